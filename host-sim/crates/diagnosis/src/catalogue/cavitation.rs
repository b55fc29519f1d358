//! # Cavitation
//!
//! ## What it adds
//! Oil cannot pull. If more oil is drawn from a chamber than flows in, the pressure stays at a floor, that of the oil's vapour or of the air
//! that the oil gives off, while a void grows. The pressure rises again only once the void is filled.
//!
//! ## How it shows
//! A pressure stays flat near zero while the rod is drawn on: by an overrunning load, or by the moving mass when the valve closes at once. Then
//! it rises late and steeply. The model without this effect simulates pressures far below vacuum there, and a rod that stops too early.
//!
//! ## What looks alike
//! Entrained air bends the pressure at low values, but never holds it flat. A sensor at the end of its range is flat as well, while the
//! rod follows the model.
//!
//! ## Parameters
//! The floor, measured from the same zero as the tank's pressure and not above it: −1 to −0.3 bar. Recordings hardly determine it, since half
//! a bar is little beside the supply. It is tried only where the pressure of the model without it falls below the floor and no sensor contradicts.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, §5-5: the cavity of a valve under an overrunning load.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "cavitation",
    subsystem: Subsystem::Chambers,
    equation: "p ≥ floor, void ≥ 0, void·(p − floor) = 0",
    forms: &[&[EffectParameter {
        parameter: Parameter::CavitationFloor,
        kind: Kind::Floor(|_| (-1e5, -3e4), &[0.2, 0.8]),
    }]],
    look_alikes: &[LookAlike {
        effect: "entrained-air",
        told_apart_by: "a hard stop of the valve in full motion, both pressures recorded: air bends the pressure, and never holds it flat",
    }],
    refined: &[],
    extends: None,
    separated_by: "a hard stop of the valve in full motion, or an overrunning load, both pressures recorded",
    source: "Merritt 1967, §5-5",
    shows_in: |scene| scene.input_point != InputPoint::Force,
};
