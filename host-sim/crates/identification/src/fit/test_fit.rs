//! A fit of three values for the tests: the recordings determine the first two only by their sum, and the third by itself.

use model_core::machine::Parameter as P;
use nalgebra::{DMatrix, DVector};
use test_press::press;

use super::{Fit, Free, Freedom, NormalEquations, OF_START, StartState};

/// It ended at these coordinates, where half the sum of squares has these slopes without the priors'.
pub(super) fn ended(at: [f64; 3], slopes: [f64; 3], converged: bool) -> Fit {
    let around = |parameter, nominal, sigma| Free { parameter, freedom: Freedom::Around { nominal, sigma } };
    let free = vec![
        around(P::ValveGain, 0.05, 0.005),
        around(P::FlowCoefficient, 2.4e-7, 2.4e-8),
        around(P::ViscousFriction, 1e4, 1e3),
    ];
    let mut matrix = DMatrix::zeros(3 + OF_START, 3 + OF_START);
    for (one, other) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2)] {
        matrix[(one, other)] = 99.0;
    }
    let mut gradient = DVector::zeros(3 + OF_START);
    gradient.rows_mut(0, 3).copy_from_slice(&slopes);
    Fit {
        machine: press(&[]),
        free,
        coordinates: at.to_vec(),
        starts: vec![StartState::default()],
        normal_equations: vec![NormalEquations { matrix, gradient, square: 1000.0, rows: 1000.0 }],
        converged,
        loss: 0.0,
    }
}
