//! Commands that look at stored individuals.

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

Examples:
  selftalk show                                 the best of every replication's last generation
  selftalk show quickstart/0/59/12
  selftalk show best --replication 1 --generation 12
  selftalk show champion --experiment elementary --replication 0

`selftalk --help` lists the exit codes.")]
pub struct ShowArgs {
    /// Which individuals.
    #[command(flatten)]
    pub which: Which,
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

Examples:
  selftalk evaluate best                        400 trials, 100 of each behaviour
  selftalk evaluate champion --trials 1600
  selftalk evaluate quickstart/0/59/12 quickstart/1/59/3 --format csv

`selftalk --help` lists the exit codes.")]
pub struct EvaluateArgs {
    /// Which individuals.
    #[command(flatten)]
    pub which: Which,
    /// How.
    #[command(flatten)]
    pub fresh: Fresh,
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

/// Fresh trials.
#[derive(Debug, Clone, Args)]
pub struct Fresh {
    /// Trials of each individual, a multiple of 16: four of each behaviour in every draw of positions
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = whole_draws)]
    pub trials: u32,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
}

/// Most trials of an individual that can be asked for.
const MOST_TRIALS: u32 = 1_600_000;

fn whole_draws(text: &str) -> Result<u32, String> {
    let fits = |trials: &u32| *trials > 0 && trials.is_multiple_of(16) && *trials <= MOST_TRIALS;
    let wrong = || format!("expected a multiple of 16 from 16 to {MOST_TRIALS}");
    text.parse().ok().filter(fits).ok_or_else(wrong)
}

fn engine(text: &str) -> Result<Engine, String> {
    let names = || Engine::ALL.iter().map(|engine| engine.name()).collect::<Vec<_>>().join(", ");
    let found = Engine::ALL.iter().copied().find(|engine| engine.name() == text);
    found.ok_or_else(|| format!("there is no such engine; there is: {}", names()))
}
