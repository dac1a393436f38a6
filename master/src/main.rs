//! The `selftalk` command.

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};
use selftalk::cli::{Cli, Color, Global, LogFormat, execute};
use tracing_subscriber::EnvFilter;

#[tokio::main]
async fn main() -> ExitCode {
    let color = Color::asked(std::env::args_os());
    let matches = Cli::command().color(color.choice()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    log(&cli.global);
    match execute(cli).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit.into()
        }
    }
}

/// Has what is logged written to stderr.
fn log(global: &Global) {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(global.log_filter()));
    let log = tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(global.color.on_stderr())
        .with_env_filter(filter);
    match global.log {
        LogFormat::Text => log.init(),
        LogFormat::Json => log.json().with_ansi(false).init(),
    }
}
