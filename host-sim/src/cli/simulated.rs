//! What a simulation made, for programs: every signal with the values between which it was.

use std::ops::Range;

use clap::ValueEnum;
use model_core::machine::Tick;
use recording::Signal;
use serde_json::{Value, json};
use simulation::{InputPoint, Trajectory};

use super::simulate::Arguments;

/// What was simulated so far.
pub(crate) struct Made {
    machine: String,
    input_point: InputPoint,
    tick: Tick,
    rows: usize,
    /// Times of the first and the last row, s.
    ends_s: Option<(f64, f64)>,
    /// Each signal with its lowest, highest and last value, SI.
    signals: Vec<(Signal, [f64; 3])>,
}

impl Made {
    /// Nothing yet.
    pub(crate) fn of(machine: &str, input_point: InputPoint, tick: Tick) -> Self {
        Self { machine: machine.to_owned(), input_point, tick, rows: 0, ends_s: None, signals: Vec::new() }
    }

    /// Adds these rows of a simulation; `time_s` are their times alone.
    pub(crate) fn add(&mut self, time_s: &[f64], simulated: &Trajectory, rows: &Range<usize>) {
        self.rows += rows.len();
        if let (Some(first), Some(last)) = (time_s.first(), time_s.last()) {
            self.ends_s = Some((self.ends_s.map_or(*first, |(first, _)| first), *last));
        }
        for (signal, values) in &simulated.series {
            for value in values.get(rows.clone()).unwrap_or_default() {
                match self.signals.iter_mut().find(|(known, _)| known == signal) {
                    Some((_, [low, high, last])) => {
                        (*low, *high, *last) = (low.min(*value), high.max(*value), *value);
                    }
                    None => self.signals.push((*signal, [*value; 3])),
                }
            }
        }
    }
}

/// The document, schema `host-sim/simulation/1`: SI units.
pub(crate) fn document_of(arguments: &Arguments, made: &Made) -> Value {
    let signal = |(signal, [low, high, last]): &(Signal, [f64; 3])| json!({ "signal": signal.name(), "unit": signal.si_unit().symbol(), "low": low, "high": high, "last": last });
    let arithmetic = arguments.machine.model.arithmetic.to_possible_value();
    json!({
        "schema": "host-sim/simulation/1",
        "machine": made.machine,
        "recording": arguments.recording.as_ref().map(|path| path.display().to_string()),
        "input": arguments.input,
        "out": arguments.out.display().to_string(),
        "entry": report::inspect::input_point_name(made.input_point),
        "tick_ms": 1e3 * made.tick.seconds(),
        "arithmetic": arithmetic.map(|value| value.get_name().to_owned()),
        "rows": made.rows,
        "from_s": made.ends_s.map(|(first, _)| first),
        "to_s": made.ends_s.map(|(_, last)| last),
        "signals": made.signals.iter().map(signal).collect::<Vec<_>>(),
    })
}
