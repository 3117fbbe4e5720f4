//! The main job's stages, each a function from one named struct to the next.

mod mechanism;
mod plausibility;
mod projection;
mod reading;
mod reduction_error;
mod side_by_side;
mod travel;

pub use mechanism::mechanisms;
pub use plausibility::{modal_plausibility, plausibility, study_plausibility};
pub use projection::{PROJECTION_TOLD, ProjectionError, Simplified, acting_damping, projection_error};
pub use reading::{inputs, read_meshes};
pub use reduction_error::{FREQUENCY_BOUND, MAP_BOUND, ReductionErrors, few_component_modes, reduction_errors};
pub use travel::{check_travel, screw_length};

use crate::coupling::{
    BasisOptions, CoupledModel, CouplingError, Unreduced, at_fixed_position, couple, reduction_requests, unreduced,
};
use crate::files::InputError;
use crate::interrupt::Interrupt;
use crate::linalg::LinalgError;
use crate::machine::{Damping, Machine, SurfaceCoupling};
use crate::mesh::{MeshError, MeshFile, inputs_of};
use crate::modal::{ModalError, ModeCount, ModeFamilies, Modes, Tracker, check_count, modes_at, track};
use crate::reduction::{Cache, CacheError, Cached, ReductionError, Superelement, reduce};
use crate::solid::{SolidError, interface_motions};
use nalgebra::DMatrix;
use rayon::prelude::*;
use side_by_side::side_by_side;

