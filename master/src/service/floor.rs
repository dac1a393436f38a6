//! What the workers are at, for whoever shows it.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::Instant;

use crate::store::WorkerId;

/// Rates are those of so many last samples.
const WINDOW: usize = 30;

/// What the workers are at.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Floor {
    /// The connected workers, in the order they came.
    pub workers: Vec<Attendance>,
    /// Units that wait to be given out.
    pub waiting: usize,
    /// Whether an operator has them held back.
    pub paused: bool,
    /// Units that workers hold.
    pub leased: usize,
    /// Units that were evaluated since the master began.
    pub units: u64,
    /// Trials that were run for them.
    pub trials: u64,
}

/// A connected worker.
#[derive(Debug, Clone, PartialEq)]
pub struct Attendance {
    /// Its connection.
    pub worker: WorkerId,
    /// The name it goes by.
    pub name: Arc<str>,
    /// Its machine.
    pub host: Arc<str>,
    /// Threads it runs trials on.
    pub slots: u32,
    /// Units it holds.
    pub units: usize,
    /// Trials it has run since it joined.
    pub trials: u64,
    /// How many a second it runs at present.
    pub trials_per_second: f64,
    /// Time since it was last heard.
    pub silence: Duration,
}

/// What one worker has done, and how fast.
#[derive(Debug)]
pub(super) struct Tally {
    trials: u64,
    samples: VecDeque<(Instant, u64)>,
}

impl Tally {
    pub(super) fn new(now: Instant) -> Self {
        Self { trials: 0, samples: VecDeque::from([(now, 0)]) }
    }

    pub(super) fn add(&mut self, trials: u64) {
        self.trials += trials;
    }

    pub(super) const fn trials(&self) -> u64 {
        self.trials
    }

    /// Notes how many it has done by now.
    pub(super) fn sample(&mut self, now: Instant) {
        if self.samples.len() >= WINDOW {
            self.samples.pop_front();
        }
        self.samples.push_back((now, self.trials));
    }

    /// Trials a second between the first and the last sample; 0 while there is only one.
    pub(super) fn rate(&self) -> f64 {
        let (Some(first), Some(last)) = (self.samples.front(), self.samples.back()) else { return 0.0 };
        let seconds = last.0.saturating_duration_since(first.0).as_secs_f64();
        if seconds > 0.0 { (last.1 - first.1) as f64 / seconds } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_of_the_last_samples() {
        let begin = Instant::now();
        let at = |second: u64| begin + Duration::from_secs(second);
        let mut tally = Tally::new(begin);
        assert_eq!(tally.rate(), 0.0);
        for second in 1..=10 {
            tally.add(16);
            tally.sample(at(second));
        }
        assert_eq!((tally.rate(), tally.trials()), (16.0, 160));
        // A worker that has stopped is slow at once and still in the end.
        (11..=20).for_each(|second| tally.sample(at(second)));
        assert_eq!(tally.rate(), 8.0);
        (21..=60).for_each(|second| tally.sample(at(second)));
        assert_eq!(tally.rate(), 0.0);
    }
}
