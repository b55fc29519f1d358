//! # Entrained air
//!
//! ## What it adds
//! Bubbles of undissolved air make the oil soft at low pressure. With the share s of free air at atmospheric pressure
//! the compressibility 1/E0 gains `s·(p_atm/p)^(1/n)/(n·p)` with p absolute and n = 4/3: while the pressure swings the bubbles keep
//! most of their heat. Slow changes are isothermal, n = 1; the same softness at 50 bar then is twice the share.
//!
//! ## How it shows
//! The flow that the model lacks follows dp/dt, below 30–50 bar only: pressure builds late after a reversal, and the
//! rod lags at the start of each stroke.
//!
//! ## What looks alike
//! Hoses are equally soft at high pressure. A volume that changes with the position depends on where the rod is, not on the
//! pressure.
//!
//! ## Parameters
//! Share of the volume, not negative: 0.1–5 %; foam has more.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §2-5; J. Yu, Z. Chen, Y. Lu, *The variation of oil effective
//! bulk modulus with pressure in hydraulic systems*, J. Dynamic Systems, Measurement, and Control 116, 1994.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "entrained-air",
    subsystem: Subsystem::Chambers,
    equation: "1/E = 1/E0 + s·(p_atm/p)^(1/n)/(n·p), n = 4/3",
    forms: &[&[EffectParameter { parameter: Parameter::AirShare, kind: Kind::Amount(|_| (1e-3, 0.05)) }]],
    look_alikes: &[
        LookAlike {
            effect: "hose-compliance",
            told_apart_by: "strokes at two loads, both pressures recorded: hoses are soft above 50 bar, too",
        },
        LookAlike {
            effect: "position-dependent-volume",
            told_apart_by: "strokes over the whole stroke: air is as soft at both ends",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes at two loads, both pressures recorded, one below 50 bar and one above",
    source: "Yu, Chen, Lu, J. Dyn. Syst. Meas. Control 116, 1994; Merritt 1967, §2-5",
    shows_in: |scene| scene.input_point != InputPoint::Force,
};
