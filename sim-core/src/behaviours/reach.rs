//! REACH: the palm comes close to the top of the object.

use super::{Judgement, View, graded_alignment, near};
use crate::experiment::Reach;

pub(super) fn judge(settings: &Reach, view: &View<'_>) -> Judgement {
    let distance = view.palm_to_object();
    let closeness = near(&settings.near, distance);
    let weight = settings.near_weight;
    Judgement {
        reward: weight * closeness + (1.0 - weight) * graded_alignment(view.alignment()),
        goal: distance < settings.goal_distance,
    }
}
