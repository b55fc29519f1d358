//! # Dead-zone asymmetry
//!
//! ## What it adds
//! The overlap differs between the two sides of the spool: it opens at x = d + Δ/2 to extend and at x = −(d − Δ/2) to
//! retract.
//!
//! ## How it shows
//! Flow is missing in one direction and too large in the other, by the same amount at every opening; the strokes of a
//! symmetric command drift away to one side.
//!
//! ## What looks alike
//! A wrong offset of the spool does exactly the same as long as the spool is not recorded: then the two cannot be
//! told apart. Drift of the null changes in the course of time. Unequal metering edges scale with the opening.
//!
//! ## Parameters
//! Δ in parts of full travel: overlap of the extending side less that of the retracting side, either sign; the overlaps
//! of both sides are 5–25 %, their difference up to 25 %.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 5 (overlap at the null); G. Tao and P. V. Kokotović,
//! *Adaptive Control of Systems with Actuator and Sensor Nonlinearities*, Wiley 1996 (unequal break-points).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "dead-zone-asymmetry",
    subsystem: Subsystem::Flow,
    equation: "opens at x > d + Δ/2 and at x < −(d − Δ/2)",
    forms: &[&[EffectParameter { parameter: Parameter::DeadZoneDifference, kind: Kind::Signed(|_| 0.25) }]],
    look_alikes: &[
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "slow triangle, spool recorded: a wrong reading shows at zero command, too",
        },
        LookAlike {
            effect: "null-drift",
            told_apart_by: "slow triangle at the start and the end of a long run: unequal overlap does not change",
        },
        LookAlike {
            effect: "metering-asymmetry",
            told_apart_by: "steps of several sizes: overlap takes the same travel from each, edges the same share",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "slow triangle through the centre, spool recorded",
    source: "Tao & Kokotović, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, 1996",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
