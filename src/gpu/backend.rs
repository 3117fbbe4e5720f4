//! Which back end answers a request, and what happens when a device fails on the way.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::frf::{self, ComplianceMap, FrfRequest, Packing, Sink, Tile};

use super::cache::{MeasuredCache, Speed};
use super::trust::{self, TrustFigures};
use super::{AdapterSummary, Gpu, GpuError, Precision, adapter, bench, modal_sum_tiles};

/// Below this estimate, in seconds on the processor, a device is not even looked for: opening one takes longer.
const WORTH_A_DEVICE: f64 = 0.1;
/// Work a second and thread that any processor reaches, before it is measured.
const MODEST_WORK_PER_SECOND: f64 = 1e9;

/// Which back end is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// By size and adapter; the processor finishes what a device cannot.
    #[default]
    Auto,
    /// The processor, f64.
    Cpu,
    /// A device, or an error.
    Gpu,
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(name: &str) -> Result<Backend, String> {
        match name {
            "auto" => Ok(Backend::Auto),
            "cpu" => Ok(Backend::Cpu),
            "gpu" => Ok(Backend::Gpu),
            _ => Err(format!("back end {name:?}: allowed are auto, cpu, gpu")),
        }
    }
}

/// How a request is to be answered.
#[derive(Clone, Debug, Default)]
pub struct BackendOptions {
    /// Back end.
    pub backend: Backend,
    /// Precision on a device; the processor always sums in f64.
    pub precision: Precision,
    /// Where measurements of adapters are kept; none are kept without it.
    pub cache_dir: Option<PathBuf>,
}

/// Who answered, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BackendReport {
    /// `cpu`, `gpu`, or `gpu, finished on the cpu`.
    pub backend: &'static str,
    /// The device's adapter, where one took part.
    pub adapter: Option<AdapterSummary>,
    /// Precision of the sums: of the device's where one took part.
    pub precision: Precision,
    /// Why this back end.
    pub why: String,
    /// The device's accuracy check.
    pub trust: Option<TrustFigures>,
    /// (position, frequency) pairs from the device.
    pub pairs_on_device: usize,
    /// (position, frequency) pairs from the processor.
    pub pairs_on_cpu: usize,
    /// Seconds for choosing, opening and computing.
    pub seconds: f64,
}

/// Computes a map on the back end that the options choose.
///
/// # Errors
/// [`GpuError::Request`] for a request that is not usable, and with [`Backend::Gpu`] whatever a device may do.
pub fn compute(request: &FrfRequest, options: &BackendOptions) -> Result<(ComplianceMap, BackendReport), GpuError> {
    request.check()?;
    let start = Instant::now();
    match choose(request, options)? {
        // Straight into the map, without tiles.
        Choice::Cpu { why } => {
            let map = frf::modal_sum(request)?;
            Ok((map, on_cpu(request, why, start)))
        }
        Choice::Gpu(gpu, chosen) => {
            let mut values = frf::zeros(request.len());
            let mut filled = 0;
            let mut sink = |tile: Tile<'_>| {
                values[filled..filled + tile.values.len()].copy_from_slice(tile.values);
                filled += tile.values.len();
                Ok(())
            };
            let report = on_gpu(&gpu, &chosen, request, options, &mut sink, start)?;
            Ok((ComplianceMap::around(request, values), report))
        }
    }
}

/// [`compute`] in tiles for maps that exceed memory: see [`frf::modal_sum_tiles`].
///
/// # Errors
/// As [`compute`], and [`frf::FrfError::Sink`] when the receiver fails.
pub fn compute_tiles(
    request: &FrfRequest,
    options: &BackendOptions,
    sink: &mut Sink,
) -> Result<BackendReport, GpuError> {
    request.check()?;
    let start = Instant::now();
    match choose(request, options)? {
        Choice::Cpu { why } => {
            frf::modal_sum_tiles(request, 0, sink)?;
            Ok(on_cpu(request, why, start))
        }
        Choice::Gpu(gpu, chosen) => on_gpu(&gpu, &chosen, request, options, sink, start),
    }
}

