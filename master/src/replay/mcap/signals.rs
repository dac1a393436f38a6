//! All signals of a control step as one message, `selftalk.Signals`, whose fields are named as the columns of CSV.

use prost::Message;
use prost::encoding;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use selftalk_sim::behaviours::Quantity;
use selftalk_sim::robot::RobotModel;

use crate::replay::{Kind, Moment, Recording, Signal, names, values};

/// Fields before those of the signals.
const KEYS: [(&str, Type); 4] =
    [("trial", Type::Uint32), ("behaviour", Type::String), ("step", Type::Uint32), ("time", Type::Double)];

/// The message's fields.
pub(super) struct Schema {
    fields: Vec<(String, Type)>,
}

impl Schema {
    pub(super) fn new(robot: &RobotModel) -> Self {
        let joints: Vec<String> = robot.joints.iter().map(|joint| joint.name.clone()).collect();
        let keys = KEYS.map(|(name, of)| (name.to_owned(), of));
        let signals = names(&joints, &quantities()).into_iter().map(|(name, kind)| match kind {
            Kind::Text => (name, Type::String),
            Kind::Real => (name, Type::Double),
            Kind::Truth => (name, Type::Bool),
        });
        Self { fields: keys.into_iter().chain(signals).collect() }
    }

    /// The message's description, as Protobuf's readers want it. What there is not at a moment is left out of a message,
    /// and so all fields are optional.
    pub(super) fn description(&self) -> Vec<u8> {
        let field = |(tag, (name, of)): (i32, &(String, Type))| FieldDescriptorProto {
            name: Some(name.clone()),
            number: Some(tag),
            label: Some(Label::Optional.into()),
            r#type: Some((*of).into()),
            ..FieldDescriptorProto::default()
        };
        let message = DescriptorProto {
            name: Some("Signals".to_owned()),
            field: (1..).zip(&self.fields).map(field).collect(),
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some("selftalk/signals.proto".to_owned()),
            package: Some("selftalk".to_owned()),
            message_type: vec![message],
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }

    /// The message of a moment.
    #[expect(clippy::unused_self, reason = "the fields are those of this schema")]
    pub(super) fn encode(&self, recording: &Recording, step: usize, moment: &Moment) -> Vec<u8> {
        let mut message = Vec::new();
        encoding::uint32::encode(1, &recording.trial, &mut message);
        encoding::string::encode(2, &recording.behaviour.to_owned(), &mut message);
        encoding::uint32::encode(3, &u32::try_from(step).unwrap_or(u32::MAX), &mut message);
        encoding::double::encode(4, &moment.time, &mut message);
        for (tag, signal) in (5..).zip(values(moment, &quantities())) {
            match signal {
                Signal::None => {}
                Signal::Text(words) => encoding::string::encode(tag, &words.to_owned(), &mut message),
                Signal::Real(number) => encoding::double::encode(tag, &number, &mut message),
                Signal::Truth(truth) => encoding::bool::encode(tag, &truth, &mut message),
            }
        }
        message
    }
}

fn quantities() -> [&'static str; Quantity::ALL.len()] {
    Quantity::ALL.map(Quantity::name)
}
