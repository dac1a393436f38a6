//! The table of signals: trials that were run again, control step by control step.

use std::borrow::Cow;

use selftalk_sim::behaviours::Quantity;
use selftalk_sim::robot::RobotModel;

use super::columns::{Column, Kind, Value};
use super::{ExportError, Sheet};
use crate::replay::{self, Recording, Signal};

/// The columns that say which step of which trial a row is.
const KEYS: [(&str, Kind); 8] = [
    ("experiment", Kind::Text),
    ("replication", Kind::Integer),
    ("generation", Kind::Integer),
    ("individual", Kind::Integer),
    ("trial", Kind::Integer),
    ("behaviour", Kind::Text),
    ("step", Kind::Integer),
    ("time", Kind::Real),
];

pub(super) fn columns() -> Result<Vec<Column>, ExportError> {
    let joints: Vec<String> = RobotModel::icub()?.joints.iter().map(|joint| joint.name.clone()).collect();
    let keys = KEYS.map(|(name, kind)| Column { name: Cow::Borrowed(name), kind, optional: false });
    let signal = |(name, kind): (String, replay::Kind)| Column {
        name: Cow::Owned(name),
        kind: match kind {
            replay::Kind::Text => Kind::Text,
            replay::Kind::Real => Kind::Real,
            replay::Kind::Truth => Kind::Truth,
        },
        optional: true,
    };
    let signals = replay::names(&joints, &quantities()).into_iter().map(signal);
    Ok(keys.into_iter().chain(signals).collect())
}

fn quantities() -> [&'static str; Quantity::ALL.len()] {
    Quantity::ALL.map(Quantity::name)
}

/// Writes a recording into the table of signals. An individual is named by experiment, replication, generation and
/// number.
///
/// # Errors
/// [`ExportError::File`] when that is not possible.
pub fn rows(
    sheet: &mut Sheet,
    (experiment, replication, generation, individual): (&str, u32, u32, u32),
    recording: &Recording,
) -> Result<(), ExportError> {
    for (step, moment) in (0_u32..).zip(&recording.moments) {
        let mut row: Vec<Value<'_>> = vec![
            experiment.into(),
            replication.into(),
            generation.into(),
            individual.into(),
            recording.trial.into(),
            recording.behaviour.into(),
            step.into(),
            moment.time.into(),
        ];
        row.extend(replay::values(moment, &quantities()).into_iter().map(|signal| match signal {
            Signal::None => Value::Null,
            Signal::Text(words) => words.into(),
            Signal::Real(number) => number.into(),
            Signal::Truth(truth) => truth.into(),
        }));
        sheet.push(&row)?;
    }
    Ok(())
}
