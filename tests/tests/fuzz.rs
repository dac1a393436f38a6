//! Valid input with some bytes changed, removed and added: whatever comes of it, nothing panics.

use std::sync::Arc;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use prost::Message;
use selftalk_proto::{Answer, FromMaster, FromWorker, Hello, PROTOCOL, Unit, UnitKey, UnitResult, v1};
use selftalk_sim::experiment::PRESETS;
use selftalk_sim::{Draw, Experiment, Genotype, TrialOutcome};
use selftalk_tests::{Place, fuzz};

/// Changes to make somewhere in some bytes; places are shares of their length.
#[derive(Debug, Clone)]
enum Change {
    Set(f64, u8),
    Flip(f64, u8),
    Remove(f64, usize),
    Insert(f64, Vec<u8>),
    Repeat(f64, usize),
    Cut(f64),
}

fn change() -> impl Strategy<Value = Change> {
    let place = || 0.0..1.0;
    prop_oneof![
        4 => (place(), any::<u8>()).prop_map(|(at, byte)| Change::Set(at, byte)),
        4 => (place(), 0_u8..8).prop_map(|(at, bit)| Change::Flip(at, bit)),
        2 => (place(), 1_usize..20).prop_map(|(at, count)| Change::Remove(at, count)),
        2 => (place(), prop::collection::vec(any::<u8>(), 1..20)).prop_map(|(at, bytes)| Change::Insert(at, bytes)),
        1 => (place(), 1_usize..200).prop_map(|(at, count)| Change::Repeat(at, count)),
        1 => place().prop_map(Change::Cut),
    ]
}

fn changed(mut bytes: Vec<u8>, changes: &[Change]) -> Vec<u8> {
    for change in changes {
        let at = |share: f64| (share * bytes.len() as f64) as usize;
        match change {
            _ if bytes.is_empty() => {}
            Change::Set(share, byte) => {
                let at = at(*share);
                bytes[at] = *byte;
            }
            Change::Flip(share, bit) => {
                let at = at(*share);
                bytes[at] ^= 1 << bit;
            }
            Change::Remove(share, count) => {
                let at = at(*share);
                bytes.drain(at..(at + count).min(bytes.len()));
            }
            Change::Insert(share, new) => {
                let at = at(*share);
                bytes.splice(at..at, new.iter().copied());
            }
            Change::Repeat(share, count) => {
                let at = at(*share);
                let again = bytes[at..(at + count).min(bytes.len())].to_vec();
                bytes.splice(at..at, again);
            }
            Change::Cut(share) => bytes.truncate(at(*share)),
        }
    }
    bytes
}

/// Calls `target` with each of the seeds changed in so many ways.
fn fuzz(seeds: &[Vec<u8>], cases: u32, mut target: impl FnMut(&[u8])) {
    let mut runner = TestRunner::deterministic();
    let strategy = (0..seeds.len(), prop::collection::vec(change(), 0..6));
    for _ in 0..cases {
        let (seed, changes) = strategy.new_tree(&mut runner).unwrap().current();
        target(&changed(seeds[seed].clone(), &changes));
    }
}

#[test]
fn messages() {
    let key = UnitKey::from_bytes([7; 16]);
    let hello = Hello {
        protocol: PROTOCOL,
        version: "0.1.0".to_owned(),
        fingerprint: "f".repeat(32),
        host: "host".to_owned(),
        pid: 7,
        slots: 2,
        instance: 3,
        holds: vec![key; 3],
    };
    let outcomes = vec![TrialOutcome { score: 0.5, success: true, steps: 30 }; 16];
    let unit = Unit {
        key,
        experiment: 0,
        draw: Draw { replication: 1, generation: 2 },
        genotype: Arc::new(Genotype::new(vec![7; 613])),
        trials: 0..16,
        attempt: 1,
    };
    let workers = [
        FromWorker::Hello(hello),
        FromWorker::Results(vec![
            UnitResult { key, answer: Answer::Outcomes(outcomes) },
            UnitResult { key, answer: Answer::Failed("why".to_owned()) },
        ]),
    ];
    let masters = [
        FromMaster::Welcome { worker: 3, heartbeat_ms: 2000 },
        FromMaster::Lease(vec![unit; 3]),
        FromMaster::Experiment { id: 0, toml: Experiment::default().to_toml() },
        FromMaster::Cancel(vec![key; 4]),
    ];
    let workers = workers.map(|message| v1::WorkerMessage::from(message).encode_to_vec());
    let masters = masters.map(|message| v1::MasterMessage::from(message).encode_to_vec());
    fuzz(&[workers.to_vec(), masters.to_vec()].concat(), 20_000, fuzz::wire);
}

#[test]
fn experiment_files() {
    let seeds: Vec<Vec<u8>> = PRESETS
        .iter()
        .map(|preset| Experiment::from_toml(preset.name, preset.toml, &[]).unwrap().to_toml().into_bytes())
        .collect();
    fuzz(&seeds, 2_000, fuzz::experiment);
}

#[test]
fn robots() {
    let robot = include_bytes!("../../sim-core/assets/icub-left-arm.urdf").to_vec();
    fuzz(&[robot], 2_000, fuzz::urdf);
}

#[test]
fn genotypes() {
    let genotype = Genotype::new((0..613).collect::<Vec<u16>>());
    fuzz(&[genotype.to_bytes(), genotype.to_hex().into_bytes()], 5_000, fuzz::genotype);
}

#[test]
fn database_files() {
    let place = Place::with_history(2);
    let seed = place.read("history.db");
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    fuzz(&[seed], 300, |bytes| runtime.block_on(fuzz::database(bytes, &place.path(""))));
}
