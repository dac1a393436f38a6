//! MOVE-TO-TARGET: a distant object is fetched and carried to the target.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View};
use crate::experiment::MoveToTarget;

pub(super) fn conditions(settings: &MoveToTarget, view: &View<'_>) -> [Condition; 1] {
    [Condition::below(Quantity::ObjectToTarget, view.object_to_target(), settings.goal_distance)]
}

/// There is nothing to grade in a state: what is rewarded on the way to the goal is that the object has been lifted,
/// and where attention is.
pub(super) fn judge(settings: &MoveToTarget, view: &View<'_>) -> Judgement {
    Judgement { reward: 1.0, goal: reached(&conditions(settings, view)) }
}
