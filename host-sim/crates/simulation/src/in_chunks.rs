//! A recording that is simulated in chunks, each from the state in which the last one ended.

use std::ops::Range;

use machine_file::{DELAY_LINE, LoadSource};
use model_core::drive::{Drive, DriveState};
use model_core::machine::{Machine, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::Part;

use crate::arithmetic::Arithmetic;
use crate::error::SimulateError;
use crate::grid::Origin;
use crate::initial_state::{StartOffset, at_start};
use crate::run::{Trajectory, computed_below, run_on, unbraked};
use crate::sensor_fault::Mended;
use crate::stimulus::{InputPoint, Stimulus};

/// Rows that two parts have in common on either side of the border between them: bridging and smoothing at the border
/// need the rows beyond it.
const OVERLAP: usize = 1000;

/// A simulation that continues from part to part of a recording.
///
/// Every value equals that of a simulation of the whole, to the last bit, except for what is estimated from the recording itself,
/// because this is estimated for each part alone: rows in which a sensor failed, and the noise of pressures that the load balances.
/// A failure that lasts beyond the common rows of two parts is bridged in each as if it were at an end of the recording.
#[derive(Debug)]
pub struct InChunks {
    machine: Machine<f64>,
    input_point: InputPoint,
    load: LoadSource,
    tick: Tick,
    start: StartOffset,
    going: Going,
}

/// The state reached so far, in its number type.
#[derive(Debug)]
enum Going {
    Fixed(Option<Box<Led<PerUnit>>>),
    Float(Option<Box<Led<f64>>>),
}

/// The state reached by the parts before.
#[derive(Debug)]
struct Led<N: Scalar<Real = f64>> {
    state: DriveState<N, DELAY_LINE>,
    origin: Origin,
    /// The last rows of the parts before.
    tail: Trajectory,
}

/// What was simulated for a part.
#[derive(Clone, Debug, PartialEq)]
pub struct Advance {
    /// Its rows that were in no part before.
    pub rows: Range<usize>,
    /// The signals from its first row to the end of these rows, SI.
    pub trajectory: Trajectory,
    /// The row with which the next part has to begin.
    pub next_from: usize,
}

impl InChunks {
    /// Nothing has been simulated yet.
    #[must_use]
    pub fn new(
        machine: &Machine<f64>,
        input_point: InputPoint,
        load: LoadSource,
        tick: Tick,
        arithmetic: Arithmetic,
    ) -> Self {
        let going = match arithmetic {
            Arithmetic::Fixed => Going::Fixed(None),
            Arithmetic::Float => Going::Float(None),
        };
        Self { machine: *machine, input_point, load, tick, start: StartOffset::none(), going }
    }

    /// The same with another start than the first row's.
    #[must_use]
    pub fn starting(self, start: StartOffset) -> Self {
        Self { start, ..self }
    }

    /// Simulates the next part: all of it if it is the last, otherwise some rows less.
    pub fn part(&mut self, part: &Part) -> Result<Advance, SimulateError> {
        let Self { machine, input_point, load, tick, start, going } = self;
        let next = Next { machine, input_point: *input_point, load: *load, tick: *tick, start: *start, part };
        match going {
            Going::Fixed(led) => next.from(led),
            Going::Float(led) => next.from(led),
        }
    }
}

/// The part to be simulated next.
struct Next<'a> {
    machine: &'a Machine<f64>,
    input_point: InputPoint,
    load: LoadSource,
    tick: Tick,
    start: StartOffset,
    part: &'a Part,
}

