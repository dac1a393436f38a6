//! Arbitrary interleavings of everything that can happen to a scheduler, and single rules.

mod batches;
mod peers;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use proptest::prelude::*;
use selftalk_sim::{Draw, Genotype};

use super::*;

const OUTCOME: TrialOutcome = TrialOutcome { score: 0.5, success: false, steps: 60 };

fn key(number: u16) -> UnitKey {
    let mut bytes = [0; 16];
    bytes[..2].copy_from_slice(&number.to_le_bytes());
    UnitKey::from_bytes(bytes)
}

pub(super) fn work(number: u16) -> Arc<Work> {
    Arc::new(Work {
        key: key(number),
        experiment: 0,
        generation: 0,
        draw: Draw { replication: 0, generation: 0 },
        genotype: Arc::new(Genotype::new([number])),
        trials: 0..2,
    })
}

fn joined(peer: u64, instance: u64, slots: u32, holds: Vec<UnitKey>) -> Event {
    Event::Joined { peer: PeerId(peer), instance, slots, holds }
}

fn answered(peer: PeerId, key: UnitKey) -> Event {
    Event::Answered(peer, key, vec![OUTCOME; 2])
}

/// Something that happens; the numbers choose among whatever there is to choose from.
#[derive(Debug, Clone)]
enum Step {
    Submit(u8),
    Join(u8),
    /// A worker whose line was cut comes back with what it held.
    Rejoin(u8),
    Leave(u8),
    Lose(u8),
    Answer(u8, u8),
    /// An answer to a lease of any time, from a worker that may be gone.
    LateAnswer(u16),
    ShortAnswer(u8, u8),
    Fail(u8, u8),
    /// The master has looked into an answer.
    Audit(u8),
    Pause(bool),
    Tick(u16),
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        2 => (1_u8..60).prop_map(Step::Submit),
        2 => (1_u8..4).prop_map(Step::Join),
        1 => any::<u8>().prop_map(Step::Rejoin),
        1 => any::<u8>().prop_map(Step::Leave),
        2 => any::<u8>().prop_map(Step::Lose),
        20 => (any::<u8>(), any::<u8>()).prop_map(|(a, b)| Step::Answer(a, b)),
        2 => any::<u16>().prop_map(Step::LateAnswer),
        1 => (any::<u8>(), any::<u8>()).prop_map(|(a, b)| Step::ShortAnswer(a, b)),
        2 => (any::<u8>(), any::<u8>()).prop_map(|(a, b)| Step::Fail(a, b)),
        3 => any::<u8>().prop_map(Step::Audit),
        1 => any::<bool>().prop_map(Step::Pause),
        2 => (0_u16..5000).prop_map(Step::Tick),
    ]
}

/// The world around a scheduler, which notes what it is told and checks it. Every fourth worker's answers are wrong.
struct World {
    scheduler: Scheduler,
    now_ms: u64,
    next: u64,
    next_unit: u16,
    connected: BTreeMap<PeerId, (u64, BTreeSet<UnitKey>)>,
    cut: Vec<(u64, BTreeSet<UnitKey>)>,
    ever_leased: Vec<(PeerId, UnitKey)>,
    ended: BTreeMap<UnitKey, Verdict>,
    audits: Vec<Claim>,
    expelled: BTreeSet<u64>,
    /// The last answer of each process that counted.
    last: BTreeMap<u64, UnitKey>,
    /// Answers that were found to be right.
    right: BTreeSet<(u64, UnitKey)>,
    /// Processes that have left since nothing of theirs was left to be looked into.
    parted: BTreeSet<u64>,
    paused: bool,
}

impl Default for World {
    fn default() -> Self {
        let limits = Limits { audit_share: 0.2, audit_secret: 5, ..Limits::default() };
        Self {
            scheduler: Scheduler::new(limits),
            now_ms: 0,
            next: 0,
            next_unit: 0,
            connected: BTreeMap::new(),
            cut: Vec::new(),
            ever_leased: Vec::new(),
            ended: BTreeMap::new(),
            audits: Vec::new(),
            expelled: BTreeSet::new(),
            last: BTreeMap::new(),
            right: BTreeSet::new(),
            parted: BTreeSet::new(),
            paused: false,
        }
    }
}

impl World {
    fn tell(&mut self, event: Event) {
        self.scheduler.handle(event);
        for effect in self.scheduler.settle() {
            self.obey(effect);
        }
    }

