//! The files of a folder of results.

use std::fs;
use std::io;
use std::path::Path;

use selftalk_sim::Experiment;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Results, ResultsError, figure};

const EXPERIMENT: &str = "experiment.toml";
const GENERATIONS: &str = "generations.csv";
const SUMMARY: &str = "summary.csv";
const BEST: &str = "best.csv";
const TRIALS: &str = "trials.csv";
const DIGESTS: &str = "digest.csv";
const WORKERS: &str = "workers.csv";
const FIGURE: &str = "figure.svg";

/// Makes sure that a folder can be written to: it is created, or there and empty.
pub(super) fn prepare(folder: &Path) -> Result<(), ResultsError> {
    fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    let mut entries = fs::read_dir(folder).map_err(|error| failed(folder, &error))?;
    if entries.next().is_some() { Err(ResultsError::Occupied(folder.to_owned())) } else { Ok(()) }
}

pub(super) fn write(results: &Results, folder: &Path) -> Result<(), ResultsError> {
    prepare(folder)?;
    let path = folder.join(EXPERIMENT);
    fs::write(&path, results.experiment.to_toml()).map_err(|error| failed(&path, &error))?;
    write_rows(&folder.join(GENERATIONS), &results.generations)?;
    write_rows(&folder.join(SUMMARY), &results.summary)?;
    write_rows(&folder.join(BEST), &results.best)?;
    write_rows(&folder.join(TRIALS), &results.trials)?;
    write_rows(&folder.join(DIGESTS), &results.digests)?;
    write_rows(&folder.join(WORKERS), &results.workers)?;
    let path = folder.join(FIGURE);
    figure::draw(results, &path).map_err(|error| ResultsError::File { path, reason: error.to_string() })
}

pub(super) fn read(folder: &Path) -> Result<Results, ResultsError> {
    let path = folder.join(EXPERIMENT);
    let text = fs::read_to_string(&path).map_err(|error| failed(&path, &error))?;
    Ok(Results {
        experiment: Experiment::from_toml(&path.display().to_string(), &text, &[])?,
        generations: read_rows(&folder.join(GENERATIONS))?,
        summary: read_rows(&folder.join(SUMMARY))?,
        best: read_rows(&folder.join(BEST))?,
        trials: read_rows(&folder.join(TRIALS))?,
        digests: read_rows(&folder.join(DIGESTS))?,
        workers: read_rows(&folder.join(WORKERS))?,
    })
}

fn write_rows(path: &Path, rows: &[impl Serialize]) -> Result<(), ResultsError> {
    let fail = |reason: String| ResultsError::File { path: path.to_owned(), reason };
    let mut writer = csv::Writer::from_path(path).map_err(|error| fail(error.to_string()))?;
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(|error| fail(error.to_string()))?;
    writer.flush().map_err(|error| failed(path, &error))
}

pub(super) fn read_rows<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>, ResultsError> {
    let text = fs::read(path).map_err(|error| failed(path, &error))?;
    let rows: Result<Vec<T>, csv::Error> = csv::Reader::from_reader(text.as_slice()).deserialize().collect();
    rows.map_err(|error| ResultsError::Content { path: path.to_owned(), reason: error.to_string() })
}

fn failed(path: &Path, error: &io::Error) -> ResultsError {
    if error.kind() == io::ErrorKind::NotFound {
        return ResultsError::Missing(path.to_owned());
    }
    ResultsError::File { path: path.to_owned(), reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::super::{BestRow, DigestRow, GenerationRow, SummaryRow, TrialRow, WorkerRow};
    use super::*;

    fn results() -> Results {
        let score: f64 = 1.0 / 3.0;
        Results {
            experiment: Experiment { name: "a".to_owned(), ..Experiment::default() },
            generations: vec![GenerationRow {
                replication: 0,
                generation: 0,
                best_fitness: score,
                mean_fitness: 1e-7,
                best_successes: 10,
                reach: 4,
                open: 3,
                grasp: 2,
                transport: 1,
            }],
            summary: [None, Some(12)]
                .into_iter()
                .map(|first_optimal_generation| SummaryRow {
                    replication: 0,
                    generations: 1,
                    first_optimal_generation,
                    best_successes_of_16: 10,
                    fresh_reach: 1.0,
                    fresh_open: 0.0,
                    fresh_grasp: 0.25,
                    fresh_move: 0.98,
                })
                .collect(),
            best: vec![BestRow {
                replication: 0,
                generation: 0,
                individual: 3,
                fitness: score,
                successes: 10,
                validation_trials: 160,
                validation_successes: 90,
                fresh_trials: 400,
                genes: "00ff1234".to_owned(),
            }],
            trials: vec![TrialRow {
                replication: 0,
                trial: 0,
                behaviour: "reach".to_owned(),
                score,
                score_bits: format!("{:016x}", score.to_bits()),
                success: true,
                steps: 9,
            }],
            digests: vec![DigestRow {
                experiment: "a".to_owned(),
                replication: 0,
                generations: 1,
                sha256: "00".to_owned(),
                fingerprint: "11".to_owned(),
            }],
            workers: [None, Some("2026-01-01T00:01:00Z".to_owned())]
                .into_iter()
                .map(|left_at| WorkerRow {
                    slots: 2,
                    version: "0.1.0".to_owned(),
                    joined_at: "2026-01-01T00:00:00Z".to_owned(),
                    left_at,
                })
                .collect(),
        }
    }

    #[test]
    fn what_is_written_reads_back_equal() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("docs/results/a");
        let results = results();
        results.write(&folder).unwrap();
        assert_eq!(Results::read(&folder).unwrap(), results);
        let summary = fs::read_to_string(folder.join(SUMMARY)).unwrap();
        let mut lines = summary.lines();
        let header = "replication,generations,first_optimal_generation,best_successes_of_16,fresh_reach,fresh_open,\
                      fresh_grasp,fresh_move";
        assert_eq!(lines.next(), Some(header));
        assert_eq!(lines.next(), Some("0,1,,10,1.0,0.0,0.25,0.98"));
        let figure = fs::read_to_string(folder.join(FIGURE)).unwrap();
        assert!(figure.contains("replication 0") && figure.trim_end().ends_with("</svg>"), "{figure}");
        assert_eq!(results.trials[0].outcome().unwrap().score, 1.0 / 3.0);
    }

    #[test]
    fn a_folder_with_something_in_it_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("notes.txt"), "mine").unwrap();
        assert!(matches!(results().write(folder.path()), Err(ResultsError::Occupied(_))));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_is_missing_or_broken_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("a");
        assert!(Results::read(&folder).unwrap_err().to_string().contains("experiment.toml: no such file"));
        results().write(&folder).unwrap();
        fs::write(folder.join(TRIALS), "replication,trial\n0,x\n").unwrap();
        let error = Results::read(&folder).unwrap_err();
        assert!(matches!(error, ResultsError::Content { .. }) && error.to_string().contains("trials.csv: "));
    }
}
