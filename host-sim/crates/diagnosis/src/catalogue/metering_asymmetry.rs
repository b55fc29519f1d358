//! # Metering asymmetry
//!
//! ## What it adds
//! The four edges are not of one size, as on spools for differential cylinders. Relative to P-A the flow gain of the edges to tank is
//! multiplied by 1 + r, of those at port B by 1 + s, and of those that are open while retracting by 1 + d: B-T has
//! (1 + r)·(1 + s), P-B (1 + s)·(1 + d), A-T (1 + r)·(1 + d).
//!
//! ## How it shows
//! Both chamber pressures of a steady stroke lie higher (r < 0) or lower (r > 0) than the model's, while the position
//! may look right. Unequal ports (s < 0) raise both while extending and lower both while retracting; unequal directions (d) leave
//! the pressures unchanged and change the speed in one direction.
//!
//! ## What looks alike
//! With wrong piston areas, or with an offset of a pressure sensor, the balance of forces is wrong at rest, too.
//! Back-pressure of the return line is quadratic in the flow. Unequal overlap removes a travel, not a share.
//!
//! ## Parameters
//! r or s, either sign: ±10–40 %; a spool cut for a 2:1 cylinder has s = −50 %. Edges that were cut alike still differ by some per cent,
//! in s and d as well. No edge may be five times P-A.
//!
//! ## Source
//! M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, chapter 4 (valves with unequal edges); J. Watton,
//! *Fundamentals of Fluid Power Control*, Cambridge University Press 2009.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const fn cut(parameter: Parameter) -> EffectParameter {
    EffectParameter { parameter, kind: Kind::Signed(|_| 0.5) }
}

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "metering-asymmetry",
    subsystem: Subsystem::Flow,
    equation: "Q = (1 + r to tank)·(1 + s at B)·(1 + d retracting)·K_Q·o·√Δp",
    forms: &[&[cut(Parameter::MeteringRatio)], &[cut(Parameter::MeteringPorts)]],
    look_alikes: &[
        LookAlike {
            effect: "tank-back-pressure",
            told_apart_by: "steps of several sizes, both pressures recorded: back-pressure grows with the flow squared",
        },
        LookAlike {
            effect: "dead-zone-asymmetry",
            told_apart_by: "steps of several sizes: overlap takes the same travel from each, edges the same share",
        },
        LookAlike {
            effect: "flow-gain-nonlinearity",
            told_apart_by: "steps of several sizes, both pressures recorded: a curved gain changes with the opening",
        },
        LookAlike {
            effect: "sensor-offset",
            told_apart_by: "closed-valve hold under load: a pressure sensor's offset is there at rest, too",
        },
    ],
    refined: &[&[cut(Parameter::MeteringRatio), cut(Parameter::MeteringPorts), cut(Parameter::MeteringDirections)]],
    extends: None,
    separated_by: "steps of several sizes both ways, both pressures recorded",
    source: "Jelali & Kroll, Hydraulic Servo-systems, 2003, ch. 4",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
