//! From the figures to effects of the catalogue, each with its evidence, and what a reader should know of the recording. Sentences for both
//! are formed by `report`.

use simulation::signal::noise::extent;

use super::course::beyond_chance;
use super::curve::LocalGain;
use super::{Jump, Port, Staircase, Statics};

/// An effect of the catalogue that a static recording shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Indication {
    /// Its name.
    pub effect: &'static str,
    /// The evidence for it.
    pub evidence: Evidence,
}

/// What shows an effect; inputs and outputs in the units of their columns.
#[derive(Clone, Debug, PartialEq)]
pub enum Evidence {
    /// The loop that stays however slow the sweep.
    LoopStays {
        /// Its width, input unit.
        width: f64,
        /// Its standard error.
        std: f64,
        /// In how many sweeps.
        sweeps: usize,
    },
    /// The spool follows with less than a tenth of its gain.
    SpoolStops {
        /// From this input on.
        from: f64,
    },
    /// The gain is no straight line: lowest and highest over that at small openings.
    UnequalGains {
        /// Lowest.
        low: f64,
        /// Highest.
        high: f64,
    },
    /// The supply pressure falls with the flow.
    SupplyFalls(PortPressure),
    /// The return pressure rises with the flow.
    ReturnRises(PortPressure),
}

/// A port's pressure without flow and at the largest.
#[derive(Clone, Debug, PartialEq)]
pub struct PortPressure {
    /// The column.
    pub header: String,
    /// Without flow.
    pub at_rest: f64,
    /// At the largest flow.
    pub at_full: f64,
}

/// What a reader of a static recording should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// Only what does not depend on the rate is read.
    NoRate {
        /// Whether the table has a clock, which is not used.
        clock: bool,
    },
    /// A loop may be hysteresis or a lag.
    LagOrLoop {
        /// The lag that it would be, s, where the rate is known.
        lag_s: Option<f64>,
    },
    /// No gain, null, dead zone or saturation is read, since the curve is none that has them.
    NoGain,
    /// A monotone curve whose output is nowhere small.
    NowhereSmall,
    /// The meter's staircase.
    Staircase(Staircase),
    /// A jump of the meter.
    Jump(Jump),
    /// The output is a pressure and ends at the supply's.
    PressureEnds,
    /// Spool or orifice stops following at the end: not decided.
    SpoolOrOrifice,
    /// A dead zone that is wider on one side or an offset of the input: not decided.
    EdgesOrOffset,
    /// Neither null nor the other side's dead zone.
    OneDirection,
    /// A solenoid's limit, a stop or a sensor's end: not decided.
    LimitStopOrSensor,
    /// A port's pressure holds the drop of its edge as well.
    PortHoldsEdge,
}

/// A figure is accepted if it is more than this many times its scatter.
pub(crate) const SURE: f64 = 3.0;
/// Least size that is reported: loops as a share of the span, pressures as a share of the supply.
pub(crate) const LEAST: f64 = 1e-3;
/// If gains differ by more than this share of the gain at small outputs, the characteristic is no straight line.
const STRAIGHT: f64 = 0.3;

/// Whether an output is a pressure, judging by its header.
fn is_pressure(header: &str) -> bool {
    header.contains("pressure") || header.contains("[bar]")
}

fn is_spool(header: &str) -> bool {
    ["spool", "slider"].iter().any(|name| header.contains(name))
}

pub(crate) fn indications(statics: &Statics) -> Vec<Indication> {
    let mut found = Vec::new();
    let mut indication = |effect, evidence| found.push(Indication { effect, evidence });
    let flow = !is_pressure(&statics.output.header);
    let spool_stops = statics.spool_saturation.iter().find(|fallen| fallen.share < 0.2).or_else(|| {
        is_spool(&statics.output.header).then(|| statics.saturation.iter().find(|fallen| fallen.share < 0.2))?
    });
    if let Some(fallen) = spool_stops {
        indication("solenoid-saturation", Evidence::SpoolStops { from: fallen.from });
    }
    if flow
        && !is_spool(&statics.output.header)
        && let Some((low, high)) = unequal_gains(statics)
    {
        indication("flow-gain-nonlinearity", Evidence::UnequalGains { low, high });
    }
    let pressure =
        |port: &Port| PortPressure { header: port.header.clone(), at_rest: port.at_rest, at_full: port.at_full };
    if let Some(port) = &statics.supply
        && port.at_rest - port.at_full > (SURE * port.scatter).max(LEAST * port.at_rest)
    {
        indication("supply-droop", Evidence::SupplyFalls(pressure(port)));
    }
    if let Some(port) = &statics.returning
        && port.at_full - port.at_rest > SURE * port.scatter
        && port.line.r_squared > 0.5
    {
        indication("tank-back-pressure", Evidence::ReturnRises(pressure(port)));
    }
    found
}