/// Computes on an open device what it can, and with [`Backend::Auto`] the rest on the processor.
///
/// # Errors
/// As [`compute_tiles`].
pub fn compute_tiles_on(
    gpu: &Gpu,
    request: &FrfRequest,
    options: &BackendOptions,
    sink: &mut Sink,
) -> Result<BackendReport, GpuError> {
    request.check()?;
    let start = Instant::now();
    let trust = trusted(gpu, options, &mut MeasuredCache::load(options.cache_dir.as_deref()))?;
    on_gpu(gpu, &Chosen { trust, why: "an open device".to_string() }, request, options, sink, start)
}

/// What a choice came to.
pub(super) enum Choice {
    Cpu { why: String },
    Gpu(Box<Gpu>, Chosen),
}

/// What is known of a device that was chosen.
pub(super) struct Chosen {
    trust: TrustFigures,
    /// Why it was chosen.
    pub(super) why: String,
}

/// The measure of a request: what [`Speed`] counts a second.
pub(super) fn work(request: &FrfRequest) -> f64 {
    let pairs = Packing::new(request).pairs.len() as f64;
    let triples = request.positions.len() as f64 * request.frequencies.len() as f64 * request.max_modes() as f64;
    triples * (pairs + 5.0)
}

pub(super) fn choose(request: &FrfRequest, options: &BackendOptions) -> Result<Choice, GpuError> {
    let dir = options.cache_dir.as_deref();
    if request.is_coupled() {
        // The devices' sums know modes without coupling only.
        let why = "damping of single joints or parts couples the modes, which the processor solves for";
        return Ok(Choice::Cpu { why: why.to_string() });
    }
    match options.backend {
        Backend::Cpu => Ok(Choice::Cpu { why: "asked for".to_string() }),
        Backend::Gpu => {
            let gpu = Gpu::open()?;
            let mut cache = MeasuredCache::load(dir);
            let trust = trusted(&gpu, options, &mut cache)?;
            cache.save(dir);
            Ok(Choice::Gpu(Box::new(gpu), Chosen { trust, why: "asked for".to_string() }))
        }
        Backend::Auto => Ok(choose_by_speed(request, options)),
    }
}

/// The faster back end as far as it is known; never a software adapter.
fn choose_by_speed(request: &FrfRequest, options: &BackendOptions) -> Choice {
    let (work, dir) = (work(request), options.cache_dir.as_deref());
    let modest = work / (MODEST_WORK_PER_SECOND * rayon::current_num_threads() as f64);
    if modest < WORTH_A_DEVICE {
        let why = format!("at most {:.0} ms of work on the processor: less than opening a device", 1e3 * modest);
        return Choice::Cpu { why };
    }
    let mut cache = MeasuredCache::load(dir);
    let before = cache.clone();
    let choice = choose_measured(work, options, &mut cache);
    if cache != before {
        cache.save(dir);
    }
    choice.unwrap_or_else(|e| Choice::Cpu { why: e.to_string() })
}

