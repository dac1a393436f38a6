//! The neurons by name.

/// The sensory neurons: where the attended thing is seen from the palm, joint angles as shares of their ranges, touch,
/// and the label that is heard.
pub const SENSORS: [&str; 25] = [
    "attended_x",
    "attended_y",
    "attended_z",
    "torso_yaw",
    "torso_pitch",
    "shoulder_pitch",
    "shoulder_roll",
    "shoulder_yaw",
    "elbow",
    "wrist_prosup",
    "wrist_pitch",
    "wrist_yaw",
    "thumb_flexion",
    "thumb_opposition",
    "finger_flexion",
    "touch_palm",
    "touch_thumb",
    "touch_index",
    "touch_middle",
    "touch_ring",
    "touch_little",
    "label_reach",
    "label_open",
    "label_grasp",
    "label_move",
];

/// The motor neurons: attention, and the joints they command.
pub const MOTORS: [&str; 13] = [
    "focus",
    "torso_yaw",
    "torso_pitch",
    "shoulder_pitch",
    "shoulder_roll",
    "shoulder_yaw",
    "elbow",
    "wrist_prosup",
    "wrist_pitch",
    "wrist_yaw",
    "thumb_flexion",
    "thumb_opposition",
    "finger_flexion",
];

#[cfg(test)]
mod tests {
    use super::*;
    use selftalk_sim::Behaviour;
    use selftalk_sim::physics::TOUCH_SENSOR_NAMES;

    #[test]
    fn sensors_are_named_in_the_order_of_the_body() {
        assert_eq!(SENSORS[3..15], MOTORS[1..], "proprioception has the motors' order");
        let touch = TOUCH_SENSOR_NAMES.map(|name| format!("touch_{name}"));
        assert_eq!(SENSORS[15..21], touch.each_ref().map(String::as_str));
        let labels = Behaviour::ELEMENTARY.map(|label| format!("label_{}", label.name()));
        assert_eq!(SENSORS[21..], labels.each_ref().map(String::as_str));
    }
}
