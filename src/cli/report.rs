//! The report page and the mode shapes for ParaView, as `run` writes them.

use super::figures::Shown;
use super::run::Outcome;
use anyhow::Result;
use serde_json::json;
use std::path::{Path, PathBuf};
use stiffmap::coupling::CoupledModel;
use stiffmap::export::manifest::Manifest;
use stiffmap::export::vtu;
use stiffmap::figures::HeightScale;
use stiffmap::figures::report::{DATABASE_FILE, Database, DatabaseInput, PAGE_FILE, write_page};
use stiffmap::frf::ModalSystem;
use stiffmap::modal::{Modes, modes_at};
use stiffmap::reduction::Superelement;

/// Setting of the manifest that holds the hash of the database beside it.
pub const DATABASE_HASH: &str = "modal_database_blake3";

/// What pictures and page need besides the outcome.
pub struct Look<'a> {
    pub systems: &'a [ModalSystem],
    pub model: &'a CoupledModel,
    pub superelements: &'a [Superelement],
}

impl Look<'_> {
    /// What pictures of a run show.
    pub fn shown<'a>(&'a self, outcome: &'a Outcome) -> Shown<'a> {
        Shown {
            machine: &outcome.machine.name,
            axis: &outcome.machine.axis.name,
            axes: &outcome.axes,
            systems: self.systems,
            families: &outcome.solved.families,
            height: HeightScale::Linear,
        }
    }

    /// The modal database of a run.
    pub fn database(&self, outcome: &Outcome) -> Result<Database> {
        let input = DatabaseInput {
            machine: &outcome.machine,
            model: self.model,
            superelements: self.superelements,
            modes: &outcome.solved.modes,
            systems: self.systems,
            frequencies: &outcome.axes.frequencies,
            quantity: outcome.axes.quantity,
            families: &outcome.solved.families,
            table: &outcome.table,
            free_motions: &outcome.free_motions,
            metrics: &outcome.metrics,
        };
        Ok(Database::new(&input)?)
    }

    /// Mode shapes at the first, the middle and the last position (`.vtu`), if a part has a surface; returns the files.
    pub fn write_shapes(&self, outcome: &Outcome) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        if self.superelements.iter().all(|s| s.skin.nodes.is_empty()) {
            return Ok(files);
        }
        let analysis = &outcome.machine.analysis;
        for modes in ends_and_middle(&outcome.solved.modes) {
            let again;
            let modes = if modes.shapes.is_empty() {
                again = modes_at(self.model, &analysis.damping, modes.position)?;
                &again
            } else {
                modes
            };
            let place = format!("{:.3}", 1e3 * modes.position);
            let place = place.trim_end_matches('0').trim_end_matches('.');
            let path = outcome.out.join(format!("mode_shapes_{}_{place}_mm.vtu", outcome.machine.axis.name));
            let listed = modes.free + analysis.modes;
            vtu::write_mode_shapes(&path, self.model, self.superelements, modes, listed)?;
            files.push(path);
        }
        Ok(files)
    }
}

/// The first, the middle and the last position, each once.
fn ends_and_middle(modes: &[Modes]) -> Vec<&Modes> {
    let mut places = vec![0, modes.len() / 2, modes.len().saturating_sub(1)];
    places.dedup();
    places.into_iter().filter_map(|p| modes.get(p)).collect()
}

/// The modal database and the page; returns the files.
pub fn write_report(out: &Path, database: &Database, manifest: &mut Manifest) -> Result<Vec<PathBuf>> {
    let (data, page) = (out.join(DATABASE_FILE), out.join(PAGE_FILE));
    // By this the folder knows its own database from that of another run.
    manifest.settings.push(DATABASE_HASH, json!(database.write(&data)?));
    write_page(&page, database, &serde_json::to_string(manifest)?)?;
    Ok(vec![data, page])
}
