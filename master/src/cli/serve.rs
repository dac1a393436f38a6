//! `selftalk serve`.

use selftalk_proto::Token;

use super::Global;
use super::ancestors::adopt;
use super::args::ServeArgs;
use super::choose::{continuable, find_or_create, open_existing, read, unfinished};
use super::conduct::{Workers, conduct, listen, watch_signals};
use super::summary::{next_steps, print_summary};
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store, StoredExperiment};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ServeArgs, global: &Global) -> Result<(), Failure> {
    let mut asked = args.experiments.iter().map(|named| read(named, &[])).collect::<Result<Vec<_>, _>>()?;
    for experiment in &mut asked {
        adopt(experiment, args.ancestors.as_deref(), global).await?;
    }
    let token = token(&args)?;
    let signal = watch_signals()?;
    // A taken port is found out before anything is written.
    let listener = listen(args.listen).await?;
    let address = listener.local_addr().map_err(|error| Failure::new(Exit::Network, error))?;
    let (store, experiments) = if asked.is_empty() {
        let store = open_existing(global).await?;
        let experiments = store.experiments().await?;
        (store, experiments)
    } else {
        let store = SqliteStore::open_writer(&global.db).await?;
        let mut experiments: Vec<StoredExperiment> = Vec::new();
        for experiment in &asked {
            let stored = find_or_create(&store, experiment).await?;
            if experiments.iter().all(|other| other.id != stored.id) {
                experiments.push(stored);
            }
        }
        (store, experiments)
    };
    let (running, finished): (Vec<_>, Vec<_>) = experiments.into_iter().partition(unfinished);
    if running.is_empty() {
        print_summary(&finished, global)?;
        eprintln!("there is nothing to do: all of it is finished");
        return Ok(store.close().await?);
    }
    running.iter().try_for_each(continuable)?;
    eprintln!("listening on {address}; workers join with `selftalk-worker --master http://{address}`");
    let ended = conduct(store, running, Workers::Remote(listener, token), &signal, None, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}

/// The token that workers must have. Where other machines can come in, it takes a word to say that the network is trusted.
///
/// # Errors
/// [`Exit::Usage`] when that word is missing, or the token cannot be used.
fn token(args: &ServeArgs) -> Result<Option<Token>, Failure> {
    let variable = std::env::var(Token::VARIABLE).ok();
    let token = Token::given(args.token_file.as_deref(), variable.as_deref());
    let token = token.map_err(|error| Failure::new(Exit::Usage, error))?;
    if !args.listen.ip().is_loopback() && !args.insecure {
        let who = if token.is_some() { "read along" } else { "join as workers, and read along" };
        let message = format!(
            "--listen {}: other machines could {who}, as nothing is encrypted; add --insecure if the network is \
             trusted{}",
            args.listen,
            if token.is_some() {
                ""
            } else {
                ", and --token-file to let in only workers that know the token"
            }
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(token)
}
