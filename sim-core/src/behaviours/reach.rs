//! REACH: the palm comes close to the top of the object.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View, graded_alignment, near};
use crate::experiment::Reach;

pub(super) fn conditions(settings: &Reach, view: &View<'_>) -> [Condition; 1] {
    [Condition::below(Quantity::PalmToTop, view.palm_to_object(), settings.goal_distance)]
}

pub(super) fn judge(settings: &Reach, view: &View<'_>) -> Judgement {
    let conditions = conditions(settings, view);
    let [distance] = conditions.map(|condition| condition.value);
    let closeness = near(&settings.near, distance);
    let alignment = graded_alignment(view.alignment(), settings.full_alignment);
    let weight = settings.near_weight;
    let reward = view.standing() * (weight * closeness + (1.0 - weight) * alignment);
    Judgement { reward, goal: reached(&conditions) }
}
