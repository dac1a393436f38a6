//! The `selftalk` command.

#[cfg(feature = "otel")]
mod traces;

use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches};
use selftalk::cli::{Cli, Color, Global, LogFormat, execute};
#[cfg(feature = "otel")]
use selftalk::exit::Exit;
use selftalk::exit::Failure;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{EnvFilter, Layer, Registry, fmt};

#[tokio::main]
async fn main() -> ExitCode {
    let color = Color::asked(std::env::args_os());
    let matches = Cli::command().color(color.choice()).get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    match run(cli).await {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {failure}");
            failure.exit.into()
        }
    }
}

#[cfg(not(feature = "otel"))]
async fn run(cli: Cli) -> Result<(), Failure> {
    tracing_subscriber::registry().with(log(&cli.global)).init();
    execute(cli).await
}

#[cfg(feature = "otel")]
async fn run(cli: Cli) -> Result<(), Failure> {
    use tracing::level_filters::LevelFilter;

    let provider = traces::provider().map_err(|error| Failure::new(Exit::Usage, error))?;
    let spans = provider.as_ref().map(|provider| traces::layer(provider).with_filter(LevelFilter::INFO));
    tracing_subscriber::registry().with(log(&cli.global)).with(spans).init();
    let result = execute(cli).await;
    if let Some(provider) = provider {
        // It waits for the collector, which the runtime has to go on for.
        let sent = tokio::task::spawn_blocking(move || provider.shutdown()).await;
        if !matches!(sent, Ok(Ok(()))) {
            tracing::warn!("the last spans could not be sent");
        }
    }
    result
}

/// What writes logs to stderr.
fn log(global: &Global) -> impl Layer<Registry> + use<> {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(global.log_filter()));
    let lines = fmt::layer().with_writer(std::io::stderr);
    let lines = match global.log {
        LogFormat::Text => lines.with_ansi(global.color.on_stderr()).boxed(),
        LogFormat::Json => lines.json().with_ansi(false).boxed(),
    };
    lines.with_filter(filter)
}
