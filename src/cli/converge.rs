//! `stiffmap converge`: one machine on meshes of two or three sizes.

use super::{UsageError, at_least_one, cache_folder, position, streams};
use anyhow::Result;
use clap::Args;
use nalgebra::DMatrix;
use serde_json::json;
use std::fmt::Write as _;
use std::path::PathBuf;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, read_machine};
use stiffmap::modal::{ConvergenceError, Extrapolation, extrapolate};
use stiffmap::pipeline::{self, AtOnePosition};
use stiffmap::reduction::Cache;

/// Shapes that agree less than this at the interfaces are not taken for one mode.
const LEAST_MAC: f64 = 0.8;
/// Ranks that a mode may move from mesh to mesh.
const REACH: usize = 3;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Two or three machine files or folders: one machine on meshes of different size, in any order
    #[arg(num_args = 2..=3, required = true, value_name = "MACHINE")]
    machines: Vec<PathBuf>,
    /// Position in m; the first of the travel without it
    #[arg(long, allow_hyphen_values = true, value_name = "Z")]
    position: Option<f64>,
    /// Elastic modes
    #[arg(long, default_value_t = 10, value_name = "N")]
    modes: usize,
    /// Order of convergence that two meshes go by (three show their own)
    #[arg(long, default_value_t = 2.0, value_name = "P")]
    order: f64,
    /// Print the figures as JSON
    #[arg(long)]
    json: bool,
}

/// A mode of the finest mesh, its frequencies from coarse to fine, and what follows from them.
struct Row {
    frequencies: Vec<f64>,
    estimate: Result<Extrapolation, String>,
}

/// Prints for each mode the order, the limit and how far the finest mesh is from it.
pub fn converge(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    if !(0.3..=8.0).contains(&arguments.order) {
        return Err(UsageError(format!("--order: {} is not between 0.3 and 8", arguments.order)).into());
    }
    let modes = at_least_one(arguments.modes)?;
    let machines = arguments.machines.iter().map(|p| read_machine(p)).collect::<Result<Vec<Machine>, _>>()?;
    for machine in &machines[1..] {
        same_machine(&machines[0], machine)?;
    }
    let position = position(&machines[0], arguments.position)?;
    let cache = cache_folder().map(Cache::in_folder);
    let solved = machines.iter().map(|machine| {
        let meshes = pipeline::read_meshes(machine)?;
        // Modes beyond the wanted ones, to which a rank may move.
        pipeline::at_position(machine, &meshes, cache.as_ref(), position, modes + REACH, interrupt)
    });
    let mut solved = solved.collect::<Result<Vec<AtOnePosition>, _>>()?;
    solved.sort_by_key(|s| s.n_dof);
    if let Some(pair) = solved.windows(2).find(|w| w[0].n_dof == w[1].n_dof) {
        return Err(UsageError(format!(
            "two of the machines have {} unknowns each; give meshes of different size",
            pair[0].n_dof
        ))
        .into());
    }
    let sizes: Vec<f64> = solved.iter().map(|s| (s.n_dof as f64).powf(-1.0 / 3.0)).collect();
    let Some(fine) = solved.last() else { return Ok(()) };
    let count = modes.min(fine.motions.ncols());
    let rows: Vec<Row> = (0..count).map(|rank| row(&solved, &sizes, rank, arguments.order)).collect();
    if arguments.json {
        let of_row = |(rank, row): (usize, &Row)| match &row.estimate {
            Ok(e) => {
                json!({ "rank": rank + 1, "hz": row.frequencies, "order": e.order, "limit_hz": e.limit, "error": e.error })
            }
            Err(reason) => json!({ "rank": rank + 1, "hz": row.frequencies, "refused": reason }),
        };
        let unknowns: Vec<usize> = solved.iter().map(|s| s.n_dof).collect();
        let all = json!({
            "position_m": position,
            "unknowns": unknowns,
            "order_assumed": (solved.len() == 2).then_some(arguments.order),
            "elastic_modes": rows.iter().enumerate().map(of_row).collect::<Vec<_>>(),
        });
        streams::print_json(&all)?;
        return Ok(());
    }
    let text = table(&machines[0], position, &solved, &rows, arguments.order)?;
    Ok(streams::print(&text)?)
}

