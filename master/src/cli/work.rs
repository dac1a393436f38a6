//! How commands have trials run on this machine.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::exit::{Exit, Failure};
use crate::retest::{Crew, RetestError};

/// So many threads, or one for every core.
pub(super) fn crew(workers: Option<u32>, done: &(dyn Fn() + Sync)) -> Crew<'_> {
    Crew { threads: workers.unwrap_or_else(selftalk_worker::available_cores), done }
}

/// A bar on stderr for so many trials, if that is a terminal.
pub(super) fn bar(trials: u64) -> ProgressBar {
    bar_of(trials, "trials")
}

/// A bar on stderr for so many things, if that is a terminal.
pub(super) fn bar_of(count: u64, things: &str) -> ProgressBar {
    let template = format!("{{wide_bar}} {{human_pos}}/{{human_len}} {things}  {{eta:>4}}");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::with_draw_target(Some(count), ProgressDrawTarget::stderr()).with_style(style)
}

impl From<RetestError> for Failure {
    fn from(error: RetestError) -> Self {
        Self::new(Exit::Unexpected, error)
    }
}
