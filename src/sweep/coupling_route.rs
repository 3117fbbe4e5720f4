//! The coupling route: no eigenproblem a design, but the base's receptances changed by its springs.
//!
//! Joint dampers and loss factors are exact here, and so is one structural loss factor for the whole
//! machine. Viscous modal ratios belong to the base's modes and stay with them, and loss factors of
//! single parts are projected on the base's modes: with either, this route and the modes route are two
//! models of the same damping, not one.

use super::bases::Bases;
use super::device::{BackendUse, SpringBackend};
use super::modes_route::static_compliance;
use super::{Design, Evaluation, Evaluator, Kept, PositionMetrics, Prepared, Request, SweepError};
use crate::coupling::{Around, SpringValues};
use crate::frf::metrics::{Extremum, PairMetrics, direct_pairs_of};
use crate::frf::modification::{BaseMode, BaseReceptance, SpringChange, Work};
use crate::frf::refined_extrema;
use crate::gpu::modification::SpringRequest;
use crate::interrupt::Interrupt;
use crate::machine::{Damping, Machine};
use crate::modal::{Modes, base_modes, modes_around};
use crate::reduction::Superelement;
use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;

/// Designs of a batch: the base's receptances are formed once a batch.
const BATCH: usize = 256;
/// Step of the grid, as a share of half a half-power bandwidth.
const STEP: f64 = 0.45;
/// The finest grid, as half a relative bandwidth.
const SHARPEST: f64 = 2e-4;
/// The grid is fine from this share of the lowest eigenfrequency on.
const SOFTEST: f64 = 0.25;
/// Points of the grid below.
const BELOW: usize = 16;
/// Share of a row's largest entry below which a free motion does not reach it.
const FELT: f64 = 1e-6;

/// Evaluates designs by structural modification of the nominal machine.
#[derive(Debug)]
pub struct CouplingRoute<'a> {
    bases: Bases<'a>,
    pairs: Vec<(usize, usize)>,
    /// How far below the nominal machine's lowest frequency a design's may lie, as a factor: no design is softer than
    /// its softest spring's share, and frequencies go with the root (Rayleigh's quotient).
    softest: f64,
    backend: SpringBackend,
}

impl<'a> CouplingRoute<'a> {
    /// Prepares the positions for designs that differ from the machine as `probes` do.
    ///
    /// # Errors
    /// As [`Prepared::new`]; [`SweepError::NeedsModes`] if families are asked for.
    pub fn new(
        machine: &'a Machine,
        superelements: &'a [Superelement],
        request: Request,
        probes: &[Design],
        interrupt: &'a Interrupt,
    ) -> Result<Self, SweepError> {
        if !request.families.is_empty() {
            return Err(SweepError::NeedsModes);
        }
        let request = Request { kept: Kept::FixedBasis, ..request };
        let bases = Bases::new(machine, superelements, request, probes, interrupt)?;
        let model = &bases.nominal.model;
        let softest = softest(&bases.nominal, probes);
        let pairs = direct_pairs_of(&model.output_names(), &model.input_names());
        let backend = SpringBackend::cpu("no device is asked for");
        Ok(Self { bases, pairs, softest, backend })
    }

    /// The same on another back end; its extrema are the same.
    ///
    /// # Errors
    /// [`SweepError::Device`] if a device is asked for and its kernels have no room for the springs that vary.
    pub fn on(self, backend: SpringBackend) -> Result<Self, SweepError> {
        if let Some(around) = self.prepared().around.first() {
            let inputs = if around.outputs == around.inputs { 0 } else { around.inputs.nrows() };
            backend.fit(around.varied.len(), around.outputs.nrows() + inputs)?;
        }
        Ok(Self { backend, ..self })
    }

    /// The prepared positions.
    pub fn prepared(&self) -> &Prepared {
        &self.bases.nominal
    }

    /// Compliance of a design at a position between (output, input) pairs, `[pair][frequency]`, m/N.
    ///
    /// # Errors
    /// [`SweepError`] of coupling or modes.
    pub fn compliance(
        &self,
        design: &Design,
        index: usize,
        frequencies: &[f64],
        pairs: &[(usize, usize)],
    ) -> Result<Vec<Vec<Complex<f64>>>, SweepError> {
        let prepared = &self.bases.nominal;
        let base = Base::new(&prepared.around[index], design, frequencies)?;
        let values = prepared.model.spring_values(&design.machine, prepared.around[index].position)?;
        let pairs: Vec<(usize, usize)> = pairs.iter().map(|&(i, j)| (i, base.first_input + j)).collect();
        Ok(base.receptance.modified(&base.changes(&values), &pairs, &mut Work::default()))
    }

