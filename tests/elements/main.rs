//! The solid elements and their faces: shape functions, gradients, matrices, patch test, rigid motions, mass,
//! convergence, interfaces.

#[path = "../support/mod.rs"]
mod support;

mod convergence;
mod interfaces;
mod kinds;
mod meshes;
mod tet_matrices;
mod tet_shape;
