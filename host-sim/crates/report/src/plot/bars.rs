//! Horizontal bars on a logarithmic axis, in groups: what is left after each step.

use plotters::element::{PathElement, Rectangle};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use recording::display_unit::significant;

use super::Style;
use super::canvas::{
    Area, Drawn, FAINT_INK, FRAME, GRID, INK, PAPER, TextPlace, drawn, fine, line, look, write, write_at,
};

const WIDTH: i32 = 800;
const LEFT: i32 = 290;
const RIGHT: i32 = WIDTH - 80;
const TOP: i32 = 44;
const BAR: i32 = 20;
const HEADING: i32 = 30;
const FOOT: i32 = 46;

/// One bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// What it stands for.
    pub label: String,
    /// Its end; from 1 on.
    pub value: f64,
    /// Its colour.
    pub style: Style,
}

/// Bars under one heading.
#[derive(Clone, Debug, PartialEq)]
pub struct BarGroup {
    /// The heading.
    pub title: String,
    /// The bars.
    pub bars: Vec<Bar>,
}

/// Draws groups of bars below each other over one logarithmic axis from 1; the text of an SVG with a `viewBox`, 800 px wide.
#[must_use]
pub fn bars(title: &str, axis: &str, groups: &[BarGroup]) -> String {
    let rows: i32 = groups.iter().map(height_of).sum();
    drawn((WIDTH, TOP + rows + FOOT), |area| draw(area, title, axis, groups))
}

fn height_of(group: &BarGroup) -> i32 {
    HEADING + BAR * i32::try_from(group.bars.len()).unwrap_or(0)
}

fn draw(area: &Area<'_>, title: &str, axis: &str, groups: &[BarGroup]) -> Drawn {
    area.fill(&PAPER)?;
    write(area, title, (16, 12), 15, INK, HPos::Left)?;
    let values = || groups.iter().flat_map(|group| &group.bars).map(|bar| bar.value).filter(|value| value.is_finite());
    let decades = libm::log10(values().fold(10.0_f64, f64::max)).ceil().clamp(1.0, 12.0);
    let at = |value: f64| {
        let share = (libm::log10(value.max(1e-300)) / decades).clamp(0.0, 1.0);
        #[expect(clippy::cast_possible_truncation, reason = "between two pixels")]
        let pixel = (f64::from(LEFT) + share * f64::from(RIGHT - LEFT)).round() as i32;
        pixel
    };
    let bottom = TOP + groups.iter().map(height_of).sum::<i32>() + 4;
    #[expect(clippy::cast_possible_truncation, reason = "at most 12")]
    for decade in 0..=decades as i32 {
        let x = at(10.0_f64.powi(decade));
        let colour = if decade == 0 { FRAME } else { GRID };
        area.draw(&PathElement::new(vec![fine((x, TOP)), fine((x, bottom))], line(colour, 1.0)))?;
        let label = if decade < 5 { format!("{}", 10_i64.pow(decade.unsigned_abs())) } else { format!("1e{decade}") };
        write(area, &label, (x, bottom + 5), 12, INK, HPos::Center)?;
    }
    write(area, axis, (i32::midpoint(LEFT, RIGHT), bottom + 22), 12, INK, HPos::Center)?;
    let mut top = TOP;
    for group in groups {
        write(area, &group.title, (16, top + 9), 13, INK, HPos::Left)?;
        top += HEADING;
        for bar in &group.bars {
            let (middle, end) = (top + BAR / 2, at(bar.value));
            let right = TextPlace { anchor: Pos::new(HPos::Right, VPos::Center), size: 12 };
            write_at(area, &bar.label, (LEFT - 10, middle), right, INK)?;
            let (colour, _) = look(bar.style);
            let corners = [fine((LEFT, top + 3)), fine((end.max(LEFT + 2), top + BAR - 3))];
            area.draw(&Rectangle::new(corners, colour.filled()))?;
            let left = TextPlace { anchor: Pos::new(HPos::Left, VPos::Center), size: 12 };
            write_at(area, &significant(bar.value, 3), (end.max(LEFT + 2) + 6, middle), left, FAINT_INK)?;
            top += BAR;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_of_any_size_have_a_place() {
        let bar = |value| Bar { label: "with <it>".into(), value, style: Style::After };
        let group = BarGroup { title: "position".into(), bars: vec![bar(1e4), bar(1.0), bar(0.3), bar(f64::NAN)] };
        let text = bars("left", "times the noise", &[group]);
        assert!(text.contains("with &lt;it&gt;") && text.contains("10000"), "{text}");
        assert!(bars("", "", &[]).starts_with("<svg"));
    }
}
