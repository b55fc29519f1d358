//! A recording that is simulated part by part, each from where the one before has led.

use std::ops::Range;

use model_core::drive::{Drive, DriveState};
use model_core::machine::{Machine, Tick};
use model_core::number::Scalar;

use super::grid::Origin;
use super::{
    DELAY_LINE, EntryPoint, SimulateError, StartOffset, Stimulus, Trajectory, at_start, computed_below, run_on,
    unbraked,
};
use crate::failure::Mended;
use crate::machine_file::LoadSource;
use crate::recording::Part;

/// Rows that two parts have in common on either side of where one ends and the other is taken up: what is bridged or smoothed there
/// sees past it.
const OVERLAP: usize = 1000;

/// A simulation that goes on from part to part of a recording.
///
/// Where the chain is entered at a command, every value is that of a simulation of the whole, to the last bit. What is found out about
/// a recording (rows in which a sensor failed, how noisy its pressures are) is found out about each part by itself.
#[derive(Debug)]
pub struct Onward<N: Scalar<Real = f64>> {
    machine: Machine<f64>,
    entry: EntryPoint,
    load: LoadSource,
    tick: Tick,
    going: Option<Going<N>>,
}

/// Where the parts before have led.
#[derive(Debug)]
struct Going<N: Scalar<Real = f64>> {
    state: DriveState<N, DELAY_LINE>,
    origin: Origin,
    /// Of the last rows before.
    tail: Trajectory,
}

/// What was simulated of a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Advance {
    /// Its rows that no part before had.
    pub rows: Range<usize>,
    /// The signals from its first row to the end of those, SI.
    pub trajectory: Trajectory,
    /// The row that the next part has to begin with.
    pub next_from: usize,
}

impl<N: Scalar<Real = f64>> Onward<N> {
    /// Nothing is simulated yet.
    #[must_use]
    pub fn new(machine: &Machine<f64>, entry: EntryPoint, load: LoadSource, tick: Tick) -> Self {
        Self { machine: *machine, entry, load, tick, going: None }
    }

