//! SI parameters → per-unit coefficients. Only this file and those below it convert, for host and target alike.

#![expect(clippy::float_arithmetic, reason = "coefficients are computed once, before a run, in real arithmetic")]

pub(crate) mod bases;
mod chambers;
mod correction_table;
mod flow_effects;
mod lags;
mod mechanics;
mod oil;
mod sensors;
mod valve_effects;

use crate::chambers::Chambers;
use crate::coefficients::bases::{
    GAIN_AIM, PUMP_SPEED_REV_PER_S, SPRUNG, bases, inertia, least_drag, smaller_capacity,
};
use crate::drive::{Drive, OilSource, StageWeights};
use crate::flow::{Edges, Lines, Pump};
use crate::machine::{Bases, Machine, MachineError, Parameter as P, Source, Tick};
use crate::mechanics::GAMMA;
use crate::number::{Number, Real};
use crate::valve::Valve;

impl<N: Number> Drive<N> {
    /// The coefficients of `machine` at `tick`, for states whose delay line holds `DELAY` ticks.
    ///
    /// # Errors
    /// A parameter is out of its range, or a coefficient does not fit the number format; the error says which value.
    pub fn new<const DELAY: usize>(machine: &Machine<N::Real>, tick: Tick) -> Result<Self, MachineError> {
        machine.map(Real::value).check()?;
        let builder = Builder { machine, tick_s: tick.seconds(), bases: bases(&machine.map(Real::value), tick) };
        let source = match machine.source {
            Source::Valve => OilSource::Valve(builder.valve::<N>(DELAY)?, builder.edges()?),
            Source::Pump => OilSource::Pump(builder.pump()?),
            Source::Force => OilSource::None,
        };
        let is_sprung = !matches!(source, OilSource::None);
        let mass = if is_sprung { builder.sprung_mass() } else { builder.get(P::MovingMass) };
        let mechanics = builder.mechanics::<N>(mass)?;
        let unsprung = builder.mechanics::<N>(builder.get(P::MovingMass))?;
        let chambers: Chambers<N> = if is_sprung {
            builder.chambers().map_err(|error| builder.with_cause(error))?
        } else {
            builder.no_chambers()?
        };
        let (sensors, viscosity, unnamed) =
            (builder.sensors::<N>(DELAY)?, builder.viscosity()?, builder.unnamed::<N>()?);
        let plain = matches!(&source, OilSource::Valve(valve, edges) if valve.effects.are_off() && edges.effects.is_none())
            && chambers.effects.are_off()
            && mechanics.effects.are_off()
            && !mechanics.hard
            && !sensors.follows()
            && viscosity.is_none()
            && unnamed.is_none();
        Ok(Drive {
            source,
            chambers,
            mechanics,
            unsprung,
            weights: builder.weights()?,
            sensors,
            viscosity,
            unnamed,
            plain,
            bases: builder.bases,
        })
    }
}

/// What the magnitude of a gain must stay below.
const GAIN_LIMIT: f64 = 4.0;
struct Builder<'a, R> {
    machine: &'a Machine<R>,
    tick_s: f64,
    bases: Bases,
}

