//! Simulated control steps (50 ms each, of one trial) per second and core.
//!
//! `cargo bench -p selftalk-sim` prints a line for each engine, instruction set and kind of trial: sensors, network, physics
//! and rewards included. Random controllers wave the arm and hit object and table; in GRASP and MOVE the hand is
//! around the object, so that contacts dominate.

use std::error::Error;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use selftalk_sim::experiment::Engine;
use selftalk_sim::physics::Instructions;
use selftalk_sim::{Case, Draw, Experiment, Genotype, Job, Simulator};

/// How long each line is measured.
const TIME: Duration = Duration::from_secs(3);

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "{:<8}  {:<12}  {:<16}  {:>24}  {:>12}",
        "engine", "instructions", "trials", "control steps / s / core", "us / step"
    );
    for (engine, instructions) in [
        (Engine::Lockstep, Instructions::Best),
        (Engine::Lockstep, Instructions::Avx2),
        (Engine::Lockstep, Instructions::Baseline),
        (Engine::Rapier, Instructions::default()),
    ] {
        for (trials, range) in [("all", 0..16), ("GRASP and MOVE", 8..16)] {
            let rate = control_steps_per_second(engine, instructions, range)?;
            let (engine, instructions) = (engine.name(), format!("{instructions:?}"));
            let time = 1e6 / rate;
            println!("{engine:<8}  {instructions:<12}  {trials:<16}  {rate:>24.0}  {time:>12.2}");
        }
    }
    Ok(())
}

/// Runs trials of random controllers on one thread.
fn control_steps_per_second(
    engine: Engine,
    instructions: Instructions,
    trials: Range<u32>,
) -> Result<f64, Box<dyn Error>> {
    let experiment = Experiment { engine, ..Experiment::default() };
    let simulator = Simulator::with_instructions(&experiment, instructions)?;
    let mut stream = ChaCha8Rng::seed_from_u64(1);
    let draw = Draw { replication: 0, generation: 0 };
    let mut queue = Vec::new();
    let mut steps = 0_u64;
    let start = Instant::now();
    let next = || {
        if queue.is_empty() && start.elapsed() < TIME {
            let genes: Vec<u16> = (0..simulator.gene_count()).map(|_| stream.random()).collect();
            let genotype = Arc::new(Genotype::new(genes));
            queue.extend(trials.clone().map(|trial| Job {
                genotype: Arc::clone(&genotype),
                case: Case::Drawn { draw, trial },
                tag: (),
            }));
        }
        queue.pop()
    };
    simulator.run(next, |(), outcome| steps += u64::from(outcome.steps))?;
    Ok(steps as f64 / start.elapsed().as_secs_f64())
}
