//! `stiffmap devices`: the adapters that could compute a map.

use super::streams;
use anyhow::Result;
use clap::Args;
use std::fmt::Write as _;
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
        streams::print_json(&adapters)?;
        return Ok(());
    }
    let mut text = String::new();
    if adapters.is_empty() {
        writeln!(
            text,
            "no adapter: no Vulkan, Metal or DirectX 12 driver answers; maps are computed on the processor"
        )?;
    }
    for (i, a) in adapters.iter().enumerate() {
        writeln!(text, "{i}  {} ({}, {})", a.name, a.kind, a.backend)?;
        writeln!(text, "   driver {}", a.driver)?;
        writeln!(text, "   f64 in shaders: {}", if a.f64 { "yes" } else { "no" })?;
        writeln!(
            text,
            "   storage binding {} MiB, buffer {} MiB, {} workgroups a dimension, {} invocations a workgroup",
            a.max_storage_binding >> 20,
            a.max_buffer >> 20,
            a.max_workgroups,
            a.max_invocations
        )?;
    }
    Ok(streams::print(&text)?)
}
