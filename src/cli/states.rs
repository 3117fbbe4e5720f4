//! The state-space database of a run: what the user may ask of it, and its file.

use super::UsageError;
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::borrow::Cow;
use std::path::Path;
use stiffmap::export::manifest::Manifest;
use stiffmap::export::mat;
use stiffmap::modal::Modes;
use stiffmap::state_space::{Database, Hold, StateSpace, StateSpaceError, StateSpaceOptions, discretise, state_space};

#[derive(Args, Debug, Default)]
pub struct StateArguments {
    /// Rows for the outputs' velocities in state_space.mat, after those for displacements
    #[arg(long)]
    velocity: bool,
    /// Rows for the outputs' accelerations, after those
    #[arg(long)]
    acceleration: bool,
    /// Discretise state_space.mat exactly at this sample time, s; continuous without it
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    sample_time: Option<f64>,
    /// What the force does between samples: zero keeps its value, first runs straight to the next
    #[arg(long, value_name = "zero|first", requires = "sample_time", value_parser = parse_hold)]
    hold: Option<Hold>,
}

fn parse_hold(text: &str) -> Result<Hold, String> {
    match text {
        "zero" => Ok(Hold::Zero),
        "first" => Ok(Hold::First),
        _ => Err(format!("hold {text:?}: allowed are zero, first")),
    }
}

/// Leave-one-out figure from which a run tells of it.
const LEAVE_ONE_OUT_TOLD: f64 = 0.01;

impl StateArguments {
    /// Refuses what cannot be, before anything is computed.
    pub fn check(&self) -> Result<(), UsageError> {
        match self.sample_time {
            Some(time) if !(time.is_finite() && time > 0.0) => {
                Err(UsageError(format!("--sample-time: {time} is not allowed; a positive time in s")))
            }
            _ => Ok(()),
        }
    }

    /// Rows and D of the systems.
    pub fn options(&self, modes: usize, residual: bool) -> StateSpaceOptions {
        StateSpaceOptions { modes, velocity: self.velocity, acceleration: self.acceleration, residual }
    }

    /// Writes `state_space.mat` of all positions.
    pub fn write(
        &self,
        path: &Path,
        modes: &[Modes],
        options: StateSpaceOptions,
        (outputs, inputs): (&[String], &[String]),
        manifest: &mut Manifest,
    ) -> Result<()> {
        let discrete = self.sample_time.map(|time| (time, self.hold.unwrap_or(Hold::Zero)));
        if let Some((time, hold)) = discrete {
            manifest.settings.push("sample_time_s", json!(time));
            manifest.settings.push("hold", json!(hold.name()));
        }
        let written = |system: StateSpace| match discrete {
            Some((time, hold)) => discretise(&system, time, hold),
            None => system,
        };
        // Of very many positions the shapes have been given up, and one system is held at a time.
        let shapes_are_kept = modes.iter().all(|m| !m.shapes.is_empty());
        let database = if shapes_are_kept { Some(Database::new(modes, options)) } else { None };
        let reason = match database {
            Some(Ok(mut database)) => {
                if let Some(figure) = database.worst_leave_one_out() {
                    manifest.settings.push("state_space_leave_one_out", json!(figure));
                    if figure > LEAVE_ONE_OUT_TOLD {
                        let off = if figure.is_finite() {
                            format!("is off by up to {:.1} % of its peak", 100.0 * figure)
                        } else {
                            "has a stiffness that is not positive".to_owned()
                        };
                        manifest.warnings.push(format!(
                            "aligned state spaces between stations: a station interpolated from the others, at twice the \
                             spacing, {off}; make the axis's step smaller before you interpolate them"
                        ));
                    }
                }
                database.states = database.states.into_iter().map(written).collect();
                return Ok(mat::write_database(path, &database, outputs, inputs, discrete)?);
            }
            Some(Err(StateSpaceError::Order { .. })) => "the positions neither all ascend nor all descend",
            Some(Err(error)) => return Err(error.into()),
            None => "so many positions are solved without keeping their shapes; more memory for them: --map-memory",
        };
        manifest.warnings.push(format!("{reason}: state_space.mat holds no aligned matrices"));
        let state = |i: usize| Cow::Owned(written(state_space(&modes[i], options)));
        let labels = mat::StateLabels { outputs, inputs, options, discrete };
        Ok(mat::write_state_spaces(path, modes.len(), &state, &labels)?)
    }
}
