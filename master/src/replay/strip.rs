//! Key moments of a trial side by side, for a paper: the shapes that the page draws, from the camera it starts with.

use std::fmt::Write;

use super::camera::{Camera, Seen};
use super::events::{Event, What, events};
use super::shapes::{self, Shape, Tint};
use super::{Moment, Recording};
use crate::picture::escaped;

/// Width and height of a moment's picture.
const PICTURE: [f64; 2] = [300.0, 240.0];
/// Space around the pictures.
const MARGIN: f64 = 10.0;
/// Height of the title, and of the words below a picture.
const WORDS: [f64; 2] = [26.0, 40.0];
/// At least and at most so many moments, if the trial has them.
const COUNT: (usize, usize) = (4, 6);
/// Lines around the robot's parts.
const FAINT: &str = "#8792a3";
const INK: &str = "#1c2430";
/// The corners of a box's faces.
const FACES: [[usize; 4]; 6] =
    [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

/// The key moments of a trial, with what happens in them.
#[must_use]
pub fn key_moments(recording: &Recording) -> Vec<(usize, String)> {
    let events = events(recording);
    let first = |wanted: fn(What) -> bool| events.iter().find(move |event| wanted(event.what));
    let last = recording.moments.len().saturating_sub(1);
    let mut chosen: Vec<Event> =
        vec![Event { moment: 0, what: What::Start }, Event { moment: last, what: What::End }];
    chosen.extend(first(|what| what == What::Goal));
    chosen.extend(first(|what| matches!(what, What::Touch(_))));
    // In elementary actions the label is there from the first step.
    chosen.extend(events.iter().filter(|event| event.moment > 1 && matches!(event.what, What::Heard(_))));
    let mut moments: Vec<(usize, String)> = Vec::new();
    for event in chosen {
        let words = event.what.words(recording);
        let room = moments.len() < COUNT.1;
        match moments.iter_mut().find(|(moment, _)| *moment == event.moment) {
            Some((_, others)) => *others = format!("{others}, {words}"),
            None if room => moments.push((event.moment, words)),
            None => {}
        }
    }
    moments.sort();
    while moments.len() < COUNT.0 {
        let gaps = moments.windows(2).enumerate().map(|(at, pair)| (pair[1].0 - pair[0].0, at));
        // The earlier of equal ones.
        let widest = gaps.max_by_key(|(gap, at)| (*gap, std::cmp::Reverse(*at))).filter(|(gap, _)| *gap > 1);
        let Some((gap, at)) = widest else { break };
        moments.insert(at + 1, (moments[at].0 + gap / 2, String::new()));
    }
    moments
}

/// The moments side by side, as SVG.
#[must_use]
pub fn strip(recording: &Recording) -> String {
    let moments = key_moments(recording);
    let width = MARGIN + moments.len() as f64 * (PICTURE[0] + MARGIN);
    let height = WORDS[0] + PICTURE[1] + WORDS[1];
    let mut svg = Svg::default();
    svg.add(format_args!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" fill=\"{INK}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <defs><radialGradient id=\"ball\" cx=\"0.35\" cy=\"0.35\" r=\"0.75\"><stop offset=\"0\" stop-color=\"#f0b0b0\"/>\
         <stop offset=\"0.5\" stop-color=\"{}\"/></radialGradient>\n<clipPath id=\"frame\"><rect width=\"{}\" height=\"{}\"/>\
         </clipPath></defs>\n",
        hex(Tint::Object),
        PICTURE[0],
        PICTURE[1]
    ));
    let title = format!(
        "{}, trial {}: {}, score {:.4}",
        recording.individual, recording.trial, recording.behaviour, recording.score
    );
    svg.add(format_args!("<text x=\"{MARGIN}\" y=\"18\" font-size=\"14\">{}</text>\n", escaped(&title)));
    for (place, (moment, words)) in moments.iter().enumerate() {
        let Some(moment) = recording.moments.get(*moment) else { continue };
        let x = MARGIN + place as f64 * (PICTURE[0] + MARGIN);
        svg.add(format_args!(
            "<g transform=\"translate({x} {})\">\n<g clip-path=\"url(#frame)\">\n",
            WORDS[0]
        ));
        svg.picture(recording, moment);
        svg.add(format_args!(
            "</g>\n<rect width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#d8dde5\"/>\n",
            PICTURE[0], PICTURE[1]
        ));
        let below = PICTURE[1] + 16.0;
        svg.add(format_args!("<text y=\"{below}\" font-size=\"13\">{}</text>\n", caption(moment)));
        svg.add(format_args!(
            "<text y=\"{}\" font-size=\"12\" fill=\"{FAINT}\">{}</text>\n</g>\n",
            below + 16.0,
            escaped(words)
        ));
    }
    svg.add(format_args!("</svg>\n"));
    svg.text
}

