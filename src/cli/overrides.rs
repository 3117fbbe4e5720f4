//! Command-line values that take the place of the machine file's.

use super::{UsageError, frequencies};
use clap::Args;
use stiffmap::machine::{Machine, Quantity};

#[derive(Args, Debug, Default)]
pub struct Overrides {
    /// Positions in m: a list `0,-0.15,-0.3` or a range `0:-0.6:0.005`
    #[arg(long, visible_alias = "position", allow_hyphen_values = true, value_name = "LIST|RANGE")]
    positions: Option<String>,
    /// Frequencies in Hz: a list, a range `0:900:1`, `logarithmic:1:900:500` (from, to, count) or `clustered:0:900`
    #[arg(long, allow_hyphen_values = true, value_name = "LIST|RANGE|GRID")]
    frequencies: Option<String>,
    /// What the map holds: receptance, mobility or accelerance
    #[arg(long, value_name = "receptance|mobility|accelerance")]
    quantity: Option<String>,
    /// Viscous damping ratio of all modes; takes the place of all damping in the machine file
    #[arg(long, allow_hyphen_values = true, value_name = "ZETA")]
    damping: Option<f64>,
    /// Exactly this many elastic modes in map and state space
    #[arg(long, value_name = "N")]
    pub modes: Option<usize>,
}

impl Overrides {
    /// Whether positions were given.
    pub fn gives_positions(&self) -> bool {
        self.positions.is_some()
    }

    /// Puts the values into the machine and returns the positions.
    pub fn apply(&self, machine: &mut Machine) -> Result<Vec<f64>, UsageError> {
        if let Some(text) = &self.frequencies {
            (machine.analysis.frequencies, machine.analysis.grid) = frequencies::parse(text)?;
        }
        if let Some(name) = &self.quantity {
            machine.analysis.quantity = Quantity::named(name).ok_or_else(|| {
                UsageError(format!("--quantity: \"{name}\"; allowed are receptance, mobility, accelerance"))
            })?;
        }
        if let Some(zeta) = self.damping {
            if !(0.0..1.0).contains(&zeta) {
                return Err(UsageError(format!("--damping: {zeta} is not in 0 <= zeta < 1")));
            }
            let damping = &mut machine.analysis.damping;
            damping.ratios = vec![zeta];
            damping.rayleigh = None;
            damping.loss_factor = 0.0;
            machine.parts.iter_mut().for_each(|p| p.loss_factor = None);
            for joint in &mut machine.joints {
                joint.loss_factor = None;
                joint.springs.iter_mut().for_each(|s| s.damping = 0.0);
            }
        }
        if let Some(modes) = self.modes {
            if modes == 0 {
                return Err(UsageError("--modes: 0 is not allowed; at least 1".into()));
            }
            machine.analysis.modes = modes;
        }
        let Some(text) = &self.positions else { return Ok(machine.axis.stations()) };
        let positions = numbers("--positions", text)?;
        let [from, to] = machine.axis.travel;
        for (i, p) in positions.iter().enumerate() {
            if *p < from.min(to) - 1e-9 || *p > from.max(to) + 1e-9 {
                return Err(UsageError(format!(
                    "--positions: {p} m is outside the travel of axis \"{}\", {from} to {to} m",
                    machine.axis.name
                )));
            }
            if positions[..i].contains(p) {
                return Err(UsageError(format!("--positions: {p} m is given twice")));
            }
        }
        Ok(positions)
    }
}

/// A list `a,b,c` or a range `from:to:step`; the end is included when a step meets it.
pub(super) fn numbers(flag: &str, text: &str) -> Result<Vec<f64>, UsageError> {
    let number = |part: &str| {
        let value: Result<f64, _> = part.trim().parse();
        value.ok().filter(|v| v.is_finite()).ok_or_else(|| {
            UsageError(format!("{flag}: \"{part}\" is not a number; write a list `0,-0.15` or a range `from:to:step`"))
        })
    };
    if !text.contains(':') {
        return text.split(',').map(number).collect();
    }
    let parts = text.split(':').map(number).collect::<Result<Vec<f64>, _>>()?;
    let [from, to, step] = parts[..] else {
        return Err(UsageError(format!(
            "{flag}: \"{text}\" has {} of the three numbers of a range `from:to:step`",
            parts.len()
        )));
    };
    if step == 0.0 {
        return Err(UsageError(format!("{flag}: the step of \"{text}\" is 0")));
    }
    let count = ((to - from).abs() / step.abs() + 1e-9).floor();
    if count > 1e7 {
        return Err(UsageError(format!("{flag}: \"{text}\" has {count:.0} values; at most 10,000,000 are allowed")));
    }
    let sign = if to < from { -1.0 } else { 1.0 };
    Ok((0..=count as usize).map(|i| ((from + sign * step.abs() * i as f64) * 1e12).round() / 1e12).collect())
}
