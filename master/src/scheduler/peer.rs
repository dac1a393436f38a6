//! What the scheduler knows of a connected worker.

use std::collections::BTreeMap;

use selftalk_proto::UnitKey;

/// A connected worker and what it holds.
#[derive(Debug)]
pub(super) struct Peer {
    /// Its process.
    pub(super) instance: u64,
    /// When it was last heard.
    pub(super) heard_ms: u64,
    slots: u32,
    /// The units it holds, with their batch and whether they are suspect.
    held: BTreeMap<UnitKey, (u64, bool)>,
    /// Units left of each batch.
    batches: BTreeMap<u64, usize>,
    suspects: usize,
    next_batch: u64,
}

impl Peer {
    pub(super) fn new(instance: u64, slots: u32, now_ms: u64) -> Self {
        Self {
            instance,
            heard_ms: now_ms,
            slots,
            held: BTreeMap::new(),
            batches: BTreeMap::new(),
            suspects: 0,
            next_batch: 0,
        }
    }

    pub(super) fn slots(&self) -> usize {
        self.slots as usize
    }

    pub(super) fn held(&self) -> impl DoubleEndedIterator<Item = UnitKey> {
        self.held.keys().copied()
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

    /// Takes a batch of units that it does not hold yet.
    pub(super) fn hold(&mut self, keys: &[UnitKey], suspect: bool) {
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
