//! Machine and tuning → coefficients of the follower.
#![expect(clippy::float_arithmetic, reason = "coefficients are computed once, before a run, in real arithmetic")]

use super::orifice::Orifice;
use super::overlap::Overlap;
use super::{Follower, Tuning};
use crate::coefficients::bases::{COMMAND_V, bases};
use crate::machine::{Bases, Machine, MachineError, Parameter as P, Source, Tick};
use crate::number::Scalar;

/// Why a machine and a tuning do not become a follower.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FollowError {
    /// Only a valve has an overlap, and edges whose flow can be inverted.
    #[error("the machine is driven by {found:?}, expected a valve")]
    Source {
        /// The source that the machine has.
        found: Source,
    },
    /// The machine is not valid.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// A value of the tuning is out of its range.
    #[error("tuning: {name} = {value}, expected {least} to {most}")]
    Tuning {
        /// The name of its field.
        name: &'static str,
        /// Its value, in its unit.
        value: f64,
        /// Smallest that is admissible.
        least: f64,
        /// Largest that is admissible.
        most: f64,
    },
    /// A coefficient does not fit the number format.
    #[error("{coefficient} becomes {scaled:.6}, which does not fit; expected a magnitude below {limit}")]
    DoesNotFit {
        /// The coefficient, in words.
        coefficient: &'static str,
        /// Its value.
        scaled: f64,
        /// What its magnitude must stay below.
        limit: f64,
    },
}

impl<N: Scalar<Real = f64>> Follower<N> {
    /// The follower of `machine` with a period of `tick`.
    ///
    /// # Errors
    /// The machine has no valve or a parameter out of range, the tuning has a value out of range, or a coefficient does not fit.
    pub fn new(machine: &Machine<f64>, tuning: &Tuning, tick: Tick) -> Result<Self, FollowError> {
        if machine.source != Source::Valve {
            return Err(FollowError::Source { found: machine.source });
        }
        machine.check()?;
        let bases = bases(machine, tick);
        check(tuning, machine)?;
        let per_volt = machine.get(P::ValveGain);
        let half_of_difference = 0.5 * machine.get(P::DeadZoneDifference);
        // From the sensor's half step to velocity per unit: strokes to velocity bases.
        let loop_gain = |per_s: f64| per_s * bases.stroke_m / bases.velocity_m_per_s;
        let command = |volts: f64| volts / bases.command_v;
        let middle = half_of_difference - machine.get(P::ValveOffset);
        Ok(Self {
            orifice: orifice(machine, &bases)?,
            overlap: overlap(machine.get(P::DeadZone), tuning.kept_overlap)?,
            middle: signal::<N>("middle of the overlap", half_of_difference)?,
            per_spool: gain::<N>("command per spool travel", command(1.0 / per_volt))?,
            per_command: gain::<N>("spool travel per command", per_volt * bases.command_v)?,
            neutral: signal::<N>("neutral command", command(middle / per_volt))?,
            command_limit: signal::<N>("command limit", command(tuning.command_limit_v))?,
            slew: signal::<N>("slew a tick", command(tuning.slew_v_per_s * bases.tick_s))?,
            velocity_limit: signal::<N>("velocity limit", tuning.velocity_limit_m_per_s / bases.velocity_m_per_s)?,
            lead: steep::<N>("lead", tuning.lead_s / tuning.lead_filter_s)?,
            lead_share: gain::<N>("share of the lead's filter", share(bases.tick_s, tuning.lead_filter_s))?,
            spool_gain: steep::<N>("spool gain", tuning.spool_gain)?,
            model_gain: steep::<N>("model gain", loop_gain(tuning.model_gain_per_s))?,
            process_gain: steep::<N>("process gain", loop_gain(tuning.process_gain_per_s))?,
            integral_gain: steep::<N>("process integral", loop_gain(tuning.process_integral_per_s2 * bases.tick_s))?,
            unseen: signal::<N>(
                "half of the position's resolution",
                0.5 * tuning.position_resolution_m / bases.stroke_m,
            )?,
            load_share: gain::<N>("share of the load's filter", share(bases.tick_s, tuning.load_filter_s))?,
            damping: steep::<N>(
                "pressure damping",
                tuning.pressure_damping_m_per_s_n * bases.force_n / bases.velocity_m_per_s,
            )?,
        })
    }
}

