//! Panels drawn one below the other.

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{PathElement, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoFont, RGBAColor, RGBColor, ShapeStyle, TextStyle};

use recording::files::source_error::printable;

use super::axis::{Axis, extent};
use super::thin::thinned;
use super::{Panel, Style, Trace};

/// Width of a figure, px.
pub(crate) const WIDTH: i32 = 1000;
/// Coordinates inside the SVG are this many times finer than a pixel, since they are whole numbers.
pub(crate) const FINE: i32 = 8;

pub(crate) const LEFT: i32 = 74;
pub(crate) const RIGHT: i32 = WIDTH - 22;
const TOP: i32 = 66;
pub(crate) const BOTTOM: i32 = 34;
const HEADING: i32 = 40;
/// Labels of the time axis below each panel.
const LABELS: i32 = 26;
const UPPER: i32 = 150;
/// Between a chart and the residuals below it, with room for their caption.
const GAP: i32 = 24;
const LOWER: i32 = 74;
const INPUT: i32 = 84;

pub(crate) const INK: RGBColor = RGBColor(33, 37, 41);
pub(crate) const FAINT_INK: RGBColor = RGBColor(95, 103, 112);
pub(crate) const GRID: RGBColor = RGBColor(228, 231, 235);
pub(crate) const FRAME: RGBColor = RGBColor(176, 183, 191);
pub(crate) const PAPER: RGBColor = RGBColor(255, 255, 255);
pub(crate) const SHADE: RGBAColor = RGBAColor(255, 193, 7, 0.28);

/// Colours of several simulations, told apart by eyes that confuse red and green; the page's style has the same.
pub(crate) const MODELS: [RGBColor; 6] = [
    RGBColor(0, 96, 176),
    RGBColor(214, 96, 0),
    RGBColor(0, 133, 92),
    RGBColor(178, 60, 140),
    RGBColor(138, 106, 0),
    RGBColor(90, 70, 190),
];

pub(crate) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(crate) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Draws panels below each other over one time axis; the text of an SVG with a `viewBox`, 1000 px wide.
///
/// Series of more than 2000 points are thinned: the lowest and the highest point of each stretch stay.
#[must_use]
pub fn svg(title: &str, subtitle: &str, panels: &[Panel]) -> String {
    let height = head(title) + panels.iter().map(height_of).sum::<i32>() + BOTTOM;
    drawn((WIDTH, height), |area| draw(area, title, subtitle, panels))
}

/// The text of an SVG of this size in px.
pub(crate) fn drawn((width, height): (i32, i32), draw: impl FnOnce(&Area<'_>) -> Drawn) -> String {
    let mut text = String::new();
    {
        let size = ((width * FINE).unsigned_abs(), (height * FINE).unsigned_abs());
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area).expect("drawing into a text does not fail");
        area.present().expect("drawing into a text does not fail");
    }
    let fine = format!("width=\"{}\" height=\"{}\"", width * FINE, height * FINE);
    text.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1)
}

/// Room for the title; little without a title.
fn head(title: &str) -> i32 {
    if title.is_empty() { 0 } else { TOP }
}

fn height_of(panel: &Panel) -> i32 {
    HEADING + if panel.residuals.is_empty() { chart_height(panel) } else { chart_height(panel) + GAP + LOWER } + LABELS
}

/// A drive input needs less room than a judged signal.
fn chart_height(panel: &Panel) -> i32 {
    if panel.traces.iter().all(|trace| trace.style == Style::Input) { INPUT } else { UPPER }
}

fn draw(area: &Area<'_>, title: &str, subtitle: &str, panels: &[Panel]) -> Drawn {
    area.fill(&PAPER)?;
    write(area, title, (LEFT, 16), 20, INK, HPos::Left)?;
    write(area, subtitle, (LEFT, 42), 13, FAINT_INK, HPos::Left)?;
    let times = panels.iter().flat_map(|panel| [panel.time_s.first(), panel.time_s.last()]).flatten();
    let time = Axis::exact(extent(times), LEFT, RIGHT);
    let mut top = head(title);
    for panel in panels {
        heading(area, panel, top)?;
        let upper = (top + HEADING, top + HEADING + chart_height(panel));
        chart(area, panel, &panel.traces, &time, upper, false)?;
        let mut bottom = upper.1;
        if !panel.residuals.is_empty() {
            let lower = (upper.1 + GAP, upper.1 + GAP + LOWER);
            chart(area, panel, &panel.residuals, &time, lower, true)?;
            bottom = lower.1;
        }
        for (value, label) in time.ticks(10.0) {
            write(area, &label, (time.pixel(value), bottom + 7), 12, INK, HPos::Center)?;
        }
        top += height_of(panel);
    }
    write(area, "time [s]", (i32::midpoint(LEFT, RIGHT), top + 4), 13, INK, HPos::Center)
}

