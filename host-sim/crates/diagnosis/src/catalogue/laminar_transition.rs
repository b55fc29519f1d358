//! # Laminar transition
//!
//! ## What it adds
//! Below a pressure difference `p_t` the flow through an edge is laminar and grows with Δp instead of its root:
//! `Q ∝ Δp/(Δp² + p_t²)^¼`. Narrow gaps and cold oil raise `p_t`; the effect is the increase over the valve's own.
//!
//! ## How it shows
//! Flow is missing at small pressure differences only: slow approach under a load that takes nearly the whole supply,
//! slow equalisation of the pressures.
//!
//! ## What looks alike
//! Valve leakage acts near the centre, at large pressure differences too. Internal leakage continues with the valve
//! closed.
//!
//! ## Parameters
//! Pressure in Pa, not negative: 0.1–20 bar, where the Reynolds number of the edge is 10–100.
//!
//! ## Source
//! W. Borutzky, B. Barnard, J. Thoma, *An orifice flow model for laminar and turbulent conditions*, Simulation
//! Modelling Practice and Theory 10, 2002; H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 3.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "laminar-transition",
    subsystem: Subsystem::Flow,
    equation: "Q = K_Q·o·Δp/(Δp² + p_t²)^¼",
    forms: &[&[EffectParameter { parameter: Parameter::LaminarPressure, kind: Kind::Amount(|_| (1e4, 2e6)) }]],
    look_alikes: &[
        LookAlike {
            effect: "valve-leakage",
            told_apart_by: "closed-valve hold under load: only leakage lets it creep",
        },
        LookAlike {
            effect: "internal-leakage",
            told_apart_by: "closed-valve hold under load: only leakage lets it creep",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes at two loads, one of which takes nearly the whole supply, both pressures recorded",
    source: "Borutzky, Barnard, Thoma, Simulation Modelling Practice and Theory 10, 2002",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
