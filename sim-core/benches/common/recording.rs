//! Motor commands as controllers gave them in trials, to be given to any engine.

use std::error::Error;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk_sim::behaviours::Starts;
use selftalk_sim::robot::{JOINTS, RobotModel};
use selftalk_sim::{Case, Draw, Experiment, Genotype, SETTLING, Simulator, body};
use serde::Serialize;

/// The genes of a controller that evolution found, hexadecimal: the champion of replication 0 in an
/// early run of the preset `elementary`, which succeeded in 13 of its 16 trials.
const CHAMPION: &str = include_str!("champion.txt");

/// A trial's start, and the servos' targets in each control step until it ended.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Recording {
    pub(crate) angles: [f64; JOINTS],
    pub(crate) object: [f64; 3],
    pub(crate) orientation: [f64; 4],
    pub(crate) commands: Vec<[f64; JOINTS]>,
    /// Control steps of a trial that does not succeed early.
    pub(crate) full: usize,
}

/// What the champion evolved in: the default experiment, with positions felt as its were.
pub(crate) fn experiment() -> Experiment {
    let mut experiment = Experiment::default();
    experiment.controller.position_scale = 0.1;
    experiment.controller.position_limit = 2.5;
    experiment
}

/// The champion.
///
/// # Errors
/// When the shipped genes are damaged.
pub(crate) fn champion() -> Result<Genotype, Box<dyn Error>> {
    Ok(Genotype::from_hex(&CHAMPION.split_whitespace().collect::<String>())?)
}

/// Controllers of random genes.
pub(crate) fn random(simulator: &Simulator, count: usize) -> Vec<Genotype> {
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let mut genes = || (0..simulator.gene_count()).map(|_| stream.random()).collect::<Vec<u16>>();
    (0..count).map(|_| Genotype::new(genes())).collect()
}

impl Recording {
    /// The trials of a controller.
    ///
    /// # Errors
    /// When the genotype does not fit the simulator.
    pub(crate) fn of(
        simulator: &Simulator,
        genotype: &Genotype,
        draw: Draw,
    ) -> Result<Vec<Self>, Box<dyn Error>> {
        let robot = RobotModel::icub()?;
        let starts = Starts::shipped()?;
        (0..simulator.trial_count())
            .map(|trial| {
                let behaviour = simulator.behaviour(trial);
                let trace = simulator.trace(genotype, Case::Drawn { draw, trial })?;
                let settling = starts.of(behaviour)[trial as usize % 4].placement([0.0; 2]).targets;
                let given = trace.frames.iter().map(|frame| body::command(&robot, &frame.motors));
                Ok(Self {
                    angles: trace.start.angles,
                    object: trace.start.object,
                    orientation: trace.start.orientation,
                    commands: std::iter::repeat_n(settling, SETTLING as usize).chain(given).collect(),
                    full: (SETTLING + behaviour.steps(&experiment())) as usize,
                })
            })
            .collect()
    }
}
