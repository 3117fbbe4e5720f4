//! The modal sum and the change of springs on any device that WebGPU reaches, in WGSL through wgpu.
//!
//! Four objects with four lifetimes: [`Gpu`], the open device; [`Kernels`], its compiled pipelines; [`Buffers`], the
//! memory of a tile in flight; [`Params`], a tile's numbers. The request is [`crate::frf::FrfRequest`], the same as on the
//! processor. [`compute`] chooses between both and says why; [`trust`] looks at a device's numbers before they are used.
//!
//! In f32 each frequency is given as hi + lo, and (f_r - f) is formed from both parts, guarded against reassociation:
//! the error of a plain f32 difference is 1e-7 / zeta, that of this one does not depend on the damping.

mod adapter;
pub mod backend;
pub mod bench;
mod buffers;
mod cache;
mod device;
mod error;
pub mod extrema;
mod kernels;
pub mod metrics;
mod modal_sum;
mod model;
pub mod modification;
pub mod shader;
pub mod trust;
pub mod twin;

pub use adapter::{ADAPTER_VARIABLE, AdapterSummary, list_adapters};
pub use backend::{Backend, BackendOptions, BackendReport, compute, compute_tiles};
pub use buffers::Buffers;
pub use cache::MeasuredCache;
pub use device::Gpu;
pub use error::GpuError;
pub use kernels::Kernels;
pub use metrics::compute_metrics;
pub use modal_sum::{modal_sum, modal_sum_tiles, modal_sum_without_low_parts, shader_inputs};
pub use shader::{Params, Precision};
