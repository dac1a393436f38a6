//! The simulator of one experiment: trials of any genotypes, side by side in an engine's lanes.

use std::ops::Range;
use std::sync::Arc;

use thiserror::Error;

use crate::behaviours::{Behaviour, StartError, Starts};
use crate::controller::{Layout, Network};
use crate::experiment::{Engine, Experiment, Task};
use crate::genotype::{Genotype, GenotypeError};
use crate::null::Null;
use crate::physics::{self, EngineError, Instructions, Observation};
use crate::robot::{RobotError, RobotModel};
use crate::situation::{self, Case, Draw, Situation};
use crate::trial::{Frame, Setup, Trial, TrialOutcome};

/// Why an evaluation is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimError {
    /// The genotype does not fit the experiment's controller.
    #[error(transparent)]
    Genotype(#[from] GenotypeError),
    /// An individual that generation 0 is to be made from does not fit the experiment's controller.
    #[error("ancestors.genotypes: number {number} does not fit this controller: {error}")]
    Ancestor {
        /// Which one, counted from 0.
        number: usize,
        /// How it does not fit.
        error: GenotypeError,
    },
    /// A trial number is too large.
    #[error("trial {trial} does not exist: there are trials 0 to {}", trials - 1)]
    Trial {
        /// The trial that was asked for.
        trial: u32,
        /// How many there are.
        trials: u32,
    },
    /// There is no engine, or none that simulates anything that could be looked at.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The shipped robot is damaged.
    #[error(transparent)]
    Robot(#[from] RobotError),
    /// The shipped initial postures are damaged.
    #[error(transparent)]
    Starts(#[from] StartError),
}

/// A trial to be run, with whatever the caller wants back beside its outcome.
#[derive(Debug, Clone)]
pub struct Job<T> {
    /// The genotype under test; shared by its trials.
    pub genotype: Arc<Genotype>,
    /// Which trial.
    pub case: Case,
    /// Returned with the outcome.
    pub tag: T,
}

/// A trial, control step by control step.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Robot and object at the start, before the posture settles.
    pub start: Observation,
    /// Where the target is; root frame, metres.
    pub target: [f64; 3],
    /// The control steps.
    pub frames: Vec<Frame>,
    /// What the trial came to: the same as without a trace.
    pub outcome: TrialOutcome,
}

/// Everything the trials of one experiment share. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Simulator {
    setup: Arc<Setup>,
    instructions: Instructions,
}

impl Simulator {
    /// Prepares the simulator of an experiment.
    ///
    /// # Errors
    /// [`SimError::Ancestor`] when the experiment's ancestors do not fit its controller, [`SimError::Robot`] or
    /// [`SimError::Starts`] when a shipped file is damaged.
    pub fn new(experiment: &Experiment) -> Result<Self, SimError> {
        Self::with_instructions(experiment, Instructions::default())
    }

    /// The same with a choice of instruction set, which changes the speed and nothing else.
    ///
    /// # Errors
    /// As [`Simulator::new`].
    pub fn with_instructions(experiment: &Experiment, instructions: Instructions) -> Result<Self, SimError> {
        let layout = Layout::new(&experiment.controller);
        for (number, genotype) in experiment.ancestors.genotypes.iter().enumerate() {
            let (expected, found) = (layout.elementary(), genotype.genes().len());
            if expected != found {
                let error = GenotypeError::Length { expected, found: 2 * found };
                return Err(SimError::Ancestor { number, error });
            }
        }
        let setup =
            Setup { experiment: experiment.clone(), robot: RobotModel::icub()?, starts: Starts::shipped()? };
        Ok(Self { setup: Arc::new(setup), instructions })
    }

    /// Genes of a genotype.
    #[must_use]
    pub fn gene_count(&self) -> usize {
        Layout::new(&self.setup.experiment.controller).genes()
    }

    /// Trials of an evaluation: 16, four for each elementary action, or 8 of MOVE-TO-TARGET.
    #[must_use]
    pub fn trial_count(&self) -> u32 {
        situation::trials(self.setup.experiment.task)
    }

    /// The behaviour a trial asks for.
    #[must_use]
    pub fn behaviour(&self, trial: u32) -> Behaviour {
        Behaviour::of_trial(self.setup.experiment.task, trial)
    }

