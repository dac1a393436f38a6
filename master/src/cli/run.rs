//! `selftalk run`.

use super::Global;
use super::ancestors::adopt;
use super::args::RunArgs;
use super::choose::{continuable, find_or_create, read, resume_command, unfinished};
use super::conduct::{Workers, conduct, watch_signals};
use super::dashboard;
use super::summary::{next_steps, print_summary};
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store};

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: RunArgs, global: &Global) -> Result<(), Failure> {
    let mut overrides = args.set;
    overrides.extend(args.seed.map(|seed| format!("seed={seed}")));
    let mut experiment = read(&args.experiment, &overrides)?;
    adopt(&mut experiment, args.ancestors.as_deref(), global).await?;
    let signal = watch_signals()?;
    let dashboard = dashboard::of_run(&args.shown).await?;
    let store = SqliteStore::open_writer(&global.db).await?;
    let name = &experiment.name;
    let begun = store.experiment(name).await?.is_some();
    let stored = find_or_create(&store, &experiment).await?;
    if !unfinished(&stored) {
        print_summary(&[stored], global)?;
        eprintln!(
            "`{name}` is finished already and is not run again; `--set name=...` runs it under another name"
        );
        return Ok(store.close().await?);
    }
    continuable(&stored)?;
    if begun {
        let message = format!(
            "experiment `{name}` was interrupted; `{}` goes on with it",
            resume_command(global, name)
        );
        return Err(Failure::new(Exit::Exists, message));
    }
    let workers = Workers::Here(args.workers.unwrap_or_else(selftalk_worker::available_cores));
    let ended = conduct(store, vec![stored], workers, &signal, dashboard.as_ref(), None, global).await?;
    print_summary(&ended, global)?;
    next_steps(&ended, global);
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;
    use selftalk_sim::fingerprint;

    use crate::cli::{Cli, execute};
    use crate::exit::{Exit, Failure};
    use crate::store::{SqliteStore, Store};

    const TINY: &str = "name = \"tiny\"\nreplications = 2\ngenerations = 2\n[evolution]\npopulation = 4\nparents = 2\n\
                        offspring = 2\n";

    async fn say(folder: &Path, words: &str) -> Result<(), Failure> {
        let file = folder.join("tiny.toml");
        std::fs::write(&file, TINY).unwrap();
        let words = words.replace("FILE", file.to_str().unwrap());
        let mut cli = Cli::try_parse_from(["selftalk"].into_iter().chain(words.split(' '))).unwrap();
        cli.global.db = folder.join("history.db");
        execute(cli).await
    }

    async fn refused(folder: &Path, words: &str) -> (Exit, String) {
        let failure = say(folder, words).await.unwrap_err();
        (failure.exit, failure.message)
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn an_experiment_is_run_once() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        say(folder, "run FILE --workers 2").await.unwrap();
        say(folder, "run FILE").await.unwrap();
        say(folder, "resume tiny").await.unwrap();
        say(folder, "serve --listen 127.0.0.1:0 FILE").await.unwrap();
        let (exit, message) = refused(folder, "run FILE --seed 5").await;
        assert_eq!(exit, Exit::Exists);
        assert!(message.contains("seed is 1, not 5"), "{message}");
        let store = SqliteStore::open_reader(&folder.join("history.db")).await.unwrap();
        let replications = &store.experiments().await.unwrap()[0].replications;
        assert!(replications.iter().all(|replication| replication.finished && replication.generations == 2));
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn an_interrupted_experiment_is_only_resumed() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let path = folder.join("history.db");
        let experiment = selftalk_sim::Experiment::from_toml("tiny.toml", TINY, &[]).unwrap();
        let store = SqliteStore::open_writer(&path).await.unwrap();
        store.create_experiment(&experiment, &fingerprint().unwrap()).await.unwrap();
        let other = selftalk_sim::Experiment { name: "other".to_owned(), ..experiment };
        store.create_experiment(&other, "of another release").await.unwrap();
        store.close().await.unwrap();
        let (exit, message) = refused(folder, "run FILE").await;
        assert_eq!(exit, Exit::Exists);
        assert!(message.contains("selftalk resume tiny --db"), "{message}");
        let (exit, message) = refused(folder, "resume").await;
        assert_eq!(exit, Exit::Exists);
        assert!(message.contains("fingerprint of another release"), "{message}");
        say(folder, "resume tiny --workers 1").await.unwrap();
        say(folder, "run FILE").await.unwrap();
    }

    #[tokio::test]
    async fn failures_have_their_codes_and_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let port = taken.local_addr().unwrap().port();
        assert_eq!(refused(folder, &format!("serve --listen 127.0.0.1:{port} FILE")).await.0, Exit::Network);
        assert_eq!(refused(folder, "run nothing").await.0, Exit::Usage);
        assert_eq!(refused(folder, "run FILE --set generations=0").await.0, Exit::Experiment);
        assert_eq!(refused(folder, "resume").await.0, Exit::Database);
        assert_eq!(refused(folder, "serve --listen 127.0.0.1:0").await.0, Exit::Database);
        assert!(!folder.join("history.db").exists());
    }
}
