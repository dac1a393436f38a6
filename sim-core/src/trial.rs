//! A trial: what a controller senses, does and is given for it, control step by control step.

use crate::behaviours::{Behaviour, Condition, Starts, View};
use crate::body;
use crate::caretaker::Caretaker;
use crate::controller::{Activity, Motors, Network, SENSORS};
use crate::experiment::{Added, Experiment};
use crate::physics::{Engine, Observation};
use crate::robot::RobotModel;
use crate::score::{Judged, Score};
use crate::situation::Situation;

/// Control steps for which the initial posture is held before the controller takes over, so that a hand around the
/// object has it firmly in its grip.
pub const SETTLING: u32 = 2;

/// What a trial came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOutcome {
    /// Score in [0, 1]; NaN where the simulation left the finite numbers, which counts as 0.
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
    /// The label among them: the behaviour's own, or in MOVE-TO-TARGET the caretaker's or the robot's.
    pub heard: Option<Behaviour>,
    /// Activity of the leaky integrators.
    pub activity: Activity,
    /// The label that the robot says from the next step on, if it can speak.
    pub said: Option<Behaviour>,
    /// Activity of the motor neurons.
    pub motors: Motors,
    /// Robot and object at the end of the step.
    pub observation: Observation,
    /// The graded reward of the step, in [0, 1].
    pub reward: f64,
    /// Whether the state was the goal.
    pub goal: bool,
    /// Whether attention was on what it should have been on.
    pub focused: bool,
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
    /// The caretaker, where it speaks.
    caretaker: Option<Caretaker>,
    observation: Observation,
    activity: Activity,
    sensors: [f64; SENSORS],
    heard: Option<Behaviour>,
    said: Option<Behaviour>,
    motors: Option<Motors>,
    settled: u32,
    /// Control steps that are still under the label of the action before this one.
    lead_in: u32,
    steps: u32,
    held: u32,
    success: bool,
    score: Score,
    last: Judged,
}

impl<'a> Trial<'a> {
    /// Places robot, object and target in a lane.
    pub(crate) fn begin(
        setup: &'a Setup,
        engine: &mut dyn Engine,
        lane: usize,
        network: Network,
        situation: &Situation,
    ) -> Self {
        let &Situation { behaviour, posture, object, target, caretaker, lead_in } = situation;
        engine.place(lane, &setup.starts.of(behaviour)[posture].placement(object));
        Self {
            setup,
            network,
            behaviour,
            target,
            caretaker: caretaker.then(Caretaker::default),
            observation: engine.observe(lane),
            activity: Activity::default(),
            sensors: [0.0; SENSORS],
            heard: None,
            said: None,
            motors: None,
            settled: 0,
            lead_in,
            steps: 0,
            held: 0,
            success: false,
            score: Score::default(),
            last: Judged::default(),
        }
    }

    /// Senses, and commands the lane for the coming control step.
    pub(crate) fn act(&mut self, engine: &mut dyn Engine, lane: usize) {
        if self.settled < SETTLING {
            return;
        }
        let Setup { experiment, robot, .. } = self.setup;
        self.heard = self.label();
        let on_target = self.motors.is_some_and(|motors| motors.attends_target());
        let attended = if on_target { &self.target } else { &self.observation.object };
        self.sensors = body::sense(robot, &experiment.controller, &self.observation, attended, self.heard);
        let task = f64::from(u8::from(self.behaviour == Behaviour::MoveToTarget));
        let motors = self.network.step(&self.sensors, task, &mut self.activity);
        self.said = (experiment.controller.added == Added::Speech)
            .then(|| Behaviour::ELEMENTARY[self.activity.most_active()]);
        engine.command(lane, &body::command(robot, &motors));
        self.motors = Some(motors);
    }

