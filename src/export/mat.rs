//! `compliance.mat` and `state_space.mat`, for MATLAB, Octave and SciPy.

use std::borrow::Cow;
use std::path::Path;

use nalgebra::{Complex, DMatrix};
use rayon::prelude::*;

use super::mat5::{self, Value};
use super::{ExportError, finite, length, npy, response};
use crate::frf::{ComplianceMap, FrfRequest};
use crate::state_space::{Aligned, Database, Hold, StateSpace, StateSpaceOptions};

/// Columns of the transposition that one task takes: a row of them fills whole cache lines.
const BLOCK: usize = 16;

/// Writes `compliance.mat`.
///
/// | variable | shape | unit |
/// |---|---|---|
/// | `position_m` | n_position x 1 | m |
/// | `frequency_hz` | n_frequency x 1 | Hz |
/// | `output`, `input` | cell columns of names | |
/// | `quantity`, `unit` | text | |
/// | `receptance` (or `mobility`, `accelerance`) | n_position x n_frequency x n_output x n_input, complex | `unit` |
///
/// # Errors
/// [`ExportError::Shape`] if the values do not fill the map, [`ExportError::NotFinite`] for NaN and
/// infinities, [`ExportError::TooLarge`] past the format's 2^31 bytes (119 million values),
/// [`ExportError::Io`] if the file cannot be written.
pub fn write_compliance(path: &Path, map: &ComplianceMap) -> Result<(), ExportError> {
    let dims = [map.positions.len(), map.frequencies.len(), map.outputs.len(), map.inputs.len()];
    length(path, "the map", map.values.len(), dims.iter().product())?;
    check_axis(path, "position", &map.positions)?;
    check_axis(path, "frequency", &map.frequencies)?;
    check_map(path, map)?;
    let (re, im) = column_major(&map.values, dims);
    let name = map.quantity.name();
    mat5::write(
        path,
        &[
            ("position_m", Value::column(&map.positions)),
            ("frequency_hz", Value::column(&map.frequencies)),
            ("output", Value::names(&map.outputs)),
            ("input", Value::names(&map.inputs)),
            ("quantity", Value::Text(Cow::Borrowed(name))),
            ("unit", Value::Text(Cow::Borrowed(response::unit(map.quantity)))),
            (name, Value::Complex { dims: dims.to_vec(), re: re.into(), im: im.into() }),
        ],
    )
}

/// Writes `compliance.mat` for a map that stands in a file of its own: the axes, and where the values are.
///
/// | variable | shape | |
/// |---|---|---|
/// | `position_m`, `frequency_hz`, `output`, `input`, `quantity`, `unit` | | as [`write_compliance`] |
/// | `file` | text | name of the values' file, in the same folder |
/// | `shape` | 1 x 4 | positions, frequencies, outputs, inputs; the last is fastest in the file |
/// | `offset_bytes` | 1 x 1 | where in the file the values begin, complex f64 |
///
/// # Errors
/// As [`write_compliance`].
pub fn write_axes(path: &Path, request: &FrfRequest, file: &str) -> Result<(), ExportError> {
    check_axis(path, "position", request.positions)?;
    check_axis(path, "frequency", request.frequencies)?;
    let extents = npy::extents(request);
    let shape: Vec<f64> = extents.iter().map(|n| *n as f64).collect();
    mat5::write(
        path,
        &[
            ("position_m", Value::column(request.positions)),
            ("frequency_hz", Value::column(request.frequencies)),
            ("output", Value::names(request.outputs)),
            ("input", Value::names(request.inputs)),
            ("quantity", Value::Text(Cow::Borrowed(request.quantity.name()))),
            ("unit", Value::Text(Cow::Borrowed(response::unit(request.quantity)))),
            ("file", Value::Text(Cow::Borrowed(file))),
            ("shape", Value::Real { dims: vec![1, 4], data: Cow::Owned(shape) }),
            ("offset_bytes", Value::scalar(npy::header(&extents).len() as f64)),
        ],
    )
}

