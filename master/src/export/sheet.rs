//! The files of the tables. A file gets its name when all of them are complete.

use std::fmt::Write;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::ExportError;
use super::columns::{Column, Topic, Value};
use super::parquet::ParquetWriter;

/// What kind of file a table is written to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileType {
    /// Comma-separated values.
    Csv,
    /// Parquet, compressed with Snappy.
    Parquet,
}

impl FileType {
    const fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// The folder that tables are written to.
#[derive(Debug, Clone)]
pub struct Folder {
    path: PathBuf,
    to: FileType,
}

impl Folder {
    /// A folder, created if need be, in which none of these tables is yet; or, with `replace`, any folder.
    ///
    /// # Errors
    /// [`ExportError::Occupied`] when one of the tables is there, [`ExportError::File`] when there can be no such
    /// folder.
    pub fn prepare(path: &Path, to: FileType, topics: &[Topic], replace: bool) -> Result<Self, ExportError> {
        fs::create_dir_all(path).map_err(|error| failed(path, &error))?;
        let folder = Self { path: path.to_owned(), to };
        let there = topics.iter().map(|topic| folder.file(*topic)).find(|file| file.exists());
        match there {
            Some(file) if !replace => Err(ExportError::Occupied(file)),
            _ => Ok(folder),
        }
    }

    /// Begins a table.
    ///
    /// # Errors
    /// [`ExportError::File`] when it cannot be written.
    pub fn begin(&self, topic: Topic) -> Result<Sheet, ExportError> {
        let columns = topic.columns()?;
        let partial = Partial::new(self.file(topic));
        let fail = |error: &dyn ToString| failed(&partial.target, error);
        let file = File::create(&partial.path).map_err(|error| fail(&error))?;
        let sink = match self.to {
            FileType::Csv => {
                let mut writer = csv::Writer::from_writer(file);
                let names = columns.iter().map(|column| column.name.as_bytes());
                writer.write_record(names).map_err(|error| fail(&error))?;
                Sink::Csv(Box::new(writer))
            }
            FileType::Parquet => {
                let writer = ParquetWriter::new(file, topic.name(), &columns);
                Sink::Parquet(Box::new(writer.map_err(|error| fail(&error))?))
            }
        };
        Ok(Sheet { topic, columns, sink, partial, rows: 0, text: String::new() })
    }

    fn file(&self, topic: Topic) -> PathBuf {
        self.path.join(format!("{}.{}", topic.name(), self.to.extension()))
    }
}

/// A file under another name, which is gone with this unless it was given its own.
#[derive(Debug)]
struct Partial {
    path: PathBuf,
    target: PathBuf,
    kept: bool,
}

impl Partial {
    fn new(target: PathBuf) -> Self {
        let mut path = target.clone().into_os_string();
        path.push(".partial");
        Self { path: path.into(), target, kept: false }
    }

