//! What looks for the extrema of the coupling route: the processor, or a device.

use crate::frf::metrics::Extremum;
use crate::frf::modification::Work;
use crate::gpu::extrema::extrema;
use crate::gpu::modification::{SpringRequest, check, check_rows};
use crate::gpu::{AdapterSummary, Backend, Gpu, GpuError, Precision, list_adapters};
use serde::Serialize;
use std::sync::Mutex;
use std::time::Instant;

/// Largest |H| and smallest Re H of each design's pairs.
type Extrema = Vec<Vec<(Extremum, Extremum)>>;

/// Who answered a sweep's designs, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BackendUse {
    /// `cpu`, `gpu`, or `gpu, finished on the cpu`.
    pub backend: &'static str,
    /// The device's adapter, where one took part.
    pub adapter: Option<AdapterSummary>,
    /// Precision of the device's look; what it finds is computed again in f64.
    pub precision: Precision,
    /// Why this back end.
    pub why: String,
    /// Largest relative Frobenius difference of the device from f64 in its check.
    pub trust: Option<f64>,
    /// (design, position) pairs from the device.
    pub pairs_on_device: u64,
    /// (design, position) pairs from the processor.
    pub pairs_on_cpu: u64,
}

impl BackendUse {
    /// The processor alone.
    pub fn cpu(why: impl Into<String>) -> Self {
        Self {
            backend: "cpu",
            adapter: None,
            precision: Precision::F64,
            why: why.into(),
            trust: None,
            pairs_on_device: 0,
            pairs_on_cpu: 0,
        }
    }
}

/// The back end of the coupling route.
#[derive(Debug)]
pub struct SpringBackend {
    asked: Backend,
    gpu: Option<Gpu>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    stage: Stage,
    used: BackendUse,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The device is there, and nobody knows yet whether it is faster.
    Untimed,
    Device,
    Cpu,
}

impl SpringBackend {
    /// The processor.
    pub fn cpu(why: impl Into<String>) -> Self {
        let state = State { stage: Stage::Cpu, used: BackendUse::cpu(why) };
        Self { asked: Backend::Cpu, gpu: None, state: Mutex::new(state) }
    }

    /// The back end that is asked for. `auto` takes a device that is no software adapter and passes its check, and
    /// times it against the processor at the first batch.
    ///
    /// # Errors
    /// With [`Backend::Gpu`], [`GpuError`] of opening and checking a device.
    pub fn open(backend: Backend, precision: Precision) -> Result<Self, GpuError> {
        if backend == Backend::Cpu {
            return Ok(Self::cpu("asked for"));
        }
        let opened = match backend {
            // Drivers are asked for their names before one is opened.
            Backend::Auto if list_adapters().first().is_some_and(AdapterSummary::is_software) => {
                Err(GpuError::SoftwareOnly { name: list_adapters().swap_remove(0).name })
            }
            _ => Gpu::open().and_then(|gpu| {
                if backend == Backend::Auto && gpu.adapter().is_software() {
                    return Err(GpuError::SoftwareOnly { name: gpu.adapter().name.clone() });
                }
                Ok((check(&gpu, precision)?, gpu))
            }),
        };
        match opened {
            Ok((trust, gpu)) => Ok(Self::on(gpu, backend, precision, Some(trust))),
            Err(error) if backend == Backend::Auto => Ok(Self::cpu(error.to_string())),
            Err(error) => Err(error),
        }
    }

    /// An open device, used without a look at its speed; with [`Backend::Auto`] the processor goes on where it fails.
    pub fn with(gpu: Gpu, backend: Backend, precision: Precision) -> Self {
        let opened = Self::on(gpu, backend, precision, None);
        opened.update(|state| {
            state.stage = Stage::Device;
            state.used.why = "an open device".into();
        });
        opened
    }

    fn on(gpu: Gpu, asked: Backend, precision: Precision, trust: Option<f64>) -> Self {
        let stage = if asked == Backend::Auto { Stage::Untimed } else { Stage::Device };
        let used = BackendUse {
            backend: "gpu",
            adapter: Some(gpu.adapter().clone()),
            precision,
            trust,
            ..BackendUse::cpu("asked for")
        };
        Self { asked, gpu: Some(gpu), state: Mutex::new(State { stage, used }) }
    }

