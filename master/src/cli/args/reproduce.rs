//! The command that runs the whole study.

use std::path::PathBuf;

use clap::Args;

use super::Shown;

/// How the names of the presets of a second phase begin.
pub const SECOND: [&str; 2] = ["linked", "integrated"];

/// Arguments of `selftalk reproduce`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The first training phase, the second one in its four conditions, post-evaluation, generalisation, and the report. All of it
is kept in one folder: the history in `study.db`, the results of the first phase in a folder of its name, and the report's
figures, tables and page in `report`. It can be interrupted or killed at any time; the same command goes on.

The settings of the defaults are ours; the paper's own are those of `elementary` and `integrated`.

Examples:
  selftalk reproduce                            in the folder `study`
  selftalk reproduce --dir literal --first elementary --second integrated
  selftalk reproduce --dir small --set replications=3 --set-first generations=200 --set-second generations=20

`selftalk --help` lists the exit codes.")]
pub struct ReproduceArgs {
    /// The study's folder; --db is not used
    #[arg(long, value_name = "DIR", default_value = "study")]
    pub dir: PathBuf,
    /// The first phase: a preset or an experiment file; several are run one after the other, each from the champions of the
    /// one before, and have ancestors.evolve=true but for the first
    #[arg(
        long,
        value_name = "PRESET|FILE.toml",
        default_values = ["elementary-linked", "elementary-further", "elementary-refined"]
    )]
    pub first: Vec<String>,
    /// The second phase: which presets the four conditions are, `linked-c` and so on or `integrated-c` and so on
    #[arg(long, value_name = "PRESETS", default_value = "linked", value_parser = SECOND)]
    pub second: String,
    /// Change a setting of all experiments, as key=value with a dotted key; can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Change a setting of the first phase
    #[arg(long, value_name = "KEY=VALUE")]
    pub set_first: Vec<String>,
    /// Change a setting of the four conditions of the second phase
    #[arg(long, value_name = "KEY=VALUE")]
    pub set_second: Vec<String>,
    /// Seed of all randomness, in place of the experiments'
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
    /// Where the dashboard is.
    #[command(flatten)]
    pub shown: Shown,
}
