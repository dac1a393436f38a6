//! MOVE: the object is carried to the target.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View, near};
use crate::experiment::Move;

pub(super) fn conditions(settings: &Move, view: &View<'_>) -> [Condition; 1] {
    [Condition::below(Quantity::ObjectToTarget, view.object_to_target(), settings.goal_distance)]
}

pub(super) fn judge(settings: &Move, view: &View<'_>) -> Judgement {
    let conditions = conditions(settings, view);
    let [distance] = conditions.map(|condition| condition.value);
    let held = view.is_lifted(settings);
    let weight = settings.near_weight;
    Judgement {
        reward: weight * near(&settings.near, distance) + (1.0 - weight) * f64::from(u8::from(held)),
        goal: reached(&conditions),
    }
}
