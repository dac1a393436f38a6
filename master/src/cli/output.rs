//! Data for people and for programs: one table, three formats.

use std::io::{self, Write};

use comfy_table::{CellAlignment, presets};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::Format;
use crate::exit::{Exit, Failure};

/// A value in a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// There is none.
    Empty,
    /// Words.
    Text(String),
    /// A count or a number.
    Integer(i64),
    /// A measured value; people see four decimals.
    Real(f64),
    /// Several numbers.
    List(Vec<u32>),
    /// Whether something is so.
    Truth(bool),
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<u32> for Cell {
    fn from(value: u32) -> Self {
        Self::Integer(value.into())
    }
}

impl From<i64> for Cell {
    fn from(value: i64) -> Self {
        Self::Integer(value)
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        i64::try_from(value).map_or_else(|_| Self::Text(value.to_string()), Self::Integer)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Self::Truth(value)
    }
}

impl From<Vec<u32>> for Cell {
    fn from(values: Vec<u32>) -> Self {
        Self::List(values)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

impl Cell {
    /// The value in full, as CSV has it.
    fn full(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) => text.clone(),
            Self::Integer(value) => value.to_string(),
            Self::Real(value) => value.to_string(),
            Self::List(values) => values.iter().map(u32::to_string).collect::<Vec<_>>().join(" "),
            Self::Truth(value) => value.to_string(),
        }
    }

    /// The value for people.
    fn short(&self) -> String {
        match self {
            Self::Real(value) => format!("{value:.4}"),
            Self::Truth(value) => if *value { "yes" } else { "no" }.to_owned(),
            _ => self.full(),
        }
    }

    const fn is_number(&self) -> bool {
        matches!(self, Self::Integer(_) | Self::Real(_))
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Empty => serializer.serialize_none(),
            Self::Text(text) => serializer.serialize_str(text),
            Self::Integer(value) => serializer.serialize_i64(*value),
            Self::Real(value) => serializer.serialize_f64(*value),
            Self::List(values) => values.serialize(serializer),
            Self::Truth(value) => serializer.serialize_bool(*value),
        }
    }
}

/// Records with the same columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<Cell>>,
}

/// A row as a JSON object, keys in the order of the columns.
struct Object<'a>(&'a [&'static str], &'a [Cell]);

impl Serialize for Object<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (column, cell) in self.0.iter().zip(self.1) {
            map.serialize_entry(column, cell)?;
        }
        map.end()
    }
}

impl Table {
    /// A table without rows.
    #[must_use]
    pub fn new(columns: impl Into<Vec<&'static str>>) -> Self {
        Self { columns: columns.into(), rows: Vec::new() }
    }

    /// Adds a row with a value for every column.
    pub fn push(&mut self, row: impl Into<Vec<Cell>>) {
        let row = row.into();
        debug_assert_eq!(row.len(), self.columns.len());
        self.rows.push(row);
    }

    /// The same without these columns.
    #[must_use]
    pub fn without(mut self, columns: &[&str]) -> Self {
        let kept: Vec<bool> = self.columns.iter().map(|column| !columns.contains(column)).collect();
        let keep = |row: &mut Vec<Cell>| {
            let mut kept = kept.iter();
            row.retain(|_| kept.next().copied().unwrap_or_default());
        };
        self.rows.iter_mut().for_each(keep);
        self.columns.retain(|column| !columns.contains(column));
        self
    }

    /// Whether there are no rows.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Prints to stdout. A reader that has had enough (`| head`) is no failure.
    ///
    /// # Errors
    /// [`Exit::Unexpected`] when stdout cannot be written.
    pub fn print(&self, format: Format) -> Result<(), Failure> {
        let mut text = Vec::new();
        printed(self.write(format, &mut text).and_then(|()| to_stdout(&text)))
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, format: Format, out: &mut impl Write) -> io::Result<()> {
        match format {
            Format::Table => self.write_table(out),
            Format::Json => self.write_json(out),
            Format::Csv => self.write_csv(out),
        }
    }

