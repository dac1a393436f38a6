//! What the service costs, without a simulator: `cargo bench -p selftalk-tests --bench service -- cost|crowd`.
//!
//! `cost [GENERATIONS]`: a master and two workers as processes, 1 600 units a generation (16 replications of 100 genotypes,
//! `engine = "null"`), 100 generations: wall and processor time a unit, everything included, the database too. `others.py`
//! sets general task systems beside it.
//!
//! `crowd [WORKERS [GENERATIONS [REPLICATIONS]]]`: a master, and a thousand workers in this process, each taking 50 ms for a
//! unit. How long it takes until all have joined, how long one waits for a lease, what the master needs, and what becomes of
//! it when 30 % of them are gone at once and as many others come.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod probe;

use std::time::{Duration, Instant};

use selftalk_tests::{Page, Place, processor_time, processor_time_of_children, wait_until};
use selftalk_worker::{Config, over_tcp, run_in_task};
use tokio::task::AbortHandle;
use tokio_util::sync::CancellationToken;

use self::probe::Probe;

/// What a worker of a crowd takes for a unit; a slot of a real one takes 10 to 50 ms.
const PACE: Duration = Duration::from_millis(50);

/// Replications side by side, each with 100 units a generation.
const REPLICATIONS: u32 = 16;

fn main() {
    // Cargo adds a `--bench`.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let number = |place: usize, otherwise: u32| {
        words.get(place).map_or(otherwise, |word| word.parse().expect("a number"))
    };
    match words.first().map(String::as_str) {
        Some("cost") => cost(number(1, 100)),
        Some("crowd") => crowd(number(1, 1000), number(2, 100), number(3, REPLICATIONS)),
        _ => println!("what is it to be: cost or crowd?"),
    }
}

/// A place with an experiment in which nothing is simulated, and all genotypes differ.
fn place(generations: u32, replications: u32) -> Place {
    let place = Place::new();
    let experiment = format!(
        "name = 'null'\nengine = 'null'\nreplications = {replications}\ngenerations = {generations}\n\
         evolution.mutation = 0.01\n"
    );
    place.write("null.toml", experiment);
    // Finding the program may build it.
    place.run("--version").done();
    place
}

fn cost(generations: u32) {
    let place = place(generations, REPLICATIONS);
    let (begin, before) = (Instant::now(), processor_time_of_children().expect("Linux"));
    let mut master = place.start("serve --listen 127.0.0.1:0 --dashboard off null.toml");
    let address = master.address();
    let workers = [(); 2].map(|()| place.start_worker(&address));
    master.end().done();
    for worker in workers {
        worker.end().done();
    }
    let (wall, used) = (begin.elapsed().as_secs_f64(), processor_time_of_children().expect("Linux") - before);
    let units = f64::from(generations) * 1600.0;
    println!("units: {units}, wall: {wall:.2} s, processor: {used:.2} s");
    println!("a unit: wall {:.1} us, processor {:.1} us", 1e6 * wall / units, 1e6 * used / units);
    let bytes = place.read("history.db").len() as f64;
    println!("database: {:.1} MB, {:.0} bytes a genotype and generation", bytes / 1e6, bytes / units);
}

fn crowd(workers: u32, generations: u32, replications: u32) {
    let place = place(generations, replications);
    let mut master = place.start("serve --listen 127.0.0.1:0 --dashboard 127.0.0.1:0 null.toml");
    let (address, page) = (master.address(), master.dashboard());
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let process = master.id();
    let metric = |name: &str| {
        let text = Page::get(&page, "/metrics").body;
        let value = text.lines().find_map(|line| line.strip_prefix(name)?.trim().parse::<f64>().ok());
        value.unwrap_or_else(|| panic!("no {name}"))
    };
    let fingerprint = selftalk_sim::fingerprint().unwrap();
    let hire = || {
        let mut config = Config::new(format!("http://{address}"), fingerprint.as_str());
        config.slots = 1;
        runtime.spawn(run_in_task(config, over_tcp(), PACE, CancellationToken::new())).abort_handle()
    };

    let probe = runtime.block_on(Probe::join(address.clone(), fingerprint.clone()));
    let begin = Instant::now();
    let mut crew: Vec<AbortHandle> = (0..workers).map(|_| hire()).collect();
    let all = |count: u32| {
        wait_until("all workers", || (metric("selftalk_workers ") >= f64::from(count)).then_some(()))
    };
    all(workers + 1);
    println!("{workers} workers have joined after {:.2} s", begin.elapsed().as_secs_f64());

    let units = || metric("selftalk_units_total ");
    let watch = |what: &str, seconds: u64| {
        let (begin, before, used) = (Instant::now(), units(), processor_time(process).expect("Linux"));
        std::thread::sleep(Duration::from_secs(seconds));
        let (wall, done) = (begin.elapsed().as_secs_f64(), units() - before);
        let used = processor_time(process).expect("Linux") - used;
        println!(
            "{what}: {:.0} units a second, master {:.0} % of a core, {:.1} us a unit, {:.0} MiB at most",
            done / wall,
            100.0 * used / wall,
            1e6 * used / done,
            memory(process)
        );
    };
    let probed = runtime.spawn(probe.waits(PACE, Duration::from_secs(5)));
    watch("steady", 5);
    let waits = runtime.block_on(probed).unwrap();
    let share = |share: f64| waits[((waits.len() - 1) as f64 * share) as usize];
    println!("a lease comes after {:.1} ms (median), {:.1} ms (99 of 100)", share(0.5), share(0.99));
    let gone = crew.len() * 3 / 10;
    crew.drain(..gone).for_each(|worker| worker.abort());
    watch("30 % gone at once", 3);
    crew.extend((0..gone).map(|_| hire()));
    let begin = Instant::now();
    all(workers);
    println!("as many others have joined after {:.2} s", begin.elapsed().as_secs_f64());
    master.end().done();
    let alone = self::place(generations, replications);
    alone.run("run null.toml --dashboard off").done();
    let digest = |place: &Place| place.run("digest null --format csv").done().stdout;
    assert_eq!(digest(&place), digest(&alone));
    println!("the history is that of a run with two workers");
}

/// The most memory that a process has had, in MiB.
fn memory(process: u32) -> f64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).expect("Linux");
    let kib = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:")?.trim().split(' ').next()?.parse::<f64>().ok());
    kib.expect("memory is counted") / 1024.0
}
