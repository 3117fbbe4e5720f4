//! What was measured of adapters, kept in a file: accuracy and speed a driver, and which adapters there are.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::files::aside;

use super::trust::TrustFigures;
use super::{AdapterSummary, Precision, list_adapters};

/// Version of the file; another one is rebuilt.
const VERSION: u32 = 1;
/// Name of the file in the cache directory.
const FILE: &str = "devices.json";

/// Measured speed of a back end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// (position, frequency, mode) triples times (pairs + 5), a second.
    pub work_per_second: f64,
    /// Seconds to open the device and compile its kernels.
    pub open_seconds: f64,
}

/// The cached measurements. Losing the file loses time, never correctness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeasuredCache {
    version: u32,
    /// By [`AdapterSummary::key`] and precision.
    trust: BTreeMap<String, TrustFigures>,
    /// By [`AdapterSummary::key`] and precision, or `cpu` and the number of threads.
    speeds: BTreeMap<String, Speed>,
    /// Adapters, with the state of the drivers' manifests that they were listed in.
    adapters: Option<(String, Vec<AdapterSummary>)>,
}

impl MeasuredCache {
    /// Reads the file of a cache directory; an absent one is empty, a damaged one is reported and empty.
    pub fn load(dir: Option<&Path>) -> MeasuredCache {
        let empty = MeasuredCache { version: VERSION, ..MeasuredCache::default() };
        let Some(path) = dir.map(|d| d.join(FILE)) else {
            return empty;
        };
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return empty,
            Err(e) => {
                tracing::warn!("the device cache {} cannot be read ({e}); measuring again", path.display());
                return empty;
            }
        };
        match serde_json::from_str::<MeasuredCache>(&text) {
            Ok(cache) if cache.version == VERSION => cache,
            Ok(_) => empty,
            Err(e) => {
                tracing::warn!("the device cache {} is damaged ({e}); measuring again", path.display());
                empty
            }
        }
    }

    /// Writes the file aside and renames it; a failure is reported and costs only the next measurement.
    pub fn save(&self, dir: Option<&Path>) {
        let Some(dir) = dir else { return };
        let write = || -> std::io::Result<()> {
            std::fs::create_dir_all(dir)?;
            aside::write(&dir.join(FILE), &[&serde_json::to_vec_pretty(self)?])
        };
        if let Err(e) = write() {
            tracing::warn!("the device cache in {} cannot be written: {e}", dir.display());
        }
    }

    /// Figures of an earlier look at this adapter and driver.
    pub fn trust(&self, adapter: &AdapterSummary, precision: Precision) -> Option<&TrustFigures> {
        self.trust.get(&key(adapter, precision))
    }

    /// Keeps the figures of a look.
    pub fn keep_trust(&mut self, adapter: &AdapterSummary, figures: TrustFigures) {
        self.trust.insert(key(adapter, figures.precision), figures);
    }

    /// Measured speed of an adapter, or of the processor.
    pub fn speed(&self, adapter: Option<&AdapterSummary>, precision: Precision) -> Option<Speed> {
        self.speeds.get(&speed_key(adapter, precision)).copied()
    }

    /// Keeps a measured speed.
    pub fn keep_speed(&mut self, adapter: Option<&AdapterSummary>, precision: Precision, speed: Speed) {
        self.speeds.insert(speed_key(adapter, precision), speed);
    }

    /// The adapters: listed again only where the drivers have changed, since listing may load every driver.
    pub fn adapters(&mut self) -> Vec<AdapterSummary> {
        let state = driver_state();
        match &self.adapters {
            Some((known, adapters)) if !state.is_empty() && *known == state => adapters.clone(),
            _ => {
                let adapters = list_adapters();
                self.adapters = Some((state, adapters.clone()));
                adapters
            }
        }
    }
}

fn key(adapter: &AdapterSummary, precision: Precision) -> String {
    format!("{} | {}", adapter.key(), precision.name())
}

fn speed_key(adapter: Option<&AdapterSummary>, precision: Precision) -> String {
    match adapter {
        Some(adapter) => key(adapter, precision),
        None => format!("cpu | {} threads", rayon::current_num_threads()),
    }
}

/// What decides which Vulkan drivers the loader finds: its variables, and its manifests with their times. Empty where
/// there are no manifests to look at; then nothing is cached.
fn driver_state() -> String {
    const VARIABLES: [&str; 6] = [
        "VK_DRIVER_FILES",
        "VK_ICD_FILENAMES",
        "VK_ADD_DRIVER_FILES",
        "VK_LOADER_DRIVERS_SELECT",
        "VK_LOADER_DRIVERS_DISABLE",
        "VK_LOADER_DEVICE_SELECT",
    ];
    const DIRECTORIES: [&str; 3] = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let mut manifests: Vec<PathBuf> = DIRECTORIES
        .iter()
        .filter_map(|d| std::fs::read_dir(d).ok())
        .flat_map(|entries| entries.filter_map(Result::ok).map(|e| e.path()))
        .collect();
    manifests.sort();
    if manifests.is_empty() {
        return String::new();
    }
    let variables = VARIABLES.iter().map(|v| format!("{v}={};", std::env::var(v).unwrap_or_default()));
    let times = manifests.iter().map(|m| {
        let time = std::fs::metadata(m).and_then(|meta| meta.modified()).ok();
        let seconds = time.and_then(|t| t.duration_since(std::time::UNIX_EPOCH).ok()).map_or(0, |d| d.as_secs());
        // A graphics device appears under /dev/dri or /dev/nvidia0 with its kernel driver.
        format!("{}@{seconds};", m.display())
    });
    let devices = ["/dev/dri", "/dev/nvidia0", "/dev/dxg"].map(|d| format!("{d}={};", Path::new(d).exists()));
    variables.chain(times).chain(devices).collect()
}
