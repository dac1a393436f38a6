//! What a master says.

use crate::v1::{self, master_message::Body, refusal};
use crate::{Unit, UnitKey, WireError};

/// A message of a master.
#[derive(Debug, Clone, PartialEq)]
pub enum FromMaster {
    /// The worker is accepted.
    Welcome {
        /// The worker's number in the master's history.
        worker: i64,
        /// Milliseconds between the heartbeats that the master expects.
        heartbeat_ms: u32,
    },
    /// The worker is not accepted.
    Refusal {
        /// Why.
        reason: RefusalReason,
        /// The same for people.
        text: String,
    },
    /// An experiment to which units refer.
    Experiment {
        /// Its number, valid for this stream.
        id: u32,
        /// The complete experiment file.
        toml: String,
    },
    /// Units to be evaluated.
    Lease(Vec<Unit>),
    /// Units that need not be evaluated any more.
    Cancel(Vec<UnitKey>),
    /// The master ends.
    Farewell {
        /// Whether all work is done; otherwise the master is expected back.
        finished: bool,
    },
}

/// Why a worker is not accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusalReason {
    /// Master and worker speak different versions of the protocol.
    Protocol,
    /// Master and worker would compute different results.
    Fingerprint,
    /// The hello cannot be understood.
    Hello,
    /// An answer of the worker was not what the master computes.
    Wrong,
    /// A reason that this version does not know.
    Other,
}

impl From<FromMaster> for v1::MasterMessage {
    fn from(message: FromMaster) -> Self {
        let body = match message {
            FromMaster::Welcome { worker, heartbeat_ms } => {
                Body::Welcome(v1::Welcome { worker, heartbeat_ms })
            }
            FromMaster::Refusal { reason, text } => {
                Body::Refusal(v1::Refusal { reason: refusal::Reason::from(reason).into(), text })
            }
            FromMaster::Experiment { id, toml } => Body::Experiment(v1::Experiment { id, toml }),
            FromMaster::Lease(units) => {
                Body::Lease(v1::Lease { units: units.iter().map(Into::into).collect() })
            }
            FromMaster::Cancel(keys) => {
                Body::Cancel(v1::Cancel { keys: keys.into_iter().map(UnitKey::to_wire).collect() })
            }
            FromMaster::Farewell { finished } => Body::Farewell(v1::Farewell { finished }),
        };
        Self { body: Some(body) }
    }
}

impl TryFrom<v1::MasterMessage> for FromMaster {
    type Error = WireError;

    fn try_from(message: v1::MasterMessage) -> Result<Self, WireError> {
        Ok(match message.body.ok_or(WireError::Missing("body"))? {
            Body::Welcome(v1::Welcome { worker, heartbeat_ms }) => Self::Welcome { worker, heartbeat_ms },
            Body::Refusal(refusal) => Self::Refusal { reason: refusal.reason().into(), text: refusal.text },
            Body::Experiment(v1::Experiment { id, toml }) => Self::Experiment { id, toml },
            Body::Lease(v1::Lease { units }) => {
                Self::Lease(units.into_iter().map(TryInto::try_into).collect::<Result<_, _>>()?)
            }
            Body::Cancel(v1::Cancel { keys }) => {
                Self::Cancel(keys.iter().map(|key| UnitKey::from_wire(key)).collect::<Result<_, _>>()?)
            }
            Body::Farewell(v1::Farewell { finished }) => Self::Farewell { finished },
        })
    }
}

impl From<RefusalReason> for refusal::Reason {
    fn from(reason: RefusalReason) -> Self {
        match reason {
            RefusalReason::Protocol => Self::Protocol,
            RefusalReason::Fingerprint => Self::Fingerprint,
            RefusalReason::Hello => Self::Hello,
            RefusalReason::Wrong => Self::Wrong,
            RefusalReason::Other => Self::Unspecified,
        }
    }
}

impl From<refusal::Reason> for RefusalReason {
    fn from(reason: refusal::Reason) -> Self {
        match reason {
            refusal::Reason::Protocol => Self::Protocol,
            refusal::Reason::Fingerprint => Self::Fingerprint,
            refusal::Reason::Hello => Self::Hello,
            refusal::Reason::Wrong => Self::Wrong,
            refusal::Reason::Unspecified => Self::Other,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use proptest::prelude::*;
    use prost::Message;
    use selftalk_sim::{Draw, Genotype};

    use super::*;
    use crate::FromWorker;

    #[test]
    fn messages_arrive_as_they_were_sent() {
        let key = UnitKey::from_bytes([5; 16]);
        let unit = Unit {
            key,
            experiment: 1,
            draw: Draw { replication: 2, generation: 3 },
            genotype: Arc::new(Genotype::new([1_u16, 0xfffe])),
            trials: 4..16,
            attempt: 2,
        };
        for message in [
            FromMaster::Welcome { worker: -3, heartbeat_ms: 1000 },
            FromMaster::Refusal { reason: RefusalReason::Fingerprint, text: "no".to_owned() },
            FromMaster::Experiment { id: 1, toml: "seed = 1".to_owned() },
            FromMaster::Lease(vec![unit]),
            FromMaster::Cancel(vec![key]),
            FromMaster::Farewell { finished: true },
        ] {
            assert_eq!(FromMaster::try_from(v1::MasterMessage::from(message.clone())), Ok(message));
        }
    }

    #[test]
    fn a_refusal_of_a_later_version_is_still_a_refusal() {
        let refusal = v1::Refusal { reason: 99, text: "why".to_owned() };
        let message = v1::MasterMessage { body: Some(Body::Refusal(refusal)) };
        let expected = FromMaster::Refusal { reason: RefusalReason::Other, text: "why".to_owned() };
        assert_eq!(FromMaster::try_from(message), Ok(expected));
    }

    proptest! {
        #[test]
        fn hostile_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            if let Ok(message) = v1::MasterMessage::decode(bytes.as_slice()) {
                let _ = FromMaster::try_from(message);
            }
            if let Ok(message) = v1::WorkerMessage::decode(bytes.as_slice()) {
                let _ = FromWorker::try_from(message);
            }
        }
    }
}
