//! Writes `assets/icub-left-arm.urdf` from the robot's figures in `assets/icub-joints.csv`.
//!
//! Run from the repository's root: `cargo run -p selftalk-sim --example make_urdf > sim-core/assets/icub-left-arm.urdf`

#![allow(
    clippy::disallowed_methods,
    reason = "what is written is shipped, and the same everywhere from then on"
)]

use std::collections::HashMap;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};

const FIGURES: &str = include_str!("../assets/icub-joints.csv");

/// Radius of all phalanges, in metres.
const PHALANX_RADIUS: f64 = 0.0065;
const FOREARM_RADIUS: f64 = 0.03;
/// Density by which a link without a measured inertia tensor is turned into a solid sphere, in kg/m^3 (aluminium).
const DENSITY: f64 = 2700.0;
const PALM: &str =
    r#"<origin xyz="0.03 0 0.012" rpy="0 -0.2618 0"/><geometry><box size="0.07 0.026 0.07"/></geometry>"#;
const PALM_SIZE: [f64; 3] = [0.07, 0.026, 0.07];

fn main() -> Result<(), Box<dyn Error>> {
    let mut reader = csv::Reader::from_reader(FIGURES.as_bytes());
    let columns = reader.headers()?.clone();
    let rows: Vec<HashMap<String, String>> = reader
        .records()
        .map(|record| {
            let record = record?;
            Ok(columns.iter().zip(record.iter()).map(|(k, v)| (k.to_owned(), v.to_owned())).collect())
        })
        .collect::<Result<_, csv::Error>>()?;

    println!("<?xml version=\"1.0\"?>");
    println!("<!-- iCub: torso, left arm and left hand. CC-BY-SA-4.0, see LICENSE-urdf.md.");
    println!("     Made from icub-joints.csv by the example make_urdf. -->");
    println!("<robot name=\"icub_left_arm\">");
    println!("  <link name=\"root_link\"/>");
    for row in &rows {
        print_link(row, &rows)?;
        print_joint(row)?;
    }
    println!("</robot>");
    Ok(())
}

type Row = HashMap<String, String>;

fn number(row: &Row, column: &str) -> Result<f64, Box<dyn Error>> {
    let text = row.get(column).map_or("", String::as_str);
    if text.is_empty() {
        return Ok(0.0);
    }
    text.parse().map_err(|_| format!("{}: {column} is not a number: {text}", row["joint"]).into())
}

fn triple(row: &Row, columns: [&str; 3]) -> Result<[f64; 3], Box<dyn Error>> {
    Ok([number(row, columns[0])?, number(row, columns[1])?, number(row, columns[2])?])
}

fn text([x, y, z]: [f64; 3]) -> String {
    format!("{x} {y} {z}")
}

fn print_joint(row: &Row) -> Result<(), Box<dyn Error>> {
    let name = &row["joint"];
    let moving = row["type"] == "revolute" && !is_locked(name);
    let kind = if moving { "revolute" } else { "fixed" };
    println!("  <joint name=\"{name}\" type=\"{kind}\">");
    println!("    <parent link=\"{}\"/>", row["parent_link"]);
    println!("    <child link=\"{}\"/>", row["child_link"]);
    let (xyz, rpy) = (triple(row, ["x", "y", "z"])?, triple(row, ["roll", "pitch", "yaw"])?);
    println!("    <origin xyz=\"{}\" rpy=\"{}\"/>", text(xyz), text(rpy));
    if moving {
        println!("    <axis xyz=\"{}\"/>", text(triple(row, ["axis_x", "axis_y", "axis_z"])?));
        // The experiment limits the torso to -10 and 40 degrees (paper, section II.B).
        let [lower, upper] = if name.starts_with("torso") {
            [-10.0_f64.to_radians(), 40.0_f64.to_radians()]
        } else {
            [number(row, "lower_rad")?, number(row, "upper_rad")?]
        };
        let (effort, damping) = match group(name) {
            Group::Arm => (25.0, 20.0),
            Group::Wrist => (2.0, 1.2),
            Group::Hand => (0.15, 0.05),
        };
        println!("    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\" velocity=\"10\"/>");
        println!("    <dynamics damping=\"{damping}\" friction=\"0\"/>");
    }
    println!("  </joint>");
    Ok(())
}

/// The torso's roll and the fingers' abduction stay at zero, and a finger's last two phalanges are one body.
fn is_locked(joint: &str) -> bool {
    let abduction = joint.ends_with("_0_joint") && !joint.contains("thumb");
    joint == "torso_roll" || abduction || joint.ends_with("_3_joint")
}

