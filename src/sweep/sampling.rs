//! Samples of the design variables: full grid, Latin hypercube, Sobol's sequence.
//!
//! The values of a design are a function of the study and the design's index, so that a shard knows its designs
//! without the others, and a continued sweep those it has not done.

use super::random::{hash, permuted, uniform};
use super::sobol;
use super::study_error::StudyError;
use super::variables::Variable;
use crate::machine::table::{Table, find_name};

/// How designs are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Every combination of values; the last variable changes fastest.
    Grid,
    /// One design in each of n slices of every variable, at a random place of it.
    LatinHypercube,
    /// Sobol's sequence; with a seed, shifted by random digits.
    Sobol,
}

/// A sample of designs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// How designs are chosen.
    pub method: Method,
    /// Number of designs.
    pub designs: u64,
    /// Seed; `None` where the study gives none: 0 for a Latin hypercube, no shift for Sobol's sequence.
    pub seed: Option<u64>,
}

impl Sampling {
    /// The method's name as the study writes it.
    pub fn name(&self) -> &'static str {
        METHODS[self.method as usize]
    }

    /// Values of the design with an index, in SI units, in the order of the variables.
    pub fn values(&self, variables: &[Variable], index: u64) -> Vec<f64> {
        assert!(index < self.designs, "design {index} of {}", self.designs);
        if self.method == Method::Grid {
            let mut rest = index;
            let mut values: Vec<f64> = variables
                .iter()
                .rev()
                .map(|variable| {
                    let points = variable.grid_points().unwrap_or(1) as u64;
                    let step = rest % points;
                    rest /= points;
                    // The middle of its share for a list, both ends for a range.
                    let place = match variable.domain {
                        super::variables::Domain::Values(_) => (step as f64 + 0.5) / points as f64,
                        super::variables::Domain::Range { .. } => step as f64 / (points - 1).max(1) as f64,
                    };
                    variable.at(place)
                })
                .collect();
            values.reverse();
            return values;
        }
        let seed = self.seed.unwrap_or(0);
        let place = |d: usize| match self.method {
            Method::LatinHypercube => {
                let words = [seed, d as u64, self.designs];
                let slice = permuted(index, self.designs, &words);
                (slice as f64 + uniform(&[seed, d as u64, self.designs, slice])) / self.designs as f64
            }
            _ => {
                let shift = self.seed.map_or(0, |seed| (hash(&[seed, d as u64]) >> 32) as u32);
                f64::from(sobol::coordinate(index, d) ^ shift) / 4_294_967_296.0
            }
        };
        variables.iter().enumerate().map(|(d, variable)| variable.at(place(d))).collect()
    }
}

const METHODS: [&str; 3] = ["grid", "latin-hypercube", "sobol"];
/// Designs of a grid at most: 2^53, so that counts are exact in every format.
const MOST_DESIGNS: f64 = 9_007_199_254_740_992.0;

/// Reads `[sampling]`.
pub(super) fn read_sampling(root: &Table<'_>, variables: &[Variable]) -> Result<Sampling, StudyError> {
    let item = root.need("sampling", "[sampling] with method and designs")?;
    let table = item.table()?;
    let method_item = table.need("method", "method = \"grid\", \"latin-hypercube\" or \"sobol\"")?;
    let method = [Method::Grid, Method::LatinHypercube, Method::Sobol]
        [find_name(&method_item, "sampling method", method_item.text()?, &METHODS)?];
    let seed_item = table.get("seed");
    let seed = seed_item.as_ref().map(|item| match item.plain_number()? {
        n if n >= 0.0 && n.fract() == 0.0 && n < MOST_DESIGNS => Ok(n as u64),
        _ => Err(item.refuse("a whole number from 0 to 2^53", "write it without quotes")),
    });
    let seed = seed.transpose()?;
    let count_item = table.get("designs");
    let designs = if method == Method::Grid {
        if let Some(item) = count_item.or(seed_item) {
            return Err(item
                .refuse(
                    "neither `designs` nor `seed` on a grid",
                    "remove it; `points` of each variable give their number",
                )
                .into());
        }
        let mut product = 1.0;
        for variable in variables {
            let Some(points) = variable.grid_points() else {
                let seen = format!("the variable {:?} without `points`", variable.name);
                return Err(method_item
                    .refuse_seen(seen, "a number of points for each range on a grid", "add points = 10 to it")
                    .into());
            };
            product *= points as f64;
        }
        if product > MOST_DESIGNS {
            return Err(method_item
                .refuse_seen(format!("a grid of {product:.1e} designs"), "at most 2^53", "give fewer points")
                .into());
        }
        product as u64
    } else {
        table.need("designs", "designs = 200")?.count()? as u64
    };
    if method == Method::Sobol && variables.len() > sobol::MOST_DIMENSIONS {
        let seen = format!("{} variables", variables.len());
        let allowed = format!("at most {} with Sobol's sequence", sobol::MOST_DIMENSIONS);
        return Err(method_item.refuse_seen(seen, allowed, "take a Latin hypercube").into());
    }
    table.finish()?;
    Ok(Sampling { method, designs, seed })
}
