//! A drive at random: its true values, and those in its machine file.

use std::collections::BTreeMap;

use machine_file::MachineFile;
use model_core::machine::{Machine, Parameter as P, Source};
use recording::seeded_noise::Noise;

/// A drive of realistic size: pressures of 50 to 160 bar, pistons of 40 to 80 mm, loads of 15 to 200 kg.
pub(crate) fn draw(dice: &mut Noise) -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    let supply_pa = dice.decades(5.0e6, 1.6e7);
    let area_a = dice.decades(1.3e-3, 5.0e-3);
    let area_b = area_a * dice.uniform(0.5, 0.92);
    let stroke_m = dice.uniform(0.2, 0.45);
    let gain = dice.uniform(0.05, 0.09);
    let dead_zone = dice.uniform(0.02, 0.11);
    // Speed at an opening of 0.4, and the viscous share of the force that the drive has at that speed.
    let speed = dice.decades(0.08, 0.3);
    let coefficient = speed * 0.5 * (area_a + area_b) / (0.4 * (0.5 * supply_pa).sqrt());
    let viscous = dice.decades(0.06, 0.5) * supply_pa * area_b / speed;
    let full_flow = 0.55 * coefficient * (0.5 * supply_pa).sqrt();
    for (parameter, value) in [
        (P::SupplyPressure, supply_pa),
        (P::FlowLimit, full_flow * dice.uniform(0.9, 1.6)),
        (P::ValveGain, gain),
        (P::ValveOffset, dead_zone * dice.uniform(-0.5, 0.5)),
        (P::DeadZone, dead_zone),
        (P::RateLimit, dice.uniform(9.0, 22.0)),
        (P::TimeConstant1, dice.decades(0.008, 0.024)),
        (P::TimeConstant2, dice.decades(0.014, 0.036)),
        (P::TransportDelay, dice.uniform(0.002, 0.011)),
        (P::FlowCoefficient, coefficient),
        (P::AreaA, area_a),
        (P::AreaB, area_b),
        (P::Stroke, stroke_m),
        (P::VolumeA, 0.5 * stroke_m * area_a * dice.uniform(0.85, 1.35)),
        (P::VolumeB, 0.5 * stroke_m * area_b * dice.uniform(0.85, 1.4)),
        (P::BulkModulus, dice.uniform(1.0e9, 1.5e9)),
        (P::MovingMass, dice.decades(15.0, 200.0)),
        (P::ViscousFriction, viscous),
        (P::LoadForce, supply_pa * area_b * dice.uniform(-0.15, 0.1)),
    ] {
        machine.set(parameter, rounded(value, 6));
    }
    machine
}

/// The same drive with a load so heavy that the valve closes before the load has stopped, so that the load pulls the rod on.
pub(crate) fn heavy(machine: &Machine<f64>, dice: &mut Noise) -> Machine<f64> {
    let get = |parameter| machine.get(parameter);
    let (area_b, supply_pa) = (get(P::AreaB), get(P::SupplyPressure));
    let speed = 0.4 * get(P::FlowCoefficient) * (0.5 * supply_pa).sqrt() / (0.5 * (get(P::AreaA) + area_b));
    let closes_s = get(P::TimeConstant1) + get(P::TimeConstant2);
    // The mass that the drive's force, times a random factor, stops within this time.
    let mass_kg = dice.decades(0.5, 1.5) * supply_pa * area_b * closes_s / speed;
    machine.with(&[(P::MovingMass, rounded(mass_kg, 6))])
}

/// A small drive with its own pump: the valve only sets the direction.
pub(crate) fn draw_pump(dice: &mut Noise) -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Pump);
    let area_a = dice.decades(1.2e-3, 3.5e-3);
    let area_b = area_a * dice.uniform(0.6, 0.92);
    let stroke_m = dice.uniform(0.15, 0.35);
    for (parameter, value) in [
        (P::AreaA, area_a),
        (P::AreaB, area_b),
        (P::Stroke, stroke_m),
        (P::VolumeA, 0.5 * stroke_m * area_a * dice.uniform(0.9, 1.4)),
        (P::VolumeB, 0.5 * stroke_m * area_b * dice.uniform(0.9, 1.4)),
        (P::BulkModulus, dice.uniform(1.0e9, 1.5e9)),
        (P::MovingMass, dice.decades(10.0, 80.0)),
        (P::ViscousFriction, dice.decades(3.0e3, 3.0e4)),
        (P::LoadForce, -area_a * dice.uniform(8.0e5, 4.0e6)),
        (P::PumpDisplacement, dice.decades(1.2e-6, 3.0e-6)),
        (P::ReturnCoefficient, dice.decades(2.0e-7, 1.0e-6)),
    ] {
        machine.set(parameter, rounded(value, 6));
    }
    machine
}