impl Next<'_> {
    fn from<N: Scalar<Real = f64>>(&self, led: &mut Option<Box<Led<N>>>) -> Result<Advance, SimulateError> {
        let recording = &self.part.recording;
        let (origin, mut trajectory) = match &led {
            Some(led) => (led.origin, led.tail.clone()),
            None => (Origin::of(recording), Trajectory::of(computed_below(self.input_point), recording.rows())),
        };
        let begun = trajectory.rows();
        let mended = Mended::of(recording);
        let mut stimulus =
            Stimulus::from_origin(&mended, self.machine, self.input_point, self.load, self.tick, origin)?;
        if !self.part.is_last {
            stimulus.end_at(recording.rows().saturating_sub(OVERLAP).max(1));
        }
        let end = stimulus.rows().max(begun);
        let machine = unbraked(self.machine, &stimulus);
        let drive = Drive::<N>::new::<DELAY_LINE>(&machine, self.tick)?;
        let mut state = match led.take() {
            Some(led) => {
                // It begins where the part before ended.
                stimulus.start.taken_up = None;
                led.state
            }
            None => at_start(&drive, &machine, &stimulus.start, self.start.lifted()),
        };
        run_on(&drive, &machine, &stimulus, self.start.lifted(), &mut state, &mut |row, sample| {
            if row >= begun {
                trajectory.push(|signal| sample.signal(signal));
            }
        });
        let origin = Origin { point: origin.point + stimulus.ticks(), ..origin };
        let next_from = end.saturating_sub(OVERLAP);
        *led = Some(Box::new(Led { state, origin, tail: trajectory.since(next_from) }));
        Ok(Advance { rows: begun..end, trajectory, next_from })
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::path::Path;

    use model_core::machine::{Parameter, Source};
    use recording::formats::read::parts_of;
    use recording::{At, ChannelMap, Note, Parts, Recording, Signal, read_from};
    use test_press::press;

    use super::*;

    /// The columns of a recording in addition to time: the one that drives it, and those that act on it throughout.
    const DRIVEN: [(InputPoint, &str); 4] = [
        (InputPoint::Command, "command [V]"),
        (InputPoint::Spool, "spool"),
        (InputPoint::Flow, "flow [l/min]"),
        (InputPoint::Pump, "pump_speed [rpm]"),
    ];

    /// A recording of this many rows at these intervals, as a text. Every seventh row stands twice, followed by a row with an
    /// empty cell: so, whatever rows the parts begin and end with, some of them are next to a row that is left out.
    fn text(rows: usize, driven_by: &str, interval_s: impl Fn(usize) -> f64) -> String {
        let (mut time_s, mut text) =
            (3.0, format!("time [s],{driven_by},position [mm],oil_temperature [°C],load_force [N]\n"));
        let largest = if driven_by.starts_with("pump") { 900.0 } else { 0.6 };
        for row in 0..rows {
            let (drive, force) = (largest * (0.003 * row as f64).sin(), 2e3 * (0.001 * row as f64).cos());
            writeln!(text, "{time_s:.7},{drive:.4},150.0,{:.2},{force:.1}", 40.0 + 1e-3 * row as f64).unwrap();
            if row % 7 == 3 {
                writeln!(text, "{time_s:.7},1,2,3,4\n{:.7},,2,3,4", time_s + 1e-5).unwrap();
            }
            time_s += interval_s(row);
        }
        text
    }

    fn parts(text: &str, usual_rows: usize) -> Parts<'_> {
        parts_of("run.csv", Box::new(text.as_bytes()), &ChannelMap::default(), usual_rows).unwrap()
    }

    /// Rows of a text with every signal in it.
    fn written(recording: &Recording, rows: Range<usize>, trajectory: &Trajectory) -> String {
        let series: Vec<_> = trajectory.series.iter().map(|(signal, values)| (*signal, values.as_slice())).collect();
        String::from_utf8(recording.csv_rows(Path::new("out.csv"), rows, &series, &series).unwrap()).unwrap()
    }

    /// Simulating and writing in parts gives the same as simulating and writing the whole.
    fn as_a_whole(arithmetic: Arithmetic, text: &str, input_point: InputPoint, tick: Tick) {
        let further = [(Parameter::ViscosityLossPerKelvin, 0.03), (Parameter::CoulombFriction, 300.0)];
        let mut machine = press(&further);
        if input_point == InputPoint::Pump {
            machine.source = Source::Pump;
        }
        let whole = read_from("run.csv", text.as_bytes(), &ChannelMap::default()).unwrap();
        let load = LoadSource::Constant;
        let stimulus = Stimulus::new(&whole, &machine, input_point, load, tick).unwrap();
        let start = StartOffset { shift_m: 1e-3, ..StartOffset::none() };
        let simulated = arithmetic.simulate(&machine, &stimulus, start).unwrap();
        let position = simulated.signal(Signal::Position).unwrap();
        assert!(position.iter().any(|there| (there - position[0]).abs() > 1e-4), "{input_point:?} moves the rod");
        let expected = written(&whole, 0..whole.rows(), &simulated);

        for usual_rows in [3500, 5003, 100_000] {
            let mut parts = parts(text, usual_rows);
            let mut in_chunks = InChunks::new(&machine, input_point, load, tick, arithmetic).starting(start);
            let (mut found, mut count) = (String::new(), 0);
            while let Some(part) = parts.read_next().unwrap() {
                let advance = in_chunks.part(&part).unwrap();
                found += &written(&part.recording, advance.rows, &advance.trajectory);
                parts.forget_before(advance.next_from);
                count += 1;
            }
            assert_eq!(count > 1, usual_rows < 10_000, "{usual_rows} rows a part");
            assert!(found == expected, "{input_point:?}, {usual_rows} rows a part");
        }
    }

    #[test]
    fn in_parts_a_recording_is_simulated_and_written_as_a_whole() {
        for (input_point, driven_by) in DRIVEN {
            as_a_whole(Arithmetic::Float, &text(7_000, driven_by, |_| 1e-3), input_point, Tick::OneMillisecond);
            // Faster than the tick, slower, and uneven with gaps: rows lie on a grid point only by chance.
            as_a_whole(Arithmetic::Fixed, &text(9_000, driven_by, |_| 2.3e-4), input_point, Tick::HalfMillisecond);
            as_a_whole(Arithmetic::Float, &text(4_000, driven_by, |_| 7.1e-3), input_point, Tick::TwoMilliseconds);
            let uneven = |row: usize| 1e-4 * (1 + row * 7919 % 23) as f64 + if row % 999 == 500 { 0.25 } else { 0.0 };
            as_a_whole(Arithmetic::Fixed, &text(7_000, driven_by, uneven), input_point, Tick::OneMillisecond);
        }
    }

    #[test]
    fn rows_that_are_left_out_take_no_more_memory_than_others() {
        let mut text = String::from("time [ms],command [V]\n");
        for row in 0..100_000 {
            // Rows that are written again and again.
            writeln!(text, "{},1", row / 50).unwrap();
        }
        let mut parts = parts(&text, 3_000);
        let mut in_chunks = InChunks::new(
            &press(&[]),
            InputPoint::Command,
            LoadSource::Constant,
            Tick::OneMillisecond,
            Arithmetic::Float,
        );
        let (mut rows, mut notes) = (0, Vec::new());
        while let Some(part) = parts.read_next().unwrap() {
            let advance = in_chunks.part(&part).unwrap();
            rows += advance.rows.len();
            parts.forget_before(advance.next_from);
            notes.extend(part.recording.notes().to_vec());
        }
        assert_eq!(rows, 2_000);
        assert_eq!(notes, [Note::DuplicateTimes { rows: 98_000, first: At::Line(3) }], "said once, of all");
    }

    #[test]
    fn a_gap_is_noted_once() {
        let text = text(9_000, "command [V]", |row| if row == 4_000 { 0.5 } else { 1e-3 });
        let mut parts = parts(&text, 3_000);
        let mut gaps = Vec::new();
        while let Some(part) = parts.read_next().unwrap() {
            parts.forget_before(part.recording.rows() / 2);
            let is_gap = |note: &&Note| matches!(note, Note::Gaps { .. });
            gaps.extend(part.recording.notes().iter().filter(is_gap).cloned());
        }
        assert!(matches!(gaps.as_slice(), [Note::Gaps { count: 1, .. }]), "{gaps:?}");
    }

    #[test]
    fn a_part_with_fewer_rows_than_two_have_in_common_only_waits_for_more() {
        let text = text(6_000, "command [V]", |_| 1e-3);
        let mut parts = parts(&text, 300);
        let mut in_chunks = InChunks::new(
            &press(&[]),
            InputPoint::Command,
            LoadSource::Constant,
            Tick::OneMillisecond,
            Arithmetic::Float,
        );
        let mut rows = 0;
        while let Some(part) = parts.read_next().unwrap() {
            let advance = in_chunks.part(&part).unwrap();
            rows += advance.rows.len();
            parts.forget_before(advance.next_from);
        }
        assert_eq!(rows, 6_000);
    }

    #[test]
    fn an_error_in_a_later_part_names_its_line() {
        let text = text(5_000, "command [V]", |_| 1e-3) + "8.0,far,1,2,3\n";
        let mut parts = parts(&text, 4_000);
        assert!(!parts.read_next().unwrap().unwrap().is_last);
        parts.forget_before(usize::MAX);
        let told = parts.read_next().map(|part| part.map(|part| part.recording.rows())).unwrap_err().to_string();
        let line = 1 + 5_000 + 2 * 714 + 1;
        assert!(told.contains(&format!("run.csv:{line}")) && told.contains("far"), "{told}");
    }
}
