//! Level 5 MAT-files: real and complex arrays of any rank, text, cells and struct arrays.
//!
//! A file is a 128-byte header and a sequence of elements, each an 8-byte tag (type, byte count)
//! and data padded to 8 bytes. An array is an element of elements: flags, dimensions, name, and
//! its data in column-major order. Data are written in the machine's own byte order, which the
//! header states, and uncompressed, since compression costs seconds and saves a few percent on
//! measured or computed spectra. Sizes are 32-bit: a variable of 2^31 bytes or more is refused.
//!
//! Source: MathWorks, MAT-File Format (level 5), 2023.

use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

use super::ExportError;
use super::atomic;

/// Largest size of a variable, bytes.
pub const LIMIT: u64 = (1 << 31) - 1;

const MI_INT8: u32 = 1;
const MI_UINT16: u32 = 4;
const MI_INT32: u32 = 5;
const MI_UINT32: u32 = 6;
const MI_DOUBLE: u32 = 9;
const MI_MATRIX: u32 = 14;

const MX_CELL: u32 = 1;
const MX_STRUCT: u32 = 2;
const MX_CHAR: u32 = 4;
const MX_DOUBLE: u32 = 6;
const COMPLEX: u32 = 0x800;

/// Longest name of a struct field with its terminating zero, as MATLAB reads it.
const FIELD_NAME_BYTES: usize = 64;

/// What a variable holds. Arrays are in column-major order: the first index is fastest.
#[derive(Clone, Debug)]
pub enum Value<'a> {
    /// Real numbers.
    Real {
        /// Extents, at least two.
        dims: Vec<usize>,
        /// As many numbers as the product of the extents.
        data: Cow<'a, [f64]>,
    },
    /// Complex numbers, the parts apart as the format wants them.
    Complex {
        /// Extents, at least two.
        dims: Vec<usize>,
        /// Real parts.
        re: Cow<'a, [f64]>,
        /// Imaginary parts.
        im: Cow<'a, [f64]>,
    },
    /// A row of characters.
    Text(Cow<'a, str>),
    /// A cell array.
    Cell {
        /// Extents, at least two.
        dims: Vec<usize>,
        /// As many values as the product of the extents.
        values: Vec<Value<'a>>,
    },
    /// A 1 x n struct array.
    Structs {
        /// Names of the fields.
        fields: Vec<&'static str>,
        /// Per struct, one value a field.
        values: Vec<Vec<Value<'a>>>,
    },
}

impl<'a> Value<'a> {
    /// One number.
    pub fn scalar(value: f64) -> Value<'a> {
        Value::Real { dims: vec![1, 1], data: Cow::Owned(vec![value]) }
    }

    /// A column of numbers.
    pub fn column(data: &'a [f64]) -> Value<'a> {
        Value::Real { dims: vec![data.len(), 1], data: Cow::Borrowed(data) }
    }

    /// A dense matrix.
    pub fn matrix(matrix: &'a nalgebra::DMatrix<f64>) -> Value<'a> {
        Value::Real { dims: vec![matrix.nrows(), matrix.ncols()], data: Cow::Borrowed(matrix.as_slice()) }
    }

    /// A column cell array of names.
    pub fn names(names: &'a [String]) -> Value<'a> {
        Value::Cell {
            dims: vec![names.len(), 1],
            values: names.iter().map(|n| Value::Text(Cow::Borrowed(n))).collect(),
        }
    }
}

/// Writes variables, in the given order, as one MAT-file.
///
/// # Errors
/// [`ExportError::TooLarge`] for a variable past [`LIMIT`], before anything is written;
/// [`ExportError::Io`] if the file cannot be written.
///
/// # Panics
/// If an array's length is not the product of its extents or a struct lacks a field.
pub fn write(path: &Path, variables: &[(&str, Value)]) -> Result<(), ExportError> {
    check_sizes(path, variables)?;
    atomic::write_atomic(path, |file| {
        let mut all = || -> io::Result<()> {
            header(file)?;
            variables.iter().try_for_each(|(name, value)| matrix(file, name, value))
        };
        all().map_err(atomic::io(path, "write"))
    })
}

/// A 1 x n struct array whose structs are made one after the other, twice: for their sizes, and to be written.
pub struct Structs<'a> {
    /// Name of the variable.
    pub name: &'a str,
    /// Names of the fields.
    pub fields: Vec<&'static str>,
    /// Number of structs.
    pub count: usize,
    /// Makes a struct's values, one a field, the same at each call, and hands them on.
    pub visit: &'a dyn Fn(usize, &mut Visitor<'_>) -> Result<(), ExportError>,
}

