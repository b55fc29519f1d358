//! Sensors with errors.

use model_core::drive::Drive;
use model_core::machine::{MachineError, Parameter as P};
use model_core::number::{PerUnit, Scalar, Single};

use super::bench::{STROKE_M, State, TICK, at_rest, drive, position_m, press, pushed, velocity_m_per_s, with};

fn sensed_m<N: Scalar<Real = f64>>(drive: &Drive<N>, state: &State<N>) -> f64 {
    N::strokes(drive.sensed(state).position) * STROKE_M
}

#[test]
fn play_hides_half_of_it_from_the_middle_and_all_of_it_at_a_reversal() {
    fn check<N: Scalar<Real = f64>>() {
        let drive = drive::<N>(&with(&press(), &[(P::BacklashPlay, 2e-3)]));
        let mut state = at_rest(&drive, [0.4, 0.4], 0.5);
        assert!((sensed_m(&drive, &state) - 0.15).abs() < 1e-8, "at the start it reads true");
        for _ in 0..100 {
            pushed(&drive, &mut state, 1000.0);
        }
        let out = position_m(&drive, &state) - sensed_m(&drive, &state);
        assert!((out - 1e-3).abs() < 1e-8, "{out}");
        for _ in 0..200 {
            pushed(&drive, &mut state, -1000.0);
        }
        let back = position_m(&drive, &state) - sensed_m(&drive, &state);
        assert!((back + 1e-3).abs() < 1e-8, "{back}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

/// On a ramp the reading is behind by speed times the sum of lag and delay.
#[test]
fn a_slow_sensor_is_behind_by_its_time() {
    fn check<N: Scalar<Real = f64>>() {
        let slow = [(P::PositionLag, 8e-3), (P::PositionDelay, 4.3e-3), (P::Stroke, STROKE_M)];
        let drive = drive::<N>(&with(&press(), &slow));
        let mut state = at_rest(&drive, [0.4, 0.4], 0.1);
        for _ in 0..400 {
            pushed(&drive, &mut state, 2000.0);
        }
        let behind_s = (position_m(&drive, &state) - sensed_m(&drive, &state)) / velocity_m_per_s(&drive, &state);
        assert!((behind_s - 12.3e-3).abs() < 2e-6, "{behind_s}");
    }
    check::<PerUnit>();
    check::<Single>();
    check::<f64>();
}

#[test]
fn gain_errors_and_offsets_are_what_they_say() {
    fn check<N: Scalar<Real = f64>>(within: f64) {
        let wrong = [
            (P::PressureAOffset, 1.4e5),
            (P::PressureAFactor, 0.1),
            (P::PressureBFactor, -0.05),
            (P::SpoolOffset, 0.02),
            (P::PositionFactor, 0.1),
        ];
        let drive = drive::<N>(&with(&press(), &wrong));
        let mut state = at_rest(&drive, [0.4, 0.6], 0.5);
        let sensed = drive.sensed(&state);
        assert!((sensed.pressure_a.to_f64() - 0.46).abs() < within);
        assert!((sensed.pressure_b.to_f64() - 0.57).abs() < within);
        assert!((sensed.spool.to_f64() - 0.02).abs() < within);
        assert!((sensed_m(&drive, &state) - 0.15).abs() < within, "from where the state starts");
        for _ in 0..100 {
            pushed(&drive, &mut state, 1000.0);
        }
        let travel = (position_m(&drive, &state) - 0.15, sensed_m(&drive, &state) - 0.15);
        assert!((travel.1 - 1.1 * travel.0).abs() < within, "{travel:?}");
    }
    check::<PerUnit>(1e-8);
    check::<Single>(1e-7);
    check::<f64>(1e-8);
}

#[test]
fn a_dead_time_longer_than_the_line_is_refused_by_its_name() {
    let machine = with(&press(), &[(P::PositionDelay, 0.05)]);
    let error = Drive::<PerUnit>::new::<32>(&machine, TICK).unwrap_err();
    assert!(
        matches!(error, MachineError::DelayTooLong { parameter: P::PositionDelay, ticks: 52, line: 32, .. }),
        "{error}"
    );
}
