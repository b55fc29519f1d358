//! # Oil temperature
//!
//! ## What it adds
//! Warm oil loses viscosity, by half every 15–20 K: viscous friction becomes D·u and each laminar leakage G/u. Where the
//! oil's temperature ϑ is recorded, u = e^(−κ·(ϑ − ϑ0)), within 1/8 to 8. Where it is not, the oil may warm in the course
//! of the recording: u = 1 − s·(1 − e^(−t/T)).
//!
//! ## How it shows
//! Strokes become faster and the drift at rest becomes larger, slowly and together: the product of friction and leakage stays
//! constant. A recording in oil of another temperature looks like one of another drive, from start to end.
//!
//! ## What looks alike
//! A worn seal leaks more at the same friction. Drift of the valve's neutral favours one direction. Dry friction does
//! not depend on the speed.
//!
//! ## Parameters
//! Share s of the viscosity that is lost in the end, either sign (negative: the oil cools), up to 0.5 usually. T in s,
//! from less than a stroke to far longer than the recording, where the change is a ramp. κ, 0.02–0.06 1/K, is the mean
//! between the temperatures recorded: mineral oil loses more when cold. ϑ0, 40 °C ± 10 K, is the temperature that the
//! file's values hold for: ISO 3448 grades oil at 40 °C. A recording without the temperature counts as one at ϑ0; where no recording
//! has it, the form changes nothing.
//!
//! ## Source
//! ISO 3448 (viscosity grades); ASTM D341 (viscosity over temperature, after Walther); G. E. Totten (ed.), *Handbook of
//! Hydraulic Fluid Technology*, Marcel Dekker 2000; H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 2.

use machine_file::LoadSource;
use model_core::machine::Parameter;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "oil-temperature",
    subsystem: Subsystem::Mechanics,
    equation: "D·u and G/u, u = 1 − s·(1 − e^(−t/T)); measured: u = e^(−κ·(ϑ − ϑ0))",
    forms: &[
        &[
            EffectParameter { parameter: Parameter::ViscosityLoss, kind: Kind::Signed(|_| 0.5) },
            EffectParameter {
                parameter: Parameter::WarmingTime,
                kind: Kind::Shape(|scene| (0.5, (10.0 * scene.duration_s).clamp(1.0, 1e5)), 3),
            },
        ],
        &[
            EffectParameter { parameter: Parameter::ViscosityLossPerKelvin, kind: Kind::Amount(|_| (0.02, 0.06)) },
            EffectParameter { parameter: Parameter::ReferenceTemperature, kind: Kind::Place(|_| (30.0, 50.0), &[0.5]) },
        ],
    ],
    look_alikes: &[
        LookAlike {
            effect: "internal-leakage",
            told_apart_by: "long run for warming up: with wear the leakage rises and the friction stays",
        },
        LookAlike {
            effect: "null-drift",
            told_apart_by: "long run for warming up: warm oil speeds both directions up, drift one only",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "long run for warming up with the oil's temperature recorded, constant-speed strokes and closed-valve hold repeated",
    source: "Totten (ed.), Handbook of Hydraulic Fluid Technology, 2000; ASTM D341",
    // Where the load is taken from the pressures, the force balance is an input.
    shows_in: |scene| scene.load == LoadSource::Constant,
};
