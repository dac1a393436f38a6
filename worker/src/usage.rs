//! What a slot does with its time, for those who look after the speed; no result depends on it.

use std::time::{Duration, Instant};

/// The time that a slot has simulated, and where that lies.
#[derive(Debug, Default)]
pub(crate) struct Usage {
    simulated: Duration,
    /// Begin of the first and end of the last simulation.
    span: Option<(Instant, Instant)>,
}

impl Usage {
    /// Counts what is done in here as simulated.
    pub(crate) fn measure(&mut self, simulate: impl FnOnce()) {
        let begin = Instant::now();
        simulate();
        let end = Instant::now();
        self.simulated += end - begin;
        self.span = Some((self.span.map_or(begin, |(first, _)| first), end));
    }

    /// Share of the time between the first and the last simulation in which there was one; none without any.
    fn share(&self) -> Option<f64> {
        let (first, last) = self.span?;
        Some(self.simulated.as_secs_f64() / (last - first).as_secs_f64().max(f64::MIN_POSITIVE))
    }

    /// Logs it. The benchmark of the whole system reads this line; to be called on the slot's thread.
    pub(crate) fn report(&self) {
        if let Some(share) = self.share() {
            let simulated_ms = self.simulated.as_millis() as u64;
            let on_core_ms = on_core().map(|time| time.as_millis() as u64);
            tracing::debug!(simulated_ms, on_core_ms, share, "a slot ends");
        }
    }
}

/// Time for which this thread has had a core, where the system tells.
fn on_core() -> Option<Duration> {
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    statistics.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_between_simulations_is_not_simulated() {
        let mut usage = Usage::default();
        assert_eq!(usage.share(), None);
        let pause = || std::thread::sleep(Duration::from_millis(20));
        usage.measure(pause);
        assert!((usage.share().unwrap() - 1.0).abs() < 1e-9);
        pause();
        usage.measure(pause);
        let share = usage.share().unwrap();
        assert!(share < 1.0 && usage.simulated >= Duration::from_millis(40), "{share}");
    }
}
