//! A master among peers that do everything wrong at once: it goes on, and those are cut off.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use selftalk_tests::{GOLDEN, Place, SMALL, wait_until};

/// Peers that are at it. They end when this is dropped.
struct Peers(Child);

impl Peers {
    /// Lets them loose on a master; none where there is no Python with grpcio.
    fn start(address: &str) -> Option<Self> {
        let python = std::env::var_os("SELFTALK_PYTHON").unwrap_or_else(|| "python3".into());
        let there = Command::new(&python).args(["-c", "import grpc"]).output();
        if !there.is_ok_and(|output| output.status.success()) {
            return None;
        }
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/hostile.py");
        let fingerprint = selftalk_sim::fingerprint().unwrap();
        let mut command = Command::new(python);
        command.args([script, address, &fingerprint]);
        let child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        Some(Self(child))
    }

    /// Waits until all are at it.
    fn ready(&mut self) {
        let stdout = BufReader::new(self.0.stdout.take().unwrap());
        let ready = stdout.lines().map_while(Result::ok).any(|line| line == "ready");
        assert!(ready, "the peers ended before they were at it");
    }
}

impl Drop for Peers {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn peers_that_do_everything_wrong_are_cut_off_and_the_run_goes_on() {
    let place = Place::new();
    // Those that hang are found out after a while; there is something to do until then.
    place.write(
        "endless.toml",
        SMALL.replace("small", "endless").replace("generations = 12", "generations = 1000000"),
    );
    let mut master = place.start("serve --listen 127.0.0.1:0 small.toml endless.toml");
    let address = master.address();
    let Some(mut peers) = Peers::start(&address) else {
        eprintln!("skipped: no Python with grpcio; SELFTALK_PYTHON may name one");
        return;
    };
    peers.ready();
    let worker = place.start_worker(&address);
    for (name, why) in [("flood", "Flooding"), ("hang", "Hanging"), ("stall", "Hanging")] {
        let cut = |line: &str| line.contains("worker cut off") && line.contains(name) && line.contains(why);
        wait_until(name, || master.reported().lines().any(cut).then_some(()));
    }
    wait_until("the history of the experiment that ends", || (place.digests() == GOLDEN).then_some(()));
    assert!(worker.kill() && master.kill());
}
