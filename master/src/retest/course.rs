//! How a trial went, as far as its goal is concerned, and in words why it was no success.

use std::fmt::Write;

use selftalk_sim::behaviours::{Bound, Condition, Quantity};
use selftalk_sim::physics::TOUCH_SENSOR_NAMES;
use selftalk_sim::{Behaviour, Experiment, Frame, Trace, scene};

use super::words::{apart, in_words, number};

/// An object that moved less than this is not said to have moved, m.
const MOVED: f64 = 0.01;
/// Cosine of the angle up to which an object counts as upright: 30 degrees.
const UPRIGHT: f64 = 0.866;

/// A trial, step by step.
#[derive(Debug, Clone, Copy)]
pub struct Course<'a> {
    experiment: &'a Experiment,
    behaviour: Behaviour,
    trace: &'a Trace,
}

impl<'a> Course<'a> {
    /// The course of a trial of this behaviour.
    #[must_use]
    pub const fn new(experiment: &'a Experiment, behaviour: Behaviour, trace: &'a Trace) -> Self {
        Self { experiment, behaviour, trace }
    }

    /// The most control steps for which the goal held without a break.
    #[must_use]
    pub fn held(&self) -> u32 {
        self.longest().1
    }

    /// Share of the control steps in which attention was on what the behaviour is about.
    #[must_use]
    pub fn focus(&self) -> f64 {
        let frames = &self.trace.frames;
        frames.iter().filter(|frame| frame.focused).count() as f64 / frames.len().max(1) as f64
    }

    /// What the goal asks for and was not so at any step.
    #[must_use]
    pub fn lacking(&self) -> Vec<Quantity> {
        let last = self.trace.frames.last().map_or(&[][..], |frame| &frame.conditions);
        let never = |quantity: &Quantity| !self.of(*quantity).any(|(_, condition)| condition.holds());
        last.iter().map(|condition| condition.quantity).filter(never).collect()
    }

    /// The best that a quantity came to, and after how many steps.
    #[must_use]
    pub fn best(&self, quantity: Quantity) -> Option<(u32, Condition)> {
        self.of(quantity)
            .filter(|(_, condition)| condition.value.is_finite())
            .min_by(|(_, a), (_, b)| a.shortfall().total_cmp(&b.shortfall()))
    }

    /// Where the thing whose distance a quantity is was at its best, seen from where it should have been.
    pub(super) fn miss(&self, quantity: Quantity) -> Option<[f64; 3]> {
        let (step, _) = self.best(quantity)?;
        let frame = self.trace.frames.get(step as usize - 1)?;
        apart(quantity, &frame.observation, self.trace.target)
    }

    /// Why the trial was no success; nothing if it was one.
    #[must_use]
    pub fn reason(&self) -> String {
        let mut parts = Vec::new();
        match self.trace.frames.last() {
            _ if self.trace.outcome.success => return String::new(),
            Some(last) if last.observation.is_finite() => {
                parts.push(self.nearest_to_the_goal());
                parts.extend(self.bests());
                parts.extend(self.touched());
                parts.extend(self.shoved());
                parts.extend(self.dropped());
                parts.extend(self.end());
                if self.focus() < 0.9 {
                    let thing = match self.behaviour {
                        Behaviour::Move => "target",
                        Behaviour::MoveToTarget => "right thing",
                        _ => "object",
                    };
                    parts
                        .push(format!("focus on the {thing} for {:.0} % of the trial", 100.0 * self.focus()));
                }
            }
            _ => parts
                .push(format!("the simulation left the finite numbers in step {}", self.trace.outcome.steps)),
        }
        parts.join("; ")
    }

    /// A quantity at every step; steps are counted from 1 here: what is seen after the first.
    fn of(&self, quantity: Quantity) -> impl Iterator<Item = (u32, Condition)> {
        let find = move |frame: &Frame| {
            frame.conditions.iter().copied().find(|condition| condition.quantity == quantity)
        };
        (1..).zip(&self.trace.frames).filter_map(move |(step, frame)| Some((step, find(frame)?)))
    }

    /// The longest time for which the goal held: its last step, and how long it was.
    fn longest(&self) -> (u32, u32) {
        let mut longest = (0, 0);
        let mut held = 0;
        for (step, frame) in (1..).zip(&self.trace.frames) {
            held = if frame.goal { held + 1 } else { 0 };
            if held > longest.1 {
                longest = (step, held);
            }
        }
        longest
    }

    /// The step at which the conditions fell short least, all together.
    fn nearest(&self) -> Option<(u32, &Frame)> {
        let short = |frame: &Frame| frame.conditions.iter().map(relative_shortfall).sum::<f64>();
        (1..).zip(&self.trace.frames).min_by(|(_, a), (_, b)| short(a).total_cmp(&short(b)))
    }