fn choose_measured(work: f64, options: &BackendOptions, cache: &mut MeasuredCache) -> Result<Choice, GpuError> {
    let precision = options.precision;
    let cpu = match cache.speed(None, precision) {
        Some(speed) => speed,
        None => {
            let speed = Speed { work_per_second: bench::work_per_second_on_cpu()?, open_seconds: 0.0 };
            cache.keep_speed(None, precision, speed);
            speed
        }
    };
    let cpu_seconds = work / cpu.work_per_second;
    if cpu_seconds < WORTH_A_DEVICE {
        return Ok(Choice::Cpu {
            why: format!("{:.0} ms of work on the processor: less than opening a device", 1e3 * cpu_seconds),
        });
    }
    let adapters = cache.adapters();
    let wanted = adapters.iter().enumerate().find(|(i, a)| adapter::is_wanted(*i, &a.name)).map(|(_, a)| a.clone());
    let wanted = wanted.ok_or(GpuError::NoAdapter { wanted: adapter::wish() })?;
    if wanted.is_software() {
        return Err(GpuError::SoftwareOnly { name: wanted.name });
    }
    if precision == Precision::F64 && !wanted.f64 {
        return Err(GpuError::NoF64 { adapter: wanted.name });
    }
    let slower = |speed: &Speed| work / speed.work_per_second + speed.open_seconds >= cpu_seconds;
    let compare = |speed: &Speed| {
        let gpu_seconds = work / speed.work_per_second + speed.open_seconds;
        format!("estimated {cpu_seconds:.2} s on the processor, {gpu_seconds:.2} s on {}", wanted.name)
    };
    if let Some(speed) = cache.speed(Some(&wanted), precision).filter(slower) {
        return Ok(Choice::Cpu { why: compare(&speed) });
    }
    let opening = Instant::now();
    let gpu = Gpu::open()?;
    let trust = trusted(&gpu, options, cache)?;
    let open_seconds = opening.elapsed().as_secs_f64();
    let speed = match cache.speed(Some(&wanted), precision) {
        Some(speed) => speed,
        None => {
            let speed = Speed { work_per_second: bench::work_per_second_on(&gpu, precision)?, open_seconds };
            cache.keep_speed(Some(&wanted), precision, speed);
            speed
        }
    };
    if slower(&speed) {
        return Ok(Choice::Cpu { why: compare(&speed) });
    }
    Ok(Choice::Gpu(Box::new(gpu), Chosen { trust, why: compare(&speed) }))
}

/// The figures of this adapter and driver: cached, or looked at now.
fn trusted(gpu: &Gpu, options: &BackendOptions, cache: &mut MeasuredCache) -> Result<TrustFigures, GpuError> {
    if let Some(figures) = cache.trust(gpu.adapter(), options.precision) {
        return Ok(figures.clone());
    }
    let figures = trust::check(gpu, options.precision)?;
    cache.keep_trust(gpu.adapter(), figures.clone());
    Ok(figures)
}

pub(super) fn on_cpu(request: &FrfRequest, why: String, start: Instant) -> BackendReport {
    BackendReport {
        backend: "cpu",
        adapter: None,
        precision: Precision::F64,
        why,
        trust: None,
        pairs_on_device: 0,
        pairs_on_cpu: request.positions.len() * request.frequencies.len(),
        seconds: start.elapsed().as_secs_f64(),
    }
}

pub(super) fn on_device(
    gpu: &Gpu,
    chosen: &Chosen,
    options: &BackendOptions,
    pairs_on_device: usize,
    start: Instant,
) -> BackendReport {
    BackendReport {
        backend: "gpu",
        adapter: Some(gpu.adapter().clone()),
        precision: options.precision,
        why: chosen.why.clone(),
        trust: Some(chosen.trust.clone()),
        pairs_on_device,
        pairs_on_cpu: 0,
        seconds: start.elapsed().as_secs_f64(),
    }
}

fn on_gpu(
    gpu: &Gpu,
    chosen: &Chosen,
    request: &FrfRequest,
    options: &BackendOptions,
    sink: &mut Sink,
    start: Instant,
) -> Result<BackendReport, GpuError> {
    let total = request.positions.len() * request.frequencies.len();
    let mut done = 0;
    let mut counted = |tile: Tile<'_>| {
        let pairs = tile.range.pairs();
        sink(tile)?;
        done += pairs;
        Ok(())
    };
    let result = modal_sum_tiles(gpu, request, options.precision, 0, &mut counted);
    let mut report = on_device(gpu, chosen, options, done, start);
    report.pairs_on_cpu = total - done;
    match result {
        Ok(()) => {}
        Err(e) if options.backend == Backend::Auto && e.is_of_the_device() => {
            tracing::warn!("{e}; the processor goes on from (position, frequency) pair {done} of {total}");
            frf::modal_sum_tiles(request, done, sink)?;
            report.backend = "gpu, finished on the cpu";
            report.why = format!("{}; the device failed: {e}", chosen.why);
        }
        Err(e) => return Err(e),
    }
    report.seconds = start.elapsed().as_secs_f64();
    Ok(report)
}
