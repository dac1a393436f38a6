//! A run whose processes are killed and frozen, whose disk fills up, whose clock jumps and some of whose workers answer wrongly,
//! twice, late, with nonsense or not at all, in an order that a seed decides on: at the end the history is that of an undisturbed run, and the database is sound.

#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::Signal;
use selftalk_tests::{CrookedLine, Disk, Manner, Place, Running, free_port, selftalk, wait_until, worker};
use sqlx::Connection;

const WORKERS: usize = 3;
/// Generations over both replications, enough for all blows.
const GENERATIONS: u64 = 160;
/// Fakes the time of day, and leaves alone what only ever goes forward.
const FAKETIME: &str = "/usr/lib/x86_64-linux-gnu/faketime/libfaketimeMT.so.1";

/// What is done to a run.
#[derive(Debug, Clone, Copy)]
enum Blow {
    KillMaster,
    KillWorker,
    /// The system gives it no time; for long enough that it is taken for lost, or not.
    FreezeWorker(Duration),
    FreezeMaster(Duration),
    FillDisk,
    /// The time of day is another: that many days from the right one.
    ShiftClock(i32),
    /// A worker joins that is not heard as it speaks.
    Twist(Manner),
}

/// A run that is being disturbed.
struct Site {
    place: Place,
    disk: Option<Disk>,
    clock: PathBuf,
    port: u16,
    master: Running,
    workers: Vec<Running>,
    twisted: Vec<(Running, CrookedLine)>,
}

impl Site {
    fn new(disk: Option<Disk>, clock: PathBuf) -> Self {
        let place = disk.as_ref().map_or_else(Place::new, |disk| Place::in_folder(disk.path()));
        place.write("long.toml", long());
        std::fs::write(&clock, "+0d").unwrap();
        let port = free_port();
        let master = start_master(&place, &clock, port);
        let workers = (0..WORKERS).map(|_| start_worker(&clock, &address(port))).collect();
        Self { place, disk, clock, port, master, workers, twisted: Vec::new() }
    }

    /// Waits for some generations more. False once the run has ended.
    fn goes_on(&mut self) -> bool {
        let before = self.place.generations();
        wait_until("more generations", || {
            let now = self.place.generations();
            (now >= before + 3 || now >= GENERATIONS).then_some(now < GENERATIONS)
        })
    }

    fn strike(&mut self, blow: Blow, dice: &mut ChaCha8Rng) {
        let which = dice.random_range(0..WORKERS);
        match blow {
            Blow::KillMaster => {
                self.master.signal(Signal::KILL);
                wait_until("the master's end", || (!self.master.is_running()).then_some(()));
                self.master = start_master(&self.place, &self.clock, self.port);
            }
            Blow::KillWorker => {
                // Dropping it kills it.
                self.workers[which] = start_worker(&self.clock, &address(self.port));
            }
            Blow::FreezeWorker(time) => freeze(&mut self.workers[which], time),
            Blow::FreezeMaster(time) => freeze(&mut self.master, time),
            Blow::FillDisk => self.fill_disk(),
            Blow::Twist(manner) => {
                let line = CrookedLine::to(self.port, manner);
                self.twisted.push((start_worker(&self.clock, &line.master()), line));
            }
            Blow::ShiftClock(days) => std::fs::write(&self.clock, format!("{days:+}d")).unwrap(),
        }
    }

    /// Leaves the master no room, until it has given up, and goes on with room.
    fn fill_disk(&mut self) {
        let Some(disk) = &self.disk else { return };
        let used: u64 = std::fs::read_dir(disk.path())
            .unwrap()
            .map(|file| file.unwrap().metadata().unwrap().len().div_ceil(4096) * 4)
            .sum();
        disk.remount(&format!("size={}k", used + 256));
        let gave_up = self.master.reports("the disk is full");
        disk.remount("size=256m");
        if gave_up {
            self.master = start_master(&self.place, &self.clock, self.port);
        }
    }
}

/// The experiment of the other tests, and more of it.
fn long() -> String {
    let generations = format!("generations = {}", GENERATIONS / 2);
    selftalk_tests::SMALL.replace("generations = 12", &generations)
}

