//! Which answers the master looks into itself, and what is in doubt when one of them was wrong.
//!
//! A share of a worker's answers is evaluated again, chosen so that a worker cannot know which. A right one clears
//! everything that its process has answered until then. After a wrong one the process is not believed any more, and the
//! generations to which it has contributed since it was last right are taken back.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

use selftalk_proto::UnitKey;
use selftalk_sim::TrialOutcome;

use super::Work;

/// After how many times 1 / share answers without an audit one is due, whatever chance says: it bounds what is in doubt,
/// and what has to be remembered.
const PATIENCE: f64 = 4.0;

/// An answer, and whose it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Claim {
    /// The worker's process.
    pub instance: u64,
    /// Numbers the answers of all processes.
    pub serial: u64,
    /// What was asked.
    pub work: Arc<Work>,
    /// What was answered.
    pub outcomes: Vec<TrialOutcome>,
}

/// A generation of a replication.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// The experiment, by the number that units refer to.
    pub experiment: u32,
    /// Replication, counted from 0.
    pub replication: u32,
    /// Generation, counted from 0.
    pub generation: u32,
}

/// What is known of the processes that answer.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    /// Share of answers that are evaluated again, 0 to 1.
    share: f64,
    secret: u64,
    serial: u64,
    accounts: BTreeMap<u64, Account>,
    expelled: BTreeSet<u64>,
    /// Claims that are being evaluated again.
    pending: usize,
}

/// What a process has answered since it was last found to be right.
#[derive(Debug, Default)]
struct Account {
    unproven: VecDeque<(u64, Place)>,
    last: Option<Claim>,
    /// Serial number of its latest claim that is being evaluated again.
    asked: Option<u64>,
}

impl Ledger {
    pub(super) fn new(share: f64, secret: u64) -> Self {
        Self { share, secret, ..Self::default() }
    }

    /// Takes note of an answer and returns it if it is to be evaluated again.
    pub(super) fn note(
        &mut self,
        instance: u64,
        work: &Arc<Work>,
        outcomes: &[TrialOutcome],
    ) -> Option<Claim> {
        if self.share <= 0.0 {
            return None;
        }
        self.serial += 1;
        let serial = self.serial;
        let claim = Claim { instance, serial, work: Arc::clone(work), outcomes: outcomes.to_vec() };
        let chosen = drawn(self.secret, work.key) < self.share;
        let account = self.accounts.entry(instance).or_default();
        account.unproven.push_back((serial, work.place()));
        let due = account.asked.is_none() && account.unproven.len() as f64 >= PATIENCE / self.share;
        account.last = Some(claim.clone());
        (chosen || due).then(|| self.ask(claim))
    }

    /// The last answer of a process that is gone, if it has not been looked into since.
    pub(super) fn settle(&mut self, instance: u64) -> Option<Claim> {
        let account = self.accounts.get(&instance)?;
        let last = account.last.clone().filter(|last| account.asked != Some(last.serial))?;
        Some(self.ask(last))
    }

    /// The last answers of all processes.
    pub(super) fn settle_all(&mut self) -> Vec<Claim> {
        let instances: Vec<u64> = self.accounts.keys().copied().collect();
        instances.into_iter().filter_map(|instance| self.settle(instance)).collect()
    }

    fn ask(&mut self, claim: Claim) -> Claim {
        self.pending += 1;
        if let Some(account) = self.accounts.get_mut(&claim.instance) {
            account.asked = Some(claim.serial);
        }
        claim
    }

    /// Whether nothing of a process is left to be looked into and it is believed.
    pub(super) fn is_clear(&self, instance: u64) -> bool {
        self.share > 0.0 && !self.accounts.contains_key(&instance) && !self.is_expelled(instance)
    }

    /// An answer was right: so far the process is believed. Returns whether nothing is left of it to be looked into.
    pub(super) fn right(&mut self, instance: u64, serial: u64) -> bool {
        self.pending = self.pending.saturating_sub(1);
        let Some(account) = self.accounts.get_mut(&instance) else { return false };
        while account.unproven.front().is_some_and(|(earlier, _)| *earlier <= serial) {
            account.unproven.pop_front();
        }
        account.asked = account.asked.filter(|asked| *asked > serial);
        let clear = account.unproven.is_empty();
        if clear {
            self.accounts.remove(&instance);
        }
        clear
    }

