//! The scales of all per-unit quantities: what 1 means.

#![expect(clippy::float_arithmetic, reason = "scales are computed once, before a run, in real arithmetic")]

use crate::machine::{Bases, Machine, Parameter as P, Source, Tick};
use crate::mechanics::GAMMA;
use crate::number::{Field, Real};
use crate::oil::THINNEST;

/// Command at 1, V.
pub(crate) const COMMAND_V: f64 = 10.0;
/// Temperature at 1, °C: signals reach ±200 °C.
pub(crate) const TEMPERATURE_C: f64 = 25.0;
/// Pump speed at 1, revolutions per second.
pub(crate) const PUMP_SPEED_REV_PER_S: f64 = 50.0;

/// Largest gain that a choice of scales aims at.
pub(crate) const GAIN_AIM: f64 = 3.9;
/// Largest factor by which the mass on the oil spring may be smaller: see `sprung_mass`.
pub(crate) const SPRUNG: f64 = 1.05;

/// Scales in which all coefficients of a sensible drive fit.
///
/// Pressures are scaled by the supply, so the velocity's scale decides: a larger one makes the pressure rise per tick
/// larger, a smaller one the flow at full opening and the velocity gained per tick. The preferred scale holds the largest
/// flow and a velocity gain of 2; it is changed as far as the others need. No scale fits an oil spring so stiff
/// that (ω·tick)² exceeds about 15.
pub(crate) fn bases(machine: &Machine<f64>, tick: Tick) -> Bases {
    let (tick_s, area_a, area_b) = (tick.seconds(), machine.get(P::AreaA), machine.get(P::AreaB));
    let pressure_pa = machine.get(P::SupplyPressure);
    let opened = machine.get(P::FlowCoefficient) * Field::sqrt(pressure_pa);
    let (largest_flow, gained_flow) = match machine.source {
        Source::Valve => (machine.get(P::FlowLimit).min(opened), opened),
        Source::Pump => {
            let full_speed = machine.get(P::PumpDisplacement) * PUMP_SPEED_REV_PER_S;
            (full_speed, full_speed)
        }
    };
    let inertia = inertia(machine, tick_s);
    let smaller_capacity = smaller_capacity(machine);
    let from_flow = largest_flow / area_a.min(area_b);
    let from_force = tick_s * area_a * pressure_pa / inertia;
    let least = (0.5 * from_flow).max(SPRUNG * from_force / GAIN_AIM).max(gained_flow / (GAIN_AIM * area_a));
    let most = GAIN_AIM * pressure_pa * smaller_capacity / (tick_s * area_a);
    let velocity_m_per_s = from_flow.max(0.5 * from_force).min(most).max(least);
    Bases {
        pressure_pa,
        velocity_m_per_s,
        flow_m3_per_s: area_a * velocity_m_per_s,
        force_n: area_a * pressure_pa,
        stroke_m: machine.get(P::Stroke),
        command_v: COMMAND_V,
        pump_speed_rev_per_s: PUMP_SPEED_REV_PER_S,
        temperature_c: TEMPERATURE_C,
        tick_s,
    }
}

/// m + γ·h·D: what a force has to move within a tick.
pub(crate) fn inertia(machine: &Machine<f64>, tick_s: f64) -> f64 {
    machine.get(P::MovingMass) + GAMMA * tick_s * machine.get(P::ViscousFriction) * least_drag(machine)
}

/// Least viscous friction that the rod meets anywhere and at any time, as a share of the one that the machine's values are for.
pub(crate) fn least_drag<R: Real>(machine: &Machine<R>) -> R {
    let (slope, bow) = (machine.get(P::PositionDragSlope), machine.get(P::PositionDragBow));
    let smaller = |one: R, other: R| if other.value() < one.value() { other } else { one };
    let ends = smaller(R::ONE + bow + slope, R::ONE + bow - slope);
    let inside = bow.value() > 0.5 * slope.value().abs();
    let least = if inside { R::ONE - slope * slope / (R::constant(4.0) * bow) } else { ends };
    thinnest(machine) * if least.value() > SLIPPERIEST { least } else { R::constant(SLIPPERIEST) }
}

/// Least share of its viscous friction that the rod has anywhere along its stroke.
pub(crate) const SLIPPERIEST: f64 = 0.05;

/// Least possible viscosity, as a share of the one that the machine's values are for.
pub(crate) fn thinnest<R: Real>(machine: &Machine<R>) -> R {
    let loss = machine.get(P::ViscosityLoss);
    let warmed = if loss.value() > 0.0 { R::ONE - loss } else { R::ONE };
    let thins = machine.get(P::ViscosityLossPerKelvin).value() > 0.0;
    if thins { warmed * R::constant(THINNEST) } else { warmed }
}

/// Capacity of the stiffer chamber. (7)
pub(crate) fn smaller_capacity(machine: &Machine<f64>) -> f64 {
    let capacity = |volume: P| machine.get(volume) / machine.get(P::BulkModulus) + machine.get(P::HoseCompliance);
    capacity(P::VolumeA).min(capacity(P::VolumeB))
}
