//! A trial: what a controller senses, does and is given for it, control step by control step.

use rand::RngExt;

use crate::behaviours::{Behaviour, Condition, Judgement, Starts, View};
use crate::body;
use crate::controller::{INTERNAL, Motors, Network, SENSORS};
use crate::experiment::Experiment;
use crate::physics::{Engine, Observation};
use crate::robot::RobotModel;
use crate::scene;
use crate::stream::{Purpose, StreamKey};

/// Control steps for which the initial posture is held before the controller takes over, so that a hand around the
/// object has it firmly in its grip.
pub const SETTLING: u32 = 2;

/// Trials of an evaluation: four for each behaviour (paper, section II.C).
pub(crate) const TRIALS: u32 = 16;

/// Selects the random positions of object and target: all genotypes that are evaluated with the same draw face the
/// same ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Draw {
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation in which the positions were drawn, counted from 0.
    pub generation: u32,
}

/// Fresh draws of a kind, and where the kinds begin: beyond any generation that an experiment can run for.
const FRESH: u32 = 1 << 30;
const VALIDATION: u32 = FRESH;
const TEST: u32 = 2 * FRESH;

impl Draw {
    /// A draw that no evolution uses, for choosing between individuals. `number` counts from 0 to 2^30 - 1.
    #[must_use]
    pub const fn validation(number: u32) -> Self {
        Self { replication: 0, generation: VALIDATION + number % FRESH }
    }

    /// A draw that neither an evolution nor a choice between individuals uses, for reporting how good they are.
    /// `number` counts from 0 to 2^30 - 1.
    #[must_use]
    pub const fn test(number: u32) -> Self {
        Self { replication: 0, generation: TEST + number % FRESH }
    }
}

/// What a trial came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOutcome {
    /// Score in [0, 1]; 0 where the simulation left the finite numbers.
    pub score: f64,
    /// Whether the goal was reached and held.
    pub success: bool,
    /// Control steps (50 ms each) the trial lasted.
    pub steps: u32,
}

/// A control step of a trial as it was seen, done and judged.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Activity of the sensory neurons.
    pub sensors: [f64; SENSORS],
    /// Activity of the internal neurons.
    pub internal: [f64; INTERNAL],
    /// Activity of the motor neurons.
    pub motors: Motors,
    /// Robot and object at the end of the step.
    pub observation: Observation,
    /// The graded reward of the step, in [0, 1].
    pub reward: f64,
    /// Whether the state was the goal.
    pub goal: bool,
    /// What the goal asks for, as it was at the end of the step.
    pub conditions: Vec<Condition>,
}

/// What all trials of an experiment share.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) experiment: Experiment,
    pub(crate) robot: RobotModel,
    pub(crate) starts: Starts,
}

/// A trial under way, in one lane of an engine.
pub(crate) struct Trial<'a> {
    setup: &'a Setup,
    network: Network,
    behaviour: Behaviour,
    target: [f64; 3],
    observation: Observation,
    internal: [f64; INTERNAL],
    sensors: [f64; SENSORS],
    motors: Option<Motors>,
    settled: u32,
    steps: u32,
    held: u32,
    rewards: f64,
    last: Judgement,
}

impl Behaviour {
    /// The behaviour a trial asks for: trials 0 to 3 REACH, 4 to 7 OPEN, 8 to 11 GRASP, 12 to 15 MOVE.
    #[must_use]
    pub fn of_trial(trial: u32) -> Self {
        Self::ALL[(trial / 4) as usize % Self::ALL.len()]
    }
}

