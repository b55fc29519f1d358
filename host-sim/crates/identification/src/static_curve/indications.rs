//! From the figures to effects of the catalogue, each with its evidence.

use serde::Serialize;

use recording::files::source_error::rounded;
use simulation::signal::noise::extent;

use super::Statics;
use super::curve::LocalGain;

/// An effect of the catalogue that a static recording shows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Indication {
    /// Its name.
    pub effect: &'static str,
    /// The evidence for it.
    pub evidence: String,
}

/// A figure is accepted if it is more than this many times its scatter.
const SURE: f64 = 3.0;
/// Least size that is reported: loops as a share of the span, pressures as a share of the supply.
const LEAST: f64 = 1e-3;
/// If gains differ by more than this share of the gain at small outputs, the characteristic is no straight line.
const STRAIGHT: f64 = 0.3;

/// Whether an output is a pressure, judging by its header.
fn is_pressure(header: &str) -> bool {
    header.contains("pressure") || header.contains("[bar]")
}

fn is_spool(header: &str) -> bool {
    ["spool", "slider"].iter().any(|name| header.contains(name))
}

/// Rounded to three digits.
pub fn short(value: f64) -> String {
    format!("{value:.2e}").parse::<f64>().map_or_else(|_| value.to_string(), |value| rounded(value).to_string())
}

pub(crate) fn indications(statics: &Statics) -> Vec<Indication> {
    let mut found = Vec::new();
    let mut indication = |effect, evidence| found.push(Indication { effect, evidence });
    if let Some(hysteresis) = statics.hysteresis
        && hysteresis.width > SURE * hysteresis.std
        && hysteresis.share_of_span > LEAST
    {
        indication(
            "valve-hysteresis",
            format!(
                "the way back is {} ± {} from the way up at {} levels of {}: {:.1} % of the span",
                short(hysteresis.width),
                short(hysteresis.std),
                hysteresis.levels,
                statics.output.header,
                100.0 * hysteresis.share_of_span,
            ),
        );
    }
    let flow = !is_pressure(&statics.output.header);
    let spool_stops = statics.spool_saturation.iter().find(|fallen| fallen.share < 0.2).or_else(|| {
        is_spool(&statics.output.header).then(|| statics.saturation.iter().find(|fallen| fallen.share < 0.2))?
    });
    if let Some(fallen) = spool_stops {
        let from = short(fallen.from);
        indication(
            "solenoid-saturation",
            format!("the spool follows with less than a tenth of its gain from {from} on"),
        );
    }
    if flow
        && !is_spool(&statics.output.header)
        && let Some((low, high)) = unequal_gains(statics)
    {
        indication(
            "flow-gain-nonlinearity",
            format!("the gain is {:.0} to {:.0} % of that at small openings", 100.0 * low, 100.0 * high),
        );
    }
    if let Some(port) = &statics.supply
        && port.at_rest - port.at_full > (SURE * port.scatter).max(LEAST * port.at_rest)
    {
        let (rest, full) = (short(port.at_rest), short(port.at_full));
        indication("supply-droop", format!("{} falls from {rest} at rest to {full} at the largest flow", port.header));
    }
    if let Some(port) = &statics.returning
        && port.at_full - port.at_rest > SURE * port.scatter
        && port.line.r_squared > 0.5
    {
        let (rest, full) = (short(port.at_rest), short(port.at_full));
        indication(
            "tank-back-pressure",
            format!("{} rises from {rest} at little flow to {full} at the largest", port.header),
        );
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
    let shares = opened.map(|local| local.gain / gain);
    let (low, high) = extent(shares);
    (high - low > STRAIGHT).then_some((low, high))
}

pub(crate) fn remarks(statics: &Statics, clock: bool, spool: bool) -> Vec<String> {
    let mut found = Vec::new();
    let mut say = |text: String| found.push(text);
    say(if clock {
        "the clock is not used: only what does not depend on the rate is read".to_owned()
    } else {
        "rows in the order of the file, no clock: only what does not depend on the rate is read".to_owned()
    });
    if statics.indications.iter().any(|indication| indication.effect == "valve-hysteresis") {
        say("a lag would also open a loop; the sweep is assumed to be slow against the valve".to_owned());
    }
    if let Some(stairs) = statics.staircase {
        let from = if stairs.from_magnitude > 0.0 {
            format!(" from ±{} on", short(stairs.from_magnitude))
        } else {
            String::new()
        };
        say(format!(
            "instrument: {} stands on {} levels {} apart{from}: a staircase of the meter, not of the valve; the loop is read at the \
             edges of its steps{}",
            statics.output.header,
            stairs.levels,
            short(stairs.step),
            if stairs.from_magnitude > 0.0 { ", and a different gain there is attributed to the meter" } else { "" },
        ));
    }
    for jump in &statics.jumps {
        say(format!(
            "instrument: {} jumps from {} to {} near {} on every branch and nowhere else: attributed to the meter",
            statics.output.header,
            short(jump.output.0),
            short(jump.output.1),
            short(jump.input)
        ));
    }
    if is_pressure(&statics.output.header) && !statics.saturation.is_empty() {
        say("the output is a pressure and ends at the supply's: this is not saturation of the valve".to_owned());
    } else if !spool && !is_spool(&statics.output.header) && !statics.saturation.is_empty() {
        say("without a measured spool it cannot be decided whether spool or orifice stops following at the end"
            .to_owned());
    }
    match (statics.positive, statics.negative) {
        (Some(_), Some(_)) => {
            say("edges of unequal distance from zero may be a dead-zone-asymmetry or an offset of the input: not separable here".to_owned());
        }
        (None, None) => say("no output from which an edge could be read".to_owned()),
        _ => say("one direction only: neither null nor the other side's dead zone".to_owned()),
    }
    if statics.indications.iter().any(|indication| indication.effect == "solenoid-saturation") {
        say("a spool that stops may be at its solenoid's limit, at its stop or at the end of its sensor: not separable here".to_owned());
    }
    if statics.returning.is_some() {
        say("a pressure at the valve's port holds the drop of the edge behind it as well as that of the line"
            .to_owned());
    }
    found
}
