//! What a worker says.

use selftalk_sim::TrialOutcome;

use crate::v1::{self, unit_result, worker_message::Body};
use crate::{SLOT_LIMIT, UnitKey, WireError};

/// Longest text of a worker that a master takes, in bytes.
const TEXT_LIMIT: usize = 1024;

/// A message of a worker.
#[derive(Debug, Clone, PartialEq)]
pub enum FromWorker {
    /// Who is calling; the first message.
    Hello(Hello),
    /// The worker is alive.
    Heartbeat,
    /// Answers to units.
    Results(Vec<UnitResult>),
    /// The worker leaves on purpose.
    Goodbye,
}

/// How a worker introduces itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hello {
    /// Version of the protocol.
    pub protocol: u32,
    /// Version of the worker's program.
    pub version: String,
    /// Fingerprint of its simulator.
    pub fingerprint: String,
    /// Name of its machine.
    pub host: String,
    /// Its process.
    pub pid: u32,
    /// Threads that simulate.
    pub slots: u32,
    /// Stays the same when the worker reconnects.
    pub instance: u64,
    /// Units it still holds from before a cut line.
    pub holds: Vec<UnitKey>,
}

/// A worker's answer to a unit.
#[derive(Debug, Clone, PartialEq)]
pub struct UnitResult {
    /// The unit.
    pub key: UnitKey,
    /// What became of it.
    pub answer: Answer,
}

/// What became of a unit.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// The outcomes of its trials, in their order.
    Outcomes(Vec<TrialOutcome>),
    /// It could not be evaluated.
    Failed(String),
}

impl From<FromWorker> for v1::WorkerMessage {
    fn from(message: FromWorker) -> Self {
        let body = match message {
            FromWorker::Hello(hello) => Body::Hello(hello.into()),
            FromWorker::Heartbeat => Body::Heartbeat(v1::Heartbeat {}),
            FromWorker::Results(results) => {
                Body::Results(v1::Results { results: results.into_iter().map(Into::into).collect() })
            }
            FromWorker::Goodbye => Body::Goodbye(v1::Goodbye {}),
        };
        Self { body: Some(body) }
    }
}

impl TryFrom<v1::WorkerMessage> for FromWorker {
    type Error = WireError;

    fn try_from(message: v1::WorkerMessage) -> Result<Self, WireError> {
        Ok(match message.body.ok_or(WireError::Missing("body"))? {
            Body::Hello(hello) => Self::Hello(hello.try_into()?),
            Body::Heartbeat(_) => Self::Heartbeat,
            Body::Results(v1::Results { results }) => {
                Self::Results(results.into_iter().map(TryInto::try_into).collect::<Result<_, _>>()?)
            }
            Body::Goodbye(_) => Self::Goodbye,
        })
    }
}

impl From<Hello> for v1::Hello {
    fn from(hello: Hello) -> Self {
        Self {
            protocol: hello.protocol,
            version: hello.version,
            fingerprint: hello.fingerprint,
            host: hello.host,
            pid: hello.pid,
            slots: hello.slots,
            instance: hello.instance,
            holds: hello.holds.into_iter().map(UnitKey::to_wire).collect(),
        }
    }
}

impl TryFrom<v1::Hello> for Hello {
    type Error = WireError;

    fn try_from(hello: v1::Hello) -> Result<Self, WireError> {
        if !(1..=SLOT_LIMIT).contains(&hello.slots) {
            return Err(WireError::Slots(hello.slots));
        }
        Ok(Self {
            protocol: hello.protocol,
            version: short("version", hello.version)?,
            fingerprint: short("fingerprint", hello.fingerprint)?,
            host: short("host", hello.host)?,
            pid: hello.pid,
            slots: hello.slots,
            instance: hello.instance,
            holds: hello.holds.iter().map(|key| UnitKey::from_wire(key)).collect::<Result<_, _>>()?,
        })
    }
}

fn short(field: &'static str, text: String) -> Result<String, WireError> {
    if text.len() > TEXT_LIMIT { Err(WireError::TooLong { field, limit: TEXT_LIMIT }) } else { Ok(text) }
}

