//! Commands that look at stored individuals.

use std::path::PathBuf;

use clap::Args;
use selftalk_sim::experiment::Engine;

use super::ReplicationFilter;

/// Which individuals.
#[derive(Debug, Clone, Args)]
pub struct Which {
    /// EXPERIMENT/REPLICATION/GENERATION/INDIVIDUAL, as `selftalk history individuals` lists them; or `best`, the best
    /// individual of each replication's last generation; or `champion`, the one of the best individuals of each
    /// replication's last 50 generations that succeeds most often in 160 fresh trials, which takes a while
    #[arg(value_name = "INDIVIDUAL", default_value = "best")]
    pub individuals: Vec<String>,
    /// Of which replications `best` and `champion` are.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// `best` of this generation, `champion` up to it, counted from 0 [default: each replication's last]
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
}

/// Arguments of `selftalk show`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The trials are run again; should one not come to what is stored, down to the last bit of its score, that is said
(exit code 7). `held` is for how many control steps the goal held without a break, `focus` in which share of them
attention was on what the behaviour is about. Steps are counted from 1. JSON and CSV have a record a trial.

With `--weights`, the controller's numbers instead of the trials: weights, biases and time constants by the names of the
neurons. JSON and CSV have a record a number.

Examples:
  selftalk show                                 the best of every replication's last generation
  selftalk show quickstart/0/59/12
  selftalk show best --replication 1 --generation 12
  selftalk show champion --experiment elementary --replication 0
  selftalk show quickstart/0/59/12 --weights --format csv
  selftalk show best --replication 0 --weights --image weights.png

`selftalk --help` lists the exit codes.")]
pub struct ShowArgs {
    /// Which individuals.
    #[command(flatten)]
    pub which: Which,
    /// The controller's weights, biases and time constants instead of the trials
    #[arg(long)]
    pub weights: bool,
    /// Draw them into a file, FILE.png or FILE.svg, for one individual
    #[arg(long, value_name = "FILE", requires = "weights")]
    pub image: Option<PathBuf>,
    /// Threads that choose champions [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}

/// Arguments of `selftalk evaluate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Prints which share of the trials of each behaviour succeeds. The trials have object and target positions that no
evolution has used and no champion was chosen by, the same for all individuals of an experiment. The same question has
the same answer on every machine, with any number of workers.

With `--why`, trial 0 to 3 of each behaviour have their own area of the object and their own initial posture; in MOVE,
the target lies to the left in trials 12 and 14, to the right in 13 and 15. 5x is said of five trials that failed in the
same way; what is said of them then are medians.

Examples:
  selftalk evaluate best                        400 trials, 100 of each behaviour
  selftalk evaluate champion --trials 1600
  selftalk evaluate best --replication 0 --why
  selftalk evaluate quickstart/0/59/12 quickstart/1/59/3 --format csv
  selftalk evaluate --post --experiment integrated-lst

`selftalk --help` lists the exit codes.")]
pub struct EvaluateArgs {
    /// Which individuals.
    #[command(flatten)]
    pub which: Which,
    /// How.
    #[command(flatten)]
    pub fresh: Fresh,
    /// Post-evaluation, for the second training phase: 40 trials without a caretaker for the best individual of every
    /// generation. What comes out is kept in the database, for `generalise` and `report`
    #[arg(long, conflicts_with_all = ["why", "individuals", "generation", "trials"])]
    pub post: bool,
    /// A line for each of an individual's trials, with how it fails
    #[arg(long)]
    pub why: bool,
}

/// Arguments of `selftalk transfer`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Prints which share of the trials of each behaviour succeeds in the experiment's own engine, and in the other one. Both
run the same fresh trials, those of `selftalk evaluate`.

Examples:
  selftalk transfer champion
  selftalk transfer best --replication 0 --to lockstep

`selftalk --help` lists the exit codes.")]
pub struct TransferArgs {
    /// Which individuals.
    #[command(flatten)]
    pub which: Which,
    /// How.
    #[command(flatten)]
    pub fresh: Fresh,
    /// The other engine, as experiment files name it [default: the one that the experiment does not use]
    #[arg(long, value_name = "ENGINE", value_parser = engine)]
    pub to: Option<Engine>,
}

/// Arguments of `selftalk verify`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Each generation has to follow from the one before it, fitness from the trials, the ranking from fitness; and the trials,
run again, have to come to the stored scores, successes and steps, bit for bit. Nothing is written. Mismatches are named
on stderr (exit code 7). The trials of a whole study take as long as the study; `--best` and `--sample` run fewer.

Examples:
  selftalk verify --sample 1000
  selftalk verify --experiment elementary --replication 0 --generation 1400-1499
  selftalk verify --best
  selftalk verify --results docs/results/elementary

`selftalk --help` lists the exit codes.")]
pub struct VerifyArgs {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// Only this generation, or those from one to another, counted from 0
    #[arg(long, value_name = "N|N-M", value_parser = range)]
    pub generation: Option<GenerationRange>,
    /// Run only the trials of each generation's best individual
    #[arg(long, conflicts_with = "sample")]
    pub best: bool,
    /// Run only the trials of so many genotypes, strewn over all, always the same
    #[arg(long, value_name = "N")]
    pub sample: Option<u64>,
    /// Verify a folder that `selftalk results` has written, instead of the database
    #[arg(long, value_name = "DIR", conflicts_with_all = ["experiment", "replication", "generation", "best", "sample"])]
    pub results: Option<PathBuf>,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}

/// Arguments of `selftalk generalise`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The best robot of a replication of the second training phase is the one with most successes in post-evaluation, of several
the latest. It fetches the object from 7 x 7 places over 35 x 35 cm, from 4 initial postures each, without a caretaker; in
experiments with a caretaker also with one that speaks in all trials. What comes out is kept in the database, for `report`;
what is kept already is not run again.

Examples:
  selftalk evaluate --post                      first: who is best
  selftalk generalise
  selftalk generalise --experiment integrated-lst --replication 0

`selftalk --help` lists the exit codes.")]
pub struct GeneraliseArgs {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}

/// Arguments of `selftalk results`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The folder gets the experiment file, how each replication's best individuals developed, the replications' champions with
their genes and the bits of their scores, how often they succeed in fresh trials, and the checksum of each replication's
history; docs/results/README.md has the columns. A champion is chosen by fresh trials other than those that are reported.

Examples:
  selftalk results elementary --out docs/results/elementary
  selftalk verify --results docs/results/elementary

`selftalk --help` lists the exit codes.")]
pub struct ResultsArgs {
    /// Which experiment; needed if the database has several
    #[arg(value_name = "EXPERIMENT")]
    pub experiment: Option<String>,
    /// The folder; it must not exist, or be empty
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How the champions are reported on.
    #[command(flatten)]
    pub fresh: Fresh,
}

/// Arguments of `selftalk report`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Everything is read from the database: boxplots of post-evaluation and generalisation (the paper's figures 4 and 6), learning
curves, tests between the conditions, robots with the caretaker's labels and with their own, and a page that sets it all
beside the paper. Figures are SVG and PNG, each with its CSV.

Examples:
  selftalk report --out report
  selftalk report integrated-c integrated-lst --out report

`selftalk --help` lists the exit codes.")]
pub struct ReportArgs {
    /// Experiments of the second training phase [default: all of them]
    #[arg(value_name = "EXPERIMENT")]
    pub experiments: Vec<String>,
    /// The folder; files of the report that are there are replaced
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Generations from one to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GenerationRange {
    /// The first of them.
    pub first: u32,
    /// The last of them.
    pub last: u32,
}

impl GenerationRange {
    /// Whether a generation is among them.
    #[must_use]
    pub const fn has(self, generation: u32) -> bool {
        self.first <= generation && generation <= self.last
    }
}

fn range(text: &str) -> Result<GenerationRange, String> {
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let read = || Some(GenerationRange { first: first.parse().ok()?, last: last.parse().ok()? });
    let wrong = || "expected a generation, such as 7, or a range of them, such as 10-19".to_owned();
    read().filter(|range| range.first <= range.last).ok_or_else(wrong)
}

/// Fresh trials.
#[derive(Debug, Clone, Args)]
pub struct Fresh {
    /// Trials of each individual, in whole draws of positions: a multiple of 16, or of 8 in the second training phase
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole_draws)]
    pub trials: u32,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}

