//! The supply: a pressure that falls with the flow drawn from it, delayed by an accumulator (`supply-droop`).
//!
//! τ·dps/dt = p0 − R·(Qs + Qo) − ps, with Qs the flow from the supply into both ports (below 0 where a chamber pushes back) and Qo what other
//! consumers take from the same supply, an input. τ = R·C: a pump of source resistance R beside an accumulator of capacity C (Merritt,
//! *Hydraulic Control Systems*, 1967, ch. 11).
//!
//! Over a tick in which the whole flow changes linearly from Q0 to Q1 the solution is exact:
//!
//! ```text
//! ps' = ps + (1 − e)·(p0 − ps) − R·(w0·Q0 + w1·Q1),   e = e^(−h/τ),  w1 = 1 − (1 − e)·τ/h,  w0 = 1 − e − w1
//! ```
//!
//! Q1 depends on ps' itself, more so the faster the supply is. It is solved by iteration along chords: the remaining error, divided by
//! 1 + R·w1·∂Q1/∂ps, twice for the second stage, and once more, from there, for the tick's end. A chord is steeper than
//! its root by a factor of two at most, so each round removes at least half of the remaining error and never overshoots: with τ = 0 (w1 = 1)
//! the static droop is reached to an eighth of its change within the same tick. With a single round, a droop of more than the supply pressure
//! could keep a soft drive oscillating.

use crate::number::Number;

/// State of the supply.
#[derive(Clone, Copy, Debug, PartialEq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SupplyState<N> {
    /// Supply pressure at the valve, per unit: 1 is p0, where it stays without droop.
    pub pressure: N,
    /// Its rounding remainder.
    rest: N,
    /// Flow that other consumers take from the same supply, per unit of [`Bases::flow_m3_per_s`](crate::machine::Bases::flow_m3_per_s): an
    /// input. If it is known, set it before a tick, over which it is held. Without `supply-droop` it acts on nothing.
    pub other_flow: N,
}

impl<N: Number> SupplyState<N> {
    /// No flow has been drawn for a long time.
    pub(crate) fn at_rest(pressure: N) -> Self {
        Self { pressure, rest: N::ZERO, other_flow: N::ZERO }
    }
}

/// Flow drawn from the supply, and its slope against the supply pressure over [`SLOPE_SCALE`](crate::flow::effects::SLOPE_SCALE).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Draw<N> {
    pub(crate) flow: N,
    pub(crate) steepness: N,
}

/// Number of rounds for the flow drawn at the end of a tick, for the tick's second stage; two are enough for stability.
pub(crate) const ROUNDS_OF_STAGE: usize = 2;
/// The same for the tick's end, which begins with the change of the stage.
pub(crate) const ROUNDS_OF_TICK: usize = 1;

/// A supply a tick later.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Supplied<N> {
    pub(crate) supply: SupplyState<N>,
    /// Change of its pressure, at the fineness of [`Droop::shares`].
    pub(crate) moved: N,
}

/// Coefficients of the droop at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct Droop<N: Number> {
    /// 1 − e, −R·w0 and −R·w1, times the fineness.
    pub shares: [N::Gain; 3],
    /// 1 / fineness.
    pub fine: N::Gain,
    /// R·w1: fall of the supply pressure at once, per flow.
    pub at_once: N::Gain,
}

impl<N: Number> Droop<N> {
    /// The supply a tick later, computed in this many rounds from a first guess of its change: `drawn` is the drive's own flow at its start; `draw` gives it at
    /// its end for a supply pressure there.
    #[inline]
    pub(crate) fn after<const ROUNDS: usize>(
        &self,
        supply: SupplyState<N>,
        unloaded: N,
        drawn: N,
        mut moved: N,
        slope_scale: N::Steep,
        draw: impl Fn(N) -> Draw<N>,
    ) -> Supplied<N> {
        let others = supply.other_flow;
        for _ in 0..ROUNDS {
            let at_end = draw(supply.pressure + N::dot([self.fine], [moved]));
            let wanted = N::dot(self.shares, [unloaded - supply.pressure, drawn + others, at_end.flow + others]);
            moved = moved + (wanted - moved).times(self.gives(at_end.steepness, slope_scale));
        }
        let (pressure, rest) = supply.pressure.accumulated(supply.rest, [self.fine], [moved]);
        Supplied { supply: SupplyState { pressure, rest, ..supply }, moved }
    }

    /// 1/(1 + R·w1·∂Q/∂ps)
    #[inline]
    pub(crate) fn gives(&self, steepness: N, slope_scale: N::Steep) -> N {
        N::inverse_one_plus([N::dot([self.at_once], [steepness])], [slope_scale])
    }

