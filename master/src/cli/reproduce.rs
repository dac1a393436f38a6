//! `selftalk reproduce`: the whole study, from nothing or from wherever it stands.

use selftalk_sim::Experiment;
use selftalk_sim::experiment::Task;
use selftalk_worker::signal::Signal;

use super::ancestors::adopt;
use super::args::ReproduceArgs;
use super::battery::{generalise_replication, post_evaluate_replication};
use super::choose::{continuable, find_or_create, read, unfinished};
use super::conduct::{Workers, conduct, watch_signals};
use super::dashboard::{self, Dashboard};
use super::overall::Overall;
use super::report::gathered;
use super::{Global, results, select};
use crate::exit::{Exit, Failure};
use crate::store::{SqliteStore, Store, StoredExperiment, Test};

/// The conditions of the second phase, as the presets' names end.
const CONDITIONS: [&str; 4] = ["c", "le", "st", "lst"];
/// Fresh trials by which the champions of the first phase are reported on.
const FRESH_TRIALS: u32 = 400;
/// The study's database, in its folder.
const DATABASE: &str = "study.db";

/// Control steps that a trial lasts, about: for the estimate of the time left.
const ELEMENTARY_STEPS: f64 = 30.0;
const INTEGRATED_STEPS: f64 = 110.0;
/// Trials by which a replication's robots are tested, about: 40 for every generation, as far as its best individual is a
/// new one, and 196 places twice.
const POST_TRIALS: f64 = 40.0 * 0.6;
const GRID_TRIALS: f64 = 2.0 * 196.0;

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: ReproduceArgs, global: &Global) -> Result<(), Failure> {
    let signal = watch_signals()?;
    let dashboard = dashboard::of_run(&args.shown).await?;
    let folder = args.dir.clone();
    std::fs::create_dir_all(&folder).map_err(|error| {
        Failure::new(Exit::Usage, format!("{}: cannot be created: {error}", folder.display()))
    })?;
    let global = Global { db: folder.join(DATABASE), ..global.clone() };
    let study = Study { args, global, signal, dashboard };
    study.run().await.map_err(|failure| study.explained(failure))
}

struct Study {
    args: ReproduceArgs,
    global: Global,
    signal: Signal,
    dashboard: Option<Dashboard>,
}

impl Study {
    async fn run(&self) -> Result<(), Failure> {
        let mut first = self.first()?;
        let mut second = self.second()?;
        let mut overall = self.overall(first.iter().chain(&second)).await?;

        let mut before: Option<&str> = None;
        for experiment in &mut first {
            if let Some(before) = before {
                self.bequeath(before, std::slice::from_mut(experiment)).await?;
            }
            self.evolve(std::slice::from_ref(experiment), &mut overall).await?;
            before = Some(&experiment.name);
        }
        if let Some(before) = before {
            self.bequeath(before, &mut second).await?;
        }
        self.evolve(&second, &mut overall).await?;
        self.test(&second, &mut overall).await?;
        self.write(&first, &second).await
    }

    /// The experiments of the first phase, of which each starts from the champions of the one before.
    fn first(&self) -> Result<Vec<Experiment>, Failure> {
        let refuse =
            |name: &str, reason: &str| Err(Failure::new(Exit::Usage, format!("--first {name}: {reason}")));
        let overrides = self.overrides(&self.args.set_first);
        let mut experiments: Vec<Experiment> = Vec::with_capacity(self.args.first.len());
        for name in &self.args.first {
            let experiment = read(name, &overrides)?;
            if experiment.task != Task::Elementary {
                return refuse(name, "this is not an experiment of the first phase");
            }
            if experiments.iter().any(|other| other.name == experiment.name) {
                return refuse(name, "there is one of that name already");
            }
            let follows = experiment.ancestors.evolve && experiment.ancestors.genotypes.is_empty();
            if follows == experiments.is_empty() {
                let reason = if follows {
                    "it goes on from another's champions, which has to come before it (ancestors.evolve is true)"
                } else {
                    "only one with ancestors.evolve = true goes on from another's champions"
                };
                return refuse(name, reason);
            }
            experiments.push(experiment);
        }
        Ok(experiments)
    }

