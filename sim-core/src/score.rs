//! What a trial is worth.

use crate::behaviours::{Behaviour, View};
use crate::caretaker::Anticipation;
use crate::controller::Motors;
use crate::experiment::Experiment;

/// A control step as it was judged.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Judged {
    /// The graded reward, in [0, 1].
    pub(crate) reward: f64,
    /// Whether the state is the goal.
    pub(crate) goal: bool,
    /// Whether attention is on what it should be on.
    pub(crate) focused: bool,
}

/// What the control steps of a trial add up to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Score {
    rewards: f64,
    /// Whether the object has been held above the table.
    lifted: bool,
    pub(crate) anticipation: Anticipation,
}

impl Score {
    /// Adds a control step that has led to a state.
    pub(crate) fn add(
        &mut self,
        experiment: &Experiment,
        behaviour: Behaviour,
        view: &View<'_>,
        motors: &Motors,
    ) -> Judged {
        let about_target = behaviour.is_about_target(self.lifted);
        let focused = motors.attends_target() == about_target;
        let judgement = behaviour.judge(experiment, view);
        let factor = if behaviour == Behaviour::MoveToTarget {
            f64::from(u8::from(focused))
        } else {
            let right = if about_target { motors.focus() } else { 1.0 - motors.focus() };
            let wrong = experiment.trials.wrong_focus;
            wrong + (1.0 - wrong) * (2.0 * right).min(1.0)
        };
        let reward = judgement.reward * factor;
        self.rewards += reward;
        self.lifted |= view.is_lifted(&experiment.transport);
        Judged { reward, goal: judgement.goal, focused }
    }

    /// The trial's score, in [0, 1], after so many control steps. What is left of a trial that has ended at its goal
    /// counts as fully rewarded.
    pub(crate) fn total(
        &self,
        experiment: &Experiment,
        behaviour: Behaviour,
        caretaker: bool,
        steps: u32,
        success: bool,
    ) -> f64 {
        let length = behaviour.steps(experiment);
        let rest = if success { f64::from(length - steps) } else { 0.0 };
        let graded = (self.rewards + rest) / f64::from(length);
        let reached = f64::from(u8::from(success));
        if behaviour != Behaviour::MoveToTarget {
            let share = experiment.trials.goal_share;
            return (1.0 - share) * graded + share * reached;
        }
        let settings = &experiment.move_to_target;
        let lifted = f64::from(u8::from(self.lifted));
        let attention = 1.0 - settings.goal_share - settings.lift_share;
        let score = settings.goal_share * reached + settings.lift_share * lifted + attention * graded;
        if !caretaker {
            return score;
        }
        let share = experiment.caretaker.anticipation_share;
        (1.0 - share) * score + share * self.anticipation.worth()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::controller::MOTORS;
    use crate::physics::Observation;
    use crate::robot::RobotModel;
    use crate::scene;

    const TARGET: [f64; 3] = [-0.25, 0.1, 0.23];

    /// The score of MOVE-TO-TARGET in which object, touching sensors and focus are as given in each step.
    fn score(
        experiment: &Experiment,
        caretaker: bool,
        steps: &[([f64; 3], bool, f64)],
        success: bool,
    ) -> f64 {
        let robot = RobotModel::icub().unwrap();
        let mut score = Score::default();
        for (object, touching, focus) in steps {
            let observation = Observation {
                angles: robot.joints.each_ref().map(|joint| joint.angle(0.5)),
                palm: [0.0; 3],
                palm_normal: [0.0, 0.0, -1.0],
                thumb_tip: [0.0; 3],
                little_tip: [0.0; 3],
                object: *object,
                orientation: [1.0, 0.0, 0.0, 0.0],
                touch: [*touching; 6],
            };
            let view = View { robot: &robot, observation: &observation, target: TARGET };
            score.add(experiment, Behaviour::MoveToTarget, &view, &Motors([*focus; MOTORS]));
        }
        score.total(experiment, Behaviour::MoveToTarget, caretaker, steps.len() as u32, success)
    }

    fn experiment() -> Experiment {
        let overrides = ["move_to_target.steps=10", "caretaker.anticipation_share=0.5"].map(str::to_owned);
        Experiment::from_toml("x", "", &overrides).unwrap()
    }

    const ON_TABLE: [f64; 3] = [-0.3, -0.1, scene::OBJECT_STANDING];
    const IN_AIR: [f64; 3] = [-0.3, -0.1, scene::OBJECT_STANDING + 0.05];

    #[test]
    fn move_to_target_rewards_goal_lift_and_attention() {
        let e = experiment();
        let idle = [(ON_TABLE, false, 1.0); 10];
        assert_eq!(score(&e, false, &idle, false), 0.0);
        let looking = [(ON_TABLE, false, 0.0); 10];
        assert!((score(&e, false, &looking, false) - 0.15).abs() < 1e-12);
        let thrown = [(IN_AIR, false, 1.0); 10];
        assert_eq!(score(&e, false, &thrown, false), 0.0, "nothing holds it");
        let lifted = [(IN_AIR, true, 1.0); 10];
        // The first step counts as before the lift, in which attention belongs on the object.
        assert!((score(&e, false, &lifted, false) - (0.25 + 0.15 * 0.9)).abs() < 1e-12);
        let mut carried = vec![(ON_TABLE, true, 0.2), (IN_AIR, true, 0.3)];
        carried.extend([(TARGET, true, 0.9); 3]);
        assert!((score(&e, false, &carried, true) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn anticipation_counts_only_where_the_caretaker_speaks() {
        let e = experiment();
        let lifted = [(IN_AIR, true, 1.0); 10];
        let alone = score(&e, false, &lifted, false);
        assert!((score(&e, true, &lifted, false) - 0.5 * alone).abs() < 1e-12, "nothing was anticipated");
    }
}
