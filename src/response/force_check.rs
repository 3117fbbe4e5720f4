//! What a history cannot hold of a force: refused where the motion would be another, told where it loses a share.

use super::force::rounded;
use super::{Forces, Milling, Pulse, ResponseError, Shape};

/// Share of a wave's amplitude that straight lines may put at the mirrored frequency before it is told.
const MIRRORED: f64 = 0.02;
/// Samples that a tooth passing must have.
const OF_A_TOOTH: f64 = 20.0;

/// Straight lines between the samples of a wave of frequency f hold a second wave at rate - f; its share of the first.
pub fn mirrored_share(frequency: f64, rate: f64) -> f64 {
    (frequency / (rate - frequency)).powi(2)
}

impl Shape {
    /// Refuses a force that the samples would turn into another, and returns warnings for what they lose of it. `what`
    /// names it in messages.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`] for a force that begins after the last sample, and for a frequency of half the rate
    /// or more.
    pub fn check(&self, what: &str, forces: &Forces) -> Result<Vec<String>, ResponseError> {
        let last = forces.end();
        let begins = |start: f64| {
            if start < last {
                return Ok(());
            }
            let allowed =
                format!("less than {last} s, the last sample's time; start earlier or give a longer --duration");
            Err(ResponseError::not_allowed(format!("{what}: start"), format!("{start} s"), allowed))
        };
        let mut told = Vec::new();
        match *self {
            Self::Impulse(pulse @ Pulse { start, length, .. }) => {
                begins(start)?;
                if pulse.is_lost(forces.step) {
                    let samples = length / forces.step;
                    told.push(format!(
                        "{what}: the pulse of {length} s is {samples:.3} samples long: its momentum is kept, its form is \
                         not; --rate {} or more shows it",
                        (10.0 / length).ceil()
                    ));
                }
                if start + length > last + forces.step * (1.0 + 1e-9) {
                    told.push(format!(
                        "{what}: the pulse ends at {} s, the history at {last} s: the rest is left out; give a longer \
                         --duration",
                        rounded(start + length)
                    ));
                }
            }
            Self::Step { start, .. } => begins(start)?,
            Self::Sine { frequency, .. } => told.extend(wave(&format!("{what}: frequency"), frequency, forces)?),
            Self::Chirp { from, to, .. } => {
                told.extend(wave(&format!("{what}: the highest frequency"), from.max(to), forces)?);
            }
            Self::Random { .. } => {}
        }
        Ok(told)
    }
}

fn wave(what: &str, frequency: f64, forces: &Forces) -> Result<Option<String>, ResponseError> {
    let rate = forces.step.recip();
    if frequency >= 0.5 * rate * (1.0 - 1e-12) {
        let allowed = format!(
            "less than {} Hz, half the rate: samples of a faster wave are those of a slower one; --rate {} or more",
            0.5 * rate,
            (10.0 * frequency).ceil()
        );
        return Err(ResponseError::not_allowed(what, format!("{frequency} Hz"), allowed));
    }
    let share = mirrored_share(frequency, rate);
    Ok((share > MIRRORED).then(|| {
        format!(
            "{what}: {frequency} Hz at {rate} samples a second: straight lines between the samples hold a second wave at \
             {} Hz with {:.1} % of its amplitude; --rate {} or more",
            rate - frequency,
            100.0 * share,
            (10.0 * frequency).ceil()
        )
    }))
}

impl Milling {
    /// As [`Shape::check`]: refuses a cut whose teeth pass faster than half the rate, and tells one with few samples a
    /// tooth, whose harmonics lie above it.
    ///
    /// # Errors
    /// [`ResponseError::NotAllowed`].
    pub fn check(&self, forces: &Forces) -> Result<Vec<String>, ResponseError> {
        let (passing, rate) = (self.tooth_passing(), forces.step.recip());
        let enough = (OF_A_TOOTH * passing).ceil();
        if passing >= 0.5 * rate {
            let allowed = format!("less than {} Hz, half the rate; --rate {enough} or more", 0.5 * rate);
            return Err(ResponseError::not_allowed("--milling: teeth pass at", format!("{passing} Hz"), allowed));
        }
        let few = rate < OF_A_TOOTH * passing;
        Ok(few
            .then(|| {
                format!(
                    "--milling: {:.1} samples while a tooth passes, at {passing} Hz: its momentum is kept, harmonics above \
                     {} Hz are not; --rate {enough} or more",
                    rate / passing,
                    0.5 * rate
                )
            })
            .into_iter()
            .collect())
    }
}
