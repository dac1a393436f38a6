//! How far a study is as a whole, and how long it may still take.

use std::time::Duration;

use tokio::time::Instant;

use crate::driver::Board;

/// The part of a study's work that is under way: some experiments, or the tests of some robots.
#[derive(Debug, Clone)]
pub(super) struct Overall {
    /// The work of the whole study, in any unit.
    whole: f64,
    /// What was done when this process began, and what is done now without the part under way.
    at_first: f64,
    before: f64,
    /// The work of the part under way.
    part: f64,
    begun: Instant,
}

impl Overall {
    /// A study of so much work of which some is done.
    pub(super) fn new(whole: f64, done: f64) -> Self {
        Self { whole, at_first: done, before: done, part: 0.0, begun: Instant::now() }
    }

    /// Goes on to a part of so much work; the part before is done.
    pub(super) fn begin(&mut self, part: f64) {
        self.before += self.part;
        self.part = part;
    }

    /// Where the study stands when a share of the part under way is done.
    pub(super) fn words(&self, share: f64) -> String {
        words(self.before + share * self.part, self.at_first, self.whole, self.begun.elapsed())
    }

    /// Where it stands when the part under way is what a board shows.
    pub(super) fn of(&self, board: &Board) -> String {
        self.words(share(board))
    }
}

/// The share of a board's generations that are done.
pub(super) fn share(board: &Board) -> f64 {
    let ends = |standing: &crate::driver::Standing| {
        if standing.finished { standing.generations } else { standing.of }
    };
    let of: u32 = board.standings.iter().map(ends).sum();
    let done: u32 = board.standings.iter().map(|standing| standing.generations).sum();
    if of == 0 { 1.0 } else { f64::from(done) / f64::from(of) }
}

fn words(done: f64, at_first: f64, whole: f64, elapsed: Duration) -> String {
    let percent = 100.0 * (done / whole).clamp(0.0, 1.0);
    let pace = (done - at_first) / elapsed.as_secs_f64();
    // The first moments say nothing about the rest.
    if elapsed < Duration::from_secs(5) || pace <= 0.0 {
        return format!("study {percent:.0} %");
    }
    let minutes = ((whole - done).max(0.0) / pace / 60.0).ceil();
    let (hours, minutes) = ((minutes / 60.0).floor(), minutes % 60.0);
    let left = if hours > 0.0 { format!("{hours} h {minutes} min") } else { format!("{minutes} min") };
    format!("study {percent:.0} %, about {left} left")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_at_the_pace_since_the_process_began() {
        let seconds = Duration::from_secs;
        assert_eq!(words(10.0, 10.0, 100.0, seconds(60)), "study 10 %");
        assert_eq!(words(20.0, 10.0, 100.0, seconds(1)), "study 20 %");
        assert_eq!(words(20.0, 10.0, 100.0, seconds(60)), "study 20 %, about 8 min left");
        assert_eq!(words(20.0, 10.0, 100.0, seconds(600)), "study 20 %, about 1 h 20 min left");
        assert_eq!(words(100.0, 10.0, 100.0, seconds(600)), "study 100 %, about 0 min left");
    }

    #[test]
    fn parts_follow_each_other() {
        let mut overall = Overall::new(10.0, 2.0);
        overall.begin(4.0);
        assert_eq!(overall.words(0.5), "study 40 %");
        overall.begin(4.0);
        assert_eq!(overall.words(0.0), "study 60 %");
    }
}