/// Writes `state_space.mat`: the 1 x n struct array `states`, one struct a position (the paper's
/// figure 6), and what its rows and columns are.
///
/// | field | shape |
/// |---|---|
/// | `position` | 1 x 1, m |
/// | `A`, `B`, `C`, `D` | as [`StateSpace`] |
/// | `eigenvalues` | n x 1, (rad/s)^2 |
/// | `eigenvectors` | n x n_output, kg^(-1/2) |
/// | `damping` | n x 1 |
///
/// `inputs` and `outputs` are cell columns of names, `units` a struct of texts. With velocity
/// and acceleration rows, C has the displacement rows of all outputs first, then the others.
///
/// # Errors
/// [`ExportError::Shape`] if matrices do not fit each other or the names,
/// [`ExportError::NotFinite`] for NaN and infinities, [`ExportError::TooLarge`] past 2^31 bytes,
/// [`ExportError::Io`] if the file cannot be written.
pub fn write_state_space(
    path: &Path,
    states: &[StateSpace],
    outputs: &[String],
    inputs: &[String],
) -> Result<(), ExportError> {
    write_states(path, states.len(), &|i| Cow::Borrowed(&states[i]), outputs, inputs, Vec::new())
}

/// What the rows and columns of state spaces are, and whether time is discrete.
#[derive(Clone, Copy, Debug)]
pub struct StateLabels<'a> {
    /// Names of the outputs.
    pub outputs: &'a [String],
    /// Names of the inputs.
    pub inputs: &'a [String],
    /// Which rows there are.
    pub options: StateSpaceOptions,
    /// Sample time (s) and hold of systems that are discretised.
    pub discrete: Option<(f64, Hold)>,
}

impl StateLabels<'_> {
    fn variables(&self) -> Vec<(&'static str, Value<'static>)> {
        let quantities =
            [("displacement", true), ("velocity", self.options.velocity), ("acceleration", self.options.acceleration)];
        let given = quantities.into_iter().filter(|(_, is_given)| *is_given);
        let rows: Vec<String> = given.flat_map(|(q, _)| self.outputs.iter().map(move |o| format!("{q} {o}"))).collect();
        let rows = rows.into_iter().map(|row| Value::Text(Cow::Owned(row))).collect::<Vec<_>>();
        let (sample_time, hold) = self.discrete.map_or((0.0, ""), |(time, hold)| (time, hold.name()));
        vec![
            ("sample_time", Value::scalar(sample_time)),
            ("hold", Value::Text(Cow::Borrowed(hold))),
            ("rows", Value::Cell { dims: vec![rows.len(), 1], values: rows }),
        ]
    }
}

/// Writes what [`write_state_space`] writes, `states` making each of `count` systems when it is written, in the memory
/// of one, and
///
/// | variable | content |
/// |---|---|
/// | `sample_time`, `hold` | s and `zero` or `first` for discretised states; 0 and an empty text for continuous ones |
/// | `rows` | cell column: quantity and output of each row of C and D |
///
/// # Errors
/// As [`write_state_space`].
pub fn write_state_spaces<'s>(
    path: &Path,
    count: usize,
    states: &dyn Fn(usize) -> Cow<'s, StateSpace>,
    labels: &StateLabels<'_>,
) -> Result<(), ExportError> {
    write_states(path, count, states, labels.outputs, labels.inputs, labels.variables())
}

