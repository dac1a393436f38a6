//! `selftalk serve`.

use std::fmt::Display;

use selftalk_proto::{MasterKeys, Token};
use tonic::transport::ServerTlsConfig;

use super::Global;
use super::ancestors::adopt;
use super::args::ServeArgs;
use super::choose::{continuable, find_or_create, open_existing, read, unfinished};
use super::conduct::{Remote, Workers, conduct, listen, watch_signals};
use super::dashboard;
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
    let Admission { token, operators, tls } = admission(&args)?;
    let signal = watch_signals()?;
    // A taken port is found out before anything is written.
    let listener = listen(args.listen).await?;
    let dashboard = dashboard::of_run(&args.shown).await?;
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
    let (scheme, keys) = if tls.is_some() { ("https", " --keys FOLDER") } else { ("http", "") };
    eprintln!(
        "listening on {address}; workers join with `selftalk-worker --master {scheme}://{address}{keys}`"
    );
    let remote = Remote { listener, token, operators, tls, audit: args.audit };
    let workers = Workers::Remote(remote);
    let ended = conduct(store, running, workers, &signal, dashboard.as_ref(), None, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}

/// What those who come in must have.
struct Admission {
    token: Option<Token>,
    operators: Option<Token>,
    tls: Option<ServerTlsConfig>,
}

/// Who may come in: those who have the token and, with keys, a certificate. Where other machines can, it takes keys and a
/// token, or a word to say that the network is trusted.
///
/// # Errors
/// [`Exit::Usage`] when that word is missing, or keys or tokens cannot be used.
fn admission(args: &ServeArgs) -> Result<Admission, Failure> {
    let usage = |error: &dyn Display| Failure::new(Exit::Usage, error);
    let variable = std::env::var(Token::VARIABLE).ok();
    let token =
        Token::given(args.token_file.as_deref(), variable.as_deref()).map_err(|error| usage(&error))?;
    let operators = Token::given(args.operator_token_file.as_deref(), None).map_err(|error| usage(&error))?;
    let keys = args.keys.as_deref().map(MasterKeys::read).transpose().map_err(|error| usage(&error))?;
    let (tls, workers, others) =
        keys.map_or((None, None, None), |keys| (Some(keys.tls), keys.token, keys.operators));
    let (token, operators) = (token.or(workers), operators.or(others));
    if token.is_some() && token == operators {
        let message = "workers and operators have the same token; give them different ones, as any worker could \
                       end the run";
        return Err(usage(&message));
    }
    let admission = Admission { token, operators, tls };
    let who = match (&admission.token, &admission.tls) {
        (Some(_), Some(_)) => return Ok(admission),
        (Some(_), None) => "read along, as nothing is encrypted",
        (None, Some(_)) => "join as workers, as no token is asked for",
        (None, None) => "join as workers and read along, as there are neither token nor keys",
    };
    if !args.listen.ip().is_loopback() && !args.shown.insecure {
        let message = format!(
            "--listen {}: other machines could {who}; `selftalk keys init` makes both, for --keys, or add --insecure \
             if the network is trusted",
            args.listen
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(admission)
}