const PUMP: [(P, f64); 4] =
    [(P::PumpDisplacement, 0.02), (P::BulkModulus, 0.06), (P::ViscousFriction, 0.1), (P::ReturnCoefficient, 0.05)];
/// Which nominal values may be off, and by how much: relative to the value.
const MODERATE: [(P, f64); 9] = [
    (P::ValveGain, 0.05),
    (P::TimeConstant1, 0.05),
    (P::TimeConstant2, 0.05),
    (P::FlowCoefficient, 0.05),
    (P::ViscousFriction, 0.05),
    (P::RateLimit, 0.05),
    (P::BulkModulus, 0.05),
    (P::DeadZone, 0.08),
    (P::TransportDelay, 0.08),
];
const HARD: [(P, f64); 13] = [
    (P::ValveGain, 0.08),
    (P::TimeConstant1, 0.1),
    (P::TimeConstant2, 0.1),
    (P::FlowCoefficient, 0.08),
    (P::ViscousFriction, 0.15),
    (P::RateLimit, 0.08),
    (P::BulkModulus, 0.12),
    (P::DeadZone, 0.1),
    (P::TransportDelay, 0.1),
    (P::VolumeA, 0.12),
    (P::VolumeB, 0.12),
    (P::SupplyPressure, 0.01),
    (P::MovingMass, 0.1),
];
/// Standard deviation of the offset in hard cases, and that of the load relative to the full force.
const HARD_OFFSET: f64 = 0.006;
const HARD_LOAD_SHARE: f64 = 0.025;

/// The machine file: the true values with Gaussian errors, and the standard deviations of these errors.
pub(crate) fn file(name: &str, truth: &Machine<f64>, hard: bool, dice: &mut Noise) -> MachineFile {
    let valve = truth.source == Source::Valve;
    let list: &[(P, f64)] = match (valve, hard) {
        (false, _) => &PUMP,
        (true, true) => &HARD,
        (true, false) => &MODERATE,
    };
    let mut sigma: BTreeMap<P, f64> =
        list.iter().map(|&(parameter, share)| (parameter, rounded(share * truth.get(parameter), 3))).collect();
    if hard && valve {
        let full_n = truth.get(P::SupplyPressure) * truth.get(P::AreaA);
        sigma.extend([(P::ValveOffset, HARD_OFFSET), (P::LoadForce, rounded(HARD_LOAD_SHARE * full_n, 2))]);
    }
    let mut nominal = *truth;
    for (&parameter, &deviation) in &sigma {
        let description = parameter.description();
        let off = dice.gaussian(1.0).clamp(-2.5, 2.5) * deviation;
        let value = rounded(truth.get(parameter) + off, 6).clamp(description.min, description.max);
        nominal.set(parameter, value);
    }
    let mut file = MachineFile::from_machine(name, nominal);
    file.sigma = sigma;
    file.has_sigma_table = true;
    file
}

/// A value rounded to so many significant digits, as in a data sheet.
pub(crate) fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_are_valid_and_their_files_are_off_by_about_what_they_say() {
        let (mut squares, mut count) = (0.0, 0.0);
        for seed in 0..60 {
            let mut dice = Noise::new(seed, 0);
            let truth = draw(&mut dice);
            for &parameter in P::ALL {
                let description = parameter.description();
                assert!((description.min..=description.max).contains(&truth.get(parameter)), "{}", description.key);
            }
            let file = file("drive", &truth, seed % 2 == 0, &mut dice);
            for (&parameter, deviation) in &file.sigma {
                squares += ((file.machine.get(parameter) - truth.get(parameter)) / deviation).powi(2);
                count += 1.0;
            }
            assert!(truth.get(P::ValveOffset).abs() < truth.get(P::DeadZone), "it rests at zero volts");
        }
        let ratio = (squares / count).sqrt();
        assert!((0.85..1.1).contains(&ratio), "{ratio}");
    }
}