impl<R: Real> Builder<'_, R> {
    fn get(&self, parameter: P) -> R {
        self.machine.get(parameter)
    }

    fn misfit(&self, coefficient: &'static str, parameter: P, scaled: R, limit: f64) -> MachineError {
        MachineError::DoesNotFit {
            parameter,
            value: self.get(parameter).value(),
            coefficient,
            scaled: scaled.value(),
            limit,
        }
    }

    /// An error about the oil spring, where the oil spring is why no scale fits; else the error as it is.
    ///
    /// `bases` lets the velocity gained per tick fit first, so that too fast an oil spring shows in the chambers' pressure rise.
    fn with_cause(&self, error: MachineError) -> MachineError {
        let machine = self.machine.map(Real::value);
        let turn_inertia =
            self.tick_s * self.tick_s * machine.get(P::AreaA) * machine.get(P::AreaA) / smaller_capacity(&machine);
        let limit = GAIN_LIMIT * GAIN_AIM / SPRUNG;
        let turn = turn_inertia / inertia(&machine, self.tick_s);
        if turn <= limit {
            return error;
        }
        MachineError::OilSpringTooFast {
            mass_kg: machine.get(P::MovingMass),
            tick_s: self.tick_s,
            turn,
            limit,
            least_kg: turn_inertia / limit
                - GAMMA * self.tick_s * machine.get(P::ViscousFriction) * least_drag(&machine),
            times: turn / limit,
        }
    }

    fn gain<N: Number<Real = R>>(&self, name: &'static str, of: P, value: R) -> Result<N::Gain, MachineError> {
        N::gain(value).ok_or_else(|| self.misfit(name, of, value, GAIN_LIMIT))
    }

    fn weights<N: Number<Real = R>>(&self) -> Result<StageWeights<N>, MachineError> {
        let weight = |value: f64| self.gain::<N>("a weight of the step", P::Stroke, R::constant(value));
        Ok(StageWeights { rest: weight(1.0 - GAMMA)?, half: weight(0.5)? })
    }

    fn steep<N: Number<Real = R>>(&self, name: &'static str, of: P, value: R) -> Result<N::Steep, MachineError> {
        N::steep(value).ok_or_else(|| self.misfit(name, of, value, 65536.0))
    }

    fn signal<N: Number<Real = R>>(&self, name: &'static str, of: P, value: R) -> Result<N, MachineError> {
        N::signal(value).ok_or_else(|| self.misfit(name, of, value, 8.0))
    }

    /// A limit: infinite, or beyond the format, means that nothing limits.
    fn limit<N: Number<Real = R>>(value: R) -> N {
        N::signal(value).unwrap_or_else(|| N::saturated(value.value()))
    }

    fn valve<N: Number<Real = R>>(&self, line: usize) -> Result<Valve<N>, MachineError> {
        let (delay_ticks, delay_rest) = self.delay(P::TransportDelay, line)?;
        let step_limit = self.get(P::RateLimit) * R::constant(self.tick_s);
        let limits = N::signal(step_limit).is_some();
        let half_per_step = if limits { R::constant(0.5) / step_limit } else { R::ZERO };
        let lags = self.lags(delay_rest);
        Ok(Valve {
            gain: self.gain::<N>(
                "spool travel per command of 1",
                P::ValveGain,
                self.get(P::ValveGain) * R::constant(self.bases.command_v),
            )?,
            offset: self.signal("spool offset", P::ValveOffset, self.get(P::ValveOffset))?,
            step_limit: Self::limit(step_limit),
            half_per_step: self.steep::<N>("inverse of the rate limit per tick", P::RateLimit, half_per_step)?,
            delay_ticks,
            delay_rest: self.signal("rest of the delay", P::TransportDelay, delay_rest)?,
            decay_1: self.gain::<N>("decay of the first lag", P::TimeConstant1, lags.decay_1)?,
            decay_2: self.gain::<N>("decay of the second lag", P::TimeConstant2, lags.decay_2)?,
            cross: self.gain::<N>("coupling of the lags", P::TimeConstant1, lags.cross)?,
            effects: self.valve_effects(&lags)?,
        })
    }

    /// A delay in whole ticks, for which the line is long enough, and the remainder of the delay in ticks.
    fn delay(&self, of: P, line: usize) -> Result<(usize, R), MachineError> {
        let delay = self.get(of) / R::constant(self.tick_s);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0..1 s over a tick is a small count"
        )]
        let whole = delay.value() as usize;
        if whole + 2 > line {
            return Err(MachineError::DelayTooLong {
                parameter: of,
                value: self.get(of).value(),
                ticks: whole + 2,
                line,
            });
        }
        Ok((whole, delay - R::constant(whole as f64)))
    }

    /// e^(−h/T), 0 for no lag.
    fn decay(&self, time_constant: R) -> R {
        if time_constant.value() > 0.0 { (-(R::constant(self.tick_s) / time_constant)).exp() } else { R::ZERO }
    }

    fn lines<N: Number<Real = R>>(&self) -> Result<Lines<N>, MachineError> {
        let base = R::constant(self.bases.pressure_pa);
        Ok(Lines {
            supply: self.signal("supply pressure", P::SupplyPressure, self.get(P::SupplyPressure) / base)?,
            tank: self.signal("tank pressure", P::TankPressure, self.get(P::TankPressure) / base)?,
        })
    }

    /// Per unit.
    fn transition_pressure(&self) -> R {
        (self.get(P::LaminarTransition) + self.get(P::LaminarPressure)) / R::constant(self.bases.pressure_pa)
    }

    fn transition<N: Number<Real = R>>(&self) -> Result<N, MachineError> {
        self.signal("laminar transition", P::LaminarTransition, self.transition_pressure())
    }

    /// `K_Q` per unit.
    fn orifice(&self, coefficient: P) -> R {
        self.get(coefficient) * R::constant(self.bases.pressure_pa).sqrt() / R::constant(self.bases.flow_m3_per_s)
    }

    fn edges<N: Number<Real = R>>(&self) -> Result<Edges<N>, MachineError> {
        Ok(Edges {
            overlap: self.overlap()?,
            gain: self.gain::<N>("flow at full opening", P::FlowCoefficient, self.orifice(P::FlowCoefficient))?,
            limit: Self::limit(self.get(P::FlowLimit) / R::constant(self.bases.flow_m3_per_s)),
            unity: self.steep::<N>("one", P::FlowLimit, R::ONE)?,
            transition: self.transition()?,
            turbulent: Self::limit(R::constant(256.0) * self.transition_pressure()),
            lines: self.lines()?,
            effects: self.edge_effects()?,
        })
    }

    fn pump<N: Number<Real = R>>(&self) -> Result<Pump<N>, MachineError> {
        let flow = R::constant(self.bases.flow_m3_per_s);
        let full_speed = self.get(P::PumpDisplacement) * R::constant(PUMP_SPEED_REV_PER_S) / flow;
        let slip = self.get(P::PumpSlip) * R::constant(self.bases.pressure_pa) / flow;
        Ok(Pump {
            into_a: self.gain::<N>("pump flow at 50 revolutions per second", P::PumpDisplacement, full_speed)?,
            into_b: self.gain::<N>(
                "pump flow into B at 50 revolutions per second",
                P::PumpReverseRatio,
                full_speed * self.get(P::PumpReverseRatio),
            )?,
            slip: self.signal("slip at supply pressure", P::PumpSlip, slip)?,
            back: self.signal(
                "return flow at supply pressure",
                P::ReturnCoefficient,
                self.orifice(P::ReturnCoefficient),
            )?,
            transition: self.transition()?,
            lines: self.lines()?,
            unity: self.steep::<N>("one", P::PumpDisplacement, R::ONE)?,
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::number::PerUnit;

    /// A 63/40 × 300 mm cylinder that moves almost no mass, without friction.
    fn light() -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        for (parameter, value) in [
            (P::AreaA, 3.117e-3),
            (P::AreaB, 1.861e-3),
            (P::VolumeA, 5.2e-4),
            (P::VolumeB, 3.3e-4),
            (P::ViscousFriction, 0.0),
            (P::MovingMass, 0.02),
        ] {
            machine.set(parameter, value);
        }
        machine
    }

    fn refusal(machine: &Machine<f64>, tick: Tick) -> Option<MachineError> {
        Drive::<PerUnit>::new::<64>(machine, tick).err()
    }

    /// A nonlinear flow gain and large edges together may open further than the format holds, where neither does alone.
    #[test]
    fn an_opening_that_is_too_large_is_refused_by_what_makes_most_of_it() {
        let with = |linear: f64, ratio: f64| {
            let sizes = [(P::FlowGainLinear, linear), (P::MeteringRatio, ratio), (P::MovingMass, 50.0)];
            refusal(&light().with(&sizes), Tick::OneMillisecond)
        };
        for (linear, ratio, of) in [(1.0, 3.5, P::MeteringRatio), (3.5, 1.0, P::FlowGainLinear)] {
            let error = with(linear, ratio).unwrap();
            let MachineError::DoesNotFit { parameter, coefficient, scaled, .. } = error else { panic!("{error}") };
            assert_eq!((parameter, coefficient), (of, "opening at full travel with its effects"));
            assert!((scaled - 9.0).abs() < 1e-9, "{scaled}");
        }
        assert_eq!(with(0.0, 3.5), None);
        assert_eq!(with(1.0, 0.0), None);
    }

    #[test]
    fn too_fast_an_oil_spring_is_refused_by_its_mass_and_what_is_said_to_fit_does() {
        let machine = light();
        let error = refusal(&machine, Tick::OneMillisecond).unwrap();
        let MachineError::OilSpringTooFast { mass_kg, least_kg, times, turn, .. } = error else { panic!("{error}") };
        assert!((mass_kg - 0.02).abs() < 1e-12);
        // h²·Aa²·E0/(Vb·m)
        assert!((turn / (1e-6 * 3.117e-3 * 3.117e-3 * 1.2e9 / 3.3e-4 / 0.02) - 1.0).abs() < 1e-9);
        let text = std::format!("{error}");
        assert!(text.starts_with("cylinder.moving_mass_kg = 0.02 kg") && text.contains("shorter tick"), "{text}");

        let mut heavier = machine;
        heavier.set(P::MovingMass, 1.001 * least_kg);
        assert_eq!(refusal(&heavier, Tick::OneMillisecond), None);
        let mut larger = machine;
        for volume in [P::VolumeA, P::VolumeB] {
            larger.set(volume, 1.001 * times * machine.get(volume));
        }
        assert_eq!(refusal(&larger, Tick::OneMillisecond), None);
        heavier.set(P::MovingMass, 0.99 * least_kg);
        assert!(matches!(refusal(&heavier, Tick::OneMillisecond), Some(MachineError::OilSpringTooFast { .. })));
        assert_eq!(refusal(&heavier, Tick::HalfMillisecond), None);
    }

    #[test]
    fn a_chamber_too_small_for_its_flow_is_refused_by_its_volume() {
        let mut machine = light();
        machine.set(P::MovingMass, 1e4);
        machine.set(P::VolumeB, 1e-6);
        let error = refusal(&machine, Tick::OneMillisecond).unwrap();
        assert!(matches!(error, MachineError::DoesNotFit { parameter: P::VolumeB, .. }), "{error}");
    }
}
