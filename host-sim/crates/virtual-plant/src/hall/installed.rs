//! What every installed drive has within its drawing, and no data sheet says; and its sensors.

use crate::sensor::sensors::{PositionSensor, PressureSensor, SpoolSensor};
use crate::{DryFriction, FlowEffect, FrictionLevel, MeasuredSignal, PlantEffect, SensingEffect, Sensors, ValveEffect};
use model_core::machine::{Machine, Parameter as P};
use recording::seeded_noise::Noise;

/// Effects, each within the tolerance that the data sheet's file has for it.
pub(super) fn installed(truth: &Machine<f64>, servo: bool, hose_m3: f64, dice: &mut Noise) -> Vec<PlantEffect> {
    let get = |parameter| truth.get(parameter);
    let (supply_pa, full_n) = (get(P::SupplyPressure), get(P::SupplyPressure) * get(P::AreaA));
    let (area_a, area_b) = (get(P::AreaA), get(P::AreaB));
    let open = get(P::FlowCoefficient) * (1.0 - get(P::DeadZone));
    let full_m3_per_s = open * area_a * (supply_pa * area_a / (area_a.powi(3) + area_b.powi(3))).sqrt();

    let sliding_n = full_n * dice.uniform(0.01, 0.025);
    let level = FrictionLevel::Stribeck {
        sliding_n,
        break_away_n: sliding_n * dice.uniform(1.1, 1.7),
        velocity_m_per_s: dice.uniform(5e-3, 0.015),
    };
    let give_m = dice.decades(1e-5, 5e-5);
    let bristles_n_s_per_m = dice.decades(0.05, 0.3) * (sliding_n / give_m * get(P::MovingMass)).sqrt();
    let droop = dice.uniform(0.005, 0.015) * supply_pa / full_m3_per_s;
    let mut unequal = |within: f64| dice.uniform(-within, within);
    let sizes = [unequal(0.025), unequal(0.025), unequal(0.025), unequal(0.025)].map(|off| 1.0 + off);
    let overlaps = [unequal(0.025), unequal(0.025)].map(|off| off * get(P::DeadZone));
    let mut all = vec![
        PlantEffect::Friction(DryFriction::giving(level, give_m, bristles_n_s_per_m)),
        PlantEffect::entrained_air(dice.uniform(1e-3, 5e-3)),
        PlantEffect::Flow(FlowEffect::Metering { sizes }),
        PlantEffect::Flow(FlowEffect::DeadZone { extending: overlaps[0], retracting: overlaps[1] }),
        PlantEffect::Flow(FlowEffect::SupplyDroop {
            resistance_pa_s_per_m3: droop,
            gas_volume_m3: dice.decades(5e-5, 3e-4),
            line_pa_s2_per_m6: 0.1 * droop / full_m3_per_s,
        }),
        PlantEffect::Flow(FlowEffect::BackPressure {
            linear_pa_s_per_m3: dice.uniform(0.0, 3e4) / full_m3_per_s,
            quadratic_pa_s2_per_m6: dice.uniform(3e4, 1.5e5) / full_m3_per_s.powi(2),
        }),
        PlantEffect::Valve(ValveEffect::WeightedPlays { width: dice.uniform(1e-3, 6e-3) }),
        PlantEffect::Sensing(SensingEffect::PositionFilter {
            // Late by 1 to 3 ms.
            frequency_hz: 1.0 / (std::f64::consts::PI * dice.uniform(1e-3, 3e-3)),
            damping: 1.0,
        }),
    ];
    if dice.happens(0.5) {
        let compliance_m3_per_pa = hose_m3 / dice.uniform(0.3e9, 0.8e9);
        all.push(PlantEffect::HoseCompliance { compliance_m3_per_pa, stiffening_pressure_pa: 1e8 });
    }
    let play = if servo { dice.uniform(3e-3, 8e-3) } else { dice.uniform(1e-3, 4e-3) };
    all.push(PlantEffect::Flow(FlowEffect::RoundedEdges { play, laminar_pa: 3e5 }));
    all
}

/// 12 to 14 bits each; the converter of a pressure has half of its range below zero.
pub(super) fn sensors(truth: &Machine<f64>, dice: &mut Noise) -> Sensors {
    let mut bits = || 12 + u8::try_from(dice.below(3)).unwrap_or(0);
    let [of_spool, of_position, of_pressure] = [bits(), bits(), bits()];
    let step_m = truth.get(P::Stroke) / 2.0_f64.powi(of_position.into());
    let range_pa = truth.get(P::SupplyPressure) * dice.uniform(1.25, 2.5);
    Sensors {
        spool: SpoolSensor {
            counts_per_unit: 2.0_f64.powi(i32::from(of_spool) - 1),
            noise_std: dice.decades(2e-4, 8e-4),
        },
        position: PositionSensor::Linear { resolution_m: step_m },
        position_noise_m: step_m * dice.uniform(0.3, 0.6),
        pressure: PressureSensor { noise_std_pa: range_pa * dice.decades(2e-4, 8e-4), range_pa, bits: of_pressure + 1 },
        sees_supply: false,
    }
}

/// Less than 0.3 % of full scale.
pub(super) fn offsets(sensors: &Sensors, stroke_m: f64, dice: &mut Noise) -> Vec<PlantEffect> {
    let range_pa = sensors.pressure.range_pa;
    let scales = [
        (MeasuredSignal::Spool, 1.0),
        (MeasuredSignal::Position, stroke_m),
        (MeasuredSignal::PressureA, range_pa),
        (MeasuredSignal::PressureB, range_pa),
    ];
    let off = |(channel, scale)| {
        PlantEffect::Sensing(SensingEffect::Offset { channel, offset: scale * dice.uniform(-0.003, 0.003) })
    };
    scales.map(off).to_vec()
}
