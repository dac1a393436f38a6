//! The command `selftalk keys`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Arguments of `selftalk keys`.
#[derive(Debug, Clone, Args)]
pub struct KeysArgs {
    /// What to do
    #[command(subcommand)]
    pub what: KeysCommand,
}

/// The commands of `selftalk keys`.
#[derive(Debug, Clone, Subcommand)]
pub enum KeysCommand {
    /// Make certificates, keys and tokens in a new folder, with a part for the master, one for its workers and one for its
    /// operators
    Init(KeysInitArgs),
}

/// Arguments of `selftalk keys init`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk keys init keys --host node1 --host 10.0.0.5
  selftalk serve elementary --listen 0.0.0.0:7700 --keys keys/master
  selftalk-worker --master https://node1:7700 --keys keys/worker          elsewhere, with a copy of keys/worker
  selftalk operate standings --master https://node1:7700 --keys keys/operator

The certificates do not expire. To replace them make another folder and start master and workers again.
`selftalk --help` lists the exit codes.")]
pub struct KeysInitArgs {
    /// The folder; it must not exist
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// A name or address by which workers and operators reach the master, besides localhost; can be repeated
    #[arg(long = "host", value_name = "NAME|ADDRESS")]
    pub hosts: Vec<String>,
}