/// Why a stage failed.
#[derive(Debug, thiserror::Error)]
pub enum PipelineError {
    /// A file was edited between two readings.
    #[error(transparent)]
    Inputs(#[from] InputError),
    /// A mesh file is missing or not usable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A part is not usable.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// A part could not be reduced.
    #[error(transparent)]
    Reduction(#[from] ReductionError),
    /// The parts could not be coupled.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// The modes of a position could not be had.
    #[error(transparent)]
    Modal(#[from] ModalError),
    /// Responses could not be summed.
    #[error(transparent)]
    Frf(#[from] crate::frf::FrfError),
    /// The user asked to stop.
    #[error("interrupted; nothing half-written is left")]
    Interrupted,
}

impl PipelineError {
    /// Whether the input is to blame (exit code 2) and not the computation.
    pub fn is_input(&self) -> bool {
        match self {
            Self::Mesh(error) => !matches!(error, MeshError::Memory(_)),
            Self::Inputs(_) | Self::Solid(_) => true,
            Self::Reduction(error) => matches!(error, ReductionError::Solid(_) | ReductionError::NotHeld { .. }),
            Self::Coupling(error) | Self::Modal(ModalError::Coupling(error)) => {
                !matches!(error, CouplingError::Basis(_))
            }
            Self::Modal(_) | Self::Frf(_) | Self::Interrupted => false,
        }
    }
}

/// Reports that one more of a stage's steps is done.
pub type Step<'a> = &'a (dyn Fn() + Sync);

/// Reduces every part, parts in parallel; superelements come from the cache where there is one.
///
/// # Errors
/// [`PipelineError`] of the first part that fails.
pub fn reduce_parts(
    machine: &Machine,
    meshes: &[MeshFile],
    cache: Option<&Cache>,
    interrupt: &Interrupt,
    step: Step<'_>,
) -> Result<Vec<Cached>, PipelineError> {
    let interfaces = machine.parts.iter().zip(meshes).map(|(part, file)| interface_motions(part, &file.mesh));
    let interfaces = interfaces.collect::<Result<Vec<_>, SolidError>>()?;
    let centroids: Vec<Vec<[f64; 3]>> =
        interfaces.iter().map(|of_part| of_part.iter().map(|(_, motion)| motion.centroid).collect()).collect();
    check_travel(machine, meshes, &centroids)?;
    let requests = reduction_requests(machine, &interfaces);
    // The largest part first, so that it does not run alone at the end.
    let mut order: Vec<usize> = (0..requests.len()).collect();
    order.sort_by_key(|&i| std::cmp::Reverse(meshes[i].mesh.nodes.len()));
    // A part that fails, or does not fit into the memory, stops those beside it.
    let all = interrupt.within();
    let one = |&i: &usize| -> Result<(usize, Cached), PipelineError> {
        if all.requested() {
            return Err(PipelineError::Interrupted);
        }
        let (request, mesh) = (&requests[i], &meshes[i].mesh);
        let made = match cache {
            Some(cache) => cache.reduce(request, mesh, Some(&all)),
            None => reduce(request, mesh, Some(&all)).map(|superelement| Cached {
                superelement,
                hit: false,
                warnings: Vec::new(),
            }),
        };
        step();
        match made.inspect_err(|_| all.request()) {
            Err(ReductionError::Linalg { source: LinalgError::Interrupted, .. }) => Err(PipelineError::Interrupted),
            made => Ok((i, made?)),
        }
    };
    let mut parts = side_by_side(&order, &one)?;
    parts.sort_by_key(|(i, _)| *i);
    Ok(parts.into_iter().map(|(_, cached)| cached).collect())
}

/// A machine in its fixed basis, with how good that is.
#[derive(Clone, Debug)]
pub struct Built {
    /// The machine; its basis was made for `model.frequency`.
    pub model: CoupledModel,
    /// Largest relative difference of the wanted frequencies between the basis and the superelements side by
    /// side; see [`check_basis`].
    pub error: f64,
}

/// A basis is made larger as long as it is further than this from the superelements side by side.
pub const BASIS_BOUND: f64 = 1e-5;

/// Couples the superelements in a fixed basis made for frequencies up to `highest` (Hz), or as far up
/// as the `reported` elastic modes reach where that is higher, and made larger until it is within
/// [`BASIS_BOUND`] of the superelements or holds all their coordinates.
///
/// # Errors
/// [`PipelineError`] of coupling, or of the modes at the positions looked at.
pub fn build_model(
    machine: &Machine,
    superelements: &[Superelement],
    reported: usize,
    highest: f64,
) -> Result<Built, PipelineError> {
    let mut made = highest.max(SOFTEST * lowest_elastic(superelements));
    loop {
        let model = couple(machine, superelements, BasisOptions::up_to(made))?;
        let (error, last) = check_basis(machine, &model, reported)?;
        // Frequencies move by some 10 % over a travel; a basis that reaches a quarter too far is no loss.
        let reaches = last.is_some_and(|last| 0.8 * last <= made);
        if model.is_whole() || reaches && error <= BASIS_BOUND {
            return Ok(Built { model, error });
        }
        made = if reaches { 1.5 * made } else { last.map_or(2.0 * made, |last| 1.25 * last) };
    }
}

/// A basis is made for at least this share of the parts' lowest elastic frequency.
const SOFTEST: f64 = 0.1;

fn lowest_elastic(superelements: &[Superelement]) -> f64 {
    let positive = superelements.iter().flat_map(|s| s.eigenvalues.iter().copied()).filter(|l| *l > 0.0);
    let lowest = positive.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() { lowest.sqrt() / std::f64::consts::TAU } else { 1.0 }
}

/// The same machine in a basis that reaches twice as far, where modes were missed; nothing if it holds all
/// coordinates of the parts already.
///
/// # Errors
/// [`PipelineError`] of coupling.
pub fn wider(
    machine: &Machine,
    superelements: &[Superelement],
    model: &CoupledModel,
) -> Result<Option<CoupledModel>, PipelineError> {
    if model.is_whole() {
        return Ok(None);
    }
    Ok(Some(couple(machine, superelements, BasisOptions::up_to(2.0 * model.frequency))?))
}

/// Largest relative difference of the lowest `reported` elastic frequencies between the fixed basis and
/// the superelements side by side, at both ends and off the stations in the middle of the travel; and the highest
/// of those frequencies (Hz), `None` if the basis has fewer.
///
/// # Errors
/// [`PipelineError::Coupling`] or [`PipelineError::Modal`].
pub fn check_basis(
    machine: &Machine,
    model: &CoupledModel,
    reported: usize,
) -> Result<(f64, Option<f64>), PipelineError> {
    let [from, to] = machine.axis.travel;
    let beside = 0.5 * (from + to) + 0.37 * machine.axis.step * (to - from).signum();
    let middle = beside.clamp(from.min(to), from.max(to));
    let one = |position: &f64| -> Result<(f64, Option<f64>), PipelineError> {
        let modes = modes_at(model, &machine.analysis.damping, *position)?;
        let n = modes.eigenvalues.len();
        let last = (modes.free + reported).min(n);
        // A few more, so that the last one wanted has neighbours to be told from.
        let block = (last + GUARD).min(n);
        let start = model.over_parts(&modes.shapes.columns(0, block).into_owned());
        let exact = model.side_by_side.eigenvalues_near(*position, &start, model.shift())?;
        let difference = |r: usize| ((modes.eigenvalues[r] / exact[r]).sqrt() - 1.0).abs();
        let highest = (last == modes.free + reported && last > 0).then(|| modes.frequency(last - 1));
        Ok(((modes.free..last).map(difference).fold(0.0, f64::max), highest))
    };
    let all = [from, middle, to].par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
    let highest = all.iter().map(|(_, last)| *last).collect::<Option<Vec<f64>>>();
    let error = all.iter().map(|(error, _)| *error).fold(0.0, f64::max);
    Ok((error, highest.map(|all| all.into_iter().fold(0.0, f64::max))))
}

/// Modes beyond the wanted ones that an iteration carries along.
const GUARD: usize = 12;

/// Modes at every position, each counted, and their families.
#[derive(Debug)]
pub struct Solved {
    /// Modes, one a position.
    pub modes: Vec<Modes>,
    /// The inertia counts, one a position.
    pub counts: Vec<ModeCount>,
    /// Families.
    pub families: ModeFamilies,
}

/// Solves the positions in parallel, counts their modes and tracks the `reported` lowest elastic ones.
///
/// # Errors
/// [`PipelineError::Modal`]; a missed mode is an error.
pub fn solve_positions(
    machine: &Machine,
    model: &CoupledModel,
    positions: &[f64],
    reported: usize,
    interrupt: &Interrupt,
    step: Step<'_>,
) -> Result<Solved, PipelineError> {
    let damping = &machine.analysis.damping;
    let (modes, counts) = solve_all(model, damping, positions, reported, interrupt, step)?;
    let families = track(&modes, reported, &|position| modes_at(model, damping, position))?;
    Ok(Solved { modes, counts, families })
}

/// Positions that are solved together where their shapes are not kept.
const BATCH: usize = 64;

/// [`solve_positions`] in the memory of a few: of all but the first position the shapes in the basis are given up once
/// they are tracked (they become empty; those at the ports stay). 12,000 positions of 150 coordinates would hold 2 GB.
///
/// # Errors
/// As [`solve_positions`].
pub fn solve_many_positions(
    machine: &Machine,
    model: &CoupledModel,
    positions: &[f64],
    reported: usize,
    interrupt: &Interrupt,
    step: Step<'_>,
) -> Result<Solved, PipelineError> {
    let damping = &machine.analysis.damping;
    let solve = |position| modes_at(model, damping, position);
    let mut tracker = Tracker::new(reported);
    let mut modes: Vec<Modes> = Vec::with_capacity(positions.len());
    let mut counts = Vec::with_capacity(positions.len());
    let give_up = |modes: &mut Modes| modes.shapes = nalgebra::DMatrix::zeros(0, 0);
    for batch in positions.chunks(BATCH) {
        let (batch, counted) = solve_all(model, damping, batch, reported, interrupt, step)?;
        counts.extend(counted);
        for next in batch {
            tracker.follow(modes.last(), &next, &solve)?;
            if let Some(before) = modes.iter_mut().skip(1).next_back() {
                give_up(before);
            }
            modes.push(next);
        }
    }
    modes.iter_mut().skip(1).for_each(give_up);
    Ok(Solved { modes, counts, families: tracker.finish() })
}

fn solve_all(
    model: &CoupledModel,
    damping: &Damping,
    positions: &[f64],
    reported: usize,
    interrupt: &Interrupt,
    step: Step<'_>,
) -> Result<(Vec<Modes>, Vec<ModeCount>), PipelineError> {
    let one = |&position: &f64| -> Result<(Modes, ModeCount), PipelineError> {
        if interrupt.requested() {
            return Err(PipelineError::Interrupted);
        }
        let modes = modes_at(model, damping, position)?;
        let count = check_count(model, &modes, modes.free + reported)?;
        step();
        Ok((modes, count))
    };
    Ok(positions.par_iter().map(one).collect::<Result<Vec<_>, _>>()?.into_iter().unzip())
}

/// The machine's springs at a position over the nodes of its parts, before any reduction.
///
/// # Errors
/// [`PipelineError::Solid`] for an interface without a surface, [`PipelineError::Coupling`].
pub fn unreduced_springs(machine: &Machine, meshes: &[MeshFile], position: f64) -> Result<Unreduced, PipelineError> {
    let own = machine.parts.iter().zip(meshes).map(|(part, file)| interface_motions(part, &file.mesh));
    let surfaces = own.collect::<Result<Vec<_>, _>>()?;
    let meshes: Vec<_> = meshes.iter().map(|f| &f.mesh).collect();
    Ok(unreduced(machine, &meshes, &surfaces, position)?)
}

/// A machine with its modes at one position.
#[derive(Debug)]
pub struct AtOnePosition {
    /// The modes.
    pub modes: Modes,
    /// Motions of all interfaces of all parts, six rows each, over the elastic modes asked for.
    pub motions: DMatrix<f64>,
    /// Unknowns before the reduction.
    pub n_dof: usize,
}

/// Reduces and couples a machine and finds its lowest `elastic` modes at a position, counted.
///
/// # Errors
/// [`PipelineError`] of the stage that fails.
pub fn at_position(
    machine: &Machine,
    meshes: &[MeshFile],
    cache: Option<&Cache>,
    position: f64,
    elastic: usize,
    interrupt: &Interrupt,
) -> Result<AtOnePosition, PipelineError> {
    let cached = reduce_parts(machine, meshes, cache, interrupt, &|| ())?;
    let superelements: Vec<Superelement> = cached.into_iter().map(|c| c.superelement).collect();
    let highest = machine.analysis.frequencies.iter().copied().fold(1.0, f64::max);
    let mut model = build_model(machine, &superelements, elastic, highest)?.model;
    let modes = loop {
        let modes = modes_at(&model, &machine.analysis.damping, position)?;
        match check_count(&model, &modes, modes.free + elastic) {
            Ok(_) => break modes,
            Err(error) => model = wider(machine, &superelements, &model)?.ok_or(error)?,
        }
    };
    let wanted = elastic.min(modes.eigenvalues.len() - modes.free);
    let shapes = modes.shapes.columns(modes.free, wanted);
    let count = superelements.iter().map(|s| s.interfaces.len()).sum::<usize>();
    let mut motions = DMatrix::zeros(6 * count, wanted);
    let interfaces = superelements.iter().zip(&model.parts).flat_map(|(s, p)| s.interfaces.iter().map(move |i| (i, p)));
    for (k, (interface, part)) in interfaces.enumerate() {
        motions.rows_mut(6 * k, 6).copy_from(&(&interface.rows * (&part.basis * shapes)));
    }
    Ok(AtOnePosition { modes, motions, n_dof: superelements.iter().map(|s| s.n_dof).sum() })
}

/// The machine at a position with all its joints' interfaces distributing, and with all of them rigid.
///
/// # Errors
/// [`PipelineError`]; a node that two rigid interfaces would carry is one.
pub fn interface_band(
    machine: &Machine,
    position: f64,
    elastic: usize,
    cache: Option<&Cache>,
    interrupt: &Interrupt,
) -> Result<[AtOnePosition; 2], PipelineError> {
    let meshes = read_meshes(machine)?;
    let own = machine.parts.iter().zip(&meshes).map(|(part, file)| interface_motions(part, &file.mesh));
    let own = own.map(|motions| Ok(motions?.iter().map(|(_, m)| m.centroid).collect()));
    let centroids = own.collect::<Result<Vec<Vec<[f64; 3]>>, SolidError>>()?;
    check_travel(machine, &meshes, &centroids)?;
    let one = |coupling| {
        let fixed = at_fixed_position(machine, &centroids, position, coupling)?;
        // Parts given by matrices form their interfaces as they are read, which must be the same machine again.
        let again = fixed.parts.iter().any(|p| p.matrices.is_some()).then(|| read_meshes(&fixed)).transpose()?;
        if let Some(again) = &again {
            inputs(machine, &meshes)?.extend(&inputs_of(again)?)?;
        }
        let meshes = again.as_ref().unwrap_or(&meshes);
        at_position(&fixed, meshes, cache, position, elastic, interrupt)
    };
    Ok([one(SurfaceCoupling::Distributing)?, one(SurfaceCoupling::Rigid)?])
}

/// What the user should know about the cache.
pub fn cache_warnings(parts: &[Cached]) -> Vec<String> {
    parts.iter().flat_map(|p| p.warnings.iter().map(CacheError::to_string)).collect()
}
