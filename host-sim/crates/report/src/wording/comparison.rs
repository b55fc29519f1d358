//! What a comparison says: which part is weakest and what that means, and which parts cannot be judged.

use std::collections::BTreeSet;

use identification::compare::open_loop::{Mover, SENSOR_OFFSET};
use identification::compare::weakest::{
    Obstacle, Unjudged, Weakest, missed_by_the_whole, obstacles, unjudged as all_unjudged, weakest,
};
use identification::compare::{Comparison, Section};
use machine_file::LoadSource;
use recording::Signal;
use recording::display_unit::{difference, percent, significant};

/// What prevents the links from being judged separately, and what to record.
#[must_use]
pub fn obstacle(obstacle: Obstacle) -> &'static str {
    match obstacle {
        Obstacle::NoSpool => "the valve cannot be told from the links below it: record `spool` for this",
        Obstacle::NoPressures => {
            "flow, chambers and mechanics cannot be told apart: record both chamber pressures (`pressure_a`, `pressure_b`) for this"
        }
        Obstacle::NoMotion => {
            "the links below the valve are not judged by their motion: record `position` or `velocity` for this"
        }
        Obstacle::LoadFromPressures => {
            "the mechanics cannot be judged: the load is taken from the recorded pressures, which takes a measured \
             `load_force` to avoid"
        }
    }
}

/// Why the misfit of a part says nothing about its physics.
#[must_use]
pub fn unjudged(part: &Unjudged) -> String {
    let Unjudged { section, signal, rmse, sway } = part;
    let (missed, moved) = (difference(*signal, *rmse), difference(*signal, sway.by_most));
    let by = match sway.most {
        Mover::Offset(signal) => {
            let sensor = match signal {
                Signal::PressureA | Signal::PressureB => "a pressure sensor".to_owned(),
                other => format!("the sensor of {other}"),
            };
            format!("an offset of {} % of the full scale of {sensor}", significant(100.0 * SENSOR_OFFSET, 1))
        }
        Mover::Parameter(parameter) => format!("{} off by its standard deviation", parameter.description().key),
        Mover::Tolerance(parameter) => format!("half the tolerance of {}", parameter.description().key),
    };
    format!(
        "{section} cannot be judged by {signal}, which it misses by {missed}: in open loop {by} alone moves it by {moved}"
    )
}

/// Which part is weakest, in each recording and over all, what that means, and what prevents parts from being distinguished.
#[must_use]
pub fn sentences(comparisons: &[Comparison], load: LoadSource) -> Vec<String> {
    let mut lines: Vec<String> = comparisons
        .iter()
        .filter_map(|comparison| {
            let found = weakest(std::slice::from_ref(comparison))?;
            Some(format!("{}: weakest is {}", comparison.recording, described(found)))
        })
        .collect();
    if let Some(found) = weakest(comparisons) {
        if comparisons.len() > 1 {
            lines.push(format!("over all {}: weakest is {} on average", comparisons.len(), described(found)));
        }
        lines.push(meaning(found, missed_by_the_whole(comparisons)));
    }
    lines.extend(all_unjudged(comparisons).iter().map(|part| format!("{}.", unjudged(part))));
    let missing: BTreeSet<&str> =
        comparisons.iter().flat_map(|comparison| obstacles(comparison, load)).map(obstacle).collect();
    lines.extend(missing.into_iter().map(|missing| format!("But {missing}.")));
    lines
}

fn described(found: Weakest) -> String {
    format!("{}, {} at {} %", found.section, found.signal, percent(found.nrmse_percent))
}

fn meaning(found: Weakest, whole: Option<(Signal, f64)>) -> String {
    if found.follows()
        && let Some((signal, fit)) = whole
    {
        return format!(
            "What could be judged by itself follows its recordings within about their noise. But end to end {signal} is at {} %:\n\
             physics is missing in a part that could not be judged by itself, or a parameter of it is off.",
            percent(fit)
        );
    }
    if found.follows() {
        return "Every part follows its recordings to about their noise; there is no sign of missing physics."
            .to_owned();
    }
    if found.cannot_be_judged() {
        return match whole {
            Some((signal, fit)) => format!(
                "No part that can be judged by itself misses its recordings. But end to end {signal} is at {} %, more than small errors of\n\
                 sensors and parameters make: `host-sim diagnose` refits and looks closer.",
                percent(fit)
            ),
            None => "Nothing is missed by more than small errors of sensors and parameters make; `host-sim diagnose` refits and looks closer."
                .to_owned(),
        };
    }
    let signal = found.signal;
    let told = match found.section {
        Section::EndToEnd => {
            return "This is the whole chain: whatever it misses may be missed anywhere in it.".to_owned();
        }
        Section::Valve => format!("Driven by the recorded command, the valve alone misses the recorded {signal}"),
        Section::BelowSpool => {
            format!("Driven by the recorded spool, flow, chambers and mechanics together miss the recorded {signal}")
        }
        Section::BelowFlow => format!("Driven by the recorded flow, chambers and mechanics together miss the {signal}"),
        Section::FlowAndChambers => format!(
            "At the recorded pressures, the flow minus the compression of the oil does not give the recorded {signal} (orifices,\n\
             pump, leakage or compressibility)"
        ),
        Section::Mechanics => {
            format!("Driven by the recorded pressures, mass, friction and load alone miss the recorded {signal}")
        }
    };
    match (found.rival(), found.runner_up) {
        (Some((rival, fit)), _) => format!(
            "{told}.\nBut {rival} misses nearly as much ({} %): which of the two lacks physics, or has a parameter off, is not \
             settled by these figures.",
            percent(fit)
        ),
        (None, Some(_)) => {
            format!(
                "{told}; the other parts fit better.\n\
                 This part does not follow: an effect is missing in it, or a parameter is further off than its standard deviation."
            )
        }
        (None, None) => format!("{told}.\nIt is the only part that could be judged by itself."),
    }
}
