//! # Counterbalance
//!
//! ## What it adds
//! A load-holding valve between the valve and a chamber: oil flows in freely, and out only past a poppet that the chamber's own pressure, and by the
//! pilot ratio the other side's, push open: its opening grows with `p + R·p_other − p_set`. Two such orifices in series pass `o·c/√(o² + c²)`.
//!
//! ## How it shows
//! Where the drive pushes the load down, the chamber that holds it stays at a high pressure, and so does the other one, which has to open the valve: both
//! are far above what the metering edges alone would need, and they rise together. Where the load is lifted nothing is different.
//!
//! ## What looks alike
//! A return line's pressure grows with the flow alone, and the other chamber does not follow. A small tank edge keeps the ratio of both pressures.
//!
//! ## Parameters
//! Setting of each chamber's valve, by its makers' advice 1.3 times the largest pressure of the load; pilot ratio 1.5 to 10; pressure beyond the setting at which it is as
//! wide as a metering edge at full travel; its time constant. It is tried only where both pressures are recorded.
//!
//! ## Source
//! Sun Hydraulics, data sheet of the counterbalance valve CBEA (free flow to the load; a relief valve the other way, whose setting pressure at the pilot
//! port lowers by the pilot ratio). That its opening grows in proportion is chosen. H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 3 (two
//! orifices in series).

use model_core::machine::Parameter;
use recording::Signal;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Scene, Subsystem};

/// From a third of the supply to three times as much.
fn settings(scene: &Scene<'_>) -> (f64, f64) {
    let supply_pa = scene.machine.get(Parameter::SupplyPressure);
    (0.3 * supply_pa, 3.0 * supply_pa)
}

const OF_A: EffectParameter =
    EffectParameter { parameter: Parameter::HoldingSetA, kind: Kind::Setting(settings, &[0.1, 0.3, 0.6]) };
const OF_B: EffectParameter =
    EffectParameter { parameter: Parameter::HoldingSetB, kind: Kind::Setting(settings, &[0.1, 0.3, 0.6]) };
const PILOT: EffectParameter =
    EffectParameter { parameter: Parameter::PilotRatio, kind: Kind::Shape(|_| (1.5, 10.0), 2) };
const SPAN: EffectParameter =
    EffectParameter { parameter: Parameter::HoldingSpan, kind: Kind::Shape(|_| (1e6, 3e7), 1) };
const TIME: EffectParameter =
    EffectParameter { parameter: Parameter::HoldingTime, kind: Kind::Shape(|_| (3e-3, 0.1), 1) };
const SIZE: EffectParameter =
    EffectParameter { parameter: Parameter::HoldingSize, kind: Kind::Shape(|_| (0.05, 2.0), 1) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "counterbalance",
    subsystem: Subsystem::Flow,
    equation: "out of the chamber o·c/√(o² + c²), c = (p + R·p_other − p_set)/span, 0 to its stop",
    forms: &[&[OF_A, PILOT, SPAN], &[OF_B, PILOT, SPAN]],
    look_alikes: &[
        LookAlike {
            effect: "tank-back-pressure",
            told_apart_by: "lowering at several speeds, both pressures recorded: the other chamber's pressure rises with a load-holding valve alone",
        },
        LookAlike {
            effect: "metering-asymmetry",
            told_apart_by: "lowering with two loads, both pressures recorded: unequal edges keep the ratio of the pressures",
        },
    ],
    refined: &[
        &[OF_A, PILOT, SPAN, TIME, SIZE],
        &[OF_B, PILOT, SPAN, TIME, SIZE],
        &[OF_A, OF_B, PILOT, SPAN],
        &[OF_A, OF_B, PILOT, SPAN, TIME, SIZE],
    ],
    extends: None,
    separated_by: "lowering at several speeds and with two loads, both pressures recorded",
    source: "Sun Hydraulics, data sheet of the counterbalance valve CBEA",
    shows_in: |scene| {
        matches!(scene.input_point, InputPoint::Command | InputPoint::Spool)
            && [Signal::PressureA, Signal::PressureB].iter().all(|&pressure| scene.judges(pressure))
    },
};
