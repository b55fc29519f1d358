//! What a recording says at a step nearby, by the kept Jacobian of the point where the step began: a plain run replaces one with derivatives.

use nalgebra::DVector;

use model_core::machine::{Machine, MachineError};

use super::initial_state::StartState;
use super::normal_equations::{NormalEquations, OF_START};
use super::residuals::{missed, runs, simulated, soft};
use crate::experiment::Prepared;

/// A Jacobian of more than this many values is not kept: 16 MB per recording.
const MOST_KEPT: usize = 4 << 20;

/// The derivatives of one recording's residuals with respect to every coordinate, before they are softened, row after row.
#[derive(Debug)]
pub(crate) struct Jacobian {
    columns: usize,
    /// Empty where they are not kept.
    values: Vec<f32>,
    is_kept: bool,
}

impl Jacobian {
    /// Space for a recording's derivatives with respect to this many free parameters.
    pub(crate) fn new(free: usize, case: &Prepared) -> Self {
        let columns = free + OF_START;
        let count = columns * case.rows() * case.channels.len();
        let is_kept = count <= MOST_KEPT;
        Self { columns, values: if is_kept { Vec::with_capacity(count) } else { Vec::new() }, is_kept }
    }

    /// One row, times a scale.
    #[inline]
    pub(crate) fn put(&mut self, jacobian: impl Iterator<Item = f32>, scale: f32) {
        if self.is_kept {
            self.values.extend(jacobian.map(|slope| slope * scale));
        }
    }
}

impl NormalEquations {
    /// The normal equations at a machine and starts nearby: residuals computed anew, the Jacobian as kept. `None` where it was not kept.
    pub(crate) fn by_kept_jacobian(
        here: &[Self],
        jacobian: &[Jacobian],
        machine: &Machine<f64>,
        cases: &[&Prepared],
        starts: &[StartState],
    ) -> Result<Option<Vec<Self>>, MachineError> {
        if !jacobian.iter().all(|jacobian| jacobian.is_kept) {
            return Ok(None);
        }
        let runs = runs(machine, cases.iter().copied().zip(starts.iter().copied()));
        let there = simulated(machine, &runs, |_| true)?;
        let moved = |((here, jacobian), (case, there)): ((&Self, &Jacobian), (&&Prepared, &Vec<f64>))| {
            here.moved(jacobian, case, there)
        };
        Ok(Some(here.iter().zip(jacobian).zip(cases.iter().zip(&there)).map(moved).collect()))
    }

    /// The same with the residuals of what one recording simulates.
    fn moved(&self, jacobian: &Jacobian, case: &Prepared, simulated: &[f64]) -> Self {
        let mut rows = jacobian.values.chunks_exact(jacobian.columns);
        let mut gradient = vec![0.0; jacobian.columns];
        let mut square = 0.0;
        for (row, simulated) in simulated.chunks_exact(case.channels.len()).enumerate() {
            let judged = case.channels.iter().zip(simulated).filter(|(channel, _)| !channel.failed[row]);
            for (channel, &simulated) in judged {
                let (residual, slope) = soft(missed(channel, row, Some(simulated)), channel.tolerance);
                square += residual * residual;
                let weight = slope * residual;
                for (sum, slope) in gradient.iter_mut().zip(rows.next().unwrap_or_default()) {
                    *sum += weight * f64::from(*slope);
                }
            }
        }
        Self { gradient: DVector::from_vec(gradient), square, ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use std::slice;

    use machine_file::LoadSource;
    use model_core::machine::Parameter;
    use test_press::{extending, press};

    use super::*;
    use crate::fit::jacobian::At;
    use crate::fit::{Free, Freedom};

    /// Derivatives computed at some coordinates of two parameters.
    fn own(
        machine: &Machine<f64>,
        free: &[Free],
        coordinates: [f64; 2],
        case: &Prepared,
    ) -> (NormalEquations, Jacobian, Machine<f64>) {
        let mut moved = *machine;
        for (free, coordinate) in free.iter().zip(coordinates) {
            moved.set(free.parameter, free.value(coordinate));
        }
        let mut jacobian = Jacobian::new(free.len(), case);
        let at = At { base: machine, free, coordinates: &coordinates };
        (NormalEquations::of(&at, StartState::default(), case, &mut jacobian).unwrap(), jacobian, moved)
    }

    #[test]
    fn a_kept_jacobian_predicts_at_its_own_point_what_it_did_and_a_step_on_nearly_what_a_new_one_does() {
        let machine = press(&[(Parameter::ViscousFriction, 4e4)]);
        let mut case = Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap();
        // Rows that are not judged have no derivatives either.
        for (row, failed) in case.channels[0].failed.iter_mut().enumerate() {
            *failed = row % 7 == 3;
        }
        let free = [Parameter::ViscousFriction, Parameter::FlowCoefficient].map(|parameter| {
            let nominal = machine.get(parameter);
            Free { parameter, freedom: Freedom::Around { nominal, sigma: 0.1 * nominal } }
        });
        let by_kept_jacobian = |here: &NormalEquations, jacobian: &Jacobian, there: &Machine<f64>| {
            let (here, jacobian, starts) = (slice::from_ref(here), slice::from_ref(jacobian), [StartState::default()]);
            NormalEquations::by_kept_jacobian(here, jacobian, there, &[&case], &starts).unwrap().unwrap().remove(0)
        };
        let apart = |a: &NormalEquations, b: &NormalEquations| (&a.gradient - &b.gradient).norm() / b.gradient.norm();

        let (here, jacobian, there) = own(&machine, &free, [0.3, -0.2], &case);
        let again = by_kept_jacobian(&here, &jacobian, &there);
        assert!((again.square / here.square - 1.0).abs() < 1e-12, "{} {}", again.square, here.square);
        assert!(apart(&again, &here) < 1e-5, "{}", apart(&again, &here));

        let (anew, _, there) = own(&machine, &free, [0.5, -0.5], &case);
        let by_kept_jacobian = by_kept_jacobian(&here, &jacobian, &there);
        assert!(
            (by_kept_jacobian.square / anew.square - 1.0).abs() < 1e-12,
            "{} {}",
            by_kept_jacobian.square,
            anew.square
        );
        assert!(
            apart(&here, &anew) > 0.2 && apart(&by_kept_jacobian, &anew) < 0.01,
            "{} {}",
            apart(&here, &anew),
            apart(&by_kept_jacobian, &anew)
        );
    }
}
