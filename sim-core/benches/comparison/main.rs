//! The physics engines against each other and against MuJoCo: the same robot, scene and motor commands, on one core.
//!
//! `just compare` prepares MuJoCo and runs this; without it the engines are compared among themselves. What is
//! measured, and the numbers, are in `README.md` beside this file.

#[path = "../common/mod.rs"]
mod common;
mod mujoco;
mod ours;

use std::error::Error;
use std::time::Duration;

use selftalk_sim::experiment::Engine;
use selftalk_sim::{Draw, Simulator};

use self::common::{Recording, champion, experiment, median, random};
use self::mujoco::MuJoCo;
use self::ours::Ours;

/// Turns that each engine gets. They take them one after the other, so that a busy machine is as unkind to all.
const TURNS: usize = 5;
/// How long a turn lasts at least.
const TURN: Duration = Duration::from_millis(500);
/// Evaluations of 16 trials of each kind of controller.
const EVALUATIONS: u32 = 4;
/// Objects that end closer together than this, in metres, have come to the same.
const SAME: f64 = 0.02;

/// One of those compared.
trait Contestant {
    /// Replays all recordings.
    fn replay(&mut self) -> Result<Replay, Box<dyn Error>>;
}

/// Where the objects end, and how long it took.
struct Replay {
    ends: Vec<[f64; 3]>,
    time: Duration,
}

type Named = (&'static str, Box<dyn Contestant>);

fn contestants(recordings: &[Recording]) -> Result<Vec<Named>, Box<dyn Error>> {
    let mut contestants: Vec<Named> = vec![
        ("lockstep", Box::new(Ours::new(Engine::Lockstep, recordings)?)),
        ("rapier", Box::new(Ours::new(Engine::Rapier, recordings)?)),
    ];
    for (name, settings) in [("MuJoCo, fastest", "fastest"), ("MuJoCo, careful", "careful")] {
        match MuJoCo::new(settings, recordings)? {
            Some(mujoco) => contestants.push((name, Box::new(mujoco))),
            None => println!("{name} is left out: `just compare` prepares it"),
        }
    }
    Ok(contestants)
}

/// What the turns of a contestant came to.
#[derive(Default)]
struct Turns {
    seconds: Vec<f64>,
    ends: Vec<[f64; 3]>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let simulator = Simulator::new(&experiment())?;
    let (mut champions, mut randoms) = (Vec::new(), Vec::new());
    for (generation, genotype) in (0..).zip(random(&simulator, EVALUATIONS as usize)) {
        let draw = Draw { replication: 0, generation };
        champions.extend(Recording::of(&simulator, &champion()?, draw)?.into_iter().map(held));
        randoms.extend(Recording::of(&simulator, &genotype, draw)?.into_iter().map(held));
    }
    println!(
        "{:<9} {:<16} {:>14} {:>8} {:>9}",
        "commands", "engine", "control steps/s", "slower", "same end"
    );
    for (commands, recordings) in [("champion", champions), ("random", randoms)] {
        compare(commands, &recordings)?;
    }
    Ok(())
}

/// Goes on with the last command until the trial's time is up, as if it had not succeeded.
fn held(mut recording: Recording) -> Recording {
    if let Some(last) = recording.commands.last().copied() {
        recording.commands.resize(recording.full, last);
    }
    recording
}

fn compare(commands: &str, recordings: &[Recording]) -> Result<(), Box<dyn Error>> {
    let steps: usize = recordings.iter().map(|recording| recording.commands.len()).sum();
    let mut contestants = contestants(recordings)?;
    let mut all: Vec<Turns> = contestants.iter().map(|_| Turns::default()).collect();
    for _ in 0..TURNS {
        for ((_, contestant), turns) in contestants.iter_mut().zip(&mut all) {
            let (mut replays, mut time) = (0, Duration::ZERO);
            while time < TURN {
                let replay = contestant.replay()?;
                (turns.ends, time, replays) = (replay.ends, time + replay.time, replays + 1);
            }
            turns.seconds.push(time.as_secs_f64() / f64::from(replays));
        }
    }
    let first = &all[0];
    for ((name, _), turns) in contestants.iter().zip(&all) {
        let rate = steps as f64 / median(turns.seconds.iter().copied());
        // Of turns that followed each other, so that what else the machine does cancels out.
        let slower = median(turns.seconds.iter().zip(&first.seconds).map(|(own, first)| own / first));
        let same = first.ends.iter().zip(&turns.ends).filter(|(a, b)| distance(a, b) < SAME).count();
        let same = format!("{same}/{}", recordings.len());
        println!("{commands:<9} {name:<16} {rate:>14.0} {slower:>8.1} {same:>9}");
    }
    Ok(())
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}
