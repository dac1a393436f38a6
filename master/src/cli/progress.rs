//! What is shown while a run goes on: a bar for each replication on a terminal, otherwise a line now and then.

use std::io::IsTerminal;
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;

use super::overall::Overall;
use crate::driver::{Board, Standing};
use crate::service::Crew;

/// How often bars are drawn at most.
const REDRAW: Duration = Duration::from_millis(200);
/// How often lines are printed where there is no terminal.
const LINES: Duration = Duration::from_secs(10);
/// More replications than this share the bar of their experiment.
const BARS: usize = 16;

/// The display.
pub(super) struct Progress {
    stop: CancellationToken,
    task: JoinHandle<()>,
}

impl Progress {
    /// Shows a run on stderr until it is finished, and how far the study is that it is part of.
    pub(super) fn show(
        board: watch::Receiver<Board>,
        crew: watch::Receiver<Crew>,
        overall: Option<Overall>,
    ) -> Self {
        let stop = CancellationToken::new();
        let task = if std::io::stderr().is_terminal() {
            tokio::spawn(draw(board, crew, overall, stop.clone()))
        } else {
            tokio::spawn(print(board, crew, overall, stop.clone()))
        };
        Self { stop, task }
    }

    /// Shows the last state and ends the display.
    pub(super) async fn finish(self) {
        self.stop.cancel();
        // The display cannot fail in a way that matters.
        let _ = self.task.await;
    }
}

async fn draw(
    board: watch::Receiver<Board>,
    crew: watch::Receiver<Crew>,
    overall: Option<Overall>,
    stop: CancellationToken,
) {
    let display = MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len}  {msg}  {eta:>4}");
    let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
    let mut bars = Vec::new();
    for row in rows(&board.borrow()) {
        let bar =
            display.add(ProgressBar::new(row.of.into()).with_style(style.clone()).with_prefix(row.name));
        bar.set_position(row.done.into());
        // What an earlier run did says nothing about the time this one takes.
        bar.reset_eta();
        bars.push(bar);
    }
    let plain = ProgressStyle::with_template("{msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    let foot = display.add(ProgressBar::new(0).with_style(plain));
    loop {
        for (bar, row) in bars.iter().zip(rows(&board.borrow())) {
            bar.set_position(row.done.into());
            bar.set_message(row.message);
        }
        foot.set_message(foot_words(&board.borrow(), *crew.borrow(), overall.as_ref()));
        if stop.is_cancelled() {
            break;
        }
        tokio::select! {
            () = sleep(REDRAW) => {}
            () = stop.cancelled() => {}
        }
    }
    foot.finish_and_clear();
    bars.iter().for_each(ProgressBar::abandon);
}

async fn print(
    board: watch::Receiver<Board>,
    crew: watch::Receiver<Crew>,
    overall: Option<Overall>,
    stop: CancellationToken,
) {
    let mut finished: Vec<bool> = board.borrow().standings.iter().map(|standing| standing.finished).collect();
    let mut next = Instant::now() + LINES;
    loop {
        let now = board.borrow().clone();
        for (was, standing) in finished.iter_mut().zip(&now.standings) {
            if standing.finished && !std::mem::replace(was, true) {
                eprintln!(
                    "{}: done, {} generations  {}",
                    name(standing),
                    standing.generations,
                    worth(&[standing])
                );
            }
        }
        if stop.is_cancelled() {
            return;
        }
        if Instant::now() >= next {
            next += LINES;
            if let Some(overall) = &overall {
                eprintln!("{}", overall.of(&now));
            }
            for row in by_experiment(&now).into_iter().filter(|row| row.done < row.of) {
                let (name, message) = (row.name.trim_end(), row.message);
                eprintln!(
                    "{name}: {} of {} generations  {message}  {}",
                    row.done,
                    row.of,
                    workers(*crew.borrow())
                );
            }
        }
        tokio::select! {
            () = sleep(REDRAW) => {}
            () = stop.cancelled() => {}
        }
    }
}

