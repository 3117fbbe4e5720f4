//! The machine while it travels: K(p(t)) without steps.
//!
//! ```text
//! z'' + C(p) z' + K(p) z = R(p)^T u,   y = L(p) z + D(p) u,   p = p(t)
//! C(p) = Phi diag(2 zeta_r omega_r) Phi^T with the modes Phi of K(p): the damping of the fixed position
//! ```
//!
//! The coordinates are those of a basis that spans the modes of the whole path up to a band
//! ([`PathModel`]), with M = I and matrices that are smooth functions of p. The stepping ([`travel`])
//! holds K at the middle of every few samples and crosses them by the exact flow of that frozen system:
//! symplectic where nothing damps, stable for any step, second order in the step, and the fixed
//! position's own recursion where the path rests. The energy balance ([`Energy`]) is not a property of
//! that scheme: it is integrated from the sampled motion and the continuous K(p).
//!
//! ```text
//! kinetic + potential = int u . R z' dt - int z' . C z' dt + int 1/2 z . (dK/dt) z dt
//! ```
//!
//! The last term is the work that the guide does on the machine through the change of K.
//!
//! Source of the stepping: Hochbruck and Ostermann, Exponential integrators, Acta Numerica 19 (2010).

mod basis;
mod energy;
mod run;

pub use basis::{LocalModel, PathModel, PathOptions};
pub use energy::Energy;
pub use run::{Travel, TravelOptions, travel};
