//! The task that owns the scheduler and carries out what it wants done.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::sync::mpsc as blocking;
use std::time::Duration;

use selftalk_proto::{FromMaster, RefusalReason, Unit, UnitKey};
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::{Instant, MissedTickBehavior, interval};

use super::auditor::{self, Audit};
use super::floor::{Attendance, Floor, Tally};
use super::handle::{Command, Crew, Finding, Findings, Handle, Line, UnitEnd};
use crate::scheduler::{Claim, Cut, Effect, Event, Limits, PeerId, Place, Scheduler, Verdict, Work};
use crate::store::WorkerId;

/// How often time is looked at; a small part of the limits that depend on it.
const TICK: Duration = Duration::from_millis(250);
/// How often it is counted what the workers have done.
const COUNT: Duration = Duration::from_secs(1);
/// Commands that are taken before the scheduler gives out work, so that a rush costs little.
const AT_ONCE: usize = 256;

type Ends = mpsc::UnboundedSender<(UnitKey, UnitEnd)>;

/// The state of the task.
#[derive(Debug)]
pub struct Hub {
    scheduler: Scheduler,
    experiments: HashMap<u32, String>,
    peers: BTreeMap<PeerId, Peer>,
    waiting: HashMap<UnitKey, Vec<Ends>>,
    crew: watch::Sender<Crew>,
    /// Whether answers are looked into.
    auditing: bool,
    audits: blocking::Sender<Audit>,
    /// Experiments that the auditor has been sent.
    audited: BTreeSet<u32>,
    findings: mpsc::UnboundedSender<Finding>,
    /// Workers that have left, by their processes, until their last answers have been looked into.
    parted: HashMap<u64, Vec<WorkerId>>,
    /// Workers that have left since the scheduler was asked last: what they had answered before may still have to be reported.
    leaving: HashMap<PeerId, WorkerId>,
    /// Who waits for all audits to be over.
    closing: Vec<oneshot::Sender<Vec<WorkerId>>>,
    floor: watch::Sender<Floor>,
    /// What all workers have done, those that have left included.
    done: Done,
    /// Workers that do not take what is sent to them.
    stalled: Vec<PeerId>,
    /// Whether units are held back.
    paused: bool,
    /// Set when the master ends.
    farewell: Option<FromMaster>,
}

#[derive(Debug, Clone, Copy, Default)]
struct Done {
    units: u64,
    trials: u64,
}

#[derive(Debug)]
struct Peer {
    line: Line,
    instance: u64,
    slots: u32,
    tally: Tally,
    /// Experiments it has been sent.
    knows: BTreeSet<u32>,
}

impl Hub {
    /// Starts the task and returns the way to it, and where it says what came of audits. Must be called within a Tokio
    /// runtime.
    #[must_use]
    pub fn start(limits: Limits) -> (Handle, Findings) {
        let (commands, inbox) = mpsc::channel(1024);
        let (crew, receiver) = watch::channel(Crew::default());
        let (findings, found) = mpsc::unbounded_channel();
        let (floor, seen) = watch::channel(Floor::default());
        let hub = Self {
            auditing: limits.audit_share > 0.0,
            scheduler: Scheduler::new(limits),
            experiments: HashMap::new(),
            peers: BTreeMap::new(),
            waiting: HashMap::new(),
            crew,
            floor,
            done: Done::default(),
            audits: auditor::start(commands.downgrade()),
            audited: BTreeSet::new(),
            findings,
            parted: HashMap::new(),
            leaving: HashMap::new(),
            closing: Vec::new(),
            stalled: Vec::new(),
            paused: false,
            farewell: None,
        };
        tokio::spawn(hub.run(inbox));
        let (experiments, peers) = Default::default();
        let handle = Handle { commands, crew: receiver, floor: seen, experiments, peers };
        (handle, Findings(found))
    }

    async fn run(mut self, mut inbox: mpsc::Receiver<Command>) {
        let begin = Instant::now();
        let mut counted = begin;
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut commands = Vec::new();
        loop {
            tokio::select! {
                // Time goes on in the greatest rush.
                biased;
                now = ticks.tick() => {
                    let passed = now.saturating_duration_since(begin).as_millis();
                    self.scheduler.handle(Event::Tick(u64::try_from(passed).unwrap_or(u64::MAX)));
                    if now.saturating_duration_since(counted) >= COUNT {
                        counted = now;
                        self.look(now);
                    }
                }
                count = inbox.recv_many(&mut commands, AT_ONCE) => {
                    if count == 0 {
                        return;
                    }
                    commands.drain(..).for_each(|command| self.follow(command));
                }
            }
            self.settle();
            self.leaving.clear();
            if self.scheduler.audits() == 0 {
                // Nobody waits any more when the run is being ended.
                for closed in std::mem::take(&mut self.closing) {
                    let _ = closed.send(self.right().collect());
                }
            }
        }
    }

