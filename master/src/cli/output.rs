//! Data for people and for programs: one table, three formats.

mod lines;

use std::borrow::Cow;
use std::fmt;
use std::io::{self, IsTerminal, Write};

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Width, presets};
use serde::ser::{Serialize, SerializeMap, Serializer};

pub use self::lines::Lines;
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
    /// The value for people.
    fn short(&self) -> String {
        match self {
            Self::Real(value) => format!("{value:.4}"),
            Self::Truth(value) => if *value { "yes" } else { "no" }.to_owned(),
            _ => self.to_string(),
        }
    }

    /// The value on a terminal, where a long list would fill the screen.
    fn brief(&self) -> String {
        match self {
            Self::List(values) if values.len() > LISTED => {
                let first = values.iter().take(LISTED - 1).map(u32::to_string).collect::<Vec<_>>().join(" ");
                format!("{first} ... ({})", values.len())
            }
            _ => self.short(),
        }
    }

    const fn is_number(&self) -> bool {
        matches!(self, Self::Integer(_) | Self::Real(_))
    }
}

impl fmt::Display for Cell {
    /// The value in full, as CSV has it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Text(text) => f.write_str(text),
            Self::Integer(value) => value.fmt(f),
            Self::Real(value) => value.fmt(f),
            Self::List(values) => values.iter().enumerate().try_for_each(|(place, value)| {
                let separator = if place == 0 { "" } else { " " };
                write!(f, "{separator}{value}")
            }),
            Self::Truth(value) => value.fmt(f),
        }
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
    columns: Vec<Cow<'static, str>>,
    /// Row by row.
    cells: Vec<Cell>,
}

/// A row as a JSON object, keys in the order of the columns.
struct Object<'a>(&'a [Cow<'static, str>], &'a [Cell]);

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
    pub fn new<T: Into<Cow<'static, str>>>(columns: impl IntoIterator<Item = T>) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), cells: Vec::new() }
    }

    /// Adds a row with a value for every column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.cells.extend(row);
        debug_assert_eq!(self.cells.len() % self.columns.len(), 0);
    }

    fn rows(&self) -> impl Iterator<Item = &[Cell]> {
        self.cells.chunks_exact(self.columns.len())
    }

    /// The same without these columns.
    #[must_use]
    pub fn without(mut self, columns: &[&str]) -> Self {
        let kept: Vec<bool> = self.columns.iter().map(|column| !columns.contains(&&**column)).collect();
        let mut cell = kept.iter().cycle();
        self.cells.retain(|_| cell.next().copied().unwrap_or_default());
        self.columns.retain(|column| !columns.contains(&&**column));
        self
    }

    /// Whether there are no rows.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Prints to stdout. A reader that has had enough (`| head`) is no failure.
    ///
    /// # Errors
    /// [`Exit::Unexpected`] when stdout cannot be written.
    pub fn print(&self, format: Format) -> Result<(), Failure> {
        let mut text = Vec::new();
        let written = match format {
            Format::Table => self.write_table(&mut text, terminal()),
            _ => self.write(format, &mut text),
        };
        printed(written.and_then(|()| to_stdout(&text)))
    }

    /// Writes the table.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, format: Format, out: &mut impl Write) -> io::Result<()> {
        match format {
            Format::Table => self.write_table(out, None),
            Format::Json => self.write_json(out),
            Format::Csv => self.write_csv(out),
        }
    }

    /// Columns without any value are left out. With a width, long words are broken into lines so that the table is no
    /// wider, if its numbers allow it.
    fn write_table(&self, out: &mut impl Write, width: Option<u16>) -> io::Result<()> {
        let shown = |column: &usize| {
            self.cells.is_empty() || self.rows().any(|row| !row[*column].to_string().is_empty())
        };
        let shown: Vec<usize> = (0..self.columns.len()).filter(shown).collect();
        let mut table = comfy_table::Table::new();
        table.load_style(presets::NOTHING);
        if let Some(width) = width {
            table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
        }
        table.set_header(shown.iter().map(|&column| self.columns[column].as_ref()));
        let words = |cell: &Cell| if width.is_some() { cell.brief() } else { cell.short() };
        for row in self.rows() {
            table.add_row(shown.iter().map(|&column| words(&row[column])));
        }
        for (&column, drawn) in shown.iter().zip(table.column_iter_mut()) {
            if self.rows().any(|row| row[column].is_number()) {
                drawn.set_cell_alignment(CellAlignment::Right);
            }
            // Words of which a line has no room are worse than a line that is too long.
            let most = self.rows().map(|row| words(&row[column]).chars().count()).max().unwrap_or_default();
            drawn.set_constraint(if most > usize::from(BREAKABLE) {
                ColumnConstraint::LowerBoundary(Width::Fixed(BREAKABLE))
            } else {
                ColumnConstraint::ContentWidth
            });
            drawn.set_padding((0, 2));
        }
        for line in table.lines() {
            writeln!(out, "{}", line.trim_end())?;
        }
        Ok(())
    }

    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        self.write_json_rows(true, out)?;
        writeln!(out, "{}", if self.cells.is_empty() { "[]" } else { "\n]" })
    }

    /// The rows alone: the first ones, or such that follow others.
    fn write_json_rows(&self, first: bool, out: &mut impl Write) -> io::Result<()> {
        let mut separator = if first { "[" } else { "," };
        for row in self.rows() {
            write!(out, "{separator}\n  ")?;
            serde_json::to_writer(&mut *out, &Object(&self.columns, row))?;
            separator = ",";
        }
        Ok(())
    }

    fn write_csv(&self, out: &mut impl Write) -> io::Result<()> {
        self.write_csv_head(out)?;
        self.write_csv_rows(out)
    }

    fn write_csv_head(&self, out: &mut impl Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        writer.write_record(self.columns.iter().map(|column| column.as_bytes()))?;
        writer.flush()
    }

    /// The rows alone.
    fn write_csv_rows(&self, out: &mut impl Write) -> io::Result<()> {
        let mut writer = csv::Writer::from_writer(out);
        let (mut integer, mut field) = (itoa::Buffer::new(), Vec::new());
        for row in self.rows() {
            for cell in row {
                match cell {
                    Cell::Text(text) => writer.write_field(text)?,
                    Cell::Integer(value) => writer.write_field(integer.format(*value))?,
                    _ => {
                        field.clear();
                        write!(field, "{cell}")?;
                        writer.write_field(&field)?;
                    }
                }
            }
            writer.write_record(None::<&[u8]>)?;
        }
        writer.flush()
    }
}

