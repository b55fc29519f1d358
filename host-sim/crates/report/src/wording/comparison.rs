//! Parts of a drive that a comparison cannot judge.

use identification::compare::open_loop::{Mover, SENSOR_OFFSET};
use identification::compare::weakest::{Obstacle, Unjudged};
use recording::Signal;
use recording::display_unit::{difference, significant};

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
