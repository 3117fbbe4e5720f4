//! What a map is read for: the largest response, the smallest dynamic stiffness and the most negative real part.
//!
//! The grid gives a first answer ([`grid_extrema`], or a device); [`refine`] makes it independent of the grid. Around
//! each mode, from the closed-form extremum of that mode alone, safeguarded Newton steps on the full sum find
//!
//! ```text
//! max |H|^2:   d|H|^2/df  = 2 Re(conj(H) H') = 0
//! min Re H:    dRe(H)/df  = Re(H') = 0
//! ```
//!
//! and the same from the grid's own best point between its neighbours, so that extrema that no single mode explains are
//! refined too. The search stays inside the grid's first and last frequency.

use nalgebra::Complex;
use rayon::prelude::*;

use super::exact::Packed;
use super::modal_sum::sum_at;
use super::packing::{Denominator, PackedSystem, Packing};
use super::point::{Response, Weights};
use super::{ComplianceMap, FrfError, FrfRequest, GridSearch, Quantity, Tile, TileRange};

/// An extreme value and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extremum {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Value, in the map's unit.
    pub value: f64,
}

/// Metrics of one output and input at one position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairMetrics {
    /// Index of the output.
    pub output: usize,
    /// Index of the input.
    pub input: usize,
    /// Largest |H|.
    pub peak: Extremum,
    /// Smallest Re H: the most negative real part where one is negative (the chatter criterion).
    pub most_negative_real: Extremum,
}

impl PairMetrics {
    /// Smallest element-wise dynamic stiffness 1/max|H|, N/m for a receptance.
    pub fn smallest_dynamic_stiffness(&self) -> f64 {
        self.peak.value.recip()
    }
}

/// Extrema on the grid of one output and input at one position: indices of frequencies, the first of equal values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridExtrema {
    /// Where |H| is largest.
    pub peak: usize,
    /// Where Re H is smallest.
    pub most_negative_real: usize,
}

/// The direct pairs of a request, as [`direct_pairs_of`].
pub fn direct_pairs(request: &FrfRequest) -> Vec<(usize, usize)> {
    direct_pairs_of(request.outputs, request.inputs)
}

/// The direct pairs (output, input): those of one name, in the order of the outputs.
///
/// A machine whose forces act at one port and whose motions are read at another has none; its outputs and inputs are
/// then paired in their order, the first with the first.
pub fn direct_pairs_of(outputs: &[String], inputs: &[String]) -> Vec<(usize, usize)> {
    let own_input = |(o, name): (usize, &String)| Some((o, inputs.iter().position(|input| input == name)?));
    let direct: Vec<(usize, usize)> = outputs.iter().enumerate().filter_map(own_input).collect();
    if direct.is_empty() { (0..outputs.len().min(inputs.len())).map(|i| (i, i)).collect() } else { direct }
}

/// Metrics of a computed map, `[position][pair]`, refined from the modes of its request.
///
/// # Errors
/// As [`refine`].
///
/// # Accuracy
/// As [`refine`].
pub fn metrics(
    request: &FrfRequest,
    map: &ComplianceMap,
    pairs: &[(usize, usize)],
) -> Result<Vec<Vec<PairMetrics>>, FrfError> {
    refine(request, pairs, &grid_extrema(map, pairs))
}

/// Extrema on the grid of a map, `[position][pair]`; of a map in tiles, [`GridSearch`] finds them.
pub fn grid_extrema(map: &ComplianceMap, pairs: &[(usize, usize)]) -> Vec<Vec<GridExtrema>> {
    let values_per_pair = map.outputs.len() * map.inputs.len();
    let mut search = GridSearch::with(map.positions.len(), map.inputs.len(), values_per_pair, pairs);
    let range = TileRange { positions: 0..map.positions.len(), frequencies: 0..map.frequencies.len() };
    search.look(&Tile { range, values: &map.values });
    search.finish()
}

