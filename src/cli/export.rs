//! `stiffmap export`: the assembled machine at a position, for another program.

use super::{
    UsageError, at_least_one, begin, cache_folder, finish, machine_path, open_folder, position, record, streams,
};
use anyhow::Result;
use clap::{Args, ValueEnum};
use nalgebra::DMatrix;
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::coupling::{Unreduced, assembled, assembled_bytes};
use stiffmap::export::deck::{element_differences, write_deck};
use stiffmap::export::manifest::Manifest;
use stiffmap::export::matrix_market::{DofRow, write_dense, write_dofs, write_sets, write_sparse};
use stiffmap::files::MANIFEST;
use stiffmap::interrupt::Interrupt;
use stiffmap::machine::{Machine, Part, Region, SurfaceCoupling, read_machine};
use stiffmap::matrix::GivenNodes;
use stiffmap::mesh::{Mesh, MeshFile};
use stiffmap::pipeline::{self, PipelineError};
use stiffmap::reduction::{Cache, Superelement, admit_assemblies, admit_assembly};
use stiffmap::resources::{admit, room};
use stiffmap::solid::{SecondOrder, assemble, interface_motions};

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
    /// inp: one CalculiX deck; mtx: Matrix Market files
    #[arg(long, value_name = "inp|mtx")]
    format: Format,
    /// Position in m; the first of the travel without it
    #[arg(long, allow_hyphen_values = true, value_name = "Z")]
    position: Option<f64>,
    /// Frequencies that the deck asks for
    #[arg(long, default_value_t = 30, value_name = "N")]
    modes: usize,
    /// mtx: the unreduced machine in place of the reduced one
    #[arg(long)]
    full: bool,
    /// mtx: one part alone, unreduced, in the form that a machine file's `matrices` reads
    #[arg(long, value_name = "NAME", conflicts_with_all = ["full", "position"])]
    part: Option<String>,
    /// File to write (inp), or folder (mtx)
    #[arg(long, value_name = "FILE|DIR")]
    out: PathBuf,
}

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// One CalculiX deck.
    Inp,
    /// Matrix Market files.
    Mtx,
}

/// Writes the machine in the format asked for.
pub fn export(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let (path, _bundled) = machine_path(arguments.machine.as_deref())?;
    let machine = read_machine(&path)?;
    let position = position(&machine, arguments.position)?;
    let modes = at_least_one(arguments.modes)?;
    if arguments.format == Format::Inp && (arguments.full || arguments.part.is_some()) {
        return Err(UsageError("--full and --part go with --format mtx; a deck holds the whole machine".into()).into());
    }
    let files = pipeline::read_meshes(&machine)?;
    let out = &arguments.out;
    if let Some(name) = &arguments.part {
        let names = || machine.parts.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
        let part = machine.parts.iter().position(|p| p.name == *name);
        let part = part.ok_or_else(|| UsageError(format!("--part: no part \"{name}\"; there are {}", names())))?;
        into_folder(arguments, &machine, &files, json!({ "part": name }), interrupt, |out, begin| {
            write_part(out, begin, &machine.parts[part], &files[part].mesh)
        })?;
        streams::say(&format!("wrote {name} to {}", out.display()));
        return Ok(());
    }
    let springs = pipeline::unreduced_springs(&machine, &files, position)?;
    match arguments.format {
        Format::Inp => {
            let meshes: Vec<&Mesh> = files.iter().map(|f| &f.mesh).collect();
            write_deck(out, &machine, &meshes, &springs, modes)?;
            for difference in element_differences(&machine, &meshes) {
                streams::say(&format!("warning: {difference}"));
            }
        }
        Format::Mtx => {
            let settings = json!({ "position_m": position, "full": arguments.full });
            into_folder(arguments, &machine, &files, settings, interrupt, |out, begin| match arguments.full {
                true => write_full(out, begin, &machine, &files, &springs),
                false => write_reduced(out, begin, &machine, &files, position, interrupt),
            })?;
        }
    }
    streams::say(&format!("wrote {} at {} = {position} m to {}", machine.name, machine.axis.name, out.display()));
    Ok(())
}

/// What is called before the first file is written, once all is computed: the old result then goes.
type Begin<'a> = &'a mut dyn FnMut() -> Result<()>;