/// What [`Structs::visit`] hands a struct's values to.
pub type Visitor<'v> = dyn FnMut(&[Value<'_>]) -> Result<(), ExportError> + 'v;

/// Writes a struct array of any length in the memory of one struct, and variables behind it; as [`write()`].
///
/// # Errors
/// As [`write()`], and whatever `visit` returns.
///
/// # Panics
/// As [`write()`].
pub fn write_structs(path: &Path, structs: &Structs, variables: &[(&str, Value)]) -> Result<(), ExportError> {
    let empty = Value::Structs { fields: structs.fields.clone(), values: Vec::new() };
    let mut bytes = body_size(structs.name, &empty);
    for i in 0..structs.count {
        (structs.visit)(i, &mut |values| {
            bytes += values.iter().map(|v| 8 + body_size("", v)).sum::<u64>();
            Ok(())
        })?;
    }
    check_size(path, structs.name, 8 + bytes)?;
    check_sizes(path, variables)?;
    let fail = atomic::io(path, "write");
    atomic::write_atomic(path, |file| {
        let mut begin = || -> io::Result<()> {
            header(file)?;
            tag(file, MI_MATRIX, bytes)?;
            head(file, structs.name, MX_STRUCT, &[1, structs.count])?;
            field_names(file, &structs.fields)
        };
        begin().map_err(&fail)?;
        for i in 0..structs.count {
            (structs.visit)(i, &mut |values| {
                assert_eq!(values.len(), structs.fields.len(), "fields of a struct in `{}`", structs.name);
                values.iter().try_for_each(|v| matrix(file, "", v)).map_err(&fail)
            })?;
        }
        variables.iter().try_for_each(|(name, value)| matrix(file, name, value)).map_err(&fail)
    })
}

fn check_sizes(path: &Path, variables: &[(&str, Value)]) -> Result<(), ExportError> {
    variables.iter().try_for_each(|(name, value)| check_size(path, name, 8 + body_size(name, value)))
}

fn check_size(path: &Path, name: &str, bytes: u64) -> Result<(), ExportError> {
    if bytes <= LIMIT {
        return Ok(());
    }
    Err(ExportError::TooLarge { path: path.into(), variable: name.to_owned(), bytes, limit: LIMIT })
}

fn header(file: &mut impl Write) -> io::Result<()> {
    let text = concat!("MATLAB 5.0 MAT-file, written by stiffmap ", env!("CARGO_PKG_VERSION"));
    write!(file, "{text:<116}")?;
    file.write_all(&[0; 8])?;
    file.write_all(&0x0100_u16.to_ne_bytes())?;
    file.write_all(&0x4D49_u16.to_ne_bytes()) // "MI" in the machine's order
}

const fn padded(bytes: u64) -> u64 {
    bytes.div_ceil(8) * 8
}

/// Bytes of an element with its tag.
const fn element_size(bytes: usize) -> u64 {
    8 + padded(bytes as u64)
}

fn dims(value: &Value) -> Vec<usize> {
    match value {
        Value::Real { dims, .. } | Value::Complex { dims, .. } | Value::Cell { dims, .. } => dims.clone(),
        Value::Text(text) => {
            let units = text.encode_utf16().count();
            vec![usize::from(units > 0), units]
        }
        Value::Structs { values, .. } => vec![1, values.len()],
    }
}

