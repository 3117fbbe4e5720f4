//! Abaqus/CalculiX `.inp`: nodes, solid elements, sets, surfaces, isotropic materials, solid sections,
//! held displacements, included files.
//!
//! Keywords and names are read without regard to case and blanks, data in free format. Names may stand in double
//! quotes, in keyword and data lines. What would not change
//! the mesh (output requests, later steps) is passed over with a warning; everything else that is not
//! understood is refused with its line.
//!
//! The file is read in two passes: `sections` collects what stands in it, `assemble` resolves labels and
//! names, so sections may come in any order. [`read_deck`] reads the frequency step too.

mod assemble;
mod keywords;
mod lines;
mod materials;
mod parameters;
mod places;
mod properties;
mod raw;
mod sections;
mod sets;
mod source;
mod step;
mod surfaces;
mod topology;

pub use raw::FrequencyStep;

use super::{Mesh, MeshError, MeshFile, Warning};
use crate::files::Inputs;
use crate::machine::MeshUnits;
use sections::Purpose;
use source::Source;
use std::path::Path;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// C3D8 stays the plain brick.
    pub plain_bricks: bool,
    /// The part is made of something that the file does not say: its materials are passed over.
    pub other_material: bool,
}

/// The mesh of an Abaqus/CalculiX input file; its warnings go to the log.
///
/// `units` are those of the file; the mesh is in m, Pa and kg/m^3. Nodes that no element uses are
/// dropped. An element without a `*SOLID SECTION` has no material. C3D8 is read as C3D8I.
///
/// # Errors
/// [`MeshError`] with the line: a keyword or parameter that would change the result and is not
/// supported, an element type that is no supported solid, unreadable or infinite numbers, labels given
/// twice, labels or names that do not exist, an element that is cut off, a material without modulus or
/// density, no elements.
pub fn read_inp(path: &Path, units: MeshUnits) -> Result<Mesh, MeshError> {
    let MeshFile { mesh, warnings } = read_inp_file(path, units, false)?;
    for Warning { line, text } in warnings {
        tracing::warn!("{}:{line}: {text}", path.display());
    }
    Ok(mesh)
}

/// The mesh of an Abaqus/CalculiX input file and its warnings; C3D8 stays as it is if `plain_bricks`.
///
/// # Errors
/// As [`read_inp`].
pub fn read_inp_file(path: &Path, units: MeshUnits, plain_bricks: bool) -> Result<MeshFile, MeshError> {
    read_inp_as(path, units, Reading { plain_bricks, other_material: false })
}

/// The mesh of an Abaqus/CalculiX input file and its warnings.
///
/// # Errors
/// As [`read_inp`].
pub fn read_inp_as(path: &Path, units: MeshUnits, how: Reading) -> Result<MeshFile, MeshError> {
    parse(Source::read(path)?, units, how)
}

/// The mesh of the bytes of an input file; `file` serves the messages, and its folder what is included.
///
/// # Errors
/// As [`read_inp`].
pub fn parse_inp(bytes: &[u8], file: &Path, units: MeshUnits) -> Result<MeshFile, MeshError> {
    parse(Source::new(bytes, file)?, units, Reading::default())
}

fn parse(mut source: Source, units: MeshUnits, how: Reading) -> Result<MeshFile, MeshError> {
    let raw = sections::collect(&source, Purpose::Part, how)?;
    let mut file = assemble::assemble(raw, &source, units, how.other_material)?;
    file.mesh.inputs = std::mem::take(&mut source.inputs);
    Ok(file)
}

/// A deck: a mesh and what its frequency step asks for, in the deck's own units.
#[derive(Clone, Debug)]
pub struct Deck {
    /// The mesh, with what the deck holds in [`Mesh::supports`].
    pub mesh: Mesh,
    /// The frequency step.
    pub frequency: FrequencyStep,
    /// What was passed over.
    pub warnings: Vec<Warning>,
}

/// A CalculiX or Abaqus deck whose first step computes frequencies; `modes` overrides their number and
/// serves where the deck has no step.
///
/// # Errors
/// As [`read_inp`], and [`MeshError::Deck`] where the first step is another, or there is none and no `modes`.
pub fn read_deck(path: &Path, plain_bricks: bool, modes: Option<usize>) -> Result<Deck, MeshError> {
    deck(&Source::read(path)?, plain_bricks, modes)
}

/// The same of the bytes of a deck.
///
/// # Errors
/// As [`read_deck`].
pub fn parse_deck(bytes: &[u8], file: &Path, plain_bricks: bool, modes: Option<usize>) -> Result<Deck, MeshError> {
    deck(&Source::new(bytes, file)?, plain_bricks, modes)
}

fn deck(source: &Source, plain_bricks: bool, modes: Option<usize>) -> Result<Deck, MeshError> {
    let raw = sections::collect(source, Purpose::Deck, Reading { plain_bricks, other_material: false })?;
    let whole = |modes| FrequencyStep { modes, from: f64::NEG_INFINITY, to: f64::INFINITY };
    let mut frequency = raw.frequency.or(modes.map(whole)).ok_or_else(|| MeshError::Deck {
        spot: source.spot(1),
        reason: "the deck has no *STEP; allowed: a first step of *FREQUENCY; add it, or give --modes".into(),
    })?;
    frequency.modes = modes.unwrap_or(frequency.modes);
    let MeshFile { mesh, warnings } = assemble::assemble(raw, source, MeshUnits::METRE_KILOGRAM_SECOND, false)?;
    Ok(Deck { mesh, frequency, warnings })
}

/// Reads a file whole and records it.
fn read(path: &Path, inputs: &mut Inputs) -> Result<Vec<u8>, MeshError> {
    inputs.read(path).map_err(|source| MeshError::Unreadable { file: path.to_path_buf(), source })
}
