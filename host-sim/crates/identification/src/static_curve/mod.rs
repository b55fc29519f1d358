//! Static recordings: what a slow sweep, a table of means or runs at constant command show of a valve without a clock.
//!
//! First the kind of the curve is told, against its own scatter ([`Shape`]). Only a curve that is monotone has a gain, a null, a dead zone and a
//! saturation; a maximum inside, as the leakage of a valve has at its null, has a height and a width; of others only the kind is told. Then come
//! width of the loop, droop of the supply and rise of the return pressure with flow. What the instrument does to its reading (a staircase, a jump at
//! one reading) is separated from the valve and reported. A loop may be hysteresis or a lag: one sweep cannot tell, and names neither; sweeps at
//! several rates can ([`compare()`]).

mod branch;
mod course;
mod curve;
pub mod indications;
mod instrument;
mod line;
mod loops;
mod runs;
mod several;
mod shape;

use curve::Sweep;
use line::median_and_std;
use serde::Serialize;

use recording::{RecordingError, StaticTable};
use simulation::signal::noise::extent;

pub use branch::{Branch, branches};
pub use curve::{Edge, Hysteresis, LocalGain, Null, Saturation};
pub use indications::{Evidence, Indication, PortPressure, Remark};
pub use instrument::{Jump, Staircase, jumps, staircase};
pub use line::FittedLine;
pub use runs::{VELOCITY, means};
pub use several::{Cause, Comparison, Estimate, LoopAtRate, RateFrom, compare};
pub use shape::{Extreme, Shape};

/// Which column of a table is what; headers, with or without their units.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// What was set: current, voltage, percent.
    pub input: String,
    /// What resulted: flow, speed, load pressure, spool.
    pub output: String,
    /// The measured spool between them, where there is one.
    pub spool: Option<String>,
    /// The supply pressure.
    pub supply: Option<String>,
    /// A pressure on the way back to the tank.
    pub returning: Option<String>,
}

/// Why a table cannot be read as a static recording.
#[derive(Debug, thiserror::Error)]
pub enum StaticsError {
    /// A file or one of its columns.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The input or the output never changes.
    #[error("{table}: `{column}` is {value} in every row; expected a column that is swept")]
    Constant {
        /// The table.
        table: String,
        /// The column.
        column: String,
        /// Its value.
        value: f64,
    },
    /// Fewer rows than a characteristic needs.
    #[error("{table}: {rows} rows; expected at least {least}")]
    TooFewRows {
        /// The table.
        table: String,
        /// How many it has.
        rows: usize,
        /// How many are needed.
        least: usize,
    },
    /// Not one period for each sweep.
    #[error("{periods} periods for {sweeps} recordings; expected one for each, in the order of the files")]
    PeriodsOfOthers {
        /// How many periods were given.
        periods: usize,
        /// How many sweeps.
        sweeps: usize,
    },
    /// A run whose command is not constant.
    #[error("{run}: `{input}` goes from {from} to {to}; expected runs at a constant command each")]
    InputMoves {
        /// The run.
        run: String,
        /// The command's column.
        input: String,
        /// Lowest value.
        from: f64,
        /// Highest value.
        to: f64,
    },
}

/// A column and the range that it covers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Axis {
    /// Its header.
    pub header: String,
    /// Lowest value.
    pub low: f64,
    /// Highest value.
    pub high: f64,
}

/// A pressure at one port over the flow.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Port {
    /// The column.
    pub header: String,
    /// Pressure at no flow on the line.
    pub at_rest: f64,
    /// Pressure at the largest flow on the line.
    pub at_full: f64,
    /// Scatter of the rows about the line (1.4826 × median absolute deviation).
    pub scatter: f64,
    /// The robust line over |output|.
    pub line: FittedLine,
}

