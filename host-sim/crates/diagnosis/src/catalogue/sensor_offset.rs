//! # Sensor offset
//!
//! ## What it adds
//! One channel reads wrong by a constant or by a factor: a pressure, the spool's LVDT, or the position's scale. One
//! error of one channel at a time.
//!
//! ## How it shows
//! The same in every recording and at every instant: a constant pressure that is there without supply, a spool off its
//! centre at rest, strokes that are all too long by the same share. The channel disagrees with all others,
//! which agree among themselves. With spool and position alone, no other channel shows the motion, and the position's scale is not tried.
//!
//! ## What looks alike
//! Physics varies with time, load or position, a wrong reading does not: test for it first. Without the spool's sensor, an
//! offset of the spool and unequal overlap are one and the same.
//!
//! ## Parameters
//! Pressure in Pa, either sign, up to 10 % of the supply; spool in parts of full travel, up to 5 %; gain errors of
//! pressure and spool up to 10 %, of the position up to 5 %, positive reads too much.
//!
//! ## Source
//! R. Isermann, *Fault-Diagnosis Systems*, Springer 2006 (offset and gain faults of sensors); E. O. Doebelin,
//! *Measurement Systems: Application and Design*, McGraw-Hill.

use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Scene, Subsystem};

/// The largest usual error of a sensor; 0 where the sensor is not there.
fn of(scene: &Scene<'_>, signal: Signal, largest: f64) -> f64 {
    if scene.judges(signal) { largest } else { 0.0 }
}

fn pressure_a_pa(scene: &Scene<'_>) -> f64 {
    of(scene, Signal::PressureA, 0.1 * scene.machine.get(Parameter::SupplyPressure))
}

fn pressure_b_pa(scene: &Scene<'_>) -> f64 {
    of(scene, Signal::PressureB, 0.1 * scene.machine.get(Parameter::SupplyPressure))
}

/// A wrong scale of all motion that no other channel contradicts may come from flow, areas or the sensor, so it is not tried. A spool shows
/// how far the valve opens, not the motion that results.
fn position_factor(scene: &Scene<'_>) -> f64 {
    const OF_MOTION: [Signal; 5] =
        [Signal::Flow, Signal::PressureA, Signal::PressureB, Signal::Force, Signal::Velocity];
    let contradicted = OF_MOTION.iter().any(|&signal| scene.judges(signal));
    if contradicted { of(scene, Signal::Position, 0.05) } else { 0.0 }
}

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "sensor-offset",
    subsystem: Subsystem::Sensing,
    equation: "read = (1 + f)·true + offset, one channel",
    forms: &[
        &[EffectParameter { parameter: Parameter::PressureAOffset, kind: Kind::Signed(pressure_a_pa) }],
        &[EffectParameter { parameter: Parameter::PressureBOffset, kind: Kind::Signed(pressure_b_pa) }],
        &[EffectParameter {
            parameter: Parameter::SpoolOffset,
            kind: Kind::Signed(|scene| of(scene, Signal::Spool, 0.05)),
        }],
        &[EffectParameter {
            parameter: Parameter::PressureAFactor,
            kind: Kind::Signed(|scene| of(scene, Signal::PressureA, 0.1)),
        }],
        &[EffectParameter {
            parameter: Parameter::PressureBFactor,
            kind: Kind::Signed(|scene| of(scene, Signal::PressureB, 0.1)),
        }],
        &[EffectParameter {
            parameter: Parameter::SpoolFactor,
            kind: Kind::Signed(|scene| of(scene, Signal::Spool, 0.1)),
        }],
        &[EffectParameter { parameter: Parameter::PositionFactor, kind: Kind::Signed(position_factor) }],
    ],
    look_alikes: &[
        LookAlike {
            effect: "null-drift",
            told_apart_by: "long run for warming up: a sensor's offset is the same from start to end",
        },
        LookAlike {
            effect: "dead-zone-asymmetry",
            told_apart_by: "slow triangle, spool recorded: a wrong reading shows at zero command, too",
        },
        LookAlike {
            effect: "external-leakage",
            told_apart_by: "closed-valve hold under load: a sensor's offset stays, a leaking chamber empties",
        },
        LookAlike {
            effect: "metering-asymmetry",
            told_apart_by: "closed-valve hold under load: unequal edges shift no pressure at rest",
        },
        LookAlike {
            effect: "friction-asymmetry",
            told_apart_by: "closed-valve hold under load: friction of either direction ends with the motion",
        },
        LookAlike {
            effect: "position-dependent-load",
            told_apart_by: "strokes over the whole stroke: a sensor's offset is the same at every position",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "closed-valve hold with the supply shut off, all sensors recorded",
    source: "Isermann, Fault-Diagnosis Systems, 2006",
    // Each of its forms is only possible where its sensor is there.
    shows_in: |_| true,
};
