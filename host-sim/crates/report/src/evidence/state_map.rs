//! Operating regions in which the error is made: its mean size over the two states that it depends on most.

use diagnosis::localisation::error_shape::{Shape, State};
use diagnosis::localisation::locate::{extend, states};
use diagnosis::localisation::operating_region::Course;
use diagnosis::{Diagnosis, Shown};
use recording::display_unit::state_unit;
use recording::{Recording, Signal};
use simulation::Trajectory;
use simulation::signal::noise::quantile;

use super::timeline::{error_in, errors};
use crate::plot::Cells;

/// Cells across and upwards.
const COUNT: [usize; 2] = [28, 18];
/// Share of the rows at each end of a state that lie in the outermost cells.
const OUTSIDE: f64 = 0.002;
/// A cell with fewer rows is left empty.
const LEAST_ROWS: usize = 3;
/// Partners for a single state that was found, the most informative first.
const PARTNERS: [&str; 4] = ["velocity", "pressure in A", "spool", "position"];

/// The map before and, where it differs, after, over all training recordings; none where nothing was located.
/// `recordings` are all that the diagnosis shows, in its order.
#[must_use]
pub(super) fn state_maps(diagnosis: &Diagnosis, recordings: &[&Recording]) -> Vec<Cells> {
    let Some(location) = &diagnosis.located else { return Vec::new() };
    let training = || diagnosis.shown.iter().zip(recordings).filter(|(shown, _)| !shown.held_out);
    let mut course = Course::default();
    for (shown, recording) in training() {
        extend(&mut course, recording, &shown.prepared, &shown.before);
    }
    let missed = |of: fn(&Shown) -> &Trajectory| -> Option<Vec<f64>> {
        let each: Option<Vec<_>> = training().map(|(shown, _)| errors(shown, of(shown), location.signal)).collect();
        Some(each?.concat())
    };
    let has_pressures = diagnosis.shown.iter().all(|shown| measures(shown, Signal::PressureA));
    let states = states(&course);
    let Some((x, y)) = pair(&location.shape, &states, has_pressures) else { return Vec::new() };
    let mut maps = Vec::new();
    let mut drawn = |name: &str, of: fn(&Shown) -> &Trajectory| {
        let named = format!("Mean {}, {name}", error_in(location.signal));
        maps.extend(missed(of).map(|errors| map(named, &errors, x, y)));
    };
    drawn(diagnosis.before_is_called(), |shown| &shown.before);
    if diagnosis.changes() {
        drawn("after", |shown| &shown.after);
    }
    // One colour scale for both maps.
    let most = maps.first().map_or(1.0, |map| map.most);
    for map in &mut maps {
        map.most = most;
    }
    maps
}

fn measures(shown: &Shown, signal: Signal) -> bool {
    shown.prepared.channels.iter().any(|channel| channel.signal == signal)
}

/// The two states that the error depends on. A single state is drawn with a partner; an error that depends on none is drawn with the usual two.
fn pair<'a>(shape: &Shape, states: &'a [State], has_pressures: bool) -> Option<(&'a State, &'a State)> {
    let varies = |state: &&State| state.values.iter().any(|value| value.to_bits() != state.values[0].to_bits());
    let find = |name: &str| states.iter().filter(varies).find(|state| state.name == name);
    let usual = if has_pressures { ("velocity", "pressure in A") } else { ("spool", "position") };
    let (one, other) = match shape {
        Shape::Over { pair: Some((one, other, _)), .. } => (*one, *other),
        Shape::Over { state, .. } => {
            let fits = |partner: &&str| *partner != *state && (has_pressures || !partner.starts_with("pressure"));
            (*state, PARTNERS.into_iter().find(fits)?)
        }
        _ => usual,
    };
    find(one).zip(find(other)).or_else(|| find(usual.0).zip(find(usual.1)))
}

