//! A recording as rows: one a control step, a column a signal.

use std::io;

use selftalk_sim::controller::{ADDED, INTERNAL};
use selftalk_sim::physics::TOUCH_SENSOR_NAMES;

use super::neurons::{MOTORS, SENSORS};
use super::{Moment, Recording};

/// What kind of values a signal has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Words.
    Text,
    /// Measured numbers.
    Real,
    /// Whether something is so.
    Truth,
}

/// What a signal is at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Signal<'a> {
    /// There is none.
    None,
    /// Words.
    Text(&'a str),
    /// A measured number.
    Real(f64),
    /// Whether something is so.
    Truth(bool),
}

/// The signals of a robot with these joints whose goals ask for these quantities, in the order of [`values`].
#[must_use]
pub fn names(joints: &[String], quantities: &[&str]) -> Vec<(String, Kind)> {
    let mut names = Vec::new();
    let mut add = |kind: Kind, prefix: &str, of: &mut dyn Iterator<Item = String>| {
        names.extend(of.map(|name| (format!("{prefix}{name}"), kind)));
    };
    let words = |words: &'static [&'static str]| words.iter().map(|word| (*word).to_owned());
    let numbers = |count: usize| (0..count).map(|number| number.to_string());
    let place = ["x", "y", "z", "qw", "qx", "qy", "qz"];
    add(Kind::Real, "object_", &mut place.iter().map(|name| (*name).to_owned()));
    add(Kind::Real, "angle_", &mut joints.iter().cloned());
    add(Kind::Truth, "touch_", &mut words(&TOUCH_SENSOR_NAMES));
    add(Kind::Text, "", &mut words(&["heard", "said"]));
    add(Kind::Real, "", &mut words(&["reward"]));
    add(Kind::Truth, "", &mut words(&["focused", "goal"]));
    add(Kind::Real, "", &mut quantities.iter().map(|name| name.replace(' ', "_")));
    add(Kind::Real, "motor_", &mut words(&MOTORS));
    add(Kind::Real, "sensor_", &mut words(&SENSORS));
    add(Kind::Real, "internal_", &mut numbers(INTERNAL));
    add(Kind::Real, "added_", &mut numbers(ADDED));
    names
}

/// What the signals are at a moment; none for quantities that its goal does not ask for, and for what there is not at the
/// start.
#[must_use]
pub fn values<'a>(moment: &'a Moment, quantities: &[&str]) -> Vec<Signal<'a>> {
    let numbers = moment.object.iter().chain(&moment.orientation).chain(&moment.angles);
    let mut values: Vec<Signal<'_>> = numbers.map(|number| Signal::Real(*number)).collect();
    values.extend(moment.touch.map(Signal::Truth));
    if let Some(step) = &moment.step {
        values.extend([step.heard, step.said].map(|label| label.map_or(Signal::None, Signal::Text)));
        values.push(Signal::Real(step.reward));
        values.extend([step.focused, step.goal].map(Signal::Truth));
        let condition = |name: &&str| {
            let found = step.conditions.iter().find(|(quantity, _)| quantity == name);
            found.map_or(Signal::None, |(_, value)| Signal::Real(*value))
        };
        values.extend(quantities.iter().map(condition));
        let neurons = step.motors.iter().chain(&step.sensors).chain(&step.internal).chain(&step.added);
        values.extend(neurons.map(|activity| Signal::Real(*activity)));
    } else {
        let missing = 5 + quantities.len() + MOTORS.len() + SENSORS.len() + INTERNAL + ADDED;
        values.extend(std::iter::repeat_n(Signal::None, missing));
    }
    values
}

/// Writes all signals of a recording as CSV, the start included.
///
/// # Errors
/// Those of writing.
pub fn csv(recording: &Recording, to: impl io::Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    let steps = recording.moments.iter().find_map(|moment| moment.step.as_ref());
    let quantities: Vec<&str> =
        steps.map_or(&[][..], |step| &step.conditions).iter().map(|(name, _)| *name).collect();
    let names = names(&recording.joints, &quantities);
    writer.write_record(std::iter::once("time").chain(names.iter().map(|(name, _)| name.as_str())))?;
    for moment in &recording.moments {
        let values = values(moment, &quantities);
        let words = values.iter().map(|value| match value {
            Signal::None => String::new(),
            Signal::Text(words) => (*words).to_owned(),
            Signal::Real(number) => number.to_string(),
            Signal::Truth(truth) => u8::from(*truth).to_string(),
        });
        writer.write_record(std::iter::once(moment.time.to_string()).chain(words))?;
    }
    writer.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn every_signal_has_a_column_and_every_step_a_line() {
        let recording = recording(&["grasp.steps=3"], 9);
        let mut text = Vec::new();
        csv(&recording, &mut text).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_slice());
        let header = reader.headers().unwrap().clone();
        assert_eq!(header.len(), 8 + 20 + 6 + 5 + 2 + 13 + 25 + 15 + 4);
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        assert_eq!(rows.len(), recording.moments.len());
        let column = |name: &str| header.iter().position(|other| other == name).unwrap();
        assert_eq!(&rows[0][column("heard")], "");
        assert_eq!(&rows[1][column("heard")], "grasp");
        assert_eq!(&rows[1][column("sensor_label_grasp")], "1");
        let elbow: f64 = rows[2][column("angle_l_elbow")].parse().unwrap();
        assert_eq!(elbow, recording.moments[2].angles[5]);
    }

    #[test]
    fn what_a_goal_does_not_ask_for_is_none() {
        let recording = recording(&["reach.steps=3"], 0);
        let quantities = ["touches", "palm to top"];
        let names = names(&recording.joints, &quantities);
        for moment in &recording.moments {
            let values = values(moment, &quantities);
            assert_eq!(values.len(), names.len());
            let of = |name: &str| values[names.iter().position(|(other, _)| other == name).unwrap()];
            assert_eq!(of("touches"), Signal::None);
            assert_eq!(matches!(of("palm_to_top"), Signal::Real(_)), moment.step.is_some());
        }
    }
}