fn at_time_of(clock: &Path, mut command: Command) -> Command {
    if Path::new(FAKETIME).exists() {
        command.env("LD_PRELOAD", FAKETIME).env("FAKETIME_DONT_FAKE_MONOTONIC", "1");
        command.env("FAKETIME_TIMESTAMP_FILE", clock).env("FAKETIME_CACHE_DURATION", "1");
    }
    command
}

fn start_master(place: &Place, clock: &Path, port: u16) -> Running {
    let mut command = at_time_of(clock, selftalk());
    command.current_dir(place.path("")).args([
        "serve",
        "long.toml",
        "--db",
        "history.db",
        "--dashboard",
        "off",
    ]);
    command.args(["--audit", "0.05", "--listen", &format!("127.0.0.1:{port}")]);
    Running::start(command)
}

fn address(port: u16) -> String {
    format!("http://127.0.0.1:{port}")
}

fn start_worker(clock: &Path, master: &str) -> Running {
    let mut command = at_time_of(clock, worker());
    command.args(["--slots", "1", "--connect-timeout", "100", "--master", master]);
    Running::start(command)
}

fn freeze(process: &mut Running, time: Duration) {
    process.signal(Signal::STOP);
    sleep(time);
    process.signal(Signal::CONT);
}

/// What SQLite finds wrong with a database.
fn faults(database: &Path) -> Vec<String> {
    let ask = async {
        let options = sqlx::sqlite::SqliteConnectOptions::new().filename(database).read_only(true);
        let mut connection = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        let found: Vec<(String,)> =
            sqlx::query_as("PRAGMA integrity_check").fetch_all(&mut connection).await.unwrap();
        let dangling = sqlx::query("PRAGMA foreign_key_check").fetch_all(&mut connection).await.unwrap();
        let mut faults: Vec<String> =
            found.into_iter().map(|(fault,)| fault).filter(|fault| fault != "ok").collect();
        faults.extend(dangling.iter().map(|_| "a row refers to none".to_owned()));
        faults
    };
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(ask)
}

fn play(seed: u64) {
    let mut dice = ChaCha8Rng::seed_from_u64(seed);
    let clock = tempfile::tempdir().unwrap();
    let mut site = Site::new(Disk::mount(256 * 1024), clock.path().join("clock"));
    let short = |dice: &mut ChaCha8Rng| Duration::from_millis(dice.random_range(50..2_000));
    let mut blows = vec![
        Blow::KillMaster,
        Blow::KillMaster,
        Blow::KillWorker,
        Blow::KillWorker,
        Blow::FreezeWorker(short(&mut dice)),
        // Longer than the master waits for a sign of life.
        Blow::FreezeWorker(Duration::from_secs(11)),
        Blow::FreezeMaster(short(&mut dice)),
        Blow::FillDisk,
        Blow::ShiftClock(3),
        Blow::ShiftClock(-2),
        Blow::Twist(Manner::WrongBits),
        Blow::Twist(Manner::Twice),
        Blow::Twist(Manner::Hangs),
        Blow::Twist(Manner::Garbage),
        Blow::Twist(Manner::Late),
    ];
    blows.shuffle(&mut dice);
    let mut struck = 0;
    for blow in blows {
        if !site.goes_on() {
            break;
        }
        site.strike(blow, &mut dice);
        struck += 1;
    }
    let Site { place, disk: _disk, master, workers, twisted: _twisted, .. } = site;
    master.end().done();
    for worker in workers {
        worker.end().done();
    }
    assert!(struck >= 12, "seed {seed}: the run was over after {struck} blows");
    assert_eq!(faults(&place.path("history.db")), Vec::<String>::new(), "seed {seed}");

    let alone = Place::new();
    alone.write("long.toml", long());
    alone.run("run long.toml").done();
    assert_eq!(place.digests(), alone.digests(), "seed {seed}");
}

#[test]
fn killed_frozen_and_lying_processes_full_disks_and_wrong_clocks_change_nothing() {
    play(1);
}

/// `SELFTALK_SEEDS` says how many, 100 otherwise.
#[test]
#[ignore = "takes hours"]
fn nothing_changes_for_many_seeds() {
    let count = std::env::var("SELFTALK_SEEDS").map_or(100, |count| count.parse().expect("a number"));
    (2..2 + count).for_each(play);
}