    fn evaluate_with(&self, prepared: &Prepared, designs: &[&Design]) -> Vec<Result<Evaluation, SweepError>> {
        if self.backend.is_untimed() {
            self.time(prepared, designs);
        }
        let one = |(index, around): (usize, &Around)| -> Vec<Result<PositionMetrics, SweepError>> {
            let mut work = Work::default();
            let mut answers = Vec::with_capacity(designs.len());
            while answers.len() < designs.len() {
                let rest = &designs[answers.len()..];
                match self.base(prepared, around, rest[0]) {
                    Err(error) => answers.push(Err(error)),
                    Ok(base) => {
                        let served = rest.iter().take_while(|design| base.serves(design)).count().max(1);
                        answers.extend(self.answers(index, prepared, &base, &rest[..served], &mut work));
                    }
                }
            }
            answers
        };
        let positions: Vec<_> = prepared.around.par_iter().enumerate().map(one).collect();
        let mut columns: Vec<_> = positions.into_iter().map(Vec::into_iter).collect();
        designs.iter().map(|_| columns.iter_mut().flat_map(Iterator::next).collect()).collect()
    }

    /// The base's receptances at a position with a design's damping.
    fn base<'b>(&self, prepared: &Prepared, around: &'b Around, design: &Design) -> Result<Base<'b>, SweepError> {
        let nominal = prepared.model.spring_values(self.bases.machine, around.position)?;
        Base::new(around, design, &self.grid(around, &nominal, design)?)
    }

    /// Metrics of designs that share a base.
    fn answers(
        &self,
        index: usize,
        prepared: &Prepared,
        base: &Base<'_>,
        designs: &[&Design],
        work: &mut Work,
    ) -> Vec<Result<PositionMetrics, SweepError>> {
        let values: Vec<_> =
            designs.iter().map(|d| prepared.model.spring_values(&d.machine, base.around.position)).collect();
        let changes: Vec<Vec<SpringChange>> = values.iter().flatten().map(|v| base.changes(v)).collect();
        let mut found = match self.extrema(index, base, &changes, work) {
            Ok(found) => found.into_iter(),
            Err(SweepError::Interrupted) => return designs.iter().map(|_| Err(SweepError::Interrupted)).collect(),
            Err(error) => {
                let message = error.to_string();
                return designs.iter().map(|_| Err(SweepError::Device { message: message.clone() })).collect();
            }
        };
        let answers = designs.iter().zip(values).map(|(design, values)| {
            let values = values?;
            let extrema = found.next().expect("extrema of each design that has changes");
            self.metrics(base, design, &values, &extrema, work)
        });
        answers.collect()
    }

    /// Extrema of each design's direct pairs.
    fn extrema(
        &self,
        index: usize,
        base: &Base<'_>,
        changes: &[Vec<SpringChange>],
        work: &mut Work,
    ) -> Result<Vec<Vec<(Extremum, Extremum)>>, SweepError> {
        if self.bases.interrupt.requested() {
            return Err(SweepError::Interrupted);
        }
        let pairs = self.port_pairs(base);
        let request = SpringRequest { base: &base.receptance, designs: changes, pairs: &pairs, position: index };
        if let Some(found) = self.backend.extrema(&request)? {
            return Ok(found);
        }
        let one = |changes: &Vec<SpringChange>| {
            if self.bases.interrupt.requested() {
                return Err(SweepError::Interrupted);
            }
            let responses = base.receptance.modified(changes, &pairs, work);
            Ok(responses.iter().map(|h| refined_extrema(&base.receptance.frequencies, h)).collect())
        };
        changes.iter().map(one).collect()
    }

    /// Times both back ends on a batch at the first position.
    fn time(&self, prepared: &Prepared, designs: &[&Design]) {
        let (Some(around), Some(first)) = (prepared.around.first(), designs.first()) else { return };
        // A base that cannot be had is reported where it is asked for.
        let Ok(base) = self.base(prepared, around, first) else { return };
        let values = designs.iter().flat_map(|d| prepared.model.spring_values(&d.machine, around.position));
        let changes: Vec<Vec<SpringChange>> = values.map(|v| base.changes(&v)).collect();
        let pairs = self.port_pairs(&base);
        self.backend.time(&SpringRequest { base: &base.receptance, designs: &changes, pairs: &pairs, position: 0 });
    }

    fn port_pairs(&self, base: &Base<'_>) -> Vec<(usize, usize)> {
        self.pairs.iter().map(|&(i, j)| (i, base.first_input + j)).collect()
    }

    fn metrics(
        &self,
        base: &Base<'_>,
        design: &Design,
        values: &SpringValues,
        extrema: &[(Extremum, Extremum)],
        work: &mut Work,
    ) -> Result<PositionMetrics, SweepError> {
        let found = self.pairs.iter().zip(extrema).map(|(&(output, input), &(peak, most_negative_real))| PairMetrics {
            output,
            input,
            peak,
            most_negative_real,
        });
        let static_compliance = match &base.at_rest {
            Some(at_rest) => {
                let changes = base.static_changes(values);
                at_rest.modified(&changes, &self.port_pairs(base), work).iter().map(|h| h[0].re).collect()
            }
            None => {
                let losses: Vec<Option<f64>> = design.machine.parts.iter().map(|p| p.loss_factor).collect();
                let modes = modes_around(base.around, &design.machine.analysis.damping, values, &losses)?;
                self.pairs.iter().map(|&(i, j)| static_compliance(&modes, i, j)).collect()
            }
        };
        Ok(PositionMetrics { pairs: found.collect(), static_compliance, families: Vec::new() })
    }

    /// A grid over the request's band with steps of half a half-power bandwidth.
    fn grid(&self, around: &Around, nominal: &SpringValues, design: &Design) -> Result<Vec<f64>, SweepError> {
        let frequencies = &self.bases.request.frequencies;
        let (first, last) = (frequencies[0], frequencies[frequencies.len() - 1]);
        let losses: Vec<Option<f64>> = design.machine.parts.iter().map(|p| p.loss_factor).collect();
        let modes = base_modes(around, &design.machine.analysis.damping, nominal, &losses)?;
        let in_band = modes.free..modes.count_up_to(1.5 * last).max(modes.free + 1).min(modes.eigenvalues.len());
        // Where the whole machine has a loss factor, a design may have no more than that: joints dissipate less of a
        // mode the less they move in it.
        let nominal =
            in_band.map(|r| modes.damping_ratios[r] + 0.5 * modes.loss_factors[r]).fold(f64::INFINITY, f64::min);
        let own = 0.5 * design.machine.analysis.damping.loss_factor;
        let half = if own > 0.0 { nominal.min(own) } else { nominal };
        if half < SHARPEST {
            let what = format!("half the relative bandwidth of a mode at position {} m", around.position);
            return Err(SweepError::Value { what, seen: half, allowed: "2e-4 or more; use the modes route" });
        }
        let fine = (SOFTEST * self.softest * modes.frequency(modes.free)).clamp(first, last);
        let mut grid: Vec<f64> = (0..BELOW).map(|k| first + (fine - first) * k as f64 / BELOW as f64).collect();
        let steps = ((last / fine).ln() / (STEP * half).ln_1p()).ceil().max(1.0) as usize;
        grid.extend((0..=steps).map(|k| fine * (last / fine).powf(k as f64 / steps as f64)));
        grid.dedup_by(|b, a| *b <= *a);
        Ok(grid)
    }
}

