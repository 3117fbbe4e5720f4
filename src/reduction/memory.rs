//! What memory a reduction and the modes of a part take, from the symbolic factorisation: the pattern of the matrix says
//! how many numbers its factor has before one of them is computed.
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

use super::{ReductionError, ReductionRequest};
use crate::interrupt::Interrupt;
use crate::linalg::{LinalgError, Ordering, factor_entries};
use crate::mesh::Mesh;
use crate::resources::{NoMemory, Share, admit, reserve, room};
use crate::solid::SecondOrder;

/// Bytes of a number.
const NUMBER: u64 = 8;
/// What to do where it does not fit.
pub const REDUCTION_ADVICE: &str = "take a coarser mesh, fewer component modes, or a machine or limit with more memory";

/// Bytes that the assembly takes a pair of nodes of an element: the two element matrices, the pattern, and the
/// assembled matrices, in which neighbours share half of the entries.
const ASSEMBLED_PAIR: u64 = 310;

/// Of that what stays when the assembly is done.
const KEPT_PAIR: u64 = 160;

/// Pairs of nodes of all elements of a mesh.
fn pairs(mesh: &Mesh) -> u64 {
    mesh.cells.iter().map(|cell| (cell.nodes.len() as u64).pow(2)).sum()
}

/// Refuses a part whose matrices alone do not fit, before they are formed.
///
/// # Errors
/// [`NoMemory`].
pub fn admit_assembly(part: &str, mesh: &Mesh) -> Result<(), NoMemory> {
    let what = format!("the assembly of part \"{part}\" with {} elements", mesh.cells.len());
    admit(&what, ASSEMBLED_PAIR * pairs(mesh), room().as_ref(), REDUCTION_ADVICE)
}

/// Vectors that the Lanczos iteration of `shift_invert_modes` holds a mode, and beside them.
const VECTORS_A_MODE: u64 = 9;
const VECTORS: u64 = 200;

/// Refuses parts whose matrices do not fit side by side, before they are formed one after the other.
///
/// # Errors
/// [`NoMemory`].
pub fn admit_assemblies<'a>(meshes: impl Iterator<Item = &'a Mesh>) -> Result<(), NoMemory> {
    let (mut kept, mut largest, mut elements) = (0, 0, 0);
    for mesh in meshes {
        let pairs = pairs(mesh);
        (kept, largest, elements) = (kept + pairs, largest.max(pairs), elements + mesh.cells.len());
    }
    let need = KEPT_PAIR * (kept - largest) + ASSEMBLED_PAIR * largest;
    admit(&format!("the assembly of all parts with {elements} elements"), need, room().as_ref(), REDUCTION_ADVICE)
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
    /// Of an assembled part.
    fn new(
        system: &SecondOrder,
        ordering: &Ordering,
        (columns, modes, second_moment): (usize, usize, bool),
    ) -> Result<Self, LinalgError> {
        let factor = factor_entries(&system.stiffness, ordering)?;
        let (unknowns, entries) = (system.n_dof(), system.stiffness.entries());
        Ok(Self { unknowns, entries, factor, columns, modes, second_moment })
    }

    /// Bytes of the modes alone beside the assembled part, at most.
    fn bytes_of_modes(self) -> u64 {
        let [n, e, f, m] = [self.unknowns, self.entries, self.factor, self.modes].map(|x| x as u64);
        NUMBER * (2 * f + 6 * e + n * (VECTORS_A_MODE * m + VECTORS))
    }

    /// Bytes beside the assembled part, at most.
    pub fn bytes(self) -> u64 {
        let [n, e, f] = [self.unknowns, self.entries, self.factor].map(|x| x as u64);
        let (c, m) = (self.columns as u64, self.modes as u64);
        let basis = m + if self.second_moment { 2 * c } else { c };
        let counting = 2 * f + 6 * e + n * (5 * c + 4 * m);
        NUMBER * counting.max(6 * e + n * (6 * basis + c))
    }
}

/// Bytes that the reduction of an assembled part takes beside its matrices, at most. Nothing is solved: the ordering
/// and the symbolic factorisation say it.
///
/// # Errors
/// [`ReductionError::Linalg`] if there is no ordering.
pub fn foreseen(request: &ReductionRequest, system: &SecondOrder) -> Result<u64, ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: request.part.name.clone(), source };
    let ordering = system.ordering().map_err(failed)?;
    let sizes = Sizes::new(system, &ordering, columns_and_modes(request, system));
    Ok(sizes.map_err(failed)?.bytes())
}

/// Refuses a part with too many unknowns for its modes, before its matrix is factored.
///
/// Two factors as in a reduction, six copies of the matrix, and the vectors of the Lanczos iteration with their images.
///
/// # Errors
/// [`ReductionError::Memory`]; [`ReductionError::Linalg`] if the symbolic factorisation fails.
pub fn admit_modes(part: &str, system: &SecondOrder, ordering: &Ordering, modes: usize) -> Result<(), ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let sizes = Sizes::new(system, ordering, (0, modes.min(system.n_dof()), false)).map_err(failed)?;
    let what = format!("{modes} modes of \"{part}\" with {} unknowns", sizes.unknowns);
    tracing::debug!("{what}: {sizes:?}, {} bytes", sizes.bytes_of_modes());
    let advice = "ask for fewer modes, take a coarser mesh, or a machine or limit with more memory";
    Ok(admit(&what, sizes.bytes_of_modes(), room().as_ref(), advice)?)
}

/// Columns of interface motions and component modes at most, and whether the basis has second moments.
pub(super) fn columns_and_modes(request: &ReductionRequest, system: &SecondOrder) -> (usize, usize, bool) {
    (request.most_motions(&system.surfaces), request.component.modes, request.component.second_moment)
}

/// A share of the memory for the reduction of a part; waits while parts beside it take too much.
pub(super) fn share(
    part: &str,
    system: &SecondOrder,
    ordering: &Ordering,
    columns_and_modes: (usize, usize, bool),
    interrupt: Option<&Interrupt>,
) -> Result<Share, ReductionError> {
    let failed = |source: LinalgError| ReductionError::Linalg { part: part.to_string(), source };
    let sizes = Sizes::new(system, ordering, columns_and_modes).map_err(failed)?;
    let what = format!("the reduction of part \"{part}\" with {} unknowns", sizes.unknowns);
    tracing::debug!("{what}: {sizes:?}, {} bytes", sizes.bytes());
    reserve(&what, sizes.bytes(), REDUCTION_ADVICE, interrupt)?.ok_or_else(|| failed(LinalgError::Interrupted))
}
