//! A study of the second phase that is kept as a folder, as `selftalk report` writes it: its best robots are put to their
//! tests again.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use selftalk_sim::{Experiment, Genotype, Simulator};
use serde::Deserialize;

use super::ResultsError;
use super::files::read_rows;
use crate::retest::{Crew, battery};
use crate::store::Test;

const ROBOTS: &str = "robots.csv";

/// What is kept of a study.
#[derive(Debug)]
pub struct KeptStudy {
    /// The conditions' experiments by their names.
    experiments: BTreeMap<String, Experiment>,
    robots: Vec<RobotRow>,
    summary: Vec<SummaryRow>,
    aid: Vec<AidRow>,
    digests: Vec<DigestRow>,
}

#[derive(Debug, Deserialize)]
struct RobotRow {
    condition: String,
    experiment: String,
    replication: u32,
    generation: u32,
    individual: u32,
    genes: String,
}

#[derive(Debug, Deserialize)]
struct SummaryRow {
    condition: String,
    replication: u32,
    best_generation: u32,
    post_successes_of_40: u32,
    generalisation_successes_of_196: u32,
}

#[derive(Debug, Deserialize)]
struct AidRow {
    condition: String,
    replication: u32,
    own_successes: u32,
    aided_successes: u32,
}

#[derive(Debug, Deserialize)]
struct DigestRow {
    experiment: String,
    replication: u32,
    fingerprint: String,
}

/// How many robots of an experiment were tested again, in how many trials, and what is not as it is kept.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Examined {
    /// The experiment.
    pub experiment: String,
    /// Robots.
    pub robots: u64,
    /// Trials.
    pub trials: u64,
    /// What came out otherwise, in words.
    pub mismatches: Vec<String>,
}

impl KeptStudy {
    /// Whether a folder has a study, and not the results of one experiment.
    #[must_use]
    pub fn is_in(folder: &Path) -> bool {
        folder.join(ROBOTS).exists()
    }

    /// Reads a study.
    ///
    /// # Errors
    /// [`ResultsError`] names the file that is missing or wrong.
    pub fn read(folder: &Path) -> Result<Self, ResultsError> {
        let robots: Vec<RobotRow> = read_rows(&folder.join(ROBOTS))?;
        let mut experiments = BTreeMap::new();
        for RobotRow { experiment: name, .. } in &robots {
            if !experiments.contains_key(name) {
                let path = folder.join(format!("{name}.toml"));
                let failed = |error: std::io::Error| ResultsError::File {
                    path: path.clone(),
                    reason: error.to_string(),
                };
                let text = std::fs::read_to_string(&path).map_err(failed)?;
                let read = Experiment::from_toml(&path.display().to_string(), &text, &[])?;
                experiments.insert(name.clone(), read);
            }
        }
        Ok(Self {
            experiments,
            robots,
            summary: read_rows(&folder.join("summary.csv"))?,
            aid: read_rows(&folder.join("even_odd.csv"))?,
            digests: read_rows(&folder.join("digest.csv"))?,
        })
    }

    /// The experiments, each with the fingerprints of the simulators that its replications were run with.
    pub fn fingerprints(&self) -> impl Iterator<Item = (&str, &str)> {
        self.digests.iter().map(|row| (row.experiment.as_str(), row.fingerprint.as_str()))
    }

    /// Trials of the tests.
    #[must_use]
    pub fn trials(&self) -> u64 {
        (self.robots.len() as u64) * (40 + 196) + (self.aid.len() as u64) * 196
    }

    /// Tests the robots again, experiment by experiment.
    ///
    /// # Errors
    /// [`ResultsError`] when a robot cannot be run.
    pub fn check(&self, crew: Crew<'_>) -> Result<Vec<Examined>, ResultsError> {
        self.experiments.iter().map(|(name, experiment)| self.examine(name, experiment, crew)).collect()
    }

    fn examine(&self, name: &str, experiment: &Experiment, crew: Crew<'_>) -> Result<Examined, ResultsError> {
        let genes = Simulator::new(experiment)?.gene_count();
        let mut examined = Examined { experiment: name.to_owned(), ..Examined::default() };
        for robot in self.robots.iter().filter(|robot| robot.experiment == name) {
            examined.robots += 1;
            let known =
                Genotype::from_hex(&robot.genes).ok().filter(|genotype| genotype.genes().len() == genes);
            let found = match known {
                Some(genotype) => {
                    self.test(robot, experiment, Arc::new(genotype), crew, &mut examined.trials)?
                }
                None => vec!["the genes are not a genotype".to_owned()],
            };
            let RobotRow { replication, generation, individual, .. } = robot;
            let named = |what| format!("{name}/{replication}/{generation}/{individual}: {what}");
            examined.mismatches.extend(found.into_iter().map(named));
        }
        let digests = self.digests.iter().filter(|row| row.experiment == name).map(|row| row.replication);
        let robots = self.robots.iter().filter(|row| row.experiment == name).map(|row| row.replication);
        if !digests.eq(robots) {
            examined.mismatches.push(format!("{name}: digest.csv has not the replications of robots.csv"));
        }
        Ok(examined)
    }

