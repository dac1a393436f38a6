//! The command for those who look after a master.

use std::path::PathBuf;

use clap::{Args, Subcommand};

/// Arguments of `selftalk operate`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Examples:
  selftalk serve elementary --listen 0.0.0.0:7700 --keys keys/master
  selftalk operate standings --master https://node1:7700 --keys keys/operator      elsewhere, with a copy of keys/operator
  selftalk operate pause --master https://node1:7700 --keys keys/operator
  selftalk operate stop --token-file secret                                        a master without keys on this machine

What is asked for needs the operators' token, which no worker has; the workers' token opens nothing here.
`selftalk --help` lists the exit codes.")]
pub struct OperateArgs {
    /// Which master.
    #[command(flatten)]
    pub at: OperateAt,
    /// What to do
    #[command(subcommand)]
    pub what: OperateCommand,
}

/// Which master, and what shows that one may operate it.
#[derive(Debug, Clone, Args)]
pub struct OperateAt {
    /// Address of the master
    #[arg(long, global = true, value_name = "URL", default_value = "http://127.0.0.1:7700")]
    pub master: String,
    /// Folder with what encrypts the line, made by `selftalk keys init`: ca.crt, tls.crt, tls.key, token. The address is
    /// https:// then
    #[arg(long, global = true, value_name = "FOLDER")]
    pub keys: Option<PathBuf>,
    /// File with the operators' token [default: the one among the keys, or the environment's SELFTALK_TOKEN]
    #[arg(long, global = true, value_name = "FILE")]
    pub token_file: Option<PathBuf>,
}

/// The commands of `selftalk operate`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Subcommand)]
pub enum OperateCommand {
    /// List how far the replications are that the master runs
    Standings,
    /// List the workers that are connected, and what they are at
    Workers,
    /// Give out no more work; what workers hold they finish
    Pause,
    /// Give out work again
    Continue,
    /// End the master as SIGTERM does: all complete generations are kept
    Stop,
}
