//! Recordings in an engine, without the controllers.

use selftalk_sim::physics::{Engine, Placement};

use super::Recording;

/// Replays recordings in all lanes of an engine; returns where the objects end.
pub(crate) fn replay(engine: &mut dyn Engine, recordings: &[Recording]) -> Vec<[f64; 3]> {
    let mut ends = vec![[f64::NAN; 3]; recordings.len()];
    let mut waiting = recordings.iter().enumerate();
    // What each lane replays, and its next control step.
    let mut lanes: Vec<Option<(usize, &Recording, usize)>> = vec![None; engine.lanes()];
    loop {
        for (lane, slot) in lanes.iter_mut().enumerate() {
            if slot.is_none()
                && let Some((number, recording)) = waiting.next()
            {
                let &Recording { angles, object, orientation, .. } = recording;
                engine.place(lane, &Placement { angles, targets: angles, object, orientation });
                *slot = Some((number, recording, 0));
            }
            if let Some((_, recording, step)) = slot {
                engine.command(lane, &recording.commands[*step]);
                *step += 1;
            }
        }
        if lanes.iter().all(Option::is_none) {
            return ends;
        }
        engine.advance();
        for (lane, slot) in lanes.iter_mut().enumerate() {
            if let Some((number, _, _)) =
                slot.take_if(|(_, recording, step)| *step == recording.commands.len())
            {
                ends[number] = engine.observe(lane).object;
            }
        }
    }
}
