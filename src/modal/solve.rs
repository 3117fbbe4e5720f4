//! Modes of the coupled machine at one position.

use super::dissipation::{Dissipation, PartLosses, direct_rows, project, uncoupled};
use super::{ModalError, free_motion};
use crate::coupling::{Around, CoupledEigen, CoupledModel, SpringValues};
use crate::linalg::{multiply, multiply_transposed};
use crate::machine::Damping;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// All modes of the machine in its fixed basis at one position.
#[derive(Clone, Debug)]
pub struct Modes {
    /// Position, m.
    pub position: f64,
    /// omega_r^2, (rad/s)^2, ascending; exactly 0 for free motions. As many as the basis has coordinates.
    pub eigenvalues: Vec<f64>,
    /// Free motions at 0 Hz, the first modes.
    pub free: usize,
    /// Viscous damping ratio of each mode, dampers projected on it; 0 for free motions.
    pub damping_ratios: Vec<f64>,
    /// Structural loss factor of each mode, those of joints and parts projected on it.
    pub loss_factors: Vec<f64>,
    /// What couples the modes, where anything does and it is to be exact.
    pub dissipation: Option<Dissipation>,
    /// Mass-normalised shapes over the coordinates they were solved in, n x n.
    pub shapes: DMatrix<f64>,
    /// Shapes at the outputs, n_output x n, kg^(-1/2).
    pub outputs: DMatrix<f64>,
    /// Shapes at the inputs, n_input x n, kg^(-1/2).
    pub inputs: DMatrix<f64>,
    /// Static compliance that no mode of the basis carries, n_output x n_input, m/N.
    pub direct: DMatrix<f64>,
    /// Structural loss factor of that static compliance: the whole machine's.
    pub direct_loss_factor: f64,
}

/// Share of the largest elastic mode's port motion above which a port feels a free motion.
const FELT: f64 = 1e-6;

/// A motion that nothing resists.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeMotion {
    /// What moves and how, such as `spindle turns about z`.
    pub name: String,
    /// Largest displacement of an output per unit modal amplitude, kg^(-1/2).
    pub at_outputs: f64,
}

impl Modes {
    /// Natural frequency of mode r, Hz.
    pub fn frequency(&self, r: usize) -> f64 {
        self.eigenvalues[r].max(0.0).sqrt() / TAU
    }

    /// Modes at or below a frequency (Hz), free motions included.
    pub fn count_up_to(&self, frequency: f64) -> usize {
        let limit = (TAU * frequency).powi(2);
        self.eigenvalues.iter().take_while(|l| **l <= limit).count()
    }

    /// Whether a mode moves both an output and an input by more than rounding: a free motion that it
    /// does not (a spindle that turns about its axis, for a force through that axis) is left out of sums.
    ///
    /// The bound is 1e-6 of what the softest elastic mode moves.
    pub fn is_felt(&self, r: usize) -> bool {
        let product = |r: usize| self.outputs.column(r).norm() * self.inputs.column(r).norm();
        let elastic = (self.free..self.eigenvalues.len()).map(product).fold(0.0, f64::max);
        product(r) > FELT * elastic
    }

    /// What the free motions are.
    pub fn free_motions(&self, model: &CoupledModel) -> Vec<FreeMotion> {
        (0..self.free)
            .map(|r| FreeMotion {
                name: free_motion::describe(model, &self.shapes.column(r).into_owned()),
                at_outputs: self.outputs.column(r).amax(),
            })
            .collect()
    }
}

/// Modes at a position: the dense f64 eigenproblem of the machine in its fixed basis.
///
/// # Errors
/// [`ModalError`].
///
/// # Accuracy
/// That of [`CoupledModel::eigen`].
pub fn modes_at(model: &CoupledModel, damping: &Damping, position: f64) -> Result<Modes, ModalError> {
    let at = model.at(position)?;
    let springs = model.springs(position)?;
    let coupled = model.coupled(&at, &springs.stiffness)?;
    let eigen =
        model.eigen(&at, &coupled, &springs.stiffness).map_err(|source| ModalError::Eigen { position, source })?;
    let mut parts = Vec::new();
    if model.parts.iter().any(|part| part.loss_factor.is_some()) {
        let rows = at.residual.nrows();
        let tension = multiply(&coupled.forces, &eigen.vectors).resize_vertically(rows, 0.0);
        let loads = beside(&-tension, &model.loads_in_place(&at, &springs.stiffness)?);
        let motion = eigen.vectors.clone().resize_horizontally(eigen.vectors.ncols() + rows, 0.0);
        for (part, residual) in model.parts.iter().zip(&at.residual_of_part) {
            if let (Some(eta), Some(k), Some(c)) = (part.loss_factor, &part.stiffness, residual) {
                parts.push((eta, c.strain_energy(k, &motion, &loads)));
            }
        }
    }
    let residual = springs.dissipate().then(|| model.residual_in_place(&at, &springs.stiffness)).transpose()?;
    let rows = Rows {
        outputs: &coupled.outputs,
        inputs: &coupled.inputs,
        direct: coupled.direct,
        elongations: &coupled.elongations,
        residual,
        parts,
        reach: PARTS_REACH * model.frequency,
    };
    rows.modes(position, damping, &springs, eigen)
}