    /// The behaviours that an evaluation's trials ask for.
    #[must_use]
    pub fn behaviours(&self) -> &'static [Behaviour] {
        match self.setup.experiment.task {
            Task::Elementary => &Behaviour::ELEMENTARY,
            Task::MoveToTarget => &[Behaviour::MoveToTarget],
        }
    }

    /// Runs trials of one genotype and returns their outcomes in order.
    ///
    /// # Errors
    /// [`SimError`] when the genotype or the trials do not fit the experiment.
    pub fn evaluate(
        &self,
        genotype: &Genotype,
        draw: Draw,
        trials: Range<u32>,
    ) -> Result<Vec<TrialOutcome>, SimError> {
        let genotype = Arc::new(genotype.clone());
        let mut outcomes = vec![None; trials.len()];
        let mut jobs = trials.enumerate().map(|(tag, trial)| {
            let case = Case::Drawn { draw, trial };
            Job { genotype: Arc::clone(&genotype), case, tag }
        });
        self.run(|| jobs.next(), |tag, outcome| outcomes[tag] = Some(outcome))?;
        Ok(outcomes.into_iter().flatten().collect())
    }

    /// Runs trials side by side: takes jobs from `next` whenever a lane is free, until it has none, and hands each
    /// outcome to `done` as it falls, in any order. An outcome does not depend on the other jobs.
    ///
    /// # Errors
    /// [`SimError`] at the first job that does not fit the experiment.
    pub fn run<T>(
        &self,
        mut next: impl FnMut() -> Option<Job<T>>,
        mut done: impl FnMut(T, TrialOutcome),
    ) -> Result<(), SimError> {
        let Setup { experiment, robot, .. } = self.setup.as_ref();
        if experiment.engine == Engine::Null {
            return self.invent(next, done);
        }
        let mut engine = physics::engine(robot, experiment, self.instructions)?;
        let mut lanes: Vec<Option<(Trial<'_>, T)>> = (0..engine.lanes()).map(|_| None).collect();
        let mut decoded = Decoded::default();
        loop {
            for (lane, slot) in lanes.iter_mut().enumerate().filter(|(_, slot)| slot.is_none()) {
                let Some(job) = next() else { break };
                let network = decoded.network(experiment, &job.genotype)?;
                let situation = self.situation(job.case)?;
                let trial = Trial::begin(&self.setup, engine.as_mut(), lane, network, &situation);
                *slot = Some((trial, job.tag));
            }
            if lanes.iter().all(Option::is_none) {
                return Ok(());
            }
            for (lane, slot) in lanes.iter_mut().enumerate() {
                if let Some((trial, _)) = slot {
                    trial.act(engine.as_mut(), lane);
                }
            }
            engine.advance();
            for (lane, slot) in lanes.iter_mut().enumerate() {
                let outcome = slot.as_mut().and_then(|(trial, _)| trial.judge(engine.as_ref(), lane));
                if let Some((outcome, (_, tag))) = outcome.and_then(|outcome| Some((outcome, slot.take()?))) {
                    done(tag, outcome);
                }
            }
        }
    }

    /// Runs one trial and keeps every control step.
    ///
    /// # Errors
    /// [`SimError`] when the genotype or the trial does not fit the experiment.
    pub fn trace(&self, genotype: &Genotype, case: Case) -> Result<Trace, SimError> {
        let Setup { experiment, robot, .. } = self.setup.as_ref();
        let mut engine = physics::engine(robot, experiment, self.instructions)?;
        let network = Network::new(genotype, &experiment.controller)?;
        let mut trial = Trial::begin(&self.setup, engine.as_mut(), 0, network, &self.situation(case)?);
        let (start, target) = (trial.observation().clone(), trial.target());
        let mut frames = Vec::new();
        loop {
            trial.act(engine.as_mut(), 0);
            engine.advance();
            let outcome = trial.judge(engine.as_ref(), 0);
            frames.extend(trial.frame());
            if let Some(outcome) = outcome {
                return Ok(Trace { start, target, frames, outcome });
            }
        }
    }

    /// What [`Simulator::run`] does where nothing is simulated.
    fn invent<T>(
        &self,
        next: impl FnMut() -> Option<Job<T>>,
        mut done: impl FnMut(T, TrialOutcome),
    ) -> Result<(), SimError> {
        let mut null = Null::new(self.setup.experiment.seed);
        let expected = self.gene_count();
        for Job { genotype, case, tag } in std::iter::from_fn(next) {
            let found = 2 * genotype.genes().len();
            if found != 2 * expected {
                return Err(GenotypeError::Length { expected, found }.into());
            }
            self.check(case)?;
            done(tag, null.outcome(&genotype, case));
        }
        Ok(())
    }

    fn situation(&self, case: Case) -> Result<Situation, SimError> {
        self.check(case)?;
        Ok(Situation::new(&self.setup.experiment, case))
    }

    /// Whether there is such a trial.
    fn check(&self, case: Case) -> Result<(), SimError> {
        let (trial, trials) = match case {
            Case::Drawn { trial, .. } => (trial, self.trial_count()),
            Case::Grid { number } => (number, Case::GRID_TRIALS),
        };
        if trial < trials { Ok(()) } else { Err(SimError::Trial { trial, trials }) }
    }
}

/// The network of the last job's genotype: the trials of one genotype follow each other.
#[derive(Default)]
struct Decoded {
    last: Option<(Arc<Genotype>, Network)>,
}

impl Decoded {
    fn network(&mut self, experiment: &Experiment, of: &Arc<Genotype>) -> Result<Network, SimError> {
        match &self.last {
            Some((genotype, network)) if Arc::ptr_eq(genotype, of) => Ok(network.clone()),
            _ => {
                let network = Network::new(of, &experiment.controller)?;
                self.last = Some((Arc::clone(of), network.clone()));
                Ok(network)
            }
        }
    }
}
