//! How far the page's own solutions hold, measured against the whole model when the page is made.

use super::ReportError;
use super::header::{Group, SpringList};
use super::local::{Local, LocalInput};
use super::what_if::{Dissipating, Summed};
use crate::machine::Damping;
use crate::modal::ModalError;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A frequency that differs by more than this at a setting looked at is beyond the page's reach: half of the 0.1 % that
/// is promised between these settings.
const FREQUENCY_BOUND: f64 = 5e-4;
/// What is stated is this multiple of the largest difference found, for the settings in between.
const MARGIN: f64 = 1.5;
/// More coordinates are kept where frequencies of the map's band differ by more than this,
const FREQUENCY_AIM: f64 = 1e-4;
/// or responses with the run's damping by more than this share of the norm,
const RESPONSE_AIM: f64 = 5e-3;
/// or with the least damping ratio.
const LEAST_AIM: f64 = 2e-2;
/// Least damping ratio of the page's slider.
const LEAST_RATIO: f64 = 0.001;
/// A whole model of more coordinates than this is solved at no more than a quarter as many settings as the page has
/// positions, so that the run takes little longer for it,
const MANY_COORDINATES: usize = 400;
/// but at this many at least.
const FEWEST_PAIRS: usize = 5;
/// Frequencies over the band at which responses are compared, beside those of the modes.
const PROBES: usize = 15;

/// The largest differences between the page's solutions and the whole model over the range of its sliders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accuracy {
    /// Frequencies above this one (Hz) are not the machine's, and not shown.
    pub reach_hz: f64,
    /// Largest relative difference of each elastic frequency below that, by rank; 1.5 times what was found, as all
    /// differences here.
    pub frequency: Vec<f64>,
    /// The largest of those up to the map's highest frequency.
    #[serde(skip)]
    in_band: f64,
    /// Largest difference of the responses up to the map's highest frequency with the run's damping, as a share of the
    /// Frobenius norm over outputs and inputs at that frequency; missing where the sliders are off with that damping, or
    /// where it leaves a mode undamped.
    pub response: Option<f64>,
    /// The same with the least damping ratio for all modes.
    pub response_least: f64,
    /// Least damping ratio that the page offers.
    pub least_ratio: f64,
    /// Settings of the sliders looked at, each at one position or more.
    pub settings: usize,
    /// Positions looked at, m.
    pub positions: Vec<f64>,
}

impl Accuracy {
    /// Whether no more coordinates are needed for maps up to `highest` (Hz).
    pub(super) fn holds(&self, highest: f64) -> bool {
        self.reach_hz >= highest
            && self.in_band <= FREQUENCY_AIM
            && self.response.unwrap_or(0.0) <= RESPONSE_AIM
            && self.response_least <= LEAST_AIM
    }

    /// Whether it reaches further into maps up to `highest` (Hz) or, where both or neither cover them, is nearer.
    pub(super) fn is_better(&self, other: &Self, highest: f64) -> bool {
        let missing = |a: &Self| (1.0 - a.reach_hz / highest).max(0.0);
        let error = |a: &Self| a.response.unwrap_or(0.0).max(a.response_least);
        let (own, before) = (missing(self), missing(other));
        own < before || own == before && error(self) < error(other)
    }
}

/// The page's coordinates, to be measured.
pub(super) struct Checked<'a> {
    pub input: &'a LocalInput<'a>,
    pub springs: SpringList<'a>,
    pub local: &'a [Local],
    /// Frequency above which nothing is promised, whatever the settings looked at give, Hz.
    pub most: f64,
}

/// What one setting at one position gives.
struct Measured {
    reach: f64,
    frequency: Vec<(f64, f64)>,
    response: Option<f64>,
    response_least: f64,
}

