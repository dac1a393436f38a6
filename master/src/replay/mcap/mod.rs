//! Recordings as an MCAP file, which Foxglove and Rerun open: robot, object and target in 3D, transforms, a log of what
//! happens, and all signals. Messages are Protobuf, as that is what both read.
//!
//! The trials follow each other, with a second between them.

mod scene;
mod signals;
mod transforms;

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::{McapError, WriteOptions, Writer};
use prost::Message;
use prost_types::Timestamp;
use selftalk_sim::robot::{RobotError, RobotModel};
use thiserror::Error;

use self::foxglove::log::Level;
use self::signals::Schema;
use super::Recording;
use super::events::{What, events};

/// Foxglove's messages.
#[allow(
    missing_docs,
    unreachable_pub,
    clippy::all,
    reason = "made from foxglove.proto, which says what they are"
)]
mod foxglove {
    include!(concat!(env!("OUT_DIR"), "/foxglove.rs"));
}

/// The description of Foxglove's messages, as Protobuf's readers want it.
const FOXGLOVE: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/foxglove.bin"));
/// The frame that everything is in: the robot's root.
const ROOT: &str = "root";
/// Nanoseconds in a second.
const SECOND: u64 = 1_000_000_000;

/// Why there is no file.
#[derive(Debug, Error)]
pub enum McapFailure {
    /// The file's format does not allow it.
    #[error(transparent)]
    Mcap(#[from] McapError),
    /// The shipped robot is damaged.
    #[error(transparent)]
    Robot(#[from] RobotError),
}

/// A file of some trials of an individual.
///
/// # Errors
/// [`McapFailure`] when the shipped robot is damaged, or the writer fails.
pub fn mcap(recordings: &[Recording]) -> Result<Vec<u8>, McapFailure> {
    let robot = RobotModel::icub()?;
    let mut out = Output::new(&robot)?;
    let mut start = 0;
    for recording in recordings {
        out.trial(&robot, recording, start)?;
        let length = recording.moments.last().map_or(0.0, |moment| moment.time);
        start += nanoseconds(length) + SECOND;
    }
    out.writer.finish()?;
    Ok(out.writer.into_inner().into_inner())
}

/// A time of a trial, which is a multiple of a control step, in nanoseconds.
fn nanoseconds(seconds: f64) -> u64 {
    (seconds * SECOND as f64).round() as u64
}

fn timestamp(time: u64) -> Option<Timestamp> {
    let (seconds, nanos) = (time / SECOND, time % SECOND);
    Some(Timestamp { seconds: i64::try_from(seconds).ok()?, nanos: i32::try_from(nanos).ok()? })
}

/// A topic with the number of messages it has had.
#[derive(Debug, Clone, Copy)]
struct Channel {
    id: u16,
    count: u32,
}

struct Output {
    writer: Writer<Cursor<Vec<u8>>>,
    schema: Schema,
    scene: Channel,
    points: Channel,
    transforms: Channel,
    log: Channel,
    signals: Channel,
}

impl Output {
    fn new(robot: &RobotModel) -> Result<Self, McapFailure> {
        let options =
            WriteOptions::new().compression(None).library(concat!("selftalk ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(Cursor::new(Vec::new()))?;
        let schema = Schema::new(robot);
        let mut channel = |topic: &str, name: &str, description: &[u8]| {
            let schema = writer.add_schema(name, "protobuf", description)?;
            let id = writer.add_channel(schema, topic, "protobuf", &BTreeMap::new())?;
            Ok::<Channel, McapError>(Channel { id, count: 0 })
        };
        Ok(Self {
            scene: channel("/scene", "foxglove.SceneUpdate", FOXGLOVE)?,
            points: channel("/points", "foxglove.PointCloud", FOXGLOVE)?,
            transforms: channel("/tf", "foxglove.FrameTransforms", FOXGLOVE)?,
            log: channel("/log", "foxglove.Log", FOXGLOVE)?,
            signals: channel("/signals", "selftalk.Signals", &schema.description())?,
            writer,
            schema,
        })
    }

    fn trial(&mut self, robot: &RobotModel, recording: &Recording, start: u64) -> Result<(), McapFailure> {
        let words = [
            ("individual", recording.individual.clone()),
            ("behaviour", recording.behaviour.to_owned()),
            ("score", recording.score.to_string()),
            ("success", recording.success.to_string()),
            ("start_seconds", (start as f64 / SECOND as f64).to_string()),
        ];
        let metadata = words.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        self.writer.write_metadata(&Metadata { name: format!("trial {}", recording.trial), metadata })?;
        let mut events = events(recording).into_iter().peekable();
        for (step, moment) in recording.moments.iter().enumerate() {
            let time = start + nanoseconds(moment.time);
            while let Some(event) = events.next_if(|event| event.moment == step) {
                self.say(recording, event.what, time)?;
            }
            let Self { writer, .. } = self;
            write(
                writer,
                &mut self.transforms,
                time,
                &transforms::at(robot, recording, moment, time).encode_to_vec(),
            )?;
            write(writer, &mut self.scene, time, &scene::at(recording, moment, time).encode_to_vec())?;
            write(writer, &mut self.points, time, &scene::points(recording, moment, time).encode_to_vec())?;
            write(writer, &mut self.signals, time, &self.schema.encode(recording, step, moment))?;
        }
        Ok(())
    }

    fn say(&mut self, recording: &Recording, what: What, time: u64) -> Result<(), McapFailure> {
        let (trial, behaviour, score) = (recording.trial, recording.behaviour, recording.score);
        let message = match what {
            What::Start => format!("trial {trial}, {behaviour}: start"),
            What::End => format!("trial {trial}, {behaviour}: {}, score {score:.4}", what.words(recording)),
            _ => what.words(recording),
        };
        let log = foxglove::Log {
            timestamp: timestamp(time),
            level: Level::Info.into(),
            message,
            name: recording.individual.clone(),
            ..foxglove::Log::default()
        };
        Ok(write(&mut self.writer, &mut self.log, time, &log.encode_to_vec())?)
    }
}

fn write(
    writer: &mut Writer<Cursor<Vec<u8>>>,
    channel: &mut Channel,
    time: u64,
    message: &[u8],
) -> Result<(), McapError> {
    let header =
        MessageHeader { channel_id: channel.id, sequence: channel.count, log_time: time, publish_time: time };
    channel.count += 1;
    writer.write_to_known_channel(&header, message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::replay::tests::recording;

    #[test]
    fn trials_follow_each_other_and_every_step_is_there() {
        let recordings = [recording(&["reach.steps=3"], 0), recording(&["grasp.steps=4"], 9)];
        let file = mcap(&recordings).unwrap();
        let mut messages: BTreeMap<String, Vec<::mcap::Message<'_>>> = BTreeMap::new();
        for message in ::mcap::MessageStream::new(&file).unwrap() {
            let message = message.unwrap();
            assert!(message.channel.schema.is_some() && message.channel.message_encoding == "protobuf");
            messages.entry(message.channel.topic.clone()).or_default().push(message);
        }
        let topics: Vec<&str> = messages.keys().map(String::as_str).collect();
        assert_eq!(topics, ["/log", "/points", "/scene", "/signals", "/tf"]);
        let times: Vec<u64> = messages["/scene"].iter().map(|message| message.log_time / 1_000_000).collect();
        assert_eq!(times, [0, 50, 100, 150, 1150, 1200, 1250, 1300, 1350]);

        let last = foxglove::SceneUpdate::decode(&*messages["/scene"][8].data).unwrap();
        let object = last.entities.iter().find(|entity| entity.id == "object").unwrap();
        let place = object.spheres[0].pose.as_ref().unwrap().position.as_ref().unwrap();
        assert_eq!([place.x, place.y, place.z], recordings[1].moments[4].object);
        let said: Vec<String> = messages["/log"]
            .iter()
            .map(|message| foxglove::Log::decode(&*message.data).unwrap().message)
            .collect();
        assert_eq!(said[0], "trial 0, reach: start");
        assert!(said.contains(&"hears grasp".to_owned()), "{said:?}");
        let summary = ::mcap::Summary::read(&file).unwrap().unwrap();
        assert_eq!(summary.metadata_indexes.len(), 2);
        assert_eq!(summary.stats.unwrap().message_count, 4 * 9 + said.len() as u64);
    }
}