/// Bytes of an array element after its tag.
fn body_size(name: &str, value: &Value) -> u64 {
    let head = element_size(8) + element_size(4 * dims(value).len()) + element_size(name.len());
    head + match value {
        Value::Real { data, .. } => element_size(8 * data.len()),
        Value::Complex { re, im, .. } => element_size(8 * re.len()) + element_size(8 * im.len()),
        Value::Text(text) => element_size(2 * text.encode_utf16().count()),
        Value::Cell { values, .. } => values.iter().map(|v| 8 + body_size("", v)).sum(),
        Value::Structs { fields, values } => {
            8 + element_size(FIELD_NAME_BYTES * fields.len())
                + values.iter().flatten().map(|v| 8 + body_size("", v)).sum::<u64>()
        }
    }
}

fn tag(file: &mut impl Write, kind: u32, bytes: u64) -> io::Result<()> {
    file.write_all(&kind.to_ne_bytes())?;
    file.write_all(&(bytes as u32).to_ne_bytes()) // at most LIMIT: checked in `write`
}

fn element<T: bytemuck::NoUninit>(file: &mut impl Write, kind: u32, data: &[T]) -> io::Result<()> {
    let bytes = bytemuck::cast_slice::<T, u8>(data);
    tag(file, kind, bytes.len() as u64)?;
    file.write_all(bytes)?;
    let padding = padded(bytes.len() as u64) as usize - bytes.len();
    file.write_all(&[0; 8][..padding])
}

/// Flags, extents and name of an array.
fn head(file: &mut impl Write, name: &str, class: u32, extents: &[usize]) -> io::Result<()> {
    element(file, MI_UINT32, &[class, 0])?;
    element(file, MI_INT32, &extents.iter().map(|&d| d as i32).collect::<Vec<_>>())?;
    element(file, MI_INT8, name.as_bytes())
}

/// The names of a struct's fields, in slots of equal length.
fn field_names(file: &mut impl Write, fields: &[&str]) -> io::Result<()> {
    // The length of a slot comes as a small element: tag and data in 8 bytes.
    file.write_all(&((4 << 16) | MI_INT32).to_ne_bytes())?;
    file.write_all(&(FIELD_NAME_BYTES as u32).to_ne_bytes())?;
    let mut names = vec![0_u8; FIELD_NAME_BYTES * fields.len()];
    for (slot, field) in names.chunks_exact_mut(FIELD_NAME_BYTES).zip(fields) {
        assert!(field.len() < FIELD_NAME_BYTES, "field name `{field}` is too long");
        slot[..field.len()].copy_from_slice(field.as_bytes());
    }
    element(file, MI_INT8, &names)
}

fn matrix(file: &mut impl Write, name: &str, value: &Value) -> io::Result<()> {
    let extents = dims(value);
    let count: usize = extents.iter().product();
    let class = match value {
        Value::Real { .. } => MX_DOUBLE,
        Value::Complex { .. } => MX_DOUBLE | COMPLEX,
        Value::Text(_) => MX_CHAR,
        Value::Cell { .. } => MX_CELL,
        Value::Structs { .. } => MX_STRUCT,
    };
    tag(file, MI_MATRIX, body_size(name, value))?;
    head(file, name, class, &extents)?;
    match value {
        Value::Real { data, .. } => {
            assert_eq!(data.len(), count, "numbers in `{name}` against its extents {extents:?}");
            element(file, MI_DOUBLE, data)
        }
        Value::Complex { re, im, .. } => {
            assert_eq!(re.len(), count, "real parts in `{name}` against its extents {extents:?}");
            assert_eq!(im.len(), count, "imaginary parts in `{name}`, extents {extents:?}");
            element(file, MI_DOUBLE, re)?;
            element(file, MI_DOUBLE, im)
        }
        Value::Text(text) => element(file, MI_UINT16, &text.encode_utf16().collect::<Vec<_>>()),
        Value::Cell { values, .. } => {
            assert_eq!(values.len(), count, "cells in `{name}` against its extents {extents:?}");
            values.iter().try_for_each(|v| matrix(file, "", v))
        }
        Value::Structs { fields, values } => {
            field_names(file, fields)?;
            for one in values {
                assert_eq!(one.len(), fields.len(), "fields of a struct in `{name}`");
                one.iter().try_for_each(|v| matrix(file, "", v))?;
            }
            Ok(())
        }
    }
}
