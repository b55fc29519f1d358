//! Whether a tick computes a machine: the same question for a file that `init` writes, for a search and for a file that a fit saves.

use model_core::drive::Drive;
use model_core::machine::{Machine, MachineError, Tick};
use model_core::number::PerUnit;
use recording::files::source_error::Place;

use crate::{DELAY_LINE, MachineFile, MachineFileError};

/// Whether the controller's step computes the machine at this tick.
///
/// # Errors
/// The value that it does not compute.
pub fn carried(machine: &Machine<f64>, tick: Tick) -> Result<(), MachineError> {
    Drive::<PerUnit>::new::<DELAY_LINE>(machine, tick).map(drop)
}

impl MachineFile {
    /// The tick that computes a fitted drive: the one that was asked for; without one 1 ms or, where that does not, 0.5 ms. `file` stands for the
    /// file in messages.
    ///
    /// # Errors
    /// The value that it does not compute, and whether 0.5 ms would.
    pub fn tick_of_fitted(&self, file: &str, asked: Option<Tick>) -> Result<Tick, MachineFileError> {
        let is_computed = |tick: &Tick| carried(&self.machine, *tick);
        let tick = asked.unwrap_or(Tick::OneMillisecond);
        let Err(cause) = is_computed(&tick) else { return Ok(tick) };
        let shorter_computes = is_computed(&Tick::HalfMillisecond).is_ok();
        if asked.is_none() && shorter_computes {
            return Ok(Tick::HalfMillisecond);
        }
        Err(MachineFileError::FittedNotCarried { place: Place::file(file), tick, shorter_computes, cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_text;

    /// A drive with a mass so small that its oil spring turns by this many rad in a tick of 1 ms.
    fn of_spring(turn: f64) -> MachineFile {
        let of_mass = |mass_kg: f64| {
            let text = format!(
                "[supply]\npressure_pa = 7e6\n[valve]\ngain_per_v = 0.06\n[cylinder]\narea_a_m2 = 3e-3\narea_b_m2 = 2e-3\n\
                 viscous_friction_n_s_per_m = 0.0\nmoving_mass_kg = {mass_kg:?}\n"
            );
            read_text("press.toml", &text).unwrap()
        };
        of_mass(1e-6 * of_mass(1.0).machine.oil_spring_n_per_m() / (turn * turn))
    }

    #[test]
    fn a_fitted_drive_that_is_too_fast_for_a_tick_is_refused_with_the_tick_that_computes_it() {
        let of = |turn: f64, asked| of_spring(turn).tick_of_fitted("f.toml", asked);
        assert_eq!(of(0.5, None).unwrap(), Tick::OneMillisecond);
        let fast =
            (1..4000).map(|step| 0.01 * f64::from(step)).find(|turn| of(*turn, Some(Tick::OneMillisecond)).is_err());
        let fast = fast.unwrap();
        assert_eq!(of(fast, None).unwrap(), Tick::HalfMillisecond);
        let message = of(fast, Some(Tick::OneMillisecond)).unwrap_err().to_string();
        assert!(message.contains("step of 1 ms") && message.contains("--tick 0.5"), "{message}");
        let message = of(10.0 * fast, None).unwrap_err().to_string();
        assert!(message.contains("moving_mass_kg") && !message.contains("--tick 0.5"), "{message}");
    }
}
