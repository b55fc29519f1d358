//! The fit on what the model itself computed: it must find what was put in.

use host_sim::fit::{Free, Freedom, From, fit};
use host_sim::prepare::{Channel, Prepared};
use host_sim::simulate::{StartOffset, simulate};
use model_core::machine::Machine;
use model_core::parameter::Parameter as P;

use super::bed::{Case, press, valve_case};

/// The case's recordings with the model's own signals in place of the test bed's, free of noise.
fn computed(case: &Case, truth: &Machine<f64>) -> Vec<Prepared> {
    let prepare = |recording| Prepared::new(recording, &case.file.machine, case.file.load_source, None).unwrap();
    let replace = |mut prepared: Prepared| {
        let computed = simulate::<f64>(truth, &prepared.stimulus, StartOffset::none()).unwrap();
        for Channel { signal, recorded, .. } in &mut prepared.channels {
            recorded.clear();
            recorded.extend_from_slice(computed.signal(*signal).unwrap());
        }
        prepared
    };
    case.training.iter().map(prepare).map(replace).collect()
}

#[test]
fn a_fit_to_the_models_own_signals_recovers_what_they_were_made_with() {
    let file = press();
    let case = valve_case(21, None, true, None);
    let mut truth = file.machine;
    for (index, (&parameter, &sigma)) in file.sigma.iter().enumerate() {
        let sign = if index % 2 == 0 { 1.0 } else { -1.0 };
        truth.set(parameter, truth.get(parameter) + sign * sigma);
    }
    let strengths = [(P::InternalLeakage, 3e-12), (P::HoseCompliance, 3e-13), (P::CoulombFriction, 500.0)];
    for (parameter, strength) in strengths {
        truth.set(parameter, strength);
    }
    let cases = computed(&case, &truth);
    let cases: Vec<&Prepared> = cases.iter().collect();
    let around = |(&parameter, &sigma): (&P, &f64)| Free {
        parameter,
        // A prior as wide as this has no say.
        freedom: Freedom::Around { nominal: file.machine.get(parameter), sigma: 30.0 * sigma },
    };
    let strength = |(parameter, strength): (P, f64)| Free {
        parameter,
        freedom: Freedom::Logarithm { centre: 0.3 * strength, spread: 30.0, vanishes: true },
    };
    let free: Vec<Free> = file.sigma.iter().map(around).chain(strengths.map(strength)).collect();
    let fit = fit(&file.machine, &free, &cases, &From::default(), 1e-12).unwrap();
    for estimate in &fit.estimates(1.0) {
        let put_in = truth.get(estimate.parameter);
        let off = estimate.value / put_in - 1.0;
        println!("{}: {put_in:e}, found {off:+.1e} of it off", estimate.parameter.description().key);
        assert!(off.abs() < 5e-3, "{}: {put_in:e} {:e}", estimate.parameter.description().key, estimate.value);
    }
    assert!(fit.converged);
}