/// Modes of a design at a position around its base, in that base's coordinates: the k-th entry of a
/// shape is its share of the base's k-th mode.
///
/// `part_losses` are the design's loss factors of the parts; a part that had none in the base has none.
///
/// # Errors
/// As [`modes_at`].
///
/// # Accuracy
/// That of [`crate::coupling::CoupledModel::around`].
pub fn modes_around(
    around: &Around,
    damping: &Damping,
    springs: &SpringValues,
    part_losses: &[Option<f64>],
) -> Result<Modes, ModalError> {
    let position = around.position;
    let design = around.coupled(&springs.stiffness)?;
    let eigen = around.eigen(&design).map_err(|source| ModalError::Eigen { position, source })?;
    let elongations = around.elongations(&design);
    let mut parts = Vec::new();
    // Coordinates and loads of the base, for the design's modes and then unit loads.
    let rows = around.residual.nrows();
    let of_modes = |coordinates: &DMatrix<f64>| {
        let own = multiply(&coordinates.columns(0, eigen.vectors.nrows()).into_owned(), &eigen.vectors);
        beside(&own, &coordinates.columns_range(eigen.vectors.nrows()..).into_owned())
    };
    let lossy = around.strain_energy.iter().any(Option::is_some);
    let state = lossy.then(|| {
        let m = around.n();
        let coordinates = eigen.vectors.clone().resize_horizontally(m + rows, 0.0);
        stacked(&coordinates, &of_modes(&around.loads_of(&design)))
    });
    let state = state.unwrap_or_else(|| DMatrix::zeros(0, 0));
    for (form, eta) in around.strain_energy.iter().zip(part_losses) {
        if let (Some(form), Some(eta)) = (form, eta) {
            let energy = multiply_transposed(&state, &multiply(form, &state));
            parts.push((*eta, 0.5 * (&energy + energy.transpose())));
        }
    }
    let residual = springs.dissipate().then(|| around.residual_of(&design));
    let rows = Rows {
        outputs: &design.outputs,
        inputs: &design.inputs,
        direct: design.direct,
        elongations: &elongations,
        residual,
        parts,
        reach: PARTS_REACH * around.frequency,
    };
    rows.modes(position, damping, springs, eigen)
}

/// The base's own modes: coordinates that carry inertia above the band count as modes too.
///
/// `springs` are the dampers and loss factors to project on them, with the base's stiffness.
///
/// # Errors
/// [`ModalError::Negative`].
pub fn base_modes(
    around: &Around,
    damping: &Damping,
    springs: &SpringValues,
    part_losses: &[Option<f64>],
) -> Result<Modes, ModalError> {
    let (m, s, o) = (around.n(), around.springs.nrows(), around.outputs.nrows());
    let energies = around.strain_energy.iter().zip(part_losses).filter_map(|(form, eta)| {
        let (form, eta) = (form.as_ref()?, (*eta)?);
        Some((eta, form.clone()))
    });
    let rows = Rows {
        outputs: &around.outputs,
        inputs: &around.inputs,
        direct: around.residual.view((s, s + o), (o, around.inputs.nrows())).into_owned(),
        elongations: &around.springs,
        residual: springs.dissipate().then(|| around.residual.clone()),
        parts: energies.collect(),
        reach: f64::INFINITY,
    };
    let eigen =
        CoupledEigen { values: around.eigenvalues.clone(), vectors: DMatrix::identity(m, m), free: around.free };
    rows.modes(around.position, damping, springs, eigen)
}

