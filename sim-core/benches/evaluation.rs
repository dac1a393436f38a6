//! What an evaluation costs: beside bare physics, with the number of trials, in memory, and in two slots.
//!
//! `cargo bench -p selftalk-sim --bench evaluation`. What is compared takes turns, and the numbers are medians.

mod common;

use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use selftalk_sim::physics::{self, Instructions};
use selftalk_sim::robot::RobotModel;
use selftalk_sim::{Case, Draw, Experiment, Genotype, Job, Simulator};

use self::common::{Recording, champion, experiment, median, random, replay};

/// Turns that each of those compared gets.
const TURNS: usize = 9;
const DRAW: Draw = Draw { replication: 0, generation: 0 };

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let simulator = Simulator::new(&experiment())?;
    beside_bare_physics("champion", &simulator, &vec![champion()?; 10])?;
    beside_bare_physics("random", &simulator, &random(&simulator, 10))?;
    with_the_number_of_trials(&simulator)?;
    in_two_slots(&simulator)?;
    match peak_memory() {
        Some(peak) => println!("peak memory of this process: {peak:.1} MiB"),
        None => println!("peak memory: the system does not tell"),
    }
    Ok(())
}

/// Seconds of something.
fn time(what: impl FnOnce() -> Outcome<()>) -> Outcome<f64> {
    let start = Instant::now();
    what()?;
    Ok(start.elapsed().as_secs_f64())
}

/// Runs all trials of some genotypes, as many as are left to give out, in one slot.
fn evaluate(simulator: &Simulator, genotypes: &[Arc<Genotype>], given: &AtomicUsize) -> Outcome<()> {
    let trials = simulator.trial_count() as usize;
    let next = || {
        let number = given.fetch_add(1, Ordering::Relaxed);
        let genotype = Arc::clone(genotypes.get(number / trials)?);
        let case = Case::Drawn { draw: DRAW, trial: (number % trials) as u32 };
        Some(Job { genotype, case, tag: () })
    };
    Ok(simulator.run(next, |(), _| ())?)
}

fn shared(genotypes: &[Genotype]) -> Vec<Arc<Genotype>> {
    genotypes.iter().cloned().map(Arc::new).collect()
}

/// Controllers, sensors and rewards included, against the physics of the same commands.
fn beside_bare_physics(name: &str, simulator: &Simulator, genotypes: &[Genotype]) -> Outcome<()> {
    let mut recordings = Vec::new();
    for genotype in genotypes {
        recordings.extend(Recording::of(simulator, genotype, DRAW)?);
    }
    let genotypes = shared(genotypes);
    let robot = RobotModel::icub()?;
    let mut ratios = Vec::new();
    for _ in 0..TURNS {
        let full = time(|| evaluate(simulator, &genotypes, &AtomicUsize::new(0)))?;
        let bare = time(|| {
            let mut engine = physics::engine(&robot, &Experiment::default(), Instructions::Best)?;
            replay(engine.as_mut(), &recordings);
            Ok(())
        })?;
        ratios.push(full / bare);
    }
    println!("evaluation over bare physics, {name}: {:.2}", median(ratios));
    Ok(())
}

/// The lanes run empty at the end, which few trials feel.
fn with_the_number_of_trials(simulator: &Simulator) -> Outcome<()> {
    let counts = [1, 10, 100];
    let genotypes = shared(&vec![random(simulator, 1).remove(0); counts[2]]);
    let mut costs = [const { Vec::new() }; 3];
    for _ in 0..TURNS {
        for (count, costs) in counts.iter().zip(&mut costs) {
            let seconds = time(|| evaluate(simulator, &genotypes[..*count], &AtomicUsize::new(0)))?;
            costs.push(1e6 * seconds / (*count * simulator.trial_count() as usize) as f64);
        }
    }
    for (count, costs) in counts.into_iter().zip(costs) {
        println!("{:>5} trials: {:.0} us a trial", count * simulator.trial_count() as usize, median(costs));
    }
    Ok(())
}

/// Wall time counts what other programs take of the cores; time on a core does not, and shows what the slots take from
/// each other.
fn in_two_slots(simulator: &Simulator) -> Outcome<()> {
    let genotypes = shared(&random(simulator, 100));
    let (mut walls, mut cores) = (Vec::new(), Vec::new());
    for _ in 0..TURNS {
        let (one, one_on_core) = in_slots(1, simulator, &genotypes)?;
        let (two, two_on_core) = in_slots(2, simulator, &genotypes)?;
        walls.push(one / two);
        cores.extend(one_on_core.zip(two_on_core).map(|(one, two)| 2.0 * one / two));
    }
    println!("throughput of two slots over one: {:.2} by the clock", median(walls));
    println!("throughput of two slots over one: {:.2} by the time on a core", median(cores));
    Ok(())
}

/// Seconds that all trials take, by the clock and on the cores.
fn in_slots(slots: usize, simulator: &Simulator, genotypes: &[Arc<Genotype>]) -> Outcome<(f64, Option<f64>)> {
    let given = AtomicUsize::new(0);
    let slot = || {
        let before = on_core();
        evaluate(simulator, genotypes, &given).ok()?;
        Some(on_core().zip(before).map(|(after, before)| after - before))
    };
    let start = Instant::now();
    let used: Option<Vec<Option<f64>>> = std::thread::scope(|scope| {
        let slots: Vec<_> = (0..slots).map(|_| scope.spawn(slot)).collect();
        slots.into_iter().map(|slot| slot.join().ok().flatten()).collect()
    });
    let used = used.ok_or("a slot failed")?;
    Ok((start.elapsed().as_secs_f64(), used.into_iter().sum()))
}

/// Seconds this thread has been on a core; none where the system does not tell.
fn on_core() -> Option<f64> {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(statistics.split_whitespace().next()?.parse::<f64>().ok()? / 1e9)
}

/// In MiB; none where the system does not tell.
fn peak_memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.split_whitespace().next()?.parse::<f64>().ok()? / 1024.0)
}