    fn obey(&mut self, effect: Effect) {
        match effect {
            Effect::Lease(peer, units) => {
                assert!(!units.is_empty() && units.len() <= Limits::default().largest_batch);
                assert!(!self.paused, "leased while units are held back");
                let (instance, held) = self.connected.get_mut(&peer).expect("leased to nobody");
                assert!(!self.expelled.contains(instance), "leased to one that was found wrong");
                for (work, attempt) in units {
                    assert!(attempt >= 1);
                    assert!(!self.ended.contains_key(&work.key), "an ended unit is given out");
                    assert!(held.insert(work.key), "a worker gets a unit twice");
                    self.ever_leased.push((peer, work.key));
                }
            }
            Effect::Cancel(peer, keys) => {
                let held = &mut self.connected.get_mut(&peer).expect("cancelled at nobody").1;
                keys.iter().for_each(|key| assert!(held.remove(key)));
            }
            Effect::Disconnect(peer, _) => {
                let gone = self.connected.remove(&peer).expect("cut off twice");
                self.parted.insert(gone.0);
                self.cut.push(gone);
            }
            Effect::Ended(key, verdict) => {
                if let Verdict::Evaluated { by, .. } = &verdict {
                    self.last.insert(self.connected[by].0, key);
                }
                assert!(self.ended.insert(key, verdict).is_none(), "a unit ends twice");
            }
            Effect::Audit(claim) => self.audits.push(claim),
            Effect::Revoke(places) => assert!(!places.is_empty()),
            Effect::Cleared(instance) => {
                assert!(!self.expelled.contains(&instance), "one that was found wrong is cleared");
                let right = |last: &UnitKey| self.right.contains(&(instance, *last));
                assert!(self.last.get(&instance).is_none_or(right), "the last answer was not looked into");
                self.parted.remove(&instance);
            }
        }
    }

    fn join(&mut self, instance: u64, slots: u32, holds: BTreeSet<UnitKey>) {
        let peer = self.next;
        self.next += 1;
        self.connected.insert(PeerId(peer), (instance, holds.clone()));
        self.tell(joined(peer, instance, slots, holds.into_iter().collect()));
    }

    fn audit(&mut self, choice: usize) {
        if self.audits.is_empty() {
            return;
        }
        let Claim { instance, serial, work, .. } = self.audits.swap_remove(choice % self.audits.len());
        let right = instance % 4 != 3;
        if right {
            self.right.insert((instance, work.key));
        } else {
            self.expelled.insert(instance);
        }
        self.tell(Event::Audited { instance, serial, right });
    }

    fn peer(&self, choice: u8) -> Option<PeerId> {
        self.connected.keys().nth(usize::from(choice) % self.connected.len().max(1)).copied()
    }

    fn held(&mut self, peer: u8, unit: u8) -> Option<(PeerId, UnitKey)> {
        let peer = self.peer(peer)?;
        let held = &mut self.connected.get_mut(&peer)?.1;
        let key = held.iter().nth(usize::from(unit) % held.len().max(1)).copied()?;
        held.remove(&key);
        Some((peer, key))
    }

