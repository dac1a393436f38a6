//! A Hinton diagram: a square for each number, as large as the number is, with the colour of its sign.

use std::fmt::Write;

use selftalk_sim::controller::{Parameter, Role};

use super::{Block, blocks};
use crate::picture::escaped;

/// Side of a cell in pixels.
const CELL: f64 = 16.0;
/// Room for the names of rows, and of columns, which stand upright.
const NAMES: [f64; 2] = [122.0, 64.0];
/// Room between the tables, and above a table for its title.
const GAP: f64 = 30.0;
const MARGIN: f64 = 12.0;
const POSITIVE: &str = "#c2410c";
const NEGATIVE: &str = "#1d4ed8";
const GROUND: &str = "#f1f3f6";

/// The diagram of a controller, as SVG.
#[must_use]
pub fn diagram(title: &str, parameters: &[Parameter]) -> String {
    let blocks = blocks(parameters);
    // Time constants go up to 1 whatever the weights do.
    let weights = parameters.iter().filter(|parameter| parameter.role != Role::Kept);
    let most = weights.map(|parameter| parameter.value.abs()).fold(1e-9, f64::max);
    let size = |block: &Block| {
        [NAMES[0] + CELL * block.columns.len() as f64, GAP + NAMES[1] + CELL * block.rows.len() as f64]
    };
    let width = MARGIN * 2.0 + blocks.iter().map(|block| size(block)[0]).fold(0.0, f64::max);
    let height = MARGIN * 2.0 + GAP + blocks.iter().map(|block| size(block)[1]).sum::<f64>() + GAP;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\" fill=\"#1c2430\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"{MARGIN}\" y=\"{}\" font-size=\"14\">{}</text>\n",
        MARGIN + 10.0,
        escaped(title)
    );
    let mut top = MARGIN + GAP;
    for block in &blocks {
        draw(&mut svg, block, top, most);
        top += size(block)[1];
    }
    // The legend.
    let mut left = MARGIN;
    for (colour, words) in [
        (POSITIVE, "positive".to_owned()),
        (NEGATIVE, "negative".to_owned()),
        ("", format!("a full square is {most:.2}, of a time constant 1")),
    ] {
        if !colour.is_empty() {
            let _ = writeln!(
                svg,
                "<rect x=\"{left}\" y=\"{}\" width=\"10\" height=\"10\" fill=\"{colour}\"/>",
                top + 6.0
            );
            left += 14.0;
        }
        let _ = writeln!(svg, "<text x=\"{left}\" y=\"{}\">{words}</text>", top + 15.0);
        left += 62.0;
    }
    svg.push_str("</svg>\n");
    svg
}

fn draw(svg: &mut String, block: &Block, top: f64, most: f64) {
    let (left, first) = (MARGIN + NAMES[0], top + GAP + NAMES[1]);
    let (width, height) = (CELL * block.columns.len() as f64, CELL * block.rows.len() as f64);
    let _ =
        writeln!(svg, "<text x=\"{MARGIN}\" y=\"{}\" font-size=\"12\">{}</text>", top + 22.0, block.title);
    let _ = writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{first}\" width=\"{width}\" height=\"{height}\" fill=\"{GROUND}\"/>"
    );
    for (name, at) in block.columns.iter().zip(0_u32..) {
        let (x, y) = (left + CELL * f64::from(at) + 12.0, first - 5.0);
        let _ = writeln!(svg, "<text transform=\"translate({x} {y}) rotate(-90)\">{}</text>", escaped(name));
    }
    for ((name, values), at) in block.rows.iter().zip(&block.values).zip(0_u32..) {
        let y = first + CELL * f64::from(at);
        let (x, middle) = (left - 5.0, y + 12.0);
        let _ = writeln!(svg, "<text x=\"{x}\" y=\"{middle}\" text-anchor=\"end\">{}</text>", escaped(name));
        for (value, at) in values.iter().zip(0_u32..) {
            let Some(value) = value else { continue };
            let name_of_column = block.columns.get(at as usize).map_or("", String::as_str);
            let kept = [name.as_str(), name_of_column].contains(&"time constant");
            let full = if kept { 1.0 } else { most };
            // The area is the number.
            let side = (CELL - 2.0) * (value.abs() / full).min(1.0).sqrt();
            let (x, y) = (left + CELL * (f64::from(at) + 0.5) - side / 2.0, y + (CELL - side) / 2.0);
            let colour = if *value < 0.0 { NEGATIVE } else { POSITIVE };
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{side:.2}\" height=\"{side:.2}\" fill=\"{colour}\"/>"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::png;
    use crate::weights::tests::parameters;
    use selftalk_sim::experiment::Added;

    #[test]
    fn every_number_has_a_square_and_every_neuron_its_name() {
        let parameters = parameters(Added::Speech);
        let svg = diagram("quickstart/0/59/12", &parameters);
        let squares = svg.matches("<rect x=").count();
        assert_eq!(squares, parameters.len() + 3 + 2, "numbers, grounds and legend");
        for name in [
            "quickstart/0/59/12",
            "touch_thumb",
            "internal_14",
            "added_3",
            "finger_flexion",
            "move-to-target",
        ] {
            assert!(svg.contains(&format!(">{name}<")), "{name}");
        }
        assert!(png(&svg).unwrap().len() > 10_000);
    }
}
