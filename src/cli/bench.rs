//! `stiffmap bench`: the compliance kernel measured.

use super::{UsageError, streams};
use anyhow::Result;
use clap::{Args, ValueEnum};
use std::fmt::Write as _;
use stiffmap::gpu::Backend;
use stiffmap::gpu::bench::{BenchRequest, BenchRow, measure};

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Which {
    Cpu,
    Gpu,
    All,
}

#[derive(Args, Debug)]
pub struct Arguments {
    /// What to measure
    #[arg(long, value_enum, default_value = "all")]
    backend: Which,
    /// Number of positions
    #[arg(long, default_value_t = 121)]
    positions: usize,
    /// Number of frequencies
    #[arg(long, default_value_t = 2000)]
    frequencies: usize,
    /// Number of modes
    #[arg(long, default_value_t = 30)]
    modes: usize,
    /// Runs whose median counts
    #[arg(long, default_value_t = 10)]
    repetitions: usize,
    /// Stream maps of 1, 10 and 100 times the positions: time should grow with them, memory should not
    #[arg(long)]
    growth: bool,
    /// Print a JSON list of rows
    #[arg(long)]
    json: bool,
}

/// Measures and prints.
pub fn bench(arguments: &Arguments) -> Result<()> {
    let counts = [
        ("--positions", arguments.positions),
        ("--frequencies", arguments.frequencies),
        ("--modes", arguments.modes),
        ("--repetitions", arguments.repetitions),
    ];
    if let Some((flag, _)) = counts.iter().find(|(_, n)| *n == 0) {
        return Err(UsageError(format!("{flag}: 0 is not allowed; at least 1")).into());
    }
    let request = BenchRequest {
        backend: match arguments.backend {
            Which::Cpu => Backend::Cpu,
            Which::Gpu => Backend::Gpu,
            Which::All => Backend::Auto,
        },
        positions: arguments.positions,
        frequencies: arguments.frequencies,
        modes: arguments.modes,
        repetitions: arguments.repetitions,
        streamed: arguments.growth,
        ..BenchRequest::default()
    };
    let factors: &[usize] = if arguments.growth { &[1, 10, 100] } else { &[1] };
    let mut rows = Vec::new();
    for factor in factors {
        rows.extend(measure(&BenchRequest { positions: factor * request.positions, ..request.clone() })?);
    }
    if arguments.json {
        streams::print_json(&rows)?;
    } else {
        streams::print(&table(&request, &rows)?)?;
    }
    Ok(())
}

fn table(request: &BenchRequest, rows: &[BenchRow]) -> Result<String> {
    let mut text = String::new();
    writeln!(
        text,
        "{}{} positions x {} frequencies x {} modes x {} values, median of {}\n",
        if request.streamed { "streamed: 1, 10 and 100 times " } else { "" },
        request.positions,
        request.frequencies,
        request.modes,
        request.ports * request.ports,
        request.repetitions
    )?;
    writeln!(
        text,
        "back end  precision  positions        ms  Mpairs/s  Mvalues/s  Gflop/s    GB/s  roofline  peak MB  device"
    )?;
    for row in rows {
        let share = row.roofline_share.map_or_else(|| "      -".into(), |s| format!("{:6.0}%", 100.0 * s));
        let memory = row.peak_rss_bytes.map_or_else(|| "      -".into(), |b| format!("{:7.0}", b as f64 * 1e-6));
        writeln!(
            text,
            "{:<9} {:<9} {:10} {:9.2} {:9.1} {:10.1} {:8.1} {:7.1}   {share}  {memory}  {}",
            row.backend,
            row.precision.name(),
            row.positions,
            row.median_seconds * 1e3,
            row.pairs_per_second * 1e-6,
            row.values_per_second * 1e-6,
            row.flops_per_second * 1e-9,
            row.bytes_per_second * 1e-9,
            row.device
        )?;
    }
    Ok(text)
}
