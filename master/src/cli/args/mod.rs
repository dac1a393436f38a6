//! What can be said on the command line.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::LazyLock;

use clap::{Args, Parser, Subcommand, ValueEnum};

mod backup;
mod compare;
mod dashboard;
mod export;
mod individuals;
mod keys;
mod operate;
mod replay;
mod reproduce;
mod shell;

use crate::store::schema_version;

pub use backup::BackupArgs;
pub use compare::{CompareArgs, Measure};
pub use dashboard::{DashboardArgs, DashboardAt, Shown};
pub use export::{ExportArgs, ExportTable, ExportType};
pub use individuals::{
    EvaluateArgs, Fresh, GeneraliseArgs, ReportArgs, ResultsArgs, ShowArgs, TransferArgs, VerifyArgs, Which,
};
pub use keys::{KeysArgs, KeysCommand, KeysInitArgs};
pub use operate::{OperateArgs, OperateAt, OperateCommand};
pub use replay::ReplayArgs;
pub use reproduce::{ReproduceArgs, SECOND};
pub use shell::{Color, CompletionsArgs, LogFormat, ManArgs};

const AFTER_HELP: &str = "\
Examples:
  selftalk run quickstart                       see it learn
  selftalk show best                            what the best do, and what goes wrong
  selftalk replay                               a page that plays their trials

Exit codes:
    0  done
    1  unexpected failure
    2  the command line is wrong, or names something that is not there
    3  the experiment file is refused
    4  the database cannot be opened, read or written
    5  the port is taken, the master cannot be reached, or it refuses the worker
    6  the experiment exists: interrupted, or with other settings
    7  what is stored is not what comes out when it is run again
  130  ended by Ctrl-C, 143 by SIGTERM: the generation under way is dropped, all before it are kept

Data goes to stdout, everything else to stderr; a failure is one line, `error: ...`.";

/// The release, and what it reads and writes.
fn long_version() -> &'static str {
    static RELEASE: LazyLock<String> =
        LazyLock::new(|| format!("{}\ndatabase schema {}", selftalk_proto::release(), schema_version()));
    &RELEASE
}

/// Evolves the controllers of a simulated iCub and keeps every generation in one SQLite file.
#[derive(Debug, Parser)]
#[command(name = "selftalk", version, long_version = long_version(), after_help = AFTER_HELP, max_term_width = 110)]
pub struct Cli {
    /// Options of all commands.
    #[command(flatten)]
    pub global: Global,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Options of all commands.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of all commands")]
pub struct Global {
    /// Database that holds the history
    #[arg(long, global = true, value_name = "PATH", default_value = "selftalk.db")]
    pub db: PathBuf,
    /// How data is printed
    #[arg(long, global = true, value_enum, default_value_t = Format::Table)]
    pub format: Format,
    /// Log more; twice for details. RUST_LOG overrides it
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// How logs are written, to stderr
    #[arg(long, global = true, value_enum, value_name = "FORMAT", default_value_t = LogFormat::Text)]
    pub log: LogFormat,
    /// Colours in help and logs
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t = Color::Auto)]
    pub color: Color,
}

impl Global {
    /// The directive for what is logged.
    #[must_use]
    pub const fn log_filter(&self) -> &'static str {
        match self.verbose {
            0 => "warn",
            1 => "warn,selftalk=info,selftalk_worker=info",
            _ => "info,selftalk=debug,selftalk_worker=debug,selftalk_proto=debug",
        }
    }
}

/// How data is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Columns for people
    Table,
    /// An array of objects, full precision
    Json,
    /// A header and a line a record, full precision
    Csv,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run an experiment on this machine
    Run(RunArgs),
    /// Run experiments with workers that connect over the network
    Serve(ServeArgs),
    /// Go on with what was interrupted, on this machine
    Resume(ResumeArgs),
    /// Plan more generations for an experiment
    Extend(ExtendArgs),
    /// Show a database in a browser
    Dashboard(DashboardArgs),
    /// Ask the database what happened
    History(HistoryArgs),
    /// Show individuals, their trials, and what went wrong in those that failed
    Show(ShowArgs),
    /// Play trials of an individual in a browser, or take all their signals away
    Replay(ReplayArgs),
    /// Run individuals in fresh trials, which no evolution has used
    Evaluate(EvaluateArgs),
    /// Put the best robots of the second training phase to the test at 196 places and postures
    Generalise(GeneraliseArgs),
    /// Whether an experiment's replications do better than another's
    Compare(CompareArgs),
    /// Run individuals in another physics engine, in the same fresh trials as in their own
    Transfer(TransferArgs),
    /// Run stored individuals again and compare what comes out with what is stored
    Verify(VerifyArgs),
    /// Write what an experiment came to into a folder, small enough to be kept with the source
    Results(ResultsArgs),
    /// Write the second training phase's figures, tables and tests into a folder
    Report(ReportArgs),
    /// Run the paper's whole study, or go on with it
    Reproduce(ReproduceArgs),
    /// Write the history as tables for other programs: CSV or Parquet
    Export(ExportArgs),
    /// Copy the database while it is written
    Backup(BackupArgs),
    /// Print a checksum of each replication's history
    Digest(DigestArgs),
    /// Look after a master over the network: how far it is, who works for it; hold it up, end it
    Operate(OperateArgs),
    /// Make what a master and its workers prove to each other who they are with
    Keys(KeysArgs),
    /// Print what a shell needs to complete command lines
    Completions(CompletionsArgs),
    /// Print the manual page, or write those of all commands
    Man(ManArgs),
}