impl Evaluator for CouplingRoute<'_> {
    fn route(&self) -> &'static str {
        "coupling"
    }

    fn positions(&self) -> &[f64] {
        &self.bases.request.positions
    }

    fn batch(&self) -> usize {
        BATCH
    }

    fn backend(&self) -> BackendUse {
        self.backend.used()
    }

    fn evaluate(&self, designs: &[Design]) -> Vec<Result<Evaluation, SweepError>> {
        self.bases.answer(designs, |prepared, members| self.evaluate_with(prepared, members))
    }
}

/// The base's receptances at one position, for all designs with the same damping.
struct Base<'a> {
    around: &'a Around,
    receptance: BaseReceptance,
    /// At 0 Hz without damping; `None` where a free motion is felt.
    at_rest: Option<BaseReceptance>,
    /// Place of the first input among the ports: 0 where inputs are the outputs.
    first_input: usize,
    damping: Damping,
    part_losses: Vec<Option<f64>>,
}

impl<'a> Base<'a> {
    fn new(around: &'a Around, design: &Design, frequencies: &[f64]) -> Result<Self, SweepError> {
        let damping = design.machine.analysis.damping.clone();
        let part_losses: Vec<Option<f64>> = design.machine.parts.iter().map(|p| p.loss_factor).collect();
        let modes = base_modes(around, &damping, &SpringValues::default(), &part_losses)?;
        let (s, outputs) = (around.springs.nrows(), around.outputs.nrows());
        let same = around.outputs == around.inputs;
        let first_input = if same { 0 } else { outputs };
        let ports = s..if same { s + outputs } else { around.residual.nrows() };
        let order: Vec<usize> = around.varied.iter().copied().chain(ports).collect();
        let all = [&around.springs, &around.outputs, &around.inputs];
        let all = DMatrix::from_rows(&all.iter().flat_map(|m| m.row_iter()).collect::<Vec<_>>());
        let rows = all.select_rows(&order);
        let felt: Vec<bool> = (0..modes.free).map(|r| is_felt(&rows, r)).collect();
        let kept: Vec<usize> = (0..modes.eigenvalues.len()).filter(|&r| r >= modes.free || felt[r]).collect();
        let rows = rows.select_columns(&kept);
        let base_mode = |damped: bool| {
            let one = move |modes: &Modes, r: usize| BaseMode {
                frequency: modes.frequency(r),
                damping_ratio: if damped { modes.damping_ratios[r] } else { 0.0 },
                loss_factor: if damped { modes.loss_factors[r] } else { 0.0 },
            };
            kept.iter().map(|&r| one(&modes, r)).collect::<Vec<_>>()
        };
        let left = DMatrix::from_fn(order.len(), order.len(), |a, b| around.residual[(order[a], order[b])]);
        let residual = |eta: f64| left.map(|c| c / Complex::new(1.0, eta));
        let springs = around.varied.len();
        let receptance =
            BaseReceptance::new(frequencies, &base_mode(true), &rows, &residual(damping.loss_factor), springs);
        let at_rest = (!felt.contains(&true))
            .then(|| BaseReceptance::new(&[0.0], &base_mode(false), &rows, &residual(0.0), springs));
        Ok(Self { around, receptance, at_rest, first_input, damping, part_losses })
    }

