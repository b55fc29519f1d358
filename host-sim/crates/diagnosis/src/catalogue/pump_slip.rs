//! # Pump slip
//!
//! ## What it adds
//! Inside a turning pump oil returns from the pressure side: `Q = displacement·speed − S·(p − p_tank)`. A check valve keeps the
//! pump from turning back, so slip never empties a chamber.
//!
//! ## How it shows
//! The gain from speed to velocity falls with load pressure; nothing shows at rest.
//!
//! ## What looks alike
//! Internal leakage continues with the pump at rest. A smaller displacement does not depend on pressure.
//!
//! ## Parameters
//! S in m³/s/Pa, not negative; 3–20 % of the flow at rated pressure.
//!
//! ## Source
//! W. E. Wilson, *Rotary-pump theory*, Trans. ASME 68, 1946 (laminar slip of positive-displacement pumps).

use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "pump-slip",
    subsystem: Subsystem::Flow,
    equation: "Q = V_g·n − S·(p − p_tank)",
    forms: &[&[EffectParameter {
        parameter: Parameter::PumpSlip,
        kind: Kind::Amount(|scene| {
            // 0.5 to 20 % of the flow at 20 rev/s and 50 bar.
            let full = scene.machine.get(Parameter::PumpDisplacement) * 20.0 / 5e6;
            (0.005 * full, 0.2 * full)
        }),
    }]],
    look_alikes: &[LookAlike {
        effect: "internal-leakage",
        told_apart_by: "closed-valve hold under load: leakage goes on with the pump at rest",
    }],
    refined: &[],
    extends: None,
    separated_by: "constant speeds at two loads, and a hold under load with the pump at rest",
    source: "Wilson, Rotary-pump theory, Trans. ASME 68, 1946",
    shows_in: |scene| scene.input_point == simulation::InputPoint::Pump,
};