    /// Carries out everything there is to do.
    fn settle(&mut self) {
        loop {
            for effect in self.scheduler.settle() {
                self.carry_out(effect);
            }
            if self.stalled.is_empty() {
                return;
            }
            for peer in std::mem::take(&mut self.stalled) {
                self.scheduler.handle(Event::Stalled(peer));
            }
        }
    }

    fn follow(&mut self, command: Command) {
        match command {
            Command::Register { experiment, toml } => {
                self.experiments.insert(experiment, toml);
            }
            Command::Submit { works, ends } => {
                for work in &works {
                    self.waiting.entry(work.key).or_default().push(ends.clone());
                }
                self.scheduler.handle(Event::Submitted(works));
            }
            Command::Joined { peer, instance, slots, holds, line } => {
                if let Some(farewell) = &self.farewell {
                    let _ = line.outgoing.try_send(farewell.clone());
                    return;
                }
                self.peers.insert(
                    peer,
                    Peer { line, instance, slots, tally: Tally::new(Instant::now()), knows: BTreeSet::new() },
                );
                self.scheduler.handle(Event::Joined { peer, instance, slots, holds });
                self.count();
            }
            Command::Events(events) => events.into_iter().for_each(|event| self.note(event)),
            Command::Pause(paused) => {
                tracing::info!(paused, "an operator has decided whether units are given out");
                self.paused = paused;
                self.scheduler.handle(Event::Paused(paused));
                self.look(Instant::now());
            }
            Command::Closing { closed } => {
                self.closing.push(closed);
                self.scheduler.handle(Event::Closing);
            }
            Command::Farewell { finished } => {
                let farewell = FromMaster::Farewell { finished };
                // Dropping the lines ends the streams after the farewell.
                for (id, peer) in std::mem::take(&mut self.peers) {
                    let _ = peer.line.outgoing.try_send(farewell.clone());
                    self.part(id, &peer);
                    self.scheduler.handle(Event::Left(id));
                }
                self.farewell = Some(farewell);
                self.count();
            }
        }
    }

    fn note(&mut self, event: Event) {
        let parted = match event {
            Event::Left(peer) | Event::Lost(peer) => Some(peer),
            _ => None,
        };
        self.scheduler.handle(event);
        if let Some((id, peer)) = parted.and_then(|id| self.peers.remove_entry(&id)) {
            self.part(id, &peer);
            self.count();
        }
    }

    /// Remembers a worker that has left, until its answers have been reported and its last one looked into.
    fn part(&mut self, id: PeerId, peer: &Peer) {
        self.leaving.insert(id, peer.line.worker);
        if self.auditing {
            self.parted.entry(peer.instance).or_default().push(peer.line.worker);
        }
    }

    /// Workers that are connected, and of which nothing is left to be looked into.
    fn right(&self) -> impl Iterator<Item = WorkerId> {
        let clear = self.peers.values().filter(|peer| self.scheduler.is_clear(peer.instance));
        clear.map(|peer| peer.line.worker)
    }

    fn find(&self, finding: Finding) {
        // Nobody waits any more when the run is being ended.
        let _ = self.findings.send(finding);
    }

    fn carry_out(&mut self, effect: Effect) {
        match effect {
            Effect::Lease(peer, units) => self.lease(peer, &units),
            Effect::Cancel(peer, keys) => self.send(peer, FromMaster::Cancel(keys)),
            Effect::Disconnect(id, why) => self.cut_off(id, why),
            Effect::Ended(key, verdict) => self.report(key, verdict),
            Effect::Audit(claim) => self.audit(claim),
            Effect::Revoke(places) => {
                for Place { experiment, replication, generation } in &places {
                    tracing::warn!(experiment, replication, generation, "taken back from this generation on");
                }
                self.find(Finding::Wrong(places));
            }
            Effect::Cleared(instance) => {
                if let Some(workers) = self.parted.remove(&instance) {
                    self.find(Finding::Right(workers));
                }
            }
        }
    }

