//! Prints how soon a run goes on after its master was killed, and how much work is done twice for it.
//!
//! `cargo bench -p selftalk-tests --bench recovery [-- KILLS]` runs some generations of the preset `elementary-0.5`, all
//! of its ten replications, with two workers, once undisturbed and once with a master that is killed (SIGKILL) every few
//! seconds and started again at once. Takes a few minutes. Nothing else should run meanwhile.

#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

#[cfg(unix)]
fn main() {
    unix::main();
}

#[cfg(not(unix))]
fn main() {
    println!("there is no SIGKILL here");
}

#[cfg(unix)]
mod unix {
    use std::thread::sleep;
    use std::time::{Duration, Instant};

    use rustix::process::Signal;
    use selftalk_tests::{Place, Running, free_port, wait_until, worker};

    const WORKERS: usize = 2;
    const EXPERIMENT: &str = "elementary-0.5";
    const SETTINGS: &str = "\
name = 'elementary-0.5'
generations = 8
evolution = { mutation = 0.005 }
physics = { substeps = 4 }
";

    /// A master and its workers.
    struct Site {
        place: Place,
        port: u16,
        master: Running,
        workers: Vec<Running>,
    }

    impl Site {
        fn new() -> Self {
            let (place, port) = (Place::new(), free_port());
            place.write("e.toml", SETTINGS);
            let master = serve(&place, port);
            let start = |_| {
                let mut command = worker();
                command.args(["--slots", "1", "-vv", "--master", &format!("http://127.0.0.1:{port}")]);
                Running::start(command)
            };
            Self { place, port, master, workers: (0..WORKERS).map(start).collect() }
        }

        /// Kills the master and starts it again. How long it takes until it listens, and until it has committed a generation
        /// more; none if the run was over first.
        fn kill(&mut self) -> Option<[Duration; 2]> {
            self.master.signal(Signal::KILL);
            wait_until("the master's end", || (!self.master.is_running()).then_some(()));
            let before = self.place.generations();
            let begin = Instant::now();
            self.master = serve(&self.place, self.port);
            let _address = self.master.address();
            let listening = begin.elapsed();
            let again = wait_until("a generation more", || {
                let on = self.place.generations() > before;
                (on || !self.master.is_running()).then_some(on)
            });
            again.then(|| [listening, begin.elapsed()])
        }

        /// Waits for the end. Seconds that the workers have simulated, and the digests.
        fn end(self) -> (f64, Vec<String>) {
            self.master.end().done();
            let simulated = |worker: Running| {
                let reported = worker.end().done().stderr;
                let last =
                    reported.lines().find(|line| line.contains("a slot ends")).expect("its last words");
                let value = last.split("simulated_ms=").nth(1).and_then(|rest| rest.split(' ').next());
                value.and_then(|value| value.parse::<f64>().ok()).expect("a time") / 1e3
            };
            let simulated = self.workers.into_iter().map(simulated).sum();
            let digests = self.place.ask(&format!("digest {EXPERIMENT}"));
            (simulated, digests.iter().map(|line| line["sha256"].to_string()).collect())
        }
    }

    fn serve(place: &Place, port: u16) -> Running {
        place.start(&format!("serve e.toml --dashboard off --listen 127.0.0.1:{port}"))
    }

    pub(super) fn main() {
        let kills = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(12);
        // Finding the program may build it.
        Place::new().run("--version").done();
        let (alone, expected) = Site::new().end();

        let mut site = Site::new();
        let mut times = Vec::new();
        for kill in 0..kills {
            sleep(Duration::from_millis(1500 + 700 * (kill % 5)));
            match site.kill() {
                Some(time) => times.push(time),
                None => break,
            }
        }
        let (disturbed, digests) = site.end();
        assert_eq!(digests, expected, "the history is another one");
        println!("master killed and started again {} times; the history is the same", times.len());
        for (at, what) in ["it listens", "the next generation is committed"].into_iter().enumerate() {
            let mut seconds: Vec<f64> = times.iter().map(|time| time[at].as_secs_f64()).collect();
            seconds.sort_by(f64::total_cmp);
            let (median, worst) = (seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
            println!("until {what}: median {median:.2} s, worst {worst:.2} s");
        }
        println!("simulated: {alone:.1} s undisturbed, {disturbed:.1} s in all with the kills");
        println!("work done twice, a kill: {:.2} s", (disturbed - alone) / times.len() as f64);
    }
}
