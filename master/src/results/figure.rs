//! The figure of an experiment: how successful the best individuals were, generation by generation.

use std::error::Error;
use std::path::Path;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::{GenerationRow, Results};

/// Width and height in pixels.
const SIZE: (u32, u32) = (1200, 480);
/// Most points of a curve. Each is a mean over as many generations, as single ones jump with their draws.
const POINTS: u32 = 75;

type Drawn = Result<(), Box<dyn Error>>;
type Curve = Vec<(f64, f64)>;
type Successes = fn(&GenerationRow) -> u32;

/// Draws the curves of all replications, and of each behaviour over all replications.
pub(super) fn draw(results: &Results, path: &Path) -> Drawn {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let generations = results.generations.iter().map(|row| row.generation + 1).max().unwrap_or(1);
    let (left, right) = root.split_horizontally(SIZE.0 / 2);
    let replications: Vec<(String, Curve)> = results
        .summary
        .iter()
        .map(|summary| {
            let own = |row: &&GenerationRow| row.replication == summary.replication;
            let rows = results.generations.iter().filter(own);
            let label = format!("replication {}", summary.replication);
            (label, curve(rows.map(|row| (row.generation, row.best_successes)), generations))
        })
        .collect();
    panel(&left, "Successful trials of the best individual, of 16", generations, 16.0, &replications)?;
    let behaviours: [(&str, Successes); 4] = [
        ("REACH", |row| row.reach),
        ("OPEN", |row| row.open),
        ("GRASP", |row| row.grasp),
        ("MOVE", |row| row.transport),
    ];
    let behaviours: Vec<(String, Curve)> = behaviours
        .into_iter()
        .map(|(name, of)| {
            let all = results.generations.iter().map(|row| (row.generation, of(row)));
            (name.to_owned(), curve(all, generations))
        })
        .collect();
    panel(&right, "By behaviour, of 4, mean of all replications", generations, 4.0, &behaviours)?;
    Ok(root.present()?)
}

/// Means over equally long stretches of generations, each at its middle.
fn curve(values: impl Iterator<Item = (u32, u32)>, generations: u32) -> Curve {
    let length = generations.div_ceil(POINTS).max(1);
    let mut stretches = vec![(0_u32, 0_u32); generations.div_ceil(length) as usize];
    for (generation, value) in values {
        let (count, sum) = &mut stretches[(generation / length) as usize];
        *count += 1;
        *sum += value;
    }
    let middles = (0..).map(|stretch| (f64::from(stretch) + 0.5) * f64::from(length));
    // Of generations that few replications have yet, the mean would say something else.
    let most = stretches.iter().map(|(count, _)| *count).max().unwrap_or_default();
    let points = middles.zip(stretches).filter(|(_, (count, _))| *count > 0 && 2 * count >= most);
    points.map(|(middle, (count, sum))| (middle, f64::from(sum) / f64::from(count))).collect()
}

fn panel(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    title: &str,
    generations: u32,
    most: f64,
    curves: &[(String, Curve)],
) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(40)
        .build_cartesian_2d(0.0..f64::from(generations), 0.0..most * 1.02)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("generation")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0}"))
        .y_labels(if most > 8.0 { 9 } else { 5 })
        .draw()?;
    for (number, (label, points)) in curves.iter().enumerate() {
        let colour = Palette99::pick(number).to_rgba();
        chart
            .draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(2)))?
            .label(label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_the_mean_of_its_stretch() {
        let values = [(0, 1), (1, 2), (2, 6), (1, 4), (2, 8)];
        assert_eq!(curve(values.into_iter(), 4), [(0.5, 1.0), (1.5, 3.0), (2.5, 7.0)]);
        let uneven = [(0, 1), (0, 2), (0, 3), (1, 9)];
        assert_eq!(curve(uneven.into_iter(), 2), [(0.5, 2.0)], "one of three is too few");
        let long = curve((0..200).map(|generation| (generation, generation / 100)), 200);
        assert_eq!(long.len(), 67);
        assert_eq!(long[0], (1.5, 0.0));
        assert_eq!(long[66], (199.5, 1.0));
    }
}