    fn cut_off(&mut self, id: PeerId, why: Cut) {
        let Some(peer) = self.peers.remove(&id) else { return };
        self.part(id, &peer);
        let (worker, name) = (peer.line.worker.0, &*peer.line.name);
        match why {
            Cut::Silent | Cut::Replaced => tracing::info!(worker, name, ?why, "worker cut off"),
            Cut::Hanging | Cut::Stalled | Cut::Flooding => {
                tracing::warn!(worker, name, ?why, "worker cut off")
            }
            Cut::Wrong => {
                self.parted.remove(&peer.instance);
                tracing::error!(worker, name, "a worker has given wrong results and is sent away for good");
                let text =
                    "an answer of this worker was not what the master computes: its machine may be faulty";
                let refusal = FromMaster::Refusal { reason: RefusalReason::Wrong, text: text.to_owned() };
                let _ = peer.line.outgoing.try_send(refusal);
            }
        }
        peer.line.cut.cancel();
        self.count();
    }

    fn audit(&mut self, claim: Claim) {
        let experiment = claim.work.experiment;
        let fresh = self.audited.insert(experiment);
        let toml = self.experiments.get(&experiment).filter(|_| fresh).cloned();
        let (instance, serial) = (claim.instance, claim.serial);
        if self.audits.send(Audit { claim, toml }).is_err() {
            // Its thread could not be started, which has been said.
            self.scheduler.handle(Event::Audited { instance, serial, right: true });
        }
    }

    fn lease(&mut self, id: PeerId, units: &[(Arc<Work>, u32)]) {
        let Some(peer) = self.peers.get_mut(&id) else { return };
        let mut unknown = Vec::new();
        let unit = |(work, attempt): &(Arc<Work>, u32)| {
            if peer.knows.insert(work.experiment) {
                unknown.push(work.experiment);
            }
            Unit {
                key: work.key,
                experiment: work.experiment,
                draw: work.draw,
                genotype: Arc::clone(&work.genotype),
                trials: work.trials.clone(),
                attempt: *attempt,
            }
        };
        let units = units.iter().map(unit).collect();
        for experiment in unknown {
            if let Some(toml) = self.experiments.get(&experiment).cloned() {
                self.send(id, FromMaster::Experiment { id: experiment, toml });
            }
        }
        self.send(id, FromMaster::Lease(units));
    }

    fn send(&mut self, id: PeerId, message: FromMaster) {
        let Some(peer) = self.peers.get(&id) else { return };
        match peer.line.outgoing.try_send(message) {
            Err(TrySendError::Full(_)) => self.stalled.push(id),
            // If the line is cut, the connection reports it.
            Ok(()) | Err(TrySendError::Closed(_)) => {}
        }
    }

    fn report(&mut self, key: UnitKey, verdict: Verdict) {
        let end = match verdict {
            Verdict::Evaluated { by, outcomes } => {
                let trials = outcomes.len() as u64;
                self.done = Done { units: self.done.units + 1, trials: self.done.trials + trials };
                if let Some(peer) = self.peers.get_mut(&by) {
                    peer.tally.add(trials);
                }
                let connected = self.peers.get(&by).map(|peer| peer.line.worker);
                UnitEnd::Evaluated { outcomes, worker: connected.or_else(|| self.leaving.get(&by).copied()) }
            }
            Verdict::SetAside { losses, reason } => {
                tracing::warn!(unit = %key, losses, reason, "unit set aside");
                UnitEnd::SetAside { losses, reason }
            }
        };
        for ends in self.waiting.remove(&key).into_iter().flatten() {
            // Nobody waits any more when the run is being ended.
            let _ = ends.send((key, end.clone()));
        }
    }

    /// Notes what the workers are at.
    fn look(&mut self, now: Instant) {
        let attend = |(id, peer): (&PeerId, &mut Peer)| {
            peer.tally.sample(now);
            let load = self.scheduler.load(*id);
            Attendance {
                worker: peer.line.worker,
                name: Arc::clone(&peer.line.name),
                host: Arc::clone(&peer.line.host),
                slots: peer.slots,
                units: load.map_or(0, |load| load.units),
                trials: peer.tally.trials(),
                trials_per_second: peer.tally.rate(),
                silence: Duration::from_millis(load.map_or(0, |load| load.silent_ms)),
            }
        };
        let workers = self.peers.iter_mut().map(attend).collect();
        let waiting = self.scheduler.waiting_units();
        self.floor.send_replace(Floor {
            workers,
            waiting,
            paused: self.paused,
            leased: self.scheduler.open_units() - waiting,
            units: self.done.units,
            trials: self.done.trials,
        });
    }

    fn count(&self) {
        let slots = self.peers.values().map(|peer| peer.slots).sum();
        let workers = u32::try_from(self.peers.len()).unwrap_or(u32::MAX);
        self.crew.send_replace(Crew { workers, slots });
    }
}
