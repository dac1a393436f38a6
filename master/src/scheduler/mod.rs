//! Which worker evaluates which unit, and when: a pure state machine. Events go in, effects come out; there are no
//! sockets, no clock and no randomness in here.
//!
//! Units are given out in the order in which they were submitted, generation after generation. A replication has one
//! generation under way, so each gets its turn, and while one is selected and stored the others keep the workers busy.
//!
//! A unit is open until the first answer of a connected worker, whoever gives it and however late: units are pure
//! functions, so all answers are equal. Whether they are is looked into, see `audit.rs`. The unit of a lost worker is
//! given out again. As a unit may have been the cause, it is *suspect* from then on: a worker never holds two suspects,
//! so that a unit that kills workers cannot drag the same neighbours along again and again, and after [`Limits::losses`]
//! workers it is set aside. A worker that comes back after a cut line was not killed, and clears the units it held. One
//! that says it cannot evaluate a unit may be the cause itself: it gets that unit again only when all others have failed.

mod audit;
mod deal;
mod event;
mod peer;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::sync::Arc;

use selftalk_proto::UnitKey;
use selftalk_sim::TrialOutcome;

use audit::Ledger;
pub use audit::{Claim, Place};
pub use event::{Cut, Effect, Event, PeerId, Verdict, Work};
use peer::Peer;

/// The scheduler's settings. None of them can change a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Most units in a batch for a worker that is not fast.
    pub batch: usize,
    /// Milliseconds of a slot's work that a batch for a fast worker comes to; a fifth of it where little is left.
    pub batch_ms: u64,
    /// Most units in any batch.
    pub largest_batch: usize,
    /// Batches that a worker holds for each of its slots: one under way, the others waiting.
    pub batches_a_slot: usize,
    /// Workers a unit may be lost with before it is set aside.
    pub losses: u32,
    /// Milliseconds without a word after which a worker is taken for lost.
    pub silence_ms: u64,
    /// Milliseconds after which a unit is given to a second worker if that has nothing else to do, and after twice as many
    /// more to a third.
    pub straggler_ms: u64,
    /// Milliseconds without an answer after which a worker is taken to be hanging, if others have had to evaluate ...
    pub hanging_ms: u64,
    /// ... so many of the units that it was given meanwhile, and needed less than a tenth of that time for the last one: slow
    /// machines do not hang.
    pub missed: u32,
    /// Messages of no use that a worker may send at once: signs of life, and answers that nobody waits for.
    pub useless: u32,
    /// How many more of them each second.
    pub useless_a_second: u32,
    /// Share of answers that the master evaluates again, 0 to 1.
    pub audit_share: f64,
    /// Makes unforeseeable which.
    pub audit_secret: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            batch: 4,
            batch_ms: 25,
            largest_batch: 64,
            batches_a_slot: 2,
            losses: 5,
            silence_ms: 10_000,
            straggler_ms: 3_000,
            hanging_ms: 30_000,
            missed: 4,
            useless: 2_000,
            useless_a_second: 100,
            audit_share: 0.0,
            audit_secret: 0,
        }
    }
}

/// What a connected worker has in hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Load {
    /// Units it holds.
    pub units: usize,
    /// Milliseconds since it was last heard, as exactly as ticks come.
    pub silent_ms: u64,
}

/// A unit that has not ended.
#[derive(Debug)]
struct Open {
    work: Arc<Work>,
    /// Workers that have it now: none, one, or more when it is a straggler.
    holders: Vec<PeerId>,
    /// Whether it waits to be given out.
    queued: bool,
    attempts: u32,
    /// When it was last given out.
    leased_ms: u64,
    /// Processes that were lost while they held it.
    blamed: Vec<u64>,
    /// Processes that said they could not evaluate it, each as often as it did.
    failed: Vec<u64>,
    reason: Option<String>,
}

impl Open {
    fn losses(&self) -> u32 {
        (self.failed.len() + self.blamed.len()) as u32
    }

    /// Processes that it was lost with.
    fn losers(&self) -> u32 {
        let failed: BTreeSet<&u64> = self.failed.iter().collect();
        (failed.len() + self.blamed.len()) as u32
    }

