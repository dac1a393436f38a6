//! OPEN: the fingers are stretched and the palm faces down, close to the top of the object.

use super::{Judgement, View, graded_alignment, near, unit};
use crate::experiment::Open;

/// The graded reward is the harmonic mean of closeness, extension and squared alignment, so that the term that is
/// worst counts most: a weighted sum lets a hand stay closed over the object.
pub(super) fn judge(settings: &Open, view: &View<'_>) -> Judgement {
    let distance = view.palm_to_object();
    let extension = 1.0 - view.flexion();
    let alignment = graded_alignment(view.alignment());
    let terms =
        [near(&settings.near, distance), unit(extension / settings.goal_extension), alignment * alignment];
    let reward = if terms.iter().all(|term| *term > 0.0) {
        terms.len() as f64 / terms.iter().map(|term| 1.0 / term).sum::<f64>()
    } else {
        0.0
    };
    let goal = distance < settings.goal_distance
        && extension > settings.goal_extension
        && view.alignment() > settings.goal_alignment;
    Judgement { reward, goal }
}
