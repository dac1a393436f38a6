//! The files of a report.

use std::error::Error;
use std::fs;
use std::path::Path;

use serde::Serialize;

use super::rows::{self, Quantity};
use super::{ReportError, Study, draw, page};
use crate::picture;

/// A figure by its file's name, with its title.
const FIGURES: [(Quantity, &str, &str); 2] = [
    (Quantity::Post, "figure-4", "Post-evaluation: best robots, 40 trials"),
    (Quantity::Generalisation, "figure-6", "Generalisation: best robots, 196 trials"),
];

/// A value of a boxplot.
#[derive(Serialize)]
struct BoxRow<'a> {
    condition: &'a str,
    replication: u32,
    percent: f64,
}

/// A checksum of a history.
#[derive(Serialize)]
struct DigestRow<'a> {
    experiment: &'a str,
    replication: u32,
    sha256: &'a str,
    fingerprint: &'a str,
}

pub(super) fn write(study: &Study, folder: &Path) -> Result<(), ReportError> {
    fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    for (quantity, name, title) in FIGURES {
        let groups: Vec<(&str, Vec<f64>)> = study
            .conditions
            .iter()
            .map(|condition| (condition.label.as_str(), quantity.of(condition)))
            .collect();
        figure(folder, name, draw::boxplots(title, &groups))?;
        let values: Vec<BoxRow<'_>> = study
            .conditions
            .iter()
            .flat_map(|condition| {
                condition.robots.iter().zip(quantity.of(condition)).map(|(robot, percent)| BoxRow {
                    condition: &condition.label,
                    replication: robot.replication,
                    percent,
                })
            })
            .collect();
        write_rows(&folder.join(format!("{name}.csv")), &values)?;
    }
    let title = "Best individuals in post-evaluation, mean of the replications";
    figure(folder, "curves", draw::curves(title, &study.conditions))?;
    let curves: Vec<_> = study.conditions.iter().flat_map(|condition| &condition.curve).collect();
    write_rows(&folder.join("curves.csv"), &curves)?;
    write_rows(&folder.join("summary.csv"), &rows::summary(study))?;
    write_rows(&folder.join("pairwise.csv"), &rows::pairs(study))?;
    write_rows(&folder.join("even_odd.csv"), &rows::aid(study))?;
    write_rows(&folder.join("robots.csv"), &rows::robots(study))?;
    let digests: Vec<DigestRow<'_>> = study
        .conditions
        .iter()
        .flat_map(|condition| {
            condition.digests.iter().map(|(replication, sha256)| DigestRow {
                experiment: &condition.experiment.name,
                replication: *replication,
                sha256,
                fingerprint: &condition.fingerprint,
            })
        })
        .collect();
    write_rows(&folder.join("digest.csv"), &digests)?;
    for condition in &study.conditions {
        let path = folder.join(format!("{}.toml", condition.experiment.name));
        fs::write(&path, condition.experiment.to_toml()).map_err(|error| failed(&path, &error))?;
    }
    let path = folder.join("report.md");
    fs::write(&path, page::page(study)).map_err(|error| failed(&path, &error))
}

/// Writes a figure as SVG and as PNG.
fn figure(folder: &Path, name: &str, svg: Result<String, Box<dyn Error>>) -> Result<(), ReportError> {
    let path = folder.join(format!("{name}.svg"));
    let svg = svg.map_err(|error| failed(&path, &error))?;
    fs::write(&path, &svg).map_err(|error| failed(&path, &error))?;
    let path = folder.join(format!("{name}.png"));
    let png = picture::png(&svg).map_err(|error| failed(&path, &error))?;
    fs::write(&path, png).map_err(|error| failed(&path, &error))
}

fn write_rows(path: &Path, rows: &[impl Serialize]) -> Result<(), ReportError> {
    let fail = |error: csv::Error| failed(path, &error);
    let mut writer = csv::Writer::from_path(path).map_err(fail)?;
    rows.iter().try_for_each(|row| writer.serialize(row)).map_err(fail)?;
    writer.flush().map_err(|error| failed(path, &error))
}

fn failed(path: &Path, error: &dyn ToString) -> ReportError {
    ReportError::File { path: path.to_owned(), reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::rows::tests::condition;

    #[test]
    fn a_report_has_its_figures_each_with_its_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("report");
        let study = Study { conditions: vec![condition("C", &[10, 12]), condition("LST", &[38, 40])] };
        write(&study, &folder).unwrap();
        for name in ["figure-4", "figure-6", "curves"] {
            for end in ["svg", "png", "csv"] {
                assert!(
                    fs::metadata(folder.join(format!("{name}.{end}"))).unwrap().len() > 50,
                    "{name}.{end}"
                );
            }
        }
        let summary = fs::read_to_string(folder.join("summary.csv")).unwrap();
        let expected = "condition,replication,best_generation,post_successes_of_40,generalisation_successes_of_196\n\
                        C,0,10,10,40\nC,1,11,12,48\nLST,0,10,38,152\nLST,1,11,40,160\n";
        assert_eq!(summary, expected);
        let pairs = fs::read_to_string(folder.join("pairwise.csv")).unwrap();
        assert!(pairs.starts_with("test,a,b,u,p,p_holm,a12\npost,LST,C,4.0,"), "{pairs}");
        // Written again over what is there.
        write(&study, &folder).unwrap();
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_named() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let folder = file.path().join("report");
        let study = Study { conditions: Vec::new() };
        let message = write(&study, &folder).unwrap_err().to_string();
        assert!(message.starts_with(&folder.display().to_string()), "{message}");
    }
}
