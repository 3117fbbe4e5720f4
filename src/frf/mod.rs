//! The modal sum: frequency response of modal models over positions and frequencies.
//!
//! A request ([`FrfRequest`]) names one modal system a position and one frequency grid; [`modal_sum`] answers it in
//! f64 on the processor, [`crate::gpu`] on a device. Both sum in Hz, with each denominator written as
//! (f_r - f)(f_r + f) + j (eta_r f_r^2 + 2 zeta_r f_r f), which keeps its digits beside a resonance.
//! Damping that couples the modes is solved for at every frequency ([`ExactDamping`]), on the processor.
//! A map larger than memory is computed in [`Tile`]s. [`metrics`] finds the peaks of a map and refines them from the
//! modes, so that they do not depend on where the grid's points fall.

mod error;
mod exact;
mod extrema;
pub mod grid;
mod grid_search;
mod kernel;
mod map;
pub mod metrics;
mod modal_sum;
pub mod modification;
mod packing;
mod point;
mod request;
mod rest;
mod scatter;
mod tiles;
mod truncation;

pub use error::FrfError;
pub use exact::ExactDamping;
pub use extrema::{REACH, refined_extrema, refined_extrema_in};
pub use grid::FrequencyGrid;
pub use grid_search::GridSearch;
pub use map::ComplianceMap;
pub(crate) use modal_sum::zeros;
pub use modal_sum::{modal_sum, modal_sum_into, modal_sum_tiles};
pub use packing::{Denominator, PackedSystem, Packing};
pub use request::{FrfRequest, HIGHEST_FREQUENCY, LOWEST_FREQUENCY, ModalSystem, Quantity};
pub use tiles::{Sink, SinkError, Tile, TileLimits, TileRange, tiles};
pub use truncation::{Selection, Truncation, full_system, modal_systems};
