//! The caretaker, who says which elementary action is due in MOVE-TO-TARGET (paper, section III.C), and how well a robot
//! that talks to itself says so before it does (paper, section III.D).

use crate::behaviours::{Behaviour, Quantity, View};
use crate::experiment::{self, Experiment};

/// The caretaker in a trial: REACH first, then each next label from the control step on after the one at whose end its
/// action has come to what was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Caretaker {
    label: Behaviour,
}

impl Default for Caretaker {
    fn default() -> Self {
        Self { label: Behaviour::Reach }
    }
}

impl Caretaker {
    /// The label for the coming control step.
    #[must_use]
    pub const fn label(&self) -> Behaviour {
        self.label
    }

    /// Sees the state at the end of a control step, and comes to the next label if this one's action is done: REACH and
    /// OPEN when their goals are reached, GRASP when as many sensors touch as its goal asks for. MOVE is the last.
    pub fn watch(&mut self, experiment: &Experiment, view: &View<'_>) {
        let counts = |quantity| self.label != Behaviour::Grasp || quantity == Quantity::Touches;
        let conditions = self.label.conditions(experiment, view);
        let done = conditions.iter().filter(|condition| counts(condition.quantity)).all(|part| part.holds());
        if done {
            self.label = match self.label {
                Behaviour::Reach => Behaviour::Open,
                Behaviour::Open => Behaviour::Grasp,
                _ => Behaviour::Move,
            };
        }
    }
}

/// How often a caretaker comes to a new label.
const CHANGES: f64 = (Behaviour::ELEMENTARY.len() - 1) as f64;

/// What a robot's own labels are worth as a forecast of the caretaker's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Anticipation {
    /// The robot's label, and for how many control steps it has been saying it.
    own: Option<(Behaviour, u32)>,
    heard: Option<Behaviour>,
    worth: f64,
}

impl Anticipation {
    /// Notes both labels of a control step. When the caretaker comes to a new one that the robot has been saying for
    /// some steps before, these steps are what it was earlier by.
    pub fn note(&mut self, settings: &experiment::Caretaker, own: Option<Behaviour>, heard: Behaviour) {
        let before = match (self.own, own) {
            (Some((before, steps)), Some(now)) if before == now => steps,
            _ => 0,
        };
        if self.heard.is_some_and(|last| last != heard) && own == Some(heard) {
            self.worth += match before {
                0 => 0.0,
                steps if steps <= settings.soon => 1.0,
                steps if steps <= settings.early => settings.early_reward,
                _ => 0.0,
            };
        }
        self.own = own.map(|own| (own, before + 1));
        self.heard = Some(heard);
    }

    /// What the labels have come to: 1 if all of the caretaker's were said soon before it.
    #[must_use]
    pub fn worth(&self) -> f64 {
        self.worth / CHANGES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Observation;
    use crate::robot::{RobotModel, joint};
    use crate::scene;

    /// A hand at some height over the object's top, with stretched or bent fingers.
    fn observation(height: f64, flexion: f64, touches: usize) -> Observation {
        let robot = RobotModel::icub().unwrap();
        let mut angles = robot.joints.each_ref().map(|joint| joint.angle(0.5));
        for joint in joint::FINGER_FLEXION.chain(joint::THUMB_FLEXION) {
            angles[joint] = robot.joints[joint].angle(flexion);
        }
        Observation {
            angles,
            palm: [-0.3, -0.1, scene::OBJECT_STANDING + scene::OBJECT_RADIUS + height],
            palm_normal: [0.0, 0.0, -1.0],
            thumb_tip: [0.0; 3],
            little_tip: [0.0; 3],
            object: [-0.3, -0.1, scene::OBJECT_STANDING],
            orientation: [1.0, 0.0, 0.0, 0.0],
            touch: std::array::from_fn(|sensor| sensor < touches),
        }
    }

    #[test]
    fn labels_follow_each_other_as_the_actions_are_done() {
        let (experiment, robot) = (Experiment::default(), RobotModel::icub().unwrap());
        let mut caretaker = Caretaker::default();
        let mut after = |observation: Observation| {
            caretaker
                .watch(&experiment, &View { robot: &robot, observation: &observation, target: [0.0; 3] });
            caretaker.label()
        };
        assert_eq!(after(observation(0.07, 0.0, 6)), Behaviour::Reach, "7 cm are too far");
        assert_eq!(after(observation(0.05, 0.9, 0)), Behaviour::Open);
        assert_eq!(after(observation(0.05, 0.9, 6)), Behaviour::Open, "the fingers are closed");
        assert_eq!(after(observation(0.07, 0.0, 6)), Behaviour::Open, "the hand has left");
        assert_eq!(after(observation(0.05, 0.0, 6)), Behaviour::Grasp, "one label at a time");
        assert_eq!(after(observation(0.05, 0.0, 2)), Behaviour::Grasp);
        assert_eq!(after(observation(0.50, 0.0, 3)), Behaviour::Move, "three sensors are enough");
        assert_eq!(after(observation(0.05, 0.0, 3)), Behaviour::Move);
    }

    /// What own labels are worth when the caretaker says REACH for 30 steps and then OPEN.
    fn worth(own: impl Fn(u32) -> Option<Behaviour>) -> f64 {
        let mut anticipation = Anticipation::default();
        for step in 0..40 {
            let heard = if step < 30 { Behaviour::Reach } else { Behaviour::Open };
            anticipation.note(&experiment::Caretaker::default(), own(step), heard);
        }
        3.0 * anticipation.worth()
    }

    #[test]
    fn a_label_is_worth_most_when_it_is_said_soon_before_the_caretaker_does() {
        let from = |first| move |step| Some(if step < first { Behaviour::Reach } else { Behaviour::Open });
        for (earlier_by, expected) in
            [(0, 0.0), (1, 1.0), (5, 1.0), (6, 0.3), (20, 0.3), (21, 0.0), (30, 0.0)]
        {
            assert!((worth(from(30 - earlier_by)) - expected).abs() < 1e-12, "earlier by {earlier_by}");
        }
        assert_eq!(worth(from(33)), 0.0, "later");
        assert_eq!(worth(|_| None), 0.0);
        assert_eq!(worth(|_| Some(Behaviour::Grasp)), 0.0);
    }

    #[test]
    fn only_what_is_still_said_counts() {
        let taken_back = |step| Some(if step == 27 { Behaviour::Open } else { Behaviour::Reach });
        assert_eq!(worth(taken_back), 0.0);
        let again = |step| Some(if step == 10 || step >= 27 { Behaviour::Open } else { Behaviour::Reach });
        assert!((worth(again) - 1.0).abs() < 1e-12);
    }
}
