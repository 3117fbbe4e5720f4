//! The files of a machine, read once.

use super::PipelineError;
use crate::files::Inputs;
use crate::machine::Machine;
use crate::mesh::{MeshError, MeshFile, inputs_of, read_part_mesh};
use rayon::prelude::*;

/// Reads every part's mesh or matrices.
///
/// # Errors
/// [`PipelineError::Mesh`], with file and line; [`PipelineError::Inputs`] if a file was edited between two readings.
pub fn read_meshes(machine: &Machine) -> Result<Vec<MeshFile>, PipelineError> {
    let meshes = machine.parts.par_iter().map(read_part_mesh).collect::<Result<Vec<MeshFile>, MeshError>>()?;
    inputs_of(&meshes)?;
    Ok(meshes)
}

/// Machine file and the files of all parts as they were read.
///
/// # Errors
/// [`PipelineError::Inputs`] if a file was edited between two readings.
pub fn inputs(machine: &Machine, meshes: &[MeshFile]) -> Result<Inputs, PipelineError> {
    let mut inputs = machine.inputs.clone();
    inputs.extend(&inputs_of(meshes)?)?;
    Ok(inputs)
}
