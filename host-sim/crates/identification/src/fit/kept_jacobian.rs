//! What a recording tells at a step nearby, by the slopes of where the step began: one plain run in place of one with slopes.

use nalgebra::DVector;

use model_core::machine::{Machine, MachineError};

use super::initial_state::StartState;
use super::normal_equations::{Information, OF_START};
use super::residuals::{missed, runs, simulated, soft};
use crate::experiment::Prepared;

/// Slopes of more than so many values are not kept: 16 MB of a recording.
const MOST_KEPT: usize = 4 << 20;

/// The slopes of one recording's residuals by every coordinate, before they are softened, row after row.
#[derive(Debug)]
pub(crate) struct Slopes {
    columns: usize,
    /// Empty where they are not kept.
    values: Vec<f32>,
    is_kept: bool,
}

impl Slopes {
    /// Room for a recording's slopes by so many free parameters.
    pub(crate) fn new(free: usize, case: &Prepared) -> Self {
        let columns = free + OF_START;
        let count = columns * case.rows() * case.channels.len();
        let is_kept = count <= MOST_KEPT;
        Self { columns, values: if is_kept { Vec::with_capacity(count) } else { Vec::new() }, is_kept }
    }

    /// One row, times a scale.
    #[inline]
    pub(crate) fn put(&mut self, slopes: impl Iterator<Item = f32>, scale: f32) {
        if self.is_kept {
            self.values.extend(slopes.map(|slope| slope * scale));
        }
    }
}

impl Information {
    /// What they become at a machine and starts nearby: residuals anew, and slopes as they were kept. `None` where they were not.
    pub(crate) fn nearby(
        here: &[Self],
        slopes: &[Slopes],
        machine: &Machine<f64>,
        cases: &[&Prepared],
        starts: &[StartState],
    ) -> Result<Option<Vec<Self>>, MachineError> {
        if !slopes.iter().all(|slopes| slopes.is_kept) {
            return Ok(None);
        }
        let runs = runs(machine, cases.iter().copied().zip(starts.iter().copied()));
        let there = simulated(machine, &runs, |_| true)?;
        let moved = |((here, slopes), (case, there)): ((&Self, &Slopes), (&&Prepared, &Vec<f64>))| {
            here.moved(slopes, case, there)
        };
        Ok(Some(here.iter().zip(slopes).zip(cases.iter().zip(&there)).map(moved).collect()))
    }

    /// With the residuals of what one recording simulates.
    fn moved(&self, slopes: &Slopes, case: &Prepared, simulated: &[f64]) -> Self {
        let mut rows = slopes.values.chunks_exact(slopes.columns);
        let mut gradient = vec![0.0; slopes.columns];
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

    /// Own slopes at some coordinates of two parameters.
    fn own(
        machine: &Machine<f64>,
        free: &[Free],
        coordinates: [f64; 2],
        case: &Prepared,
    ) -> (Information, Slopes, Machine<f64>) {
        let mut moved = *machine;
        for (free, coordinate) in free.iter().zip(coordinates) {
            moved.set(free.parameter, free.value(coordinate));
        }
        let mut slopes = Slopes::new(free.len(), case);
        let at = At { base: machine, free, coordinates: &coordinates };
        (Information::of(&at, StartState::default(), case, &mut slopes).unwrap(), slopes, moved)
    }

    #[test]
    fn where_slopes_were_taken_they_tell_what_they_told_and_a_step_on_what_new_ones_nearly_do() {
        let machine = press(&[(Parameter::ViscousFriction, 4e4)]);
        let mut case = Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap();
        // Rows that are not judged have no slopes either.
        for (row, failed) in case.channels[0].failed.iter_mut().enumerate() {
            *failed = row % 7 == 3;
        }
        let free = [Parameter::ViscousFriction, Parameter::FlowCoefficient].map(|parameter| {
            let nominal = machine.get(parameter);
            Free { parameter, freedom: Freedom::Around { nominal, sigma: 0.1 * nominal } }
        });
        let nearby = |here: &Information, slopes: &Slopes, there: &Machine<f64>| {
            let (here, slopes, starts) = (slice::from_ref(here), slice::from_ref(slopes), [StartState::default()]);
            Information::nearby(here, slopes, there, &[&case], &starts).unwrap().unwrap().remove(0)
        };
        let apart = |a: &Information, b: &Information| (&a.gradient - &b.gradient).norm() / b.gradient.norm();

        let (here, slopes, there) = own(&machine, &free, [0.3, -0.2], &case);
        let again = nearby(&here, &slopes, &there);
        assert!((again.square / here.square - 1.0).abs() < 1e-12, "{} {}", again.square, here.square);
        assert!(apart(&again, &here) < 1e-5, "{}", apart(&again, &here));

        let (anew, _, there) = own(&machine, &free, [0.5, -0.5], &case);
        let nearby = nearby(&here, &slopes, &there);
        assert!((nearby.square / anew.square - 1.0).abs() < 1e-12, "{} {}", nearby.square, anew.square);
        assert!(
            apart(&here, &anew) > 0.2 && apart(&nearby, &anew) < 0.01,
            "{} {}",
            apart(&here, &anew),
            apart(&nearby, &anew)
        );
    }
}
