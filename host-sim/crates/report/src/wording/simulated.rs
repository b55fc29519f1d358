//! What to know of a simulation along a recording; each with the recording's name.

use recording::display_unit::{significant, unit_for_people};
use recording::{Linkage, Recording, Signal};

/// Where in the play of its sensor the rod starts, m from its middle.
#[must_use]
pub fn starts_in_play(recording: &Recording, shift_m: f64) -> String {
    let (name, size) = (recording.name(), significant(1e3 * shift_m.abs(), 2));
    let side = if shift_m < 0.0 { "retracted" } else { "extended" };
    format!("{name}: the rod starts {size} mm on the {side} side of the middle of its play, as the recording tells")
}

/// Where the rod starts if its position was not measured.
#[must_use]
pub fn starts_anywhere(recording: &Recording) -> Option<String> {
    let unmeasured = !recording.has(Signal::Position);
    unmeasured.then(|| format!("{}: no position is recorded: the rod starts at mid-stroke", recording.name()))
}

/// Where the sensor of a signal ends, SI.
#[must_use]
pub fn sensor_ends(recording: &Recording, signal: Signal, ends: &[f64]) -> String {
    let ends: Vec<String> = ends.iter().map(|end| told(signal, *end)).collect();
    let (name, ends) = (recording.name(), ends.join(" and "));
    format!("{name}: the sensor of {signal} ends at {ends}, and so does what is simulated of it")
}

/// A simulated rod that leaves what the linkage reaches.
#[must_use]
pub fn linkage_ends(recording: &Recording, linkage: &Linkage) -> String {
    let (low, high) = linkage.reach_rad();
    let (low, high) = (told(Signal::Angle, low), told(Signal::Angle, high));
    format!(
        "{}: the linkage reaches {low} to {high}, and the simulated rod comes to its end: the angle stays there",
        recording.name()
    )
}

/// A value of a signal in the unit for people.
fn told(signal: Signal, value: f64) -> String {
    let unit = unit_for_people(signal);
    format!("{} {unit}", significant(unit.from_si(value), 4))
}