/// Title, unit and remark on the left, the legend on the right.
fn heading(area: &Area<'_>, panel: &Panel, top: i32) -> Drawn {
    let y = top + 17;
    let title = format!("{} [{}]", panel.title, panel.unit);
    write(area, &title, (LEFT, y), 15, INK, HPos::Left)?;
    let mut right = RIGHT;
    for trace in panel.traces.iter().rev() {
        let (_, look) = look(trace.style);
        write(area, &trace.label, (right, y + 2), 13, INK, HPos::Right)?;
        right -= text_width(&trace.label, 13) + 8;
        area.draw(&PathElement::new(vec![fine((right - 26, y + 8)), fine((right, y + 8))], look))?;
        right -= 26 + 22;
    }
    let left = LEFT + text_width(&title, 15) + 18;
    write(area, &fitting(&panel.note, right - left, 13), (left, y + 2), 13, FAINT_INK, HPos::Left)
}

/// As much of a text as is about this wide, px.
fn fitting(text: &str, width: i32, size: i32) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut shorter: String = text.to_owned();
    while shorter.pop().is_some() && text_width(&shorter, size) + size > width {}
    if shorter.is_empty() { shorter } else { shorter.trim_end().to_owned() + "…" }
}

/// Axes, grid, shaded intervals and lines between two heights.
fn chart(
    area: &Area<'_>,
    panel: &Panel,
    traces: &[Trace],
    time: &Axis,
    (top, bottom): (i32, i32),
    lower: bool,
) -> Drawn {
    let mut range = extent(traces.iter().flat_map(|trace| &trace.values));
    if lower {
        range = (range.0.min(0.0), range.1.max(0.0));
    }
    let vertical = Axis::airy(range, bottom, top);
    for &(from_s, to_s) in &panel.intervals {
        let (from, to) = (time.pixel(from_s), time.pixel(to_s).max(time.pixel(from_s) + 3));
        area.draw(&Rectangle::new([fine((from, top)), fine((to, bottom))], SHADE.filled()))?;
    }
    for (value, _) in time.ticks(10.0) {
        let x = time.pixel(value);
        area.draw(&PathElement::new(vec![fine((x, top)), fine((x, bottom))], line(GRID, 1.0)))?;
    }
    for (value, label) in vertical.ticks(if lower { 4.0 } else { 5.0 * f64::from(bottom - top) / f64::from(UPPER) }) {
        let y = vertical.pixel(value);
        let colour = if lower && value == 0.0 { FRAME } else { GRID };
        area.draw(&PathElement::new(vec![fine((LEFT, y)), fine((RIGHT, y))], line(colour, 1.0)))?;
        let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 12 };
        write_at(area, &label, (LEFT - 8, y), right, INK)?;
    }
    let fine_time = time.scaled(FINE);
    let fine_vertical = vertical.scaled(FINE);
    for trace in traces {
        let points = thinned(&panel.time_s, &trace.values, panel.points);
        let path: Vec<(i32, i32)> =
            points.into_iter().map(|(time, value)| (fine_time.pixel(time), fine_vertical.pixel(value))).collect();
        if path.len() > 1 {
            area.draw(&PathElement::new(path, look(trace.style).1))?;
        }
    }
    let corners = [(LEFT, top), (RIGHT, top), (RIGHT, bottom), (LEFT, bottom), (LEFT, top)];
    area.draw(&PathElement::new(corners.map(fine).to_vec(), line(FRAME, 1.0)))?;
    if lower {
        let caption = format!("recorded − simulated [{}]", panel.unit);
        write(area, &caption, (LEFT, top - 17), 12, FAINT_INK, HPos::Left)?;
    }
    Ok(())
}

/// Colour and line of a style.
pub(crate) fn look(style: Style) -> (RGBColor, ShapeStyle) {
    let (colour, width) = match style {
        Style::Input => (RGBColor(110, 98, 84), 1.4),
        Style::Recorded => (RGBColor(173, 181, 189), 4.0),
        Style::Channel => (RGBColor(0, 96, 176), 1.2),
        Style::Simulated | Style::After => (RGBColor(0, 96, 176), 1.5),
        Style::Before => (RGBColor(214, 96, 0), 1.5),
        Style::Model(index) => (MODELS[usize::from(index) % MODELS.len()], 1.5),
    };
    (colour, line(colour, width))
}

