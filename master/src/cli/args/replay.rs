//! The command that plays a trial.

use std::path::PathBuf;

use clap::Args;

use super::ReplicationFilter;

/// Arguments of `selftalk replay`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The trials are run again and must come to what is stored, to the last bit of the score (exit code 7 if not). The page needs
no server and no network: robot, object and target in 3D, and on the same time axis focus, labels, touch, joint angles,
reward, and when the goal was reached. replay.html#trial=9&step=20 is a link to a moment.

Examples:
  selftalk replay                               all trials of the best individual of the first replication
  selftalk replay quickstart/0/59/12 --behaviour grasp --html grasp.html
  selftalk replay best --replication 1 --trial 13 --csv - > trial.csv
  selftalk replay champion --mcap champion.mcap
  selftalk replay best --trial 9 --strip grasp.png

`selftalk --help` lists the exit codes.")]
pub struct ReplayArgs {
    /// EXPERIMENT/REPLICATION/GENERATION/INDIVIDUAL, `best`, or `champion`; the first if these are several
    #[arg(value_name = "INDIVIDUAL", default_value = "best")]
    pub individual: String,
    /// Of which replications `best` and `champion` are.
    #[command(flatten)]
    pub of: ReplicationFilter,
    /// `best` of this generation, `champion` up to it, counted from 0 [default: the last]
    #[arg(long, value_name = "N")]
    pub generation: Option<u32>,
    /// Only trials of this behaviour: reach, open, grasp, move, move-to-target
    #[arg(long, value_name = "NAME")]
    pub behaviour: Option<String>,
    /// Only this trial, counted from 0
    #[arg(long, value_name = "N")]
    pub trial: Option<u32>,
    /// The page to write
    #[arg(long, value_name = "FILE", default_value = "replay.html")]
    pub html: PathBuf,
    /// Write all signals as JSON instead; `-` is stdout
    #[arg(long, value_name = "FILE", conflicts_with = "html")]
    pub json: Option<PathBuf>,
    /// Write all signals of one trial as CSV instead; `-` is stdout
    #[arg(long, value_name = "FILE", conflicts_with_all = ["html", "json"])]
    pub csv: Option<PathBuf>,
    /// Write an MCAP file instead, for Foxglove and Rerun: the scene, transforms, events and all signals, the trials one
    /// after the other; `-` is stdout
    #[arg(long, value_name = "FILE", conflicts_with_all = ["html", "json", "csv"])]
    pub mcap: Option<PathBuf>,
    /// Draw key moments of one trial side by side instead: FILE.png or FILE.svg
    #[arg(long, value_name = "FILE", conflicts_with_all = ["html", "json", "csv", "mcap"])]
    pub strip: Option<PathBuf>,
}
