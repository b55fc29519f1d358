//! # Metering asymmetry
//!
//! ## What it adds
//! The edges to tank are larger or smaller than those from the supply, as spools for differential cylinders are cut:
//! the flow gain of A-T and B-T is multiplied by 1 + r.
//!
//! ## How it shows
//! Both chamber pressures of a steady stroke lie higher (r < 0) or lower (r > 0) than the model's, while the position
//! may look right.
//!
//! ## What looks alike
//! With wrong piston areas the balance of forces is off at rest, too, and so it is with a pressure sensor's offset.
//! Back-pressure of the return line is quadratic in the flow. Unequal overlap takes travel, not a share.
//!
//! ## Parameters
//! r, either sign: ±10–40 %; a spool cut for a 2:1 cylinder has more.
//!
//! ## Source
//! M. Jelali and A. Kroll, *Hydraulic Servo-systems*, Springer 2003, chapter 4 (valves with unequal edges); J. Watton,
//! *Fundamentals of Fluid Power Control*, Cambridge University Press 2009.

use model_core::parameter::Parameter;

use super::{Hypothesis, Kind, LookAlike, Strength, Subsystem};
use crate::simulate::EntryPoint;

pub(super) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "metering-asymmetry",
    subsystem: Subsystem::Flow,
    equation: "Q to tank = (1 + r)·K_Q·o·√Δp",
    forms: &[&[Strength { parameter: Parameter::MeteringRatio, kind: Kind::Signed(|_| 0.5) }]],
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
    extends: None,
    separated_by: "steps of several sizes both ways, both pressures recorded",
    source: "Jelali & Kroll, Hydraulic Servo-systems, 2003, ch. 4",
    shows_in: |scene| matches!(scene.entry, EntryPoint::Command | EntryPoint::Slider),
};
