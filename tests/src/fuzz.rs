//! What comes from outside, as bytes of any kind: none of it may make a program panic. A fuzzer calls these functions
//! (`tests/fuzz/`), and so does an ordinary test, with valid bytes that were changed a little.

use std::path::Path;

use prost::Message;
use selftalk::store::{SqliteStore, Store};
use selftalk_proto::{FromMaster, FromWorker, v1};
use selftalk_sim::robot::{Kinematics, RobotModel};
use selftalk_sim::{Experiment, Genotype, Simulator};

/// A message from the other side of the wire.
pub fn wire(bytes: &[u8]) {
    if let Ok(message) = v1::WorkerMessage::decode(bytes) {
        let _ = FromWorker::try_from(message);
    }
    if let Ok(message) = v1::MasterMessage::decode(bytes) {
        let _ = FromMaster::try_from(message);
    }
}

/// An experiment file. One that is accepted reads back as itself, and can be simulated.
///
/// # Panics
/// If it does not.
pub fn experiment(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    if let Ok(experiment) = Experiment::from_toml("fuzz.toml", &text, &[]) {
        let again = Experiment::from_toml("again.toml", &experiment.to_toml(), &[]);
        assert_eq!(again.as_ref(), Ok(&experiment));
        let _ = Simulator::new(&experiment);
    }
}

/// The description of a robot. The links of one that is accepted have poses.
pub fn urdf(bytes: &[u8]) {
    if let Ok(robot) = RobotModel::from_urdf(&String::from_utf8_lossy(bytes)) {
        let angles = robot.joints.each_ref().map(|joint| joint.angle(0.5));
        let _ = Kinematics::new(&robot, &angles);
    }
}

/// A genotype as it is stored and sent.
///
/// # Panics
/// If it is accepted and is another then.
pub fn genotype(bytes: &[u8]) {
    if let Ok(genotype) = Genotype::from_bytes(bytes, bytes.len() / 2) {
        assert_eq!(genotype.to_bytes(), bytes);
    }
    if let Ok(genotype) = Genotype::from_hex(&String::from_utf8_lossy(bytes)) {
        assert_eq!(Genotype::from_hex(&genotype.to_hex()), Ok(genotype));
    }
}

/// A database file, which is written into a folder and read as far as that is possible.
///
/// # Panics
/// If the folder cannot be written.
pub async fn database(bytes: &[u8], folder: &Path) {
    let path = folder.join("fuzz.db");
    std::fs::write(&path, bytes).unwrap();
    let Ok(store) = SqliteStore::open_reader(&path).await else { return };
    for stored in store.experiments().await.unwrap_or_default() {
        for replication in &stored.replications {
            let _ = store.last_generation(replication.id).await;
            let mut generations = store.generations(replication);
            for generation in 0..replication.generations.min(10) {
                let _ = generations.read(generation).await;
            }
        }
    }
    let _ = store.close().await;
}
