//! How long to wait before trying again.

use std::time::Duration;

const FIRST: Duration = Duration::from_millis(100);
const LONGEST: Duration = Duration::from_secs(10);

/// Pauses that double up to a limit, each shortened by a random share of up to a half, so that a thousand workers do
/// not call a restarted master at the same moment.
#[derive(Debug)]
pub(crate) struct Backoff {
    next: Duration,
    random: u64,
}

impl Backoff {
    pub(crate) fn new(seed: u64) -> Self {
        // The generator below stands still at zero.
        Self { next: FIRST, random: seed | 1 }
    }

    pub(crate) fn reset(&mut self) {
        self.next = FIRST;
    }

    pub(crate) fn next_pause(&mut self) -> Duration {
        // Xorshift; only times depend on it.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        let share = (self.random >> 11) as f64 / (1_u64 << 53) as f64;
        let pause = self.next.mul_f64(1.0 - 0.5 * share);
        self.next = (self.next * 2).min(LONGEST);
        pause
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_to_a_limit_and_differ_between_workers() {
        let pauses = |seed| {
            let mut backoff = Backoff::new(seed);
            (0..12).map(|_| backoff.next_pause()).collect::<Vec<_>>()
        };
        let (mine, yours) = (pauses(0x1234_5678_9abc_def1), pauses(0xfedc_ba98_7654_3211));
        assert_ne!(mine, yours);
        for pauses in [mine, yours] {
            assert!(pauses[0] <= FIRST && pauses[0] >= FIRST / 2);
            assert!(pauses[11] <= LONGEST && pauses[11] >= LONGEST / 2);
        }
    }
}
