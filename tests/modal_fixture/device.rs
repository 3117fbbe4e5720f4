//! The device of the GPU tests.

use stiffmap::gpu::{Gpu, GpuError};

/// The device, with its name on the test's output.
pub fn device() -> Option<Gpu> {
    match Gpu::open() {
        Ok(gpu) => {
            println!("adapter: {}", gpu.adapter().key());
            Some(gpu)
        }
        Err(GpuError::NoAdapter { .. }) => {
            let required = std::env::var("STIFFMAP_GPU").is_ok_and(|v| v == "require");
            assert!(!required, "STIFFMAP_GPU=require and no adapter");
            println!("skipped: no adapter");
            None
        }
        Err(e) => panic!("{e}"),
    }
}
