//! `stiffmap check`: what is understood of a machine.

use super::{machine_path, streams};
use anyhow::Result;
use clap::Args;
use std::fmt::Write as _;
use std::path::PathBuf;
use stiffmap::coupling::reduction_requests;
use stiffmap::machine::{Contact, Grid, JointKind, Machine, Motion, Part, ScrewSupport, SpringStiffness, read_machine};
use stiffmap::mesh::MeshFile;
use stiffmap::pipeline;
use stiffmap::reduction::{REDUCTION_ADVICE, ReductionRequest, admit_assemblies, foreseen};
use stiffmap::resources::{Size, admit, room};
use stiffmap::solid::{SecondOrder, assemble};

#[derive(Args, Debug)]
pub struct Arguments {
    /// Machine file, or the folder that holds machine.toml; the bundled vertical mill without it
    machine: Option<PathBuf>,
}

/// Reads, assembles and describes a machine; nothing is solved and nothing is written.
pub fn check(arguments: &Arguments) -> Result<()> {
    let (path, _bundled) = machine_path(arguments.machine.as_deref())?;
    let machine = read_machine(&path)?;
    let meshes = pipeline::read_meshes(&machine)?;
    let mut warnings = pipeline::plausibility(&machine, &meshes);
    let described = describe(&machine, &meshes, &mut warnings);
    // What is implausible explains a refusal, so it is said in either case.
    if described.is_err() {
        warnings.iter().for_each(|warning| streams::say(&format!("warning: {warning}")));
    }
    streams::print(&described?)?;
    Ok(())
}

