//! Adapters: what is there, and which one is taken.
//!
//! `STIFFMAP_ADAPTER` picks one by its number in [`list_adapters`] or by a part of its name (`nvidia`, `llvmpipe`);
//! else the first of discrete, integrated, virtual, other, software is taken.

use serde::{Deserialize, Serialize};

use super::GpuError;

/// The environment variable that picks an adapter.
pub const ADAPTER_VARIABLE: &str = "STIFFMAP_ADAPTER";

/// An adapter, as `stiffmap devices` lists it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AdapterSummary {
    /// Name.
    pub name: String,
    /// `vulkan`, `metal` or `dx12`.
    pub backend: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    pub kind: String,
    /// Driver and its version.
    pub driver: String,
    /// Whether shaders have f64.
    pub f64: bool,
    /// Largest storage binding, bytes.
    pub max_storage_binding: u64,
    /// Largest buffer, bytes.
    pub max_buffer: u64,
    /// Most workgroups a dimension.
    pub max_workgroups: u32,
    /// Most invocations a workgroup.
    pub max_invocations: u32,
}

impl AdapterSummary {
    pub(super) fn of(adapter: &wgpu::Adapter) -> AdapterSummary {
        let (info, limits) = (adapter.get_info(), adapter.limits());
        let kind = match info.device_type {
            wgpu::DeviceType::DiscreteGpu => "discrete",
            wgpu::DeviceType::IntegratedGpu => "integrated",
            wgpu::DeviceType::VirtualGpu => "virtual",
            wgpu::DeviceType::Cpu => "software",
            wgpu::DeviceType::Other => "other",
        };
        AdapterSummary {
            backend: info.backend.to_string().to_lowercase(),
            kind: kind.to_string(),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_string(),
            name: info.name,
            f64: adapter.features().contains(wgpu::Features::SHADER_F64),
            max_storage_binding: limits.max_storage_buffer_binding_size,
            max_buffer: limits.max_buffer_size,
            max_workgroups: limits.max_compute_workgroups_per_dimension,
            max_invocations: limits.max_compute_invocations_per_workgroup,
        }
    }

    /// Whether it runs on the processor.
    pub fn is_software(&self) -> bool {
        self.kind == "software"
    }

    /// What figures measured on it are kept under: adapter, back end and driver.
    pub fn key(&self) -> String {
        format!("{} | {} | {}", self.name, self.backend, self.driver)
    }
}

/// The adapters of this machine, the preferred one first; empty where there is none.
pub fn list_adapters() -> Vec<AdapterSummary> {
    adapters().iter().map(AdapterSummary::of).collect()
}

/// The adapter that is taken for the environment's wish.
pub(super) fn choose() -> Result<wgpu::Adapter, GpuError> {
    wanted().map(|mut adapters| adapters.swap_remove(0))
}

/// The adapters that the environment's wish allows, at least one: all without a wish.
pub(super) fn wanted() -> Result<Vec<wgpu::Adapter>, GpuError> {
    let allowed = |(index, adapter): &(usize, wgpu::Adapter)| is_wanted(*index, &adapter.get_info().name);
    let found: Vec<_> = adapters().into_iter().enumerate().filter(allowed).map(|(_, adapter)| adapter).collect();
    if found.is_empty() { Err(GpuError::NoAdapter { wanted: wish() }) } else { Ok(found) }
}

/// Whether the environment's wish is for this adapter, or there is no wish.
pub(super) fn is_wanted(index: usize, name: &str) -> bool {
    match wish() {
        None => true,
        Some(wanted) => match wanted.parse::<usize>() {
            Ok(wanted) => wanted == index,
            Err(_) => matches(name, &wanted),
        },
    }
}

/// What the environment asks for.
pub(super) fn wish() -> Option<String> {
    std::env::var(ADAPTER_VARIABLE).ok().filter(|w| !w.is_empty())
}

fn matches(name: &str, part: &str) -> bool {
    name.to_lowercase().contains(&part.to_lowercase())
}

fn adapters() -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let instance = wgpu::Instance::new(descriptor);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|a| match a.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}