    /// An answer was wrong: the process is not believed any more. Returns the generations in doubt, the first of each
    /// replication.
    pub(super) fn wrong(&mut self, instance: u64) -> Vec<Place> {
        self.pending = self.pending.saturating_sub(1);
        self.expelled.insert(instance);
        let Some(account) = self.accounts.remove(&instance) else { return Vec::new() };
        let mut first: BTreeMap<(u32, u32), Place> = BTreeMap::new();
        for (_, place) in account.unproven {
            let earliest = first.entry((place.experiment, place.replication)).or_insert(place);
            earliest.generation = earliest.generation.min(place.generation);
        }
        first.into_values().collect()
    }

    pub(super) fn is_expelled(&self, instance: u64) -> bool {
        self.expelled.contains(&instance)
    }

    /// Claims that are being evaluated again.
    pub(super) fn pending(&self) -> usize {
        self.pending
    }
}

/// A number in [0, 1) that nobody can tell from the key alone (splitmix64's finalizer, Steele et al. 2014).
fn drawn(secret: u64, key: UnitKey) -> f64 {
    let mut mixed = key.leading() ^ secret;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^= mixed >> 31;
    (mixed >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::super::tests::work;
    use super::*;

    /// With it no key of the tests is chosen unless the share is large.
    const SECRET: u64 = 0x9e37_79b9_7f4a_7c15;
    const OUTCOME: TrialOutcome = TrialOutcome { score: 0.5, success: false, steps: 60 };

    fn answer(ledger: &mut Ledger, instance: u64, number: u16) -> Option<Claim> {
        ledger.note(instance, &work(number), &[OUTCOME; 2])
    }

    #[test]
    fn about_the_share_asked_for_is_looked_into() {
        let mut ledger = Ledger::new(0.1, SECRET);
        let mut asked = 0;
        for number in 0..10_000 {
            if let Some(claim) = answer(&mut ledger, 1, number) {
                asked += 1;
                ledger.right(1, claim.serial);
            }
        }
        assert!((900..1200).contains(&asked), "{asked}");
        assert_eq!(ledger.pending(), 0);
        let mut off = Ledger::new(0.0, SECRET);
        assert!((0..1000).all(|number| answer(&mut off, 1, number).is_none()));
        assert_eq!(off.settle_all(), []);
    }

    #[test]
    fn whatever_chance_says_an_audit_comes_in_time() {
        let mut ledger = Ledger::new(0.001, SECRET);
        let first = (0..5000).map(|_| answer(&mut ledger, 1, 7)).position(|claim| claim.is_some());
        assert_eq!(first, Some(3999), "the key of number 7 is not chosen by chance");
    }

    #[test]
    fn a_right_answer_clears_what_was_before_and_a_wrong_one_takes_back_the_rest() {
        let mut ledger = Ledger::new(1e-6, SECRET);
        let at = |number: u16, replication: u32, generation: u32| {
            let work = work(number);
            let draw = selftalk_sim::Draw { replication, ..work.draw };
            Arc::new(Work { draw, generation, ..(*work).clone() })
        };
        for (number, replication, generation) in [(0, 0, 4), (1, 1, 7), (2, 0, 5), (3, 0, 6), (4, 2, 9)] {
            assert_eq!(ledger.note(1, &at(number, replication, generation), &[OUTCOME; 2]), None);
        }
        assert!(!ledger.right(1, 2));
        assert_eq!(ledger.settle(2), None);
        let last = ledger.settle(1).unwrap();
        assert_eq!((last.serial, ledger.settle(1)), (5, None), "it is asked once");
        assert_eq!(ledger.pending(), 1);
        let doubted: Vec<(u32, u32)> =
            ledger.wrong(1).iter().map(|place| (place.replication, place.generation)).collect();
        assert_eq!(doubted, [(0, 5), (2, 9)]);
        assert!(ledger.is_expelled(1) && !ledger.is_expelled(2));
        assert_eq!(ledger.pending(), 0);
    }
}