    /// The conditions of the second phase.
    fn second(&self) -> Result<Vec<Experiment>, Failure> {
        let overrides = self.overrides(&self.args.set_second);
        let names = CONDITIONS.map(|condition| format!("{}-{condition}", self.args.second));
        names.iter().map(|name| read(name, &overrides)).collect()
    }

    fn overrides(&self, of_phase: &[String]) -> Vec<String> {
        let seed = self.args.seed.map(|seed| format!("seed={seed}"));
        self.args.set.iter().chain(of_phase).cloned().chain(seed).collect()
    }

    /// How far the study is.
    async fn overall(&self, experiments: impl Iterator<Item = &Experiment>) -> Result<Overall, Failure> {
        let (mut whole, mut done) = (0.0, 0.0);
        // As a writer, which also mends a file that was left without its tables.
        let store = SqliteStore::open_writer(&self.global.db).await?;
        for experiment in experiments {
            whole += work(experiment) + tests(experiment);
            let Some(stored) = store.experiment(&experiment.name).await? else { continue };
            done += work(experiment) - remaining(&stored);
            for replication in &stored.replications {
                if !store.list_retests(replication.id, Test::Generalisation).await?.is_empty() {
                    done += tests(experiment) / f64::from(experiment.replications);
                }
            }
        }
        store.close().await?;
        Ok(Overall::new(whole, done))
    }

    /// Gives experiments their ancestors: those of one that was begun, or the champions of the experiment `before`. All
    /// have the same, which take a while to choose.
    async fn bequeath(&self, before: &str, heirs: &mut [Experiment]) -> Result<(), Failure> {
        let store = select::open(&self.global).await?;
        let mut chosen = None;
        for experiment in &mut *heirs {
            let begun = store.experiment(&experiment.name).await?;
            chosen = chosen.or(begun.map(|begun| begun.experiment.ancestors.genotypes));
        }
        for experiment in heirs {
            match &chosen {
                Some(genotypes) => experiment.ancestors.genotypes.clone_from(genotypes),
                None => {
                    adopt(experiment, Some(before), &self.global).await?;
                    chosen = Some(experiment.ancestors.genotypes.clone());
                }
            }
        }
        Ok(())
    }

    /// Runs what is left of experiments, all at the same time.
    async fn evolve(&self, experiments: &[Experiment], overall: &mut Overall) -> Result<(), Failure> {
        let store = SqliteStore::open_writer(&self.global.db).await?;
        let mut running = Vec::with_capacity(experiments.len());
        for experiment in experiments {
            running.push(find_or_create(&store, experiment).await?);
        }
        running.retain(unfinished);
        overall.begin(running.iter().map(remaining).sum());
        if running.is_empty() {
            return Ok(store.close().await?);
        }
        running.iter().try_for_each(continuable)?;
        let names: Vec<&str> = running.iter().map(|stored| stored.experiment.name.as_str()).collect();
        eprintln!("{}: evolution of {}", overall.words(0.0), names.join(", "));
        let workers = Workers::Here(self.args.workers.unwrap_or_else(selftalk_worker::available_cores));
        let (dashboard, overall) = (self.dashboard.as_ref(), Some(overall.clone()));
        conduct(store, running, workers, &self.signal, dashboard, overall, &self.global).await?;
        Ok(())
    }

    /// Post-evaluation and generalisation, as far as they are missing.
    async fn test(&self, experiments: &[Experiment], overall: &mut Overall) -> Result<(), Failure> {
        let store = SqliteStore::open_writer(&self.global.db).await?;
        if let Some(dashboard) = &self.dashboard {
            dashboard.show(&self.global.db, &selftalk_sim::fingerprint()?, None).await;
        }
        for experiment in experiments {
            let Some(stored) = store.experiment(&experiment.name).await? else { continue };
            for replication in &stored.replications {
                let tested = !store.list_retests(replication.id, Test::Generalisation).await?.is_empty();
                if !tested {
                    overall.begin(tests(experiment) / f64::from(experiment.replications));
                    eprintln!(
                        "{}: tests of {} {}",
                        overall.words(0.0),
                        stored.experiment.name,
                        replication.number
                    );
                }
                let go_on = || self.go_on();
                post_evaluate_replication(&store, &stored, replication, self.args.workers, &go_on).await?;
                generalise_replication(&store, &stored, replication, self.args.workers, &go_on).await?;
            }
        }
        if let Some(dashboard) = &self.dashboard {
            dashboard.clear().await;
        }
        Ok(store.close().await?)
    }