/// What is understood of a machine in lines, its warnings last; those of the travel are added to the given ones.
fn describe(machine: &Machine, meshes: &[MeshFile], warnings: &mut Vec<String>) -> Result<String> {
    let mut out = String::new();
    writeln!(out, "{}\n", machine.name)?;
    writeln!(out, "part              nodes  elements  unknowns    mass kg  interfaces")?;
    let mut centroids = Vec::new();
    let mut unknowns = 0;
    let mut surfaces = Vec::new();
    let mut systems = Vec::new();
    admit_assemblies(meshes.iter().map(|file| &file.mesh))?;
    for (part, file) in machine.parts.iter().zip(meshes) {
        let system = assemble(part, &file.mesh).map_err(pipeline::PipelineError::from)?;
        writeln!(
            out,
            "{:<16} {:6}  {:8}  {:8} {:10.2}  {}{}",
            part.name,
            file.mesh.nodes.len(),
            file.mesh.cells.len(),
            system.n_dof(),
            system.total_mass,
            part.interfaces.iter().map(|i| i.name.as_str()).collect::<Vec<_>>().join(", "),
            held_at(part)
        )?;
        for warning in &file.warnings {
            writeln!(out, "  line {}: {}", warning.line, warning.text)?;
        }
        unknowns += system.n_dof();
        surfaces.push(system.surfaces.clone());
        centroids.push(system.interfaces.iter().map(|i| i.centroid).collect::<Vec<_>>());
        systems.push(system);
    }
    let pairs = |system: &SecondOrder| system.surfaces.iter().cloned().zip(system.interfaces.iter().cloned()).collect();
    let requests = reduction_requests(machine, &systems.iter().map(pairs).collect::<Vec<_>>());
    let coordinates: usize = requests.iter().zip(&surfaces).map(|(r, s)| r.most_coordinates(s)).sum();
    writeln!(out, "unknowns before the reduction: {unknowns}; coordinates after the reduction: at most {coordinates}")?;
    describe_memory(&mut out, &requests, &systems, warnings)?;
    describe_joints(&mut out, machine, &centroids)?;
    describe_axis(&mut out, machine)?;
    for free in pipeline::mechanisms(machine, meshes, &systems, machine.axis.travel[0])? {
        writeln!(out, "free motion at 0 Hz: {free}")?;
    }
    warnings.extend(pipeline::check_travel(machine, meshes, &centroids)?);
    for warning in warnings {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(out)
}

/// What the reduction is expected to take, and what there is: the figures by which `run` refuses a part.
fn describe_memory(
    out: &mut String,
    requests: &[ReductionRequest],
    systems: &[SecondOrder],
    warnings: &mut Vec<String>,
) -> Result<()> {
    let room = room();
    let mut parts = Vec::new();
    for (request, system) in requests.iter().zip(systems) {
        let (name, bytes) = (&request.part.name, foreseen(request, system)?);
        parts.push(format!("{name} {}", Size(bytes)));
        let what = format!("the reduction of part \"{name}\" with {} unknowns", system.n_dof());
        warnings.extend(admit(&what, bytes, room.as_ref(), REDUCTION_ADVICE).err().map(|error| error.to_string()));
    }
    let left = room.map_or_else(|| "not known here".into(), |room| format!("{} by {}", Size(room.bytes), room.limit));
    writeln!(out, "memory of the reduction: {}; left: {left}\n", parts.join(", "))?;
    Ok(())
}

/// Where a part is held to ground.
fn held_at(part: &Part) -> String {
    let mut text =
        if part.clamped.is_empty() { String::new() } else { format!("; clamped at {}", part.clamped.join(", ")) };
    for support in &part.supported {
        let held: Vec<&str> =
            ["x", "y", "z"].into_iter().zip(support.directions).filter(|(_, h)| *h).map(|(n, _)| n).collect();
        text += &format!("; {} held at {}", held.join(", "), support.nodes);
    }
    text
}

fn describe_joints(out: &mut String, machine: &Machine, centroids: &[Vec<[f64; 3]>]) -> Result<()> {
    let side = |r: stiffmap::machine::InterfaceRef| {
        let part = &machine.parts[r.part];
        format!("{}.{}", part.name, part.interfaces[r.interface].name)
    };
    writeln!(out, "joint")?;
    for joint in &machine.joints {
        let springs: Vec<String> = joint
            .springs
            .iter()
            .filter(|s| s.stiffness != SpringStiffness::Constant(0.0) || s.damping > 0.0)
            .map(|s| match (s.stiffness, s.motion) {
                (SpringStiffness::Constant(k), Motion::Translation) => {
                    format!("{} {} N/um", s.label, (k * 1e-2).round() * 1e-4)
                }
                (SpringStiffness::Constant(k), Motion::Rotation) => format!("{} {k:.4e} N m/rad", s.label),
                (SpringStiffness::BallScrew { young, diameter, support, .. }, _) => {
                    let length = |p: f64| pipeline::screw_length(machine, joint, centroids, p);
                    let k = |p: f64| support.stiffness(young, diameter, length(p)) * 1e-6;
                    let held = match support {
                        ScrewSupport::OneEnd => String::new(),
                        ScrewSupport::BothEnds { span } => format!(", held at both ends {span:.4} m apart"),
                    };
                    let [a, b] = machine.axis.travel;
                    format!(
                        "E {:.1} GPa, D {:.1} mm, L {:.4} m at {a} m ({:.1} N/um), L {:.4} m at {b} m ({:.1} N/um){held}",
                        young * 1e-9,
                        diameter * 1e3,
                        length(a),
                        k(a),
                        length(b),
                        k(b)
                    )
                }
            })
            .collect();
        let kind = match joint.kind {
            JointKind::LinearGuide => "linear guide",
            JointKind::Bearing => "bearing",
            JointKind::BallScrew => "ball screw",
            JointKind::Bolted => "bolted",
            JointKind::SpringDamper => "spring-damper",
        };
        let footprint = joint.footprint.map_or_else(String::new, |f| format!(", footprint {:.1} mm", f * 1e3));
        writeln!(
            out,
            "  {:<18} {kind}, {} on {}{footprint}: {}",
            joint.name,
            side(joint.between[1]),
            side(joint.between[0]),
            springs.into_iter().chain(joint.contact.map(contact)).collect::<Vec<_>>().join(", ")
        )?;
    }
    Ok(())
}

/// A joint's nonlinear law in words.
fn contact(law: Contact) -> String {
    match law {
        Contact::Backlash(gap) => format!("backlash {:.3} um", gap * 1e6),
        Contact::Friction(f) if f.breakaway > f.coulomb => {
            format!(
                "friction {} N, breakaway {} N, Stribeck speed {:.3} mm/s",
                f.coulomb,
                f.breakaway,
                f.stribeck * 1e3
            )
        }
        Contact::Friction(f) => format!("friction {} N", f.coulomb),
    }
}

fn describe_axis(out: &mut String, machine: &Machine) -> Result<()> {
    let axis = &machine.axis;
    let moving: Vec<&str> =
        machine.parts.iter().zip(&axis.moves).filter(|(_, m)| **m).map(|(p, _)| p.name.as_str()).collect();
    writeln!(
        out,
        "\naxis {}: {} to {} m, {} stations; moves {}",
        axis.name,
        axis.travel[0],
        axis.travel[1],
        axis.stations().len(),
        moving.join(", ")
    )?;
    for port in &machine.ports {
        let part = &machine.parts[port.interface.part];
        let directions: Vec<&str> = port.directions.iter().map(|(d, _)| d.as_str()).collect();
        writeln!(
            out,
            "port {}: {}.{}, {}{}{}",
            port.name,
            part.name,
            part.interfaces[port.interface.interface].name,
            directions.join(", "),
            if port.input { ", input" } else { "" },
            if port.output { ", output" } else { "" }
        )?;
    }
    let grid = &machine.analysis.frequencies;
    writeln!(
        out,
        "analysis: {}{} component modes a part, {} elastic modes a position, {} from {} to {} Hz ({} grid{})",
        if machine.analysis.component.follows { "at least " } else { "" },
        machine.analysis.component.modes,
        machine.analysis.modes,
        machine.analysis.quantity.name(),
        grid.first().copied().unwrap_or_default(),
        grid.last().copied().unwrap_or_default(),
        machine.analysis.grid.name(),
        match machine.analysis.grid {
            Grid::Clustered { points } => format!(", {points} frequencies a mode on {}", grid.len()),
            _ => format!(", {} frequencies", grid.len()),
        }
    )?;
    Ok(())
}
