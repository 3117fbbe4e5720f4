//! stiffmap: the dynamic stiffness of a machine tool over its whole work volume.

pub mod machine;
pub mod mesh;
pub mod element;
pub mod linalg;
pub mod solid;
pub mod reduction;
pub mod coupling;
pub mod modal;
pub mod state_space;
pub mod frf;
pub mod gpu;
pub mod export;
pub mod figures;
