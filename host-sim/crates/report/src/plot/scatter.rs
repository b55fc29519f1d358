//! One quantity over another: clouds of points, ranges with their medians, curves.

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Style;
use super::axis::{Axis, extent};
use super::canvas::{
    Area, Drawn, FAINT_INK, FRAME, GRID, INK, PAPER, SHADE, TextPlace, drawn, fine, line, look, text_width, write,
    write_at,
};

const WIDTH: i32 = 580;
const HEIGHT: i32 = 410;
const LEFT: i32 = 74;
const RIGHT: i32 = WIDTH - 18;
const TOP: i32 = 84;
const BOTTOM: i32 = HEIGHT - 52;

/// The values in one range of x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeBin {
    /// Median x.
    pub x: f64,
    /// First quartile, median and third quartile of y.
    pub quartiles: [f64; 3],
}

/// How a layer is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum Marks {
    /// Single points.
    Dots(Vec<(f64, f64)>),
    /// Points with a line through them.
    Line(Vec<(f64, f64)>),
    /// Median of the values in a range of x, with the quartiles.
    Bins(Vec<RangeBin>),
}

/// One layer, drawn over those before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Its name in the legend; empty to leave it out.
    pub label: String,
    /// What it shows, which determines how it is drawn.
    pub style: Style,
    /// What is drawn.
    pub marks: Marks,
}

/// A chart of one quantity over another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// What is shown.
    pub title: String,
    /// Title of the horizontal axis, with its unit.
    pub x: String,
    /// Title of the vertical axis, with its unit.
    pub y: String,
    /// The layers.
    pub layers: Vec<Layer>,
    /// Values of y within ± this are shaded.
    pub band: Option<f64>,
}

/// Draws a chart; the text of an SVG with a `viewBox`, 580 px wide.
#[must_use]
pub fn scatter(figure: &Figure) -> String {
    drawn((WIDTH, HEIGHT), |area| draw(area, figure))
}

fn draw(area: &Area<'_>, figure: &Figure) -> Drawn {
    area.fill(&PAPER)?;
    write(area, &figure.title, (LEFT, 10), 15, INK, HPos::Left)?;
    write(area, &figure.y, (LEFT, 60), 12, FAINT_INK, HPos::Left)?;
    write(area, &figure.x, (i32::midpoint(LEFT, RIGHT), HEIGHT - 24), 12, INK, HPos::Center)?;
    legend(area, figure)?;
    let points: Vec<(f64, f64)> = figure.layers.iter().flat_map(|layer| corners(&layer.marks)).collect();
    let (xs, mut ys): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
    ys.extend(figure.band.into_iter().flat_map(|band| [-band, band]));
    let across = Axis::airy(extent(xs.iter()), LEFT, RIGHT);
    let upwards = Axis::airy(extent(ys.iter()), BOTTOM, TOP);
    if let Some(band) = figure.band {
        let ends = [fine((LEFT, upwards.pixel(band))), fine((RIGHT, upwards.pixel(-band)))];
        area.draw(&Rectangle::new(ends, SHADE.filled()))?;
    }
    for (value, label) in across.ticks(7.0) {
        let x = across.pixel(value);
        let colour = if value == 0.0 { FRAME } else { GRID };
        area.draw(&PathElement::new(vec![fine((x, TOP)), fine((x, BOTTOM))], line(colour, 1.0)))?;
        write(area, &label, (x, BOTTOM + 7), 12, INK, HPos::Center)?;
    }
    for (value, label) in upwards.ticks(6.0) {
        let y = upwards.pixel(value);
        let colour = if value == 0.0 { FRAME } else { GRID };
        area.draw(&PathElement::new(vec![fine((LEFT, y)), fine((RIGHT, y))], line(colour, 1.0)))?;
        let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 12 };
        write_at(area, &label, (LEFT - 8, y), right, INK)?;
    }
    let corners = [(LEFT, TOP), (RIGHT, TOP), (RIGHT, BOTTOM), (LEFT, BOTTOM), (LEFT, TOP)];
    area.draw(&PathElement::new(corners.map(fine).to_vec(), line(FRAME, 1.0)))?;
    let (across, upwards) = (across.scaled(super::canvas::FINE), upwards.scaled(super::canvas::FINE));
    let at = |x: f64, y: f64| (across.pixel(x), upwards.pixel(y));
    for layer in &figure.layers {
        let (colour, stroke) = look(layer.style);
        match &layer.marks {
            Marks::Dots(points) => {
                for (x, y) in finite(points) {
                    area.draw(&Circle::new(at(x, y), 14, colour.mix(0.7).filled()))?;
                }
            }
            Marks::Line(points) => {
                let path: Vec<(i32, i32)> = finite(points).map(|(x, y)| at(x, y)).collect();
                if path.len() > 1 {
                    area.draw(&PathElement::new(path, stroke))?;
                }
            }
            Marks::Bins(bins) => {
                for bin in bins.iter().filter(|bin| bin.x.is_finite() && bin.quartiles.iter().all(|y| y.is_finite())) {
                    let [low, middle, high] = bin.quartiles;
                    area.draw(&PathElement::new(vec![at(bin.x, low), at(bin.x, high)], line(INK, 1.0)))?;
                    area.draw(&Circle::new(at(bin.x, middle), 22, INK.filled()))?;
                }
            }
        }
    }
    Ok(())
}

fn legend(area: &Area<'_>, figure: &Figure) -> Drawn {
    let mut right = RIGHT;
    for layer in figure.layers.iter().rev().filter(|layer| !layer.label.is_empty()) {
        write(area, &layer.label, (right, 36), 12, INK, HPos::Right)?;
        right -= text_width(&layer.label, 12) + 8;
        let (colour, stroke) = look(layer.style);
        if matches!(layer.marks, Marks::Dots(_)) {
            area.draw(&Circle::new(fine((right - 6, 43)), 30, colour.filled()))?;
        } else {
            area.draw(&PathElement::new(vec![fine((right - 22, 43)), fine((right, 43))], stroke))?;
        }
        right -= 22 + 18;
    }
    Ok(())
}

fn finite(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + '_ {
    points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite())
}

/// Points that have to be on the chart.
fn corners(marks: &Marks) -> Vec<(f64, f64)> {
    match marks {
        Marks::Dots(points) | Marks::Line(points) => finite(points).collect(),
        Marks::Bins(bins) => {
            bins.iter().flat_map(|bin| [(bin.x, bin.quartiles[0]), (bin.x, bin.quartiles[2])]).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_every_kind_of_mark_and_escapes_its_words() {
        let layer = |label: &str, style, marks| Layer { label: label.into(), style, marks };
        let figure = Figure {
            title: "a < b".into(),
            x: "velocity [mm/s]".into(),
            y: "force [N]".into(),
            layers: vec![
                layer("recorded", Style::Recorded, Marks::Dots(vec![(0.0, 1.0), (f64::NAN, 2.0), (3.0, 4.0)])),
                layer("", Style::Recorded, Marks::Bins(vec![RangeBin { x: 1.0, quartiles: [0.0, 1.0, 2.0] }])),
                layer("model after", Style::After, Marks::Line(vec![(0.0, 0.0), (3.0, f64::INFINITY), (4.0, 2.0)])),
            ],
            band: Some(0.5),
        };
        let text = scatter(&figure);
        assert!(text.contains("a &lt; b") && text.contains("model after") && text.contains("<circle"));
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert!(scatter(&Figure::default()).starts_with("<svg"));
    }
}
