//! A recording with one more force on the rod, given tick by tick.

use super::Stimulus;

impl Stimulus {
    /// Points of the grid: one more than ticks.
    #[must_use]
    pub fn points(&self) -> usize {
        self.ticks + 1
    }

    /// The same with a further external force at each grid point, N; positive extends. Where pressures are not recorded, the drive starts in balance with its
    /// first value; where they are, they tell the start, and its bristles hold the rest.
    #[must_use]
    pub fn with_force(&self, force_n: &[f64]) -> Self {
        let mut with = self.clone();
        let load_n = with.load_n.get_or_insert_with(|| vec![0.0; self.ticks + 1]);
        for (load_n, force_n) in load_n.iter_mut().zip(force_n) {
            *load_n += force_n;
        }
        with.start.load_n += force_n.first().copied().unwrap_or(0.0);
        with
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::{Parameter, Tick};
    use recording::Signal;
    use test_press::{extending, press};

    use crate::{InputPoint, StartOffset, Stimulus, simulate_f64};

    fn stimulus(machine: &model_core::machine::Machine<f64>) -> Stimulus {
        Stimulus::new(&extending(machine), machine, InputPoint::Command, LoadSource::Constant, Tick::OneMillisecond)
            .unwrap()
    }

    #[test]
    fn a_constant_force_is_the_load_s() {
        let machine = press(&[]);
        let (plain, force_n) = (stimulus(&machine), 700.0);
        let loaded = machine.with(&[(Parameter::LoadForce, machine.get(Parameter::LoadForce) + force_n)]);
        let with = plain.with_force(&vec![force_n; plain.points()]);
        let run = |machine, stimulus| simulate_f64(machine, stimulus, StartOffset::none()).unwrap();
        let (by_force, by_load, without) = (run(&machine, &with), run(&loaded, &plain), run(&machine, &plain));
        let apart = |one: &crate::Trajectory, other: &crate::Trajectory| {
            let position = |of: &crate::Trajectory| of.signal(Signal::Position).unwrap().to_vec();
            position(one).iter().zip(position(other)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(apart(&by_force, &by_load) < 1e-9, "{}", apart(&by_force, &by_load));
        assert!(apart(&by_force, &without) > 1e-6, "{}", apart(&by_force, &without));
    }
}