/// What modes need of the coordinates they were solved in.
struct Rows<'a> {
    outputs: &'a DMatrix<f64>,
    inputs: &'a DMatrix<f64>,
    direct: DMatrix<f64>,
    /// Elongations of all springs, n_springs x n.
    elongations: &'a DMatrix<f64>,
    /// Compliance that no coordinate carries between springs, outputs and inputs, m/N, if a spring dissipates.
    residual: Option<DMatrix<f64>>,
    /// Loss factor of each part that has one, and its stiffness between the modes and unit loads on springs, outputs and
    /// inputs.
    parts: Vec<(f64, DMatrix<f64>)>,
    /// Parts couple the modes up to this frequency, Hz.
    reach: f64,
}

/// Parts with loss factors couple the modes up to this multiple of the frequency that the basis was made for; maps sum
/// those up to twice their highest frequency one by one.
const PARTS_REACH: f64 = 2.0;

impl Rows<'_> {
    fn modes(
        self,
        position: f64,
        damping: &Damping,
        springs: &SpringValues,
        eigen: CoupledEigen,
    ) -> Result<Modes, ModalError> {
        let free = eigen.free;
        let eigenvalues = settled(&eigen, position)?;
        let elongations = springs.dissipate().then(|| multiply(self.elongations, &eigen.vectors));
        let (mut damping_ratios, mut loss_factors) = uncoupled(damping, &eigenvalues, free);
        let (outputs, inputs) = (multiply(self.outputs, &eigen.vectors), multiply(self.inputs, &eigen.vectors));
        let dissipation = (!damping.projected).then(|| {
            let whole = (&damping_ratios[..], &loss_factors[..]);
            self.dissipation(springs, elongations.as_ref(), (&outputs, &inputs), &eigenvalues, free, whole)
        });
        let own = (&mut damping_ratios[..], &mut loss_factors[..]);
        project(springs, elongations.as_ref(), &self.parts, &eigenvalues, free, own);
        Ok(Modes {
            position,
            free,
            damping_ratios,
            loss_factors,
            dissipation: dissipation.flatten(),
            outputs,
            inputs,
            direct: self.direct,
            direct_loss_factor: damping.loss_factor,
            shapes: eigen.vectors,
            eigenvalues,
        })
    }

    /// What couples the modes; `None` where nothing does.
    fn dissipation(
        &self,
        springs: &SpringValues,
        elongations: Option<&DMatrix<f64>>,
        (outputs, inputs): (&DMatrix<f64>, &DMatrix<f64>),
        eigenvalues: &[f64],
        free: usize,
        (ratios, losses): (&[f64], &[f64]),
    ) -> Option<Dissipation> {
        let chosen = springs.dissipating();
        let lossy = self.parts.iter().any(|(eta, _)| *eta > 0.0);
        if chosen.is_empty() && !lossy {
            return None;
        }
        let (n, n_springs) = (eigenvalues.len(), self.elongations.nrows());
        let mut loss_factors = losses.to_vec();
        let (rows, columns) = direct_rows(&chosen, n_springs, self.outputs.nrows(), self.inputs.nrows());
        let springs_at = |s: usize, k: usize| elongations.map_or(0.0, |e| e[(chosen[s], k)]);
        let parts = lossy.then(|| {
            let mut all = DMatrix::zeros(self.parts[0].1.nrows(), self.parts[0].1.ncols());
            self.parts.iter().for_each(|(eta, energy)| all += energy * *eta);
            let edge = (TAU * self.reach).powi(2);
            let coupled = eigenvalues.iter().take_while(|l| **l <= edge).count();
            (coupled.max(free)..n).for_each(|r| loss_factors[r] += all[(r, r)] / eigenvalues[r]);
            let own = |r: usize| Complex::new(eigenvalues[r], eigenvalues[r] * loss_factors[r]).inv();
            // The modes beyond answer statically: their inertia is that of their own terms.
            let beyond: Vec<Complex<f64>> = (coupled..n).map(own).collect();
            let through = |left: &dyn Fn(usize) -> f64, right: &dyn Fn(usize) -> f64| {
                beyond
                    .iter()
                    .enumerate()
                    .map(|(k, c)| c * (left(coupled + k) * right(coupled + k)))
                    .sum::<Complex<f64>>()
            };
            let between_modes = DMatrix::from_fn(coupled, coupled, |r, q| {
                Complex::new(0.0, all[(r, q)]) + through(&|k| all[(r, k)], &|k| all[(k, q)])
            });
            let loads = |of: &[usize], shapes: &DMatrix<f64>| {
                let shape = |i: usize, k: usize| {
                    if i < shapes.nrows() { shapes[(i, k)] } else { springs_at(i - shapes.nrows(), k) }
                };
                DMatrix::from_fn(of.len(), coupled, |i, r| {
                    Complex::new(0.0, all[(n + of[i], r)])
                        + Complex::new(0.0, 1.0) * through(&|k| shape(i, k), &|k| all[(k, r)])
                })
            };
            PartLosses {
                between_modes,
                outputs: loads(&rows, outputs),
                inputs: loads(&columns, inputs),
                direct: DMatrix::from_fn(rows.len(), columns.len(), |i, j| all[(n + rows[i], n + columns[j])]),
            }
        });
        let direct = match &self.residual {
            Some(residual) => DMatrix::from_fn(rows.len(), columns.len(), |i, j| residual[(rows[i], columns[j])]),
            None => self.direct.clone(),
        };
        Some(Dissipation {
            springs: elongations.map_or_else(|| DMatrix::zeros(0, n), |e| e.select_rows(&chosen)),
            direct,
            viscous: chosen.iter().map(|&s| springs.damping[s]).collect(),
            structural: chosen.iter().map(|&s| springs.loss_factors[s] * springs.stiffness[s]).collect(),
            parts,
            damping_ratios: ratios.to_vec(),
            loss_factors,
        })
    }
}