    fn step(&mut self, step: Step) {
        match step {
            Step::Submit(units) => {
                let first = self.next_unit;
                self.next_unit += u16::from(units);
                self.tell(Event::Submitted((first..self.next_unit).map(work).collect()));
            }
            Step::Join(slots) => self.join(self.next, u32::from(slots), BTreeSet::new()),
            Step::Rejoin(choice) => {
                if !self.cut.is_empty() {
                    let (instance, holds) = self.cut.swap_remove(usize::from(choice) % self.cut.len());
                    self.join(instance, 2, holds);
                }
            }
            Step::Leave(choice) | Step::Lose(choice) => {
                let Some(peer) = self.peer(choice) else { return };
                let gone = self.connected.remove(&peer).unwrap();
                self.parted.insert(gone.0);
                if matches!(step, Step::Leave(_)) {
                    return self.tell(Event::Left(peer));
                }
                self.cut.push(gone);
                self.tell(Event::Lost(peer));
            }
            Step::Answer(peer, unit) => {
                if let Some((peer, key)) = self.held(peer, unit) {
                    self.tell(answered(peer, key));
                }
            }
            Step::LateAnswer(choice) => {
                let choice = usize::from(choice) % self.ever_leased.len().max(1);
                if let Some(&(peer, key)) = self.ever_leased.get(choice) {
                    if let Some((_, held)) = self.connected.get_mut(&peer) {
                        held.remove(&key);
                    }
                    self.tell(answered(peer, key));
                }
            }
            Step::ShortAnswer(peer, unit) => {
                if let Some((peer, key)) = self.held(peer, unit) {
                    self.tell(Event::Answered(peer, key, vec![OUTCOME]));
                }
            }
            Step::Fail(peer, unit) => {
                if let Some((peer, key)) = self.held(peer, unit) {
                    self.tell(Event::Failed(peer, key, "why".to_owned()));
                }
            }
            Step::Audit(choice) => self.audit(usize::from(choice)),
            Step::Pause(paused) => {
                self.paused = paused;
                self.tell(Event::Paused(paused));
            }
            Step::Tick(ms) => {
                self.now_ms += u64::from(ms);
                let alive: Vec<PeerId> = self.connected.keys().copied().collect();
                // Every third worker has fallen silent.
                for peer in alive.into_iter().filter(|peer| peer.0 % 3 != 0) {
                    self.tell(Event::Heard(peer));
                }
                self.tell(Event::Tick(self.now_ms));
            }
        }
        self.check();
    }

    fn check(&self) {
        let queued = self.scheduler.open.values().filter(|unit| unit.queued).count();
        assert_eq!(queued, self.scheduler.waiting);
        for (key, unit) in &self.scheduler.open {
            assert!(unit.queued == unit.holders.is_empty(), "{key} is forgotten or held while it waits");
        }
        for (peer, (_, held)) in &self.connected {
            let known: BTreeSet<UnitKey> = self.scheduler.peers[peer].held().collect();
            assert_eq!(&known, held);
            assert!(self.scheduler.peers[peer].suspects() <= 1);
        }
    }

    /// Healthy workers join and do whatever they are given.
    fn finish(&mut self) {
        self.paused = false;
        self.tell(Event::Paused(false));
        self.join(1 << 40, 3, BTreeSet::new());
        for round in 0_u32.. {
            assert!(round < 100_000, "no end");
            let Some(peer) = self.connected.iter().find(|(_, (_, held))| !held.is_empty()) else { break };
            let (peer, key) = (*peer.0, *peer.1.1.iter().next().unwrap());
            self.connected.get_mut(&peer).unwrap().1.remove(&key);
            self.tell(answered(peer, key));
        }
        self.tell(Event::Closing);
        while !self.audits.is_empty() {
            self.audit(0);
        }
    }
}

proptest! {
    #[test]
    fn every_unit_ends_exactly_once(steps in prop::collection::vec(step(), 0..300)) {
        let mut world = World::default();
        steps.into_iter().for_each(|step| world.step(step));
        world.finish();
        prop_assert_eq!(world.scheduler.open_units(), 0);
        prop_assert_eq!(world.scheduler.waiting, 0);
        prop_assert_eq!(world.scheduler.audits(), 0);
        prop_assert_eq!(world.ended.len(), usize::from(world.next_unit));
        prop_assert!(world.parted.is_subset(&world.expelled), "{:?} are forgotten", world.parted);
        let clear = |instance: &u64| world.scheduler.is_clear(*instance) || world.expelled.contains(instance);
        prop_assert!(world.connected.values().all(|(instance, _)| clear(instance)));
    }
}

fn leases(effects: &[Effect]) -> Vec<(u64, Vec<UnitKey>)> {
    let lease = |effect: &Effect| match effect {
        Effect::Lease(peer, units) => Some((peer.0, units.iter().map(|(work, _)| work.key).collect())),
        _ => None,
    };
    effects.iter().filter_map(lease).collect()
}

fn scheduler(events: Vec<Event>) -> (Scheduler, Vec<Effect>) {
    let mut scheduler = Scheduler::default();
    events.into_iter().for_each(|event| scheduler.handle(event));
    let effects = scheduler.settle();
    (scheduler, effects)
}

