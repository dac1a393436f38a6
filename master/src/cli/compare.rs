//! `selftalk compare`: whether one experiment's replications do better than another's.

use std::ops::RangeInclusive;

use super::args::{CompareArgs, Measure};
use super::output::Table;
use super::{Global, select};
use crate::exit::{Exit, Failure};
use crate::statistics::{MannWhitney, holm, mann_whitney, median};
use crate::store::{SqliteStore, StoredExperiment};

/// An experiment's values, one a replication.
struct Group {
    name: String,
    values: Vec<f64>,
}

/// Carries out the command.
///
/// # Errors
/// [`Failure`] with the exit code and the line to print.
pub async fn run(args: CompareArgs, global: &Global) -> Result<(), Failure> {
    let store = select::open(global).await?;
    let experiments = meant(&store, &args.experiments).await?;
    let generations = generations(&experiments, &args)?;
    let mut groups = Vec::with_capacity(experiments.len());
    for stored in &experiments {
        let values = values(&store, stored, args.by, &generations).await?;
        groups.push(Group { name: stored.experiment.name.clone(), values });
    }
    table(&groups, args.by, &generations).print(global.format)
}

/// The experiments that are named, or all of them.
async fn meant(store: &SqliteStore, names: &[String]) -> Result<Vec<StoredExperiment>, Failure> {
    let mut experiments = Vec::new();
    if names.is_empty() {
        experiments = select::experiments(store, None).await?;
    }
    for name in names {
        experiments.extend(select::experiments(store, Some(name)).await?);
    }
    let mut seen: Vec<&str> = experiments.iter().map(|stored| stored.experiment.name.as_str()).collect();
    seen.sort_unstable();
    if let Some(pair) = seen.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Failure::new(Exit::Usage, format!("experiment `{}` is named twice", pair[0])));
    }
    if experiments.len() < 2 {
        let given = if names.is_empty() { "there is" } else { "named is" };
        let there = seen.first().map_or("there is none".to_owned(), |name| format!("{given} only `{name}`"));
        return Err(Failure::new(
            Exit::Usage,
            format!(
                "it takes two experiments to compare; {there}; run another, or the same with `--set name=...`"
            ),
        ));
    }
    Ok(experiments)
}

/// The generations that enter.
fn generations(experiments: &[StoredExperiment], args: &CompareArgs) -> Result<RangeInclusive<u32>, Failure> {
    let replications = experiments.iter().flat_map(|stored| &stored.replications);
    let common = replications.map(|replication| replication.generations).min().unwrap_or_default();
    let last = args.generation.unwrap_or(common.saturating_sub(1));
    if last >= common {
        let words = match common {
            0 => "not all replications have a generation yet".to_owned(),
            _ => format!(
                "not all replications have generation {last}; the last one that all have is {}",
                common - 1
            ),
        };
        return Err(Failure::new(Exit::Usage, words));
    }
    Ok((last + 1).saturating_sub(args.over)..=last)
}

async fn values(
    store: &SqliteStore,
    stored: &StoredExperiment,
    by: Measure,
    generations: &RangeInclusive<u32>,
) -> Result<Vec<f64>, Failure> {
    let mut values = Vec::with_capacity(stored.replications.len());
    for replication in &stored.replications {
        let entries = store.list_generations(replication.id, None).await?;
        let entering = entries.iter().filter(|entry| generations.contains(&entry.generation));
        let (count, sum) = entering.fold((0_u32, 0.0), |(count, sum), entry| {
            let value = match by {
                Measure::Successes => f64::from(entry.best_successes),
                Measure::Fitness => entry.best_fitness,
            };
            (count + 1, sum + value)
        });
        values.push(sum / f64::from(count));
    }
    Ok(values)
}

/// A line a pair of experiments.
fn table(groups: &[Group], by: Measure, generations: &RangeInclusive<u32>) -> Table {
    let mut table = Table::new([
        "by", "first", "last", "a", "b", "n_a", "n_b", "median_a", "median_b", "u", "p", "p_holm", "a12",
    ]);
    let pairs = (1..).zip(groups).flat_map(|(next, a)| groups[next..].iter().map(move |b| (a, b)));
    let tests: Vec<(&Group, &Group, MannWhitney)> =
        pairs.filter_map(|(a, b)| Some((a, b, mann_whitney(&a.values, &b.values)?))).collect();
    let corrected = holm(&tests.iter().map(|(_, _, test)| test.p).collect::<Vec<_>>());
    for ((a, b, test), p_holm) in tests.iter().zip(corrected) {
        table.push(vec![
            by.name().into(),
            (*generations.start()).into(),
            (*generations.end()).into(),
            a.name.as_str().into(),
            b.name.as_str().into(),
            (a.values.len() as u64).into(),
            (b.values.len() as u64).into(),
            median(&a.values).into(),
            median(&b.values).into(),
            test.u.into(),
            test.p.into(),
            p_holm.into(),
            test.a12.into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_has_a_line() {
        let group = |name: &str, values: &[f64]| Group { name: name.to_owned(), values: values.to_vec() };
        let groups =
            [group("a", &[1.0, 2.0, 3.0]), group("b", &[4.0, 5.0, 6.0]), group("c", &[4.0, 5.0, 6.0])];
        let mut lines = Vec::new();
        table(&groups, Measure::Fitness, &(3..=7)).write(crate::cli::Format::Csv, &mut lines).unwrap();
        let lines = String::from_utf8(lines).unwrap();
        let expected = [
            "by,first,last,a,b,n_a,n_b,median_a,median_b,u,p,p_holm,a12",
            "fitness,3,7,a,b,3,3,2,5,0,0.1,0.30000000000000004,0",
            "fitness,3,7,a,c,3,3,2,5,0,0.1,0.30000000000000004,0",
            "fitness,3,7,b,c,3,3,5,5,4.5,1,1,0.5",
        ];
        assert_eq!(lines.lines().collect::<Vec<_>>(), expected);
    }
}
