//! The machine file: what it says, checked and in SI units.
//!
//! [`read_machine`] reads `machine.toml` into a [`Machine`], the only thing the rest of the program
//! knows of the file: every quantity in it is in m, kg, s, N, rad and Hz, every name has been
//! resolved to an index, and every mesh file it names exists. What does not make a machine is refused
//! with the file, line and key, the value seen, what is allowed and what to do.
//!
//! In the file a quantity carries its unit (`"77 N/um"`, `"40 mm"`) or is a plain SI number; see
//! [`parse_quantity`]. The bundled mill, [`bundled_vertical_mill`], is the worked example.

mod analysis;
mod analysis_model;
mod axis;
mod bundled;
mod contact;
mod error;
mod frequencies;
mod interfaces;
mod joint_kinds;
mod joints;
mod matrices;
mod model;
mod nearest;
mod parts;
mod placement;
mod ports;
mod quantity;
mod read;
mod springs;
pub(crate) mod table;
mod units;

pub(crate) use analysis::read_damping;
pub use analysis_model::*;
pub use bundled::bundled_vertical_mill;
pub use error::{MachineError, Place};
pub use frequencies::{DEFAULT_BACKGROUND, DEFAULT_POINTS, logarithmic_frequencies, uniform_frequencies};
pub use matrices::{InterfaceNodes, InterfaceWeights, MatrixFiles};
pub use model::*;
pub use nearest::nearest;
pub use quantity::{Dimension, QuantityError, parse_quantity};
pub use read::read_machine;
