//! stiffmap: the dynamic stiffness of a machine tool over its whole work volume.

pub mod coupling;
pub mod element;
pub mod export;
pub mod figures;
pub mod frf;
pub mod gpu;
pub mod linalg;
pub mod machine;
pub mod mesh;
pub mod modal;
pub mod reduction;
pub mod solid;
pub mod state_space;
