//! A recording as CSV: a line a control step, a column a signal.

use std::io;

use super::Recording;

/// Writes all signals of a recording, the start included; what there is not at the start is empty.
///
/// # Errors
/// Those of writing.
pub fn csv(recording: &Recording, to: impl io::Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(to);
    writer.write_record(header(recording))?;
    for moment in &recording.moments {
        let mut row = vec![moment.time.to_string()];
        let numbers = moment.object.iter().chain(&moment.orientation).chain(&moment.angles);
        row.extend(numbers.map(f64::to_string));
        row.extend(moment.touch.iter().map(|touch| u8::from(*touch).to_string()));
        if let Some(step) = &moment.step {
            row.extend([step.heard, step.said].map(|label| label.unwrap_or_default().to_owned()));
            row.push(step.reward.to_string());
            row.extend([step.focused, step.goal].map(|truth| u8::from(truth).to_string()));
            row.extend(step.conditions.iter().map(|(_, value)| value.to_string()));
            let neurons = step.motors.iter().chain(&step.sensors).chain(&step.internal).chain(&step.added);
            row.extend(neurons.map(f64::to_string));
        } else {
            row.resize(header(recording).len(), String::new());
        }
        writer.write_record(row)?;
    }
    writer.flush()
}

fn header(recording: &Recording) -> Vec<String> {
    let names =
        ["time", "object_x", "object_y", "object_z", "object_qw", "object_qx", "object_qy", "object_qz"];
    let mut header: Vec<String> = names.map(str::to_owned).to_vec();
    header.extend(recording.joints.iter().map(|joint| format!("angle_{joint}")));
    header.extend(recording.sensors.map(|sensor| format!("touch_{sensor}")));
    header.extend(["heard", "said", "reward", "focused", "goal"].map(str::to_owned));
    let steps = recording.moments.iter().filter_map(|moment| moment.step.as_ref());
    if let Some(step) = steps.into_iter().next() {
        header.extend(step.conditions.iter().map(|(name, _)| name.replace(' ', "_")));
        header.extend(recording.motors.iter().map(|motor| format!("motor_{motor}")));
        let neurons =
            [("sensor", step.sensors.len()), ("internal", step.internal.len()), ("added", step.added.len())];
        header.extend(
            neurons.iter().flat_map(|(name, count)| (0..*count).map(move |at| format!("{name}_{at}"))),
        );
    }
    header
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
        let elbow: f64 = rows[2][column("angle_l_elbow")].parse().unwrap();
        assert_eq!(elbow, recording.moments[2].angles[5]);
    }
}