/// The time, and the labels of the step.
fn caption(moment: &Moment) -> String {
    let mut words = format!("{:.2} s", moment.time);
    if let Some(step) = &moment.step {
        for (verb, label) in [("hears", step.heard), ("says", step.said)] {
            if let Some(label) = label {
                let _ = write!(words, ", {verb} {label}");
            }
        }
    }
    words
}

fn hex(tint: Tint) -> String {
    let [r, g, b] = tint.rgb();
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[derive(Default)]
struct Svg {
    text: String,
}

impl Svg {
    fn add(&mut self, words: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.text.write_fmt(words);
    }

    fn picture(&mut self, recording: &Recording, moment: &Moment) {
        let camera = Camera::new(PICTURE);
        self.ground(&camera, recording, moment);
        // What is farther away first.
        let mut things: Vec<(f64, String)> = Vec::new();
        for (id, parts) in shapes::at(recording, moment) {
            for (shape, tint) in parts.into_iter().filter(|_| id != "table" && id != "attention") {
                things.extend(drawn(&camera, recording, moment, shape, tint));
            }
        }
        things.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        for (_, thing) in things {
            self.text.push_str(&thing);
        }
        if let Some(centre) = shapes::attended(recording, moment) {
            let Seen { x, y, scale, .. } = camera.see(centre);
            self.add(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"/>\n",
                shapes::ATTENTION * scale,
                hex(Tint::Attention)
            ));
        }
    }

    /// The table, the shadows on it, and the place below the target.
    fn ground(&mut self, camera: &Camera, recording: &Recording, moment: &Moment) {
        let [[left, right], [near, far]] = shapes::TABLE;
        let table = recording.table;
        let corners = [[left, near, table], [left, far, table], [right, far, table], [right, near, table]];
        let style = format!("fill=\"{}\" stroke=\"#d8dde5\"", hex(Tint::Table));
        self.text.push_str(&polygon(camera, &corners, &style));
        let ring = |[x, y]: [f64; 2], radius: f64| -> Vec<[f64; 3]> {
            let angle = |at: u32| f64::from(at) / 40.0 * std::f64::consts::TAU;
            (0..40)
                .map(|at| [x + radius * libm::cos(angle(at)), y + radius * libm::sin(angle(at)), table])
                .collect()
        };
        let palm: [f64; 2] =
            std::array::from_fn(|i| moment.palm.iter().map(|corner| corner[i]).sum::<f64>() / 8.0);
        let [x, y, _] = moment.object;
        let shadow = |opacity: &str| format!("fill=\"#000000\" fill-opacity=\"{opacity}\"");
        self.text.push_str(&polygon(camera, &ring([x, y], recording.object_radius), &shadow("0.16")));
        self.text.push_str(&polygon(camera, &ring(palm, 0.04), &shadow("0.1")));
        let [x, y, _] = recording.target;
        let style = format!("fill=\"none\" stroke=\"{}\"", hex(Tint::Target));
        self.text.push_str(&polygon(camera, &ring([x, y], 0.01), &style));
    }
}

fn polygon(camera: &Camera, points: &[[f64; 3]], style: &str) -> String {
    let mut words = "<polygon points=\"".to_owned();
    for point in points {
        let Seen { x, y, .. } = camera.see(*point);
        let _ = write!(words, "{x:.1},{y:.1} ");
    }
    format!("{}\" {style}/>\n", words.trim_end())
}