    /// Simulates the next part: all of it where it is the last, else some rows less than it has.
    pub fn part(&mut self, part: &Part) -> Result<Advance, SimulateError> {
        let recording = &part.recording;
        let (origin, mut trajectory) = match &self.going {
            Some(going) => (going.origin, going.tail.clone()),
            None => (Origin::of(recording), Trajectory::of(computed_below(self.entry))),
        };
        let begun = trajectory.rows();
        let mended = Mended::of(recording);
        let mut stimulus = Stimulus::from_origin(&mended, &self.machine, self.entry, self.load, self.tick, origin)?;
        if !part.is_last {
            stimulus.end_at(recording.rows().saturating_sub(OVERLAP).max(1));
        }
        let end = stimulus.rows().max(begun);
        let machine = unbraked(&self.machine, &stimulus);
        let drive = Drive::<N>::new::<DELAY_LINE>(&machine, self.tick)?;
        let mut state = match self.going.take() {
            Some(going) => going.state,
            None => at_start(&drive, &machine, &stimulus.start, StartOffset::none()),
        };
        run_on(&drive, &machine, &stimulus, &mut state, |row, sample| {
            if row >= begun {
                trajectory.push(|signal| sample.signal(signal));
            }
        });
        let origin = Origin { point: origin.point + stimulus.ticks(), ..origin };
        let next_from = end.saturating_sub(OVERLAP);
        self.going = Some(Going { state, origin, tail: trajectory.since(next_from) });
        Ok(Advance { rows: begun..end, trajectory, next_from })
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use model_core::fixed_point::PerUnit;

    use super::*;
    use crate::press::press;
    use crate::recording::{ChannelMap, Parts, parts_of, read_from};
    use crate::simulate::simulate;

    /// A recording of so many rows at such intervals, as a text; some rows stand twice, and some have an empty cell.
    fn text(rows: usize, interval_s: impl Fn(usize) -> f64) -> String {
        let mut time_s = 3.0;
        let mut text = String::from("time [s],command [V],position [mm],oil_temperature [°C]\n");
        for row in 0..rows {
            let volts = 6.0 * (0.003 * row as f64).sin();
            writeln!(text, "{time_s:.7},{volts:.3},150.0,{:.2}", 40.0 + 1e-3 * row as f64).unwrap();
            if row % 1234 == 7 {
                writeln!(text, "{time_s:.7},1,2,3\n{:.7},,2,3", time_s + 1e-5).unwrap();
            }
            time_s += interval_s(row);
        }
        text
    }

    fn parts(text: &str, most_rows: usize) -> Parts<impl std::io::Read> {
        parts_of("run.csv", text.as_bytes(), &ChannelMap::default(), most_rows).unwrap()
    }

    /// What is simulated in parts and written is what is simulated and written as a whole.
    fn as_a_whole<N: Scalar<Real = f64>>(text: &str, tick: Tick) {
        let machine = press(&[]);
        let whole = read_from("run.csv", text.as_bytes(), &ChannelMap::default()).unwrap();
        let (entry, load) = (EntryPoint::Command, LoadSource::Constant);
        let stimulus = Stimulus::new(&whole, &machine, entry, load, tick).unwrap();
        let expected = simulate::<N>(&machine, &stimulus, StartOffset::none()).unwrap();
        let all = |trajectory: &Trajectory| -> Vec<_> { trajectory.series.clone() };
        let series = all(&expected);
        let written: Vec<_> = series.iter().map(|(signal, values)| (*signal, values.as_slice())).collect();
        let expected = String::from_utf8(whole.csv_rows(0..whole.rows(), &written, &written[..1]).unwrap()).unwrap();

        for most_rows in [2500, 4001, 100_000] {
            let (mut parts, mut onward) = (parts(text, most_rows), Onward::<N>::new(&machine, entry, load, tick));
            let (mut found, mut count) = (String::new(), 0);
            while let Some(part) = parts.read_next().unwrap() {
                let advance = onward.part(&part).unwrap();
                let series = all(&advance.trajectory);
                let written: Vec<_> = series.iter().map(|(signal, values)| (*signal, values.as_slice())).collect();
                let rows = part.recording.csv_rows(advance.rows, &written, &written[..1]).unwrap();
                found += &String::from_utf8(rows).unwrap();
                parts.forget_before(advance.next_from);
                count += 1;
            }
            assert_eq!(count > 1, most_rows < 10_000, "{most_rows} rows a part");
            assert!(found == expected, "{most_rows} rows a part");
        }
    }

    #[test]
    fn in_parts_a_recording_is_simulated_and_written_as_a_whole() {
        let every_tick = text(10_000, |_| 1e-3);
        as_a_whole::<f64>(&every_tick, Tick::OneMillisecond);
        as_a_whole::<PerUnit>(&every_tick, Tick::TwoMilliseconds);
        // Faster than the tick, slower, and uneven with gaps: no row lies on a point but by chance.
        as_a_whole::<PerUnit>(&text(10_000, |_| 1.3e-4), Tick::HalfMillisecond);
        as_a_whole::<f64>(&text(6_000, |_| 7.1e-3), Tick::OneMillisecond);
        let uneven = |row: usize| 1e-4 * (1 + row * 7919 % 23) as f64 + if row % 999 == 500 { 0.25 } else { 0.0 };
        as_a_whole::<PerUnit>(&text(9_000, uneven), Tick::OneMillisecond);
    }

    #[test]
    fn a_part_with_fewer_rows_than_two_have_in_common_only_waits_for_more() {
        let text = text(6_000, |_| 1e-3);
        let mut parts = parts(&text, 300);
        let mut onward =
            Onward::<f64>::new(&press(&[]), EntryPoint::Command, LoadSource::Constant, Tick::OneMillisecond);
        let mut rows = 0;
        while let Some(part) = parts.read_next().unwrap() {
            let advance = onward.part(&part).unwrap();
            rows += advance.rows.len();
            parts.forget_before(advance.next_from);
        }
        assert_eq!(rows, 6_000);
    }

    #[test]
    fn an_error_in_a_later_part_names_its_line() {
        let text = text(5_000, |_| 1e-3) + "8.0,far,1,2\n";
        let mut parts = parts(&text, 3_000);
        assert!(!parts.read_next().unwrap().unwrap().is_last);
        parts.forget_before(2_900);
        let told = parts.read_next().map(|part| part.map(|part| part.recording.rows())).unwrap_err().to_string();
        assert!(told.contains("run.csv:5012") && told.contains("far"), "{told}");
    }
}
