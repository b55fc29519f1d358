//! What a simulation along a recording takes from it beyond the input: where the rod starts in the play of its sensor, where the sensors end, and which
//! of the computed signals stand in the place of recorded ones.

use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Tick};
use recording::{Column, Linkage, Recording, RecordingError, Series, Signal};
use simulation::Trajectory;
use simulation::sensor_fault::sensor_range;

use crate::experiment::Prepared;
use crate::fit::settle;

/// Every signal that the model computes, in the order in which it is written.
pub const SIGNALS: [Signal; 8] = [
    Signal::Spool,
    Signal::Position,
    Signal::Velocity,
    Signal::PressureA,
    Signal::PressureB,
    Signal::Flow,
    Signal::Force,
    Signal::Angle,
];

/// How far from the middle of the play of its sensor the rod starts, m; positive on the extended side. No sensor shows it, and what was recorded tells it
/// as soon as the rod has moved through the play. `None` without a play, or where nothing is recorded that tells it.
#[must_use]
pub fn start_in_play(machine: &Machine<f64>, recording: &Recording, load: LoadSource, tick: Tick) -> Option<f64> {
    let half_m = 0.5 * machine.get(Parameter::BacklashPlay);
    if half_m <= 0.0 || !recording.has(Signal::Position) {
        return None;
    }
    // A recording that cannot be judged is simulated all the same.
    let case = Prepared::new(recording, machine, load, Some(tick)).ok()?;
    let shift_m = settle(machine, &case).ok()?.offset(machine, &case).shift_m.clamp(-half_m, half_m);
    (shift_m.abs() > case.start_sigma_m).then_some(shift_m)
}

/// Ends what is simulated where the recorded sensors end; gives the finite ends of each signal that has any, SI.
pub fn end_with_sensors(recording: &Recording, simulated: &mut Trajectory) -> Vec<(Signal, Vec<f64>)> {
    let mut all = Vec::new();
    for (signal, values) in &mut simulated.series {
        let (low, high) = sensor_range(recording, *signal);
        for value in values.iter_mut() {
            *value = value.clamp(low, high);
        }
        let ends: Vec<f64> = [low, high].into_iter().filter(|end| end.is_finite()).collect();
        if !ends.is_empty() {
            all.push((*signal, ends));
        }
    }
    all
}

/// Adds the angle of the joint, where there is a position; gives whether the rod leaves what the linkage reaches.
pub fn add_angle(linkage: &Linkage, simulated: &mut Trajectory) -> bool {
    let Some(position_m) = simulated.signal(Signal::Position) else { return false };
    let angle_rad: Vec<f64> = position_m.iter().map(|position| linkage.angle_rad(*position)).collect();
    let (low, high) = linkage.reach_rad();
    let ends = angle_rad.iter().any(|angle| *angle <= low || *angle >= high);
    simulated.series.push((Signal::Angle, angle_rad));
    ends
}

/// The simulated signals in place of the recorded ones, and the additional ones where none was recorded.
#[must_use]
pub fn columns<'a>(recording: &Recording, simulated: &'a Trajectory) -> (Vec<Series<'a>>, Vec<Series<'a>>) {
    let computed: Vec<Series<'_>> =
        SIGNALS.iter().filter_map(|&signal| Some((signal, simulated.signal(signal)?))).collect();
    let replaces = computed.iter().any(|(signal, _)| *signal != Signal::Angle && recording.has(*signal));
    let is_added = |signal: Signal| !replaces || (signal == Signal::Angle && !recording.has(signal));
    let added = computed.iter().copied().filter(|(signal, _)| is_added(*signal)).collect();
    (computed, added)
}

/// The command and every signal that follows from it, in SI units.
pub fn response(input: &Recording, simulated: &Trajectory) -> Result<Recording, RecordingError> {
    let given = input.columns().iter().filter(|column| column.signal != Signal::Position).cloned();
    let computed = SIGNALS.iter().filter_map(|&signal| Some(Column::si(signal, simulated.signal(signal)?.to_vec())));
    Recording::new("the response", given.chain(computed).collect())
}
