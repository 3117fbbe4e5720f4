//! Friction and backlash as forces fed back between the joints' reduced coordinates.
//!
//! At a fixed position each law sees the relative motion e = j . z of its joint and answers with a
//! tension lambda between the two sides:
//!
//! ```text
//! z'' + C z' + K z = R^T u - J^T lambda
//! friction   lambda in F(|e'|) Sgn(e')        F(v) = Fc + (Fb - Fc) exp(-(v / vs)^2); it holds up to Fb
//! backlash   lambda = -k clamp(e, -g/2, g/2)  K holds the screw's k, so the screw's force is k (e - clamp(e))
//! ```
//!
//! A step is the modes' exact flow, with friction constant over it and backlash straight, and the laws
//! hold at its end: a small complementarity problem (friction in velocities, backlash in displacements)
//! with a unique solution, solved by its active set. Sgn is the set-valued sign, so a joint that sticks
//! does not creep, and nothing is regularised. A reversal of sliding inside a step is located on the
//! exact flow and the step is split there, so that stopping is where and when it is, not at a sample.
//!
//! The flexibility that no mode carries, and that of modes too fast for the step, belongs to the contacts: a joint's
//! relative motion is e = j . z + c_u u - sum c lambda, over all contacts, and outputs and inputs feel it alike. A joint
//! that holds takes its mean motion over a step from both ends (the trapezoidal rule) as long as its own oscillation
//! is resolved, and from the end where its sides are too stiff for that; without flexibility it stops where it is.
//!
//! Source: Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, Springer 2008, ch. 10.

mod elements;
mod reduced;
mod run;
mod solve;
mod span;

pub use elements::{Element, Law, elements};
pub use run::{ContactHistory, Event, EventKind, simulate_contact};