/// Words up to this length are not broken into lines.
const BREAKABLE: u16 = 24;
/// A list is shown in full on a terminal if it has no more numbers than these.
const LISTED: usize = 6;

/// The terminal's width, if stdout is one.
fn terminal() -> Option<u16> {
    if io::stdout().is_terminal() { comfy_table::Table::new().width() } else { None }
}

/// Prints a text to stdout.
///
/// # Errors
/// Those of [`Table::print`].
pub fn print_text(text: &[u8]) -> Result<(), Failure> {
    printed(to_stdout(text))
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
        table.write_table(&mut text, terminal())
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
    fn a_table_is_as_wide_as_the_terminal_and_numbers_stay_whole() {
        let mut table = Table::new(["trial", "fitness", "reason"]);
        table.push([7_u32.into(), 0.25.into(), "nearest to the goal at step 12: palm to top 0.081 m".into()]);
        let mut out = Vec::new();
        table.write_table(&mut out, Some(50)).unwrap();
        let text = String::from_utf8(out).unwrap();
        assert!(text.lines().all(|line| line.len() <= 50) && text.lines().count() > 2, "{text}");
        assert!(text.contains("    7   0.2500  nearest to the goal at"), "{text}");
        let mut out = Vec::new();
        table.write_table(&mut out, Some(10)).unwrap();
        assert!(String::from_utf8(out).unwrap().contains("0.2500"), "a number is never broken");
    }

    #[test]
    fn a_long_list_is_cut_short_on_a_terminal_only() {
        let mut table = Table::new(["flipped"]);
        table.push([(0..9).collect::<Vec<u32>>().into()]);
        let mut out = Vec::new();
        table.write_table(&mut out, Some(80)).unwrap();
        assert_eq!(String::from_utf8(out).unwrap(), "flipped\n0 1 2 3 4 ... (9)\n");
        assert_eq!(written(&table, Format::Table), "flipped\n0 1 2 3 4 5 6 7 8\n");
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
