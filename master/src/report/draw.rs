//! The figures: boxplots of conditions as the paper has them, and learning curves. Each is drawn as SVG, of which the
//! PNG is a picture.

use std::error::Error;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::Condition;
use super::boxes::five_numbers;

/// Width and height in pixels.
const SIZE: (u32, u32) = (720, 480);
/// Half the width of a box, where conditions are 1 apart.
const HALF: f64 = 0.3;

type Drawn<T> = Result<T, Box<dyn Error>>;
type Chart<'a> = ChartContext<
    'a,
    SVGBackend<'a>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Boxplots of percentages, one a condition: whiskers to minimum and maximum, outliers as +.
pub(super) fn boxplots(title: &str, groups: &[(&str, Vec<f64>)]) -> Drawn<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let right = groups.len() as f64 + 0.5;
        let mut chart = layout(&root, title, (0.5..right, -2.0..102.0))?;
        let name = |x: f64| {
            let at = x.round();
            let close = (x - at).abs() < 1e-6 && at >= 1.0;
            groups.get(at as usize - usize::from(close)).filter(|_| close).map_or("", |(name, _)| *name)
        };
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .x_labels(groups.len() * 2 + 1)
            .x_label_formatter(&|x| name(*x).to_owned())
            .y_desc("successful trials, %")
            .y_label_formatter(&|y| format!("{y:.0}"))
            .draw()?;
        for (place, (_, values)) in (1..).zip(groups) {
            draw_box(&mut chart, f64::from(place), values)?;
        }
        root.present()?;
    }
    Ok(svg)
}

fn draw_box(chart: &mut Chart<'_>, x: f64, values: &[f64]) -> Drawn<()> {
    let Some(found) = five_numbers(values) else { return Ok(()) };
    let [least, lower, middle, upper, most] = found.numbers;
    let (left, right) = (x - HALF, x + HALF);
    let line = |points: Vec<(f64, f64)>, style: ShapeStyle| PathElement::new(points, style);
    let (ink, accent) = (BLUE.stroke_width(1), RED.stroke_width(2));
    // Those without length could not be drawn.
    let whiskers = [(upper, most), (lower, least)].into_iter().filter(|(from, to)| from != to);
    chart.draw_series(whiskers.map(|(from, to)| line(vec![(x, from), (x, to)], BLACK.stroke_width(1))))?;
    chart.draw_series([
        line(vec![(left, lower), (left, upper), (right, upper), (right, lower), (left, lower)], ink),
        line(vec![(x - HALF / 2.0, most), (x + HALF / 2.0, most)], BLACK.stroke_width(1)),
        line(vec![(x - HALF / 2.0, least), (x + HALF / 2.0, least)], BLACK.stroke_width(1)),
        line(vec![(left, middle), (right, middle)], accent),
    ])?;
    let plus = |y: &f64| {
        EmptyElement::at((x, *y))
            + PathElement::new(vec![(-4, 0), (4, 0)], RED)
            + PathElement::new(vec![(0, -4), (0, 4)], RED)
    };
    chart.draw_series(found.outliers.iter().map(plus))?;
    Ok(())
}

/// Share of post-evaluation's trials in which the best individual of a generation succeeds, mean over the replications.
pub(super) fn curves(title: &str, conditions: &[Condition]) -> Drawn<String> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let rows = || conditions.iter().flat_map(|condition| &condition.curve);
        let generations = rows().map(|row| row.generation + 1).max().unwrap_or(1);
        let mut chart = layout(&root, title, (0.0..f64::from(generations), -2.0..102.0))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("generation")
            .x_label_formatter(&|x| format!("{x:.0}"))
            .y_desc("successful trials, %")
            .y_label_formatter(&|y| format!("{y:.0}"))
            .draw()?;
        for (number, condition) in conditions.iter().enumerate() {
            let colour = Palette99::pick(number).to_rgba();
            chart
                .draw_series(LineSeries::new(means(condition), colour.stroke_width(2)))?
                .label(&condition.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerRight)
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.2))
            .draw()?;
        root.present()?;
    }
    Ok(svg)
}

/// Generation by generation, the mean percentage of the replications that have it.
fn means(condition: &Condition) -> Vec<(f64, f64)> {
    let generations = condition.curve.iter().map(|row| row.generation + 1).max().unwrap_or_default();
    let mut sums = vec![(0_u32, 0_u32); generations as usize];
    for row in &condition.curve {
        let (count, sum) = &mut sums[row.generation as usize];
        *count += 1;
        *sum += row.post_successes_of_40;
    }
    let points = (0_u32..).zip(sums).filter(|(_, (count, _))| *count > 0);
    points.map(|(at, (count, sum))| (f64::from(at), 2.5 * f64::from(sum) / f64::from(count))).collect()
}

fn layout<'a>(
    root: &DrawingArea<SVGBackend<'a>, Shift>,
    title: &str,
    (x, y): (std::ops::Range<f64>, std::ops::Range<f64>),
) -> Drawn<Chart<'a>> {
    let chart = ChartBuilder::on(root)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(48)
        .build_cartesian_2d(x, y)?;
    Ok(chart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::png;
    use crate::report::rows::tests::condition;
    use resvg::tiny_skia::Pixmap;

    #[test]
    fn a_boxplot_names_its_conditions_and_marks_outliers() {
        let groups = [("LE", vec![10.0, 11.0, 12.0, 13.0, 90.0]), ("LST", vec![99.0, 100.0])];
        let svg = boxplots("Figure", &groups).unwrap();
        for name in ["LE", "LST"] {
            let label = svg.lines().filter(|line| line.trim() == name).count();
            assert_eq!(label, 1, "{name}: {svg}");
        }
        let red = svg.matches("stroke=\"#FF0000\"").count();
        assert_eq!(red, 2 + 2, "two medians, and a plus of two strokes");
        let lines = |values| boxplots("Figure", &[("C", values)]).unwrap().matches("<polyline").count();
        assert_eq!(
            lines(vec![1.0, 2.0, 3.0]),
            lines(vec![2.0; 3]) + 2,
            "whiskers only where they have a length"
        );
    }

    #[test]
    fn a_curve_is_the_mean_of_the_replications() {
        assert_eq!(means(&condition("C", &[1, 2]))[3], (3.0, 60.0));
        assert!(curves("Figure", &[condition("C", &[1])]).unwrap().contains("generation"));
    }

    #[test]
    fn a_picture_is_twice_as_large_and_has_its_words() {
        let bytes = png(&boxplots("Figure", &[("C", vec![1.0, 2.0])]).unwrap()).unwrap();
        let picture = Pixmap::decode_png(&bytes).unwrap();
        assert_eq!((picture.width(), picture.height()), (1440, 960));
        // The title's strip is not empty, as it is without a font.
        let title = &picture.pixels()[..1440 * 60];
        assert!(title.iter().any(|pixel| pixel.red() < 128));
    }
}
