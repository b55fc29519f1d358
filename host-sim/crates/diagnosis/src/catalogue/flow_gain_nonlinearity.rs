//! # Flow-gain nonlinearity
//!
//! ## What it adds
//! Notches and round holes make the area of an edge a curve over the opening o beyond the overlap: the gain changes with the
//! opening, and where a notch ends the full edge follows with another gain.
//!
//! ## How it shows
//! The flow that the model lacks is a function of the spool alone, on all four edges alike: small steps fit and large
//! ones do not, or the other way round, at every load.
//!
//! ## What looks alike
//! A drooping supply depends on the total flow, and on time. A saturated magnet leaves the spool
//! short of its travel. A flow limit is sharp.
//!
//! ## Parameters
//! c (bend per opening) and b (gain beyond the notch), either sign: ±10–80 %; the opening n at which the notch ends.
//!
//! ## Source
//! W. Backé, *Systematik der hydraulischen Widerstandsschaltungen in Ventilen und Regelkreisen*, Krausskopf 1974; N. D.
//! Manring, *Hydraulic Control Systems*, Wiley 2005 (port shapes).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const LINEAR: EffectParameter = EffectParameter { parameter: Parameter::FlowGainLinear, kind: Kind::Signed(|_| 0.8) };
const BEYOND: EffectParameter = EffectParameter { parameter: Parameter::FlowGainBeyond, kind: Kind::Signed(|_| 0.8) };
const NOTCH: EffectParameter =
    EffectParameter { parameter: Parameter::FlowGainNotch, kind: Kind::Shape(|_| (0.05, 0.6), 4) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "flow-gain-nonlinearity",
    subsystem: Subsystem::Flow,
    equation: "Q = K_Q·(o·(1 + c·o) + b·max(0, o − n))·√Δp",
    forms: &[&[LINEAR], &[BEYOND, NOTCH], &[LINEAR, BEYOND, NOTCH]],
    look_alikes: &[
        LookAlike {
            effect: "supply-droop",
            told_apart_by: "steps of several sizes, both pressures recorded: droop takes flow at the supply edge only",
        },
        LookAlike {
            effect: "solenoid-saturation",
            told_apart_by: "steps of several sizes, spool recorded: on a saturated magnet it does not arrive",
        },
        LookAlike {
            effect: "metering-asymmetry",
            told_apart_by: "steps of several sizes, both pressures recorded: a curved gain changes with the opening",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "steps of several sizes at two loads",
    source: "Backé, Systematik der hydraulischen Widerstandsschaltungen, 1974",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