    /// Whether a worker has yet to show whether it can evaluate it.
    fn is_new_to(&self, peer: &Peer) -> bool {
        !self.failed.contains(&peer.instance)
    }

    fn suspect(&self) -> bool {
        self.losses() > 0
    }
}

/// The state machine.
#[derive(Debug, Default)]
pub struct Scheduler {
    limits: Limits,
    now_ms: u64,
    peers: BTreeMap<PeerId, Peer>,
    open: HashMap<UnitKey, Open>,
    /// Units that wait, first come first served. May name units that have ended or are held meanwhile.
    fresh: VecDeque<UnitKey>,
    /// Suspect units that wait. May name units that have ended or are held meanwhile.
    suspects: VecDeque<UnitKey>,
    /// Units that wait, exactly.
    waiting: usize,
    ledger: Ledger,
    /// Processes that sent signs of life and no answers.
    hanging: BTreeSet<u64>,
    /// Whether units are held back.
    paused: bool,
    effects: Vec<Effect>,
}

impl Scheduler {
    /// A scheduler without units and workers.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        let ledger = Ledger::new(limits.audit_share, limits.audit_secret);
        Self { limits, ledger, ..Self::default() }
    }

    /// Takes note of an event.
    pub fn handle(&mut self, event: Event) {
        match event {
            Event::Submitted(works) => works.into_iter().for_each(|work| self.submit(work)),
            Event::Joined { peer, instance, slots, holds } => self.join(peer, instance, slots, holds),
            Event::Left(peer) => self.remove(peer, false),
            Event::Lost(peer) => self.remove(peer, true),
            Event::Heard(peer) => self.bear(peer),
            Event::Stalled(peer) => self.disconnect(peer, Cut::Stalled, false),
            Event::Answered(peer, key, outcomes) => self.answer(peer, key, outcomes),
            Event::Failed(peer, key, reason) => self.fail(peer, key, reason),
            Event::Audited { instance, serial, right: true } => {
                if self.ledger.right(instance, serial) {
                    self.effects.push(Effect::Cleared(instance));
                }
            }
            Event::Audited { instance, right: false, .. } => self.expel(instance),
            Event::Paused(paused) => self.paused = paused,
            Event::Closing => {
                let claims = self.ledger.settle_all();
                self.effects.extend(claims.into_iter().map(Effect::Audit));
            }
            Event::Tick(now_ms) => self.tick(now_ms),
        }
    }

    /// Gives out what can be given out and returns everything there is to do since the last call. Any number of
    /// events may lie between two calls.
    #[must_use]
    pub fn settle(&mut self) -> Vec<Effect> {
        if !self.paused {
            self.deal();
        }
        std::mem::take(&mut self.effects)
    }

    /// Units that have not ended.
    #[must_use]
    pub fn open_units(&self) -> usize {
        self.open.len()
    }

    /// Answers that are being evaluated again.
    #[must_use]
    pub fn audits(&self) -> usize {
        self.ledger.pending()
    }

    /// Whether all answers of a process were looked into, by what its last one was, and none was wrong. Never when answers are
    /// not looked into.
    #[must_use]
    pub fn is_clear(&self, instance: u64) -> bool {
        self.ledger.is_clear(instance)
    }

    /// Units that wait to be given out.
    #[must_use]
    pub fn waiting_units(&self) -> usize {
        self.waiting
    }

    /// What a worker has in hand; none if it is not connected.
    #[must_use]
    pub fn load(&self, peer: PeerId) -> Option<Load> {
        let peer = self.peers.get(&peer)?;
        Some(Load { units: peer.held().count(), silent_ms: self.now_ms.saturating_sub(peer.heard_ms) })
    }

    fn submit(&mut self, work: Arc<Work>) {
        let key = work.key;
        if self.open.contains_key(&key) {
            return;
        }
        let unit = Open {
            work,
            holders: Vec::new(),
            queued: false,
            attempts: 0,
            leased_ms: 0,
            blamed: Vec::new(),
            failed: Vec::new(),
            reason: None,
        };
        self.open.insert(key, unit);
        self.enqueue(key, false);
    }

    fn join(&mut self, peer: PeerId, instance: u64, slots: u32, holds: Vec<UnitKey>) {
        if self.ledger.is_expelled(instance) {
            self.effects.push(Effect::Disconnect(peer, Cut::Wrong));
            return;
        }
        if self.hanging.contains(&instance) {
            self.effects.push(Effect::Disconnect(peer, Cut::Hanging));
            self.clear(instance);
            return;
        }
        let earlier = self.peers.iter().find(|(_, other)| other.instance == instance).map(|(id, _)| *id);
        if let Some(earlier) = earlier {
            self.effects.push(Effect::Disconnect(earlier, Cut::Replaced));
            self.remove(earlier, false);
        }
        for unit in self.open.values_mut() {
            unit.blamed.retain(|blamed| *blamed != instance);
        }
        let mut joined = Peer::new(instance, slots, self.now_ms);
        let mut unwanted = Vec::new();
        for key in holds.into_iter().collect::<BTreeSet<_>>() {
            match self.open.get_mut(&key) {
                Some(unit) if unit.holders.is_empty() && !(unit.suspect() && joined.under_suspicion()) => {
                    self.waiting -= usize::from(std::mem::take(&mut unit.queued));
                    unit.holders.push(peer);
                    unit.attempts += 1;
                    unit.leased_ms = self.now_ms;
                    joined.hold(&[key], unit.suspect(), self.now_ms);
                }
                _ => unwanted.push(key),
            }
        }
        self.peers.insert(peer, joined);
        if !unwanted.is_empty() {
            self.effects.push(Effect::Cancel(peer, unwanted));
        }
    }

    /// Forgets a worker; `blame` when what it held may have killed it.
    fn remove(&mut self, peer: PeerId, blame: bool) {
        let Some(gone) = self.peers.remove(&peer) else { return };
        self.effects.extend(self.ledger.settle(gone.instance).map(Effect::Audit));
        self.clear(gone.instance);
        // Backwards, as each goes to the front of the queue.
        for key in gone.held().rev() {
            if let Some(unit) = self.open.get_mut(&key) {
                unit.holders.retain(|holder| *holder != peer);
                if blame && !unit.blamed.contains(&gone.instance) {
                    unit.blamed.push(gone.instance);
                }
                self.requeue(key);
            }
        }
    }

    /// Tells if there is nothing to look into of a process that is gone.
    fn clear(&mut self, instance: u64) {
        if self.ledger.is_clear(instance) {
            self.effects.push(Effect::Cleared(instance));
        }
    }

    /// Sends a process away for good and takes back what it has contributed since it was last found right.
    fn expel(&mut self, instance: u64) {
        let peers: Vec<PeerId> =
            self.peers.iter().filter(|(_, peer)| peer.instance == instance).map(|(id, _)| *id).collect();
        let places = self.ledger.wrong(instance);
        for peer in peers {
            self.effects.push(Effect::Disconnect(peer, Cut::Wrong));
            self.remove(peer, false);
        }
        if !places.is_empty() {
            self.effects.push(Effect::Revoke(places));
        }
    }

    fn disconnect(&mut self, peer: PeerId, why: Cut, blame: bool) {
        if self.peers.contains_key(&peer) {
            self.effects.push(Effect::Disconnect(peer, why));
            self.remove(peer, blame);
        }
    }

    fn heard(&mut self, peer: PeerId) {
        if let Some(peer) = self.peers.get_mut(&peer) {
            peer.heard_ms = self.now_ms;
        }
    }

    /// Bears with a message that is of no use beyond being a sign of life, as long as there are not too many of them.
    fn bear(&mut self, id: PeerId) {
        self.heard(id);
        if self.peers.get_mut(&id).is_some_and(|peer| !peer.bear(self.now_ms, &self.limits)) {
            self.disconnect(id, Cut::Flooding, false);
        }
    }

    fn answer(&mut self, peer: PeerId, key: UnitKey, outcomes: Vec<TrialOutcome>) {
        self.heard(peer);
        // Of one that is not connected any more it could not be told who it was. It says it again when it is back.
        let Some(instance) = self.peers.get(&peer).map(|peer| peer.instance) else { return };
        let Some(unit) = self.open.get(&key) else { return self.bear(peer) };
        let expected = unit.work.trials.len();
        if outcomes.len() != expected {
            let reason = format!("{} outcomes for {expected} trials", outcomes.len());
            return self.fail(peer, key, reason);
        }
        let leased_ms = unit.leased_ms;
        let took_ms = self.peers.get_mut(&peer).map_or(0, |peer| peer.answers(self.now_ms, leased_ms));
        let claim = self.ledger.note(instance, &unit.work, &outcomes);
        self.effects.extend(claim.map(Effect::Audit));
        self.end(key, Some((peer, took_ms)), Verdict::Evaluated { by: peer, outcomes });
    }

    fn fail(&mut self, peer: PeerId, key: UnitKey, reason: String) {
        self.heard(peer);
        let holder = self.peers.get_mut(&peer).filter(|peer| peer.holds(key));
        let instance = holder.map(|holder| {
            holder.release(key);
            holder.instance
        });
        let (Some(unit), Some(instance)) = (self.open.get_mut(&key), instance) else {
            return self.bear(peer);
        };
        unit.holders.retain(|holder| *holder != peer);
        unit.failed.push(instance);
        unit.reason = Some(reason);
        self.requeue(key);
    }

    /// Queues an open unit again that lost a holder, unless another one is still busy with it.
    fn requeue(&mut self, key: UnitKey) {
        let Some(unit) = self.open.get_mut(&key).filter(|unit| unit.holders.is_empty()) else { return };
        let losses = unit.losses();
        let hopeless = || self.peers.values().all(|peer| !unit.is_new_to(peer));
        if unit.losers() >= self.limits.losses || losses >= self.limits.losses && hopeless() {
            let reason = unit.reason.take();
            return self.end(key, None, Verdict::SetAside { losses, reason });
        }
        self.enqueue(key, true);
    }

    fn enqueue(&mut self, key: UnitKey, again: bool) {
        let Some(unit) = self.open.get_mut(&key) else { return };
        self.waiting += usize::from(!std::mem::replace(&mut unit.queued, true));
        match (unit.suspect(), again) {
            (true, _) => self.suspects.push_back(key),
            (false, true) => self.fresh.push_front(key),
            (false, false) => self.fresh.push_back(key),
        }
    }

    /// Closes a unit and tells everyone who still holds it, except the one that answered, `by`, which took so many
    /// milliseconds for it.
    fn end(&mut self, key: UnitKey, by: Option<(PeerId, u64)>, verdict: Verdict) {
        let Some(unit) = self.open.remove(&key) else { return };
        self.waiting -= usize::from(unit.queued);
        let (by, took_ms) = by.map_or((None, 0), |(peer, took_ms)| (Some(peer), took_ms));
        let mut hanging = Vec::new();
        for id in unit.holders {
            let Some(holder) = self.peers.get_mut(&id) else { continue };
            holder.release(key);
            if Some(id) != by {
                holder.missed += 1;
                if holder.hangs(self.now_ms, took_ms, &self.limits) {
                    self.hanging.insert(holder.instance);
                    hanging.push(id);
                }
                self.effects.push(Effect::Cancel(id, vec![key]));
            }
        }
        self.effects.push(Effect::Ended(key, verdict));
        for peer in hanging {
            self.disconnect(peer, Cut::Hanging, false);
        }
    }

    fn tick(&mut self, now_ms: u64) {
        let passed_ms = now_ms.saturating_sub(self.now_ms);
        self.now_ms += passed_ms;
        self.peers.values_mut().for_each(|peer| peer.clock(passed_ms));
        let limit = self.limits.silence_ms;
        let silent = |peer: &Peer| self.now_ms - peer.heard_ms > limit;
        let silent: Vec<PeerId> =
            self.peers.iter().filter(|(_, peer)| silent(peer)).map(|(id, _)| *id).collect();
        for peer in silent {
            self.disconnect(peer, Cut::Silent, true);
        }
        self.double_stragglers();
    }
}