    fn serves(&self, design: &Design) -> bool {
        let machine = &design.machine;
        self.damping == machine.analysis.damping
            && self.part_losses.iter().eq(machine.parts.iter().map(|p| &p.loss_factor))
    }

    /// k (1 + j (eta + eta_joint)) - k0 (1 + j eta), and the damper.
    fn changes(&self, values: &SpringValues) -> Vec<SpringChange> {
        let eta = self.damping.loss_factor;
        let one = |&s: &usize| {
            let (k, base) = (values.stiffness[s], self.around.base[s]);
            let stiffness = Complex::new(k - base, k * (eta + values.loss_factors[s]) - base * eta);
            SpringChange { stiffness, damping: values.damping[s] }
        };
        self.around.varied.iter().map(one).collect()
    }

    fn static_changes(&self, values: &SpringValues) -> Vec<SpringChange> {
        let one = |&s: &usize| SpringChange {
            stiffness: Complex::new(values.stiffness[s] - self.around.base[s], 0.0),
            damping: 0.0,
        };
        self.around.varied.iter().map(one).collect()
    }
}

/// The root of the smallest share that a probe leaves of a spring's stiffness, at most 1.
fn softest(prepared: &Prepared, probes: &[Design]) -> f64 {
    let mut smallest: f64 = 1.0;
    for around in &prepared.around {
        for probe in probes {
            // A probe that cannot be coupled here is a design that says so itself.
            let Ok(values) = prepared.model.spring_values(&probe.machine, around.position) else { continue };
            let shares = values.stiffness.iter().zip(&around.base).filter(|(_, base)| **base > 0.0);
            smallest = shares.map(|(k, base)| k / base).fold(smallest, f64::min);
        }
    }
    smallest.max(1e-12).sqrt()
}

/// Whether any row moves with a mode by more than rounding.
fn is_felt(rows: &DMatrix<f64>, mode: usize) -> bool {
    rows.row_iter().any(|row| row[mode].abs() > FELT * row.amax())
}