/// Writes what [`write_state_spaces`] writes, of a whole database, and
///
/// | variable | content |
/// |---|---|
/// | `aligned` | struct of arrays over the positions that may be interpolated entry by entry: `position`, `stiffness`, `damping` (n_position x n x n), `inputs`, `outputs`, `compliance` |
/// | `leave_one_out` | n_position x 1, share of the peak when a position is interpolated from the others; NaN at the ends, infinite where it cannot be |
///
/// `states` of the database are written as they are: discretise them before, and say how in `discrete`.
///
/// # Errors
/// As [`write_state_space`].
pub fn write_database(
    path: &Path,
    database: &Database,
    outputs: &[String],
    inputs: &[String],
    discrete: Option<(f64, Hold)>,
) -> Result<(), ExportError> {
    let mut variables = StateLabels { outputs, inputs, options: database.options, discrete }.variables();
    let aligned = &database.aligned;
    let positions: Vec<f64> = aligned.iter().map(|a| a.position).collect();
    let stacked = |what: &str, of: fn(&Aligned) -> &DMatrix<f64>| {
        let (n, m) = aligned.first().map_or((0, 0), |a| of(a).shape());
        for a in aligned {
            length(path, &format!("aligned {what} at {} m", a.position), of(a).len(), n * m)?;
            check_axis(path, &format!("aligned {what} at {} m", a.position), of(a).as_slice())?;
        }
        let data = (0..n * m).flat_map(|k| aligned.iter().map(move |a| of(a).as_slice()[k])).collect::<Vec<_>>();
        Ok(Value::Real { dims: vec![aligned.len(), n, m], data: data.into() })
    };
    let fields = vec!["position", "stiffness", "damping", "inputs", "outputs", "compliance"];
    let values = vec![
        Value::Real { dims: vec![positions.len(), 1], data: positions.into() },
        stacked("stiffness", |a| &a.stiffness)?,
        stacked("damping", |a| &a.damping)?,
        stacked("inputs", |a| &a.inputs)?,
        stacked("outputs", |a| &a.outputs)?,
        stacked("compliance", |a| &a.compliance)?,
    ];
    let figures: Vec<f64> = database.leave_one_out.iter().map(|f| f.unwrap_or(f64::NAN)).collect();
    variables.push(("aligned", Value::Structs { fields, values: vec![values] }));
    variables.push(("leave_one_out", Value::Real { dims: vec![figures.len(), 1], data: figures.into() }));
    let states = |i: usize| Cow::Borrowed(&database.states[i]);
    write_states(path, database.states.len(), &states, outputs, inputs, variables)
}

fn write_states<'s>(
    path: &Path,
    count: usize,
    states: &dyn Fn(usize) -> Cow<'s, StateSpace>,
    outputs: &[String],
    inputs: &[String],
    more: Vec<(&'static str, Value<'_>)>,
) -> Result<(), ExportError> {
    let visit = |i: usize, visitor: &mut mat5::Visitor<'_>| {
        let s = states(i);
        check_state(path, &s, outputs.len(), inputs.len())?;
        visitor(&[
            Value::scalar(s.position),
            Value::matrix(&s.a),
            Value::matrix(&s.b),
            Value::matrix(&s.c),
            Value::matrix(&s.d),
            Value::column(&s.eigenvalues),
            Value::matrix(&s.eigenvectors),
            Value::column(&s.damping),
        ])
    };
    let fields = vec!["position", "A", "B", "C", "D", "eigenvalues", "eigenvectors", "damping"];
    let structs = mat5::Structs { name: "states", fields, count, visit: &visit };
    let text = |t| Value::Text(Cow::Borrowed(t));
    let units = Value::Structs {
        fields: vec!["position", "input", "displacement", "velocity", "acceleration", "eigenvalues"],
        values: vec![vec![text("m"), text("N"), text("m"), text("m/s"), text("m/s^2"), text("(rad/s)^2")]],
    };
    let mut variables = vec![("inputs", Value::names(inputs)), ("outputs", Value::names(outputs)), ("units", units)];
    variables.extend(more);
    mat5::write_structs(path, &structs, &variables)
}

