//! The machine while it travels: K(p(t)) without steps.
//!
//! ```text
//! z'' + C(p) z' + K(p) z = R(p)^T u,   y = L(p) z + D(p) u,   p = p(t)
//! ```
//!
//! The coordinates are all of the fixed basis, so nothing is truncated: at rest the machine is that of the fixed
//! position. Every few millimetres of the path stands a **station**, whose modes Phi (K_s = Phi diag(omega^2) Phi^T)
//! are known ([`PathModel`]). Over a sample the machine is that of the nearest station plus what has changed since,
//! K(p) - K_s, which is small and of few rows, since only what rides on the rail has moved. The modes of the station
//! are stepped exactly, and the change acts as a force that is constant over the step and follows the mean of both
//! its ends ([`travel`]):
//!
//! ```text
//! z'' + C_s z' + K_s z = R^T u - (K(p_m) - K_s) (z_k + z_(k+1)) / 2        p_m: in the middle of the step
//! ```
//!
//! A constant force does the work f . (z_(k+1) - z_k), here exactly the change of 1/2 z . (K - K_s) z. So the scheme
//! keeps the energy of the whole machine, whatever the step, and is stable for any; it is of second order in the step,
//! and exact where the machine stands at a station. C_s is that of the station; the dampers of joints act between its
//! modes, at their own place, with a force that is a quadratic of the time over the step and follows the rate best.
//!
//! The energy balance ([`Energy`]) adds up exact integrals over each step:
//!
//! ```text
//! kinetic + potential = int u . R z' dt - int z' . C z' dt + work of the guide through the change of K
//! ```
//!
//! Source: energy-preserving exponential integrators, Wang and Wu, J. Comput. Phys. 321 (2016); the splitting about
//! stations is ours.

mod energy;
mod flow;
mod mode_table;
mod model;
mod run;
mod station;

pub use energy::Energy;
pub use model::{LocalModel, PathModel, PathOptions};
pub use run::{Travel, TravelOptions, travel};
