//! What does not change from design to design: parts reduced once, positions prepared once.

use super::{Design, PartScale, SweepError};
use crate::coupling::{Around, BasisOptions, CoupledModel, couple};
use crate::interrupt::Interrupt;
use crate::linalg::{multiply, multiply_transposed};
use crate::machine::{Joint, Machine, SpringStiffness};
use crate::modal::{Modes, modes_at, track};
use crate::reduction::Superelement;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// What a sweep asks of each design.
#[derive(Clone, Debug)]
pub struct Request {
    /// Positions, m.
    pub positions: Vec<f64>,
    /// Frequency grid on which extrema are searched before they are refined, Hz, ascending.
    pub frequencies: Vec<f64>,
    /// Families of the nominal machine whose eigenfrequencies are wanted, 1-based.
    pub families: Vec<usize>,
    /// The machine is reduced to answer up to this frequency, Hz.
    pub highest: f64,
    /// Whether designs keep the whole fixed basis instead of what the frequency asks for.
    pub whole_basis: bool,
    /// Elastic modes that are tracked over the positions to name the families.
    pub tracked: usize,
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
        let options = BasisOptions::up_to(request.highest);
        let mut model = couple(machine, superelements, options)?;
        let stiffest = stiffest(&model, machine, probes, &request.positions)?;
        if stiffest > options.stiffest {
            model = couple(machine, superelements, BasisOptions { stiffest, ..options })?;
        }
        let shapes = nominal_shapes(&model, machine, request)?;
        let varied = varied_springs(machine, probes);
        Self::around_nominal(model, machine, request, &varied, shapes, |model| identity(model.n()), interrupt)
    }

    /// The same with scaled parts, its families followed from those of `self`.
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
        let options = BasisOptions { stiffest: self.model.stiffest, ..BasisOptions::up_to(request.highest) };
        let model = couple(machine, &scaled, options)?;
        let varied = self.around.first().map(|a| a.varied.clone()).unwrap_or_default();
        // Both bases stand over the mass-normalised coordinates of the same superelements.
        let crossed = |model: &CoupledModel| {
            let pairs = self.model.parts.iter().zip(&model.parts);
            pairs.fold(DMatrix::zeros(model.n(), self.model.n()), |sum, (own, other)| {
                sum + multiply_transposed(&other.basis, &own.basis)
            })
        };
        Self::around_nominal(model, machine, request, &varied, self.shapes.clone(), crossed, interrupt)
    }

    fn around_nominal(
        model: CoupledModel,
        machine: &Machine,
        request: &Request,
        varied: &[usize],
        shapes: Vec<Vec<Option<DVector<f64>>>>,
        crossed: impl Fn(&CoupledModel) -> DMatrix<f64>,
        interrupt: &Interrupt,
    ) -> Result<Self, SweepError> {
        let one = |&position: &f64| -> Result<Around, SweepError> {
            if interrupt.requested() {
                return Err(SweepError::Interrupted);
            }
            let base = model.spring_values(machine, position)?.stiffness;
            let reach = if request.whole_basis { f64::INFINITY } else { request.highest };
            Ok(model.around(&model.at(position)?, &base, varied, reach)?)
        };
        let around = request.positions.par_iter().map(one).collect::<Result<Vec<_>, _>>()?;
        let crossed = if request.families.is_empty() { None } else { Some(crossed(&model)) };
        let families = around.iter().zip(&shapes).map(|(around, shapes)| {
            let to_around = |shape: &DVector<f64>| {
                let column = DMatrix::from_column_slice(shape.len(), 1, shape.as_slice());
                let here = crossed.as_ref().map_or_else(|| column.clone(), |c| multiply(c, &column));
                multiply_transposed(&around.basis, &here).column(0).into_owned()
            };
            shapes.iter().map(|shape| shape.as_ref().map(to_around)).collect()
        });
        Ok(Self { families: families.collect(), around, shapes, model })
    }
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
    let solve = |position: f64| modes_at(model, damping, position, request.tracked + 16);
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

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}
