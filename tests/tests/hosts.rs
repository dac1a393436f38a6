//! Master and workers on hosts of their own, with keys, over lines that are slow, lose packets, and are cut and mended.
//!
//! The hosts are network namespaces of this machine, which only root can make, on Linux and with `ip` and `tc` (iproute2).
//! Elsewhere nothing is tested here.

use std::process::Command;
use std::thread::sleep;
use std::time::Duration;

use selftalk_tests::{Place, Running, selftalk, wait_until, worker};

const MASTER: u32 = 1;
const WORKERS: [u32; 2] = [2, 3];

/// What a line does to what is sent over it: the first of these that the kernel knows.
const BAD_LINES: [&str; 2] = ["netem delay 20ms 10ms loss 2%", "tbf rate 2mbit burst 4kb latency 40ms"];

/// Hosts that are connected by a switch.
struct Network {
    name: String,
}

impl Network {
    /// Makes it; none where that cannot be done.
    fn new() -> Option<Self> {
        let network = Self { name: format!("selftalk-{}", std::process::id()) };
        let switch = network.switch();
        if !ip(&format!("netns add {switch}")) {
            return None;
        }
        let mut made = ip(&format!("-n {switch} link add switch type bridge"))
            && ip(&format!("-n {switch} link set switch up"));
        for host in WORKERS.into_iter().chain([MASTER]) {
            let name = network.host(host);
            made = made
                && ip(&format!("netns add {name}"))
                && ip(&format!("-n {switch} link add port{host} type veth peer name line netns {name}"))
                && ip(&format!("-n {switch} link set port{host} master switch up"))
                && ip(&format!("-n {name} addr add {}/24 dev line", address(host)))
                && ip(&format!("-n {name} link set line up"))
                && ip(&format!("-n {name} link set lo up"));
        }
        made.then_some(network)
    }

    fn switch(&self) -> String {
        format!("{}-switch", self.name)
    }

    fn host(&self, number: u32) -> String {
        format!("{}-{number}", self.name)
    }

    /// Makes all lines bad, in both directions; what was done to them, if anything.
    fn spoil(&self) -> Option<&'static str> {
        let spoil = |bad: &&str| {
            WORKERS.into_iter().all(|host| {
                let lines = [(self.switch(), format!("port{host}")), (self.host(host), "line".to_owned())];
                lines
                    .iter()
                    .all(|(host, line)| run("tc", &format!("-n {host} qdisc replace dev {line} root {bad}")))
            })
        };
        BAD_LINES.into_iter().find(spoil)
    }

    /// Cuts the line to a host, or mends it.
    fn set_line(&self, host: u32, state: &str) {
        assert!(ip(&format!("-n {} link set port{host} {state}", self.switch())));
    }

    /// Starts a program on a host, in a place.
    fn start(&self, host: u32, place: &Place, program: &Command, words: &str) -> Running {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.host(host)]).arg(program.get_program());
        command.args(words.split_whitespace()).current_dir(place.path("")).env_remove("RUST_LOG");
        Running::start(command)
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        for host in WORKERS.into_iter().chain([MASTER]) {
            ip(&format!("netns del {}", self.host(host)));
        }
        ip(&format!("netns del {}", self.switch()));
    }
}

fn address(host: u32) -> String {
    format!("10.77.0.{host}")
}

fn ip(words: &str) -> bool {
    run("ip", words)
}

fn run(program: &str, words: &str) -> bool {
    Command::new(program).args(words.split_whitespace()).output().is_ok_and(|output| output.status.success())
}

#[test]
fn hosts_that_are_cut_off_and_come_back_give_the_same_history() {
    let Some(network) = Network::new() else {
        eprintln!("skipped: no network namespaces can be made here");
        return;
    };
    let bad = network.spoil();
    eprintln!("lines: {}", bad.unwrap_or("good ones, as the kernel knows no others"));
    let generations = 50;
    let place = Place::new();
    let small = String::from_utf8(place.read("small.toml")).unwrap();
    place.write("long.toml", small.replace("generations = 12", &format!("generations = {generations}")));
    place.run(&format!("keys init keys --host {}", address(MASTER))).done();

    let at = format!("{}:7700", address(MASTER));
    let serve = format!("serve --listen {at} --keys keys/master --dashboard off --db history.db long.toml");
    let mut master = network.start(MASTER, &place, &selftalk(), &serve);
    assert_eq!(master.address(), at);
    let work = format!("--slots 1 --master https://{at} --keys keys/worker");
    let workers = WORKERS.map(|host| network.start(host, &place, &worker(), &work));
    let reaches = |count| wait_until("generations", || (place.generations() >= count).then_some(()));

    reaches(8);
    let [first, second] = WORKERS;
    network.set_line(first, "down");
    let before = place.generations();
    // The other one does the work: that of the first as well, as far as the master has waited for it.
    reaches(before + 4);
    network.set_line(second, "down");
    // Longer than the master waits for a sign of life.
    sleep(Duration::from_secs(12));
    let lost = place.generations();
    assert!(lost < 2 * generations, "the lines were cut too late");
    network.set_line(first, "up");
    network.set_line(second, "up");
    master.end().done();
    for worker in workers {
        worker.end().done();
    }

    let connections = place.ask("history workers").len();
    assert!(
        connections > WORKERS.len(),
        "nobody was away for long enough to come back: {connections} connections"
    );
    let alone = Place::new();
    alone.run(&format!("run small.toml --set generations={generations}")).done();
    assert_eq!(place.digests(), alone.digests());
}
