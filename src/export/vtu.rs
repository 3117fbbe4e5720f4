//! Mode shapes at one position for ParaView (`.vtu`): the parts' thinned outer surfaces, a vector a mode.

use std::io::Write;
use std::path::Path;

use super::{ExportError, atomic, finite};
use crate::coupling::CoupledModel;
use crate::linalg::multiply;
use crate::modal::Modes;
use crate::reduction::Superelement;

/// VTK's number for a triangle.
const TRIANGLE: u8 = 5;

/// Writes the shapes of the lowest `listed` modes at a position on the parts' skins.
///
/// Points stand where the parts are at that position (m). Point arrays `shape_01`, `shape_02`, ..,
/// numbered by rank, hold the mass-normalised displacement, kg^(-1/2), with three components; the cell
/// array `part` the number of the part, from 0; the field data `position_m` the position,
/// `frequency_hz` the frequencies by rank (0 for free motions) and `damping_ratio` their damping.
///
/// The local dent that a joint's force makes in a part beyond the fixed basis is left out: it is in the
/// frequencies, but not in these pictures.
///
/// # Errors
/// [`ExportError::NotFinite`] for NaN and infinities with their place, [`ExportError::Io`] if the file
/// cannot be written.
pub fn write_mode_shapes(
    path: &Path,
    model: &CoupledModel,
    superelements: &[Superelement],
    modes: &Modes,
    listed: usize,
) -> Result<(), ExportError> {
    let listed = listed.min(modes.shapes.ncols());
    let shapes = modes.shapes.columns(0, listed).into_owned();
    let axis = model.axis();
    let (mut points, mut triangles, mut parts) = (Vec::new(), Vec::new(), Vec::new());
    let mut vectors: Vec<Vec<f32>> = vec![Vec::new(); listed];
    for (i, (share, superelement)) in model.parts.iter().zip(superelements).enumerate() {
        let skin = &superelement.skin;
        let first = points.len() / 3;
        let travel = if axis.moves[i] { modes.position } else { 0.0 };
        let moved = skin.nodes.iter().flat_map(|x| [0, 1, 2].map(|c| (x[c] + travel * axis.direction[c]) as f32));
        points.extend(moved);
        triangles.extend(skin.triangles.iter().flatten().map(|n| (n + first) as i64));
        parts.extend(std::iter::repeat_n(i as i32, skin.triangles.len()));
        let displacements = multiply(&skin.basis, &multiply(&share.basis, &shapes));
        for (r, vector) in vectors.iter_mut().enumerate() {
            for (k, value) in displacements.column(r).iter().enumerate() {
                let place = || format!("the shape of rank {} at node {} of part \"{}\"", r + 1, k / 3, share.name);
                vector.push(finite(path, *value, place)? as f32);
            }
        }
    }
    let cells = triangles.len() / 3;
    let offsets: Vec<i64> = (1..=cells as i64).map(|c| 3 * c).collect();
    let types = vec![TRIANGLE; cells];
    let frequencies: Vec<f64> = (0..listed).map(|r| modes.frequency(r)).collect();
    let damping: Vec<f64> = (0..listed).map(|r| modes.damping_ratios[r] + 0.5 * modes.loss_factors[r]).collect();

    let mut file = Appended::default();
    let position = file.array("position_m", "Float64", 0, 1, bytemuck::cast_slice(&[modes.position]));
    let frequency = file.array("frequency_hz", "Float64", 0, listed, bytemuck::cast_slice(&frequencies));
    let ratio = file.array("damping_ratio", "Float64", 0, listed, bytemuck::cast_slice(&damping));
    let places = file.array("Points", "Float32", 3, 0, bytemuck::cast_slice(&points));
    let connectivity = file.array("connectivity", "Int64", 0, 0, bytemuck::cast_slice(&triangles));
    let ends = file.array("offsets", "Int64", 0, 0, bytemuck::cast_slice(&offsets));
    let kinds = file.array("types", "UInt8", 0, 0, &types);
    let part = file.array("part", "Int32", 0, 0, bytemuck::cast_slice(&parts));
    let named = vectors.iter().enumerate().map(|(r, v)| (format!("shape_{:02}", r + 1), v));
    let point_data: String =
        named.map(|(name, v)| file.array(&name, "Float32", 3, 0, bytemuck::cast_slice(v))).collect();
    let order = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };
    let header = format!(
        r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">
<UnstructuredGrid>
<FieldData>
{position}{frequency}{ratio}</FieldData>
<Piece NumberOfPoints="{}" NumberOfCells="{cells}">
<PointData>
{point_data}</PointData>
<CellData>
{part}</CellData>
<Points>
{places}</Points>
<Cells>
{connectivity}{ends}{kinds}</Cells>
</Piece>
</UnstructuredGrid>
<AppendedData encoding="raw">
_"#,
        points.len() / 3
    );
    atomic::write_atomic(path, |out| {
        let mut all = || -> std::io::Result<()> {
            out.write_all(header.as_bytes())?;
            out.write_all(&file.bytes)?;
            out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
        };
        all().map_err(atomic::io(path, "write"))
    })
}

/// The raw block behind the XML.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    /// Appends an array and returns its XML; components and tuples are named where they are not 0.
    fn array(&mut self, name: &str, kind: &str, components: usize, tuples: usize, values: &[u8]) -> String {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(&(values.len() as u64).to_ne_bytes());
        self.bytes.extend_from_slice(values);
        let components = if components > 0 { format!(" NumberOfComponents=\"{components}\"") } else { String::new() };
        let tuples = if tuples > 0 { format!(" NumberOfTuples=\"{tuples}\"") } else { String::new() };
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\"{components}{tuples} format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }
}