    /// Puts a robot to all tests of which something is kept.
    fn test(
        &self,
        robot: &RobotRow,
        experiment: &Experiment,
        genotype: Arc<Genotype>,
        crew: Crew<'_>,
        trials: &mut u64,
    ) -> Result<Vec<String>, ResultsError> {
        let same =
            |condition: &str, replication| condition == robot.condition && replication == robot.replication;
        let summary = self.summary.iter().find(|row| same(&row.condition, row.replication));
        let Some(summary) = summary.filter(|row| row.best_generation == robot.generation) else {
            return Ok(vec!["summary.csv does not have it".to_owned()]);
        };
        let aid = self.aid.iter().find(|row| same(&row.condition, row.replication));
        let kept = [
            (Test::Post, "of post-evaluation", Some(summary.post_successes_of_40)),
            (Test::Generalisation, "of generalisation", Some(summary.generalisation_successes_of_196)),
            (Test::Aided, "with the caretaker", aid.map(|row| row.aided_successes)),
        ];
        let mut found = Vec::new();
        for (test, words, stored) in kept {
            let Some(stored) = stored else { continue };
            let outcomes = battery(experiment, test, std::slice::from_ref(&genotype), crew)?.concat();
            *trials += outcomes.len() as u64;
            let again = outcomes.iter().filter(|outcome| outcome.success).count();
            if again != stored as usize {
                found.push(format!("{stored} successes {words} are stored, {again} come out"));
            }
        }
        if aid.is_some_and(|row| row.own_successes != summary.generalisation_successes_of_196) {
            found.push("summary.csv and even_odd.csv differ".to_owned());
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    const OVERRIDES: [&str; 4] =
        ["task=move-to-target", "controller.added=speech", "caretaker.speaks=even", "engine=null"];

    /// A folder with one robot, of which so many successes are kept.
    fn kept(change: impl Fn(u32) -> u32) -> tempfile::TempDir {
        let experiment =
            Experiment::from_toml("x", "name = \"talks\"", &OVERRIDES.map(str::to_owned)).unwrap();
        let simulator = Simulator::new(&experiment).unwrap();
        let genotype = Arc::new(Genotype::new(vec![0x0ff0; simulator.gene_count()]));
        let done = || {};
        let crew = Crew { threads: 1, done: &done };
        let count = |test| {
            let outcomes =
                battery(&experiment, test, std::slice::from_ref(&genotype), crew).unwrap().concat();
            outcomes.iter().filter(|outcome| outcome.success).count() as u32
        };
        let [post, alone, aided] = [Test::Post, Test::Generalisation, Test::Aided].map(count);
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
        write("talks.toml", experiment.to_toml());
        write(
            ROBOTS,
            format!(
                "condition,experiment,replication,generation,individual,genes\nLST,talks,0,7,3,{}\n",
                genotype.to_hex()
            ),
        );
        write(
            "summary.csv",
            format!(
                "condition,replication,best_generation,post_successes_of_40,generalisation_successes_of_196\n\
                 LST,0,7,{},{alone}\n",
                change(post)
            ),
        );
        write(
            "even_odd.csv",
            format!(
                "condition,replication,trials,own_successes,aided_successes\nLST,0,196,{alone},{aided}\n"
            ),
        );
        write("digest.csv", "experiment,replication,sha256,fingerprint\ntalks,0,00,11\n".to_owned());
        folder
    }

    #[test]
    fn robots_of_a_kept_study_come_to_the_same_or_are_named() {
        let done = || {};
        let crew = Crew { threads: 1, done: &done };
        let folder = kept(|post| post);
        assert!(KeptStudy::is_in(folder.path()));
        let study = KeptStudy::read(folder.path()).unwrap();
        let trials = 40 + 2 * 196;
        let expected = Examined { experiment: "talks".to_owned(), robots: 1, trials, mismatches: Vec::new() };
        assert_eq!(study.check(crew).unwrap(), [expected]);
        assert_eq!(study.trials(), trials);

        let folder = kept(|post| post + 1);
        let found = KeptStudy::read(folder.path()).unwrap().check(crew).unwrap().remove(0).mismatches;
        assert!(found.len() == 1 && found[0].starts_with("talks/0/7/3: "), "{found:?}");
        fs::remove_file(folder.path().join("talks.toml")).unwrap();
        let error = KeptStudy::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("talks.toml"), "{error}");
    }
}
