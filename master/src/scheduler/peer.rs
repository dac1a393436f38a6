//! What the scheduler knows of a connected worker.

use std::collections::{BTreeMap, VecDeque};

use selftalk_proto::UnitKey;

use super::Limits;

/// Milliseconds over which a worker's pace is measured, at least.
const MEASURED_MS: u64 = 200;

/// A connected worker and what it holds.
#[derive(Debug)]
pub(super) struct Peer {
    /// Its process.
    pub(super) instance: u64,
    /// When it was last heard.
    pub(super) heard_ms: u64,
    /// Units that others have evaluated while it had them, since its last answer.
    pub(super) missed: u32,
    /// When it was given the first unit since then.
    busy_ms: u64,
    slots: u32,
    /// When it gave its last answers, as many as it has slots.
    answered: VecDeque<u64>,
    /// Its answers in the last so many milliseconds.
    fresh: (u64, u64),
    /// Answers of a slot in a second, as it was seen last; less where it had nothing to do.
    pace: u64,
    /// The units it holds, with their batch and whether they are suspect.
    held: BTreeMap<UnitKey, (u64, bool)>,
    /// Units left of each batch.
    batches: BTreeMap<u64, usize>,
    suspects: usize,
    next_batch: u64,
    /// Messages of no use that were borne with, less those that time has made up for, and when that was.
    useless: u32,
    useless_ms: u64,
}

impl Peer {
    pub(super) fn new(instance: u64, slots: u32, now_ms: u64) -> Self {
        Self {
            instance,
            heard_ms: now_ms,
            missed: 0,
            busy_ms: now_ms,
            slots,
            answered: VecDeque::new(),
            fresh: (0, 0),
            pace: 0,
            held: BTreeMap::new(),
            batches: BTreeMap::new(),
            suspects: 0,
            next_batch: 0,
            useless: 0,
            useless_ms: now_ms,
        }
    }

    pub(super) fn slots(&self) -> usize {
        self.slots as usize
    }

    pub(super) fn held(&self) -> impl DoubleEndedIterator<Item = UnitKey> {
        self.held.keys().copied()
    }

    pub(super) fn holds(&self, key: UnitKey) -> bool {
        self.held.contains_key(&key)
    }

    /// Takes one more message of no use; false if there were too many.
    pub(super) fn bear(&mut self, now_ms: u64, limits: &Limits) -> bool {
        let passed = now_ms.saturating_sub(self.useless_ms);
        let forgiven = passed.saturating_mul(limits.useless_a_second.into()) / 1000;
        if forgiven > 0 {
            self.useless = self.useless.saturating_sub(u32::try_from(forgiven).unwrap_or(u32::MAX));
            self.useless_ms = now_ms;
        }
        self.useless += 1;
        self.useless <= limits.useless
    }

    pub(super) fn idle(&self) -> bool {
        self.held.is_empty()
    }

    pub(super) fn has_room(&self, batches_a_slot: usize) -> bool {
        self.batches.len() < self.slots() * batches_a_slot
    }

    /// Whether it holds a unit that has been lost before.
    pub(super) fn under_suspicion(&self) -> bool {
        self.suspects > 0
    }

    #[cfg(test)]
    pub(super) fn suspects(&self) -> usize {
        self.suspects
    }

    /// Whether its slots have less to do than another's.
    pub(super) fn less_busy_than(&self, other: &Self) -> bool {
        self.held.len() * other.slots() < other.held.len() * self.slots()
    }

    /// It has evaluated a unit that it was given then; returns how long a slot was busy with that, in milliseconds.
    pub(super) fn answers(&mut self, now_ms: u64, leased_ms: u64) -> u64 {
        // What waits in its queue begins when a slot is free: as many answers ago as it has slots.
        let free_ms = (self.answered.len() == self.slots()).then(|| self.answered.pop_front()).flatten();
        self.answered.push_back(now_ms);
        self.fresh.0 += 1;
        (self.missed, self.busy_ms) = (0, now_ms);
        now_ms - leased_ms.max(free_ms.unwrap_or(0))
    }

    /// So many milliseconds have passed since it was last told the time.
    pub(super) fn clock(&mut self, passed_ms: u64) {
        let (answers, ms) = &mut self.fresh;
        *ms += passed_ms;
        if *ms < MEASURED_MS {
            return;
        }
        // A moment in which there was nothing to do does not make it slow.
        self.pace = (1000 * *answers / (*ms * u64::from(self.slots.max(1)))).max(self.pace / 2);
        self.fresh = (0, 0);
    }

    /// Fewest and most units it is given at once: the faster it is the more, as what a message costs is shared by its units.
    pub(super) fn batch(&self, limits: &Limits) -> (usize, usize) {
        let in_time = |ms: u64| {
            let units = usize::try_from(self.pace.saturating_mul(ms) / 1000).unwrap_or(usize::MAX);
            units.clamp(1, limits.largest_batch.max(1))
        };
        let most = in_time(limits.batch_ms).max(limits.batch);
        (in_time(limits.batch_ms / 5).min(most), most)
    }

    /// Whether it has had something to do and not answered for long.
    pub(super) fn stalled(&self, now_ms: u64, limits: &Limits) -> bool {
        !self.idle() && now_ms.saturating_sub(self.busy_ms) >= limits.hanging_ms
    }

    /// Whether it has missed too much for too long, when another one took so long for a unit.
    pub(super) fn hangs(&self, now_ms: u64, took_ms: u64, limits: &Limits) -> bool {
        let limit_ms = limits.hanging_ms.max(10 * took_ms);
        self.missed >= limits.missed && now_ms.saturating_sub(self.busy_ms) >= limit_ms
    }

    /// Takes a batch of units that it does not hold yet.
    pub(super) fn hold(&mut self, keys: &[UnitKey], suspect: bool, now_ms: u64) {
        if self.idle() && self.missed == 0 {
            self.busy_ms = now_ms;
        }
        let batch = self.next_batch;
        self.next_batch += 1;
        for key in keys {
            if self.held.insert(*key, (batch, suspect)).is_none() {
                *self.batches.entry(batch).or_default() += 1;
                self.suspects += usize::from(suspect);
            }
        }
    }

    /// Gives up a unit; false if it did not hold it.
    pub(super) fn release(&mut self, key: UnitKey) -> bool {
        let Some((batch, suspect)) = self.held.remove(&key) else { return false };
        self.suspects -= usize::from(suspect);
        if let Some(left) = self.batches.get_mut(&batch) {
            *left -= 1;
            if *left == 0 {
                self.batches.remove(&batch);
            }
        }
        true
    }
}
