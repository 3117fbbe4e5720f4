//! Matrices instead of meshes: a part's stiffness and mass as another program wrote them.
//!
//! | files | from | labels of the rows |
//! |---|---|---|
//! | `.mtx` | Matrix Market | a table `node,direction[,x,y,z]` |
//! | `.sti`, `.mas` | CalculiX, `*FREQUENCY, SOLVER=MATRIXSTORAGE` | its `.dof` |
//! | `.mtx` | Abaqus, `*MATRIX OUTPUT` | in the file, or a table for the coordinate format |
//! | `.op4` | Nastran, OUTPUT4 | a table |
//! | `.full` | Ansys | in the file |
//!
//! A superelement is the same with rows that are `modal` coordinates. Coordinates of the nodes come
//! from the part's mesh file, the table, or a list of nodes; interfaces are faces of the mesh, weighted
//! node sets, or single nodes. [`read_part_matrices`] brings them together, in SI units.

mod abaqus;
mod calculix;
mod coordinates;
mod error;
mod full;
mod labels;
mod market;
pub mod op4;
mod read;
mod source;
mod text;

pub use abaqus::parse_abaqus;
pub use calculix::parse_calculix;
pub use coordinates::{Coordinates, SYMMETRY, symmetric};
pub use error::MatrixError;
pub use full::{FullFile, parse_full};
pub use labels::{
    DIRECTIONS, DofLabel, DofTable, NodeSet, parse_calculix_dofs, parse_dof_table, parse_node_table, parse_set_table,
};
pub use market::parse_market;
pub use read::{Geometry, GivenMatrices, GivenNodes, MatrixPart, read_part_matrices};
