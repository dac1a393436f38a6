//! From what is named on the command line to experiments that can be run.

use std::path::Path;

use selftalk_sim::Experiment;
use selftalk_sim::experiment::{PRESETS, Preset};
use selftalk_sim::fingerprint;

use super::Global;
use crate::exit::{Exit, Failure};
use crate::store::{ReplicationState, SqliteStore, Store, StoreError, StoredExperiment};

/// Reads a preset or a file, with `key=value` overrides.
///
/// # Errors
/// [`Failure`] when there is no such thing or it is refused.
pub(super) fn read(named: &str, overrides: &[String]) -> Result<Experiment, Failure> {
    if let Some(preset) = Preset::find(named) {
        return Ok(preset.experiment(overrides)?);
    }
    match std::fs::read_to_string(named) {
        Ok(text) => Ok(Experiment::from_toml(named, &text, overrides)?),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let presets = PRESETS.iter().map(|preset| preset.name).collect::<Vec<_>>().join(", ");
            let message = format!("{named}: neither a file nor a preset (presets: {presets})");
            Err(Failure::new(Exit::Usage, message))
        }
        Err(error) => Err(Failure::new(Exit::Experiment, format!("{named}: cannot be read: {error}"))),
    }
}

/// The stored experiment for these settings, created if there is none of that name.
///
/// # Errors
/// [`Exit::Exists`] when there is one of that name with other settings.
pub(super) async fn find_or_create(
    store: &SqliteStore,
    experiment: &Experiment,
) -> Result<StoredExperiment, Failure> {
    let Some(stored) = store.experiment(&experiment.name).await? else {
        return Ok(store.create_experiment(experiment, &fingerprint()?).await?);
    };
    if let Some(difference) = difference(&stored.experiment, experiment) {
        let name = &experiment.name;
        let message = format!(
            "experiment `{name}` exists with other settings ({difference}); give the new one a name of its own \
             with `--set name=...`"
        );
        return Err(Failure::new(Exit::Exists, message));
    }
    Ok(stored)
}

/// The first setting, in the order of the file, in which two experiments of one name differ.
fn difference(stored: &Experiment, asked: &Experiment) -> Option<String> {
    let (stored, asked) = (stored.to_toml(), asked.to_toml());
    let mut section = "";
    for (stored, asked) in stored.lines().zip(asked.lines()) {
        if let Some(name) = stored.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) {
            section = name;
        }
        if stored != asked {
            let (key, old) = stored.split_once(" = ").unwrap_or((stored, ""));
            let new = asked.split_once(" = ").map_or(asked, |(_, value)| value);
            let dot = if section.is_empty() { "" } else { "." };
            return Some(format!("{section}{dot}{key} is {old}, not {new}"));
        }
    }
    None
}

/// Opens a history that must be there for writing.
///
/// # Errors
/// [`Failure`] when it is not there, or cannot be written.
pub(super) async fn open_existing(global: &Global) -> Result<SqliteStore, Failure> {
    if !global.db.exists() {
        return Err(StoreError::Missing { path: global.db.clone() }.into());
    }
    Ok(SqliteStore::open_writer(&global.db).await?)
}

/// Whether there are generations left to run.
pub(super) fn unfinished(stored: &StoredExperiment) -> bool {
    stored.state() == ReplicationState::Running
}

/// Refuses to go on with what another simulator has begun: the generations would not belong together.
///
/// # Errors
/// [`Exit::Exists`] when the fingerprint is not this program's.
pub(super) fn continuable(stored: &StoredExperiment) -> Result<(), Failure> {
    if unfinished(stored) { of_this_simulator(stored) } else { Ok(()) }
}

/// Refuses what another simulator has begun, finished or not.
///
/// # Errors
/// [`Exit::Exists`] when the fingerprint is not this program's.
pub(super) fn of_this_simulator(stored: &StoredExperiment) -> Result<(), Failure> {
    let (begun, ours) = (&stored.fingerprint, fingerprint()?);
    if *begun == ours {
        return Ok(());
    }
    let name = &stored.experiment.name;
    let message = format!(
        "experiment `{name}` was begun with a simulator that gives other results (fingerprint {begun}, this \
         release has {ours}); go on with that release, or run it anew with `--set name=...`"
    );
    Err(Failure::new(Exit::Exists, message))
}

/// The command that goes on with an interrupted experiment.
pub(super) fn resume_command(global: &Global, name: &str) -> String {
    command(global, &format!("resume {name}"))
}

/// A command on the same database.
pub(super) fn command(global: &Global, what: &str) -> String {
    if global.db == Path::new("selftalk.db") {
        format!("selftalk {what}")
    } else {
        format!("selftalk {what} --db {}", global.db.display())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_is_named_with_its_section() {
        let stored = Experiment::default();
        assert_eq!(difference(&stored, &stored), None);
        let mut asked = stored.clone();
        asked.transport.steps = 7;
        asked.evolution.mutation = 0.25;
        let message = difference(&stored, &asked).unwrap();
        assert_eq!(message, "evolution.mutation is 0.00005, not 0.25");
        asked.seed = 9;
        assert_eq!(difference(&stored, &asked).unwrap(), "seed is 1, not 9");
    }

    #[test]
    fn an_unknown_name_lists_the_presets() {
        let failure = read("quikstart", &[]).unwrap_err();
        assert_eq!(failure.exit, Exit::Usage);
        assert!(failure.message.contains("quickstart, elementary"), "{failure}");
    }

    #[test]
    fn a_broken_file_is_refused_as_such() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("x.toml");
        std::fs::write(&path, "generations = 0").unwrap();
        let failure = read(path.to_str().unwrap(), &[]).unwrap_err();
        assert_eq!(failure.exit, Exit::Experiment);
        assert!(failure.message.contains("generations = 0"), "{failure}");
    }
}
