//! Recordings at twice the tick: half the work of every simulation, for a first estimate.
//!
//! The error of the doubled step at a solution is removed from the recorded values, so the residuals there are those of
//! the recording's own tick. Elsewhere the change of this error is missing in them.

use model_core::machine::{Machine, MachineError};
use simulation::{Coarser, Run};

use super::initial_state::StartState;
use super::residuals::{runs, simulated};
use crate::experiment::{JudgedSignal, Prepared};

/// Recordings at twice the tick, around a machine and the initial state of each; unchanged where the core has no such tick.
pub fn coarse(
    cases: &[&Prepared],
    machine: &Machine<f64>,
    starts: &[StartState],
) -> Result<Vec<Prepared>, MachineError> {
    let coarser: Vec<Option<Coarser>> = cases.iter().map(|case| case.stimulus.coarser()).collect();
    let fine = runs(machine, cases.iter().copied().zip(starts.iter().copied()));
    let rough = fine.iter().zip(&coarser).map(|(run, coarser)| Run {
        stimulus: coarser.as_ref().map_or(run.stimulus, |coarser| &coarser.stimulus),
        ..run.clone()
    });
    let rough = simulated(machine, &rough.collect::<Vec<_>>(), |_| true)?;
    let fine = simulated(machine, &fine, |_| true)?;
    let simulated = fine.iter().zip(&rough);
    let each = cases.iter().zip(coarser).zip(simulated).map(|((&case, coarser), (fine, rough))| match coarser {
        Some(coarser) => at_twice_the_tick(case, coarser, fine, rough),
        None => case.clone(),
    });
    Ok(each.collect())
}

/// A recording at twice the tick, given what is simulated at its own tick (`fine`) and at twice that (`rough`).
fn at_twice_the_tick(case: &Prepared, Coarser { stimulus, kept }: Coarser, fine: &[f64], rough: &[f64]) -> Prepared {
    let channels = case.channels.len();
    // What a whitened recording is judged by are its gains, which stay as many.
    let kept = if stimulus.is_whitened() { (0..case.rows()).collect() } else { kept };
    // Fewer rows have to weigh as much as all of them.
    let weight = (kept.len() as f64 / case.rows() as f64).sqrt();
    let channel = |(index, channel): (usize, &JudgedSignal)| JudgedSignal {
        recorded: kept
            .iter()
            .zip(rough.chunks_exact(channels))
            .map(|(&row, rough)| channel.recorded[row] - fine[row * channels + index] + rough[index])
            .collect(),
        failed: kept.iter().map(|&row| channel.failed[row]).collect(),
        noise: channel.noise * weight,
        input_noise: channel.input_noise * weight,
        tolerance: channel.tolerance / weight,
        stretches: Vec::new(),
        ends: Vec::new(),
        ..*channel
    };
    Prepared {
        name: case.name.clone(),
        time_s: kept.iter().map(|&row| case.time_s[row]).collect(),
        channels: case.channels.iter().enumerate().map(channel).collect(),
        stimulus,
        tick: case.tick,
        failures: Vec::new(),
        unsettled: kept.partition_point(|&row| row < case.unsettled),
        start_sigma_m: case.start_sigma_m,
        input_noise: case.input_noise,
        effort: case.effort.clone(),
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Parameter;
    use test_press::{extending, press};

    use super::*;
    use crate::fit::residuals::standardised;

    /// Residuals of the position over its noise.
    fn missed(machine: &Machine<f64>, case: &Prepared) -> Vec<f64> {
        standardised(machine, case, StartState::default()).unwrap().remove(0)
    }

    #[test]
    fn residuals_at_twice_the_tick_are_those_of_the_rows_that_are_kept_and_a_small_change_moves_them_as_much() {
        let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::TimeConstant2, 0.02)]);
        let fine = Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap();
        // Around a machine with an error, where residuals are far larger than noise.
        let around = machine.with(&[(Parameter::FlowCoefficient, 1.02 * machine.get(Parameter::FlowCoefficient))]);
        let coarser = coarse(&[&fine], &around, &[StartState::default()]).unwrap().remove(0);
        assert_eq!((coarser.rows(), coarser.stimulus.ticks()), (600, 599));

        let (all, kept) = (missed(&around, &fine), missed(&around, &coarser));
        let weight = coarser.channels[0].noise / fine.channels[0].noise;
        for (row, kept) in kept.iter().enumerate() {
            assert!((all[2 * row] - weight * kept).abs() < 1e-9 * all[2 * row].abs().max(1.0), "{row}");
        }
        let square = |series: &[f64]| series.iter().map(|one| one * one).sum::<f64>();
        assert!((square(&kept) / square(&all) - 1.0).abs() < 0.02, "{} {}", square(&kept), square(&all));

        let other = around.with(&[(Parameter::InternalLeakage, 2e-12)]);
        let change = |case: &Prepared| -> Vec<f64> {
            missed(&other, case).iter().zip(missed(&around, case)).map(|(there, here)| there - here).collect()
        };
        let (fine, coarse) = (change(&fine), change(&coarser));
        let off: Vec<f64> = coarse.iter().enumerate().map(|(row, coarse)| weight * coarse - fine[2 * row]).collect();
        assert!(square(&fine) > 100.0 && square(&off) < 1e-4 * square(&fine), "{} of {}", square(&off), square(&fine));
    }
}
