//! # Flow force
//!
//! ## What it adds
//! The jet through the edges pushes the spool closed, in proportion to opening and pressure difference; magnet and
//! spring give way: `x = x_set·(1 − k·Δp)`, Δp the sum over both open edges.
//!
//! ## How it shows
//! The spool misses travel as the hydraulic power grows: at large openings and small loads. Under a load that takes
//! the whole supply nothing is missing.
//!
//! ## What looks alike
//! Hysteresis depends on the direction of the command, saturation on the command alone. A supply that droops reduces the
//! flow while the spool keeps its travel.
//!
//! ## Parameters
//! k in 1/Pa, not negative: 0.5–40 % of the travel at full supply pressure. A valve with a position loop shows next to
//! none.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §5-6; J. F. Blackburn, G. Reethof, J. L. Shearer, *Fluid
//! Power Control*, MIT Press 1960.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "flow-force",
    subsystem: Subsystem::Valve,
    equation: "x = x_set·(1 − k·Δp)",
    forms: &[&[EffectParameter {
        parameter: Parameter::FlowForce,
        kind: Kind::Amount(|scene| {
            let supply_pa = scene.machine.get(Parameter::SupplyPressure);
            (5e-3 / supply_pa, 0.4 / supply_pa)
        }),
    }]],
    look_alikes: &[
        LookAlike {
            effect: "valve-hysteresis",
            told_apart_by: "slow triangle with the supply pressure lowered: flow force shrinks with it",
        },
        LookAlike {
            effect: "solenoid-saturation",
            told_apart_by: "steps of several sizes with the supply shut off: flow force is gone",
        },
        LookAlike {
            effect: "supply-droop",
            told_apart_by: "steps of several sizes, spool recorded: droop leaves the spool in its place",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes at two loads and steps of several sizes, spool recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, §5-6",
    shows_in: |scene| scene.input_point == InputPoint::Command,
};