    /// Whether a device was asked for.
    pub fn is_asked_for(&self) -> bool {
        self.asked == Backend::Gpu
    }

    /// Who has answered so far.
    pub fn used(&self) -> BackendUse {
        self.update(|state| state.used.clone())
    }

    /// Gives the device up, as a driver may at any time. For tests.
    #[doc(hidden)]
    pub fn destroy(&self) {
        if let Some(gpu) = &self.gpu {
            gpu.destroy();
        }
    }

    fn update<T>(&self, with: impl FnOnce(&mut State) -> T) -> T {
        with(&mut self.state.lock().expect("no thread panics while it holds the state"))
    }

    fn stage(&self) -> Stage {
        self.update(|state| state.stage)
    }

    /// Looks whether the kernels have room for so many springs and ports; `auto` turns to the processor if not.
    ///
    /// # Errors
    /// [`GpuError::TooManyRows`].
    pub(super) fn fit(&self, springs: usize, ports: usize) -> Result<(), GpuError> {
        match check_rows(springs, ports) {
            Err(error) if self.stage() != Stage::Cpu => {
                if self.asked != Backend::Auto {
                    return Err(error);
                }
                self.update(|state| {
                    state.stage = Stage::Cpu;
                    state.used = BackendUse::cpu(error.to_string());
                });
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// Whether [`Self::time`] is still to be asked.
    pub(super) fn is_untimed(&self) -> bool {
        self.stage() == Stage::Untimed
    }

    /// Chooses the faster back end for requests like this one.
    pub(super) fn time(&self, request: &SpringRequest<'_>) {
        let (Some(gpu), Some(first)) = (&self.gpu, request.designs.first()) else { return };
        let precision = self.used().precision;
        let on_device = || -> Result<f64, GpuError> {
            // The first run compiles.
            extrema(gpu, request, precision)?;
            let start = Instant::now();
            extrema(gpu, request, precision)?;
            Ok(start.elapsed().as_secs_f64())
        };
        let start = Instant::now();
        request.base.modified(first, request.pairs, &mut Work::default());
        let each = start.elapsed().as_secs_f64() / rayon::current_num_threads() as f64;
        let (n, cpu) = (request.designs.len(), each * request.designs.len() as f64);
        let measured = on_device();
        self.update(|state| match measured {
            Ok(device) => {
                let why = format!("{n} designs at a position take {cpu:.2e} s on the processor, {device:.2e} s on it");
                if device < cpu {
                    state.stage = Stage::Device;
                    state.used.why = why;
                } else {
                    let name = state.used.adapter.as_ref().map_or("the device", |a| a.name.as_str());
                    let why = format!("{name} is slower: {why}");
                    state.stage = Stage::Cpu;
                    state.used = BackendUse::cpu(why);
                }
            }
            Err(error) => {
                state.stage = Stage::Cpu;
                state.used = BackendUse::cpu(error.to_string());
            }
        });
    }

    /// The extrema from the device; `None` where the processor is to compute them.
    ///
    /// # Errors
    /// [`GpuError`], if a device was asked for; `auto` leaves the rest to the processor.
    pub(super) fn extrema(&self, request: &SpringRequest<'_>) -> Result<Option<Extrema>, GpuError> {
        let n = request.designs.len() as u64;
        let (stage, precision) = self.update(|state| (state.stage, state.used.precision));
        let found = match (&self.gpu, stage) {
            (Some(gpu), Stage::Device) => extrema(gpu, request, precision),
            _ => {
                self.update(|state| state.used.pairs_on_cpu += n);
                return Ok(None);
            }
        };
        self.update(|state| match found {
            Ok(found) => {
                state.used.pairs_on_device += n;
                Ok(Some(found))
            }
            Err(error) if self.asked == Backend::Auto && error.is_of_the_device() => {
                if state.stage == Stage::Device {
                    tracing::warn!("{error}; the processor goes on");
                    state.stage = Stage::Cpu;
                    state.used.backend = "gpu, finished on the cpu";
                    state.used.why = format!("{}; the device failed: {error}", state.used.why);
                }
                state.used.pairs_on_cpu += n;
                Ok(None)
            }
            Err(error) => Err(error),
        })
    }
}
