//! From `--ancestors` to the individuals that an experiment's generation 0 is made from.

use std::path::Path;

use selftalk_sim::experiment::{Added, Task};
use selftalk_sim::{Experiment, Genotype};

use super::individuals::{chosen, foreign};
use super::work::{bar, crew};
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::results::Results;
use crate::retest::{CANDIDATES, VALIDATION_DRAWS};
use crate::store::{ReplicationState, SqliteStore};

/// Where nobody is to be started from.
const NONE: &str = "none";

/// Gives an experiment the ancestors that it needs, in the second phase or where they are to evolve further: `named` is an
/// experiment in the database, a folder of results, or `none`. Experiments that need none, or name their own, stay as they
/// are.
///
/// # Errors
/// [`Exit::Usage`] when it needs ancestors and none are named, or they are not there or not yet finished;
/// [`Exit::Experiment`] when they do not fit.
pub(super) async fn adopt(
    experiment: &mut Experiment,
    named: Option<&str>,
    global: &Global,
) -> Result<(), Failure> {
    let second_phase = experiment.task == Task::MoveToTarget && experiment.controller.added != Added::None;
    let needed = second_phase || experiment.ancestors.evolve;
    if !needed || !experiment.ancestors.genotypes.is_empty() || named == Some(NONE) {
        return Ok(());
    }
    let name = &experiment.name;
    let Some(named) = named else {
        let message = format!(
            "experiment `{name}` starts from individuals of an earlier one; name them with `--ancestors`: an \
             experiment in the database (`selftalk run elementary` makes one), a folder of results, or `{NONE}`"
        );
        return Err(Failure::new(Exit::Usage, message));
    };
    let (of, genotypes) = if Path::new(named).is_dir() {
        of_folder(Path::new(named))?
    } else {
        of_experiment(named, global).await?
    };
    if let Some(difference) = difference(&of, experiment) {
        let message = format!(
            "{name}: {difference} in the ancestors of `{named}`, whose genes would mean something else"
        );
        return Err(Failure::new(Exit::Experiment, message));
    }
    experiment.ancestors.genotypes = genotypes;
    Ok(())
}

fn of_folder(folder: &Path) -> Result<(Experiment, Vec<Genotype>), Failure> {
    let results = Results::read(folder)?;
    let refuse = |row: usize, error| {
        let path = folder.join("best.csv");
        Failure::new(Exit::Mismatch, format!("{}: genes of row {row}: {error}", path.display()))
    };
    let genotypes = (1..)
        .zip(&results.best)
        .map(|(row, best)| Genotype::from_hex(&best.genes).map_err(|error| refuse(row, error)))
        .collect::<Result<_, _>>()?;
    Ok((results.experiment, genotypes))
}

/// The champions of all replications of an experiment that is finished.
async fn of_experiment(name: &str, global: &Global) -> Result<(Experiment, Vec<Genotype>), Failure> {
    let store = select::open(global).await?;
    let mut experiments = select::experiments(&store, Some(name)).await?;
    let Some(stored) = experiments.pop() else {
        return Err(Failure::new(Exit::Usage, format!("there is no experiment `{name}`")));
    };
    if stored.state() != ReplicationState::Finished {
        let message =
            format!("experiment `{name}` is not finished; `selftalk resume {name}` goes on with it");
        return Err(Failure::new(Exit::Usage, message));
    }
    if let Some(words) = foreign(name, &stored.fingerprint)? {
        eprintln!("warning: {words}");
    }
    let genotypes = champions(&store, &stored).await?;
    Ok((stored.experiment, genotypes))
}

async fn champions(
    store: &SqliteStore,
    stored: &crate::store::StoredExperiment,
) -> Result<Vec<Genotype>, Failure> {
    let trials = stored.replications.len() as u64 * u64::from(16 * CANDIDATES * VALIDATION_DRAWS);
    let bar = bar(trials);
    let done = || bar.inc(1);
    let mut genotypes = Vec::with_capacity(stored.replications.len());
    for replication in &stored.replications {
        let last = replication.generations.saturating_sub(1);
        let champion = chosen(store, stored, replication, last, crew(None, &done)).await?;
        genotypes.extend(champion.map(|individual| Genotype::clone(&individual.member.genotype)));
    }
    bar.finish_and_clear();
    Ok(genotypes)
}

/// The first setting of the controller by which a gene of one experiment means something else in another.
fn difference(ancestors: &Experiment, heirs: &Experiment) -> Option<String> {
    let (theirs, ours) = (&ancestors.controller, &heirs.controller);
    if theirs.recurrent != ours.recurrent {
        return Some(format!("controller.recurrent is {} here and {}", ours.recurrent, theirs.recurrent));
    }
    if theirs.added != Added::None {
        return Some("controller.added is not \"none\"".to_owned());
    }
    [
        ("weight_range", ours.weight_range, theirs.weight_range),
        ("slope", ours.slope, theirs.slope),
        ("position_scale", ours.position_scale, theirs.position_scale),
        ("position_limit", ours.position_limit, theirs.position_limit),
    ]
    .into_iter()
    .find(|(_, ours, theirs)| ours != theirs)
    .map(|(key, ours, theirs)| format!("controller.{key} is {ours} here and {theirs}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::args::{Color, Format, LogFormat};

    fn global(folder: &Path) -> Global {
        Global {
            db: folder.join("history.db"),
            format: Format::Table,
            verbose: 0,
            log: LogFormat::Text,
            color: Color::Auto,
        }
    }

    fn integrated(overrides: &[&str]) -> Experiment {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        selftalk_sim::experiment::Preset::find("integrated-lst").unwrap().experiment(&overrides).unwrap()
    }

    #[tokio::test]
    async fn only_the_second_phase_and_what_evolves_ancestors_need_some() {
        let folder = tempfile::tempdir().unwrap();
        let global = global(folder.path());
        let mut elementary = Experiment::default();
        adopt(&mut elementary, Some("nothing"), &global).await.unwrap();
        assert_eq!(elementary, Experiment::default());
        let mut experiment = integrated(&[]);
        let failure = adopt(&mut experiment, None, &global).await.unwrap_err();
        assert_eq!(failure.exit, Exit::Usage);
        assert!(failure.message.contains("--ancestors"), "{failure}");
        adopt(&mut experiment, Some("none"), &global).await.unwrap();
        assert!(experiment.ancestors.genotypes.is_empty());
        elementary.ancestors.evolve = true;
        let failure = adopt(&mut elementary, None, &global).await.unwrap_err();
        assert!(failure.message.contains("--ancestors"), "{failure}");
    }

    #[tokio::test]
    async fn a_folder_of_results_gives_its_champions_if_the_controllers_fit() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/elementary");
        let kept = kept.to_str().unwrap();
        let mut experiment = integrated(&[]);
        adopt(&mut experiment, Some(kept), &global(folder.path())).await.unwrap();
        assert_eq!(experiment.ancestors.genotypes.len(), 10);
        assert!(selftalk_sim::Simulator::new(&experiment).is_ok());
        let mut other = integrated(&["controller.slope=1.5"]);
        let failure = adopt(&mut other, Some(kept), &global(folder.path())).await.unwrap_err();
        assert_eq!(failure.exit, Exit::Experiment);
        assert!(failure.message.contains("controller.slope is 1.5 here and 3"), "{failure}");
    }
}
