//! What an experiment came to, in a folder small enough to be kept with the source: `docs/results/README.md` says what
//! is in its files.
//!
//! The individuals in it can be run again from the folder alone.

mod check;
mod figure;
mod files;
mod study;

use std::path::{Path, PathBuf};

use selftalk_sim::{Experiment, ExperimentError, SimError, TrialOutcome};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::retest::RetestError;

pub use check::check;
pub use study::{Examined, KeptStudy};

/// Why results cannot be written, read or run again.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// The folder has something in it already.
    #[error("{}: is not empty; name a new folder with --out", .0.display())]
    Occupied(PathBuf),
    /// There is no such file.
    #[error("{}: no such file; `selftalk results` writes it", .0.display())]
    Missing(PathBuf),
    /// A file cannot be written or read.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// A file does not hold what it should.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What it should hold.
        reason: String,
    },
    /// The experiment file is refused.
    #[error(transparent)]
    Experiment(#[from] ExperimentError),
    /// An individual cannot be run.
    #[error(transparent)]
    Retest(#[from] RetestError),
    /// The simulator is damaged.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// What an experiment came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// Its settings, complete.
    pub experiment: Experiment,
    /// What each generation's best individual came to.
    pub generations: Vec<GenerationRow>,
    /// What each replication came to.
    pub summary: Vec<SummaryRow>,
    /// The champions.
    pub best: Vec<BestRow>,
    /// Their trials.
    pub trials: Vec<TrialRow>,
    /// The checksums of the replications' histories.
    pub digests: Vec<DigestRow>,
    /// The workers that ran it.
    pub workers: Vec<WorkerRow>,
}

/// A line of `generations.csv`: a generation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GenerationRow {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation, counted from 0.
    pub generation: u32,
    /// Fitness of its best individual.
    pub best_fitness: f64,
    /// Mean fitness.
    pub mean_fitness: f64,
    /// Successful trials of its best individual.
    pub best_successes: u32,
    /// Those of REACH.
    pub reach: u32,
    /// Those of OPEN.
    pub open: u32,
    /// Those of GRASP.
    pub grasp: u32,
    /// Those of MOVE.
    #[serde(rename = "move")]
    pub transport: u32,
}

/// A line of `summary.csv`: a replication.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SummaryRow {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generations that were run.
    pub generations: u32,
    /// The first with an individual that succeeded in all 16 trials.
    pub first_optimal_generation: Option<u32>,
    /// The most successes of any generation's best individual.
    pub best_successes_of_16: u32,
    /// Share of the champion's fresh trials of REACH that succeed.
    pub fresh_reach: f64,
    /// The same for OPEN.
    pub fresh_open: f64,
    /// The same for GRASP.
    pub fresh_grasp: f64,
    /// The same for MOVE.
    pub fresh_move: f64,
}

/// A line of `best.csv`: the champion of a replication.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BestRow {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Its generation.
    pub generation: u32,
    /// Its number in the generation.
    pub individual: u32,
    /// Its fitness there.
    pub fitness: f64,
    /// Its successful trials there.
    pub successes: u32,
    /// Trials in which it was chosen.
    pub validation_trials: u32,
    /// Those that succeeded.
    pub validation_successes: u32,
    /// Trials of which `summary.csv` has the shares.
    pub fresh_trials: u32,
    /// Its genes, four hexadecimal digits each.
    pub genes: String,
}

/// A line of `trials.csv`: a trial of a champion, in the generation in which it was the best.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrialRow {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Trial, counted from 0.
    pub trial: u32,
    /// The behaviour it asks for.
    pub behaviour: String,
    /// Its score.
    pub score: f64,
    /// The 64 bits of the score, in hexadecimal.
    pub score_bits: String,
    /// Whether the goal was reached and held.
    pub success: bool,
    /// Control steps it lasted.
    pub steps: u32,
}

/// A line of `digest.csv`: the checksum of a replication's history.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DigestRow {
    /// The experiment.
    pub experiment: String,
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generations that enter.
    pub generations: u32,
    /// What `selftalk digest` prints.
    pub sha256: String,
    /// Identifies the simulator with which it was run.
    pub fingerprint: String,
}

/// A line of `workers.csv`: a worker's connection to the master.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorkerRow {
    /// Threads it ran trials on.
    pub slots: u32,
    /// Its release.
    pub version: String,
    /// When it joined: RFC 3339, UTC.
    pub joined_at: String,
    /// When it left; none if the master was killed meanwhile.
    pub left_at: Option<String>,
}

impl TrialRow {
    /// What the trial came to.
    fn outcome(&self) -> Option<TrialOutcome> {
        let Self { success, steps, .. } = *self;
        let score = f64::from_bits(u64::from_str_radix(&self.score_bits, 16).ok()?);
        Some(TrialOutcome { score, success, steps })
    }
}

impl Results {
    /// Makes sure that there is an empty folder of this name.
    ///
    /// # Errors
    /// Those of [`Results::write`].
    pub fn room(folder: &Path) -> Result<(), ResultsError> {
        files::prepare(folder)
    }

    /// Writes the files into a folder that is empty, or is created.
    ///
    /// # Errors
    /// [`ResultsError::Occupied`] when it is not empty; [`ResultsError::File`] when it cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ResultsError> {
        files::write(self, folder)
    }

    /// Reads the files of a folder.
    ///
    /// # Errors
    /// [`ResultsError`] when one of them cannot be read or does not hold what it should.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        files::read(folder)
    }
}
