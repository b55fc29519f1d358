//! One amount over some nights, small: one of many charts of a hall.

use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{Axis, extent};
use super::canvas::{
    Area, Drawn, FAINT_INK, FINE, FRAME, GRID, INK, PAPER, TextPlace, drawn, fine, line, text_width, write, write_at,
};

const WIDTH: i32 = 300;
const HEIGHT: i32 = 170;
const LEFT: i32 = 40;
const RIGHT: i32 = WIDTH - 8;
const TOP: i32 = 38;
const BOTTOM: i32 = HEIGHT - 22;
const STEADY: RGBColor = RGBColor(0, 96, 176);
const URGENT: RGBColor = RGBColor(214, 96, 0);
const LIMIT: RGBColor = RGBColor(176, 42, 55);

/// An amount in one night.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amount {
    /// The night, in days.
    pub day: f64,
    /// The amount.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
    /// Whether it takes no part.
    pub is_odd: bool,
}

/// A stretch without a change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Day and value, where it begins and ends.
    pub ends: [(f64, f64); 2],
}

/// One amount over some nights.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Multiple {
    /// Whose it is.
    pub title: String,
    /// Of what.
    pub subtitle: String,
    /// Its unit.
    pub unit: String,
    /// The magnitude that determines the power of ten in which it is written; 0 for its own.
    pub usual: f64,
    /// The first and the last day.
    pub days: (f64, f64),
    /// The same as they are written.
    pub ends: [String; 2],
    /// The nights.
    pub points: Vec<Amount>,
    /// The model between changes.
    pub pieces: Vec<Piece>,
    /// Days on which it changed.
    pub changes: Vec<f64>,
    /// How much there may be.
    pub limit: Option<f64>,
    /// Whether it is to be looked at.
    pub is_urgent: bool,
    /// The last piece, continued to its limit, and the date of that.
    pub ahead: Option<([(f64, f64); 2], String)>,
}

/// Draws it; the text of an SVG with a `viewBox`, 300 px wide.
#[must_use]
pub fn multiple(figure: &Multiple) -> String {
    drawn((WIDTH, HEIGHT), |area| draw(area, figure))
}

/// A power of ten with which values have few digits, and how it is written before a unit.
fn scale(largest: f64) -> (f64, String) {
    if largest == 0.0 || (1e-2..1e4).contains(&largest) {
        return (1.0, String::new());
    }
    #[expect(clippy::cast_possible_truncation, reason = "an exponent")]
    let exponent = 3 * (libm::log10(largest) / 3.0).floor() as i32;
    (libm::pow(10.0, f64::from(-exponent)), format!("1e{exponent} "))
}

fn draw(area: &Area<'_>, figure: &Multiple) -> Drawn {
    area.fill(&PAPER)?;
    let seen = figure
        .points
        .iter()
        .filter(|point| !point.is_odd)
        .flat_map(|point| [point.value - point.std, point.value + point.std]);
    let shown: Vec<f64> = seen
        .chain(figure.pieces.iter().flat_map(|piece| piece.ends.map(|end| end.1)))
        .chain(figure.ahead.iter().flat_map(|(line, _)| line.map(|end| end.1)))
        .chain([0.0])
        .filter(|value| value.is_finite())
        .collect();
    let (low, high) = extent(shown.iter());
    // A limit far away would press all else flat.
    let limit = figure.limit.filter(|limit| limit.abs() <= 2.0 * low.abs().max(high.abs()));
    let shown: Vec<f64> = shown.into_iter().chain(limit).collect();
    let (low, high) = extent(shown.iter());
    let (factor, prefix) = scale(if figure.usual > 0.0 { figure.usual } else { low.abs().max(high.abs()) });
    write(area, &figure.title, (8, 3), 13, INK, HPos::Left)?;
    let unit = if figure.unit == "1" { prefix.trim().to_owned() } else { format!("{prefix}{}", figure.unit) };
    let subtitle = if unit.is_empty() { figure.subtitle.clone() } else { format!("{} [{unit}]", figure.subtitle) };
    write(area, &subtitle, (8, 20), 11, FAINT_INK, HPos::Left)?;
    let last = figure.ahead.as_ref().map_or(figure.days.1, |(line, _)| line[1].0.max(figure.days.1));
    let across = Axis::airy((figure.days.0, last), LEFT, RIGHT);
    let up = Axis::airy((low * factor, high * factor), BOTTOM, TOP);
    for (value, label) in up.ticks(4.0) {
        let y = up.pixel(value);
        area.draw(&PathElement::new(vec![fine((LEFT, y)), fine((RIGHT, y))], line(GRID, 1.0)))?;
        let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 10 };
        write_at(area, &label, (LEFT - 4, y), right, INK)?;
    }
    dates(area, figure, &across)?;
    for &change in &figure.changes {
        let x = across.pixel(change);
        area.draw(&PathElement::new(vec![fine((x, TOP)), fine((x, BOTTOM))], line(FRAME, 1.2)))?;
    }
    let (across, up) = (across.scaled(FINE), up.scaled(FINE));
    let at = |(day, value): (f64, f64)| (across.pixel(day), up.pixel(value * factor));
    if let Some(limit) = limit {
        area.draw(&PathElement::new(vec![at((figure.days.0, limit)), at((last, limit))], line(LIMIT, 1.2)))?;
    }
    let colour = if figure.is_urgent { URGENT } else { STEADY };
    for point in figure.points.iter().filter(|point| (point.value + point.std).is_finite()) {
        let faint = colour.mix(0.45);
        let bar = [point.value - point.std, point.value + point.std].map(|value| at((point.day, value)));
        area.draw(&PathElement::new(bar.to_vec(), line(FRAME, 1.0)))?;
        let style = if point.is_odd { line(colour, 0.8) } else { faint.filled() };
        area.draw(&Circle::new(at((point.day, point.value)), 16, style))?;
    }
    for piece in &figure.pieces {
        area.draw(&PathElement::new(piece.ends.map(at).to_vec(), line(colour, 1.8)))?;
    }
    if let Some((ahead, _)) = &figure.ahead {
        area.draw(&PathElement::new(ahead.map(at).to_vec(), line(colour, 0.8)))?;
    }
    let corners = [(LEFT, TOP), (RIGHT, TOP), (RIGHT, BOTTOM), (LEFT, BOTTOM), (LEFT, TOP)];
    area.draw(&PathElement::new(corners.map(fine).to_vec(), line(FRAME, 1.0)))
}

