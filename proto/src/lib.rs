//! The wire between a master, its workers and its operators: the generated types in [`v1`], and types that have been
//! checked beside them.
//!
//! Messages come from another process, so nothing that arrives is trusted: every incoming message is converted with
//! `TryFrom`, which refuses what is malformed with a [`WireError`] and never panics.

mod address;
mod error;
mod from_master;
mod from_worker;
pub mod keys;
mod release;
mod token;
mod unit;

/// The generated types.
#[allow(missing_docs, unreachable_pub, clippy::all)]
pub mod v1 {
    tonic::include_proto!("selftalk.v1");
}

pub use address::{AddressError, chain, endpoint};
pub use error::WireError;
pub use from_master::{FromMaster, RefusalReason};
pub use from_worker::{Answer, FromWorker, Hello, UnitResult};
pub use keys::{ClientKeys, KeysError, MasterKeys};
pub use release::release;
pub use token::{Token, TokenError};
pub use unit::{Unit, UnitKey, UnitKeys};

/// The .proto files, compiled: what a client without them needs to call a master.
pub const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/descriptors.bin"));

/// Version of the protocol; master and worker must have the same.
pub const PROTOCOL: u32 = 1;

/// Largest message accepted on either side, in bytes.
pub const MESSAGE_LIMIT: usize = 4 << 20;

/// Most slots a worker may have.
pub const SLOT_LIMIT: u32 = 1024;
