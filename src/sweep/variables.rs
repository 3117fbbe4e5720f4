//! Design variables: what a study changes, over which values.

use super::paths::Target;
use super::{Design, PartScale};
use crate::machine::{Dimension, Machine, ScrewSupport, SpringStiffness};

/// A design variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name, unique in the study.
    pub name: String,
    /// The paths as the machine has them, asterisks resolved.
    pub paths: Vec<String>,
    /// The places that take its value.
    pub targets: Vec<Target>,
    /// Whether its values multiply the machine's own instead of taking their place.
    pub factor: bool,
    /// What its values measure; a ratio for factors, `None` for names of supports.
    pub dimension: Option<Dimension>,
    /// The values it may take.
    pub domain: Domain,
    /// The machine's own value, if there is one and the same for all places: 1 for factors.
    pub nominal: Option<f64>,
    /// Distance between a screw's supports, m, where the machine holds the screw at one end.
    pub(super) span: Option<f64>,
}

/// The values a variable may take, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// All values between two.
    Range {
        /// Smallest.
        from: f64,
        /// Largest.
        to: f64,
        /// Whether equal steps are equal ratios.
        logarithmic: bool,
        /// Values on a full grid.
        points: Option<usize>,
    },
    /// A list.
    Values(Vec<f64>),
}

/// Names of the supports, by the number that stands for each in a design's values.
pub(super) const SUPPORTS: [&str; 2] = ["one-end", "both-ends"];

impl Variable {
    /// Values on a full grid, if the study says how many.
    pub fn grid_points(&self) -> Option<usize> {
        match &self.domain {
            Domain::Range { points, .. } => *points,
            Domain::Values(values) => Some(values.len()),
        }
    }

    /// The value at a place from 0 to 1 of its domain; a list is divided into equal shares.
    ///
    /// Values inside a range are rounded to ten digits, so that they are the same on every platform.
    pub fn at(&self, place: f64) -> f64 {
        match &self.domain {
            Domain::Values(values) => {
                let last = values.len() - 1;
                values[((place * values.len() as f64) as usize).min(last)]
            }
            Domain::Range { from, .. } if place <= 0.0 => *from,
            Domain::Range { to, .. } if place >= 1.0 => *to,
            Domain::Range { from, to, logarithmic, .. } => {
                let value = if *logarithmic { from * (to / from).powf(place) } else { from + place * (to - from) };
                round_to_ten_digits(value).clamp(*from, *to)
            }
        }
    }

    /// The place from 0 to 1 of a value in its domain, as [`Variable::at`] takes it; the middle of its share in a list.
    pub fn place(&self, value: f64) -> f64 {
        match &self.domain {
            Domain::Values(values) => {
                let nearest = |a: &usize, b: &usize| (values[*a] - value).abs().total_cmp(&(values[*b] - value).abs());
                (0..values.len()).min_by(nearest).map_or(0.5, |i| (i as f64 + 0.5) / values.len() as f64)
            }
            Domain::Range { from, to, logarithmic: true, .. } => {
                ((value / from).ln() / (to / from).ln()).clamp(0.0, 1.0)
            }
            Domain::Range { from, to, .. } => ((value - from) / (to - from)).clamp(0.0, 1.0),
        }
    }

    /// Its unit, empty for a plain number or a name.
    pub fn unit(&self) -> &'static str {
        match self.dimension {
            None | Some(Dimension::Ratio) => "",
            Some(dimension) => dimension.units()[0],
        }
    }

    /// A value as tables write it.
    pub fn text(&self, value: f64) -> String {
        if self.dimension.is_none() {
            SUPPORTS[usize::from(value > 0.5)].to_owned()
        } else {
            super::table::number(value)
        }
    }

    /// The value that a table's text stands for.
    pub fn read(&self, text: &str) -> Option<f64> {
        if self.is_name() {
            SUPPORTS.iter().position(|support| *support == text).map(|i| i as f64)
        } else {
            text.parse().ok().filter(|value: &f64| value.is_finite())
        }
    }

    /// Whether its values have no order: names of supports.
    pub fn is_name(&self) -> bool {
        self.dimension.is_none()
    }
}

fn round_to_ten_digits(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// The design with the given value of each variable; values and variables go in step.
///
/// What cannot be, such as a screw whose nut lies beyond its support, is found where the design is coupled.
pub fn design(machine: &Machine, variables: &[Variable], values: &[f64]) -> Design {
    assert_eq!(variables.len(), values.len(), "one value a variable");
    let mut design = Design::nominal(machine);
    let mut pairs: Vec<(&Variable, f64)> = variables.iter().zip(values.iter().copied()).collect();
    // Which ends are held comes before the distance between them.
    pairs.sort_by_key(|(variable, _)| !variable.is_name());
    for (variable, value) in pairs {
        for &target in &variable.targets {
            apply(&mut design, machine, variable, target, value);
        }
    }
    design
}

fn apply(design: &mut Design, nominal: &Machine, variable: &Variable, target: Target, value: f64) {
    let joints = &mut design.machine.joints;
    let to = |old: f64| if variable.factor { old * value } else { value };
    match target {
        Target::Stiffness(j, s) => {
            if let SpringStiffness::Constant(k) = &mut joints[j].springs[s].stiffness {
                *k = to(*k);
            }
        }
        Target::Damper(j, s) => joints[j].springs[s].damping = to(joints[j].springs[s].damping),
        Target::JointLoss(j) => joints[j].loss_factor = Some(to(joints[j].loss_factor.unwrap_or(0.0))),
        Target::Diameter(j) | Target::ScrewYoung(j) | Target::FreeLength(j) | Target::Span(j) | Target::Support(j) => {
            for spring in &mut joints[j].springs {
                let SpringStiffness::BallScrew { young, diameter, free_length, support } = &mut spring.stiffness else {
                    continue;
                };
                match (target, &mut *support) {
                    (Target::Diameter(_), _) => *diameter = to(*diameter),
                    (Target::ScrewYoung(_), _) => *young = to(*young),
                    (Target::FreeLength(_), _) => *free_length = Some(to(free_length.unwrap_or(0.0))),
                    (Target::Span(_), ScrewSupport::BothEnds { span }) => *span = to(*span),
                    (Target::Support(_), ScrewSupport::BothEnds { .. }) if value < 0.5 => {
                        *support = ScrewSupport::OneEnd
                    }
                    (Target::Support(_), ScrewSupport::OneEnd) if value > 0.5 => {
                        *support = ScrewSupport::BothEnds { span: variable.span.unwrap_or(0.0) };
                    }
                    _ => {}
                }
            }
        }
        Target::Ratio => {
            let ratios = &mut design.machine.analysis.damping.ratios;
            *ratios = if variable.factor { ratios.iter().map(|z| z * value).collect() } else { vec![value] };
        }
        Target::LossFactor => {
            let loss = &mut design.machine.analysis.damping.loss_factor;
            *loss = to(*loss);
        }
        Target::PartYoung(p) | Target::PartDensity(p) => {
            let material = nominal.parts[p].material.as_ref();
            let young = matches!(target, Target::PartYoung(_));
            let own = material.map_or(1.0, |m| if young { m.young } else { m.density });
            let factor = if variable.factor { value } else { value / own };
            let PartScale { young: e, density: rho } = &mut design.parts[p];
            *(if young { e } else { rho }) = factor;
        }
    }
}
