//! MOVE: the object is carried to the target.

use super::{Judgement, View, near};
use crate::experiment::Move;

pub(super) fn judge(settings: &Move, view: &View<'_>) -> Judgement {
    let distance = view.object_to_target();
    let held = view.touches() >= settings.held_touches && view.height() > settings.held_height;
    let weight = settings.near_weight;
    Judgement {
        reward: weight * near(&settings.near, distance) + (1.0 - weight) * f64::from(u8::from(held)),
        goal: distance < settings.goal_distance,
    }
}
