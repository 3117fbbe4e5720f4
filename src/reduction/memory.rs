//! What memory a reduction takes, from the symbolic factorisation: the pattern of the matrix says how many numbers its
//! factor has before one of them is computed.
//!
//! Largest when the modes are counted: two factors (the one that is solved with, and the one whose inertia counts),
//! copies of the matrix, and blocks of vectors. Or in the end, when the basis, its image under the stiffness and the
//! reduced vectors stand side by side:
//!
//! ```text
//! bytes = 8 max( 2 f + 6 e + n (5 c + 4 m), 6 e + n (6 b + c) )
//! ```
//!
//! with n unknowns, e stored entries of the matrix, f of the factor, c columns of interface motions, m component
//! modes and b vectors of the basis.
//!
//! # Accuracy
//! See `docs/reliability.md`, section Resources.

use super::ReductionError;
use crate::interrupt::Interrupt;
use crate::linalg::{LinalgError, Ordering, factor_entries};
use crate::mesh::Mesh;
use crate::resources::{Share, admit, reserve, room};
use crate::solid::SecondOrder;

/// Bytes of a number.
const NUMBER: u64 = 8;
/// What to do where it does not fit.
const ADVICE: &str = "take a coarser mesh, fewer component modes, or a machine or limit with more memory";

/// Bytes that the assembly takes a pair of nodes of an element: the two element matrices, the pattern, and the
/// assembled matrices, in which neighbours share half of the entries.
const ASSEMBLED_PAIR: u64 = 260;

/// Refuses a part whose matrices alone do not fit, before they are formed.
pub(super) fn admit_assembly(part: &str, mesh: &Mesh) -> Result<(), ReductionError> {
    let pairs: u64 = mesh.cells.iter().map(|cell| (cell.nodes.len() as u64).pow(2)).sum();
    let what = format!("the assembly of part \"{part}\" with {} elements", mesh.cells.len());
    Ok(admit(&what, ASSEMBLED_PAIR * pairs, room().as_ref(), ADVICE)?)
}

/// Sizes that the memory of a reduction follows from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// Unknowns.
    pub unknowns: usize,
    /// Stored entries of the stiffness.
    pub entries: usize,
    /// Numbers in its factor.
    pub factor: usize,
    /// Columns of interface motions.
    pub columns: usize,
    /// Component modes.
    pub modes: usize,
    /// Whether the basis has second moments too.
    pub second_moment: bool,
}

impl Sizes {
    /// Bytes beside the assembled part, at most.
    pub fn bytes(self) -> u64 {
        let [n, e, f] = [self.unknowns, self.entries, self.factor].map(|x| x as u64);
        let (c, m) = (self.columns as u64, self.modes as u64);
        let basis = m + if self.second_moment { 2 * c } else { c };
        let counting = 2 * f + 6 * e + n * (5 * c + 4 * m);
        NUMBER * counting.max(6 * e + n * (6 * basis + c))
    }
}

/// A share of the memory for the reduction of a part; waits while parts beside it take too much.
pub(super) fn share(
    part: &str,
    system: &SecondOrder,
    ordering: &Ordering,
    (columns, modes, second_moment): (usize, usize, bool),
    interrupt: Option<&Interrupt>,
) -> Result<Share, ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let factor = factor_entries(&system.stiffness, ordering).map_err(failed)?;
    let (unknowns, entries) = (system.n_dof(), system.stiffness.entries());
    let sizes = Sizes { unknowns, entries, factor, columns, modes, second_moment };
    let what = format!("the reduction of part \"{part}\" with {unknowns} unknowns");
    tracing::debug!("{what}: {sizes:?}, {} bytes", sizes.bytes());
    reserve(&what, sizes.bytes(), ADVICE, interrupt)?.ok_or_else(|| failed(LinalgError::Interrupted))
}