impl<'a> Trial<'a> {
    /// Places robot, object and target in a lane.
    pub(crate) fn begin(
        setup: &'a Setup,
        engine: &mut dyn Engine,
        lane: usize,
        network: Network,
        draw: Draw,
        trial: u32,
    ) -> Self {
        let behaviour = Behaviour::of_trial(trial);
        let area = trial as usize % scene::AREA_DIRECTIONS.len();
        let Draw { replication, generation } = draw;
        let purpose = Purpose::TrialDraw;
        let seed = setup.experiment.seed;
        let mut stream = StreamKey { seed, replication, generation, purpose, index: trial }.stream();
        let mut jitter = |size: f64| size * (2.0 * stream.random::<f64>() - 1.0);
        let settings = &setup.experiment.scene;
        let share = if behaviour == Behaviour::Grasp { settings.grasp_jitter_share } else { 1.0 };
        let [front, side] = scene::AREA_DIRECTIONS[area];
        let object = [
            settings.areas_x + front * settings.areas_distance + jitter(settings.object_jitter * share),
            settings.areas_y + side * settings.areas_distance + jitter(settings.object_jitter * share),
        ];
        // Both target areas come up equally often in each behaviour.
        let side = scene::TARGET_DIRECTIONS[area % 2] * settings.target_side;
        let target = [-settings.target_front, side, scene::TABLE + settings.target_height]
            .map(|centre| centre + jitter(settings.target_jitter));
        engine.place(lane, &setup.starts.of(behaviour)[area].placement(object));
        Self {
            setup,
            network,
            behaviour,
            target,
            observation: engine.observe(lane),
            internal: [0.0; INTERNAL],
            sensors: [0.0; SENSORS],
            motors: None,
            settled: 0,
            steps: 0,
            held: 0,
            rewards: 0.0,
            last: Judgement { reward: 0.0, goal: false },
        }
    }

    /// Senses, and commands the lane for the coming control step.
    pub(crate) fn act(&mut self, engine: &mut dyn Engine, lane: usize) {
        if self.settled < SETTLING {
            return;
        }
        let Setup { experiment, robot, .. } = self.setup;
        let on_target = self.motors.is_some_and(|motors| motors.attends_target());
        let attended = if on_target { &self.target } else { &self.observation.object };
        self.sensors =
            body::sense(robot, &experiment.controller, &self.observation, attended, Some(self.behaviour));
        let motors = self.network.step(&self.sensors, &mut self.internal);
        engine.command(lane, &body::command(robot, &motors));
        self.motors = Some(motors);
    }

    /// Judges the state at the end of a control step; the outcome, if the trial ends with it.
    pub(crate) fn judge(&mut self, engine: &dyn Engine, lane: usize) -> Option<TrialOutcome> {
        self.observation = engine.observe(lane);
        let Some(motors) = &self.motors else {
            self.settled += 1;
            return None;
        };
        self.steps += 1;
        if !self.observation.is_finite() {
            return Some(TrialOutcome { score: 0.0, success: false, steps: self.steps });
        }
        let Setup { experiment, robot, .. } = self.setup;
        let view = View { robot, observation: &self.observation, target: self.target };
        let Judgement { reward, goal } = self.behaviour.judge(experiment, &view);
        let right = if self.behaviour.is_about_target() { motors.focus() } else { 1.0 - motors.focus() };
        let wrong = experiment.trials.wrong_focus;
        let reward = reward * (wrong + (1.0 - wrong) * (2.0 * right).min(1.0));
        self.rewards += reward;
        self.held = if goal { self.held + 1 } else { 0 };
        self.last = Judgement { reward, goal };

        let length = self.behaviour.steps(experiment);
        let success = self.held >= experiment.trials.hold;
        (success || self.steps >= length).then(|| {
            // After a success the rest of the trial counts as fully rewarded.
            let rest = if success { f64::from(length - self.steps) } else { 0.0 };
            let graded = (self.rewards + rest) / f64::from(length);
            let share = experiment.trials.goal_share;
            let score = (1.0 - share) * graded + share * f64::from(u8::from(success));
            TrialOutcome { score, success, steps: self.steps }
        })
    }

    /// The control step that was just judged; none while the posture settles.
    pub(crate) fn frame(&self) -> Option<Frame> {
        let Setup { experiment, robot, .. } = self.setup;
        let view = View { robot, observation: &self.observation, target: self.target };
        self.motors.map(|motors| Frame {
            sensors: self.sensors,
            internal: self.internal,
            motors,
            observation: self.observation.clone(),
            reward: self.last.reward,
            goal: self.last.goal,
            conditions: self.behaviour.conditions(experiment, &view),
        })
    }

    /// Where the target is.
    pub(crate) const fn target(&self) -> [f64; 3] {
        self.target
    }

    /// Robot and object as they were seen last.
    pub(crate) const fn observation(&self) -> &Observation {
        &self.observation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_evolution_gets_as_far_as_the_fresh_draws() {
        let longest = |generations| Experiment::from_toml("x", &format!("generations = {generations}"), &[]);
        assert!(longest(10_000_000).is_ok());
        assert!(longest(Draw::validation(0).generation).is_err());
        assert!(Draw::validation(FRESH - 1).generation < Draw::test(0).generation);
        assert!(Draw::test(0).generation < Draw::test(FRESH - 1).generation);
    }
}