/// Real and imaginary parts of a row-major array of four indices in column-major order.
///
/// Blocks of frequencies go to the threads; each reads its rows once and writes runs of positions.
fn column_major(values: &[Complex<f64>], dims: [usize; 4]) -> (Vec<f64>, Vec<f64>) {
    let [n_position, n_frequency, n_out, n_in] = dims;
    let entries = n_out * n_in;
    let mut re = vec![0.0; values.len()];
    let mut im = vec![0.0; values.len()];
    if values.is_empty() {
        return (re, im);
    }
    let plane = n_position * n_frequency;
    let blocks = n_frequency.div_ceil(BLOCK);
    let mut tasks: Vec<Vec<(&mut [f64], &mut [f64])>> = Vec::new();
    tasks.resize_with(blocks, Vec::new);
    for (re, im) in re.chunks_mut(plane).zip(im.chunks_mut(plane)) {
        let parts = re.chunks_mut(BLOCK * n_position).zip(im.chunks_mut(BLOCK * n_position));
        tasks.iter_mut().zip(parts).for_each(|(task, part)| task.push(part));
    }
    tasks.into_par_iter().enumerate().for_each(|(block, mut planes)| {
        let first = block * BLOCK;
        let width = BLOCK.min(n_frequency - first);
        for p in 0..n_position {
            let rows = &values[(p * n_frequency + first) * entries..][..width * entries];
            for (f, row) in rows.chunks_exact(entries).enumerate() {
                for (entry, value) in row.iter().enumerate() {
                    // Plane k of the output holds output k % n_out and input k / n_out.
                    let (re, im) = &mut planes[(entry % n_in) * n_out + entry / n_in];
                    re[f * n_position + p] = value.re;
                    im[f * n_position + p] = value.im;
                }
            }
        }
    });
    (re, im)
}

fn check_axis(path: &Path, what: &str, values: &[f64]) -> Result<(), ExportError> {
    values.iter().enumerate().try_for_each(|(i, v)| finite(path, *v, || format!("{what} {i}")).map(drop))
}

/// Refuses a map with NaN or infinities, naming the first place.
fn check_map(path: &Path, map: &ComplianceMap) -> Result<(), ExportError> {
    let bad = map.values.par_iter().position_first(|v| !(v.re.is_finite() && v.im.is_finite()));
    let Some(at) = bad else { return Ok(()) };
    let (n_out, n_in) = (map.outputs.len(), map.inputs.len());
    let (pair, place) = (at % (n_out * n_in), at / (n_out * n_in));
    let (p, f) = (place / map.frequencies.len(), place % map.frequencies.len());
    let value = map.values[at];
    Err(ExportError::NotFinite {
        path: path.into(),
        what: format!(
            "the {} from {} to {} at {} m and {} Hz",
            map.quantity.name(),
            map.inputs[pair % n_in],
            map.outputs[pair / n_in],
            map.positions[p],
            map.frequencies[f]
        ),
        value: if value.re.is_finite() { value.im } else { value.re },
    })
}

fn check_state(path: &Path, s: &StateSpace, n_out: usize, n_in: usize) -> Result<(), ExportError> {
    let at = |name: &str| format!("{name} at {} m", s.position);
    let order = 2 * s.eigenvalues.len();
    let rows = s.c.nrows();
    finite(path, s.position, || "a position".to_owned())?;
    let extents = [
        ("rows of A", s.a.nrows(), order),
        ("columns of A", s.a.ncols(), order),
        ("rows of B", s.b.nrows(), order),
        ("columns of B", s.b.ncols(), n_in),
        ("rows of C", rows, rows.max(n_out).next_multiple_of(n_out.max(1))),
        ("columns of C", s.c.ncols(), order),
        ("rows of D", s.d.nrows(), rows),
        ("columns of D", s.d.ncols(), n_in),
        ("the eigenvectors' rows", s.eigenvectors.nrows(), s.eigenvalues.len()),
        ("the eigenvectors' columns", s.eigenvectors.ncols(), n_out),
        ("the damping", s.damping.len(), s.eigenvalues.len()),
    ];
    for (what, seen, expected) in extents {
        length(path, &at(what), seen, expected)?;
    }
    let matrices: [(&str, &DMatrix<f64>); 5] =
        [("A", &s.a), ("B", &s.b), ("C", &s.c), ("D", &s.d), ("eigenvectors", &s.eigenvectors)];
    for (name, m) in matrices {
        check_axis(path, &at(&format!("{name} (column by column)")), m.as_slice())?;
    }
    check_axis(path, &at("eigenvalue"), &s.eigenvalues)?;
    check_axis(path, &at("damping ratio"), &s.damping)
}