/// Writes matrices into a folder that belongs to this job meanwhile, and the manifest last: without it a folder may hold
/// the stiffness of one machine and the mass of another.
fn into_folder(
    arguments: &Arguments,
    machine: &Machine,
    files: &[MeshFile],
    settings: serde_json::Value,
    interrupt: &Interrupt,
    write: impl FnOnce(&Path, Begin<'_>) -> Result<Vec<&'static str>>,
) -> Result<()> {
    let out = &arguments.out;
    let mut folder = open_folder(out, "export")?;
    let written = write(out, &mut || begin(&mut folder, &[], interrupt))?;
    let named = arguments.machine.as_ref().map_or_else(|| "bundled vertical mill".into(), |p| p.display().to_string());
    let mut manifest = Manifest {
        name: machine.name.clone(),
        command: "export".into(),
        machine_file: named,
        files: written.into_iter().chain([MANIFEST]).map(str::to_owned).collect(),
        ..Manifest::default()
    };
    record::input(&mut manifest, machine, &pipeline::inputs(machine, files)?);
    manifest.settings.push("format", json!("mtx"));
    manifest.settings.push("exported", settings);
    manifest.warnings.iter().for_each(|warning| streams::say(&format!("warning: {warning}")));
    finish(folder, &manifest)
}

/// Stiffness, mass, degrees of freedom and the interfaces' weighted nodes of one part.
fn write_part(out: &Path, begin: Begin<'_>, part: &Part, mesh: &Mesh) -> Result<Vec<&'static str>> {
    let mut part = part.clone();
    // A rigid interface has no rows of its own nodes left; whoever reads the matrices couples it.
    part.interfaces.iter_mut().for_each(|i| i.coupling = SurfaceCoupling::Distributing);
    admit_assembly(&part.name, mesh)?;
    let system = assemble(&part, mesh).map_err(PipelineError::from)?;
    let label = |(node, direction): (usize, usize)| (mesh.node_labels[node], direction, mesh.nodes[node]);
    let rows: Vec<DofRow> = system.node_of_unknown().into_iter().map(|node| node.map(label)).collect();
    let free = |node: usize| (0..3).any(|axis| !system.unknowns_of(node, axis).is_empty());
    let surfaces = interface_motions(&part, mesh).map_err(PipelineError::from)?;
    let everywhere = Region { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
    let sets = part.interfaces.iter().zip(&surfaces).enumerate().map(|(i, (interface, (surface, _)))| {
        let region = interface.within.as_ref().unwrap_or(&everywhere);
        let weights = match mesh.matrices.as_ref().map(|m| &m.interfaces[i]) {
            Some(GivenNodes::Weighted(weights)) => weights.clone(),
            Some(GivenNodes::Point(node)) => vec![(*node, 1.0)],
            Some(GivenNodes::Faces) | None => surface.weights_within(region),
        };
        if let Some((node, _)) = weights.iter().find(|(node, _)| !free(*node)) {
            let node = mesh.node_labels[*node];
            return Err(UsageError(format!(
                "--part: interface \"{}\" touches the clamped node {node}",
                interface.name
            )));
        }
        Ok((interface.name.clone(), weights.iter().map(|(node, w)| (mesh.node_labels[*node], *w)).collect()))
    });
    let sets = sets.collect::<Result<Vec<_>, _>>()?;
    begin()?;
    write_sparse(&out.join("stiffness.mtx"), &system.stiffness)?;
    write_sparse(&out.join("mass.mtx"), &system.mass)?;
    write_dofs(&out.join("dofs.csv"), &rows)?;
    write_sets(&out.join("sets.csv"), &sets)?;
    Ok(vec!["stiffness.mtx", "mass.mtx", "dofs.csv", "sets.csv"])
}

/// Stiffness and mass of the unreduced machine, parts side by side; nodes are numbered through.
fn write_full(
    out: &Path,
    begin: Begin<'_>,
    machine: &Machine,
    files: &[MeshFile],
    springs: &Unreduced,
) -> Result<Vec<&'static str>> {
    admit_assemblies(files.iter().map(|file| &file.mesh))?;
    let pairs = machine.parts.iter().zip(files);
    let systems = pairs.map(|(part, file)| assemble(part, &file.mesh).map_err(PipelineError::from));
    let systems = systems.collect::<Result<Vec<SecondOrder>, _>>()?;
    let advice = "take coarser meshes or smaller interfaces, or export the reduced machine (without --full)";
    admit("the unreduced machine", assembled_bytes(&systems, springs), room().as_ref(), advice)?;
    let whole = assembled(&systems, springs);
    let mut first = vec![1];
    first.extend(files.iter().scan(1, |next, file| {
        *next += file.mesh.nodes.len() as u64;
        Some(*next)
    }));
    let number = |row: &stiffmap::coupling::AssembledRow| {
        row.node.map(|(node, direction)| (first[row.part] + node as u64, direction, row.at))
    };
    begin()?;
    write_sparse(&out.join("stiffness.mtx"), &whole.stiffness)?;
    write_sparse(&out.join("mass.mtx"), &whole.mass)?;
    write_dofs(&out.join("dofs.csv"), &whole.rows.iter().map(number).collect::<Vec<_>>())?;
    Ok(vec!["stiffness.mtx", "mass.mtx", "dofs.csv"])
}

/// Stiffness over the fixed basis, mass, rows of outputs and inputs, and what the basis leaves out.
fn write_reduced(
    out: &Path,
    begin: Begin<'_>,
    machine: &Machine,
    files: &[MeshFile],
    position: f64,
    interrupt: &Interrupt,
) -> Result<Vec<&'static str>> {
    let cache = cache_folder().map(Cache::in_folder);
    let cached = pipeline::reduce_parts(machine, files, cache.as_ref(), interrupt, &|| ())?;
    let superelements: Vec<Superelement> = cached.into_iter().map(|c| c.superelement).collect();
    let highest = machine.analysis.frequencies.iter().copied().fold(0.0, f64::max);
    let model = pipeline::build_model(machine, &superelements, machine.analysis.modes, highest)?.model;
    let stiffness = model.stiffness(position).map_err(PipelineError::from)?;
    let at = model.at(position).map_err(PipelineError::from)?;
    let coupled = model.coupled(&at, &stiffness).map_err(PipelineError::from)?;
    begin()?;
    write_dense(&out.join("stiffness.mtx"), &model.stiffness_matrix(&coupled))?;
    write_dense(&out.join("mass.mtx"), &DMatrix::identity(model.n(), model.n()))?;
    write_dense(&out.join("outputs.mtx"), &coupled.outputs)?;
    write_dense(&out.join("inputs.mtx"), &coupled.inputs)?;
    write_dense(&out.join("direct.mtx"), &coupled.direct)?;
    Ok(vec!["stiffness.mtx", "mass.mtx", "outputs.mtx", "inputs.mtx", "direct.mtx"])
}
