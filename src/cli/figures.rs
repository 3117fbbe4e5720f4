//! Pictures from modal systems: of a run, and again from its result folder.

use anyhow::{Context, Result};
use clap::Args;
use std::path::{Path, PathBuf};
use stiffmap::export::{response, vts};
use stiffmap::figures::report::{DATABASE_FILE, Database, PAGE_FILE, write_page};
use stiffmap::figures::{FigureInput, HeightScale, ImpulseInput, draw_all, draw_impulse};
use stiffmap::frf::{ComplianceMap, FrfRequest, ModalSystem, Quantity, modal_sum};
use stiffmap::interrupt::Interrupt;
use stiffmap::modal::ModeFamilies;
use stiffmap::pipeline::PipelineError;

use super::UsageError;

/// Frequencies a picture is made of, at least; a coarser grid is divided.
const PICTURE_FREQUENCIES: usize = 3600;
/// Values that a picture's map may hold.
const PICTURE_VALUES: usize = 6_000_000;

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
    pub positions: &'a [f64],
    pub frequencies: &'a [f64],
    pub outputs: &'a [String],
    pub inputs: &'a [String],
    pub systems: &'a [ModalSystem],
    pub families: &'a ModeFamilies,
    pub height: HeightScale,
}

impl Shown<'_> {
    fn map(&self, frequencies: &[f64]) -> Result<ComplianceMap> {
        let request = FrfRequest {
            positions: self.positions,
            systems: self.systems,
            frequencies,
            outputs: self.outputs,
            inputs: self.inputs,
            quantity: Quantity::Receptance,
        };
        Ok(modal_sum(&request)?)
    }

    /// A grid fine enough for narrow peaks.
    fn fine(&self) -> Vec<f64> {
        let given = self.frequencies;
        let pairs = self.positions.len() * self.outputs.len() * self.inputs.len();
        let wanted = PICTURE_FREQUENCIES.min(PICTURE_VALUES / pairs.max(1));
        let divide = (wanted / given.len().max(1)).max(1);
        let mut frequencies: Vec<f64> = given
            .windows(2)
            .flat_map(|w| (0..divide).map(move |k| w[0] + (w[1] - w[0]) * k as f64 / divide as f64))
            .collect();
        frequencies.extend(given.last());
        frequencies
    }

    /// Draws every picture into `figures` below a folder; returns the files.
    pub fn draw(&self, out: &Path, interrupt: &Interrupt) -> Result<Vec<PathBuf>> {
        let folder = out.join("figures");
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let map = self.map(&self.fine())?;
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
        let top = (0..self.positions.len()).max_by(|&a, &b| self.positions[a].total_cmp(&self.positions[b]));
        if let Some(top) = top {
            let impulse = ImpulseInput {
                machine: self.machine,
                axis: self.axis,
                position: self.positions[top],
                system: &self.systems[top],
                outputs: self.outputs,
                inputs: self.inputs,
                highest: self.frequencies.iter().copied().fold(0.0, f64::max),
            };
            files.extend(draw_impulse(&impulse, &folder)?);
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
    let database = Database::read(&file)?;
    let damaged = || UsageError(format!("{}: an array is missing or too short; run again", file.display()));
    let (positions, frequencies) = database.axes().ok_or_else(damaged)?;
    let (systems, families) = (database.systems().ok_or_else(damaged)?, database.families().ok_or_else(damaged)?);
    let header = &database.header;
    let shown = Shown {
        machine: &header.machine,
        axis: &header.axis,
        positions: &positions,
        frequencies: &frequencies,
        outputs: &header.outputs,
        inputs: &header.inputs,
        systems: &systems,
        families: &families,
        height: if arguments.logarithmic { HeightScale::Logarithmic } else { HeightScale::Linear },
    };
    let mut files = shown.draw(out, interrupt)?;
    files.extend(write_surfaces(out, &shown.map(&frequencies)?)?);
    go_on(interrupt)?;
    let manifest = out.join("manifest.json");
    let record = std::fs::read_to_string(&manifest)
        .map_err(|e| UsageError(format!("{}: {e}; the page says what was run from it", manifest.display())))?;
    // What is embedded is JSON, whatever the file holds.
    let record: serde_json::Value =
        serde_json::from_str(&record).map_err(|e| UsageError(format!("{}: {e}", manifest.display())))?;
    let page = out.join(PAGE_FILE);
    write_page(&page, &database, &record.to_string())?;
    files.push(page);
    for file in files {
        eprintln!("{}", file.display());
    }
    Ok(())
}

/// `surface_<label>.vts` of every direct response; returns the files.
pub fn write_surfaces(out: &Path, map: &ComplianceMap) -> Result<Vec<PathBuf>> {
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
