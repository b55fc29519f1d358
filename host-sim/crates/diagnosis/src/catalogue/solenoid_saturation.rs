//! # Solenoid saturation
//!
//! ## What it adds
//! At a large command the magnet's iron saturates or its amplifier limits the current, and the spool falls behind the
//! straight characteristic: beyond the onset `x_s` its travel `t = |x| − x_s` becomes `t/(1 + c·t)`, or `(1 − d)·t` where
//! the characteristic has a knee.
//!
//! ## How it shows
//! The spool misses travel at large |U| only, the same at rest and in motion and on both sides; small strokes fit.
//!
//! ## What looks alike
//! A rate limit acts only while the spool moves. A curved flow gain has the same effect on the rod, but the spool
//! reaches its set value. Flow force grows with the pressure difference as well.
//!
//! ## Parameters
//! Onset in parts of full travel, 0.1–1. Curvature c, not negative: 0.1 takes 5 % at half a travel beyond the onset, 10
//! leaves next to nothing. Share d of the gain that is lost beyond a knee, 0.03–0.6.
//!
//! ## Source
//! N. D. Vaughan and J. B. Gamble, *The modeling and simulation of a proportional solenoid valve*, J. Dynamic Systems,
//! Measurement, and Control 118, 1996.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const ONSET: EffectParameter =
    EffectParameter { parameter: Parameter::SolenoidOnset, kind: Kind::Shape(|_| (0.1, 1.0), 4) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "solenoid-saturation",
    subsystem: Subsystem::Valve,
    equation: "|x| = x_s + t/(1 + c·t) or x_s + (1 − d)·t, t = |x_set| − x_s > 0",
    forms: &[
        &[EffectParameter { parameter: Parameter::SolenoidCurvature, kind: Kind::Amount(|_| (0.1, 10.0)) }, ONSET],
        &[EffectParameter { parameter: Parameter::SolenoidLoss, kind: Kind::Amount(|_| (0.03, 0.6)) }, ONSET],
    ],
    look_alikes: &[
        LookAlike {
            effect: "flow-gain-nonlinearity",
            told_apart_by: "steps of several sizes, spool recorded: with a curved flow gain the spool arrives",
        },
        LookAlike {
            effect: "flow-force",
            told_apart_by: "steps of several sizes with the supply shut off: saturation stays, flow force is gone",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "steps of several sizes up to full command, spool recorded",
    source: "Vaughan & Gamble, J. Dyn. Syst. Meas. Control 118, 1996",
    shows_in: |scene| scene.input_point == InputPoint::Command,
};
