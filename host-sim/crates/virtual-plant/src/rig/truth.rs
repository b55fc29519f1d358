//! A drive as it is, near to what its machine file says of it.

use std::collections::BTreeMap;

use model_core::machine::{Machine, Parameter};
use recording::seeded_noise::Noise;

/// A drive drawn about its nominal values: each parameter in `sigma` is off by its standard deviation times a Gaussian
/// number times `spread`, but by no more than two deviations and never out of its range. The others are exact.
#[must_use]
pub fn truth_near(nominal: &Machine<f64>, sigma: &BTreeMap<Parameter, f64>, spread: f64, seed: u64) -> Machine<f64> {
    let mut truth = *nominal;
    for (&parameter, &deviation) in sigma {
        let mut noise = Noise::new(seed, stream(parameter));
        let off = noise.gaussian(1.0).clamp(-2.0, 2.0) * deviation * spread;
        let description = parameter.description();
        truth.set(parameter, (nominal.get(parameter) + off).clamp(description.min, description.max));
    }
    truth
}

/// Parameters that came into the table later, between others.
const LATER: [Parameter; 9] = [
    Parameter::LevelAtRest,
    Parameter::ViscosityLossPerKelvin,
    Parameter::ReferenceTemperature,
    Parameter::PositionDragSlope,
    Parameter::PositionDragBow,
    Parameter::SolenoidLoss,
    Parameter::MeteringPorts,
    Parameter::MeteringDirections,
    Parameter::CavitationFloor,
];

/// A stream for each parameter; the first ones are the sensors'. The others keep their streams beside those that came later, so that a
/// seed draws the same machine as before.
fn stream(parameter: Parameter) -> u64 {
    match LATER.iter().position(|&later| later == parameter) {
        Some(later) => 999 - later as u64,
        None => 1000 + parameter as u64 - LATER.iter().filter(|&&later| later < parameter).count() as u64,
    }
}

#[cfg(test)]
mod tests {
    use model_core::machine::Source;

    use super::*;

    #[test]
    fn only_listed_values_move_and_by_two_deviations_at_most() {
        let nominal = Machine::with_defaults(Source::Valve);
        let sigma = BTreeMap::from([(Parameter::ValveGain, 0.01), (Parameter::TransportDelay, 1.0)]);
        let truth = truth_near(&nominal, &sigma, 1.0, 3);
        let off = (truth.get(Parameter::ValveGain) - nominal.get(Parameter::ValveGain)).abs();
        assert!(off > 0.0 && off <= 0.02);
        assert!((0.0..=1.0).contains(&truth.get(Parameter::TransportDelay)), "within its range");
        assert!((truth.get(Parameter::BulkModulus) - nominal.get(Parameter::BulkModulus)).abs() < 1e-9);
        let again = truth_near(&nominal, &sigma, 1.0, 3).get(Parameter::ValveGain);
        assert_eq!(again.to_bits(), truth.get(Parameter::ValveGain).to_bits());
        let exact = truth_near(&nominal, &sigma, 0.0, 3).get(Parameter::ValveGain);
        assert_eq!(exact.to_bits(), nominal.get(Parameter::ValveGain).to_bits());
    }
}
