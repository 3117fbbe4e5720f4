//! Pictures of the results, as PNG and SVG for print at 16 cm width, both from the same strokes.
//!
//! | file | shows | in the paper |
//! |---|---|---|
//! | `eigenfrequencies.png` | eigenfrequencies over the position, a line a family | figure 8 |
//! | `impulse_time.png` | displacements after a push of 1 N and 1 ms in all directions | figure 9 |
//! | `impulse_frequency.png` | their spectrum over that of the push | figure 10 |
//! | `frf_<label>_amplitude.png` | magnitude as a surface over position and frequency | figures 11 to 13 |
//! | `frf_<label>_frequency.png` | logarithm of the magnitude as a map, position against frequency | figures 14 to 16 |
//! | `time_history.png`, `spectrum.png` | displacements over time, magnitudes over frequency, a curve an output | figures 9, 10 |
//!
//! The paper turns its surface until the shift of the peaks in frequency can be seen; the map
//! shows the same without hiding anything, in the axes of figure 8. Where the map has a single
//! position (or frequency), both views are a curve over the other axis. Peaks survive the
//! pictures' resolution: where several samples fall on a pixel, the largest is drawn.
//!
//! Drawn by this module itself, with `ab_glyph` for the outlines of the bundled font and `png` for
//! the files: the surface needs its own order of drawing, and print needs even letter spacing.

mod amplitude_view;
mod box_view;
mod canvas;
mod colour;
mod curve;
mod eigenfrequencies;
mod field;
mod frame;
mod frequency_view;
mod history;
mod impulse;
pub mod report;
mod scale;
pub mod sweep;
mod text;
mod vector;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::export::response::{self, Response, direct_responses};
use crate::export::{ExportError, atomic};
use crate::frf::{ComplianceMap, FrfError};
use crate::modal::ModeFamilies;
use crate::response::ResponseError;
use canvas::Canvas;
use field::Field;

pub use history::{draw_history, draw_spectrum};
pub use impulse::{ImpulseInput, draw_impulse};

/// What the height of the amplitude view is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum HeightScale {
    /// The magnitude, as in the paper.
    #[default]
    Linear,
    /// Its logarithm.
    Logarithmic,
}

/// What the pictures are made of.
#[derive(Clone, Copy, Debug)]
pub struct FigureInput<'a> {
    /// Name of the machine, for the headings.
    pub machine: &'a str,
    /// Name of the axis that moves, such as `z`.
    pub axis: &'a str,
    /// Modes over the positions.
    pub families: &'a ModeFamilies,
    /// The responses; its direct ones are drawn.
    pub map: &'a ComplianceMap,
    /// Height of the amplitude view.
    pub height: HeightScale,
}

/// Why a picture was not drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// A number is NaN or infinite.
    #[error("{figure}: {what} is {value}; only finite numbers are drawn")]
    NotFinite {
        /// The picture.
        figure: String,
        /// Which number, with its place.
        what: String,
        /// The value seen.
        value: f64,
    },
    /// Parts of the input do not fit together, or there is nothing to draw.
    #[error("{figure}: {what} has {seen} entries, expected {expected}")]
    Shape {
        /// The picture.
        figure: String,
        /// Which array.
        what: String,
        /// Entries seen.
        seen: usize,
        /// Entries expected.
        expected: String,
    },
    /// The picture could not be made into a PNG file.
    #[error("{}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// The encoder's reason.
        reason: String,
    },
    /// A spectrum could not be computed.
    #[error(transparent)]
    Frf(FrfError),
    /// A time history could not be computed.
    #[error(transparent)]
    Response(ResponseError),
    /// The file could not be written.
    #[error(transparent)]
    Export(#[from] ExportError),
}

