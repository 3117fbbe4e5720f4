//! What does not change from design to design: parts reduced once, positions prepared once.

use super::memory::admit_positions;
use super::{Design, PartScale, Study, SweepError};
use crate::coupling::{Around, BasisOptions, CoupledModel, couple};
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, multiply_transposed};
use crate::machine::{Joint, Machine, SpringStiffness};
use crate::modal::{Modes, modes_at, track};
use crate::reduction::Superelement;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// How much of the machine designs keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// What the frequency asks for.
    Needed,
    /// The whole fixed basis.
    FixedBasis,
    /// All coordinates of the parts. Then no number hangs on how many are kept, which changes with a part's material, and
    /// small differences between designs have no steps.
    All,
}

/// What a sweep asks of each design.
#[derive(Clone, Debug)]
pub struct Request {
    /// Positions, m.
    pub positions: Vec<f64>,
    /// Frequency grid on which extrema are searched before they are refined, Hz, ascending.
    pub frequencies: Vec<f64>,
    /// Families of the nominal machine whose eigenfrequencies are wanted, 1-based.
    pub families: Vec<usize>,
    /// The machine is reduced to answer up to this frequency, Hz, or to its families' where they lie above.
    pub highest: f64,
    /// How much of the machine designs keep.
    pub kept: Kept,
    /// Elastic modes that are tracked over the positions to name the families.
    pub tracked: usize,
}

impl Request {
    /// What a study asks of each design, which keeps what the study's band asks for.
    pub fn of(study: &Study) -> Self {
        Self {
            positions: study.positions.clone(),
            frequencies: study.frequencies(),
            families: study.families.clone(),
            highest: study.band[1],
            kept: Kept::Needed,
            tracked: study.families.iter().copied().max().unwrap_or(0),
        }
    }

    /// The fixed basis where answers reach up to a frequency, Hz.
    fn basis(&self, frequency: f64) -> BasisOptions {
        let options = BasisOptions::up_to(frequency);
        BasisOptions { band: if self.kept == Kept::All { f64::INFINITY } else { options.band }, ..options }
    }
}

/// The machine at every position around its nominal design.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// The nominal machine, coupled.
    pub model: CoupledModel,
    /// One a position.
    pub around: Vec<Around>,
    /// `[position][family]`: the nominal family's shape in the coordinates around the base; `None`
    /// where tracking lost the family.
    pub families: Vec<Vec<Option<DVector<f64>>>>,
    /// `[position][family]`: the same in the fixed basis.
    shapes: Vec<Vec<Option<DVector<f64>>>>,
    /// Answers reach up to this frequency, Hz.
    reach: f64,
}

impl Prepared {
    /// Couples the nominal machine and prepares every position for designs that change the springs by
    /// which `probes` differ from it.
    ///
    /// # Errors
    /// [`SweepError`] of coupling, modes or tracking.
    pub fn new(
        machine: &Machine,
        superelements: &[Superelement],
        request: &Request,
        probes: &[Design],
        interrupt: &Interrupt,
    ) -> Result<Self, SweepError> {
        let options = request.basis(request.highest);
        let mut model = couple(machine, superelements, options)?;
        let reach = reach(&model, machine, request)?;
        let stiffest = stiffest(&model, machine, probes, &request.positions)?;
        if reach > request.highest || stiffest > options.stiffest {
            let stiffest = stiffest.max(options.stiffest);
            model = couple(machine, superelements, BasisOptions { stiffest, ..request.basis(reach) })?;
        }
        let varied = varied_springs(machine, probes);
        let prepare = |positions: &[f64]| around_all(&model, machine, request, positions, reach, &varied, interrupt);
        let (first, others) = request.positions.split_at(request.positions.len().min(1));
        // One says how much memory all of them take.
        let mut around = prepare(first)?;
        for one in &around {
            admit_positions(one, request.positions.len(), (&model, !request.families.is_empty()), probes)?;
        }
        let shapes = nominal_shapes(&model, machine, request)?;
        around.extend(prepare(others)?);
        let families =
            around.iter().zip(&shapes).map(|(around, shapes)| in_coordinates(around, shapes, None)).collect();
        Ok(Self { model, around, families, shapes, reach })
    }

    /// The same with scaled parts or another base design, its families followed from those of `self`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn scaled(
        &self,
        machine: &Machine,
        superelements: &[Superelement],
        scales: &[PartScale],
        request: &Request,
        interrupt: &Interrupt,
    ) -> Result<Self, SweepError> {
        let scaled: Vec<Superelement> =
            superelements.iter().zip(scales).map(|(s, scale)| s.scaled(scale.young, scale.density)).collect();
        let options = BasisOptions { stiffest: self.model.stiffest, ..request.basis(self.reach) };
        let model = couple(machine, &scaled, options)?;
        let varied = self.around.first().map(|a| a.varied.clone()).unwrap_or_default();
        let around = around_all(&model, machine, request, &request.positions, self.reach, &varied, interrupt)?;
        // Both bases stand over the mass-normalised coordinates of the same superelements.
        let mut crossed = DMatrix::zeros(model.n(), self.model.n());
        for (own, other) in self.model.parts.iter().zip(&model.parts) {
            crossed += multiply_transposed(&other.basis, &own.basis);
        }
        let shapes = self.shapes.clone();
        let families =
            around.iter().zip(&shapes).map(|(around, shapes)| in_coordinates(around, shapes, Some(&crossed))).collect();
        Ok(Self { model, around, families, shapes, reach: self.reach })
    }
}