fn map(title: String, errors: &[f64], x: &State, y: &State) -> Cells {
    let mut cells = Cells { title, unit: "× noise".to_owned(), count: COUNT, ..Cells::default() };
    let mut places = [Vec::new(), Vec::new()];
    for (axis, state) in [x, y].into_iter().enumerate() {
        let (unit, scale) = state_unit(state.unit);
        cells.axes[axis] = format!("{} [{unit}]", state.name);
        let values: Vec<f64> = state.values.iter().map(|value| scale * value).collect();
        let (from, to) = middle(&values);
        cells.from[axis] = from;
        cells.step[axis] = (to - from) / COUNT[axis] as f64;
        let last = (COUNT[axis] - 1) as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cell")]
        let place = |value: &f64| ((value - from) / cells.step[axis]).clamp(0.0, last) as usize;
        places[axis] = values.iter().map(place).collect();
    }
    let mut sums = vec![(0.0, 0_usize); COUNT[0] * COUNT[1]];
    for ((column, row), error) in places[0].iter().zip(&places[1]).zip(errors) {
        let (sum, rows) = &mut sums[row * COUNT[0] + column];
        *sum += error.abs();
        *rows += 1;
    }
    cells.cells = sums.iter().map(|&(sum, rows)| (rows >= LEAST_ROWS).then(|| (sum / rows as f64, rows))).collect();
    cells.most = cells.cells.iter().flatten().map(|(mean, _)| *mean).fold(1.0, f64::max);
    cells
}

/// The range that holds all but the outermost values.
fn middle(values: &[f64]) -> (f64, f64) {
    let at = |share: f64| quantile(values.to_vec(), share).unwrap_or(0.0);
    let (from, to) = (at(OUTSIDE), at(1.0 - OUTSIDE));
    if to > from { (from, to) } else { (from - 0.5, from + 0.5) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(name: &'static str, unit: &'static str, values: Vec<f64>) -> State {
        State { name, unit, values }
    }

    #[test]
    fn a_map_is_dark_where_the_error_is_and_empty_where_the_drive_never_was() {
        let rows = 10_000;
        let velocity: Vec<f64> = (0..rows).map(|row| 0.1 * (f64::from(row) * 0.01).sin()).collect();
        let pressure: Vec<f64> = (0..rows).map(|row| 3e6 + 1e6 * (f64::from(row) * 0.01).cos()).collect();
        let errors: Vec<f64> = velocity.iter().map(|v| if *v > 0.05 { -6.0 } else { 1.0 }).collect();
        let (x, y) = (state("velocity", "m/s", velocity), state("pressure in A", "Pa", pressure));
        let map = map("Before".into(), &errors, &x, &y);
        assert_eq!(map.axes, ["velocity [mm/s]", "pressure in A [bar]"]);
        assert!((map.most - 6.0).abs() < 1e-12 && (map.from[0] + 100.0).abs() < 1.0, "{map:?}");
        let middle = map.cells[COUNT[0] * COUNT[1] / 2 + COUNT[0] / 2];
        assert_eq!(middle, None, "on a circle nobody is in its middle");
        let right = map.cells.iter().enumerate().filter(|(index, _)| index % COUNT[0] == COUNT[0] - 1);
        assert!(right.filter_map(|(_, cell)| *cell).all(|(mean, _)| (mean - 6.0).abs() < 1e-12));
    }

    #[test]
    fn what_was_found_is_drawn_and_what_was_not_over_the_usual_states() {
        let wave = || (0..10).map(f64::from).collect::<Vec<_>>();
        let states = [
            state("spool", "1", wave()),
            state("velocity", "m/s", wave()),
            state("position", "m", wave()),
            state("pressure in A", "Pa", vec![0.0; 10]),
        ];
        let names = |shape: &Shape, pressures| pair(shape, &states, pressures).map(|(x, y)| (x.name, y.name));
        let found = |state, pair| Shape::Over { state, unit: "m", explained: 0.5, bins: Vec::new(), pair };
        assert_eq!(names(&found("spool", Some(("velocity", "position", 0.7))), true), Some(("velocity", "position")));
        assert_eq!(names(&found("position", None), false), Some(("position", "velocity")));
        assert_eq!(names(&found("velocity", None), false), Some(("velocity", "spool")));
        assert_eq!(names(&Shape::Everywhere, false), Some(("spool", "position")));
        assert_eq!(names(&Shape::Everywhere, true), None, "pressure that never changes is no axis");
    }
}