/// Most trials of an individual that can be asked for.
const MOST_TRIALS: u32 = 1_600_000;

fn whole_draws(text: &str) -> Result<u32, String> {
    let fits = |trials: &u32| *trials > 0 && trials.is_multiple_of(8) && *trials <= MOST_TRIALS;
    let wrong = || format!("expected a multiple of 8 from 8 to {MOST_TRIALS}");
    text.parse().ok().filter(fits).ok_or_else(wrong)
}

fn engine(text: &str) -> Result<Engine, String> {
    let names = || Engine::ALL.iter().map(|engine| engine.name()).collect::<Vec<_>>().join(", ");
    let found = Engine::ALL.iter().copied().find(|engine| engine.name() == text);
    found.ok_or_else(|| format!("there is no such engine; there is: {}", names()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_generations_are_read() {
        assert_eq!(range("7"), Ok(GenerationRange { first: 7, last: 7 }));
        assert_eq!(range("10-19"), Ok(GenerationRange { first: 10, last: 19 }));
        for text in ["", "-", "3-", "-3", "9-3", "1-2-3", "x"] {
            assert!(range(text).is_err(), "{text}");
        }
    }

    #[test]
    fn fresh_trials_come_in_whole_draws() {
        assert_eq!(whole_draws("400"), Ok(400));
        for text in ["0", "12", "401", "-16", "x", "1600008"] {
            assert!(whole_draws(text).is_err(), "{text}");
        }
    }

    #[test]
    fn engines_go_by_the_names_of_experiment_files() {
        for known in Engine::ALL {
            let text = format!("engine = \"{}\"", known.name());
            let experiment = selftalk_sim::Experiment::from_toml("x", &text, &[]).unwrap();
            assert_eq!(Ok(experiment.engine), engine(known.name()));
        }
        assert!(engine("unreal").unwrap_err().contains("there is: lockstep"));
    }
}