/// Lowest and highest local gain over the gain at small outputs, without both ends of the sweep where the spool stops;
/// only if they differ too much for a straight line.
fn unequal_gains(statics: &Statics) -> Option<(f64, f64)> {
    let gain = statics.gain?;
    let largest = statics.gains.iter().map(|local| local.output.abs()).fold(0.0, f64::max);
    let stopped = |input: f64| {
        let beyond = |from: f64, upper: bool| if upper { input >= from } else { input <= from };
        statics.spool_saturation.iter().any(|fallen| fallen.share < 0.2 && beyond(fallen.from, fallen.upper))
    };
    let edges = || [statics.positive, statics.negative].into_iter().flatten().map(|edge| edge.extrapolated);
    let play = statics.hysteresis.map_or(0.0, |hysteresis| hysteresis.width.abs());
    let at_an_edge = |local: &LocalGain| edges().any(|edge| local.from - play < edge && edge < local.to + play);
    // Where the meter changes to a coarse range, its gain may change as well.
    let read_finely = |local: &LocalGain| {
        statics
            .staircase
            .is_none_or(|stairs| stairs.from_magnitude <= 0.0 || local.output.abs() < stairs.from_magnitude)
    };
    let opened = statics.gains.iter().filter(|local| {
        let inside = local.output.abs() > 0.1 * largest && !at_an_edge(local);
        inside && read_finely(local) && !stopped(f64::midpoint(local.from, local.to))
    });
    // Each gain as far from the others as it surely is.
    let opened: Vec<&LocalGain> = opened.collect();
    let z = beyond_chance(opened.len());
    let share = |local: &&LocalGain| (local.gain / gain, z * local.std_error / gain.abs());
    let shares: Vec<(f64, f64)> = opened.iter().map(share).collect();
    let surely_low = shares.iter().map(|(share, error)| share + error).fold(f64::INFINITY, f64::min);
    let surely_high = shares.iter().map(|(share, error)| share - error).fold(f64::NEG_INFINITY, f64::max);
    (surely_high - surely_low > STRAIGHT).then(|| extent(shares.iter().map(|share| share.0)))
}

pub(crate) fn remarks(statics: &Statics, clock: bool, spool: bool) -> Vec<Remark> {
    let indicated = |effect| statics.indications.iter().any(|indication| indication.effect == effect);
    let mut found = vec![Remark::NoRate { clock }];
    if statics.has_loop() {
        let lag_s = statics.rate_per_s.zip(statics.hysteresis).map(|(rate, loops)| loops.width / rate / 2.0);
        found.push(Remark::LagOrLoop { lag_s });
    }
    found.extend(statics.staircase.map(Remark::Staircase));
    found.extend(statics.jumps.iter().copied().map(Remark::Jump));
    if is_pressure(&statics.output.header) && !statics.saturation.is_empty() {
        found.push(Remark::PressureEnds);
    } else if !spool && !is_spool(&statics.output.header) && !statics.saturation.is_empty() {
        found.push(Remark::SpoolOrOrifice);
    }
    found.push(match (statics.positive, statics.negative) {
        _ if !statics.shape.has_edges() => Remark::NoGain,
        (Some(_), Some(_)) => Remark::EdgesOrOffset,
        (None, None) => Remark::NowhereSmall,
        _ => Remark::OneDirection,
    });
    if indicated("solenoid-saturation") {
        found.push(Remark::LimitStopOrSensor);
    }
    if statics.returning.is_some() {
        found.push(Remark::PortHoldsEdge);
    }
    found
}