    /// The label that the controller hears in the coming control step.
    fn label(&mut self) -> Option<Behaviour> {
        if self.lead_in > 0 {
            return self.behaviour.before();
        }
        if self.behaviour != Behaviour::MoveToTarget {
            return Some(self.behaviour);
        }
        let Some(caretaker) = &self.caretaker else { return self.said };
        let settings = &self.setup.experiment.caretaker;
        self.score.anticipation.note(settings, self.said, caretaker.label());
        Some(caretaker.label())
    }

    /// Judges the state at the end of a control step; the outcome, if the trial ends with it.
    pub(crate) fn judge(&mut self, engine: &dyn Engine, lane: usize) -> Option<TrialOutcome> {
        self.observation = engine.observe(lane);
        let Some(motors) = &self.motors else {
            self.settled += 1;
            return None;
        };
        if self.lead_in > 0 {
            self.lead_in -= 1;
            return None;
        }
        self.steps += 1;
        if !self.observation.is_finite() {
            return Some(TrialOutcome { score: f64::NAN, success: false, steps: self.steps });
        }
        let Setup { experiment, robot, .. } = self.setup;
        let view = View { robot, observation: &self.observation, target: self.target };
        self.last = self.score.add(experiment, self.behaviour, &view, motors);
        self.held = if self.last.goal { self.held + 1 } else { 0 };
        if let Some(caretaker) = &mut self.caretaker {
            caretaker.watch(experiment, &view);
        }

        self.success |= self.held >= experiment.trials.hold;
        let ends_at_goal = experiment.trials.end_at_goal || self.behaviour == Behaviour::MoveToTarget;
        let over = (self.success && ends_at_goal) || self.steps >= self.behaviour.steps(experiment);
        over.then(|| {
            let (success, speaks) = (self.success, self.caretaker.is_some());
            let score = self.score.total(experiment, self.behaviour, speaks, self.steps, success);
            TrialOutcome { score, success, steps: self.steps }
        })
    }

    /// The control step that was just judged; none before any was.
    pub(crate) fn frame(&self) -> Option<Frame> {
        let Setup { experiment, robot, .. } = self.setup;
        let view = View { robot, observation: &self.observation, target: self.target };
        let motors = self.motors.filter(|_| self.steps > 0);
        motors.map(|motors| Frame {
            sensors: self.sensors,
            heard: self.heard,
            activity: self.activity,
            said: self.said,
            motors,
            observation: self.observation.clone(),
            reward: self.last.reward,
            goal: self.last.goal,
            focused: self.last.focused,
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
    use crate::controller::Layout;
    use crate::genotype::Genotype;
    use crate::physics::{Instructions, engine};
    use crate::situation::{Case, Draw};

    #[test]
    fn a_lead_in_is_under_the_label_of_the_action_before() {
        let (robot, starts) = (RobotModel::icub().unwrap(), Starts::shipped().unwrap());
        let setup = Setup { experiment: Experiment::default(), robot, starts };
        let experiment = &setup.experiment;
        let mut engine = engine(&setup.robot, experiment, Instructions::default()).unwrap();
        let genes = Layout::new(&experiment.controller).genes();
        let network = Network::new(&Genotype::new(vec![1 << 15; genes]), &experiment.controller).unwrap();
        let draw = Draw { replication: 0, generation: 0 };
        let drawn = Situation::new(experiment, Case::Drawn { draw, trial: 8 });
        let situation = Situation { lead_in: 2, ..drawn };
        let mut trial = Trial::begin(&setup, engine.as_mut(), 0, network, &situation);
        let heard: Vec<Option<Behaviour>> = (0..6)
            .map(|_| {
                trial.act(engine.as_mut(), 0);
                engine.advance();
                assert_eq!(trial.judge(engine.as_ref(), 0), None);
                trial.heard
            })
            .collect();
        let [open, grasp] = [Behaviour::Open, Behaviour::Grasp].map(Some);
        assert_eq!(heard, [None, None, open, open, grasp, grasp], "first the posture settles");
        assert_eq!(trial.steps, 2, "what is judged");
    }
}
