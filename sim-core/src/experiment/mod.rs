//! The experiment file: everything a history depends on, with the paper's values as defaults.
//!
//! An experiment is TOML. Every key has a default, unknown keys are refused, and [`Experiment::to_toml`] writes all
//! of them out, so that a stored experiment never depends on a later release's defaults.

mod check;
mod integration;
mod preset;
mod settings;

use serde::{Deserialize, Serialize};
use thiserror::Error;
use toml::{Table, Value};

pub use integration::{Added, Ancestors, Caretaker, MoveToTarget, Speaks, Task};
pub use preset::{PRESETS, Preset};
pub use settings::{Controller, Engine, Evolution, Grasp, Move, Near, Open, Physics, Reach, Scene, Trials};

/// Why an experiment file is refused: the file, the key and what would be right.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{file}: {problem}")]
pub struct ExperimentError {
    /// The file, or the name under which the text was given.
    pub file: String,
    /// What is wrong with it.
    pub problem: Problem,
}

/// What is wrong with an experiment file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Problem {
    /// The text is not TOML.
    #[error("line {line}: {reason}")]
    Syntax {
        /// Line, counted from 1.
        line: usize,
        /// The parser's words.
        reason: String,
    },
    /// A key is unknown or its value has the wrong type.
    #[error("{key}: {reason}")]
    Key {
        /// Dotted path of the key.
        key: String,
        /// What is wrong and what is expected.
        reason: String,
    },
    /// A value is outside its range.
    #[error("{key} = {value}: must be {allowed}")]
    Value {
        /// Dotted path of the key.
        key: String,
        /// The value that was given.
        value: String,
        /// The values that are possible.
        allowed: String,
    },
    /// A `key=value` override cannot be read.
    #[error("override `{text}`: {reason}")]
    Override {
        /// The override as given.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
}

/// An experiment: one experimental condition, run in several replications.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Experiment {
    /// Name under which the history is kept; unique in a database.
    pub name: String,
    /// Seed of all randomness, at most 2^63 - 1 (TOML's largest integer).
    pub seed: u64,
    /// Independent replications (paper: 10).
    pub replications: u32,
    /// Generations a replication runs for (paper, first training phase: 1500).
    pub generations: u32,
    /// The physics engine.
    pub engine: Engine,
    /// What an individual is selected by.
    pub task: Task,
    /// Selection and variation.
    pub evolution: Evolution,
    /// The neural controller.
    pub controller: Controller,
    /// The physics engine's settings.
    pub physics: Physics,
    /// Where object and target are placed.
    pub scene: Scene,
    /// What all trials share.
    pub trials: Trials,
    /// REACH: bring the hand over the object.
    pub reach: Reach,
    /// OPEN: open the fingers and turn the palm down.
    pub open: Open,
    /// GRASP: close the fingers around the object.
    pub grasp: Grasp,
    /// MOVE: carry the object to the target.
    #[serde(rename = "move")]
    pub transport: Move,
    /// MOVE-TO-TARGET: fetch the object and carry it to the target.
    pub move_to_target: MoveToTarget,
    /// Who says which elementary action is due in MOVE-TO-TARGET.
    pub caretaker: Caretaker,
    /// Individuals that generation 0 is made from.
    pub ancestors: Ancestors,
}

impl Default for Experiment {
    fn default() -> Self {
        Self {
            name: "elementary".to_owned(),
            seed: 1,
            replications: 10,
            generations: 1500,
            engine: Engine::default(),
            task: Task::default(),
            evolution: Evolution::default(),
            controller: Controller::default(),
            physics: Physics::default(),
            scene: Scene::default(),
            trials: Trials::default(),
            reach: Reach::default(),
            open: Open::default(),
            grasp: Grasp::default(),
            transport: Move::default(),
            move_to_target: MoveToTarget::default(),
            caretaker: Caretaker::default(),
            ancestors: Ancestors::default(),
        }
    }
}

impl Experiment {
    /// Reads an experiment from TOML text, applies `key=value` overrides (dotted keys, TOML values; a value that is
    /// not TOML is taken as a string) and checks every value.
    ///
    /// # Errors
    /// [`ExperimentError`] names `file`, the key, and what would be right.
    ///
    /// ```
    /// use selftalk_sim::Experiment;
    ///
    /// let experiment = Experiment::from_toml("my.toml", "generations = 5", &["seed=7".to_owned()])?;
    /// assert_eq!((experiment.generations, experiment.seed, experiment.replications), (5, 7, 10));
    ///
    /// let error = Experiment::from_toml("my.toml", "generations = 0", &[]).unwrap_err();
    /// assert_eq!(error.to_string(), "my.toml: generations = 0: must be between 1 and 10000000");
    /// # Ok::<(), selftalk_sim::ExperimentError>(())
    /// ```
    pub fn from_toml(file: &str, text: &str, overrides: &[String]) -> Result<Self, ExperimentError> {
        Self::read(text, overrides).map_err(|problem| ExperimentError { file: file.to_owned(), problem })
    }

    fn read(text: &str, overrides: &[String]) -> Result<Self, Problem> {
        // What is not given is as by default, key by key: a table that is given in part too.
        let mut table: Table = Self::default().to_toml().parse().unwrap_or_default();
        merge(&mut table, text.parse().map_err(|error| syntax(text, &error))?);
        for text in overrides {
            apply_override(&mut table, text)?;
        }
        let experiment: Self = serde_path_to_error::deserialize(Value::Table(table)).map_err(|error| {
            let reason = error.inner().message().to_owned();
            let path = error.path().to_string();
            // At the top level the path is "."; the reason then names the key.
            let key = if path == "." { "top level".to_owned() } else { path };
            Problem::Key { key, reason }
        })?;
        check::check(&experiment)?;
        Ok(experiment)
    }