fn table(machine: &Machine, position: f64, solved: &[AtOnePosition], rows: &[Row], assumed: f64) -> Result<String> {
    let mut text = String::new();
    writeln!(
        text,
        "{} at {} = {position} m: elastic frequencies in Hz, coarse to fine",
        machine.name, machine.axis.name
    )?;
    let heads: String = solved.iter().map(|s| format!("{:>11} dof", s.n_dof)).collect();
    writeln!(text, "rank{heads}   order      limit Hz   finest above limit by %")?;
    for (rank, row) in rows.iter().enumerate() {
        let own: String = row.frequencies.iter().map(|f| format!("{f:15.5}")).collect();
        match &row.estimate {
            Ok(e) => {
                let order = e.order.map_or_else(|| "-".into(), |p| format!("{p:.2}"));
                writeln!(text, "{:4}{own}   {order:>5}  {:12.5}   {:10.5}", rank + 1, e.limit, 100.0 * e.error)?;
            }
            Err(reason) => writeln!(text, "{:4}{own}   no estimate: {reason}", rank + 1)?,
        }
    }
    if solved.len() == 2 {
        writeln!(text, "Order {assumed} is assumed; a third mesh would show it.")?;
    }
    Ok(text)
}

/// The finest mesh's mode of a rank with its likes on the coarser ones.
fn row(solved: &[AtOnePosition], sizes: &[f64], rank: usize, assumed: f64) -> Row {
    let fine = &solved[solved.len() - 1];
    let mut frequencies = Vec::new();
    let mut unlike = None;
    for one in solved {
        let near = rank.saturating_sub(REACH)..(rank + REACH + 1).min(one.motions.ncols());
        let best = near.map(|r| (r, mac(&fine.motions, rank, &one.motions, r))).max_by(|a, b| a.1.total_cmp(&b.1));
        let (like, agreement) = best.unwrap_or((rank, 0.0));
        if agreement < LEAST_MAC {
            unlike =
                Some(format!("no mode of the mesh with {} unknowns has its shape (MAC {agreement:.2})", one.n_dof));
        }
        frequencies.push(one.modes.frequency(one.modes.free + like));
    }
    let estimate = unlike.map_or_else(
        || {
            let pairs: Vec<(f64, f64)> = sizes.iter().copied().zip(frequencies.iter().copied()).collect();
            extrapolate(&pairs, assumed).map_err(|e: ConvergenceError| e.to_string())
        },
        Err,
    );
    Row { frequencies, estimate }
}

/// Modal assurance criterion of the interfaces' translations.
fn mac(a: &DMatrix<f64>, i: usize, b: &DMatrix<f64>, j: usize) -> f64 {
    let translations = |m: &DMatrix<f64>, k: usize| -> Vec<f64> {
        m.column(k).iter().enumerate().filter(|(row, _)| row % 6 < 3).map(|(_, v)| *v).collect()
    };
    let (x, y) = (translations(a, i), translations(b, j));
    let dot = |u: &[f64], v: &[f64]| u.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
    dot(&x, &y).powi(2) / (dot(&x, &x) * dot(&y, &y)).max(f64::MIN_POSITIVE)
}

/// Refuses two machines that differ by more than their meshes.
fn same_machine(a: &Machine, b: &Machine) -> Result<(), UsageError> {
    let names = |m: &Machine| -> Vec<String> {
        m.parts.iter().flat_map(|p| p.interfaces.iter().map(|i| format!("{}.{}", p.name, i.name))).collect()
    };
    if names(a) == names(b) && a.joints.len() == b.joints.len() {
        return Ok(());
    }
    let (a, b) = (a.file.display(), b.file.display());
    Err(UsageError(format!("{a} and {b} have different parts, interfaces or joints; give one machine on other meshes")))
}
