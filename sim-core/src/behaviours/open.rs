//! OPEN: the fingers are stretched and the palm faces down, close to the top of the object.

use super::goal::{Condition, Quantity, reached};
use super::{Judgement, View, graded_alignment, near, unit};
use crate::experiment::Open;

pub(super) fn conditions(settings: &Open, view: &View<'_>) -> [Condition; 3] {
    [
        Condition::below(Quantity::PalmToTop, view.palm_to_object(), settings.goal_distance),
        Condition::above(Quantity::Extension, 1.0 - view.flexion(), settings.goal_extension),
        Condition::above(Quantity::Alignment, view.alignment(), settings.goal_alignment),
    ]
}

/// The graded reward is the harmonic mean of closeness, extension and squared alignment, so that the term that is
/// worst counts most: a weighted sum lets a hand stay closed over the object.
pub(super) fn judge(settings: &Open, view: &View<'_>) -> Judgement {
    let conditions = conditions(settings, view);
    let [distance, extension, alignment] = conditions.map(|condition| condition.value);
    let alignment = graded_alignment(alignment, settings.full_alignment);
    let terms =
        [near(&settings.near, distance), unit(extension / settings.full_extension), alignment * alignment];
    let reward = if terms.iter().all(|term| *term > 0.0) {
        terms.len() as f64 / terms.iter().map(|term| 1.0 / term).sum::<f64>()
    } else {
        0.0
    };
    Judgement { reward: view.standing() * reward, goal: reached(&conditions) }
}
