//! `designs.parquet`: the table of a sweep by columns, for tables too large for CSV (feature `parquet`).

use super::{ExportError, atomic};
use crate::sweep::Study;
use crate::sweep::table::Row;
use ::parquet::basic::{ConvertedType, Repetition, Type as Physical};
use ::parquet::column::writer::ColumnWriter;
use ::parquet::data_type::ByteArray;
use ::parquet::errors::ParquetError;
use ::parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use ::parquet::schema::types::Type;
use std::path::Path;
use std::sync::Arc;

/// Rows that are held together in the file.
const GROUP: usize = 65_536;

/// A column over some rows; `None` is written as null.
enum Column {
    Index(Vec<i64>),
    Number(Vec<Option<f64>>),
    Flag(Vec<Option<bool>>),
    Text(Vec<Option<String>>),
}

/// Writes the table with the columns and names of `designs.csv`: `design` as 64-bit integer, numbers as 64-bit floats,
/// `bounds_met` as boolean, names and `error` as UTF-8; what is empty there is null here.
///
/// # Errors
/// [`ExportError::Io`] if the file cannot be written.
pub fn write_designs(path: &Path, study: &Study, rows: &[Row]) -> Result<(), ExportError> {
    let failed = |error: ParquetError| ExportError::Io {
        path: path.into(),
        action: "write",
        source: std::io::Error::other(error.to_string()),
    };
    let bytes = encoded(study, rows).map_err(failed)?;
    atomic::write_bytes(path, &bytes)
}

fn encoded(study: &Study, rows: &[Row]) -> Result<Vec<u8>, ParquetError> {
    let names = study.variable_columns().into_iter().chain(study.result_columns()).map(|column| column.header());
    let names: Vec<String> =
        std::iter::once("design".into()).chain(names).chain(["bounds_met".into(), "error".into()]).collect();
    let fields = names.iter().zip(columns(study, &[])).map(|(name, column)| column.field(name).map(Arc::new));
    let schema = Type::group_type_builder("designs").with_fields(fields.collect::<Result<_, _>>()?).build()?;
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::default())?;
    for rows in rows.chunks(GROUP) {
        let mut group = writer.next_row_group()?;
        for column in columns(study, rows) {
            column.write(&mut group)?;
        }
        group.close()?;
    }
    writer.into_inner()
}

/// All columns of some rows, in the table's order.
fn columns(study: &Study, rows: &[Row]) -> Vec<Column> {
    let mut columns = vec![Column::Index(rows.iter().map(|row| row.index as i64).collect())];
    for (k, variable) in study.variables.iter().enumerate() {
        columns.push(if variable.is_name() {
            Column::Text(rows.iter().map(|row| Some(variable.text(row.values[k]))).collect())
        } else {
            Column::Number(rows.iter().map(|row| Some(row.values[k])).collect())
        });
    }
    for k in 0..study.result_columns().len() {
        columns.push(Column::Number(rows.iter().map(|row| row.results[k]).collect()));
    }
    columns.push(Column::Flag(rows.iter().map(|row| row.bounds_met).collect()));
    columns.push(Column::Text(rows.iter().map(|row| row.error.clone()).collect()));
    columns
}

impl Column {
    fn field(&self, name: &str) -> Result<Type, ParquetError> {
        let (physical, repetition) = match self {
            Column::Index(_) => (Physical::INT64, Repetition::REQUIRED),
            Column::Number(_) => (Physical::DOUBLE, Repetition::OPTIONAL),
            Column::Flag(_) => (Physical::BOOLEAN, Repetition::OPTIONAL),
            Column::Text(_) => (Physical::BYTE_ARRAY, Repetition::OPTIONAL),
        };
        let field = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        match self {
            Column::Text(_) => field.with_converted_type(ConvertedType::UTF8).build(),
            _ => field.build(),
        }
    }

    fn write(self, group: &mut SerializedRowGroupWriter<'_, Vec<u8>>) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("the schema has fewer columns than the table".into()));
        };
        match (self, column.untyped()) {
            (Column::Index(values), ColumnWriter::Int64ColumnWriter(writer)) => {
                writer.write_batch(&values, None, None)?;
            }
            (Column::Number(values), ColumnWriter::DoubleColumnWriter(writer)) => {
                let (values, given) = without_gaps(values);
                writer.write_batch(&values, Some(&given), None)?;
            }
            (Column::Flag(values), ColumnWriter::BoolColumnWriter(writer)) => {
                let (values, given) = without_gaps(values);
                writer.write_batch(&values, Some(&given), None)?;
            }
            (Column::Text(values), ColumnWriter::ByteArrayColumnWriter(writer)) => {
                let (values, given) = without_gaps(values);
                let values: Vec<ByteArray> = values.iter().map(|text| text.as_str().into()).collect();
                writer.write_batch(&values, Some(&given), None)?;
            }
            _ => return Err(ParquetError::General("a column is not of the schema's type".into())),
        }
        column.close()
    }
}

/// The values that are there, and for every row 1 or 0 (Parquet's definition level).
fn without_gaps<T>(values: Vec<Option<T>>) -> (Vec<T>, Vec<i16>) {
    let given = values.iter().map(|value| i16::from(value.is_some())).collect();
    (values.into_iter().flatten().collect(), given)
}
