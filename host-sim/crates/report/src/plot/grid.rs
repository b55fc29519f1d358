//! A square of cells: each name against each other name.

use plotters::element::{PathElement, Rectangle, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontTransform, IntoFont, RGBColor, TextStyle};

use recording::files::source_error::printable;

use super::canvas::{
    Area, Drawn, FAINT_INK, FINE, FRAME, INK, PAPER, TextPlace, drawn, fine, line, text_width, write, write_at,
};

const SIDE: i32 = 22;
const TOP: i32 = 70;
const LEGEND: i32 = 40;
const SIZE: i32 = 12;

const ALIKE: RGBColor = RGBColor(214, 102, 0);
const OWN: RGBColor = RGBColor(206, 212, 218);
/// Colours of a pair that is just distinguishable, and of one a thousand times beyond that.
const NEAR: [u8; 3] = [190, 218, 240];
const FAR: [u8; 3] = [16, 72, 128];

/// What is known about a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell {
    /// Nothing: the row's own effect is not visible.
    None,
    /// The diagonal.
    Own,
    /// The row would be taken for the column.
    Alike,
    /// Distinguishable, by this number of standard deviations.
    Distance(f64),
}

/// A square of cells with the same names down and across.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// What is shown.
    pub title: String,
    /// What the rows are.
    pub rows: String,
    /// What the columns are.
    pub columns: String,
    /// Names of rows and columns.
    pub names: Vec<String>,
    /// A row of cells for each name.
    pub cells: Vec<Vec<Cell>>,
}

/// Draws it; the text of an SVG with a `viewBox`.
#[must_use]
pub fn grid(grid: &Grid) -> String {
    let label = grid.names.iter().map(|name| text_width(name, SIZE)).max().unwrap_or(0) + 12;
    let side = SIDE * i32::try_from(grid.names.len()).unwrap_or(0);
    let (left, top) = (label + 16, TOP + label);
    drawn(((left + side + 20).max(480), top + side + LEGEND), |area| draw(area, grid, (left, top), side))
}

fn draw(area: &Area<'_>, grid: &Grid, (left, top): (i32, i32), side: i32) -> Drawn {
    area.fill(&PAPER)?;
    write(area, &grid.title, (16, 12), 15, INK, HPos::Left)?;
    write(area, &format!("down: {}; across: {}", grid.rows, grid.columns), (16, 36), SIZE, FAINT_INK, HPos::Left)?;
    for (index, name) in (0..).zip(&grid.names) {
        let middle = SIDE * index + SIDE / 2;
        let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: SIZE };
        write_at(area, name, (left - 8, top + middle), right, INK)?;
        let upwards = ("sans-serif", SIZE * FINE).into_font().transform(FontTransform::Rotate270).color(&INK);
        let place: TextStyle<'_> = upwards.pos(Pos::new(HPos::Left, VPos::Center));
        area.draw(&Text::new(printable(name), fine((left + middle, top - 8)), place))?;
    }
    for (row, cells) in (0..).zip(&grid.cells) {
        for (column, cell) in (0..).zip(cells) {
            if let Some(colour) = colour(*cell) {
                let (x, y) = (left + SIDE * column, top + SIDE * row);
                area.draw(&Rectangle::new([fine((x, y)), fine((x + SIDE, y + SIDE))], colour.filled()))?;
            }
        }
    }
    let right = left + side;
    for index in 0..=grid.names.len() {
        let at = SIDE * i32::try_from(index).unwrap_or(0);
        for ends in [[(left, top + at), (right, top + at)], [(left + at, top), (left + at, top + side)]] {
            area.draw(&PathElement::new(ends.map(fine).to_vec(), line(FRAME, 1.0)))?;
        }
    }
    legend(area, top + side + 14)
}

fn colour(cell: Cell) -> Option<RGBColor> {
    match cell {
        Cell::None => None,
        Cell::Own => Some(OWN),
        Cell::Alike => Some(ALIKE),
        Cell::Distance(deviations) => {
            let share = (libm::log10(deviations.max(1.0)) / 3.0).min(1.0);
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between two bytes")]
            let [red, green, blue] = [0, 1, 2].map(|channel| {
                let (near, far) = (f64::from(NEAR[channel]), f64::from(FAR[channel]));
                (near + share * (far - near)).round() as u8
            });
            Some(RGBColor(red, green, blue))
        }
    }
}

fn legend(area: &Area<'_>, top: i32) -> Drawn {
    let entries = [
        (Cell::Alike, "would pass for it"),
        (Cell::Distance(3.0), "separated, barely"),
        (Cell::Distance(1e3), "by far"),
        (Cell::None, "not seen"),
    ];
    let mut x = 16;
    for (cell, label) in entries {
        let corners = [fine((x, top)), fine((x + 14, top + 14))];
        if let Some(colour) = colour(cell) {
            area.draw(&Rectangle::new(corners, colour.filled()))?;
        }
        area.draw(&Rectangle::new(corners, line(FRAME, 1.0)))?;
        write(area, label, (x + 20, top), SIZE, INK, HPos::Left)?;
        x += 20 + text_width(label, SIZE) + 18;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_cell_is_drawn_and_names_are_escaped() {
        let names = vec!["a<b".to_owned(), "c".to_owned()];
        let cells = vec![vec![Cell::Own, Cell::Alike], vec![Cell::Distance(10.0), Cell::None]];
        let text = grid(&Grid { title: "t".into(), rows: "r".into(), columns: "c".into(), names, cells });
        assert!(text.contains("a&lt;b") && !text.contains("a<b"));
        let inside = text.matches("<rect").count();
        // The background, three cells, three filled entries of the legend, four frames in it.
        assert_eq!(inside, 1 + 3 + 3 + 4, "{text}");
    }
}