/// What stands below the bars.
fn foot_words(board: &Board, crew: Crew, overall: Option<&Overall>) -> String {
    let study = overall.map(|overall| format!("; {}", overall.of(board)));
    workers(crew) + study.as_deref().unwrap_or_default()
}

/// A line of the display.
#[derive(Debug, PartialEq)]
struct Row {
    name: String,
    done: u32,
    of: u32,
    message: String,
}

fn rows(board: &Board) -> Vec<Row> {
    if board.standings.len() > BARS {
        return by_experiment(board);
    }
    let width = board.standings.iter().map(|standing| name(standing).len()).max().unwrap_or(0);
    let row = |standing: &Standing| Row {
        name: format!("{:width$}", name(standing)),
        done: standing.generations,
        of: if standing.finished { standing.generations } else { standing.of },
        message: worth(&[standing]),
    };
    board.standings.iter().map(row).collect()
}

fn by_experiment(board: &Board) -> Vec<Row> {
    let same = |a: &Standing, b: &Standing| a.experiment == b.experiment;
    let row = |standings: &[Standing]| Row {
        name: standings.first().map(|first| first.experiment.clone()).unwrap_or_default(),
        done: standings.iter().map(|standing| standing.generations).sum(),
        of: standings.iter().map(|s| if s.finished { s.generations } else { s.of }).sum(),
        message: worth(&standings.iter().collect::<Vec<_>>()),
    };
    board.standings.chunk_by(same).map(row).collect()
}

fn name(standing: &Standing) -> String {
    format!("{} {}", standing.experiment, standing.replication)
}

/// The best of the replications' last generations, and the mean of their means.
fn worth(standings: &[&Standing]) -> String {
    let last = || standings.iter().filter_map(|standing| standing.last);
    let Some(best) = last().max_by(|a, b| a.best.total_cmp(&b.best)) else { return String::new() };
    let mean = last().map(|last| last.mean).sum::<f64>() / last().count() as f64;
    let trials = standings.first().map_or(0, |standing| standing.trials);
    format!("best {:.3}  mean {mean:.3}  {:>2} of {trials} trials", best.best, best.successes)
}

fn workers(crew: Crew) -> String {
    match crew {
        Crew { workers: 0, .. } => "waiting for workers".to_owned(),
        Crew { workers: 1, slots: 1 } => "1 worker".to_owned(),
        Crew { workers, slots } if workers == slots => format!("{workers} workers"),
        Crew { workers, slots } => format!("{workers} workers, {slots} slots"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driver::Last;

    fn standing(replication: u32, generations: u32, finished: bool) -> Standing {
        let last = Last { best: 0.5 + f64::from(generations) / 100.0, mean: 0.25, successes: generations };
        Standing {
            experiment: "e".to_owned(),
            replication,
            generations,
            of: 20,
            trials: 16,
            finished,
            last: (generations > 0).then_some(last),
        }
    }

    #[test]
    fn a_replication_that_ended_early_is_full() {
        let board = Board { standings: vec![standing(0, 5, true), standing(1, 0, false)] };
        let rows = rows(&board);
        assert_eq!((rows[0].done, rows[0].of), (5, 5));
        assert_eq!(rows[0].message, "best 0.550  mean 0.250   5 of 16 trials");
        assert_eq!((rows[1].done, rows[1].of, rows[1].message.as_str()), (0, 20, ""));
    }

    #[test]
    fn many_replications_share_a_bar() {
        let board = Board { standings: (0..20).map(|number| standing(number, number, false)).collect() };
        let rows = rows(&board);
        assert_eq!(rows.len(), 1);
        assert_eq!((rows[0].done, rows[0].of), (190, 400));
        assert!(rows[0].message.starts_with("best 0.690  mean 0.250"), "{}", rows[0].message);
    }
}
