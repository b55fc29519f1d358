//! The scales of all per-unit quantities: what 1 means.

#![expect(clippy::float_arithmetic, reason = "scales are computed once, before a run, in real arithmetic")]

use crate::machine::{Bases, Machine, Parameter as P, Source, Tick};
use crate::mechanics::GAMMA;
use crate::number::{Field, Real};
use crate::oil::THINNEST;

/// Command at 1, V, of a valve that is opened by that order of size.
pub(crate) const COMMAND_V: f64 = 10.0;
/// The format ends at this many bases.
const FORMAT_END: f64 = 8.0;
/// The base is doubled up to this: no signal of a valve is larger than 80 A, counted in mA.
const MOST_DOUBLED: f64 = 1024.0;
/// Temperature at 1, °C: signals reach ±200 °C.
pub(crate) const TEMPERATURE_C: f64 = 25.0;
/// Pump speed at 1, revolutions per second.
pub(crate) const PUMP_SPEED_REV_PER_S: f64 = 50.0;

/// Largest gain that a choice of scales aims at.
pub(crate) const GAIN_AIM: f64 = 3.9;
/// Largest factor by which the mass on the oil spring may be smaller: see `sprung_mass`.
pub(crate) const SPRUNG: f64 = 1.05;

/// Velocity at 1 where a force moves the mass, strokes/s: the format ends at a stroke in 31 ms.
const STROKES_PER_S: f64 = 4.0;
/// Acceleration by the full force where a force moves the mass, strokes/s²: it reaches that velocity within 31 ms, and the format ends at eight times as much.
const STROKES_PER_S2: f64 = 128.0;
/// Acceleration of a falling mass, m/s².
const GRAVITY: f64 = 9.81;
/// Largest stiffness of a stop over the full force and the stroke that a choice of scales aims at; the format ends at 65536.
const STEEP_AIM: f64 = 6e4;

impl Machine<f64> {
    /// The force that others on the rod are measured by, N: that of the supply pressure on side A. Where a force moves the mass, the one that brings
    /// it to four strokes a second within 31 ms, against its weight and its viscous friction, or the default supply pressure on side A where that is
    /// more.
    #[must_use]
    pub fn full_force_n(&self) -> f64 {
        let of_oil = self.get(P::AreaA) * self.get(P::SupplyPressure);
        if self.source != Source::Force {
            return of_oil;
        }
        let stroke = self.get(P::Stroke);
        let accelerated = self.get(P::MovingMass) * (STROKES_PER_S2 * stroke + GRAVITY);
        of_oil.max(accelerated + self.get(P::ViscousFriction) * STROKES_PER_S * stroke)
    }
}

/// Scales where a force moves the mass. No oil is there to give a flow, so the stroke gives the velocity. The force's scale is the full force, or all
/// that may hold the rod where that is more; then the velocity's scale is raised until the velocity gained per tick fits. Viscous friction always does,
/// for its force at velocity 1 is part of the full force.
fn bases_under_force(machine: &Machine<f64>, tick_s: f64) -> Bases {
    let get = |parameter: P| machine.get(parameter).abs();
    let (pressure_pa, stroke_m) = (machine.get(P::SupplyPressure), machine.get(P::Stroke));
    let table_n = P::TABLE_VALUES.iter().fold(0.0, |most: f64, &value| most.max(get(value)));
    let table_n = if machine.get(P::TableQuantity) > 0.0 { table_n } else { 0.0 };
    let load_n = get(P::LoadForce)
        + get(P::LoadSpringForce)
        + stroke_m * (get(P::LoadSpring) + stroke_m * get(P::LoadSpringBow));
    let held_n = load_n + table_n + machine.dry_friction_n();
    let wanted_n = machine.full_force_n().max(held_n).max(get(P::StopStiffness) * stroke_m / STEEP_AIM);
    // Velocity 1 per force 1, at the largest gain, and the force that brings the mass to GAIN_AIM strokes a tick with it: no scale holds more.
    let per_force = SPRUNG * tick_s / (GAIN_AIM * inertia(machine, tick_s));
    let force_n = wanted_n.min(GAIN_AIM * stroke_m / (tick_s * per_force));
    let velocity_m_per_s = (STROKES_PER_S * stroke_m).max(per_force * force_n);
    Bases {
        pressure_pa,
        velocity_m_per_s,
        flow_m3_per_s: force_n / pressure_pa * velocity_m_per_s,
        force_n,
        stroke_m,
        command_v: command_v(machine),
        pump_speed_rev_per_s: PUMP_SPEED_REV_PER_S,
        temperature_c: TEMPERATURE_C,
        tick_s,
    }
}

/// Command at 1: [`COMMAND_V`]; its first double with which the format holds the command that opens the valve, as where it counts in mA; or its first
/// half with which the spool travel per command of 1 fits, as where 1 V opens the valve.
fn command_v(machine: &Machine<f64>) -> f64 {
    let gain = machine.get(P::ValveGain).abs();
    let mut command_v = COMMAND_V;
    while gain * command_v > GAIN_AIM {
        command_v *= 0.5;
    }
    let most_v = COMMAND_V * MOST_DOUBLED;
    while gain * command_v * FORMAT_END < 1.0 && command_v < most_v {
        command_v *= 2.0;
    }
    command_v
}

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
        Source::Force => return bases_under_force(machine, tick_s),
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
        command_v: command_v(machine),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_format_holds_the_command_that_opens_the_valve_and_the_travel_per_command_fits() {
        let mut machine = Machine::<f64>::with_defaults(Source::Valve);
        let mut of = |gain: f64| {
            machine.set(P::ValveGain, gain);
            command_v(&machine)
        };
        for volts in [0.1, 1.0, 2.4, 20.0, 81.0, 800.0, 3000.0] {
            for gain in [1.0 / volts, -1.0 / volts] {
                let base = of(gain);
                let (per_base, times) = (gain.abs() * base, base / COMMAND_V);
                assert!(per_base <= GAIN_AIM && per_base * FORMAT_END >= 1.0, "{volts} V: {base} V");
                assert!(times.log2().fract() == 0.0, "{volts} V: {base} V is no power of two times the usual");
            }
        }
        for volts in [3.0, 5.0, 10.0, 24.0, 80.0] {
            assert!(of(1.0 / volts) == COMMAND_V, "{volts} V");
        }
        assert!(of(0.0).is_finite());
    }
}
