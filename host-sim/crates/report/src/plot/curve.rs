//! One quantity over another: a static characteristic.

use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;
use plotters::element::PathElement;
use plotters::style::RGBColor;
use plotters::style::text_anchor::HPos;

use super::axis::{Axis, extent};
use super::canvas::{
    Area, BOTTOM, Drawn, FAINT_INK, FINE, FRAME, GRID, INK, LEFT, PAPER, RIGHT, WIDTH, fine, line, write,
};

/// A place on the horizontal axis that is marked by a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Its label.
    pub label: String,
    /// Its value.
    pub at: f64,
}

/// A line of a drawing: `y` over `x` in the order of the rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<'a> {
    /// Its name in the legend; empty where there is only one.
    pub label: String,
    /// Values across.
    pub x: &'a [f64],
    /// Values upwards.
    pub y: &'a [f64],
}

/// Colours of the lines, told apart by colour-blind eyes as well (Okabe and Ito 2008).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 96, 176),
    RGBColor(214, 96, 0),
    RGBColor(0, 140, 100),
    RGBColor(180, 90, 150),
    RGBColor(90, 160, 215),
    RGBColor(110, 98, 84),
];
const UPPER_EDGE: i32 = 66;
const LOWER_EDGE: i32 = 466;
/// Beyond this number, points cannot be distinguished and are left out evenly.
const MOST_POINTS: usize = 6000;

/// Draws each series over axes with these headers; the text of an SVG.
#[must_use]
#[expect(clippy::missing_panics_doc, reason = "drawing into a text does not fail")]
pub fn curve(title: &str, across: &str, up: &str, series: &[Series<'_>], marks: &[Mark]) -> String {
    let height = LOWER_EDGE + 30 + BOTTOM;
    let mut text = String::new();
    {
        let size = ((WIDTH * FINE).unsigned_abs(), (height * FINE).unsigned_abs());
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area, title, (across, up), series, marks).expect("drawing into a text does not fail");
        area.present().expect("drawing into a text does not fail");
    }
    let fine = format!("width=\"{}\" height=\"{}\"", WIDTH * FINE, height * FINE);
    text.replacen(&fine, &format!("width=\"{WIDTH}\" height=\"{height}\""), 1)
}

fn draw(area: &Area<'_>, title: &str, headers: (&str, &str), series: &[Series<'_>], marks: &[Mark]) -> Drawn {
    area.fill(&PAPER)?;
    write(area, title, (LEFT, 16), 20, INK, HPos::Left)?;
    write(area, headers.1, (LEFT, 44), 13, INK, HPos::Left)?;
    let across = Axis::airy(extent(series.iter().flat_map(|one| one.x)), LEFT, RIGHT);
    let up = Axis::airy(extent(series.iter().flat_map(|one| one.y)), LOWER_EDGE, UPPER_EDGE);
    for (value, label) in across.ticks(10.0) {
        let at = across.pixel(value);
        area.draw(&PathElement::new(vec![fine((at, UPPER_EDGE)), fine((at, LOWER_EDGE))], line(GRID, 1.0)))?;
        write(area, &label, (at, LOWER_EDGE + 7), 12, INK, HPos::Center)?;
    }
    for (value, label) in up.ticks(8.0) {
        let at = up.pixel(value);
        area.draw(&PathElement::new(vec![fine((LEFT, at)), fine((RIGHT, at))], line(GRID, 1.0)))?;
        write(area, &label, (LEFT - 8, at - 6), 12, INK, HPos::Right)?;
    }
    for (index, mark) in (0..).zip(marks) {
        let at = across.pixel(mark.at);
        area.draw(&PathElement::new(vec![fine((at, UPPER_EDGE)), fine((at, LOWER_EDGE))], line(FAINT_INK, 1.2)))?;
        write(area, &mark.label, (at + 4, UPPER_EDGE + 4 + 15 * index), 12, FAINT_INK, HPos::Left)?;
    }
    let axes = (across.scaled(FINE), up.scaled(FINE));
    for ((index, one), colour) in (0..).zip(series).zip(COLOURS.into_iter().cycle()) {
        let every = one.x.len().div_ceil(MOST_POINTS).max(1);
        let finite = one.x.iter().zip(one.y).filter(|(x, y)| x.is_finite() && y.is_finite());
        let path: Vec<(i32, i32)> = finite.step_by(every).map(|(x, y)| (axes.0.pixel(*x), axes.1.pixel(*y))).collect();
        if path.len() > 1 {
            area.draw(&PathElement::new(path, line(colour, 1.5)))?;
        }
        write(area, &one.label, (RIGHT - 6, UPPER_EDGE + 6 + 16 * index), 12, colour, HPos::Right)?;
    }
    let (top, bottom) = (UPPER_EDGE, LOWER_EDGE);
    let corners = [(LEFT, top), (RIGHT, top), (RIGHT, bottom), (LEFT, bottom), (LEFT, top)];
    area.draw(&PathElement::new(corners.map(fine).to_vec(), line(FRAME, 1.0)))?;
    write(area, headers.0, (i32::midpoint(LEFT, RIGHT), LOWER_EDGE + 28), 13, INK, HPos::Center)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_has_its_headers_and_marks_and_odd_values_are_left_out() {
        let mark = Mark { label: "null".to_owned(), at: 0.5 };
        let series = |label: &str, y: &'static [f64]| Series { label: label.to_owned(), x: &[0.0, 1.0, f64::NAN], y };
        let both = [series("slow", &[1.0, 2.0, 3.0]), series("fast", &[2.0, 1.0, 0.0])];
        let text = curve("a < b", "I [mA]", "Q", &both, &[mark]);
        assert!(text.contains("slow") && text.contains("fast"), "{text}");
        assert!(text.contains("a &lt; b") && text.contains("I [mA]") && text.contains("null"), "{text}");
        assert!(!text.contains("NaN"));
        assert!(curve("", "", "", &[], &[]).contains("<svg"));
    }
}
