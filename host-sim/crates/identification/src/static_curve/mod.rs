//! Static recordings: what a slow sweep, a table of means or runs at constant command show of a valve without a clock.
//!
//! Only rate-independent indications are given: width of the loop, null, dead zone, gain and where it falls, droop of the
//! supply and rise of the return pressure with flow. What the instrument does to its reading (a staircase, a jump at one
//! reading) is separated from the valve and reported. A loop of the same width at every level is hysteresis if the sweep
//! was slow; a triangular sweep at only one rate cannot exclude a lag, and the remarks say so.

mod branch;
mod curve;
pub mod indications;
mod instrument;
mod line;
mod runs;

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
    /// Gain at small outputs, mean of both signs.
    pub gain: Option<f64>,
    /// The loop, where the input rises and falls.
    pub hysteresis: Option<Hysteresis>,
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
    let null = sweep.null();
    let (positive, negative) = (sweep.edge(1.0), sweep.edge(-1.0));
    let edges: Vec<f64> = [positive, negative].into_iter().flatten().map(|edge| edge.gain).collect();
    let gain = (!edges.is_empty()).then(|| edges.iter().sum::<f64>() / edges.len() as f64);
    let staircase = staircase(output);
    let hysteresis = sweep.hysteresis(null);
    let play = hysteresis.map_or(0.0, |hysteresis| hysteresis.width.abs() + 2.0 * hysteresis.std);
    let step = staircase.map(|staircase| staircase.step);
    let gains = gain.map_or_else(Vec::new, |gain| sweep.gains(gain, step, play));
    let spool_saturation = match &columns.spool {
        Some(spool) => spool_stops(input, swept(spool)?.1, &branches),
        None => Vec::new(),
    };
    let port = |header: &Option<String>, least_flow: f64| -> Result<Option<Port>, StaticsError> {
        let Some(header) = header else { return Ok(None) };
        let (header, pressure) = table.column(header)?;
        Ok(over_flow(header, pressure, output, least_flow))
    };
    let mut statics = Statics {
        recording: table.name().to_owned(),
        rows: table.rows(),
        branches: branches.iter().map(|branch| branch.rising).collect(),
        hysteresis,
        saturation: gain.map_or_else(Vec::new, |gain| curve::saturation(&gains, gain)),
        jumps: jumps(input, output, &branches, staircase),
        supply: port(&columns.supply, 0.0)?,
        // A closed valve traps any pressure behind it.
        returning: port(&columns.returning, 0.01)?,
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

/// Where the spool no longer follows the input, compared with its usual gain.
fn spool_stops(input: &[f64], spool: &[f64], branches: &[Branch]) -> Vec<Saturation> {
    let (low, high) = extent(spool);
    let centred: Vec<f64> = spool.iter().map(|value| value - f64::midpoint(low, high)).collect();
    let sweep = Sweep { input, output: &centred, branches };
    let gains = sweep.gains(1.0, None, 0.0);
    let usual = line::median(gains.iter().map(|local| local.gain).collect());
    curve::saturation(&gains, usual)
}

/// A pressure over the magnitude of the flow.
fn over_flow(header: &str, pressure: &[f64], flow: &[f64], least_share: f64) -> Option<Port> {
    let full = flow.iter().map(|flow| flow.abs()).fold(0.0, f64::max);
    let points: Vec<(f64, f64)> = flow.iter().zip(pressure).map(|(flow, pressure)| (flow.abs(), *pressure)).collect();
    let flowing: Vec<(f64, f64)> = points.into_iter().filter(|point| point.0 >= least_share * full).collect();
    let line = FittedLine::robust(&flowing)?;
    let at = |flow: f64| line.at_zero + line.slope * flow;
    let about: Vec<f64> = flowing.iter().map(|(flow, pressure)| pressure - at(*flow)).collect();
    let (at_rest, at_full, scatter) = (at(0.0), at(full), median_and_std(&about).1);
    Some(Port { header: header.to_owned(), at_rest, at_full, scatter, line })
}

#[cfg(test)]
mod tests;
