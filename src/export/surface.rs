//! One response over positions and frequencies as CSV, long form.

use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::Complex;
use rayon::prelude::*;

use super::response::{Response, direct_responses, index};
use super::{ExportError, atomic, digits, finite, length};
use crate::frf::{ComplianceMap, Quantity};

/// Writes `surface_<label>.csv` for every direct response of the map; returns the paths.
///
/// # Errors
/// As [`write_surface`].
pub fn write_direct_surfaces(folder: &Path, map: &ComplianceMap) -> Result<Vec<PathBuf>, ExportError> {
    direct_responses(map)
        .iter()
        .map(|response| {
            let path = folder.join(format!("surface_{}.csv", response.label));
            write_surface(&path, map, response).map(|()| path)
        })
        .collect()
}

/// Writes one response: `position_m, frequency_hz, magnitude_m_per_N, phase_deg`.
///
/// One line a position and frequency, frequencies fastest. The magnitude has nine significant
/// digits, the phase six decimals in (-180, 180]. For mobility and accelerance the third column is
/// `magnitude_m_per_s_N` and `magnitude_m_per_s2_N`.
///
/// # Errors
/// [`ExportError::Shape`] if the values do not fill the map, [`ExportError::NotFinite`] for NaN and
/// infinities with their place, [`ExportError::Io`] if the file cannot be written.
///
/// # Panics
/// If the response is not one of the map.
pub fn write_surface(path: &Path, map: &ComplianceMap, response: &Response) -> Result<(), ExportError> {
    let (n_out, n_in) = (map.outputs.len(), map.inputs.len());
    let per_position = map.frequencies.len() * n_out * n_in;
    length(path, "the map", map.values.len(), map.positions.len() * per_position)?;
    assert!(response.output < n_out && response.input < n_in, "{response:?} of {n_out} x {n_in}");

    let frequencies: Vec<String> = map.frequencies.iter().map(|f| format!(",{f},")).collect();
    let blocks: Vec<Vec<u8>> = (0..map.positions.len())
        .into_par_iter()
        .map(|p| block(path, map, response, p, &frequencies))
        .collect::<Result<_, _>>()?;
    let column = match map.quantity {
        Quantity::Receptance => "magnitude_m_per_N",
        Quantity::Mobility => "magnitude_m_per_s_N",
        Quantity::Accelerance => "magnitude_m_per_s2_N",
    };
    atomic::write_atomic(path, |file| {
        let fail = atomic::io(path, "write");
        writeln!(file, "position_m,frequency_hz,{column},phase_deg").map_err(&fail)?;
        blocks.iter().try_for_each(|b| file.write_all(b).map_err(&fail))
    })
}

/// The lines of one position.
fn block(
    path: &Path,
    map: &ComplianceMap,
    response: &Response,
    p: usize,
    frequencies: &[String],
) -> Result<Vec<u8>, ExportError> {
    let position = finite(path, map.positions[p], || format!("position {p}"))?.to_string();
    let mut lines = Vec::with_capacity(frequencies.len() * 48);
    for (f, frequency) in frequencies.iter().enumerate() {
        let Complex { re, im } = map.values[index(map, p, f, response)];
        let magnitude = re.hypot(im);
        if !(magnitude.is_finite() && map.frequencies[f].is_finite()) {
            return Err(ExportError::NotFinite {
                path: path.into(),
                what: format!("the response at {position} m and {} Hz", map.frequencies[f]),
                value: magnitude,
            });
        }
        lines.extend_from_slice(position.as_bytes());
        lines.extend_from_slice(frequency.as_bytes());
        digits::scientific(&mut lines, magnitude);
        lines.push(b',');
        digits::fixed6(&mut lines, im.atan2(re).to_degrees());
        lines.push(b'\n');
    }
    Ok(lines)
}