    /// Writes the results of both phases.
    async fn write(&self, first: &[Experiment], second: &[Experiment]) -> Result<(), Failure> {
        let store = select::open(&self.global).await?;
        for first in first {
            let folder = self.args.dir.join(&first.name);
            if folder.exists() {
                continue;
            }
            // The folder is there when it is complete.
            let part = self.args.dir.join(format!("{}.part", first.name));
            let failed = |error| Failure::new(Exit::Unexpected, format!("{}: {error}", part.display()));
            if part.exists() {
                std::fs::remove_dir_all(&part).map_err(failed)?;
            }
            for stored in select::experiments(&store, Some(&first.name)).await? {
                results::write(&store, &stored, &part, FRESH_TRIALS, self.args.workers).await?;
            }
            std::fs::rename(&part, &folder).map_err(failed)?;
        }
        let mut experiments = Vec::with_capacity(second.len());
        for experiment in second {
            experiments.extend(store.experiment(&experiment.name).await?);
        }
        let folder = self.args.dir.join("report");
        gathered(&store, &experiments).await?.write(&folder)?;
        eprintln!("the study is complete: {}", folder.join("report.md").display());
        Ok(())
    }

    /// Refuses to go on once the process was asked to end.
    fn go_on(&self) -> Result<(), Failure> {
        match self.signal.exit_code() {
            Some(code) if code == Exit::Terminated as u8 => Err(Failure::new(Exit::Terminated, "")),
            Some(_) => Err(Failure::new(Exit::Interrupted, "")),
            None => Ok(()),
        }
    }

    /// Says how a study that was interrupted is continued.
    fn explained(&self, failure: Failure) -> Failure {
        if !matches!(failure.exit, Exit::Interrupted | Exit::Terminated) {
            return failure;
        }
        let message = format!(
            "interrupted; all that is complete is kept in {}, the same command goes on",
            self.global.db.display()
        );
        Failure::new(failure.exit, message)
    }
}

/// Control steps that an experiment's evolution takes, about.
fn work(experiment: &Experiment) -> f64 {
    f64::from(experiment.replications) * f64::from(experiment.generations) * generation(experiment)
}

fn generation(experiment: &Experiment) -> f64 {
    let trials = match experiment.task {
        Task::Elementary => 16.0 * ELEMENTARY_STEPS,
        Task::MoveToTarget => 8.0 * INTEGRATED_STEPS,
    };
    f64::from(experiment.evolution.population) * trials
}

/// Control steps that are left of it.
fn remaining(stored: &StoredExperiment) -> f64 {
    let left = stored.replications.iter().filter(|replication| !replication.finished);
    let generations = left.map(|replication| stored.experiment.generations - replication.generations);
    generations.map(f64::from).sum::<f64>() * generation(&stored.experiment)
}

/// Control steps that the tests of its robots take, about. Those of the first phase have none.
fn tests(experiment: &Experiment) -> f64 {
    if experiment.task == Task::Elementary {
        return 0.0;
    }
    let trials = POST_TRIALS * f64::from(experiment.generations) + GRID_TRIALS;
    f64::from(experiment.replications) * trials * INTEGRATED_STEPS
}

#[cfg(test)]
mod command {
    use super::*;
    use crate::cli::args::SECOND;

    #[test]
    fn the_conditions_are_presets_of_the_second_phase() {
        for second in SECOND {
            for condition in CONDITIONS {
                assert_eq!(read(&format!("{second}-{condition}"), &[]).unwrap().task, Task::MoveToTarget);
            }
        }
    }
}
