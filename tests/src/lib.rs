//! Whole-system tests: what is in `tests/` runs the real `selftalk` and `selftalk-worker` as processes.
//!
//! This library starts, watches and ends them. Nothing in it waits for a fixed time: [`wait_until`] looks at what can
//! be observed from outside until it is so.

// This is test code, though the compiler cannot know it.
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)]

mod binaries;
#[cfg(unix)]
mod browser;
mod crooked;
mod disk;
pub mod fuzz;
mod http;
mod outcome;
mod place;
mod process;
mod processor;
pub mod simulation;

use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};

pub use binaries::{cargo, selftalk, worker};
#[cfg(unix)]
pub use browser::Browser;
pub use crooked::{CrookedLine, Manner};
pub use disk::Disk;
pub use http::Page;
pub use outcome::Outcome;
pub use place::{GOLDEN, Place, SMALL};
pub use process::Running;
pub use processor::{processor_time, processor_time_of_children};

/// How long anything may take before a test gives up; generous, as the machine may be busy with other things.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// Asks again and again until there is an answer.
///
/// # Panics
/// After [`PATIENCE`], with what was waited for.
pub fn wait_until<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begin.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A port of this machine that nobody listens on, for a master that has to come back on the same one. No two calls return
/// the same.
///
/// It lies below the range from which the system takes ports of its own accord: otherwise another test could get it
/// while the master is away, or a worker's connection attempts could end up connected to themselves.
///
/// # Panics
/// When there is none.
#[must_use]
pub fn free_port() -> u16 {
    static CALLS: AtomicU16 = AtomicU16::new(0);
    let first = 20_000 + (std::process::id() % 10_000) as u16;
    std::iter::repeat_with(|| first + CALLS.fetch_add(1, Ordering::Relaxed))
        .take_while(|port| *port < 32_000)
        .find(|port| std::net::TcpListener::bind(("127.0.0.1", *port)).is_ok())
        .expect("a free port")
}