#[test]
fn a_unit_that_kills_workers_is_set_aside_and_its_neighbours_live() {
    let mut scheduler = Scheduler::default();
    scheduler.handle(Event::Submitted((0..40).map(work).collect()));
    let mut verdicts = BTreeMap::new();
    let mut effects = Vec::new();
    for peer in 0..100 {
        scheduler.handle(joined(peer, peer, 1, vec![]));
        effects.extend(scheduler.settle());
        let mut held = BTreeSet::new();
        // Unit 3 kills whoever comes to it; the batches before it are answered.
        while !effects.is_empty() {
            for effect in std::mem::take(&mut effects) {
                match effect {
                    Effect::Lease(_, units) => held.extend(units.iter().map(|(work, _)| work.key)),
                    Effect::Ended(key, verdict) => drop(verdicts.insert(key, verdict)),
                    Effect::Cancel(..)
                    | Effect::Disconnect(..)
                    | Effect::Audit(_)
                    | Effect::Revoke(_)
                    | Effect::Cleared(_) => {}
                }
            }
            if held.contains(&key(3)) {
                break;
            }
            std::mem::take(&mut held)
                .into_iter()
                .for_each(|key| scheduler.handle(answered(PeerId(peer), key)));
            effects = scheduler.settle();
        }
        scheduler.handle(Event::Lost(PeerId(peer)));
    }
    assert_eq!(verdicts.len(), 40);
    for (unit, verdict) in verdicts {
        let set_aside = matches!(verdict, Verdict::SetAside { losses: 5, reason: None });
        assert_eq!(set_aside, unit == key(3), "{unit}: {verdict:?}");
    }
}

#[test]
fn a_worker_that_comes_back_keeps_its_units_and_clears_them() {
    let (mut scheduler, effects) =
        scheduler(vec![joined(1, 77, 1, vec![]), Event::Submitted((0..8).map(work).collect())]);
    let held: Vec<UnitKey> = leases(&effects).into_iter().flat_map(|(_, units)| units).collect();
    scheduler.handle(Event::Lost(PeerId(1)));
    assert!(held.iter().all(|key| scheduler.open[key].suspect()));
    let stale = key(999);
    scheduler.handle(joined(2, 77, 1, [held.clone(), vec![stale]].concat()));
    let effects = scheduler.settle();
    assert_eq!(effects[0], Effect::Cancel(PeerId(2), vec![stale]));
    assert!(leases(&effects).iter().all(|(_, units)| units.iter().all(|key| !held.contains(key))));
    assert!(held.iter().all(|key| !scheduler.open[key].suspect()));
}

#[test]
fn a_silent_worker_is_replaced_and_its_answer_counts_when_it_is_back() {
    let (mut scheduler, _) = scheduler(vec![joined(1, 1, 1, vec![]), Event::Submitted(vec![work(0)])]);
    scheduler.handle(Event::Tick(9_000));
    assert_eq!(scheduler.settle(), []);
    scheduler.handle(joined(2, 2, 1, vec![]));
    scheduler.handle(Event::Tick(10_001));
    let effects = scheduler.settle();
    assert_eq!(effects[0], Effect::Disconnect(PeerId(1), Cut::Silent));
    assert_eq!(leases(&effects), [(2, vec![key(0)])]);
    scheduler.handle(answered(PeerId(1), key(0)));
    assert_eq!(scheduler.settle(), [], "nobody knows whose answer it is");
    scheduler.handle(joined(3, 1, 1, vec![]));
    scheduler.handle(answered(PeerId(3), key(0)));
    scheduler.handle(answered(PeerId(2), key(0)));
    let effects = scheduler.settle();
    assert_eq!(effects.len(), 2);
    assert_eq!(effects[0], Effect::Cancel(PeerId(2), vec![key(0)]));
    assert!(matches!(effects[1], Effect::Ended(_, Verdict::Evaluated { by: PeerId(3), .. })));
}

#[test]
fn an_idle_worker_doubles_a_straggler() {
    let (mut scheduler, _) = scheduler(vec![
        joined(1, 1, 1, vec![]),
        Event::Submitted(vec![work(0)]),
        Event::Tick(1_000),
        joined(2, 2, 1, vec![]),
    ]);
    assert_eq!(leases(&scheduler.settle()), []);
    scheduler.handle(Event::Tick(4_001));
    assert_eq!(leases(&scheduler.settle()), [(2, vec![key(0)])]);
    scheduler.handle(Event::Lost(PeerId(1)));
    assert_eq!(scheduler.settle(), [], "the second worker still has it");
}
