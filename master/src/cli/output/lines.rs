//! Tables too long to be kept.

use std::borrow::Cow;
use std::io::{self, Write};

use super::{Cell, Table, printed, to_stdout};
use crate::cli::Format;
use crate::exit::Failure;

/// Values that are kept before their rows are written.
const KEPT: usize = 10_000;

/// A table whose rows are written as they come. Only those for people wait for the last one, as a column is as wide as its
/// widest value.
pub struct Lines {
    format: Format,
    /// The rows that are not yet written.
    table: Table,
    /// Those that are.
    text: Vec<u8>,
    /// Whether that went well.
    written: io::Result<()>,
}

impl Lines {
    /// A table without rows.
    pub fn new<T: Into<Cow<'static, str>>>(columns: impl IntoIterator<Item = T>, format: Format) -> Self {
        Self::of(Table::new(columns), format)
    }

    /// A table that is there already.
    pub fn of(table: Table, format: Format) -> Self {
        let mut text = Vec::new();
        let written = if format == Format::Csv { table.write_csv_head(&mut text) } else { Ok(()) };
        Self { format, table, text, written }
    }

    /// Adds a row with a value for every column.
    pub fn push(&mut self, row: impl IntoIterator<Item = Cell>) {
        self.table.push(row);
        if self.table.cells.len() >= KEPT && self.written.is_ok() {
            self.written = self.write_rows();
        }
    }

    fn write_rows(&mut self) -> io::Result<()> {
        match self.format {
            Format::Table => return Ok(()),
            Format::Csv => self.table.write_csv_rows(&mut self.text)?,
            Format::Json => self.table.write_json_rows(self.text.is_empty(), &mut self.text)?,
        }
        self.table.cells.clear();
        Ok(())
    }

    /// Prints to stdout, at once, so that nothing is printed of what could not be completed.
    ///
    /// # Errors
    /// Those of [`Table::print`].
    pub fn print(self) -> Result<(), Failure> {
        match self.format {
            Format::Table => self.table.print(Format::Table),
            _ => printed(self.text().and_then(|text| to_stdout(&text))),
        }
    }

    /// What programs read.
    pub(in crate::cli) fn text(mut self) -> io::Result<Vec<u8>> {
        std::mem::replace(&mut self.written, Ok(()))?;
        self.write_rows()?;
        if self.format == Format::Json {
            let end = if self.text.is_empty() { "[]" } else { "\n]" };
            writeln!(self.text, "{end}")?;
        }
        Ok(self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_written_as_they_come_are_those_of_a_table() {
        for (format, rows) in [Format::Csv, Format::Json].into_iter().flat_map(|format| {
            [0, 1, KEPT / 2 - 1, KEPT / 2, KEPT / 2 + 1, 2 * KEPT].map(|rows| (format, rows))
        }) {
            let columns = ["number", "words"];
            let (mut table, mut lines) = (Table::new(columns), Lines::new(columns, format));
            for row in 0..rows as u64 {
                table.push([row.into(), "a, b".into()]);
                lines.push([row.into(), "a, b".into()]);
            }
            let mut whole = Vec::new();
            table.write(format, &mut whole).unwrap();
            assert!(lines.text().unwrap() == whole, "{rows} rows");
        }
    }
}