    fn keep(mut self) -> Result<PathBuf, ExportError> {
        fs::rename(&self.path, &self.target).map_err(|error| failed(&self.target, &error))?;
        self.kept = true;
        Ok(self.target.clone())
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        if !self.kept {
            // There is nobody left to tell.
            let _ = fs::remove_file(&self.path);
        }
    }
}

enum Sink {
    Csv(Box<csv::Writer<File>>),
    Parquet(Box<ParquetWriter>),
}

/// A table that is being written, row by row.
pub struct Sheet {
    topic: Topic,
    columns: Vec<Column>,
    sink: Sink,
    partial: Partial,
    rows: u64,
    text: String,
}

/// A table whose file is complete but does not have its name yet.
#[derive(Debug)]
pub struct Written {
    /// The table.
    pub topic: Topic,
    /// Its rows.
    pub rows: u64,
    partial: Partial,
}

impl Sheet {
    /// Writes a row with a value for every column.
    ///
    /// # Errors
    /// [`ExportError::File`] when it cannot be written, or does not fit the columns.
    pub fn push(&mut self, row: &[Value<'_>]) -> Result<(), ExportError> {
        debug_assert_eq!(row.len(), self.columns.len());
        self.rows += 1;
        let written = match &mut self.sink {
            Sink::Csv(writer) => {
                row.iter().try_for_each(|value| write_field(writer, &mut self.text, *value)).and_then(|()| {
                    // Ends the line.
                    writer.write_record(None::<&[u8]>).map_err(|error| error.to_string())
                })
            }
            Sink::Parquet(writer) => writer.push(row).map_err(|error| error.to_string()),
        };
        written.map_err(|reason| ExportError::File { path: self.partial.target.clone(), reason })
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`ExportError::File`] when that is not possible.
    pub fn finish(self) -> Result<Written, ExportError> {
        let Self { topic, sink, partial, rows, .. } = self;
        let fail = |error: &dyn ToString| failed(&partial.target, error);
        let file = match sink {
            Sink::Csv(writer) => writer.into_inner().map_err(|error| fail(error.error()))?,
            Sink::Parquet(writer) => writer.finish().map_err(|error| fail(&error))?,
        };
        file.sync_all().map_err(|error| fail(&error))?;
        Ok(Written { topic, rows, partial })
    }
}

impl Written {
    /// Gives the file its name.
    ///
    /// # Errors
    /// [`ExportError::File`] when that is not possible.
    pub fn keep(self) -> Result<PathBuf, ExportError> {
        self.partial.keep()
    }
}

fn write_field<W: std::io::Write>(
    writer: &mut csv::Writer<W>,
    text: &mut String,
    value: Value<'_>,
) -> Result<(), String> {
    text.clear();
    let written = match value {
        Value::Null => Ok(()),
        Value::Text(words) => return writer.write_field(words).map_err(|error| error.to_string()),
        Value::Integer(number) => write!(text, "{number}"),
        Value::Real(number) => write!(text, "{number}"),
        Value::Truth(truth) => write!(text, "{truth}"),
    };
    written.map_err(|error| error.to_string())?;
    writer.write_field(&*text).map_err(|error| error.to_string())
}

fn failed(path: &Path, error: &(impl ToString + ?Sized)) -> ExportError {
    ExportError::File { path: path.to_owned(), reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW: [Value<'static>; 9] = [
        Value::Text("a"),
        Value::Integer(0),
        Value::Integer(2),
        Value::Integer(7),
        Value::Integer(15),
        Value::Text("move"),
        Value::Real(1.0 / 3.0),
        Value::Truth(true),
        Value::Integer(100),
    ];

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_has_its_name_only_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("x/out");
        let prepared = Folder::prepare(&out, FileType::Csv, &[Topic::Trials], false).unwrap();
        let mut sheet = prepared.begin(Topic::Trials).unwrap();
        sheet.push(&ROW).unwrap();
        assert_eq!(names(&out), ["trials.csv.partial"]);
        drop(sheet);
        assert!(names(&out).is_empty(), "what was given up leaves nothing");

        let mut sheet = prepared.begin(Topic::Trials).unwrap();
        let mut row = ROW;
        sheet.push(&row).unwrap();
        row[6] = f64::NAN.into();
        sheet.push(&row).unwrap();
        let written = sheet.finish().unwrap();
        assert_eq!(written.rows, 2);
        let path = written.keep().unwrap();
        assert_eq!(names(&out), ["trials.csv"]);
        let text = fs::read_to_string(path).unwrap();
        let expected = "experiment,replication,generation,individual,trial,behaviour,score,success,steps\n\
                        a,0,2,7,15,move,0.3333333333333333,true,100\n\
                        a,0,2,7,15,move,,true,100\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn what_is_there_is_replaced_only_when_that_was_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let prepare = |to, topic, replace| Folder::prepare(folder.path(), to, &[topic], replace);
        fs::write(folder.path().join("trials.csv"), "mine").unwrap();
        let refused = prepare(FileType::Csv, Topic::Trials, false).unwrap_err();
        assert!(refused.to_string().contains("trials.csv: is there already"), "{refused}");
        prepare(FileType::Csv, Topic::Generations, false).unwrap();
        prepare(FileType::Parquet, Topic::Trials, false).unwrap();
        let sheet = prepare(FileType::Csv, Topic::Trials, true).unwrap().begin(Topic::Trials).unwrap();
        assert_eq!(fs::read_to_string(folder.path().join("trials.csv")).unwrap(), "mine");
        let path = sheet.finish().unwrap().keep().unwrap();
        assert!(fs::read_to_string(path).unwrap().starts_with("experiment,"));
    }
}
