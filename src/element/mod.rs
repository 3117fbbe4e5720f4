//! Shape functions and quadrature, one file an element.
//!
//! Every element answers the same three questions at a point of its reference domain: the shape
//! functions, their gradients in physical coordinates, and the Jacobian's determinant. Node orders
//! are those of Abaqus and CalculiX.

pub mod quadrature;
pub mod tet10;
pub mod tri6;