/// First and last night below the chart, and the date on which the limit is reached, where that is later; as far as there is room.
fn dates(area: &Area<'_>, figure: &Multiple, across: &Axis) -> Drawn {
    let below = BOTTOM + 5;
    let [first, last] = &figure.ends;
    write(area, first, (LEFT, below), 10, FAINT_INK, HPos::Left)?;
    let ahead = figure.ahead.as_ref().filter(|(line, _)| line[1].0 > figure.days.1);
    let Some((_, date)) = ahead else { return write(area, last, (RIGHT, below), 10, FAINT_INK, HPos::Right) };
    write(area, date, (RIGHT, below), 10, LIMIT, HPos::Right)?;
    let (at, wide) = (across.pixel(figure.days.1), text_width(last, 10));
    let has_room = at - wide / 2 > LEFT + text_width(first, 10) + 6 && at + wide / 2 < RIGHT - text_width(date, 10) - 6;
    if has_room { write(area, last, (at, below), 10, FAINT_INK, HPos::Center) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_amounts_have_a_scale_and_a_limit_near_them_is_drawn() {
        let point = |day: f64, value: f64| Amount { day, value, std: 1e-14, is_odd: day > 8.0 };
        let figure = Multiple {
            title: "press <1>".into(),
            subtitle: "internal-leakage".into(),
            unit: "m3/s/Pa".into(),
            usual: 0.0,
            days: (0.0, 9.0),
            ends: ["2026-11-01".into(), "2026-11-10".into()],
            points: vec![point(0.0, 1e-12), point(5.0, 1.5e-12), point(9.0, f64::NAN)],
            pieces: vec![Piece { ends: [(0.0, 1e-12), (5.0, 1.5e-12)] }],
            changes: vec![3.0],
            limit: Some(2e-12),
            is_urgent: true,
            ahead: Some(([(5.0, 1.5e-12), (20.0, 2e-12)], "2026-11-21".into())),
        };
        let text = multiple(&figure);
        assert!(text.contains("press &lt;1&gt;") && text.contains("[1e-12 m3/s/Pa]") && text.contains("2026-11-21"));
        assert!(text.contains("#B02A37") && !text.contains("NaN"), "{text}");
        let far = multiple(&Multiple { limit: Some(1.0), ..figure });
        assert_eq!(far.matches("#B02A37").count(), 1, "only the date: {far}");
        assert!(multiple(&Multiple::default()).starts_with("<svg"));
    }

    #[test]
    fn scales_are_powers_of_a_thousand() {
        assert_eq!(scale(0.5), (1.0, String::new()));
        assert_eq!(scale(2.5e-12).1, "1e-12 ");
        assert_eq!(scale(0.004).1, "1e-3 ");
        assert_eq!(scale(2.5e9).1, "1e9 ");
    }
}
