//! # Valve hysteresis
//!
//! ## What it adds
//! The spool settles at different places when the command comes from above and from below: magnetisation of the
//! solenoid, play and friction of the pilot. A play of the given width in the set value, x = play(g·U + x0); with a
//! spread, the mean of three plays of different width, which rounds the corners of the loop.
//!
//! ## How it shows
//! The valve link's residual of the spool has the sign of −dU/dt. The width of the loop of x over U does not depend
//! on how fast the command changes, and it is there at every opening.
//!
//! ## What looks alike
//! A delay or a lag also opens a loop, but one that grows with the rate. A dead zone acts near the centre only. Spool
//! stiction jumps. Flow force pushes with the hydraulic power, whichever way the command goes. Play in the linkage
//! leaves spool and pressures as they should be.
//!
//! ## Parameters
//! Width in parts of full travel, not negative: 0.1 % (servo valve with position loop) to 7–10 % (open-loop
//! proportional magnet). Spread 0..1: how far the widths of the three plays lie apart.
//!
//! ## Source
//! M. A. Krasnosel'skii and A. V. Pokrovskii, *Systems with Hysteresis*, Springer 1989 (play and its superpositions);
//! Y.-K. Wen, *Method for random vibration of hysteretic systems*, J. Eng. Mech. Div. ASCE 102, 1976 (the smooth
//! alternative); ISO 10770-1 (how a valve's hysteresis is measured).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const WIDTH: EffectParameter =
    EffectParameter { parameter: Parameter::HysteresisWidth, kind: Kind::Amount(|_| (1e-3, 0.1)) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "valve-hysteresis",
    subsystem: Subsystem::Valve,
    equation: "x = play of the set value g·U + x0, by width",
    forms: &[
        &[WIDTH],
        &[WIDTH, EffectParameter { parameter: Parameter::HysteresisSpread, kind: Kind::Shape(|_| (0.1, 1.0), 2) }],
    ],
    look_alikes: &[
        LookAlike { effect: "spool-stiction", told_apart_by: "slow triangle: a stuck spool rests and then jumps" },
        LookAlike {
            effect: "flow-force",
            told_apart_by: "slow triangle with the supply pressure lowered: hysteresis stays as wide",
        },
        LookAlike {
            effect: "linkage-backlash",
            told_apart_by: "slow triangle with spool or pressures recorded: they know nothing of play in the linkage",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "slow triangle at two rates, spool recorded",
    source: "Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989",
    shows_in: |scene| scene.input_point == InputPoint::Command,
};