/// Share of a difference that a first-order filter takes in a tick; all of it where the filter has no time constant.
fn share(tick_s: f64, time_constant_s: f64) -> f64 {
    if time_constant_s > 0.0 { 1.0 - libm::exp(-tick_s / time_constant_s) } else { 1.0 }
}

fn check(tuning: &Tuning, machine: &Machine<f64>) -> Result<(), FollowError> {
    let dead_zone = machine.get(P::DeadZone);
    let least_kept = if dead_zone > 0.0 { 1e-4 } else { 0.0 };
    let ranges = [
        ("command_limit_v", tuning.command_limit_v, 0.01, 4.0 * COMMAND_V),
        ("slew_v_per_s", tuning.slew_v_per_s, 0.1, 1e5),
        ("velocity_limit_m_per_s", tuning.velocity_limit_m_per_s, 1e-4, 100.0),
        ("kept_overlap", tuning.kept_overlap, least_kept, dead_zone.max(least_kept)),
        ("lead_s", tuning.lead_s, 0.0, 10.0),
        ("lead_filter_s", tuning.lead_filter_s, 1e-4, 10.0),
        ("slider_gain", tuning.spool_gain, 0.0, 20.0),
        ("model_gain_per_s", tuning.model_gain_per_s, 0.0, 1e4),
        ("process_gain_per_s", tuning.process_gain_per_s, 0.0, 1e4),
        ("process_integral_per_s2", tuning.process_integral_per_s2, 0.0, 1e6),
        ("position_resolution_m", tuning.position_resolution_m, 0.0, machine.get(P::Stroke)),
        ("load_filter_s", tuning.load_filter_s, 0.0, 10.0),
        ("pressure_damping_m_per_s_n", tuning.pressure_damping_m_per_s_n, 0.0, 1.0),
    ];
    for (name, value, least, most) in ranges {
        // NaN is in no range.
        if !(least <= value && value <= most) {
            return Err(FollowError::Tuning { name, value, least, most });
        }
    }
    Ok(())
}

fn orifice<N: Scalar<Real = f64>>(machine: &Machine<f64>, bases: &Bases) -> Result<Orifice<N>, FollowError> {
    let ratio = machine.get(P::AreaB) / machine.get(P::AreaA);
    let (supply, tank) = (1.0, machine.get(P::TankPressure) / bases.pressure_pa);
    let flow = machine.get(P::FlowCoefficient) * libm::sqrt(bases.pressure_pa) / bases.flow_m3_per_s;
    let transition = (machine.get(P::LaminarTransition) + machine.get(P::LaminarPressure)) / bases.pressure_pa;
    Ok(Orifice {
        ratio: gain::<N>("area ratio", ratio)?,
        share: gain::<N>("share of the drop", 1.0 / (1.0 + ratio * ratio * ratio))?,
        extending: signal::<N>("drop with the rod extending", supply - ratio * tank)?,
        retracting: signal::<N>("drop with the rod retracting", ratio * supply - tank)?,
        inverse_gain: steep::<N>("opening per flow", 1.0 / flow)?,
        transition: signal::<N>("laminar transition", transition)?,
    })
}

fn overlap<N: Scalar<Real = f64>>(dead_zone: f64, kept: f64) -> Result<Overlap<N>, FollowError> {
    let (spread, shrunk) = if dead_zone > 0.0 { (dead_zone / kept, kept / dead_zone) } else { (1.0, 1.0) };
    Ok(Overlap {
        whole: signal::<N>("overlap", dead_zone)?,
        kept: signal::<N>("kept overlap", if dead_zone > 0.0 { kept } else { 0.0 })?,
        spread: steep::<N>("overlap over what is kept", spread)?,
        shrunk: steep::<N>("what is kept over the overlap", shrunk)?,
    })
}

fn misfit(coefficient: &'static str, scaled: f64, limit: f64) -> FollowError {
    FollowError::DoesNotFit { coefficient, scaled, limit }
}

fn signal<N: Scalar<Real = f64>>(name: &'static str, value: f64) -> Result<N, FollowError> {
    N::signal(value).ok_or_else(|| misfit(name, value, 8.0))
}

fn gain<N: Scalar<Real = f64>>(name: &'static str, value: f64) -> Result<N::Gain, FollowError> {
    N::gain(value).ok_or_else(|| misfit(name, value, 4.0))
}

fn steep<N: Scalar<Real = f64>>(name: &'static str, value: f64) -> Result<N::Steep, FollowError> {
    N::steep(value).ok_or_else(|| misfit(name, value, 65536.0))
}
