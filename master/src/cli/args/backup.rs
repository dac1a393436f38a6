//! The command that copies the database.

use std::path::PathBuf;

use clap::Args;

/// Arguments of `selftalk backup`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
The copy is a complete database as it stood at one moment, and is made while a master goes on writing. It appears when it is
complete; one that is there is replaced then, anything else is not. Go on from it with `selftalk resume --db COPY`.

Examples:
  selftalk backup /mnt/archive/selftalk.db
  selftalk backup /mnt/archive/selftalk.db --every 10     until Ctrl-C

`selftalk --help` lists the exit codes.")]
pub struct BackupArgs {
    /// The copy
    #[arg(value_name = "FILE")]
    pub to: PathBuf,
    /// Make it again and again, every so many minutes, until the command is ended
    #[arg(long, value_name = "MINUTES", value_parser = clap::value_parser!(u32).range(1..=10_080))]
    pub every: Option<u32>,
}