    /// The same experiment without a caretaker, as robots are tested that have to help themselves (paper, section III.B).
    #[must_use]
    pub fn unaided(&self) -> Self {
        let caretaker = Caretaker { speaks: Speaks::Never, ..self.caretaker.clone() };
        Self { caretaker, ..self.clone() }
    }

    /// The complete experiment as TOML, defaults written out. Equal experiments give equal text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // A struct of numbers, strings and tables always serialises; an empty text would be refused when read back.
        toml::to_string(self).unwrap_or_default()
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> Problem {
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = text.as_bytes()[..start].iter().filter(|byte| **byte == b'\n').count() + 1;
    Problem::Syntax { line, reason: error.message().to_owned() }
}

/// Puts the values of one table in the places of another's.
fn merge(into: &mut Table, from: Table) {
    for (key, value) in from {
        match (into.get_mut(&key), value) {
            (Some(Value::Table(into)), Value::Table(from)) => merge(into, from),
            (_, value) => {
                into.insert(key, value);
            }
        }
    }
}

fn apply_override(table: &mut Table, text: &str) -> Result<(), Problem> {
    let refuse = |reason: &str| Problem::Override { text: text.to_owned(), reason: reason.to_owned() };
    let (path, value) = text.split_once('=').ok_or_else(|| refuse("expected key=value"))?;
    let value = format!("v = {value}")
        .parse::<Table>()
        .ok()
        .and_then(|mut parsed| parsed.remove("v"))
        .unwrap_or_else(|| Value::String(value.trim().to_owned()));
    let mut keys: Vec<&str> = path.split('.').map(str::trim).collect();
    let last = keys.pop().filter(|key| !key.is_empty()).ok_or_else(|| refuse("the key is empty"))?;
    let mut table = table;
    for key in keys {
        let entry = table.entry(key).or_insert_with(|| Value::Table(Table::new()));
        table = entry.as_table_mut().ok_or_else(|| refuse("the key lies below a value"))?;
    }
    table.insert(last.to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str, overrides: &[&str]) -> String {
        let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
        match Experiment::from_toml("x.toml", text, &overrides) {
            Ok(experiment) => panic!("accepted: {experiment:?}"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn an_empty_file_is_the_paper() {
        assert_eq!(Experiment::from_toml("x.toml", "", &[]), Ok(Experiment::default()));
    }

    #[test]
    fn the_written_experiment_reads_back_equal() {
        let experiment = Experiment { seed: 7, ..Experiment::default() };
        let text = experiment.to_toml();
        assert!(text.contains("mutation"), "{text}");
        assert_eq!(Experiment::from_toml("x.toml", &text, &[]), Ok(experiment));
    }

    #[test]
    fn every_engine_reads_back_by_its_name() {
        for engine in Engine::ALL {
            let overrides = [format!("engine={}", engine.name())];
            let experiment = Experiment::from_toml("x.toml", "", &overrides).unwrap();
            assert_eq!(experiment, Experiment { engine, ..Experiment::default() });
            assert_eq!(Experiment::from_toml("x.toml", &experiment.to_toml(), &[]), Ok(experiment));
        }
    }

    #[test]
    fn unknown_keys_are_named() {
        let message = refused("[evolution]\nparent = 3\n", &[]);
        assert!(message.contains("evolution.parent"), "{message}");
        assert!(message.contains("`parents`"), "{message}");
        let message = refused("sede = 3\n", &[]);
        assert!(message.contains("sede") && message.contains("`seed`"), "{message}");
    }

    #[test]
    fn wrong_types_are_named() {
        let message = refused("[evolution]\nparents = \"twenty\"\n", &[]);
        assert!(message.starts_with("x.toml: evolution.parents:"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }

    #[test]
    fn impossible_values_are_named_with_their_range() {
        let message = refused("[evolution]\nparents = 0\n", &[]);
        assert_eq!(
            message,
            "x.toml: evolution.parents = 0: must be between 1 and 100 (evolution.population)"
        );
    }

    #[test]
    fn syntax_errors_name_the_line() {
        let message = refused("seed = 1\nname = \n", &[]);
        assert!(message.starts_with("x.toml: line 2:"), "{message}");
    }

    #[test]
    fn overrides_set_nested_keys() {
        let overrides = ["evolution.mutation=0.0004".to_owned(), "name=mine".to_owned()];
        let experiment = Experiment::from_toml("x.toml", "", &overrides).unwrap();
        assert_eq!(experiment.evolution.mutation, 0.0004);
        assert_eq!(experiment.name, "mine");
    }

    #[test]
    fn keys_left_out_of_a_nested_table_keep_their_defaults() {
        let experiment = Experiment::from_toml("x.toml", "[grasp.near]\nfull = 0.05\n", &[]).unwrap();
        assert_eq!(experiment.grasp.near, Near { full: 0.05, ..Grasp::default().near });
        assert_ne!(experiment.grasp.near.narrow, Near::default().narrow, "GRASP has its own");
    }

    #[test]
    fn broken_overrides_are_refused() {
        assert!(refused("", &["seed"]).contains("expected key=value"));
        assert!(refused("", &["=3"]).contains("empty"));
        assert!(refused("", &["seed.x=3"]).contains("seed"));
    }
}