    /// Slope of an edge against its chamber's pressure, reduced because the supply pressure gives way with it; all edges that draw have the
    /// steepness `whole`, this one has `own`: 1 − ρ·s/(1 + ρ·Σs).
    #[inline]
    pub(crate) fn softened(&self, own: N, whole: N, slope_scale: N::Steep) -> N {
        let given = own.times(self.gives(whole, slope_scale));
        own.times((N::ONE - N::dot([self.at_once], [given]).amplified(slope_scale)).max(N::ZERO))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{Drive, DriveInput, DriveState, Load};
    use crate::flow::PumpDrive;
    use crate::machine::{Machine, Parameter as P, Source, Tick};
    use crate::number::{PerUnit, Scalar};
    use crate::ports::{ChamberState, Spool};

    /// 10 bar at 0.1 l/s.
    fn machine(time_constant_s: f64) -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        for (parameter, value) in [
            (P::AreaA, 3e-3),
            (P::AreaB, 2e-3),
            (P::VolumeA, 5e-4),
            (P::VolumeB, 3e-4),
            (P::DroopResistance, 1e10),
            (P::DroopTime, time_constant_s),
        ] {
            machine.set(parameter, value);
        }
        machine
    }

    /// Supply pressures in Pa after so many ticks with the valve half open, and the flow it then draws into A in m³/s.
    fn after<N: Scalar<Real = f64>>(machine: &Machine<f64>, ticks: usize) -> [f64; 2] {
        let drive = Drive::<N>::new::<64>(machine, Tick::OneMillisecond).unwrap();
        let half = N::saturated(0.5);
        let mut state: DriveState<N> =
            drive.at_rest(N::ZERO, ChamberState { a: N::saturated(0.4), b: N::saturated(0.6) }, N::travel(0.5));
        for _ in 0..ticks {
            drive.step(&mut state, DriveInput::Spool(Spool { from: half, to: half }), Load::NONE);
        }
        let closed = PumpDrive { speed: N::ZERO, direction: 0 };
        let flow = drive.flows_from(state.supply.pressure, half, closed, state.chambers).a.to_f64();
        let bases = drive.bases();
        [state.supply.pressure.to_f64() * bases.pressure_pa, flow * bases.flow_m3_per_s]
    }

    #[test]
    fn a_supply_without_memory_has_fallen_by_its_resistance_times_the_flow() {
        for [pressure_pa, flow] in [after::<f64>(&machine(0.0), 1000), after::<PerUnit>(&machine(0.0), 1000)] {
            assert!(flow > 1e-4, "{flow}");
            assert!((pressure_pa - (7e6 - 1e10 * flow)).abs() < 20.0, "{pressure_pa} at {flow}");
        }
    }

    #[test]
    fn a_steady_draw_brings_the_supply_down_by_63_percent_within_the_time_constant() {
        let drive = Drive::<PerUnit>::new::<64>(&machine(0.1), Tick::OneMillisecond).unwrap();
        let crate::drive::OilSource::Valve(_, edges) = &drive.source else { unreachable!() };
        let effects = edges.effects.unwrap();
        let droop = effects.droop.unwrap();
        let draw = Draw { flow: PerUnit::ONE, steepness: PerUnit::ZERO };
        let mut supply = SupplyState::at_rest(PerUnit::ONE);
        for _ in 0..100 {
            let (line, zero) = (PerUnit::ONE, PerUnit::ZERO);
            let after = droop.after::<ROUNDS_OF_STAGE>(supply, line, PerUnit::ONE, zero, effects.slope_scale, |_| draw);
            supply = after.supply;
        }
        let fall = 1e10 * drive.bases().flow_m3_per_s / 7e6;
        let exact = 1.0 - fall * (1.0 - libm::exp(-1.0));
        assert!((supply.pressure.to_f64() - exact).abs() < 1e-8, "{} {exact}", supply.pressure.to_f64());
    }

    #[test]
    fn what_others_take_brings_the_supply_down_as_the_drive_s_own_flow_does() {
        fn alone<N: Scalar<Real = f64>>(resistance: f64) -> f64 {
            let machine = machine(0.02).with(&[(P::DroopResistance, resistance)]);
            let drive = Drive::<N>::new::<64>(&machine, Tick::OneMillisecond).unwrap();
            let mut state: DriveState<N> =
                drive.at_rest(N::ZERO, ChamberState { a: N::saturated(0.4), b: N::saturated(0.6) }, N::travel(0.5));
            state.supply.other_flow = N::saturated(1e-4 / drive.bases().flow_m3_per_s);
            for _ in 0..1000 {
                drive.step(&mut state, DriveInput::Command(N::ZERO), Load::NONE);
            }
            state.supply.pressure.to_f64() * drive.bases().pressure_pa
        }
        for fallen_pa in [alone::<f64>(1e10), alone::<PerUnit>(1e10)] {
            assert!((fallen_pa - 6e6).abs() < 20.0, "{fallen_pa}");
        }
        for stiff_pa in [alone::<f64>(0.0), alone::<PerUnit>(0.0)] {
            assert!((stiff_pa - 7e6).abs() < 1.0, "{stiff_pa}");
        }
    }

    #[test]
    fn an_accumulator_remembers() {
        let [slow, _] = after::<PerUnit>(&machine(1.0), 20);
        let [quick, _] = after::<PerUnit>(&machine(0.0), 20);
        assert!(7e6 - slow < 0.05 * (7e6 - quick), "{slow} {quick}");
        let [settled, flow] = after::<PerUnit>(&machine(0.01), 1000);
        assert!((settled - (7e6 - 1e10 * flow)).abs() < 50.0, "{settled} at {flow}");
    }
}
