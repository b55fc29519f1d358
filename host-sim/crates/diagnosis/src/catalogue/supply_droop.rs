//! # Supply droop
//!
//! ## What it adds
//! The supply pressure falls with the flow that is taken from it, p = p0 − R·Q, and does so with the time constant T =
//! R·C that an accumulator or the volume of the line gives it.
//!
//! ## How it shows
//! Only flow through the supply edge is missing, and more of it in a faster stroke. With an accumulator the supply has memory: the
//! first centimetres are fast, and the next stroke starts before the supply has recovered.
//!
//! ## What looks alike
//! A curved flow gain depends on the opening alone and acts on all edges. Back-pressure shows at the tank edge. A
//! recorded supply pressure decides.
//!
//! ## Parameters
//! R in Pa·s/m³, not negative: 1–60 bar at full flow, usually 5–30. T in s: 5 ms (line) to 2 s (accumulator).
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 11 (hydraulic power supplies); J. Watton,
//! *Fundamentals of Fluid Power Control*, Cambridge University Press 2009 (accumulators).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "supply-droop",
    subsystem: Subsystem::Flow,
    equation: "T·dp/dt = p0 − R·Q − p",
    forms: &[&[
        EffectParameter {
            parameter: Parameter::DroopResistance,
            kind: Kind::Amount(|scene| {
                let full = scene.full_flow_m3_per_s();
                (1e5 / full, 6e6 / full)
            }),
        },
        EffectParameter { parameter: Parameter::DroopTime, kind: Kind::Shape(|_| (5e-3, 2.0), 3) },
    ]],
    look_alikes: &[
        LookAlike {
            effect: "flow-gain-nonlinearity",
            told_apart_by: "steps of several sizes at two loads, or the supply pressure recorded",
        },
        LookAlike {
            effect: "tank-back-pressure",
            told_apart_by: "steps of several sizes, both pressures recorded: which edge the flow is missing at",
        },
        LookAlike {
            effect: "flow-force",
            told_apart_by: "steps of several sizes, spool recorded: flow force moves the spool",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "steps of several sizes, supply pressure recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, ch. 11",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
