//! `stiffmap devices`: the adapters that could compute a map.

use anyhow::Result;
use clap::Args;
use stiffmap::gpu::list_adapters;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Print a JSON list
    #[arg(long)]
    json: bool,
}

/// Lists the adapters; none is a finding, not an error.
pub fn devices(arguments: &Arguments) -> Result<()> {
    let adapters = list_adapters();
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&adapters)?);
        return Ok(());
    }
    if adapters.is_empty() {
        println!("no adapter: no Vulkan, Metal or DirectX 12 driver answers; maps are computed on the processor");
    }
    for (i, a) in adapters.iter().enumerate() {
        println!("{i}  {} ({}, {})", a.name, a.kind, a.backend);
        println!("   driver {}", a.driver);
        println!("   f64 in shaders: {}", if a.f64 { "yes" } else { "no" });
        println!(
            "   storage binding {} MiB, buffer {} MiB, {} workgroups a dimension, {} invocations a workgroup",
            a.max_storage_binding >> 20,
            a.max_buffer >> 20,
            a.max_workgroups,
            a.max_invocations
        );
    }
    Ok(())
}