/// Eigenvalues of which those of elastic modes are positive.
fn settled(eigen: &CoupledEigen, position: f64) -> Result<Vec<f64>, ModalError> {
    match eigen.values.iter().skip(eigen.free).find(|l| !l.is_finite() || **l <= 0.0) {
        None => Ok(eigen.values.iter().copied().collect()),
        Some(&eigenvalue) => Err(ModalError::Negative { position, eigenvalue }),
    }
}

fn beside(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = a.clone().resize_horizontally(a.ncols() + b.ncols(), 0.0);
    out.columns_mut(a.ncols(), b.ncols()).copy_from(b);
    out
}

fn stacked(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = a.clone().resize_vertically(a.nrows() + b.nrows(), 0.0);
    out.rows_mut(a.nrows(), b.nrows()).copy_from(b);
    out
}

/// The inertia count at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeCount {
    /// The frequency below which modes were counted, Hz.
    pub below: f64,
    /// Modes found by the eigensolver in the fixed basis, free motions included.
    pub found: usize,
    /// Modes counted by the inertia of the superelements side by side.
    pub counted: usize,
}

/// Two frequencies nearer than this share are one for the count: the basis keeps them to 1e-5.
const NEAR: f64 = 4e-5;

/// Counts the modes below a frequency just above the wanted ones by the inertia of the side-by-side machine,
/// which knows nothing of the fixed basis or of the dense eigensolver.
///
/// The frequency stands in the widest gap between modes `wanted` and `wanted` + 6, no further than the basis
/// was made for: above that its modes are coordinates for the static response, not modes of the machine.
///
/// # Errors
/// [`ModalError::Missed`] if the numbers differ.
pub fn check_count(model: &CoupledModel, modes: &Modes, wanted: usize) -> Result<ModeCount, ModalError> {
    let values = &modes.eigenvalues;
    let Some(end) = values.len().checked_sub(1).filter(|_| modes.free < values.len()) else {
        return Ok(ModeCount { below: 0.0, found: values.len(), counted: values.len() });
    };
    let reach = (TAU * model.frequency).powi(2);
    let first = wanted.min(values.len()).saturating_sub(1).clamp(modes.free.min(end), end);
    let last = (first..=end.min(first + 6)).take_while(|&r| r == first || values[r] <= reach).last().unwrap_or(first);
    let gap = |r: usize| if r < end { values[r + 1] / values[r] } else { 4.0 };
    let below = (first..=last).max_by(|&a, &b| gap(a).total_cmp(&gap(b))).unwrap_or(first);
    let shift = values[below] * (0.5 * (1.0 + gap(below))).min(2.0);
    let counted = model.side_by_side.count_below(modes.position, shift)?;
    // Of a cluster that the gap cannot part, either number is right.
    let found = |edge: f64| values.iter().take_while(|l| **l < edge).count();
    let (least, most) = (found(shift * (1.0 - NEAR)), found(shift * (1.0 + NEAR)));
    let frequency = shift.sqrt() / TAU;
    if (least..=most).contains(&counted) {
        return Ok(ModeCount { below: frequency, found: counted, counted });
    }
    Err(ModalError::Missed { position: modes.position, frequency, found: below + 1, counted })
}
