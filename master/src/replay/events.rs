//! What happens in a trial, moment by moment.

use super::Recording;

/// Something that happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The controller takes over.
    Start,
    /// A label is heard that was not before.
    Heard(&'static str),
    /// A label is said that was not before.
    Said(&'static str),
    /// A sensor feels the object that did not before.
    Touch(&'static str),
    /// The state becomes the goal.
    Goal,
    /// The state is the goal no longer.
    Lost,
    /// The trial is over.
    End,
}

/// Something that happens at a moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// The moment, by its place in the recording.
    pub moment: usize,
    /// What happens.
    pub what: What,
}

/// All that happens in a trial, in order.
#[must_use]
pub fn events(recording: &Recording) -> Vec<Event> {
    let mut events = vec![Event { moment: 0, what: What::Start }];
    let mut add = |moment: usize, what: Option<What>| events.extend(what.map(|what| Event { moment, what }));
    for (moment, pair) in (1..).zip(recording.moments.windows(2)) {
        let [before, now] = pair else { continue };
        let new = |was: Option<&'static str>, is: Option<&'static str>| is.filter(|_| was != is);
        let (was, is) = (before.step.as_ref(), now.step.as_ref());
        add(moment, new(was.and_then(|step| step.heard), is.and_then(|step| step.heard)).map(What::Heard));
        add(moment, new(was.and_then(|step| step.said), is.and_then(|step| step.said)).map(What::Said));
        for (sensor, name) in recording.sensors.iter().enumerate() {
            add(moment, (now.touch[sensor] && !before.touch[sensor]).then_some(What::Touch(name)));
        }
        match (was.is_some_and(|step| step.goal), is.is_some_and(|step| step.goal)) {
            (false, true) => add(moment, Some(What::Goal)),
            (true, false) => add(moment, Some(What::Lost)),
            _ => {}
        }
    }
    add(recording.moments.len().saturating_sub(1), Some(What::End));
    events
}

impl What {
    /// What happens, in words.
    #[must_use]
    pub fn words(self, recording: &Recording) -> String {
        match self {
            Self::Start => "start".to_owned(),
            Self::Heard(label) => format!("hears {label}"),
            Self::Said(label) => format!("says {label}"),
            Self::Touch(sensor) => format!("{sensor} touches"),
            Self::Goal => "goal".to_owned(),
            Self::Lost => "goal lost".to_owned(),
            Self::End if recording.success => "end: goal reached".to_owned(),
            Self::End => "end: goal not reached".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn what_is_new_is_an_event_and_what_stays_is_none() {
        let mut recording = recording(&["grasp.steps=6"], 8);
        for moment in &mut recording.moments {
            moment.touch = [false; 6];
        }
        for moment in 3..=4 {
            recording.moments[moment].touch[1] = true;
            recording.moments[moment].step.as_mut().unwrap().goal = true;
        }
        let found: Vec<(usize, What)> =
            events(&recording).into_iter().map(|event| (event.moment, event.what)).collect();
        let expected = [
            (0, What::Start),
            (1, What::Heard("grasp")),
            (3, What::Touch("thumb")),
            (3, What::Goal),
            (5, What::Lost),
            (6, What::End),
        ];
        assert_eq!(found, expected);
        recording.success = true;
        assert_eq!(What::End.words(&recording), "end: goal reached");
    }
}
