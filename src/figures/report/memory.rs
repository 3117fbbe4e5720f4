//! How much memory pictures and page take, told before the positions are solved.

use super::database::{BUDGET, POSITIONS};
use crate::coupling::CoupledModel;
use crate::reduction::Superelement;
use crate::resources::{NoMemory, admit, room};

/// Bytes of a number.
const NUMBER: u64 = 8;
/// Bytes for pictures and for what every page holds, about: libraries, scripts, the text while it is put together.
const FIXED: u64 = 90_000_000;
/// How often the data of a page is in memory at once: arrays, file, its text in base 64 and the page.
const COPIES: u64 = 5;

/// Refuses a page that does not fit, by the positions of the run; `shapes_given_up` says that they are solved again
/// for the page.
///
/// # Errors
/// [`NoMemory`] with the advice to leave pictures and page out.
pub fn admit_page(
    model: &CoupledModel,
    superelements: &[Superelement],
    positions: usize,
    shapes_given_up: bool,
) -> Result<(), NoMemory> {
    let shown = positions.min(POSITIONS[1]) as u64;
    let square = NUMBER * (model.n() as u64).pow(2);
    let solved = if shapes_given_up { shown * square } else { 0 };
    // On each thread a position's coordinates, with the eigenproblem they come from.
    let formed = 6 * square * rayon::current_num_threads() as u64;
    let of_skin = |s: &Superelement| NUMBER * (s.skin.basis.len() + 6 * s.skin.nodes.len()) as u64;
    let skins: u64 = superelements.iter().map(of_skin).sum();
    let need = FIXED + COPIES * BUDGET as u64 + skins + solved + formed;
    let advice = "leave them out (--no-figures), ask for fewer positions, or take a machine or limit with more memory";
    admit(&format!("pictures and page of {positions} positions"), need, room().as_ref(), advice)
}