/// The machine at positions around its own design.
fn around_all(
    model: &CoupledModel,
    machine: &Machine,
    request: &Request,
    positions: &[f64],
    reach: f64,
    varied: &[usize],
    interrupt: &Interrupt,
) -> Result<Vec<Around>, SweepError> {
    let reach = if request.kept == Kept::Needed { reach } else { f64::INFINITY };
    let one = |&position: &f64| -> Result<Around, SweepError> {
        if interrupt.requested() {
            return Err(SweepError::Interrupted);
        }
        let base = model.spring_values(machine, position)?.stiffness;
        Ok(model.around(&model.at(position)?, &base, varied, reach)?)
    };
    positions.par_iter().map(one).collect()
}

/// Shapes in a fixed basis, its own or one that `crossed` brings there, as shapes in the coordinates around a base.
fn in_coordinates(
    around: &Around,
    shapes: &[Option<DVector<f64>>],
    crossed: Option<&DMatrix<f64>>,
) -> Vec<Option<DVector<f64>>> {
    let one = |shape: &DVector<f64>| {
        let column = DMatrix::from_column_slice(shape.len(), 1, shape.as_slice());
        let here = crossed.map_or_else(|| column.clone(), |c| multiply(c, &column));
        multiply_transposed(&around.basis, &here).column(0).into_owned()
    };
    shapes.iter().map(|shape| shape.as_ref().map(one)).collect()
}

/// The frequency that answers reach up to: the request's, or that of the tracked modes where families lie above, Hz.
///
/// Frequencies move by some 10 % over a travel, and a design moves them further; a quarter is added.
fn reach(model: &CoupledModel, machine: &Machine, request: &Request) -> Result<f64, SweepError> {
    let (Some(&position), false) = (request.positions.first(), request.families.is_empty()) else {
        return Ok(request.highest);
    };
    let modes = modes_at(model, &machine.analysis.damping, position)?;
    let last = (modes.free + request.tracked).min(modes.eigenvalues.len()) - 1;
    Ok(request.highest.max(1.25 * modes.frequency(last)))
}

/// `[position][family]`: shapes of the families that were asked for, in the fixed basis.
fn nominal_shapes(
    model: &CoupledModel,
    machine: &Machine,
    request: &Request,
) -> Result<Vec<Vec<Option<DVector<f64>>>>, SweepError> {
    if request.families.is_empty() {
        return Ok(vec![Vec::new(); request.positions.len()]);
    }
    let damping = &machine.analysis.damping;
    let solve = |position: f64| modes_at(model, damping, position);
    let modes = request.positions.par_iter().map(|&p| solve(p)).collect::<Result<Vec<Modes>, _>>()?;
    let tracked = track(&modes, request.tracked, &solve)?;
    let shapes = modes.iter().zip(&tracked.modes).map(|(modes, tracked)| {
        let of = |family: &usize| {
            let mode = tracked.iter().find(|m| m.family == *family)?;
            Some(modes.shapes.column(mode.rank - 1).into_owned())
        };
        request.families.iter().map(of).collect()
    });
    Ok(shapes.collect())
}

/// The largest factor by which a probe stiffens a spring.
fn stiffest(model: &CoupledModel, machine: &Machine, probes: &[Design], positions: &[f64]) -> Result<f64, SweepError> {
    let mut largest: f64 = 1.0;
    for &position in positions {
        let base = model.spring_values(machine, position)?.stiffness;
        for probe in probes {
            // A probe that cannot be coupled here is a design that says so itself.
            let Ok(values) = model.spring_values(&probe.machine, position) else { continue };
            let ratios = values.stiffness.iter().zip(&base).filter(|(_, base)| **base > 0.0).map(|(k, base)| k / base);
            largest = ratios.fold(largest, f64::max);
        }
    }
    Ok(largest)
}

/// Springs, numbered through all joints, whose stiffness a probe changes or that dissipate.
pub fn varied_springs(machine: &Machine, probes: &[Design]) -> Vec<usize> {
    let springs = |m: &Machine| -> Vec<(SpringStiffness, bool)> {
        let of = |j: &Joint| {
            j.springs.iter().map(|s| (s.stiffness, s.damping > 0.0 || j.loss_factor > Some(0.0))).collect::<Vec<_>>()
        };
        m.joints.iter().flat_map(of).collect()
    };
    let nominal = springs(machine);
    let probes: Vec<_> = probes.iter().map(|p| springs(&p.machine)).collect();
    let varies = |s: &usize| nominal[*s].1 || probes.iter().any(|p| p[*s] != nominal[*s]);
    (0..nominal.len()).filter(varies).collect()
}