/// Refines extrema on the grid with the modes of the request, `[position][pair]`.
///
/// # Errors
/// As [`FrfRequest::check`], and [`FrfError::Singular`] where an undamped mode lies between two frequencies of the grid.
///
/// # Accuracy
/// The value is that of the full sum at the extremum, found to about 1e-10 of its frequency. An extremum is found if a
/// mode's own extremum or the grid's best point leads to it; the tests hold values to 1e-4 of a 1e-4 Hz grid from a
/// 0.5 Hz grid at 0.5 % damping.
pub fn refine(
    request: &FrfRequest,
    pairs: &[(usize, usize)],
    grid: &[Vec<GridExtrema>],
) -> Result<Vec<Vec<PairMetrics>>, FrfError> {
    request.check()?;
    assert_eq!(grid.len(), request.positions.len(), "one list of grid extrema a position");
    let packing = Packing::new(request);
    grid.par_iter()
        .enumerate()
        .map(|(position, grid)| {
            assert_eq!(grid.len(), pairs.len(), "one grid extremum a pair at position {position}");
            let system = PackedSystem::new(&request.systems[position], &packing);
            let exact = request.systems[position].exact.as_deref().map(|exact| exact.pack());
            Search::new(request, &packing, (&system, exact.as_ref()), position)?.pairs(pairs, grid)
        })
        .collect()
}

/// What is made as large as possible.
#[derive(Clone, Copy)]
enum Goal {
    /// |H|^2.
    Magnitude,
    /// -Re H.
    NegativeReal,
}

impl Goal {
    /// The goal of a response.
    fn value(self, h: Complex<f64>) -> f64 {
        match self {
            Goal::Magnitude => h.norm_sqr(),
            Goal::NegativeReal => -h.re,
        }
    }

    /// The goal's value, slope and curvature.
    fn of(self, h: &Response) -> [f64; 3] {
        match self {
            Goal::Magnitude => [
                h.value.norm_sqr(),
                2.0 * dot(h.value, h.slope),
                2.0 * (h.slope.norm_sqr() + dot(h.value, h.curvature)),
            ],
            Goal::NegativeReal => [-h.value.re, -h.slope.re, -h.curvature.re],
        }
    }
}

/// Re(conj(a) b).
fn dot(a: Complex<f64>, b: Complex<f64>) -> f64 {
    a.re * b.re + a.im * b.im
}

/// Starts whose value is below this share of the best start cannot overtake it within their bracket.
const WORTHWHILE: f64 = 0.5;

/// Newton's last step, relative to the frequency; the value is then exact to rounding, since its slope is zero there.
const STEP: f64 = 1e-10;

struct Search<'a> {
    request: &'a FrfRequest<'a>,
    packing: &'a Packing,
    system: &'a PackedSystem,
    exact: Option<&'a Packed<'a>>,
    /// Starting frequencies, ascending, and half the width of the search around each.
    starts: Vec<(f64, f64)>,
    /// The responses there, `[start, output, input]`.
    screened: Vec<Complex<f64>>,
}

