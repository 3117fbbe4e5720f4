//! One response over positions and frequencies as a surface for ParaView (`.vts`).
//!
//! A structured grid of points, frequencies fastest, with the numbers appended raw behind the
//! XML. The geometry is scaled to be looked at: positions span 0 to 1 along x, frequencies 0 to
//! 1.6 along y, the decades of the magnitude 0 to 0.6 along z. The point arrays hold the numbers.

use std::io::Write;
use std::path::Path;

use super::response::{Response, index, unit};
use super::{ExportError, atomic, finite, length};
use crate::frf::ComplianceMap;

/// Lengths of the box that the surface fills: position, frequency, magnitude.
const BOX: [f64; 3] = [1.0, 1.6, 0.6];

/// Writes one response with the point arrays `position_m`, `frequency_hz`, `magnitude`,
/// `phase_deg`, `log10_magnitude`; the field data `unit` says what the magnitude is in.
///
/// A response of exactly zero stands at the height of the smallest one above zero.
///
/// # Errors
/// [`ExportError::Shape`] if the values do not fill the map, [`ExportError::NotFinite`] for NaN and
/// infinities with their place, [`ExportError::Io`] if the file cannot be written.
///
/// # Panics
/// If the response is not one of the map.
pub fn write_surface(path: &Path, map: &ComplianceMap, response: &Response) -> Result<(), ExportError> {
    let (n_position, n_frequency) = (map.positions.len(), map.frequencies.len());
    let (n_out, n_in) = (map.outputs.len(), map.inputs.len());
    length(path, "the map", map.values.len(), n_position * n_frequency * n_out * n_in)?;
    assert!(response.output < n_out && response.input < n_in, "{response:?} of {n_out} x {n_in}");
    let mut arrays: [Vec<f64>; 5] = Default::default();
    for (p, &position) in map.positions.iter().enumerate() {
        for (f, &frequency) in map.frequencies.iter().enumerate() {
            let value = map.values[index(map, p, f, response)];
            let magnitude = value.re.hypot(value.im);
            let sum = magnitude + position.abs() + frequency.abs();
            finite(path, sum, || format!("the response at {position} m and {frequency} Hz"))?;
            let phase = value.im.atan2(value.re).to_degrees();
            let row = [position, frequency, magnitude, phase, magnitude];
            arrays.iter_mut().zip(row).for_each(|(a, v)| a.push(v));
        }
    }
    let floor = arrays[2].iter().copied().filter(|m| *m > 0.0).fold(f64::INFINITY, f64::min);
    let floor = if floor.is_finite() { floor } else { 1.0 };
    arrays[4].iter_mut().for_each(|m| *m = m.max(floor).log10());

    let axes = [unit_scale(&arrays[0]), unit_scale(&arrays[1]), unit_scale(&arrays[4])];
    let points: Vec<f64> = (0..arrays[0].len())
        .flat_map(|i| [arrays[0][i], arrays[1][i], arrays[4][i]])
        .enumerate()
        .map(|(k, v)| (v - axes[k % 3].0) * axes[k % 3].1 * BOX[k % 3])
        .collect();
    let names = ["position_m", "frequency_hz", "magnitude", "phase_deg", "log10_magnitude"];
    let header = header(n_position, n_frequency, unit(map.quantity), &names);
    atomic::write_atomic(path, |file| {
        let mut all = || -> std::io::Result<()> {
            file.write_all(header.as_bytes())?;
            for array in std::iter::once(&points).chain(&arrays) {
                file.write_all(&(8 * array.len() as u64).to_ne_bytes())?;
                file.write_all(bytemuck::cast_slice(array))?;
            }
            file.write_all(b"\n  </AppendedData>\n</VTKFile>\n")
        };
        all().map_err(atomic::io(path, "write"))
    })
}

/// Smallest value and the reciprocal of the range (0 where all are equal).
fn unit_scale(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (low, if high > low { 1.0 / (high - low) } else { 0.0 })
}

fn header(n_position: usize, n_frequency: usize, unit: &str, names: &[&str]) -> String {
    let order = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };
    let extent = format!("0 {} 0 {} 0 0", n_frequency.saturating_sub(1), n_position.saturating_sub(1));
    let numbers = n_position * n_frequency;
    let mut offset = 8 + 24 * numbers;
    let mut arrays = String::new();
    for name in names {
        arrays +=
            &format!("        <DataArray type=\"Float64\" Name=\"{name}\" format=\"appended\" offset=\"{offset}\"/>\n");
        offset += 8 + 8 * numbers;
    }
    let codes: Vec<String> = unit.bytes().chain([0]).map(|b| b.to_string()).collect();
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="StructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">
  <StructuredGrid WholeExtent="{extent}">
    <FieldData>
      <Array type="String" Name="unit" NumberOfTuples="1" format="ascii">{}</Array>
    </FieldData>
    <Piece Extent="{extent}">
      <PointData Scalars="magnitude">
{arrays}      </PointData>
      <Points>
        <DataArray type="Float64" Name="Points" NumberOfComponents="3" format="appended" offset="0"/>
      </Points>
    </Piece>
  </StructuredGrid>
  <AppendedData encoding="raw">
   _"#,
        codes.join(" ")
    )
}