/// Arguments of `selftalk run`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk run quickstart                       see it learn, in about a minute
  selftalk run elementary --workers 8           the paper's first training phase
  selftalk run integrated-lst --ancestors elementary     its second one, from the first one's champions
  selftalk run my.toml --set evolution.mutation=0.0004 --set name=mutable --db study.db

An experiment that is finished is not run again; one that was interrupted is continued by `selftalk resume`.
`selftalk --help` lists the exit codes.")]
pub struct RunArgs {
    /// A preset (quickstart, elementary, elementary-0.5, -linked, -further, -refined, integrated-c, -le, -st, -lst,
    /// linked-c and so on) or an experiment file
    #[arg(value_name = "PRESET|FILE.toml")]
    pub experiment: String,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
    /// Seed of all randomness, in place of the experiment's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    pub seed: Option<u64>,
    /// Change a setting of the experiment, as key=value with a dotted key; can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Whom the second training phase, or one with ancestors.evolve=true, starts from: the champions of an experiment in
    /// the database or of a folder of results, or `none`
    #[arg(long, value_name = "EXPERIMENT|FOLDER")]
    pub ancestors: Option<String>,
    /// Where the dashboard is.
    #[command(flatten)]
    pub shown: Shown,
}

/// Arguments of `selftalk serve`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk serve elementary                     new or interrupted; workers on this machine connect to port 7700
  selftalk serve --listen 0.0.0.0:7700 --keys keys/master a.toml b.toml --db study.db
  selftalk serve                                go on with everything unfinished in the database
  selftalk-worker --master http://host:7700     start as many as you like, where you like

`selftalk --help` lists the exit codes.")]
pub struct ServeArgs {
    /// Address and port to listen on
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7700")]
    pub listen: SocketAddr,
    /// Folder with what encrypts the lines to workers, made by `selftalk keys init`: tls.crt, tls.key, token,
    /// operator-token, and ca.crt if workers must have certificates
    #[arg(long, value_name = "FOLDER")]
    pub keys: Option<PathBuf>,
    /// File with a token that workers must have [default: the one among the keys, or the environment's SELFTALK_TOKEN, if
    /// there is one]
    #[arg(long, value_name = "FILE")]
    pub token_file: Option<PathBuf>,
    /// File with a token that operators must have, who may look where the run stands, hold it up and end it [default: the
    /// one among the keys; without one there are no operators]
    #[arg(long, value_name = "FILE")]
    pub operator_token_file: Option<PathBuf>,
    /// Share of the workers' results that are evaluated again here, 0 to 1: a worker that was wrong is sent away, and what
    /// it has contributed since it was last right is evaluated again
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, value_parser = share)]
    pub audit: f64,
    /// Presets or experiment files; without any, everything unfinished in the database is continued
    #[arg(value_name = "PRESET|FILE.toml")]
    pub experiments: Vec<String>,
    /// Whom the second training phase, or one with ancestors.evolve=true, starts from: the champions of an experiment in
    /// the database or of a folder of results, or `none`
    #[arg(long, value_name = "EXPERIMENT|FOLDER")]
    pub ancestors: Option<String>,
    /// Where the dashboard is.
    #[command(flatten)]
    pub shown: Shown,
}

/// Arguments of `selftalk resume`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk resume                               everything unfinished in selftalk.db
  selftalk resume quickstart --workers 2

`selftalk serve` does the same with workers that connect over the network.
`selftalk --help` lists the exit codes.")]
pub struct ResumeArgs {
    /// Experiment to go on with [default: all unfinished ones]
    #[arg(value_name = "EXPERIMENT")]
    pub experiment: Option<String>,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub workers: Option<u32>,
    /// Where the dashboard is.
    #[command(flatten)]
    pub shown: Shown,
}

