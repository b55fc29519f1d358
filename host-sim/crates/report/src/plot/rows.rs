//! One row for each recording over one time axis: the size of a quantity over time, and which stretches are marked.

use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::Trace;
use super::axis::{Axis, extent};
use super::canvas::{
    Area, BOTTOM, Drawn, FAINT_INK, FINE, FRAME, GRID, INK, PAPER, RIGHT, SHADE, TextPlace, WIDTH, drawn, fine, line,
    look, text_width, write, write_at,
};

const LEFT: i32 = 130;
const TOP: i32 = 58;
const ROW: i32 = 46;
/// Letters of a label that fit in.
const LETTERS: usize = 18;

/// One row.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Its name.
    pub label: String,
    /// Lines that rise from the row's base, none below 0: a value for each time, not finite where there is none.
    pub traces: Vec<Trace>,
    /// Stretches of time that are shaded, (from, to) in s.
    pub intervals: Vec<(f64, f64)>,
}

/// Rows over one time axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// What is shown.
    pub title: String,
    /// The unit of all values.
    pub unit: String,
    /// The times of all traces, s, rising.
    pub time_s: Vec<f64>,
    /// The value that reaches the top of a row.
    pub most: f64,
    /// From top to bottom.
    pub rows: Vec<Row>,
}

/// Draws rows below each other; the text of an SVG with a `viewBox`, 1000 px wide.
#[must_use]
pub fn rows(figure: &Rows) -> String {
    let count = i32::try_from(figure.rows.len()).unwrap_or(0);
    drawn((WIDTH, TOP + ROW * count + BOTTOM + 24), |area| draw(area, figure, count))
}

fn draw(area: &Area<'_>, figure: &Rows, count: i32) -> Drawn {
    area.fill(&PAPER)?;
    write(area, &figure.title, (16, 10), 15, INK, HPos::Left)?;
    legend(area, figure)?;
    let time = Axis::exact(extent(figure.time_s.iter()), LEFT, RIGHT);
    let bottom = TOP + ROW * count;
    for (value, label) in time.ticks(10.0) {
        let x = time.pixel(value);
        area.draw(&PathElement::new(vec![fine((x, TOP)), fine((x, bottom))], line(GRID, 1.0)))?;
        write(area, &label, (x, bottom + 7), 12, INK, HPos::Center)?;
    }
    write(area, "time [s]", (i32::midpoint(LEFT, RIGHT), bottom + 28), 13, INK, HPos::Center)?;
    let fine_time = time.scaled(FINE);
    for (base, row) in (1..).map(|index| TOP + ROW * index).zip(&figure.rows) {
        for &(from_s, to_s) in &row.intervals {
            let (from, to) = (time.pixel(from_s), time.pixel(to_s).max(time.pixel(from_s) + 2));
            area.draw(&Rectangle::new([fine((from, base - ROW + 3)), fine((to, base))], SHADE.filled()))?;
        }
        let height = Axis::exact((0.0, figure.most), base, base - ROW + 7).scaled(FINE);
        for trace in &row.traces {
            let points = figure.time_s.iter().zip(&trace.values).filter(|(time, value)| (**time + **value).is_finite());
            let path: Vec<(i32, i32)> =
                points.map(|(time, value)| (fine_time.pixel(*time), height.pixel(*value))).collect();
            if path.len() > 1 {
                let (colour, _) = look(trace.style);
                area.draw(&PathElement::new(path, line(colour, 1.3)))?;
            }
        }
        area.draw(&PathElement::new(vec![fine((LEFT, base)), fine((RIGHT, base))], line(FRAME, 1.0)))?;
        let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 12 };
        write_at(area, &shortened(&row.label), (LEFT - 8, base - ROW / 2), right, INK)?;
    }
    Ok(())
}

fn legend(area: &Area<'_>, figure: &Rows) -> Drawn {
    let mut right = RIGHT;
    for trace in figure.rows.first().iter().flat_map(|row| row.traces.iter().rev()) {
        write(area, &trace.label, (right, 34), 12, INK, HPos::Right)?;
        right -= text_width(&trace.label, 12) + 8;
        let (colour, _) = look(trace.style);
        area.draw(&PathElement::new(vec![fine((right - 22, 41)), fine((right, 41))], line(colour, 1.5)))?;
        right -= 22 + 18;
    }
    write(area, &format!("top of a row: {:.0} {}", figure.most, figure.unit), (16, 34), 12, FAINT_INK, HPos::Left)
}

fn shortened(label: &str) -> String {
    if label.chars().count() <= LETTERS {
        return label.to_owned();
    }
    label.chars().take(LETTERS - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Style;

    #[test]
    fn every_row_has_its_label_its_lines_and_its_shade() {
        let row = |label: &str| Row {
            label: label.into(),
            traces: vec![Trace::new("before", vec![0.0, 3.0, f64::NAN, 9.0], Style::Before)],
            intervals: vec![(0.5, 1.5)],
        };
        let figure = Rows {
            title: "Where & when".into(),
            unit: "× noise".into(),
            time_s: vec![0.0, 1.0, 2.0, 3.0],
            most: 5.0,
            rows: vec![row("train-1.csv"), row("<a name that is far too long>.csv")],
        };
        let text = rows(&figure);
        assert!(text.contains("train-1.csv") && text.contains("&lt;a name") && text.contains("Where &amp; when"));
        assert_eq!((text.matches("#FFC107").count(), text.matches("#D66000").count()), (2, 2 + 1), "{text}");
        assert!(!text.contains("NaN"));
        assert!(rows(&Rows::default()).starts_with("<svg"));
    }
}