enum Group {
    Arm,
    Wrist,
    Hand,
}

fn group(joint: &str) -> Group {
    if joint.starts_with("l_hand") {
        Group::Hand
    } else if joint.starts_with("l_wrist") {
        Group::Wrist
    } else {
        Group::Arm
    }
}

fn print_link(row: &Row, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let link = &row["child_link"];
    let mass = number(row, "child_mass_kg")?;
    if mass == 0.0 {
        println!("  <link name=\"{link}\"/>");
        return Ok(());
    }
    let length = capsule_length(link, rows)?;
    let mut centre = triple(row, ["com_x", "com_y", "com_z"])?;
    let mut inertia = triple(row, ["ixx", "iyy", "izz"])?;
    if !row["inertia_note"].is_empty() {
        inertia = match length {
            Some(length) if link.starts_with("l_hand") => {
                centre = [length / 2.0, 0.0, 0.0];
                capsule_inertia(mass, PHALANX_RADIUS, length)
            }
            _ if link == "l_hand" => box_inertia(mass, PALM_SIZE),
            _ => sphere_inertia(mass),
        };
    }
    println!("  <link name=\"{link}\">");
    println!("    <inertial>");
    println!("      <origin xyz=\"{}\"/>", text(centre));
    println!("      <mass value=\"{mass}\"/>");
    let [xx, yy, zz] = inertia;
    println!("      <inertia ixx=\"{xx}\" ixy=\"0\" ixz=\"0\" iyy=\"{yy}\" iyz=\"0\" izz=\"{zz}\"/>");
    println!("    </inertial>");
    if link == "l_hand" {
        println!("    <collision>{PALM}</collision>");
    } else if link == "l_forearm" {
        print_forearm(rows)?;
    } else if let Some(length) = length {
        let origin = format!("<origin xyz=\"{} 0 0\" rpy=\"0 {FRAC_PI_2} 0\"/>", length / 2.0);
        let shape = format!("<capsule radius=\"{PHALANX_RADIUS}\" length=\"{length}\"/>");
        println!("    <collision>{origin}<geometry>{shape}</geometry></collision>");
    }
    println!("  </link>");
    Ok(())
}

/// The forearm's capsule runs from the joint that turns it to the wrist.
fn print_forearm(rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let wrist = rows.iter().find(|row| row["joint"] == "l_wrist_pitch").ok_or("no wrist")?;
    let [x, y, z] = triple(wrist, ["x", "y", "z"])?;
    let length = (x * x + y * y + z * z).sqrt();
    let pitch = x.hypot(y).atan2(z);
    let yaw = y.atan2(x);
    let origin = format!("<origin xyz=\"{}\" rpy=\"0 {pitch} {yaw}\"/>", text([x / 2.0, y / 2.0, z / 2.0]));
    let shape = format!("<capsule radius=\"{FOREARM_RADIUS}\" length=\"{length}\"/>");
    println!("    <collision>{origin}<geometry>{shape}</geometry></collision>");
    Ok(())
}

/// A phalanx reaches from its joint to the next one, which lies on its x axis.
fn capsule_length(link: &str, rows: &[Row]) -> Result<Option<f64>, Box<dyn Error>> {
    let is_phalanx = link.starts_with("l_hand_") && !link.ends_with("_0");
    let next = rows.iter().find(|row| row["parent_link"] == link);
    match next {
        Some(next) if is_phalanx => Ok(Some(number(next, "x")?)),
        _ => Ok(None),
    }
}

/// Principal moments of a solid capsule along x: cylinder of `length` with half-spheres at its ends.
fn capsule_inertia(mass: f64, radius: f64, length: f64) -> [f64; 3] {
    let cylinder = PI * radius * radius * length;
    let caps = 4.0 / 3.0 * PI * radius.powi(3);
    let (m_cylinder, m_caps) = (mass * cylinder / (cylinder + caps), mass * caps / (cylinder + caps));
    let axial = m_cylinder * radius * radius / 2.0 + m_caps * 2.0 * radius * radius / 5.0;
    let across = m_cylinder * (length * length / 12.0 + radius * radius / 4.0)
        + m_caps * (2.0 * radius * radius / 5.0 + length * length / 4.0 + 3.0 * length * radius / 8.0);
    [axial, across, across]
}

fn box_inertia(mass: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [y * y + z * z, x * x + z * z, x * x + y * y].map(|sum| mass * sum / 12.0)
}

fn sphere_inertia(mass: f64) -> [f64; 3] {
    let radius = (3.0 * mass / (4.0 * PI * DENSITY)).cbrt();
    [0.4 * mass * radius * radius; 3]
}