impl Checked<'_> {
    /// Solves corners and middles of the sliders' range both ways.
    ///
    /// # Errors
    /// [`ReportError`] if the whole model or the coordinates cannot be solved.
    pub(super) fn accuracy(&self) -> Result<Accuracy, ReportError> {
        let n = self.local.len();
        let mut places = vec![0, n / 2, n.saturating_sub(1)];
        places.dedup();
        let settings = settings(self.springs.groups);
        let mut pairs = pairs(settings.len(), places.len());
        if self.input.model.n() > MANY_COORDINATES {
            pairs.truncate(n.div_ceil(4).max(FEWEST_PAIRS));
        }
        let looked_at = pairs.iter().map(|(setting, _)| setting + 1).max().unwrap_or(0);
        let one = |&(setting, place): &(usize, usize)| self.measure(&settings[setting], places[place]);
        let all = pairs.par_iter().with_max_len(1).map(one).collect::<Result<Vec<Measured>, _>>()?;
        let last = self.input.model.frequency.max(self.input.last).min(self.most);
        let reach_hz = all.iter().map(|m| m.reach).fold(last, f64::min);
        let ranks = all.iter().map(|m| m.frequency.iter().take_while(|(f, _)| *f <= reach_hz).count());
        let largest = |r: usize| {
            let of_rank = all.iter().filter_map(|m| m.frequency.get(r)).filter(|(f, _)| *f <= reach_hz);
            MARGIN * of_rank.map(|(_, error)| *error).fold(0.0, f64::max)
        };
        let in_band = all.iter().flat_map(|m| &m.frequency).filter(|(f, _)| *f <= self.input.highest);
        let responses: Option<Vec<f64>> = all.iter().map(|m| m.response).collect();
        Ok(Accuracy {
            reach_hz,
            frequency: (0..ranks.max().unwrap_or(0)).map(largest).collect(),
            in_band: MARGIN * in_band.map(|(_, error)| *error).fold(0.0, f64::max),
            response: responses.map(|all| MARGIN * all.into_iter().fold(0.0, f64::max)),
            response_least: MARGIN * all.iter().map(|m| m.response_least).fold(0.0, f64::max),
            least_ratio: LEAST_RATIO,
            settings: looked_at,
            positions: places.iter().map(|&p| self.input.modes[p].position).collect(),
        })
    }

    /// One setting (a factor of stiffness each group) at one of the page's positions.
    fn measure(&self, setting: &[f64], p: usize) -> Result<Measured, ReportError> {
        let SpringList { entries, places, groups } = self.springs;
        let LocalInput { model, symmetric, damping, highest, .. } = *self.input;
        let position = self.input.modes[p].position;
        let mut factors = vec![1.0; entries.len()];
        for (group, factor) in groups.iter().zip(setting) {
            group.springs.iter().for_each(|&s| factors[s] = *factor);
        }
        let mut stiffness = model.stiffness(position)?;
        for (&place, factor) in places.iter().zip(&factors) {
            stiffness[place] *= factor;
        }
        let dissipating: Vec<(usize, f64, f64)> = entries
            .iter()
            .enumerate()
            .filter(|(_, s)| s.damping > 0.0 || s.loss_factor > 0.0)
            .map(|(k, s)| (k, s.loss_factor, s.damping))
            .collect();
        let lossy = model.parts.iter().any(|part| part.loss_factor.is_some());
        let dissipating: &Dissipating = if lossy { &[] } else { &dissipating };
        let outputs = model.output_names().len();
        let page = Summed::of_page(&self.local[p], &factors, dissipating, outputs, symmetric)
            .map_err(|source| ModalError::Eigen { position, source })?;
        let truth = Summed::of_model(model, position, &stiffness, places, dissipating)?;

        let mut measured = Measured { reach: 0.0, frequency: Vec::new(), response: None, response_least: 0.0 };
        for (a, b) in (page.free..page.eigenvalues.len()).zip(truth.free..truth.eigenvalues.len()) {
            let (own, exact) = (page.frequency(a), truth.frequency(b));
            let error = (own / exact - 1.0).abs();
            if error > FREQUENCY_BOUND {
                // What is drawn stays below the first that is off, whichever way.
                measured.reach = (1.0 - FREQUENCY_BOUND) * own.min(exact);
                break;
            }
            measured.reach = own.min(exact);
            measured.frequency.push((exact, error));
        }
        let modes = (truth.free..truth.eigenvalues.len()).map(|r| truth.frequency(r)).filter(|f| *f <= highest);
        let probes: Vec<f64> = (1..=PROBES).map(|k| highest * k as f64 / PROBES as f64).chain(modes).collect();
        let difference = |damping: &Damping, page: &Summed, truth: &Summed| {
            let one = |f: &f64| {
                let exact = truth.response(damping, *f);
                (page.response(damping, *f) - &exact).norm() / exact.norm()
            };
            // The peak of a mode that nothing damps has no bound, and nothing is compared there.
            probes.iter().map(one).filter(|share| share.is_finite()).fold(0.0, f64::max)
        };
        let undamped = damping.ratios.iter().all(|z| *z <= 0.0) && damping.rayleigh.is_none();
        let undamped = undamped && damping.loss_factor <= 0.0 && dissipating.is_empty();
        measured.response = (!lossy && !undamped).then(|| difference(damping, &page, &truth));
        let least = Damping { ratios: vec![LEAST_RATIO], rayleigh: None, loss_factor: 0.0, projected: false };
        let (page, truth) = (page.without_dissipation(), truth.without_dissipation());
        measured.response_least = difference(&least, &page, &truth);
        Ok(measured)
    }
}

/// Settings of all sliders as factors of stiffness: all at their ends, all half way to the stiffer end, all as run. The
/// first has all at the stiffest, where most differs, the second all at the softest.
fn settings(groups: &[Group]) -> Vec<Vec<f64>> {
    let end = |group: &Group, side: usize| group.stiffness_factor(group.range[side]);
    let corner =
        |bits: usize| groups.iter().enumerate().map(|(g, group)| end(group, bits >> g & 1)).collect::<Vec<_>>();
    let last = (1usize << groups.len()) - 1;
    let mut all = vec![corner(last)];
    if !groups.is_empty() {
        all.push(corner(0));
        all.extend((1..last).map(corner));
        all.push(groups.iter().map(|group| end(group, 1).sqrt()).collect());
        all.push(vec![1.0; groups.len()]);
    }
    all
}

/// Which settings are looked at where: the first at every position, the others at one each in turn.
fn pairs(settings: usize, positions: usize) -> Vec<(usize, usize)> {
    let everywhere = (0..positions).map(|p| (0, p));
    everywhere.chain((1..settings).map(|s| (s, s % positions))).collect()
}
