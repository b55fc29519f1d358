//! The true drive, near the nominal values of its machine file.

use std::collections::BTreeMap;

use model_core::machine::{Machine, Parameter};
use recording::seeded_noise::Noise;

/// A drive drawn around its nominal values: each parameter in `sigma` deviates by its standard deviation times a Gaussian
/// number times `spread`, but by no more than two standard deviations and never out of its range. The others are exact.
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

/// Parameters that were added to the table later, between others.
const LATER: [Parameter; 21] = [
    Parameter::LevelAtRest,
    Parameter::ViscosityLossPerKelvin,
    Parameter::ReferenceTemperature,
    Parameter::PositionDragSlope,
    Parameter::PositionDragBow,
    Parameter::SolenoidLoss,
    Parameter::MeteringPorts,
    Parameter::MeteringDirections,
    Parameter::CavitationFloor,
    Parameter::NaturalFrequency,
    Parameter::SpoolDamping,
    Parameter::SpoolSpeedLimit,
    Parameter::VolumeFollows,
    Parameter::SpeedOverdrive,
    Parameter::EdgeRounding,
    Parameter::HoldingSetA,
    Parameter::HoldingSetB,
    Parameter::PilotRatio,
    Parameter::HoldingSpan,
    Parameter::HoldingSize,
    Parameter::HoldingTime,
];

/// A random stream for each parameter; the first streams belong to the sensors. Parameters that were added later do not shift the streams of
/// the others, so that a seed draws the same machine as before.
fn stream(parameter: Parameter) -> u64 {
    match LATER.iter().position(|&later| later == parameter) {
        Some(later) => 999 - later as u64,
        None => 1000 + parameter as u64 - LATER.iter().filter(|&&later| later < parameter).count() as u64,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use model_core::machine::Source;

    use super::*;

    #[test]
    fn a_parameter_that_is_new_takes_no_others_stream() {
        const FIRST: usize = 117;
        assert_eq!(
            Parameter::ALL.len() - LATER.len(),
            FIRST,
            "append the new parameter to LATER: else old seeds draw other machines"
        );
        let streams: BTreeSet<u64> = Parameter::ALL.iter().map(|&parameter| stream(parameter)).collect();
        assert_eq!(streams.len(), Parameter::ALL.len());
    }

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
