//! A table as a Parquet file. Rows are kept until there are enough for a row group: so many that memory does not grow
//! with the table.

use std::fs::File;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::columns::{Column, Kind, Value};

/// Values in a row group, over all columns: some ten megabytes.
const GROUP: usize = 1 << 20;

/// The values of a column that are not written yet.
struct Buffer {
    optional: bool,
    /// Whether a row has a value (1) or none (0).
    levels: Vec<i16>,
    values: Values,
}

enum Values {
    Text(Vec<ByteArray>),
    Integer(Vec<i64>),
    Real(Vec<f64>),
    Truth(Vec<bool>),
}

/// Writes a table.
pub(super) struct ParquetWriter {
    file: SerializedFileWriter<File>,
    columns: Vec<Buffer>,
    rows: usize,
    group: usize,
}

impl ParquetWriter {
    pub(super) fn new(file: File, name: &str, columns: &[Column]) -> Result<Self, ParquetError> {
        let fields = columns.iter().map(|column| field(column).map(Arc::new)).collect::<Result<_, _>>()?;
        let schema = Type::group_type_builder(name).with_fields(fields).build()?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("selftalk ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let buffer = |column: &Column| Buffer {
            optional: column.optional,
            levels: Vec::new(),
            values: match column.kind {
                Kind::Text => Values::Text(Vec::new()),
                Kind::Integer => Values::Integer(Vec::new()),
                Kind::Real => Values::Real(Vec::new()),
                Kind::Truth => Values::Truth(Vec::new()),
            },
        };
        Ok(Self {
            file: SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?,
            columns: columns.iter().map(buffer).collect(),
            rows: 0,
            group: GROUP / columns.len().max(1),
        })
    }

    pub(super) fn push(&mut self, row: &[Value<'_>]) -> Result<(), ParquetError> {
        for (column, value) in self.columns.iter_mut().zip(row) {
            column.push(*value)?;
        }
        self.rows += 1;
        if self.rows >= self.group { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
        let mut group = self.file.next_row_group()?;
        for column in &mut self.columns {
            column.write(&mut group)?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }

    /// Completes the file.
    pub(super) fn finish(mut self) -> Result<File, ParquetError> {
        if self.rows > 0 {
            self.flush()?;
        }
        self.file.into_inner()
    }
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Integer => (Physical::INT64, None),
        Kind::Real => (Physical::DOUBLE, None),
        Kind::Truth => (Physical::BOOLEAN, None),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(if column.optional { Repetition::OPTIONAL } else { Repetition::REQUIRED })
        .with_logical_type(logical)
        .build()
}

impl Buffer {
    fn push(&mut self, value: Value<'_>) -> Result<(), ParquetError> {
        match (&mut self.values, value) {
            (_, Value::Null) if self.optional => {
                self.levels.push(0);
                return Ok(());
            }
            (Values::Text(values), Value::Text(text)) => {
                // Neighbours are often equal, and then share their bytes.
                let last = values.last().filter(|last| last.data() == text.as_bytes());
                let value = last.cloned().unwrap_or_else(|| ByteArray::from(text));
                values.push(value);
            }
            (Values::Integer(values), Value::Integer(value)) => values.push(value),
            (Values::Real(values), Value::Real(value)) => values.push(value),
            (Values::Truth(values), Value::Truth(value)) => values.push(value),
            (_, value) => {
                return Err(ParquetError::General(format!("{value:?} in a column of another kind")));
            }
        }
        self.levels.push(1);
        Ok(())
    }

    fn write(&mut self, group: &mut SerializedRowGroupWriter<'_, File>) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else {
            return Err(ParquetError::General("there are more columns than the schema has".to_owned()));
        };
        let levels = self.optional.then_some(self.levels.as_slice());
        match &mut self.values {
            Values::Text(values) => {
                column.typed::<ByteArrayType>().write_batch(values, levels, None)?;
                values.clear();
            }
            Values::Integer(values) => {
                column.typed::<Int64Type>().write_batch(values, levels, None)?;
                values.clear();
            }
            Values::Real(values) => {
                column.typed::<DoubleType>().write_batch(values, levels, None)?;
                values.clear();
            }
            Values::Truth(values) => {
                column.typed::<BoolType>().write_batch(values, levels, None)?;
                values.clear();
            }
        }
        self.levels.clear();
        column.close()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::Topic;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    fn row(individual: i64) -> [Value<'static>; 9] {
        [
            "a".into(),
            0_u32.into(),
            2_u32.into(),
            individual.into(),
            15_u32.into(),
            "move".into(),
            Some(individual as f64 / 3.0).filter(|_| individual % 2 == 0).into(),
            (individual % 3 == 0).into(),
            100_u32.into(),
        ]
    }

    #[test]
    fn what_is_written_reads_back_over_several_row_groups() {
        let file = tempfile::tempfile().unwrap();
        let columns = Topic::Trials.columns().unwrap();
        let mut writer = ParquetWriter::new(file, "trials", &columns).unwrap();
        writer.group = 10;
        for individual in 0..25 {
            writer.push(&row(individual)).unwrap();
        }
        let reader = SerializedFileReader::new(writer.finish().unwrap()).unwrap();
        assert_eq!(reader.num_row_groups(), 3);
        let names: Vec<String> = reader
            .metadata()
            .file_metadata()
            .schema_descr()
            .columns()
            .iter()
            .map(|column| column.name().to_owned())
            .collect();
        assert_eq!(names, columns.iter().map(|column| column.name.as_ref()).collect::<Vec<_>>());
        let mut count = 0;
        for (individual, row) in (0_i64..).zip(reader.get_row_iter(None).unwrap()) {
            let row = row.unwrap();
            assert_eq!((row.get_string(0).unwrap().as_str(), row.get_long(3).unwrap()), ("a", individual));
            assert_eq!(row.get_double(6).ok(), (individual % 2 == 0).then_some(individual as f64 / 3.0));
            assert_eq!(row.get_bool(7).unwrap(), individual % 3 == 0);
            count += 1;
        }
        assert_eq!(count, 25);
    }

    #[test]
    fn a_value_that_must_be_there_is_missed() {
        let file = tempfile::tempfile().unwrap();
        let mut writer = ParquetWriter::new(file, "trials", &Topic::Trials.columns().unwrap()).unwrap();
        let mut row = row(0);
        row[8] = Value::Null;
        assert!(writer.push(&row).is_err());
    }
}
