//! The command that writes tables.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

/// A table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportTable {
    /// A row a generation
    Generations,
    /// A row an individual
    Individuals,
    /// A row a trial that evolution has run
    Trials,
    /// A row a control step of a trial that is run again
    Signals,
}

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ExportType {
    /// Text that every program reads
    Csv,
    /// Columns with their types, compressed
    Parquet,
}

/// Arguments of `selftalk export`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Each table is a file in the folder, named like the table. docs/export.md describes the columns and reads them with pandas,
Polars and DuckDB. A file appears when all are complete. Signals are those of individuals whose trials are run again, which
must come to what is stored (exit code 7 if not); they are written if they are asked for.

Examples:
  selftalk export --out tables                  generations, individuals and trials of all experiments
  selftalk export elementary --out tables --to parquet
  selftalk export quickstart --out tables --tables generations
  selftalk export quickstart --out tables --tables signals --individuals best

`selftalk --help` lists the exit codes.")]
pub struct ExportArgs {
    /// Experiments [default: all]
    #[arg(value_name = "EXPERIMENT")]
    pub experiments: Vec<String>,
    /// The folder to write; it is created if need be
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// What kind of files
    #[arg(long, value_enum, value_name = "TYPE", default_value_t = ExportType::Csv)]
    pub to: ExportType,
    /// Which tables, separated by commas [default: generations, individuals, trials; signals with --individuals]
    #[arg(long, value_enum, value_name = "TABLE", value_delimiter = ',')]
    pub tables: Vec<ExportTable>,
    /// Whose signals: EXPERIMENT/REPLICATION/GENERATION/INDIVIDUAL, `best` of each replication's last generation, or
    /// `champion`; separated by commas [default: best]
    #[arg(long, value_name = "INDIVIDUAL", value_delimiter = ',')]
    pub individuals: Vec<String>,
    /// Replace tables that are in the folder
    #[arg(long)]
    pub force: bool,
    /// Threads that choose champions [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}
