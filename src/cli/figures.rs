//! Pictures from modal systems: of a run, and again from its result folder.

use anyhow::{Context, Result};
use clap::Args;
use std::path::{Path, PathBuf};
use stiffmap::export::{response, vts};
use stiffmap::figures::report::{DATABASE_FILE, Database, PAGE_FILE, write_page};
use stiffmap::figures::{FigureInput, HeightScale, ImpulseInput, draw_all, draw_impulse};
use stiffmap::files::{MANIFEST, ResultFolder};
use stiffmap::frf::{ComplianceMap, ModalSystem, modal_sum};
use stiffmap::interrupt::Interrupt;
use stiffmap::modal::ModeFamilies;
use stiffmap::pipeline::PipelineError;

use super::map::Axes;
use super::pictures::picture_map;
use super::report::DATABASE_HASH;
use super::{UsageError, open_folder, streams};

/// A map larger than this is thinned for ParaView as for pictures, bytes.
const LARGEST_SURFACES: u64 = 512 << 20;

#[derive(Args, Debug)]
pub struct Arguments {
    /// Result folder of a run
    result: PathBuf,
    /// Height of the surfaces by the logarithm of the magnitude
    #[arg(long)]
    logarithmic: bool,
}

/// What pictures show.
pub struct Shown<'a> {
    pub machine: &'a str,
    pub axis: &'a str,
    pub axes: &'a Axes,
    pub systems: &'a [ModalSystem],
    pub families: &'a ModeFamilies,
    pub height: HeightScale,
}

impl Shown<'_> {
    /// Draws every picture into `figures` below a folder; returns the files.
    pub fn draw(&self, out: &Path, interrupt: &Interrupt) -> Result<Vec<PathBuf>> {
        let folder = out.join("figures");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let map = picture_map(self.axes, self.systems, interrupt)?;
        go_on(interrupt)?;
        let input = FigureInput {
            machine: self.machine,
            axis: self.axis,
            families: self.families,
            map: &map,
            height: self.height,
        };
        let mut files = draw_all(&input, &folder)?;
        go_on(interrupt)?;
        // The topmost position, as in the paper: the largest along the axis.
        let positions = &self.axes.positions;
        let top = (0..positions.len()).max_by(|&a, &b| positions[a].total_cmp(&positions[b]));
        if let Some(top) = top {
            let impulse = ImpulseInput {
                machine: self.machine,
                axis: self.axis,
                position: positions[top],
                system: &self.systems[top],
                outputs: &self.axes.outputs,
                inputs: &self.axes.inputs,
                highest: self.axes.frequencies.iter().copied().fold(0.0, f64::max),
            };
            files.extend(draw_impulse(&impulse, &folder)?);
        }
        Ok(files)
    }

    /// `surface_<label>.vts` of every direct response, from the run's map where it is in memory; returns the files.
    pub fn write_surfaces(
        &self,
        out: &Path,
        map: Option<&ComplianceMap>,
        interrupt: &Interrupt,
    ) -> Result<Vec<PathBuf>> {
        let computed;
        let map = match map {
            Some(map) => map,
            None if self.axes.bytes() <= LARGEST_SURFACES => {
                computed = modal_sum(&self.axes.request(self.systems))?;
                &computed
            }
            None => {
                computed = picture_map(self.axes, self.systems, interrupt)?;
                &computed
            }
        };
        let mut files = Vec::new();
        if map.positions.len() > 1 && map.frequencies.len() > 1 {
            for one in response::direct_responses(map) {
                let path = out.join(format!("surface_{}.vts", one.label));
                vts::write_surface(&path, map, &one)?;
                files.push(path);
            }
        }
        Ok(files)
    }
}

fn go_on(interrupt: &Interrupt) -> Result<()> {
    if interrupt.requested() { Err(PipelineError::Interrupted.into()) } else { Ok(()) }
}

/// Draws the pictures, the surfaces for ParaView and the report page of a result folder again.
pub fn figures(arguments: &Arguments, interrupt: &Interrupt) -> Result<()> {
    let out = &arguments.result;
    let file = out.join(DATABASE_FILE);
    if !file.is_file() {
        return Err(UsageError(format!(
            "{}: there is no {DATABASE_FILE}; name the folder that `stiffmap run` wrote, without --no-figures",
            out.display()
        ))
        .into());
    }
    let _folder = open_folder(out, "run")?;
    let (database, hash) = Database::read(&file)?;
    let damaged = || UsageError(format!("{}: an array is missing or too short; run again", file.display()));
    let (positions, frequencies) = database.axes().ok_or_else(damaged)?;
    let (systems, families) = (database.systems().ok_or_else(damaged)?, database.families().ok_or_else(damaged)?);
    let header = &database.header;
    let quantity = database.quantity().ok_or_else(damaged)?;
    let (outputs, inputs) = (header.outputs.clone(), header.inputs.clone());
    let shown = Shown {
        machine: &header.machine,
        axis: &header.axis,
        axes: &Axes { positions, frequencies, outputs, inputs, quantity },
        systems: &systems,
        families: &families,
        height: if arguments.logarithmic { HeightScale::Logarithmic } else { HeightScale::Linear },
    };
    let record = own_manifest(out, &hash)?;
    let mut files = shown.draw(out, interrupt)?;
    files.extend(shown.write_surfaces(out, None, interrupt)?);
    go_on(interrupt)?;
    let page = out.join(PAGE_FILE);
    write_page(&page, &database, &record.to_string())?;
    files.push(page);
    for file in files {
        streams::say(&file.display().to_string());
    }
    Ok(())
}

/// The manifest of a folder, which must be that of its database: by its hash, so that a database of another run, or of
/// another machine, is not drawn under this one's name.
fn own_manifest(out: &Path, hash: &str) -> Result<serde_json::Value> {
    ResultFolder::check_finished(out, "run again")?;
    let path = out.join(MANIFEST);
    let text = std::fs::read_to_string(&path)
        .map_err(|e| UsageError(format!("{}: {e}; the page says what was run from it", path.display())))?;
    // What is embedded is JSON, whatever the file holds.
    let record: serde_json::Value =
        serde_json::from_str(&text).map_err(|e| UsageError(format!("{}: {e}", path.display())))?;
    let expected = record["settings"][DATABASE_HASH].as_str();
    if expected != Some(hash) {
        return Err(UsageError(format!(
            "{}: its hash is {hash}, and {} names {}: it is the database of another run; run again",
            out.join(DATABASE_FILE).display(),
            path.display(),
            expected.unwrap_or("none")
        ))
        .into());
    }
    Ok(record)
}
