//! Giving out units.

use std::collections::VecDeque;

use selftalk_proto::UnitKey;

use super::{Effect, Open, Peer, PeerId, Scheduler};

impl Scheduler {
    /// Gives waiting units to workers that have room, the least busy first.
    pub(super) fn deal(&mut self) {
        if self.waiting == 0 {
            // What is still in the queues has ended or is held.
            self.fresh.clear();
            self.suspects.clear();
            return;
        }
        while let Some(peer) = self.roomiest(|peer| !peer.under_suspicion()) {
            let Some(key) = self.next(true) else { break };
            self.lease(peer, &[key], true);
        }
        let slots: usize = self.peers.values().map(Peer::slots).sum();
        while let Some(peer) = self.roomiest(|_| true) {
            // Small batches towards the end, so that the workers finish together.
            let size = (self.waiting / (4 * slots.max(1))).clamp(1, self.limits.batch.max(1));
            let keys: Vec<UnitKey> = std::iter::from_fn(|| self.next(false)).take(size).collect();
            if keys.is_empty() {
                break;
            }
            self.lease(peer, &keys, false);
        }
    }

    /// Gives units that take long to a second worker if that is idle and nothing is waiting.
    pub(super) fn double_stragglers(&mut self) {
        if self.waiting > 0 || self.open.is_empty() {
            return;
        }
        let mut idle: Vec<PeerId> =
            self.peers.iter().filter(|(_, peer)| peer.idle()).map(|(id, _)| *id).collect();
        if idle.is_empty() {
            return;
        }
        let (now_ms, limit) = (self.now_ms, self.limits.straggler_ms);
        let late = |unit: &Open| unit.holders.len() == 1 && now_ms - unit.leased_ms > limit;
        let mut late: Vec<(u64, UnitKey, bool)> = self
            .open
            .iter()
            .filter(|(_, unit)| late(unit))
            .map(|(key, unit)| (unit.leased_ms, *key, unit.suspect()))
            .collect();
        late.sort_unstable();
        for (_, key, suspect) in late {
            let Some(peer) = idle.pop() else { break };
            self.lease(peer, &[key], suspect);
        }
    }

    fn lease(&mut self, peer: PeerId, keys: &[UnitKey], suspect: bool) {
        let Some(holder) = self.peers.get_mut(&peer) else { return };
        holder.hold(keys, suspect);
        let mut units = Vec::with_capacity(keys.len());
        for key in keys {
            if let Some(unit) = self.open.get_mut(key) {
                unit.holders.push(peer);
                unit.attempts += 1;
                unit.leased_ms = self.now_ms;
                units.push((std::sync::Arc::clone(&unit.work), unit.attempts));
            }
        }
        self.effects.push(Effect::Lease(peer, units));
    }

    /// Takes the next waiting unit out of a queue. A unit changes queues when it becomes suspect or is cleared, and
    /// then is named by both: each unit found in the wrong queue moves on.
    fn next(&mut self, suspect: bool) -> Option<UnitKey> {
        loop {
            let queue: &mut VecDeque<UnitKey> = if suspect { &mut self.suspects } else { &mut self.fresh };
            let key = queue.pop_front()?;
            let Some(unit) = self.open.get_mut(&key).filter(|unit| unit.queued) else { continue };
            if unit.suspect() == suspect {
                unit.queued = false;
                self.waiting -= 1;
                return Some(key);
            }
            if suspect {
                self.fresh.push_front(key);
            } else {
                self.suspects.push_back(key);
            }
        }
    }

    /// The least busy of the workers that have room and are eligible.
    fn roomiest(&self, eligible: impl Fn(&Peer) -> bool) -> Option<PeerId> {
        let mut best: Option<(PeerId, &Peer)> = None;
        for (id, peer) in &self.peers {
            let better = best.is_none_or(|(_, best)| peer.less_busy_than(best));
            if better && peer.has_room(self.limits.batches_a_slot) && eligible(peer) {
                best = Some((*id, peer));
            }
        }
        best.map(|(id, _)| id)
    }
}