/// What a static recording shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statics {
    /// The table.
    pub recording: String,
    /// Its rows.
    pub rows: usize,
    /// The input.
    pub input: Axis,
    /// The output.
    pub output: Axis,
    /// The branches that were read: true where the input rises.
    pub branches: Vec<bool>,
    /// The kind of the curve.
    pub shape: Shape,
    /// Gain at small outputs, mean of both signs.
    pub gain: Option<f64>,
    /// The loop, where the input rises and falls.
    pub hysteresis: Option<Hysteresis>,
    /// Input that the steeper flank takes from a quarter to three quarters of its height.
    pub flank: Option<f64>,
    /// Mean rate of the input, its unit a second, where there is a clock.
    pub rate_per_s: Option<f64>,
    /// Where the output is zero, if it has both signs.
    pub null: Option<Null>,
    /// Where positive output begins.
    pub positive: Option<Edge>,
    /// Where negative output begins.
    pub negative: Option<Edge>,
    /// The gain along the input.
    pub gains: Vec<LocalGain>,
    /// Where the gain has fallen.
    pub saturation: Vec<Saturation>,
    /// Where the measured spool no longer follows the input.
    pub spool_saturation: Vec<Saturation>,
    /// The meter's staircase.
    pub staircase: Option<Staircase>,
    /// The meter's jumps.
    pub jumps: Vec<Jump>,
    /// The supply pressure over flow.
    pub supply: Option<Port>,
    /// The return pressure over flow.
    pub returning: Option<Port>,
    /// Effects of the catalogue, with the evidence for each.
    #[serde(skip)]
    pub indications: Vec<Indication>,
    /// What a reader should know.
    #[serde(skip)]
    pub remarks: Vec<Remark>,
}

impl Statics {
    /// The same, of a sweep whose way up and down took this time, s: for one without a clock.
    #[must_use]
    pub fn with_period(mut self, period_s: f64) -> Self {
        let rate = 2.0 * (self.input.high - self.input.low) / period_s;
        self.rate_per_s = Some(rate);
        let lag_s = self.hysteresis.map(|found| found.width / rate / 2.0);
        for remark in &mut self.remarks {
            if matches!(remark, Remark::LagOrLoop { .. }) {
                *remark = Remark::LagOrLoop { lag_s };
            }
        }
        self
    }

    /// Whether way up and way down are apart by more than their scatter.
    #[must_use]
    pub fn has_loop(&self) -> bool {
        self.hysteresis.is_some_and(|found| {
            let surely = Estimate { value: found.width, std: found.std_error }.is_sure();
            surely && found.share_of_span > indications::LEAST
        })
    }
}

const LEAST_ROWS: usize = 5;

