//! stiffmap: the dynamic stiffness of a machine tool over its whole work volume.
//!
//! ```text
//! machine.toml + part meshes or matrices
//!   machine        -> Machine            parts, interfaces, joints, axis, ports, damping: checked, in SI
//! each part, once (cached by content hash):
//!   mesh           -> Mesh               nodes, cells, named sets; or matrix -> stiffness and mass as given
//!   solid          -> SecondOrder        sparse mass and stiffness, and rows for every interface
//!   plausible      -> Findings           values far from any machine in use: warnings, and the slip behind each
//!   reduction      -> Superelement       M = I, K = diag(lambda), the interfaces' rows in reduced coordinates
//! the machine:
//!   coupling       -> CoupledModel       lambda, B(p), k(p): position and joint stiffness enter here and nowhere else
//! each position:
//!   modal          -> Modes              frequencies, damping, shapes at the ports; counted, tracked into families
//!   state_space    -> StateSpace         A, B, C, D
//!   frf | gpu      -> ComplianceMap      [position, frequency, output, input]
//!   response       -> History            motions over time, fixed, along a path, with friction and backlash
//!   sweep          -> metrics of many designs;  export, figures -> files
//! ```
//!
//! Each arrow is a plain function from one named struct to the next; [`pipeline`] strings them
//! together. A module uses only what stands above it here, and nothing in the physics names `gpu`,
//! `export` or `figures`.

pub mod interrupt;
pub mod resources;

pub mod files;

pub mod machine;

pub mod linalg;
pub mod matrix;

pub mod mesh;

pub mod element;
pub mod solid;

pub mod plausible;

pub mod reduction;

pub mod coupling;

pub mod modal;
pub mod state_space;

pub mod frf;
pub mod gpu;
pub mod response;

pub mod sweep;

pub mod export;
pub mod figures;

pub mod pipeline;
