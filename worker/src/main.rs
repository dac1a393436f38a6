//! The `selftalk-worker` command.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::{Parser, ValueEnum};
use selftalk_proto::{ClientKeys, KeysError, SLOT_LIMIT, Token, TokenError};
use selftalk_worker::{Config, End, WorkerError, run, signal};
use tracing_subscriber::EnvFilter;

const AFTER_HELP: &str = "\
Examples:
  selftalk-worker --master http://127.0.0.1:7700
  selftalk-worker --master http://node1:7700 --slots 4 --connect-timeout 600
  selftalk-worker --master https://node1:7700 --keys keys/worker

A worker ends when the master has finished. When the line is cut it goes on, and reconnects for as long as it takes.

Exit codes:
    0  the master has finished
    1  unexpected failure
    2  the command line is wrong
    5  the master cannot be reached, or refuses the worker
  130  ended by Ctrl-C, 143 by SIGTERM: the master gives the work to others at once";

/// How logs are written.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum LogFormat {
    /// Lines for people
    Text,
    /// A JSON object a line
    Json,
}

/// Runs trials for a selftalk master.
#[derive(Debug, Parser)]
#[command(name = "selftalk-worker", version, long_version = selftalk_proto::release(), after_help = AFTER_HELP, max_term_width = 110)]
struct Cli {
    /// Address of the master
    #[arg(long, value_name = "URL", default_value = "http://127.0.0.1:7700")]
    master: String,
    /// Threads that run trials [default: one for every core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(SLOT_LIMIT)))]
    slots: Option<u32>,
    /// Folder with what encrypts the line, made by `selftalk keys init`: ca.crt, tls.crt, tls.key, token. The address
    /// is https:// then
    #[arg(long, value_name = "FOLDER")]
    keys: Option<PathBuf>,
    /// File with the token that the master asks for [default: the one among the keys, or the environment's SELFTALK_TOKEN, if there is one]
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Seconds for which a master is tried that has never been reached
    #[arg(long, value_name = "SECONDS", default_value_t = 30)]
    connect_timeout: u64,
    /// Log more; twice for details. RUST_LOG overrides it
    #[arg(long, short, action = clap::ArgAction::Count)]
    verbose: u8,
    /// How logs are written, to stderr
    #[arg(long, value_enum, value_name = "FORMAT", default_value_t = LogFormat::Text)]
    log: LogFormat,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let default = match cli.verbose {
        0 => "warn,selftalk_worker=info",
        _ => "info,selftalk_worker=debug",
    };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    let plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let log = tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(!plain && std::io::stderr().is_terminal())
        .with_env_filter(filter);
    match cli.log {
        LogFormat::Text => log.init(),
        LogFormat::Json => log.json().with_ansi(false).init(),
    }
    match work(cli) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            eprintln!("error: {error:#}");
            let network = error.downcast_ref::<WorkerError>().is_some_and(WorkerError::is_network);
            let usage = error.is::<TokenError>()
                || error.is::<KeysError>()
                || matches!(error.downcast_ref(), Some(WorkerError::Address(_)));
            ExitCode::from(if network {
                5
            } else if usage {
                2
            } else {
                1
            })
        }
    }
}

/// Works until the end and returns the exit code. The network needs one thread; the cores belong to the slots.
#[tokio::main(flavor = "current_thread")]
async fn work(cli: Cli) -> anyhow::Result<u8> {
    let mut config = Config::new(cli.master, selftalk_sim::fingerprint()?);
    config.slots = cli.slots.unwrap_or(config.slots);
    config.token = Token::given(cli.token_file.as_deref(), std::env::var(Token::VARIABLE).ok().as_deref())?;
    if let Some(folder) = &cli.keys {
        let keys = ClientKeys::read(folder)?;
        config.tls = Some(keys.tls);
        config.token = config.token.or(keys.token);
    }
    config.connect_timeout = Duration::from_secs(cli.connect_timeout);
    let signal = signal::watch()?;
    match run(config, signal.token()).await? {
        End::Finished => {
            tracing::info!("the master has finished");
            Ok(0)
        }
        End::Stopped => Ok(signal.exit_code().unwrap_or(0)),
    }
}
