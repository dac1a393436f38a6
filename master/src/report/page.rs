//! The page of a report: what came out, beside what the paper reports.

use std::fmt::Write;

use super::rows::{self, AidRow, PairRow, Quantity};
use super::{Condition, Study};
use crate::statistics::median;

/// What the paper reports of a condition (section III).
struct Reported {
    condition: &'static str,
    /// Replications with a robot that succeeds in all trials of post-evaluation.
    perfect: &'static str,
    best: &'static str,
}

const REPORTED: [Reported; 4] = [
    Reported { condition: "C", perfect: "0 of 10", best: "30 of 40" },
    Reported { condition: "LE", perfect: "4 of 10", best: "40 of 40" },
    Reported { condition: "ST", perfect: "8 of 10", best: "40 of 40" },
    Reported { condition: "LST", perfect: "9 of 10", best: "40 of 40" },
];

/// Differences in generalisation that are significant in the paper (section III.E).
const SIGNIFICANT: [(&str, &str); 4] = [("LST", "C"), ("LST", "LE"), ("LST", "ST"), ("ST", "C")];

pub(super) fn page(study: &Study) -> String {
    let mut text = String::from("# Report\n\n## Post-evaluation (the paper's Figure 4)\n\n");
    text.push_str(
        "The best robot of each replication: of the best individuals of all generations the one with most successes in 40 \
         trials without a caretaker.\n\n![Figure 4](figure-4.svg)\n\n",
    );
    text.push_str(
        "| condition | replications | perfect robots | in the paper | best robot | in the paper | median |\n",
    );
    text.push_str("|---|---|---|---|---|---|---|\n");
    for condition in &study.conditions {
        post_line(&mut text, condition);
    }
    text.push_str(
        "\n## Generalisation (the paper's Figure 6)\n\nThe same robots with the object at 7 x 7 places, from 4 initial \
         postures each.\n\n![Figure 6](figure-6.svg)\n\n| condition | median | least | most |\n|---|---|---|---|\n",
    );
    for condition in &study.conditions {
        let values = Quantity::Generalisation.of(condition);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let middle = median(&values).unwrap_or_default();
        let _ = writeln!(text, "| {} | {middle:.1} % | {least:.1} % | {most:.1} % |", condition.label);
    }
    text.push_str(
        "\n## Differences between conditions\n\nTwo-tailed Mann-Whitney U tests, exact, ties by mid-ranks; p corrected \
         after Holm within each test; A12 is the probability that a robot of the first condition does better.\n\n\
         | test | pair | U | p | p (Holm) | A12 | in the paper |\n|---|---|---|---|---|---|---|\n",
    );
    for pair in rows::pairs(study) {
        pair_line(&mut text, &pair);
    }
    let aid = rows::aid(study);
    if !aid.is_empty() {
        aid_section(&mut text, &aid);
    }
    text.push_str("\n## Learning\n\n![Learning curves](curves.svg)\n");
    text
}

fn post_line(text: &mut String, condition: &Condition) {
    let values = Quantity::Post.of(condition);
    let perfect = values.iter().filter(|percent| **percent >= 100.0).count();
    let best =
        condition.robots.iter().map(|robot| robot.post.iter().filter(|trial| trial.success).count()).max();
    let trials = condition.robots.first().map_or(0, |robot| robot.post.len());
    let reported = REPORTED.iter().find(|reported| reported.condition == condition.label);
    let _ = writeln!(
        text,
        "| {} | {} | {perfect} | {} | {} of {trials} | {} | {:.1} % |",
        condition.label,
        condition.robots.len(),
        reported.map_or("", |reported| reported.perfect),
        best.unwrap_or_default(),
        reported.map_or("", |reported| reported.best),
        median(&values).unwrap_or_default(),
    );
}

fn pair_line(text: &mut String, pair: &PairRow) {
    let PairRow { test, a, b, u, p, p_holm, a12 } = pair;
    let significant =
        test == Quantity::Generalisation.name() && SIGNIFICANT.contains(&(a.as_str(), b.as_str()));
    let reported = if significant { "significant" } else { "" };
    let _ = writeln!(text, "| {test} | {a}, {b} | {u} | {p:.4} | {p_holm:.4} | {a12:.2} | {reported} |");
}

fn aid_section(text: &mut String, aid: &[AidRow]) {
    text.push_str(
        "\n## Own labels and the caretaker's\n\nThe robots at the places of generalisation with the caretaker's labels, as \
         in even trials, and without, as in odd ones; steps are medians of the successful trials.\n\n\
         | condition | replication | own | caretaker's | p | steps, own | steps, caretaker's | p |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    let number =
        |value: Option<f64>, digits: usize| value.map_or(String::new(), |value| format!("{value:.digits$}"));
    for row in aid {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            row.condition,
            row.replication,
            row.own_successes,
            row.aided_successes,
            number(row.p_successes, 4),
            number(row.own_steps_to_goal, 1),
            number(row.aided_steps_to_goal, 1),
            number(row.p_steps, 4),
        );
    }
    let lst: Vec<&AidRow> = aid.iter().filter(|row| row.condition == "LST").collect();
    if lst.is_empty() {
        return;
    }
    let better: Vec<_> = lst.iter().filter(|row| row.own_successes > row.aided_successes).collect();
    let faster = better.iter().filter(|row| row.own_steps_to_goal < row.aided_steps_to_goal).count();
    let _ = writeln!(
        text,
        "\nOf the {} LST robots {} do better by their own labels, {faster} of these are faster as well. In the paper 6 of \
         10 do, all of them faster.",
        lst.len(),
        better.len(),
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::rows::tests::condition;

    #[test]
    fn the_page_sets_what_came_out_beside_the_paper() {
        let study = Study { conditions: vec![condition("C", &[10, 30]), condition("LST", &[38, 40])] };
        let text = page(&study);
        for line in [
            "| C | 2 | 0 | 0 of 10 | 30 of 40 | 30 of 40 | 50.0 % |",
            "| LST | 2 | 1 | 9 of 10 | 40 of 40 | 40 of 40 | 97.5 % |",
            "| generalisation | LST, C | 4 | 0.3333 | 0.3333 | 1.00 | significant |",
            "| LST | 1 | 160 | 120 | 0.0000 | 129.5 | 109.5 | 0.0003 |",
            "Of the 2 LST robots 2 do better by their own labels, 0 of these are faster as well. In the paper 6 of 10 do, all \
             of them faster.",
        ] {
            assert!(text.contains(line), "{line}\n{text}");
        }
        assert!(!page(&Study { conditions: vec![condition("C", &[1])] }).contains("Own labels"));
    }
}