impl From<UnitResult> for v1::UnitResult {
    fn from(result: UnitResult) -> Self {
        let answer = match result.answer {
            Answer::Outcomes(outcomes) => {
                let trials = outcomes
                    .into_iter()
                    .map(|TrialOutcome { score, success, steps }| v1::TrialOutcome { score, success, steps });
                unit_result::Answer::Outcomes(v1::Outcomes { trials: trials.collect() })
            }
            Answer::Failed(mut reason) => {
                // The receiver refuses longer ones.
                reason.truncate(reason.floor_char_boundary(TEXT_LIMIT));
                unit_result::Answer::Failure(v1::Failure { reason })
            }
        };
        Self { key: result.key.to_wire(), answer: Some(answer) }
    }
}

impl TryFrom<v1::UnitResult> for UnitResult {
    type Error = WireError;

    fn try_from(result: v1::UnitResult) -> Result<Self, WireError> {
        let answer = match result.answer.ok_or(WireError::Missing("answer"))? {
            unit_result::Answer::Outcomes(v1::Outcomes { trials }) => {
                Answer::Outcomes(trials.into_iter().map(outcome).collect())
            }
            unit_result::Answer::Failure(v1::Failure { reason }) => Answer::Failed(short("reason", reason)?),
        };
        Ok(Self { key: UnitKey::from_wire(&result.key)?, answer })
    }
}

/// A trial whose score is not a finite number has failed; one pattern of bits stands for all of those.
fn outcome(trial: v1::TrialOutcome) -> TrialOutcome {
    let v1::TrialOutcome { score, success, steps } = trial;
    if score.is_finite() {
        TrialOutcome { score, success, steps }
    } else {
        TrialOutcome { score: f64::NAN, success: false, steps }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hello() -> Hello {
        Hello {
            protocol: 1,
            version: "0.1.0".to_owned(),
            fingerprint: "f".to_owned(),
            host: "h".to_owned(),
            pid: 7,
            slots: 2,
            instance: u64::MAX,
            holds: vec![UnitKey::from_bytes([3; 16])],
        }
    }

    fn back(message: FromWorker) -> Result<FromWorker, WireError> {
        v1::WorkerMessage::from(message).try_into()
    }

    #[test]
    fn messages_arrive_as_they_were_sent() {
        let outcome = TrialOutcome { score: 0.1 + 0.2, success: true, steps: 60 };
        let key = UnitKey::from_bytes([9; 16]);
        for message in [
            FromWorker::Hello(hello()),
            FromWorker::Heartbeat,
            FromWorker::Goodbye,
            FromWorker::Results(vec![
                UnitResult { key, answer: Answer::Outcomes(vec![outcome; 16]) },
                UnitResult { key, answer: Answer::Failed("why".to_owned()) },
            ]),
        ] {
            assert_eq!(back(message.clone()), Ok(message));
        }
    }

    #[test]
    fn a_score_that_is_no_number_is_a_failed_trial() {
        for score in [-f64::NAN, f64::INFINITY] {
            let got = outcome(v1::TrialOutcome { score, success: true, steps: 4 });
            assert_eq!(got.score.to_bits(), f64::NAN.to_bits());
            assert!(!got.success && got.steps == 4);
        }
    }

    #[test]
    fn malformed_messages_are_refused() {
        let empty = v1::WorkerMessage { body: None };
        assert_eq!(FromWorker::try_from(empty), Err(WireError::Missing("body")));
        let no_slots = FromWorker::Hello(Hello { slots: 0, ..hello() });
        assert_eq!(back(no_slots), Err(WireError::Slots(0)));
        let long = FromWorker::Hello(Hello { host: "x".repeat(2000), ..hello() });
        assert!(matches!(back(long), Err(WireError::TooLong { field: "host", .. })));
        let no_answer = v1::UnitResult { key: vec![0; 16], answer: None };
        assert_eq!(UnitResult::try_from(no_answer), Err(WireError::Missing("answer")));
    }
}