    /// Columns without any value are left out.
    fn write_table(&self, out: &mut impl Write) -> io::Result<()> {
        let shown = |column: &usize| {
            self.rows.is_empty() || self.rows.iter().any(|row| !row[*column].full().is_empty())
        };
        let shown: Vec<usize> = (0..self.columns.len()).filter(shown).collect();
        let mut table = comfy_table::Table::new();
        table.load_style(presets::NOTHING);
        table.set_header(shown.iter().map(|&column| self.columns[column]));
        for row in &self.rows {
            table.add_row(shown.iter().map(|&column| row[column].short()));
        }
        for (&column, drawn) in shown.iter().zip(table.column_iter_mut()) {
            if self.rows.iter().any(|row| row[column].is_number()) {
                drawn.set_cell_alignment(CellAlignment::Right);
            }
            drawn.set_padding((0, 2));
        }
        for line in table.lines() {
            writeln!(out, "{}", line.trim_end())?;
        }
        Ok(())
    }

    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        let mut separator = "[";
        for row in &self.rows {
            write!(out, "{separator}\n  ")?;
            serde_json::to_writer(&mut *out, &Object(&self.columns, row))?;
            separator = ",";
        }
        writeln!(out, "{}", if self.rows.is_empty() { "[]" } else { "\n]" })
    }

    fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(Cell::full))?;
        }
        writer.flush()
    }
}

/// Prints tables for people, an empty line between them.
///
/// # Errors
/// Those of [`Table::print`].
pub fn print_tables(tables: &[Table]) -> Result<(), Failure> {
    let mut text = Vec::new();
    let written = tables.iter().enumerate().try_for_each(|(at, table)| {
        if at > 0 {
            writeln!(text)?;
        }
        table.write(Format::Table, &mut text)
    });
    printed(written.and_then(|()| to_stdout(&text)))
}

fn to_stdout(text: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(text)?;
    out.flush()
}

fn printed(written: io::Result<()>) -> Result<(), Failure> {
    match written {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Unexpected, format!("stdout: {error}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(["name", "fitness", "none", "flips"]);
        table.push([Cell::from("a,b"), (1.0 / 3.0).into(), Cell::Empty, vec![1, 20].into()]);
        table.push([Cell::from("long name"), f64::NAN.into(), Cell::Empty, vec![].into()]);
        table
    }

    fn written(table: &Table, format: Format) -> String {
        let mut out = Vec::new();
        table.write(format, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn people_see_aligned_columns_with_values_only() {
        let text = written(&table(), Format::Table);
        assert_eq!(text, "name       fitness  flips\na,b         0.3333  1 20\nlong name      NaN\n");
    }

    #[test]
    fn programs_get_every_column_in_full() {
        assert_eq!(
            written(&table(), Format::Csv),
            "name,fitness,none,flips\n\"a,b\",0.3333333333333333,,1 20\nlong name,NaN,,\n"
        );
        let json = written(&table(), Format::Json);
        let first = "{\"name\":\"a,b\",\"fitness\":0.3333333333333333,\"none\":null,\"flips\":[1,20]}";
        assert_eq!(json.lines().nth(1), Some(&*format!("  {first},")));
        let parsed: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(parsed[1]["fitness"], serde_json::Value::Null);
    }

    #[test]
    fn columns_can_be_left_out() {
        let text = written(&table().without(&["fitness", "flips"]), Format::Csv);
        assert_eq!(text, "name,none\n\"a,b\",\nlong name,\n");
    }

    #[test]
    fn truth_is_said_in_words_to_people_only() {
        let mut table = Table::new(["done"]);
        table.push([true.into()]);
        table.push([false.into()]);
        assert_eq!(written(&table, Format::Table), "done\nyes\nno\n");
        assert_eq!(written(&table, Format::Csv), "done\ntrue\nfalse\n");
        assert_eq!(written(&table, Format::Json), "[\n  {\"done\":true},\n  {\"done\":false}\n]\n");
    }

    #[test]
    fn no_rows_are_an_empty_list_or_the_header() {
        let table = Table::new(["a", "b"]);
        assert_eq!(written(&table, Format::Json), "[]\n");
        assert_eq!(written(&table, Format::Csv), "a,b\n");
        assert_eq!(written(&table, Format::Table), "a  b\n");
    }
}