/// A shape's parts, each with how far away it is.
fn drawn(
    camera: &Camera,
    recording: &Recording,
    moment: &Moment,
    shape: Shape,
    tint: Tint,
) -> Vec<(f64, String)> {
    let fill = hex(tint);
    match shape {
        Shape::Ball { centre, radius } => {
            let Seen { x, y, depth, scale } = camera.see(centre);
            let style = match tint {
                Tint::Object => "fill=\"url(#ball)\"".to_owned(),
                Tint::Around => format!("fill=\"none\" stroke=\"{fill}\" stroke-dasharray=\"4 4\""),
                _ => format!("fill=\"{fill}\""),
            };
            let mut words =
                format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" {style}/>\n", radius * scale);
            if tint == Tint::Object {
                words.push_str(&base(camera, recording, moment));
            }
            vec![(depth, words)]
        }
        Shape::Capsule { ends, radius } => {
            let [a, b] = ends.map(|end| camera.see(end));
            let scale = (a.scale + b.scale) / 2.0;
            let line = |width: f64, colour: &str| {
                format!(
                    "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{colour}\" stroke-width=\"{:.1}\" \
                     stroke-linecap=\"round\"/>\n",
                    a.x,
                    a.y,
                    b.x,
                    b.y,
                    width * scale
                )
            };
            let words = line(2.0 * radius + 0.003, FAINT) + &line(2.0 * radius, &fill);
            vec![((a.depth + b.depth) / 2.0, words)]
        }
        Shape::Box { corners } => {
            let style = format!("fill=\"{fill}\" stroke=\"{FAINT}\"");
            let face = |face: &[usize; 4]| {
                let points = face.map(|corner| corners[corner]);
                let depth = points.iter().map(|point| camera.see(*point).depth).sum::<f64>() / 4.0;
                (depth, polygon(camera, &points, &style))
            };
            FACES.iter().map(face).collect()
        }
    }
}

/// The rim of the object's flat base, which is seen from below only.
fn base(camera: &Camera, recording: &Recording, moment: &Moment) -> String {
    let [w, i, j, k] = moment.orientation;
    let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, i, j, k));
    let at = |x: f64, y: f64, z: f64| -> [f64; 3] {
        (nalgebra::Vector3::from(moment.object) + turn * nalgebra::Vector3::new(x, y, z)).into()
    };
    if camera.see(at(0.0, 0.0, -0.01)).depth > camera.see(moment.object).depth {
        return String::new();
    }
    let (radius, below) = (recording.object_radius, recording.object_base);
    let rim = (radius * radius - below * below).max(0.0).sqrt();
    let angle = |at: u32| f64::from(at) / 24.0 * std::f64::consts::TAU;
    let points: Vec<[f64; 3]> = (0..24)
        .map(|place| at(rim * libm::cos(angle(place)), rim * libm::sin(angle(place)), -below))
        .collect();
    polygon(camera, &points, "fill=\"none\" stroke=\"#000000\" stroke-opacity=\"0.33\"")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::png;
    use crate::replay::tests::recording;

    #[test]
    fn a_strip_begins_with_the_start_and_ends_with_the_end() {
        let mut recording = recording(&["grasp.steps=20"], 8);
        for moment in &mut recording.moments {
            moment.touch = [false; 6];
        }
        let moments = key_moments(&recording);
        assert_eq!(
            moments.iter().map(|(at, _)| *at).collect::<Vec<_>>(),
            [0, 5, 10, 20],
            "filled in where it is widest"
        );
        assert_eq!((moments[0].1.as_str(), moments[3].1.as_str()), ("start", "end: goal not reached"));
        recording.moments[7].touch[2] = true;
        recording.moments[7].step.as_mut().unwrap().goal = true;
        let moments = key_moments(&recording);
        assert_eq!(moments[1], (7, "goal, index touches".to_owned()));
    }

    #[test]
    fn a_short_trial_has_a_short_strip() {
        let mut recording = recording(&["grasp.steps=3"], 8);
        recording.moments.truncate(3);
        assert_eq!(key_moments(&recording).iter().map(|(at, _)| *at).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn a_strip_is_a_picture_that_says_whose_trial_it_is() {
        let mut recording = recording(&["reach.steps=8"], 1);
        recording.individual = "<e>/0/1/2".to_owned();
        let svg = strip(&recording);
        assert!(
            svg.contains("&lt;e&gt;/0/1/2, trial 1: reach") && svg.contains("0.40 s, hears reach"),
            "{svg}"
        );
        assert!(!svg.contains("NaN"));
        assert!(png(&svg).unwrap().len() > 10_000);
    }
}
