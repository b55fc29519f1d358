//! How far an effect rises above the noise, after the uncertain parameters have compensated as much of it as they can.
//!
//! It is the difference that the effect makes to each recorded signal, relative to its noise, less the part that the uncertain
//! parameters can explain, each with its standard deviation: a linear refit with the machine file's prior. How far an effect differs from
//! a plainer one is measured in the same way, with the strength of the plainer one free.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use model_core::machine::{Machine, Parameter};

use super::bench::{RunInput, Setting};
use crate::effect::PlantEffect;
use crate::plant::PlantError;
use crate::rig::recorded::SyntheticRecording;

/// Approximate number of rows of a recording that are used.
const ROWS: usize = 400;
/// Relative increase of a plainer effect's strength, for the derivative by that strength.
const STRONGER: f64 = 0.1;

/// A case's recordings, to be repeated without an effect.
pub(crate) struct Shown<'a> {
    pub(crate) setting: &'a Setting,
    pub(crate) sigma: &'a BTreeMap<Parameter, f64>,
    /// Excitations and the recordings made with them.
    pub(crate) made: &'a [(RunInput, SyntheticRecording)],
    pub(crate) effects: &'a [PlantEffect],
}

/// What a case's recordings show with all effects, and how the base parameters could change that.
pub(crate) struct Refits<'a> {
    shown: Shown<'a>,
    base: DVector<f64>,
    /// The change for one standard deviation of each uncertain parameter, and for another start of each recording.
    base_parameters: Vec<DVector<f64>>,
}

/// RMS residual of refits, noise included, relative to the noise, in the worst channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Visible {
    /// Without each effect in turn; where the rod is pushed, without the push instead.
    pub(crate) each: Vec<f64>,
    /// Without all of several effects.
    pub(crate) together: Option<f64>,
    /// With its plainer form instead of each effect that has one, and the name of that form.
    pub(crate) plainer: Vec<Option<(&'static str, f64)>>,
}

impl Refits<'_> {
    pub(crate) fn visible(&self, pushed: bool) -> Result<Visible, PlantError> {
        let several = self.shown.effects.len() > 1;
        Ok(Visible {
            each: self.without_each(pushed)?,
            together: several.then(|| self.with_only(&[], true)).transpose()?,
            plainer: self.plainer_each()?,
        })
    }

    fn without_each(&self, pushed: bool) -> Result<Vec<f64>, PlantError> {
        let effects = self.shown.effects;
        if pushed {
            return Ok(vec![self.with_only(effects, false)?]);
        }
        let but = |left_out: usize| -> Vec<PlantEffect> {
            effects.iter().enumerate().filter(|&(k, _)| k != left_out).map(|(_, &effect)| effect).collect()
        };
        (0..effects.len()).map(|left_out| self.with_only(&but(left_out), true)).collect()
    }

    fn with_only(&self, effects: &[PlantEffect], pushed: bool) -> Result<f64, PlantError> {
        let Self { shown, base, base_parameters } = self;
        let without = shown.repeated(&shown.setting.machine, effects, pushed)?;
        Ok(shown.worst_channel(&projected(&DMatrix::from_columns(base_parameters), &(base - without), shown.weight())))
    }

    fn plainer_each(&self) -> Result<Vec<Option<(&'static str, f64)>>, PlantError> {
        let Self { shown, base, base_parameters } = self;
        let effects = shown.effects;
        let with = |k: usize, plain: PlantEffect| {
            let all: Vec<PlantEffect> =
                effects.iter().enumerate().map(|(i, &e)| if i == k { plain } else { e }).collect();
            shown.repeated(&shown.setting.machine, &all, true)
        };
        let of_each = |(k, effect): (usize, &PlantEffect)| {
            let strengths = [effect.plainer(1.0), effect.plainer(1.0 + STRONGER)];
            let [Some(plain), Some(stronger)] = strengths else { return Ok(None) };
            let (plainly, more) = (with(k, plain)?, with(k, stronger)?);
            let mut columns = base_parameters.clone();
            columns.push((more - &plainly) / STRONGER);
            let left = projected(&DMatrix::from_columns(&columns), &(base - plainly), shown.weight());
            Ok(Some((plain.name(), shown.worst_channel(&left))))
        };
        effects.iter().enumerate().map(of_each).collect()
    }
}

