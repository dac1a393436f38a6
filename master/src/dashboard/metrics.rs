//! The same in the text format of Prometheus.

use std::fmt::Write;

use super::answer::Refusal;
use super::sources::Sources;
use crate::store::{Store, StoredExperiment, StoredReplication};

/// The type of the format.
pub(super) const TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

/// What can be measured.
pub(super) async fn metrics(sources: &Sources) -> Result<String, Refusal> {
    let experiments = sources.store().experiments().await?;
    let mut page = Page::default();
    page.family("selftalk_build_info", "gauge", "Release, and fingerprint of the simulator.");
    let version = env!("CARGO_PKG_VERSION");
    page.sample("selftalk_build_info", &[("version", version), ("fingerprint", sources.fingerprint())], 1.0);
    histories(&mut page, &experiments);
    if let Some(live) = sources.live() {
        let floor = live.floor.borrow().clone();
        let slots: u32 = floor.workers.iter().map(|worker| worker.slots).sum();
        for (name, kind, help, value) in [
            ("selftalk_workers", "gauge", "Workers that are connected.", floor.workers.len() as f64),
            ("selftalk_slots", "gauge", "Slots of the connected workers.", f64::from(slots)),
            ("selftalk_units_waiting", "gauge", "Units that wait for a worker.", floor.waiting as f64),
            ("selftalk_units_leased", "gauge", "Units that workers hold.", floor.leased as f64),
            (
                "selftalk_units_total",
                "counter",
                "Units evaluated since the master began.",
                floor.units as f64,
            ),
            ("selftalk_trials_total", "counter", "Trials run for them.", floor.trials as f64),
        ] {
            page.family(name, kind, help);
            page.sample(name, &[], value);
        }
    }
    Ok(page.text)
}

/// What to measure of a replication.
type Measure = fn(&StoredExperiment, &StoredReplication) -> Option<f64>;

fn histories(page: &mut Page, experiments: &[StoredExperiment]) {
    let measures: [(&str, &str, &str, Measure); 6] = [
        ("selftalk_generations_total", "counter", "Generations committed.", |_, of| {
            Some(of.generations.into())
        }),
        ("selftalk_generations_planned", "gauge", "Generations after which a replication ends.", |of, _| {
            Some(of.experiment.generations.into())
        }),
        ("selftalk_replication_finished", "gauge", "1 when a replication is finished.", |_, of| {
            Some(f64::from(u8::from(of.finished)))
        }),
        ("selftalk_best_fitness", "gauge", "Fitness of the last generation's best individual.", |_, of| {
            of.last.map(|last| last.best_fitness)
        }),
        ("selftalk_mean_fitness", "gauge", "Mean fitness of the last generation.", |_, of| {
            of.last.map(|last| last.mean_fitness)
        }),
        (
            "selftalk_best_successes",
            "gauge",
            "Successful trials of the last generation's best individual.",
            |_, of| of.last.map(|last| last.best_successes.into()),
        ),
    ];
    for (name, kind, help, measure) in measures {
        page.family(name, kind, help);
        for stored in experiments {
            for replication in &stored.replications {
                let number = replication.number.to_string();
                let labels =
                    [("experiment", stored.experiment.name.as_str()), ("replication", number.as_str())];
                if let Some(value) = measure(stored, replication) {
                    page.sample(name, &labels, value);
                }
            }
        }
    }
}

#[derive(Default)]
struct Page {
    text: String,
}

impl Page {
    fn family(&mut self, name: &str, kind: &str, help: &str) {
        let _ = write!(self.text, "# HELP {name} {help}\n# TYPE {name} {kind}\n");
    }

    fn sample(&mut self, name: &str, labels: &[(&str, &str)], value: f64) {
        self.text.push_str(name);
        for (at, (label, of)) in labels.iter().enumerate() {
            let of = of.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            let _ = write!(self.text, "{}{label}=\"{of}\"", if at == 0 { '{' } else { ',' });
        }
        let _ = writeln!(self.text, "{} {value}", if labels.is_empty() { "" } else { "}" });
    }
}

#[cfg(test)]
mod format {
    use super::*;

    #[test]
    fn a_sample_is_a_line_with_its_labels_escaped() {
        let mut page = Page::default();
        page.family("a_total", "counter", "Of a.");
        page.sample("a_total", &[], 3.0);
        page.sample("a_total", &[("x", "1"), ("y", "a\"b\\c\nd")], 0.25);
        let expected = "# HELP a_total Of a.\n# TYPE a_total counter\na_total 3\n\
                        a_total{x=\"1\",y=\"a\\\"b\\\\c\\nd\"} 0.25\n";
        assert_eq!(page.text, expected);
    }
}
