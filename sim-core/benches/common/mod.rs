//! What the benchmarks share.

mod recording;
mod replay;

pub(crate) use recording::{Recording, champion, experiment, random};
pub(crate) use replay::replay;

/// The middle one of an odd number of values; the upper of the two in the middle of an even number.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