/// Arguments of `selftalk extend`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
It comes to the same history as if it had been planned for so many from the beginning. Replications that have ended at their
first optimum, as evolution.stop_at_optimum asks for, stay as they are. No master may be running.

Examples:
  selftalk extend quickstart --generations 200
  selftalk resume quickstart

`selftalk --help` lists the exit codes.")]
pub struct ExtendArgs {
    /// The experiment
    #[arg(value_name = "EXPERIMENT")]
    pub experiment: String,
    /// Generations of each replication, those that it has included
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub generations: u32,
}

/// Arguments of `selftalk history`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk history experiments
  selftalk history generations --experiment quickstart --replication 0 --format csv
  selftalk history individuals --best                      the best of every replication's last generation
  selftalk history individuals --replication 1 --generation 12
  selftalk history lineage --experiment quickstart --replication 0     how its last best came to be
  selftalk history behaviours --curves                     which behaviour was learnt when

`selftalk --help` lists the exit codes.")]
pub struct HistoryArgs {
    /// What to list.
    #[command(subcommand)]
    pub what: HistoryCommand,
}

/// The lists of `selftalk history`.
#[derive(Debug, Clone, Subcommand)]
pub enum HistoryCommand {
    /// The experiments and how far they are
    Experiments(ExperimentFilter),
    /// The replications, how far they are and what their last generation came to
    Replications(ReplicationFilter),
    /// What each generation came to
    Generations(GenerationFilter),
    /// The individuals of one generation: the last one, unless another is named
    Individuals(IndividualFilter),
    /// An individual and its ancestors, back to the founder
    Lineage(LineageFilter),
    /// How often the best individuals succeeded in each behaviour, over the generations
    Behaviours(BehaviourFilter),
    /// The workers that took part
    Workers,
}

/// Which experiments.
#[derive(Debug, Clone, Default, Args)]
pub struct ExperimentFilter {
    /// Only this experiment
    #[arg(long, value_name = "NAME")]
    pub experiment: Option<String>,
}

/// Which replications.
#[derive(Debug, Clone, Default, Args)]
pub struct ReplicationFilter {
    /// Only this experiment
    #[arg(long, value_name = "NAME")]
    pub experiment: Option<String>,
    /// Only this replication, counted from 0
    #[arg(long, value_name = "N")]
    pub replication: Option<u32>,
}

/// Which generations.
#[derive(Debug, Clone, Default, Args)]
pub struct GenerationFilter {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// Only this generation, counted from 0
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
    /// Only the generation with the fittest individual of each replication
    #[arg(long, conflicts_with = "generation")]
    pub best: bool,
}

/// Which individuals.
#[derive(Debug, Clone, Default, Args)]
pub struct IndividualFilter {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// This generation, counted from 0 [default: each replication's last]
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
    /// Only the best individual of the generation
    #[arg(long)]
    pub best: bool,
    /// Show the genes as well, four hexadecimal digits each
    #[arg(long)]
    pub genes: bool,
}

/// Whose ancestors.
#[derive(Debug, Clone, Default, Args)]
pub struct LineageFilter {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// The individual's generation, counted from 0 [default: each replication's last]
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
    /// The individual's number in its generation, counted from 0 [default: the best]
    #[arg(long, value_name = "N", conflicts_with = "best")]
    pub individual: Option<u32>,
    /// The best individual of the generation; the default
    #[arg(long)]
    pub best: bool,
}

/// How learning is shown.
#[derive(Debug, Clone, Args)]
pub struct BehaviourFilter {
    /// Which replications.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// Parts that the generations of a replication are divided into
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub bins: u32,
    /// Draw a curve for each behaviour
    #[arg(long)]
    pub curves: bool,
}

/// Arguments of `selftalk digest`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Two histories with equal digests hold the same genotypes, parents, trial scores, successes and rankings in every
generation. Times, workers and interruptions do not enter.

Examples:
  selftalk digest
  selftalk digest quickstart --format json

`selftalk --help` lists the exit codes.")]
pub struct DigestArgs {
    /// Only this experiment
    #[arg(value_name = "EXPERIMENT")]
    pub experiment: Option<String>,
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| "expected a number between 0 and 1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definitions_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn global_options_may_follow_the_command() {
        let cli = Cli::try_parse_from(["selftalk", "history", "workers", "--db", "a.db", "--format", "csv"])
            .unwrap();
        assert_eq!(cli.global.db, PathBuf::from("a.db"));
        assert_eq!(cli.global.format, Format::Csv);
    }
}