impl<'a> Shown<'a> {
    /// Repeats the recordings with all effects, and with each base parameter changed a little.
    pub(crate) fn refits(self) -> Result<Refits<'a>, PlantError> {
        let (machine, effects) = (&self.setting.machine, self.effects);
        let base = self.repeated(machine, effects, true)?;
        let mut base_parameters = Vec::new();
        for (&parameter, &deviation) in self.sigma {
            let mut moved = *machine;
            let range = parameter.description();
            moved.set(parameter, (machine.get(parameter) + 0.5 * deviation).clamp(range.min, range.max));
            let other = self.repeated(&moved, effects, true)?;
            base_parameters.push((other - &base) * 2.0);
        }
        base_parameters.extend((0..self.made.len()).map(|recording| self.other_start(recording)));
        Ok(Refits { shown: self, base, base_parameters })
    }

    /// Number of recorded rows for each row that is used.
    fn weight(&self) -> f64 {
        let rows = self.made.iter().map(|(_, made)| made.len()).max().unwrap_or(ROWS);
        (rows as f64 / ROWS as f64).max(1.0)
    }

    /// What the recordings would show of another drive, all in one vector.
    fn repeated(
        &self,
        machine: &Machine<f64>,
        effects: &[PlantEffect],
        pushed: bool,
    ) -> Result<DVector<f64>, PlantError> {
        let mut all = Vec::new();
        for (signal, made) in self.made {
            all.extend(self.rows(&self.setting.repeat(machine, effects, made, signal, pushed)?));
        }
        Ok(DVector::from_vec(all))
    }

    /// Spool, position and pressures in some of the rows, relative to their noise; a channel that is not recorded is 0.
    fn rows(&self, made: &SyntheticRecording) -> Vec<f64> {
        let noise = self.setting.noise_of();
        let seen = self.setting.channels.recorded();
        let step = (made.len() / ROWS).max(1);
        let mut rows = Vec::new();
        for reading in made.seen.iter().step_by(step) {
            let values = [reading.spool, reading.position_m, reading.pressure_a_pa, reading.pressure_b_pa];
            rows.extend((0..4).map(|k| if seen[k] { values[k] / noise[k] } else { 0.0 }));
        }
        rows
    }

    /// The change if one recording started a centimetre away: a simulation starts where its recording starts.
    fn other_start(&self, moved: usize) -> DVector<f64> {
        const AWAY_M: f64 = 0.01;
        let away = AWAY_M / self.setting.noise_of()[1];
        let rows = |recording: usize| {
            let count = self.rows(&self.made[recording].1).len();
            (0..count).map(move |k| if recording == moved && k % 4 == 1 { away } else { 0.0 })
        };
        DVector::from_vec((0..self.made.len()).flat_map(rows).collect())
    }

    fn worst_channel(&self, residual: &DVector<f64>) -> f64 {
        let seen = self.setting.channels.recorded();
        let rms = |channel: usize| {
            let squares: Vec<f64> = residual.iter().skip(channel).step_by(4).map(|r| r * r).collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        let worst = (0..4).filter(|&channel| seen[channel]).map(rms).fold(0.0, f64::max);
        1.0_f64.hypot(worst)
    }
}

/// The residual of `difference` after the parameters, each with a deviation of 1, have explained their part.
fn projected(jacobian: &DMatrix<f64>, difference: &DVector<f64>, weight: f64) -> DVector<f64> {
    let transposed = jacobian.transpose();
    let normal = &transposed * jacobian * weight + DMatrix::identity(jacobian.ncols(), jacobian.ncols());
    match normal.cholesky() {
        Some(factor) => difference - jacobian * factor.solve(&(transposed * difference * weight)),
        None => difference.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_free_parameter_takes_its_part_and_a_known_one_does_not() {
        let jacobian = DMatrix::from_column_slice(3, 1, &[100.0, 100.0, 0.0]);
        let difference = DVector::from_vec(vec![50.0, 50.0, 3.0]);
        let left = projected(&jacobian, &difference, 1.0);
        assert!(left[0].abs() < 0.1 && (left[2] - 3.0).abs() < 1e-9);
        let left = projected(&(jacobian * 1e-4), &difference, 1.0);
        assert!((left[0] - 50.0).abs() < 0.1);
    }
}
