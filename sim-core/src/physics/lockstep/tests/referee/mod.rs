//! MuJoCo as an outside referee: the same URDF, read, moved and brought to rest by another simulator.
//!
//! The tests need Python with MuJoCo, so they are run by `just referee` and ignored otherwise. The models on MuJoCo's
//! side, and the answers, are in `sim-core/referee/`.

mod python;
mod rest;
mod servos;
mod setup;
mod statics;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

/// A source of random postures and velocities.
struct Random {
    robot: RobotModel,
    stream: ChaCha8Rng,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self { robot: RobotModel::icub().unwrap(), stream: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// Angles within the joints' limits.
    fn posture(&mut self) -> [f64; JOINTS] {
        std::array::from_fn(|i| self.robot.joints[i].angle(self.stream.random()))
    }

    /// Velocities of up to 3 rad/s, the fingers' of up to 10.
    fn velocities(&mut self) -> [f64; JOINTS] {
        std::array::from_fn(|i| {
            let fastest = if i < joint::CARRIER.end { 3.0 } else { 10.0 };
            fastest * (2.0 * self.stream.random::<f64>() - 1.0)
        })
    }
}

/// A bound on a number over many cases, and the worst case. Prints what was measured.
struct Bound {
    what: String,
    bound: f64,
    worst: f64,
}

impl Bound {
    fn new(what: impl Into<String>, bound: f64) -> Self {
        Self { what: what.into(), bound, worst: 0.0 }
    }

    fn take(&mut self, value: f64) {
        self.worst = if value.is_nan() { f64::INFINITY } else { self.worst.max(value) };
    }

    fn hold(self) {
        let Self { what, bound, worst } = self;
        eprintln!("{what}: at most {worst:.1e}, bound {bound:.1e}");
        assert!(worst <= bound, "{what}: {worst:e} is more than {bound:e}");
    }
}
