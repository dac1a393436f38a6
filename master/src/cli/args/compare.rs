//! Arguments of `selftalk compare`.

use clap::{Args, ValueEnum};

/// Arguments of `selftalk compare`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Each replication enters with one value: the mean over its best individuals of some generations, the same ones for all
experiments. Two experiments are compared by a two-tailed Mann-Whitney U test, exact up to 100 replications together;
p_holm is p corrected for the number of pairs. a12 is the share of pairs of replications in which that of a has the
greater value, ties counting half: 0.5 where neither tends to be better.

Examples:
  selftalk run elementary --set name=steep --set controller.slope=4
  selftalk run elementary --set name=flat --set controller.slope=2
  selftalk compare steep flat
  selftalk compare --generation 99 --by fitness --format csv

`selftalk --help` lists the exit codes.")]
pub struct CompareArgs {
    /// Two experiments of the database, or more [default: all]
    #[arg(value_name = "EXPERIMENT")]
    pub experiments: Vec<String>,
    /// What is compared
    #[arg(long, value_enum, default_value_t = Measure::Successes)]
    pub by: Measure,
    /// The last generation that enters, counted from 0 [default: the last one that all replications have]
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
    /// How many generations enter
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..))]
    pub over: u32,
}

/// What a generation is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Measure {
    /// Successful trials of the best individual
    Successes,
    /// Fitness of the best individual; only for experiments that reward alike
    Fitness,
}

impl Measure {
    /// Lower-case name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Successes => "successes",
            Self::Fitness => "fitness",
        }
    }
}
