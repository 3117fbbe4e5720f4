//! Compute pipelines, made once a device and variant by one helper.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use super::shader::{Precision, Variant};
use super::{Gpu, GpuError};

/// A compiled kernel.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub pipeline: wgpu::ComputePipeline,
    /// Parameters and the read-only model.
    pub model: wgpu::BindGroupLayout,
    /// What the kernel writes.
    pub output: wgpu::BindGroupLayout,
}

/// The compiled kernels of a device. Lives as long as the device.
#[derive(Debug, Default)]
pub struct Kernels {
    pipelines: Mutex<HashMap<Variant, Arc<Pipeline>>>,
}

impl Kernels {
    /// No kernel yet; each is compiled when it is first asked for.
    pub fn new() -> Kernels {
        Kernels::default()
    }

    /// The pipeline of a variant.
    pub(super) fn get(&self, gpu: &Gpu, variant: Variant) -> Result<Arc<Pipeline>, GpuError> {
        if variant.precision == Precision::F64 && !gpu.supports(Precision::F64) {
            return Err(GpuError::NoF64 { adapter: gpu.adapter().name.clone() });
        }
        let mut pipelines = self.pipelines.lock().expect("no thread panics while it compiles a kernel");
        if let Some(pipeline) = pipelines.get(&variant) {
            return Ok(Arc::clone(pipeline));
        }
        let pipeline = Arc::new(gpu.scoped("compiling a kernel", || compile(gpu, variant))?);
        pipelines.insert(variant, Arc::clone(&pipeline));
        Ok(pipeline)
    }
}

/// Every kernel binds alike: group 0 the uniform and three read-only arrays, group 1 one array to write.
fn compile(gpu: &Gpu, variant: Variant) -> Pipeline {
    let name = format!("{} {}", variant.kernel.name(), variant.precision.name());
    let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
    let model = layout(
        gpu,
        &format!("{name} model"),
        &[wgpu::BufferBindingType::Uniform, storage(true), storage(true), storage(true)],
    );
    let output = layout(gpu, &format!("{name} output"), &[storage(false)]);
    let source = wgpu::ShaderSource::Wgsl(variant.source().into());
    let descriptor = wgpu::ShaderModuleDescriptor { label: Some(&name), source };
    let checks = wgpu::ShaderRuntimeChecks { force_loop_bounding: false, ..wgpu::ShaderRuntimeChecks::checked() };
    // SAFETY: the source is this crate's own; each of its loops runs to a bound that does not change in the loop.
    let module = unsafe { gpu.device.create_shader_module_trusted(descriptor, checks) };
    let pipeline_layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(&name),
        bind_group_layouts: &[Some(&model), Some(&output)],
        immediate_size: 0,
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(&name),
        layout: Some(&pipeline_layout),
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    Pipeline { pipeline, model, output }
}

fn layout(gpu: &Gpu, label: &str, types: &[wgpu::BufferBindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        })
        .collect();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
}
