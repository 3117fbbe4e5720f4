//! The device: one adapter, opened, with its errors caught.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::adapter::{self, AdapterSummary};
use super::{Buffers, GpuError, Kernels, Precision};

/// Seconds that a tile may take.
const PATIENCE: u64 = 120;

/// An open device. Lives as long as the program works with it; [`super::Kernels`] and buffers come from it.
#[derive(Debug)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    summary: AdapterSummary,
    limits: wgpu::Limits,
    kernels: Kernels,
    /// Buffers of finished work, for the next.
    spare: Mutex<Vec<Buffers>>,
    /// The first thing that the driver reported outside any scope: loss of the device or an error.
    fault: Arc<Mutex<Option<Fault>>>,
}

#[derive(Clone, Debug)]
enum Fault {
    Lost(String),
    Error(String),
}

impl Gpu {
    /// Opens the adapter that `STIFFMAP_ADAPTER` names, else the best one; a software adapter where it is the only one.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoDevice`].
    pub fn open() -> Result<Gpu, GpuError> {
        Gpu::from_adapter(&adapter::choose()?)
    }

    /// Opens every adapter, the preferred one first; only the one that `STIFFMAP_ADAPTER` names, if it names one.
    ///
    /// # Errors
    /// As [`Gpu::open`].
    pub fn open_each() -> Result<Vec<Gpu>, GpuError> {
        adapter::wanted()?.iter().map(Gpu::from_adapter).collect()
    }

    fn from_adapter(adapter: &wgpu::Adapter) -> Result<Gpu, GpuError> {
        let summary = AdapterSummary::of(adapter);
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("stiffmap"),
            required_features: adapter.features() & wgpu::Features::SHADER_F64,
            required_limits: limits.clone(),
            ..wgpu::DeviceDescriptor::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| GpuError::NoDevice { adapter: summary.name.clone(), message: e.to_string() })?;
        let fault = Arc::new(Mutex::new(None));
        let lost = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            record(&lost, Fault::Lost(format!("{reason:?}: {message}")));
        });
        let error = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| record(&error, Fault::Error(e.to_string()))));
        let (kernels, spare) = (Kernels::new(), Mutex::default());
        Ok(Gpu { device, queue, summary, limits, kernels, spare, fault })
    }

    /// The adapter.
    pub fn adapter(&self) -> &AdapterSummary {
        &self.summary
    }

    /// Whether shaders can compute in this precision.
    pub fn supports(&self, precision: Precision) -> bool {
        precision == Precision::F32 || self.summary.f64
    }

    /// Largest buffer that a shader can be given, bytes.
    pub(super) fn max_binding(&self) -> u64 {
        self.limits.max_storage_buffer_binding_size.min(self.limits.max_buffer_size)
    }

    /// Most workgroups a dimension.
    pub(super) fn max_workgroups(&self) -> usize {
        self.limits.max_compute_workgroups_per_dimension as usize
    }

    /// The compiled kernels.
    pub(super) fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// Buffers for two tiles in flight.
    pub(super) fn buffers(&self) -> [Buffers; 2] {
        let mut spare = self.spare.lock().expect("no thread panics while it holds spare buffers");
        [(); 2].map(|()| spare.pop().unwrap_or_else(Buffers::new))
    }

    /// Keeps buffers whose work is done for the next.
    pub(super) fn keep(&self, buffers: [Buffers; 2]) {
        self.spare.lock().expect("no thread panics while it holds spare buffers").extend(buffers);
    }

    /// Gives the device up. What is asked of it afterwards fails with [`GpuError::DeviceLost`].
    pub fn destroy(&self) {
        self.device.destroy();
    }

    /// Runs commands inside error scopes and turns what they catch into an error.
    pub(super) fn scoped<T>(&self, doing: &'static str, commands: impl FnOnce() -> T) -> Result<T, GpuError> {
        let filters = [wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::OutOfMemory];
        let scopes = filters.map(|filter| self.device.push_error_scope(filter));
        let result = commands();
        let mut caught = None;
        for scope in scopes.into_iter().rev() {
            caught = pollster::block_on(scope.pop()).or(caught);
        }
        // A lost device also fails validation; its loss is the cause, and that of an idle one is told at a poll.
        if caught.is_some() {
            self.device.poll(wgpu::PollType::Poll).ok();
        }
        self.check(doing)?;
        let adapter = self.summary.name.clone();
        match caught {
            None => Ok(result),
            Some(wgpu::Error::OutOfMemory { .. }) => Err(GpuError::OutOfMemory { adapter, doing }),
            Some(wgpu::Error::Validation { description, .. } | wgpu::Error::Internal { description, .. }) => {
                Err(GpuError::Validation { adapter, doing, message: description })
            }
        }
    }

    /// Fails if the driver has reported a loss or an error.
    pub(super) fn check(&self, doing: &'static str) -> Result<(), GpuError> {
        let adapter = self.summary.name.clone();
        match self.fault.lock().expect("no thread panics while it records a fault").clone() {
            None => Ok(()),
            Some(Fault::Lost(message)) => Err(GpuError::DeviceLost { adapter, message }),
            Some(Fault::Error(message)) => Err(GpuError::Validation { adapter, doing, message }),
        }
    }

    /// Waits until a submission is done and its callbacks have run.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        let adapter = self.summary.name.clone();
        let timeout = Some(Duration::from_secs(PATIENCE));
        let poll = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout });
        self.check("waiting for the device")?;
        match poll {
            Ok(_) => Ok(()),
            Err(wgpu::PollError::Timeout) => Err(GpuError::Timeout { adapter, seconds: PATIENCE }),
            Err(e) => Err(GpuError::Validation { adapter, doing: "waiting for the device", message: e.to_string() }),
        }
    }
}

/// Keeps the first fault; a loss replaces an error, for it is the cause of most.
fn record(fault: &Mutex<Option<Fault>>, new: Fault) {
    let mut held = fault.lock().expect("no thread panics while it records a fault");
    if matches!((&*held, &new), (None, _) | (Some(Fault::Error(_)), Fault::Lost(_))) {
        *held = Some(new);
    }
}