impl<'a> Search<'a> {
    fn new(
        request: &'a FrfRequest<'a>,
        packing: &'a Packing,
        (system, exact): (&'a PackedSystem, Option<&'a Packed<'a>>),
        position: usize,
    ) -> Result<Self, FrfError> {
        let (first, last) = (request.frequencies[0], request.frequencies[request.frequencies.len() - 1]);
        let mut starts = Vec::new();
        for (mode, denominator) in system.modes.iter().enumerate() {
            let f_r = denominator.frequency;
            let half_band = 0.5 * (denominator.viscous + denominator.loss / f_r.max(f64::MIN_POSITIVE));
            let inside = (first..=last).contains(&f_r);
            let felt = system.residues[mode * packing.pairs.len()..][..packing.pairs.len()].iter().any(|a| *a != 0.0);
            // A free motion adds a constant to an accelerance and peaks nowhere.
            let constant = f_r == 0.0 && request.quantity == Quantity::Accelerance;
            if inside && felt && half_band == 0.0 && !constant {
                return Err(FrfError::Singular { position, mode, frequency: f_r });
            }
            for f in closed_form(denominator, request.quantity) {
                if felt && half_band > 0.0 && (first..=last).contains(&f) {
                    starts.push((f, 2.0 * half_band));
                }
            }
        }
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let frequencies: Vec<f64> = starts.iter().map(|(f, _)| *f).collect();
        let screened = sum_at(system, exact, packing, request.quantity, &frequencies, request.values_per_pair());
        Ok(Search { request, packing, system, exact, starts, screened })
    }

    fn pairs(&self, pairs: &[(usize, usize)], grid: &[GridExtrema]) -> Result<Vec<PairMetrics>, FrfError> {
        let found = pairs.iter().zip(grid).map(|(&(output, input), grid)| {
            let pair = (output, input);
            let screened = |goal: Goal| -> Vec<f64> {
                let rows = self.screened.chunks_exact(self.request.values_per_pair());
                rows.map(|h| goal.value(h[output * self.request.inputs.len() + input])).collect()
            };
            let (f, value) = self.best(pair, Goal::Magnitude, &screened(Goal::Magnitude), grid.peak);
            let peak = Extremum { frequency: f, value: value.norm() };
            let (f, value) =
                self.best(pair, Goal::NegativeReal, &screened(Goal::NegativeReal), grid.most_negative_real);
            PairMetrics { output, input, peak, most_negative_real: Extremum { frequency: f, value: value.re } }
        });
        Ok(found.collect())
    }

    /// The best frequency of a goal and the response there.
    fn best(&self, pair: (usize, usize), goal: Goal, screened: &[f64], grid: usize) -> (f64, Complex<f64>) {
        let frequencies = self.request.frequencies;
        let (first, last) = (frequencies[0], frequencies[frequencies.len() - 1]);
        let on_grid = self.respond(frequencies[grid], pair);
        let top = screened.iter().copied().fold(goal.of(&on_grid)[0], f64::max);
        let bar = top - (1.0 - WORTHWHILE) * top.abs();
        let around = (frequencies[grid.saturating_sub(1)], frequencies[(grid + 1).min(frequencies.len() - 1)]);
        let mut best = (frequencies[grid], on_grid.value, goal.of(&on_grid)[0]);
        let modal = self.starts.iter().zip(screened).filter(|(_, value)| **value >= bar);
        let brackets = modal.map(|((f, width), _)| (*f, (f - width).max(first), (f + width).min(last)));
        for (start, low, high) in brackets.chain([(frequencies[grid], around.0, around.1)]) {
            let candidate = self.climb(pair, goal, start, low, high);
            if candidate.2 > best.2 {
                best = candidate;
            }
        }
        (best.0, best.1)
    }

    fn respond(&self, frequency: f64, (output, input): (usize, usize)) -> Response {
        let quantity = self.request.quantity;
        // At 0 Hz a free motion's accelerance is its own, and the modes have it.
        if let Some(exact) = self.exact.filter(|_| frequency > 0.0) {
            return exact.response(frequency, output, input, quantity);
        }
        let pair = self.packing.pair_of_value[output * self.request.inputs.len() + input];
        Weights::new(self.system, frequency).response(self.system, self.packing.pairs.len(), pair, quantity)
    }

    /// Newton steps on the goal's slope, bisection where a step leaves the bracket or the goal is not concave; the best
    /// point seen.
    fn climb(
        &self,
        pair: (usize, usize),
        goal: Goal,
        start: f64,
        mut low: f64,
        mut high: f64,
    ) -> (f64, Complex<f64>, f64) {
        let mut f = start;
        let mut best = (f, Complex::default(), f64::NEG_INFINITY);
        for _ in 0..60 {
            let h = self.respond(f, pair);
            let [value, slope, curvature] = goal.of(&h);
            if value > best.2 {
                best = (f, h.value, value);
            }
            if slope > 0.0 {
                low = f;
            } else {
                high = f;
            }
            let newton = f - slope / curvature;
            let next = if curvature < 0.0 && newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - f).abs() <= STEP * f || high <= low {
                break;
            }
            f = next;
        }
        best
    }
}

/// Where a single mode has its largest magnitude and the two extrema of its real part, Hz.
///
/// ```text
/// |H| of a receptance:   f^2 = f_r^2 (1 - 2 zeta^2 - eta zeta)
/// |H| of an accelerance: f^2 = f_r^2 (1 + 2 zeta^2 + eta zeta)
/// Re H:                  f^2 = f_r^2 (1 -+ (2 zeta + eta))
/// ```
///
/// Exact for either kind of damping alone in a receptance, a start well within the half band otherwise.
fn closed_form(mode: &Denominator, quantity: Quantity) -> [f64; 3] {
    let square = mode.frequency * mode.frequency;
    let loss = mode.viscous * mode.frequency + mode.loss;
    let shift = 0.5 * mode.viscous * loss / mode.frequency.max(f64::MIN_POSITIVE);
    let peak = match quantity {
        Quantity::Receptance => square - shift,
        Quantity::Mobility => square,
        Quantity::Accelerance => square + shift,
    };
    [peak, square - loss, square + loss].map(|f2| f2.max(0.0).sqrt())
}
