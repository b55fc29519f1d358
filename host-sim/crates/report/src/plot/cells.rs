//! The size of a quantity over two states: cells with a colour each.
//!
//! The colours get darker from one end to the other without turning back, so they keep their order for every eye, in print, and where a page
//! inverts them for dark mode.

use plotters::element::{PathElement, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

use recording::display_unit::significant;

use super::axis::Axis;
use super::canvas::{
    Area, Drawn, FAINT_INK, FINE, FRAME, GRID, INK, PAPER, TextPlace, drawn, fine, line, write, write_at,
};

/// Width of the drawing, px.
pub(crate) const WIDTH: i32 = 580;
/// Height of the drawing, px.
pub(crate) const HEIGHT: i32 = 410;
/// Where the cells are: left, right, top and bottom edge, px.
pub(crate) const EDGES: [i32; 4] = [74, WIDTH - 92, 64, HEIGHT - 52];

/// Colours from the lowest value to the highest.
const SCALE: [(u8, u8, u8); 5] = [(255, 241, 208), (252, 196, 104), (232, 126, 42), (172, 58, 40), (84, 20, 54)];
/// Steps of the scale beside the chart.
const STEPS: i32 = 32;

/// Cells over two states.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// What is shown.
    pub title: String,
    /// Titles of the horizontal and the vertical axis, each with its unit.
    pub axes: [String; 2],
    /// The unit of the values.
    pub unit: String,
    /// Lower left corner.
    pub from: [f64; 2],
    /// Size of a cell.
    pub step: [f64; 2],
    /// Cells across and upwards.
    pub count: [usize; 2],
    /// Value and number of rows of each cell, the lowest line first, from left to right; `None` where the drive never was.
    pub cells: Vec<Option<(f64, usize)>>,
    /// The value that has the darkest colour.
    pub most: f64,
}

/// Draws cells with the scale of their colours; the text of an SVG with a `viewBox`, 580 px wide.
#[must_use]
pub fn cells(figure: &Cells) -> String {
    drawn((WIDTH, HEIGHT), |area| draw(area, figure))
}

fn draw(area: &Area<'_>, figure: &Cells) -> Drawn {
    let [left, right, top, bottom] = EDGES;
    area.fill(&PAPER)?;
    write(area, &figure.title, (left, 10), 15, INK, HPos::Left)?;
    write(area, &figure.axes[1], (left, 40), 12, FAINT_INK, HPos::Left)?;
    write(area, &figure.axes[0], (i32::midpoint(left, right), HEIGHT - 24), 12, INK, HPos::Center)?;
    let ends = |axis: usize| {
        let (from, cells) = (figure.from[axis], figure.count[axis] as f64);
        (from, from + cells * figure.step[axis])
    };
    let (across, upwards) = (Axis::exact(ends(0), left, right), Axis::exact(ends(1), bottom, top));
    let (fine_across, fine_upwards) = (across.scaled(FINE), upwards.scaled(FINE));
    let edge = |axis: usize, cell: usize| figure.from[axis] + cell as f64 * figure.step[axis];
    for (index, cell) in figure.cells.iter().enumerate() {
        let Some((value, _)) = cell else { continue };
        let (column, row) = (index % figure.count[0], index / figure.count[0]);
        let corner = |right: usize, up: usize| {
            (fine_across.pixel(edge(0, column + right)), fine_upwards.pixel(edge(1, row + up)))
        };
        area.draw(&Rectangle::new([corner(0, 1), corner(1, 0)], shade(value / figure.most).filled()))?;
    }
    for (value, label) in across.ticks(6.0) {
        let x = across.pixel(value);
        area.draw(&PathElement::new(vec![fine((x, bottom)), fine((x, bottom + 4))], line(FRAME, 1.0)))?;
        write(area, &label, (x, bottom + 7), 12, INK, HPos::Center)?;
    }
    for (value, label) in upwards.ticks(6.0) {
        let y = upwards.pixel(value);
        area.draw(&PathElement::new(vec![fine((left - 4, y)), fine((left, y))], line(FRAME, 1.0)))?;
        let end = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 12 };
        write_at(area, &label, (left - 8, y), end, INK)?;
    }
    let corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    area.draw(&PathElement::new(corners.map(fine).to_vec(), line(FRAME, 1.0)))?;
    scale(area, figure)
}

/// The colours beside the cells, with what they stand for.
fn scale(area: &Area<'_>, figure: &Cells) -> Drawn {
    let [_, right, top, bottom] = EDGES;
    let (from, to) = (right + 18, right + 32);
    let at = |step: i32| bottom - (bottom - top) * step / STEPS;
    for step in 0..STEPS {
        let colour = shade((f64::from(step) + 0.5) / f64::from(STEPS));
        area.draw(&Rectangle::new([fine((from, at(step + 1))), fine((to, at(step)))], colour.filled()))?;
    }
    for quarter in 0..=4 {
        let start = TextPlace { anchor: Pos::new(HPos::Left, VPos::Center), size: 12 };
        let label = significant(figure.most * f64::from(quarter) / 4.0, 2);
        write_at(area, &label, (to + 6, at(quarter * STEPS / 4)), start, INK)?;
    }
    area.draw(&PathElement::new(vec![fine((from, top)), fine((to, top))], line(GRID, 1.0)))?;
    write(area, &figure.unit, (WIDTH - 12, 40), 12, FAINT_INK, HPos::Right)
}

/// The colour at a share of the scale.
fn shade(share: f64) -> RGBColor {
    let last = SCALE.len() - 1;
    let place = if share.is_finite() { share.clamp(0.0, 1.0) * last as f64 } else { 0.0 };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 4")]
    let below = (place.floor() as usize).min(last - 1);
    let (from, to) = (SCALE[below], SCALE[below + 1]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
    let mix = |from: u8, to: u8| (f64::from(from) + (place - below as f64) * (f64::from(to) - f64::from(from))) as u8;
    RGBColor(mix(from.0, to.0), mix(from.1, to.1), mix(from.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_gets_darker_all_the_way() {
        let light = |colour: RGBColor| {
            0.2126 * f64::from(colour.0) + 0.7152 * f64::from(colour.1) + 0.0722 * f64::from(colour.2)
        };
        let lights: Vec<f64> = (0..=100).map(|k| light(shade(f64::from(k) / 100.0))).collect();
        assert!(lights.windows(2).all(|pair| pair[1] < pair[0] + 0.5), "{lights:?}");
        assert!(lights[0] - lights[100] > 180.0, "{} to {}", lights[0], lights[100]);
        assert_eq!((shade(-1.0), shade(f64::NAN)), (shade(0.0), shade(0.0)));
    }

    #[test]
    fn cells_stand_where_their_states_are_and_empty_ones_stay_paper() {
        let figure = Cells {
            title: "a < b".into(),
            axes: ["velocity [mm/s]".into(), "pressure [bar]".into()],
            unit: "× noise".into(),
            from: [-10.0, 0.0],
            step: [10.0, 50.0],
            count: [2, 2],
            cells: vec![Some((4.0, 10)), None, None, Some((0.0, 3))],
            most: 4.0,
        };
        let text = cells(&figure);
        assert!(text.contains("a &lt; b") && text.contains("#541436") && text.contains("#FFF1D0"), "{text}");
        assert!(cells(&Cells::default()).starts_with("<svg"));
    }
}