/// Reads the static characteristic off a table.
pub fn analyse(table: &StaticTable, columns: &Columns) -> Result<Statics, StaticsError> {
    if table.rows() < LEAST_ROWS {
        let (table, rows, least) = (table.name().to_owned(), table.rows(), LEAST_ROWS);
        return Err(StaticsError::TooFewRows { table, rows, least });
    }
    let swept = |header: &str| -> Result<(Axis, &[f64]), StaticsError> {
        let (header, values) = table.column(header)?;
        let (low, high) = extent(values);
        if low < high {
            return Ok((Axis { header: header.to_owned(), low, high }, values));
        }
        Err(StaticsError::Constant { table: table.name().to_owned(), column: header.to_owned(), value: low })
    };
    let ((input_axis, input), (output_axis, output)) = (swept(&columns.input)?, swept(&columns.output)?);
    let branches = branches(input);
    let sweep = Sweep { input, output, branches: &branches };
    let shape = shape::shape(&sweep, sweep.play());
    let (edged, monotone) = (shape.has_edges(), shape.is_monotone());
    let null = if edged { sweep.null() } else { None };
    let edge = |sign: f64| if edged { sweep.edge(sign) } else { None };
    let (positive, negative) = (edge(1.0), edge(-1.0));
    let edges: Vec<f64> = [positive, negative].into_iter().flatten().map(|edge| edge.gain).collect();
    let gain = (!edges.is_empty()).then(|| edges.iter().sum::<f64>() / edges.len() as f64);
    let staircase = staircase(output);
    let step = staircase.map(|staircase| staircase.step);
    let gains = gain.filter(|_| monotone).map_or_else(Vec::new, |gain| sweep.gains(gain, step, sweep.play()));
    let spool_saturation = match &columns.spool {
        Some(spool) => spool_stops(input, swept(spool)?.1, &branches),
        None => Vec::new(),
    };
    let port = |header: &Option<String>, least_flow: f64| -> Result<Option<Port>, StaticsError> {
        let Some(header) = header else { return Ok(None) };
        let (header, pressure) = table.column(header)?;
        Ok(over_flow(header, pressure, output, least_flow).filter(|_| !matches!(shape, Shape::Constant { .. })))
    };
    let mut statics = Statics {
        recording: table.name().to_owned(),
        rows: table.rows(),
        branches: branches.iter().map(|branch| branch.rising).collect(),
        hysteresis: sweep.loop_of(&shape, null),
        flank: sweep.flank(&shape),
        rate_per_s: table.clock_s().and_then(|time_s| rate_per_s(input, &time_s, &branches)),
        saturation: gain.map_or_else(Vec::new, |gain| curve::saturation(&gains, gain)),
        jumps: if monotone { jumps(input, output, &branches, staircase) } else { Vec::new() },
        supply: port(&columns.supply, 0.0)?,
        // A closed valve traps any pressure behind it.
        returning: port(&columns.returning, 0.01)?,
        shape,
        indications: Vec::new(),
        remarks: Vec::new(),
        input: input_axis,
        output: output_axis,
        gain,
        null,
        positive,
        negative,
        gains,
        spool_saturation,
        staircase,
    };
    statics.indications = indications::indications(&statics);
    statics.remarks = indications::remarks(&statics, table.clock_s().is_some(), columns.spool.is_some());
    Ok(statics)
}

/// Mean rate of the input over the branches, whichever way it goes.
fn rate_per_s(input: &[f64], time_s: &[f64], branches: &[Branch]) -> Option<f64> {
    let along = |values: &[f64]| -> f64 {
        branches.iter().map(|branch| (values[branch.rows.end - 1] - values[branch.rows.start]).abs()).sum()
    };
    let rate = along(input) / along(time_s);
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// Where the spool no longer follows the input, compared with its usual gain.
fn spool_stops(input: &[f64], spool: &[f64], branches: &[Branch]) -> Vec<Saturation> {
    let (low, high) = extent(spool);
    let centred: Vec<f64> = spool.iter().map(|value| value - f64::midpoint(low, high)).collect();
    let sweep = Sweep { input, output: &centred, branches };
    if !shape::shape(&sweep, sweep.play()).is_monotone() {
        return Vec::new();
    }
    let gains = sweep.gains(1.0, None, 0.0);
    let usual = line::median(gains.iter().map(|local| local.gain).collect());
    curve::saturation(&gains, usual)
}

/// A pressure over the magnitude of the flow.
fn over_flow(header: &str, pressure: &[f64], flow: &[f64], least_share: f64) -> Option<Port> {
    let full = flow.iter().map(|flow| flow.abs()).fold(0.0, f64::max);
    let points: Vec<(f64, f64)> = flow.iter().zip(pressure).map(|(flow, pressure)| (flow.abs(), *pressure)).collect();
    let flowing: Vec<(f64, f64)> = points.into_iter().filter(|point| point.0 >= least_share * full).collect();
    let least = flowing.iter().map(|point| point.0).fold(f64::INFINITY, f64::min);
    // A line is followed no further than it is long.
    let line = FittedLine::robust(&flowing).filter(|_| least <= full - least)?;
    let at = |flow: f64| line.at_zero + line.slope * flow;
    let about: Vec<f64> = flowing.iter().map(|(flow, pressure)| pressure - at(*flow)).collect();
    let (at_rest, at_full, scatter) = (at(0.0), at(full), median_and_std(&about).1);
    Some(Port { header: header.to_owned(), at_rest, at_full, scatter, line })
}

#[cfg(test)]
mod tests;