pub(crate) fn line(colour: RGBColor, width_px: f64) -> ShapeStyle {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few pixels")]
    let width = (width_px * f64::from(FINE)).round() as u32;
    colour.stroke_width(width)
}

pub(crate) fn fine((x, y): (i32, i32)) -> (i32, i32) {
    (x * FINE, y * FINE)
}

#[derive(Clone, Copy)]
pub(crate) struct TextPlace {
    pub(crate) anchor: Pos,
    pub(crate) size: i32,
}

pub(crate) fn write(area: &Area<'_>, text: &str, at: (i32, i32), size: i32, colour: RGBColor, side: HPos) -> Drawn {
    write_at(area, text, at, TextPlace { anchor: Pos::new(side, VPos::Top), size }, colour)
}

pub(crate) fn write_at(area: &Area<'_>, text: &str, at: (i32, i32), place: TextPlace, colour: RGBColor) -> Drawn {
    if text.is_empty() {
        return Ok(());
    }
    // The SVG backend writes a font size that is smaller by this factor.
    let size = 1.24 * f64::from(place.size * FINE);
    let style: TextStyle<'_> = ("sans-serif", size).into_font().color(&colour).pos(place.anchor);
    // XML has no control characters, not even escaped ones.
    area.draw(&Text::new(printable(&text), fine(at), style))
}

/// Approximate width of a text, px: no font is available.
pub(crate) fn text_width(text: &str, size: i32) -> i32 {
    let letters = i32::try_from(text.chars().count()).unwrap_or(i32::MAX / 100).min(10_000);
    letters * size * 50 / 100
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> Panel {
        let time_s: Vec<f64> = (0..5000).map(|k| f64::from(k) * 1e-3).collect();
        let wave = |shift: f64| time_s.iter().map(|time| 12.0 * (time - shift).sin() + 150.0).collect::<Vec<f64>>();
        Panel::new("Position", "mm", time_s.clone())
            .note("NRMSE fit 97.10 % before, 99.80 % after")
            .trace(Trace::new("recorded", wave(0.0), Style::Recorded))
            .trace(Trace::new("before", wave(0.1), Style::Before))
            .trace(Trace::new("after", wave(0.01), Style::After))
            .residuals()
            .shade(1.2, 1.5)
    }

    #[test]
    fn a_figure_scales_and_asks_for_no_font_of_this_machine() {
        let text = svg("Holdout 1", "press-63-40", &[panel(), panel()]);
        let size = "width=\"1000\" height=\"728\" viewBox=\"0 0 8000 5824\"";
        assert!(text.contains(size), "{}", text.lines().next().unwrap());
        assert!(text.contains("font-family=\"sans-serif\"") && !text.contains("NaN") && !text.contains("inf"));
        assert_eq!(text.matches("before").count(), 2 * 2, "in the legend and the remark of each panel");
        assert_eq!(text, svg("Holdout 1", "press-63-40", &[panel(), panel()]));
        assert!(text.len() < 300_000, "{}", text.len());
    }

    #[test]
    fn text_is_escaped_and_odd_values_are_left_out() {
        let odd = Panel::new("a < b & c", "1", vec![0.0, 1.0, f64::NAN])
            .trace(Trace::new("<recorded>", vec![f64::NAN, f64::INFINITY, 1.0], Style::Recorded))
            .trace(Trace::new("simulated", vec![], Style::Simulated))
            .residuals()
            .shade(f64::NAN, 2.0);
        let text = svg("\"quoted\" <title>", "", &[odd, Panel::default()]);
        assert!(text.contains("a &lt; b &amp; c") && text.contains("&lt;title&gt;"), "{text}");
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert!(svg("nothing", "", &[]).contains("<svg"));
    }

    #[test]
    fn a_name_with_what_xml_has_not_is_drawn_without_it() {
        let panel = Panel::new("a\u{1}b\u{fffe}", "mm", vec![0.0, 1.0]).trace(Trace::new(
            "re\u{2}corded",
            vec![0.0, 1.0],
            Style::Recorded,
        ));
        let drawn = svg("na\u{7f}med", "", &[panel]);
        assert!(!drawn.contains(['\u{1}', '\u{2}', '\u{7f}', '\u{fffe}']) && drawn.contains("\\u{1}"));
    }
}
