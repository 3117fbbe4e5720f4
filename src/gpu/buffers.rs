//! Device buffers of one tile in flight: growable, checked against the limits before they are made.

use std::sync::mpsc::{Receiver, channel};

use super::kernels::Pipeline;
use super::{Gpu, GpuError};

/// A buffer that grows when more is asked of it.
#[derive(Debug)]
struct Growable {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: Option<wgpu::Buffer>,
}

impl Growable {
    fn new(label: &'static str, usage: wgpu::BufferUsages) -> Growable {
        Growable { label, usage, buffer: None }
    }

    /// The buffer with at least `size` bytes.
    fn hold(&mut self, gpu: &Gpu, size: u64) -> Result<&wgpu::Buffer, GpuError> {
        let size = size.next_multiple_of(16).max(64);
        if size > gpu.max_binding() {
            let adapter = gpu.adapter().name.clone();
            return Err(GpuError::TooLarge { adapter, what: self.label, needed: size, allowed: gpu.max_binding() });
        }
        let held = self.buffer.take().filter(|buffer| buffer.size() >= size);
        let buffer = match held {
            Some(buffer) => buffer,
            None => gpu.scoped("making a buffer", || {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(self.label),
                    size,
                    usage: self.usage,
                    mapped_at_creation: false,
                })
            })?,
        };
        Ok(self.buffer.insert(buffer))
    }
}

/// What a kernel reads for a tile: its uniform and the arrays of group 0 in the order of their bindings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inputs<'a> {
    pub uniform: &'a [u8],
    pub arrays: [&'a [u8]; 3],
}

/// The buffers of one tile in flight. Two of them let one tile's read-back overlap the next tile's sums.
#[derive(Debug)]
pub struct Buffers {
    params: Growable,
    /// The read-only arrays: frequencies, modes and residual, or receptances, changes and pairs.
    arrays: [Growable; 3],
    output: Growable,
    staging: Growable,
}

/// A tile that the device works on.
#[derive(Debug)]
pub(super) struct InFlight {
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
    bytes: u64,
}

impl Buffers {
    /// No memory yet; each buffer is made at the first tile and grows with the largest.
    #[expect(clippy::new_without_default, reason = "an empty set of buffers is no value to default to")]
    pub fn new() -> Buffers {
        use wgpu::BufferUsages as Usage;
        let read = Usage::STORAGE | Usage::COPY_DST;
        Buffers {
            params: Growable::new("params", Usage::UNIFORM | Usage::COPY_DST),
            arrays: ["array 1", "array 2", "array 3"].map(|label| Growable::new(label, read)),
            output: Growable::new("output", Usage::STORAGE | Usage::COPY_SRC),
            staging: Growable::new("staging", Usage::MAP_READ | Usage::COPY_DST),
        }
    }

    /// Uploads a tile, starts the kernel and asks for its output of `bytes` bytes.
    pub(super) fn submit(
        &mut self,
        gpu: &Gpu,
        pipeline: &Pipeline,
        inputs: Inputs<'_>,
        workgroups: [u32; 3],
        bytes: u64,
    ) -> Result<InFlight, GpuError> {
        let params = self.params.hold(gpu, inputs.uniform.len() as u64)?;
        let [first, second, third] = &mut self.arrays;
        let arrays = [
            first.hold(gpu, inputs.arrays[0].len() as u64)?,
            second.hold(gpu, inputs.arrays[1].len() as u64)?,
            third.hold(gpu, inputs.arrays[2].len() as u64)?,
        ];
        let output = self.output.hold(gpu, bytes)?;
        let staging = self.staging.hold(gpu, bytes)?;
        let (send, mapped) = channel();
        let submission = gpu.scoped("starting a kernel", || {
            gpu.queue.write_buffer(params, 0, inputs.uniform);
            for (buffer, bytes) in arrays.iter().zip(inputs.arrays) {
                gpu.queue.write_buffer(buffer, 0, bytes);
            }
            let model = bind(gpu, "model", &pipeline.model, &[params, arrays[0], arrays[1], arrays[2]]);
            let written = bind(gpu, "output", &pipeline.output, &[output]);
            let mut encoder =
                gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("tile") });
            {
                let descriptor = wgpu::ComputePassDescriptor { label: Some("tile"), timestamp_writes: None };
                let mut pass = encoder.begin_compute_pass(&descriptor);
                pass.set_pipeline(&pipeline.pipeline);
                pass.set_bind_group(0, &model, &[]);
                pass.set_bind_group(1, &written, &[]);
                pass.dispatch_workgroups(workgroups[0], workgroups[1], workgroups[2]);
            }
            encoder.copy_buffer_to_buffer(output, 0, staging, 0, bytes);
            let submission = gpu.queue.submit([encoder.finish()]);
            staging.map_async(wgpu::MapMode::Read, 0..bytes, move |result| {
                // The receiver is gone only where the tile was given up.
                let _ = send.send(result);
            });
            submission
        })?;
        Ok(InFlight { submission, mapped, bytes })
    }

    /// Waits for a tile and reads its output.
    pub(super) fn read<T>(
        &self,
        gpu: &Gpu,
        tile: InFlight,
        read: impl FnOnce(&[u8]) -> Result<T, GpuError>,
    ) -> Result<T, GpuError> {
        gpu.wait(tile.submission)?;
        let refused = |message: String| GpuError::Validation {
            adapter: gpu.adapter().name.clone(),
            doing: "reading a tile back",
            message,
        };
        match tile.mapped.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(refused(e.to_string())),
            Err(e) => return Err(refused(e.to_string())),
        }
        let staging = self.staging.buffer.as_ref().ok_or_else(|| refused("no staging buffer".to_string()))?;
        let result = {
            let view = staging.get_mapped_range(0..tile.bytes).map_err(|e| refused(e.to_string()))?;
            read(&view)
        };
        staging.unmap();
        result
    }
}

fn bind(gpu: &Gpu, label: &str, layout: &wgpu::BindGroupLayout, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(buffers)
        .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