    /// How near the goal was: for how long it held, or what it lacked when it was nearest.
    fn nearest_to_the_goal(&self) -> String {
        let Some((step, frame)) = self.nearest() else { return String::new() };
        let (until, held) = self.longest();
        if held > 0 {
            let wanted = self.experiment.trials.hold;
            let after = self.trace.frames.get(until as usize);
            let lost = after
                .map_or(&[][..], |frame| &frame.conditions)
                .iter()
                .filter(|condition| !condition.holds());
            let lost: Vec<String> = lost.map(|condition| in_words(condition, None)).collect();
            let then = if lost.is_empty() { "the trial was over".to_owned() } else { lost.join(", ") };
            return format!("the goal held for {held} of {wanted} steps, until step {until}, then {then}");
        }
        let target = self.trace.target;
        let words =
            frame.conditions.iter().map(|condition| in_words(condition, Some((&frame.observation, target))));
        format!("nearest to the goal at step {step}: {}", words.collect::<Vec<_>>().join(", "))
    }

    /// What each of several conditions came to at best, if it never held, and was better than nearest to the goal.
    fn bests(&self) -> Vec<String> {
        let lacking = self.lacking();
        let alone = self.trace.frames.last().is_none_or(|frame| frame.conditions.len() < 2);
        if alone || self.held() > 0 {
            return Vec::new();
        }
        if lacking.is_empty() {
            return vec!["each held at some step, but never together".to_owned()];
        }
        let nearest = self.nearest().map(|(step, _)| step);
        let best = |quantity: Quantity| {
            let (step, condition) = self.best(quantity).filter(|(step, _)| Some(*step) != nearest)?;
            Some(format!("{} at best {}, step {step}", quantity.name(), number(quantity, condition.value)))
        };
        lacking.into_iter().filter_map(best).collect()
    }

    /// Where the distance was at the end, if it is all that counts and had been smaller.
    fn end(&self) -> Option<String> {
        if !matches!(self.behaviour, Behaviour::Reach | Behaviour::Move | Behaviour::MoveToTarget) {
            return None;
        }
        let condition = self.trace.frames.last()?.conditions.first()?;
        let (step, _) = self.best(condition.quantity)?;
        let ended = (step as usize) < self.trace.frames.len();
        ended.then(|| format!("{} at the end", number(condition.quantity, condition.value)))
    }

    /// Which sensors ever touched the object that is to be grasped.
    fn touched(&self) -> Option<String> {
        if !matches!(self.behaviour, Behaviour::Grasp | Behaviour::MoveToTarget) {
            return None;
        }
        let touched = |sensor: usize| self.trace.frames.iter().any(|frame| frame.observation.touch[sensor]);
        let sensors = (0..).zip(TOUCH_SENSOR_NAMES).filter(|(at, _)| touched(*at));
        let names: Vec<&str> = sensors.map(|(_, name)| name).collect();
        Some(if names.is_empty() {
            "nothing touched the object".to_owned()
        } else {
            format!("touched by {}", names.join(", "))
        })
    }

    /// How far an object that stood on the table was moved, if it was.
    pub(super) fn shoved(&self) -> Option<String> {
        if self.behaviour == Behaviour::Move {
            return None;
        }
        let end = &self.trace.frames.last()?.observation;
        let [x, y, z] = [0, 1, 2].map(|axis| end.object[axis] - self.trace.start.object[axis]);
        let along = (x * x + y * y).sqrt();
        let mut words = String::new();
        if along > MOVED {
            let _ = write!(words, "object pushed {along:.3} m away");
        }
        if z > MOVED {
            let _ = write!(words, "{}object lifted {z:.3} m", if words.is_empty() { "" } else { ", " });
        }
        if end.upright() < UPRIGHT {
            let _ = write!(words, "{}object tipped over", if words.is_empty() { "" } else { ", " });
        }
        (!words.is_empty()).then_some(words)
    }

    /// When the hand lost the object it had, if it did.
    pub(super) fn dropped(&self) -> Option<String> {
        if self.behaviour != Behaviour::Move {
            return None;
        }
        let frames = &self.trace.frames;
        let touches = |frame: &Frame| frame.observation.touch.iter().any(|touch| *touch);
        let lies = |frame: &Frame| frame.observation.object[2] - scene::OBJECT_STANDING < MOVED;
        let last = frames.last()?;
        if !touches(last) {
            let until = frames.iter().rposition(touches).map_or(0, |at| at + 1);
            let ground = if lies(last) { "" } else { ", still falling at the end" };
            return Some(format!("object dropped at step {}{ground}", until + 1));
        }
        lies(last).then(|| "object on the table".to_owned())
    }
}

fn relative_shortfall(condition: &Condition) -> f64 {
    let (Bound::Below(bound) | Bound::Above(bound) | Bound::AtLeast(bound)) = condition.bound;
    let size = if bound == 0.0 { 1.0 } else { bound.abs() };
    // What is not a number is as far away as can be.
    let short = condition.shortfall().max(0.0) / size;
    if condition.value.is_nan() { f64::MAX } else { short }
}
