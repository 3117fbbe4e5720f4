//! What can go wrong on a device.

use crate::frf::FrfError;

/// Why a device did not deliver.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter answers.
    #[error(
        "no GPU adapter was found{}; install a Vulkan, Metal or DX12 driver, or use --backend cpu",
        wanted.as_ref().map(|w| format!(" that matches STIFFMAP_ADAPTER={w:?}")).unwrap_or_default()
    )]
    NoAdapter {
        /// What the environment asked for.
        wanted: Option<String>,
    },
    /// Only an adapter that runs on the processor answers, and speed was asked for.
    #[error("the only adapter, {name}, runs on the processor itself, whose own path is faster")]
    SoftwareOnly {
        /// Its name.
        name: String,
    },
    /// The adapter gave no device.
    #[error("adapter {adapter} gave no device: {message}")]
    NoDevice {
        /// Adapter.
        adapter: String,
        /// What it said.
        message: String,
    },
    /// The device went away during the work.
    #[error("the device {adapter} was lost: {message}")]
    DeviceLost {
        /// Adapter.
        adapter: String,
        /// What the driver said.
        message: String,
    },
    /// The device has not enough memory.
    #[error("the device {adapter} ran out of memory while {doing}")]
    OutOfMemory {
        /// Adapter.
        adapter: String,
        /// What was being done.
        doing: &'static str,
    },
    /// The device refused what it was given: an error of this program.
    #[error("the device {adapter} refused {doing}: {message}")]
    Validation {
        /// Adapter.
        adapter: String,
        /// What was being done.
        doing: &'static str,
        /// What it said.
        message: String,
    },
    /// The device did not answer in time.
    #[error("the device {adapter} did not finish a tile within {seconds} s")]
    Timeout {
        /// Adapter.
        adapter: String,
        /// Seconds waited.
        seconds: u64,
    },
    /// The adapter has no f64 in shaders.
    #[error("adapter {adapter} has no f64 in shaders; use --precision f32 or --backend cpu")]
    NoF64 {
        /// Adapter.
        adapter: String,
    },
    /// The kernels that change springs have no room for so many.
    #[error("{springs} springs and {ports} ports vary; the device's kernel takes {allowed} in all; use --backend cpu")]
    TooManyRows {
        /// Springs.
        springs: usize,
        /// Ports.
        ports: usize,
        /// Springs and ports allowed.
        allowed: usize,
    },
    /// One position's model does not fit a buffer of the device.
    #[error("{what} needs {needed} bytes a position; the device {adapter} allows {allowed}")]
    TooLarge {
        /// Adapter.
        adapter: String,
        /// Which buffer.
        what: &'static str,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
    },
    /// The device returned a value that is not finite: the request leaves the range of f32.
    #[error(
        "the device {adapter} returned a value that is not finite at position {position}, frequency {frequency}; use --precision f64 or --backend cpu"
    )]
    NotFinite {
        /// Adapter.
        adapter: String,
        /// Index of the position.
        position: usize,
        /// Index of the frequency.
        frequency: usize,
    },
    /// The device's numbers are not what its precision allows.
    #[error("the device {adapter} failed its accuracy check: {figure:.2e} {what}, allowed {bound:.2e}; it is not used")]
    Inaccurate {
        /// Adapter.
        adapter: String,
        /// Which figure.
        what: &'static str,
        /// Value seen.
        figure: f64,
        /// Value allowed.
        bound: f64,
    },
    /// The request is not usable on any back end.
    #[error(transparent)]
    Request(#[from] FrfError),
}

impl GpuError {
    /// Whether the processor can finish what the device began.
    pub fn is_of_the_device(&self) -> bool {
        !matches!(self, GpuError::Request(_))
    }
}