/// One picture to draw.
enum Picture<'a> {
    Eigenfrequencies,
    Amplitude(&'a Response),
    Frequency(&'a Response),
}

/// Draws all pictures into a folder as PNG and SVG, in parallel; returns their paths, eigenfrequencies first.
///
/// # Errors
/// [`FigureError::NotFinite`] and [`FigureError::Shape`] with the place of what cannot be drawn,
/// [`FigureError::Encode`] and [`FigureError::Export`] if a file cannot be written. Pictures
/// that were ready before the error stay.
pub fn draw_all(input: &FigureInput, folder: &Path) -> Result<Vec<PathBuf>, FigureError> {
    let responses = direct_responses(input.map);
    let mut pictures = vec![(Picture::Eigenfrequencies, "eigenfrequencies.png".to_owned())];
    for r in &responses {
        pictures.push((Picture::Amplitude(r), format!("frf_{}_amplitude.png", r.label)));
        pictures.push((Picture::Frequency(r), format!("frf_{}_frequency.png", r.label)));
    }
    pictures
        .into_par_iter()
        .with_max_len(1)
        .map(|(picture, name)| {
            let path = folder.join(&name);
            let canvas = draw(input, &picture, &name)?;
            write_both(&path, &canvas)
        })
        .collect::<Result<Vec<_>, _>>()
        .map(|files| files.into_iter().flatten().collect())
}

/// Writes a picture as PNG under its path, and as SVG beside it.
fn write_both(path: &Path, canvas: &Canvas) -> Result<[PathBuf; 2], FigureError> {
    let vector = path.with_extension("svg");
    atomic::write_bytes(path, &canvas.png(path)?)?;
    atomic::write_bytes(&vector, canvas.svg().as_bytes())?;
    Ok([path.into(), vector])
}

/// Draws the surfaces of all outputs for the map's first input, in both views, `frf_<output>_amplitude.png`
/// and `frf_<output>_frequency.png`, with an SVG beside each; returns their paths.
///
/// # Errors
/// As [`draw_all`].
pub fn draw_surfaces(
    machine: &str,
    axis: &str,
    map: &ComplianceMap,
    height: HeightScale,
    folder: &Path,
) -> Result<Vec<PathBuf>, FigureError> {
    let responses: Vec<Response> = (map.outputs.iter().enumerate())
        .map(|(output, name)| Response { output, input: 0, label: response::safe(name) })
        .collect();
    let pictures: Vec<(&Response, bool)> = responses.iter().flat_map(|r| [(r, true), (r, false)]).collect();
    pictures
        .into_par_iter()
        .with_max_len(1)
        .map(|(response, amplitude)| {
            let view = if amplitude { "amplitude" } else { "frequency" };
            let name = format!("frf_{}_{view}.png", response.label);
            let path = folder.join(&name);
            let canvas = draw_response(machine, axis, map, height, response, amplitude, &name)?;
            write_both(&path, &canvas)
        })
        .collect::<Result<Vec<_>, _>>()
        .map(|files| files.into_iter().flatten().collect())
}

fn draw(input: &FigureInput, picture: &Picture, name: &str) -> Result<Canvas, FigureError> {
    let (response, amplitude) = match picture {
        Picture::Eigenfrequencies => {
            return eigenfrequencies::draw(name, input.machine, input.axis, input.families);
        }
        Picture::Amplitude(response) => (response, true),
        Picture::Frequency(response) => (response, false),
    };
    draw_response(input.machine, input.axis, input.map, input.height, response, amplitude, name)
}

/// One response in one view; a curve where the map has one position or frequency.
fn draw_response(
    machine: &str,
    axis: &str,
    map: &ComplianceMap,
    height: HeightScale,
    response: &Response,
    amplitude: bool,
    name: &str,
) -> Result<Canvas, FigureError> {
    let field = Field::new(name, map, response)?;
    let heading = format!("{machine}: {}", field.title);
    Ok(if field.positions.len() == 1 || field.frequencies.len() == 1 {
        curve::draw(&heading, axis, &field, !amplitude)
    } else if amplitude {
        amplitude_view::draw(&heading, axis, &field, height)
    } else {
        frequency_view::draw(&heading, axis, &field)
    })
}

/// Label of the position axis.
fn position_label(axis: &str) -> String {
    format!("Position {axis} [mm]")
}

/// Label of the frequency axis.
const FREQUENCY_LABEL: &str = "Frequency [Hz]";
