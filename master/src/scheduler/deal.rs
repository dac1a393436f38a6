//! Giving out units.

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
        self.deal_suspects();
        let slots: usize = self.peers.values().map(Peer::slots).sum();
        while let Some(peer) = self.roomiest(|_| true) {
            // Small batches towards the end, so that the workers finish together.
            let (least, most) = self.peers.get(&peer).map_or((1, 1), |peer| peer.batch(&self.limits));
            let size = (self.waiting / (4 * slots.max(1))).clamp(least, most);
            let keys: Vec<UnitKey> = std::iter::from_fn(|| self.next()).take(size).collect();
            if keys.is_empty() {
                break;
            }
            self.lease(peer, &keys, false);
        }
    }

    /// Gives each suspect unit to a worker that holds no other, and has not failed at it as long as there is one that
    /// has not.
    fn deal_suspects(&mut self) {
        for key in std::mem::take(&mut self.suspects) {
            let Some(unit) = self.open.get(&key).filter(|unit| unit.queued) else { continue };
            if !unit.suspect() {
                // Cleared meanwhile.
                self.fresh.push_front(key);
                continue;
            }
            let untried = self.peers.values().any(|peer| unit.is_new_to(peer));
            let eligible = |peer: &Peer| !peer.under_suspicion() && (unit.is_new_to(peer) || !untried);
            match self.roomiest(eligible) {
                Some(peer) => {
                    self.take(key);
                    self.lease(peer, &[key], true);
                }
                None => self.suspects.push_back(key),
            }
        }
    }

    /// Gives units that take long to a second worker if that is idle and nothing is waiting, and to yet another one after
    /// twice as long: those who have them may all hang.
    ///
    /// While something is waiting, workers go on with that, and only units of those that have stalled are doubled: their
    /// generations would otherwise wait until everything else has ended.
    pub(super) fn double_stragglers(&mut self) {
        if self.paused || self.open.is_empty() {
            return;
        }
        let stalled = |peer: &Peer| peer.stalled(self.now_ms, &self.limits);
        let busy = self.waiting > 0;
        if busy && !self.peers.values().any(stalled) {
            return;
        }
        let free = |peer: &Peer| if busy { !stalled(peer) } else { peer.idle() };
        let mut takers: Vec<PeerId> =
            self.peers.iter().filter(|(_, peer)| free(peer)).map(|(id, _)| *id).collect();
        if takers.is_empty() {
            return;
        }
        // Those who have not answered for the longest are asked last.
        takers.sort_by_key(|id| std::cmp::Reverse(self.peers.get(id).map_or(0, |peer| peer.missed)));
        let (now_ms, limit) = (self.now_ms, self.limits.straggler_ms);
        let overdue = |unit: &Open| match unit.holders.len() {
            0 => false,
            count => now_ms - unit.leased_ms > limit << (count - 1).min(16),
        };
        let held_up = |unit: &Open| unit.holders.iter().all(|id| self.peers.get(id).is_none_or(stalled));
        let late = |unit: &Open| overdue(unit) && (!busy || held_up(unit));
        let mut late: Vec<(u64, UnitKey, bool)> = self
            .open
            .iter()
            .filter(|(_, unit)| late(unit))
            .map(|(key, unit)| (unit.leased_ms, *key, unit.suspect()))
            .collect();
        late.sort_unstable();
        for (_, key, suspect) in late {
            let able = |peer: &PeerId| match (self.open.get(&key), self.peers.get(peer)) {
                (Some(unit), Some(peer)) => unit.is_new_to(peer) && !(suspect && peer.under_suspicion()),
                _ => false,
            };
            let Some(place) = takers.iter().rposition(able) else { continue };
            let peer = takers.remove(place);
            self.lease(peer, &[key], suspect);
        }
    }

    fn lease(&mut self, peer: PeerId, keys: &[UnitKey], suspect: bool) {
        let Some(holder) = self.peers.get_mut(&peer) else { return };
        holder.hold(keys, suspect, self.now_ms);
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

    /// Takes the next unit that waits and is not suspect. A unit changes queues when it becomes suspect or is cleared, and
    /// then is named by both: each one that is found in the wrong queue moves on.
    fn next(&mut self) -> Option<UnitKey> {
        loop {
            let key = self.fresh.pop_front()?;
            let Some(unit) = self.open.get(&key).filter(|unit| unit.queued) else { continue };
            if !unit.suspect() {
                self.take(key);
                return Some(key);
            }
            self.suspects.push_back(key);
        }
    }

    /// A unit waits no more.
    fn take(&mut self, key: UnitKey) {
        if let Some(unit) = self.open.get_mut(&key) {
            self.waiting -= usize::from(std::mem::take(&mut unit.queued));
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
