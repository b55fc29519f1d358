//! # Tank back-pressure
//!
//! ## What it adds
//! Return line, filter and cooler resist the oil that leaves the cylinder: at the valve's tank port `p = p_T + R·Q²`, and
//! in narrow lines or cold oil also `r·Q`.
//!
//! ## How it shows
//! Only flow through the tank edge is missing: the outlet pressure of a fast stroke is higher than the model's, that
//! of a slow stroke is not.
//!
//! ## What looks alike
//! A drooping supply shows at the other edge. A smaller tank edge raises the outlet pressure in the same proportion at
//! slow speed.
//!
//! ## Parameters
//! R in Pa·s²/m⁶ and r in Pa·s/m³, not negative: 0.5–40 bar at full flow, usually 1–25.
//!
//! ## Source
//! W. Backé and H. Murrenhoff, *Grundlagen der Ölhydraulik*, RWTH Aachen (line and filter resistances); H. E. Merritt,
//! *Hydraulic Control Systems*, Wiley 1967, chapter 3 (turbulent losses).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const TURBULENT: EffectParameter = EffectParameter {
    parameter: Parameter::ReturnResistance,
    kind: Kind::Amount(|scene| {
        let square = scene.full_flow_m3_per_s().powi(2);
        (5e4 / square, 4e6 / square)
    }),
};
const LAMINAR: EffectParameter = EffectParameter {
    parameter: Parameter::ReturnLaminar,
    kind: Kind::Amount(|scene| {
        let flow = scene.full_flow_m3_per_s();
        (5e4 / flow, 4e6 / flow)
    }),
};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "tank-back-pressure",
    subsystem: Subsystem::Flow,
    equation: "p at the tank edge = p_T + R·Q² + r·Q",
    forms: &[&[TURBULENT], &[LAMINAR], &[TURBULENT, LAMINAR]],
    look_alikes: &[
        LookAlike {
            effect: "supply-droop",
            told_apart_by: "steps of several sizes, both pressures recorded: which edge the flow is missing at",
        },
        LookAlike {
            effect: "metering-asymmetry",
            told_apart_by: "steps of several sizes, both pressures recorded: unequal edges show at slow speed, too",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "steps of several sizes, both pressures and the tank pressure recorded",
    source: "Backé & Murrenhoff, Grundlagen der Ölhydraulik, RWTH Aachen",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
