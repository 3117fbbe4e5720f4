//! The state-space database of a run: what the user may ask of it, and its file.

use super::UsageError;
use anyhow::Result;
use clap::Args;
use serde_json::json;
use std::path::Path;
use stiffmap::export::manifest::Manifest;
use stiffmap::export::mat;
use stiffmap::modal::Modes;
use stiffmap::state_space::{Database, Hold, StateSpaceError, StateSpaceOptions, discretise, state_space};

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

    /// Writes `state_space.mat` of all positions.
    pub fn write(
        &self,
        path: &Path,
        modes: &[Modes],
        kept: usize,
        residual: bool,
        (outputs, inputs): (&[String], &[String]),
        manifest: &mut Manifest,
    ) -> Result<()> {
        let (velocity, acceleration) = (self.velocity, self.acceleration);
        let options = StateSpaceOptions { modes: kept, velocity, acceleration, residual };
        let mut database = match Database::new(modes, options) {
            Err(StateSpaceError::Order { .. }) => {
                manifest.warnings.push(
                    "the positions neither all ascend nor all descend: state_space.mat holds no aligned matrices"
                        .into(),
                );
                let states = modes.iter().map(|m| state_space(m, options)).collect();
                Database { states, aligned: Vec::new(), leave_one_out: Vec::new(), options, free: 0 }
            }
            made => made?,
        };
        if let Some(figure) = database.worst_leave_one_out() {
            manifest.settings.push("state_space_leave_one_out", json!(figure));
        }
        let discrete = self.sample_time.map(|time| (time, self.hold.unwrap_or(Hold::Zero)));
        if let Some((time, hold)) = discrete {
            database.states = database.states.iter().map(|s| discretise(s, time, hold)).collect();
            manifest.settings.push("sample_time_s", json!(time));
            manifest.settings.push("hold", json!(hold.name()));
        }
        Ok(mat::write_database(path, &database, outputs, inputs, discrete)?)
    }
}
