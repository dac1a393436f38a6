//! The task that owns the scheduler and carries out what it wants done.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;
use std::time::Duration;

use selftalk_proto::{FromMaster, Unit, UnitKey};
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, MissedTickBehavior, interval};

use super::handle::{Command, Crew, Handle, Line, UnitEnd};
use crate::scheduler::{Effect, Event, Limits, PeerId, Scheduler, Verdict, Work};

/// How often time is looked at; a small part of the limits that depend on it.
const TICK: Duration = Duration::from_millis(250);
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
    /// Set when the master ends.
    farewell: Option<FromMaster>,
}

#[derive(Debug)]
struct Peer {
    line: Line,
    slots: u32,
    /// Experiments it has been sent.
    knows: BTreeSet<u32>,
}

impl Hub {
    /// Starts the task and returns the way to it. Must be called within a Tokio runtime.
    #[must_use]
    pub fn start(limits: Limits) -> Handle {
        let (commands, inbox) = mpsc::channel(1024);
        let (crew, receiver) = watch::channel(Crew::default());
        let hub = Self {
            scheduler: Scheduler::new(limits),
            experiments: HashMap::new(),
            peers: BTreeMap::new(),
            waiting: HashMap::new(),
            crew,
            farewell: None,
        };
        tokio::spawn(hub.run(inbox));
        Handle { commands, crew: receiver, experiments: Arc::default(), peers: Arc::default() }
    }

    async fn run(mut self, mut inbox: mpsc::Receiver<Command>) {
        let begin = Instant::now();
        let mut ticks = interval(TICK);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut commands = Vec::new();
        loop {
            tokio::select! {
                count = inbox.recv_many(&mut commands, AT_ONCE) => {
                    if count == 0 {
                        return;
                    }
                    commands.drain(..).for_each(|command| self.follow(command));
                }
                now = ticks.tick() => {
                    let passed = now.saturating_duration_since(begin).as_millis();
                    self.scheduler.handle(Event::Tick(u64::try_from(passed).unwrap_or(u64::MAX)));
                }
            }
            for effect in self.scheduler.settle() {
                self.carry_out(effect);
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
                    let _ = line.outgoing.send(farewell.clone());
                    return;
                }
                self.peers.insert(peer, Peer { line, slots, knows: BTreeSet::new() });
                self.scheduler.handle(Event::Joined { peer, instance, slots, holds });
                self.count();
            }
            Command::Events(events) => events.into_iter().for_each(|event| self.note(event)),
            Command::Farewell { finished } => {
                let farewell = FromMaster::Farewell { finished };
                // Dropping the lines ends the streams after the farewell.
                for (id, peer) in std::mem::take(&mut self.peers) {
                    let _ = peer.line.outgoing.send(farewell.clone());
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
        if parted.is_some_and(|peer| self.peers.remove(&peer).is_some()) {
            self.count();
        }
    }

    fn carry_out(&mut self, effect: Effect) {
        match effect {
            Effect::Lease(peer, units) => self.lease(peer, &units),
            Effect::Cancel(peer, keys) => self.send(peer, FromMaster::Cancel(keys)),
            Effect::Disconnect(id, why) => {
                if let Some(peer) = self.peers.remove(&id) {
                    tracing::info!(worker = peer.line.worker.0, ?why, "worker cut off");
                    peer.line.cut.cancel();
                    self.count();
                }
            }
            Effect::Ended(key, verdict) => self.report(key, verdict),
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
        for id in unknown {
            if let Some(toml) = self.experiments.get(&id) {
                let _ = peer.line.outgoing.send(FromMaster::Experiment { id, toml: toml.clone() });
            }
        }
        self.send(id, FromMaster::Lease(units));
    }

    fn send(&self, peer: PeerId, message: FromMaster) {
        if let Some(peer) = self.peers.get(&peer) {
            // If the line is cut, the connection reports it.
            let _ = peer.line.outgoing.send(message);
        }
    }

    fn report(&mut self, key: UnitKey, verdict: Verdict) {
        let end = match verdict {
            Verdict::Evaluated { by, outcomes } => {
                UnitEnd::Evaluated { outcomes, worker: self.peers.get(&by).map(|peer| peer.line.worker) }
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

    fn count(&self) {
        let slots = self.peers.values().map(|peer| peer.slots).sum();
        let workers = u32::try_from(self.peers.len()).unwrap_or(u32::MAX);
        self.crew.send_replace(Crew { workers, slots });
    }
}
