//! The simulator's own engines.

use std::error::Error;
use std::time::Instant;

use selftalk_sim::physics::{self, Instructions};
use selftalk_sim::robot::RobotModel;
use selftalk_sim::{Experiment, experiment};

use crate::common::{Recording, replay};
use crate::{Contestant, Replay};

/// An engine with the recordings it replays.
pub(crate) struct Ours {
    engine: Box<dyn physics::Engine>,
    recordings: Vec<Recording>,
}

impl Ours {
    pub(crate) fn new(engine: experiment::Engine, recordings: &[Recording]) -> Result<Self, Box<dyn Error>> {
        let experiment = Experiment { engine, ..Experiment::default() };
        let engine = physics::engine(&RobotModel::icub()?, &experiment, Instructions::Best)?;
        Ok(Self { engine, recordings: recordings.to_vec() })
    }
}

impl Contestant for Ours {
    fn replay(&mut self) -> Result<Replay, Box<dyn Error>> {
        let start = Instant::now();
        let ends = replay(self.engine.as_mut(), &self.recordings);
        Ok(Replay { ends, time: start.elapsed() })
    }
}
