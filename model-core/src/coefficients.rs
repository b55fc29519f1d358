//! SI parameters → per-unit coefficients. Only this file and those below it convert, for host and target alike.

#![expect(clippy::float_arithmetic, reason = "coefficients are computed once, before a run, in real arithmetic")]

mod flow_effects;
mod valve_effects;

use crate::bases::{COMMAND_V, GAIN_AIM, PUMP_SPEED_REV_PER_S, SPRUNG, bases, inertia, smaller_capacity};
use crate::chambers::Chambers;
use crate::drive::{Drive, OilSource};
use crate::flow::{Edges, Flows, Lines, Pump};
use crate::machine::{Bases, Machine, MachineError, Source, Tick};
use crate::mechanics::{GAMMA, Mechanics};
use crate::number::{Number, Real};
use crate::parameter::Parameter as P;
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
        };
        let mechanics = builder.mechanics::<N>(builder.sprung_mass())?;
        let unsprung = builder.mechanics::<N>(builder.get(P::MovingMass))?;
        let [spring_a, spring_b] = builder.springs::<N>().map_err(|error| builder.with_cause(error))?;
        Ok(Drive {
            source,
            chambers: builder.chambers().map_err(|error| builder.with_cause(error))?,
            mechanics,
            unsprung,
            gamma: builder.gain::<N>("the step's γ", P::Stroke, N::Real::constant(GAMMA))?,
            springs: [spring_a, spring_b],
            bases: builder.bases,
        })
    }
}

/// What the magnitude of a gain must stay below.
const GAIN_LIMIT: f64 = 4.0;
/// Share of a pressure difference that leakage evens within a tick, from where on it is solved for. Explicit, a share of 2 is
/// unstable.
const FAST_LEAKAGE: f64 = 0.5;

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

    /// The oil spring where it is what leaves no scale that fits, else the error as it is.
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
            least_kg: turn_inertia / limit - GAMMA * self.tick_s * machine.get(P::ViscousFriction),
            times: turn / limit,
        }
    }

    fn gain<N: Number<Real = R>>(&self, name: &'static str, of: P, value: R) -> Result<N::Gain, MachineError> {
        N::gain(value).ok_or_else(|| self.misfit(name, of, value, GAIN_LIMIT))
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
        let delay = self.get(P::TransportDelay) / R::constant(self.tick_s);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0..1 s over a tick is a small count"
        )]
        let delay_ticks = delay.value() as usize;
        if delay_ticks + 2 > line {
            return Err(MachineError::DelayTooLong {
                value: self.get(P::TransportDelay).value(),
                ticks: delay_ticks + 2,
                line,
            });
        }
        let step_limit = self.get(P::RateLimit) * R::constant(self.tick_s);
        let limits = N::signal(step_limit).is_some();
        let half_per_step = if limits { R::constant(0.5) / step_limit } else { R::ZERO };
        let (t1, t2) = (self.get(P::TimeConstant1), self.get(P::TimeConstant2));
        let (decay_1, decay_2) = (self.decay(t1), self.decay(t2));
        let apart = t1 - t2;
        let cross = if apart.value().abs() > 1e-6 * t1.value().max(t2.value()) {
            t1 * (decay_1 - decay_2) / apart
        } else if t1.value() > 0.0 {
            R::constant(self.tick_s) / t1 * decay_1
        } else {
            R::ZERO
        };
        Ok(Valve {
            gain: self.gain::<N>(
                "slider travel per 10 V",
                P::ValveGain,
                self.get(P::ValveGain) * R::constant(COMMAND_V),
            )?,
            offset: self.signal("slider offset", P::ValveOffset, self.get(P::ValveOffset))?,
            step_limit: Self::limit(step_limit),
            half_per_step: self.steep::<N>("inverse of the rate limit per tick", P::RateLimit, half_per_step)?,
            delay_ticks,
            delay_rest: self.signal("rest of the delay", P::TransportDelay, delay - R::constant(delay_ticks as f64))?,
            decay_1: self.gain::<N>("decay of the first lag", P::TimeConstant1, decay_1)?,
            decay_2: self.gain::<N>("decay of the second lag", P::TimeConstant2, decay_2)?,
            cross: self.gain::<N>("coupling of the lags", P::TimeConstant1, cross)?,
            effects: self.valve_effects(R::ONE - decay_2 - cross)?,
        })
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

    fn transition<N: Number<Real = R>>(&self) -> Result<N, MachineError> {
        let pressure = self.get(P::LaminarTransition) + self.get(P::LaminarPressure);
        let pressure = pressure / R::constant(self.bases.pressure_pa);
        self.signal("laminar transition", P::LaminarTransition, pressure)
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
            transition: self.transition()?,
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

    /// h·Q/(p·C): pressure rise over a tick at flow 1, for a chamber of capacity V/E0 + hose. (7)
    fn stiffness(&self, volume: P) -> R {
        R::constant(self.tick_s * self.bases.flow_m3_per_s / self.bases.pressure_pa) / self.capacity(volume)
    }

    /// α = Ab/Aa. (5)
    fn ratio(&self) -> R {
        self.get(P::AreaB) / self.get(P::AreaA)
    }

    fn chambers<N: Number<Real = R>>(&self) -> Result<Chambers<N>, MachineError> {
        let (a, b) = (self.stiffness(P::VolumeA), self.stiffness(P::VolumeB));
        let gamma = R::constant(GAMMA);
        let leakage = self.get(P::InternalLeakage) * R::constant(self.bases.pressure_pa / self.bases.flow_m3_per_s);
        Ok(Chambers {
            stiffness_a: self.gain::<N>("pressure rise in A per tick at full flow", P::VolumeA, a)?,
            stiffness_b: self.gain::<N>("pressure rise in B per tick at full flow", P::VolumeB, b)?,
            implicit: Flows {
                a: self.signal("pressure rise in A per tick at full flow", P::VolumeA, gamma * a)?,
                b: self.signal("pressure rise in B per tick at full flow", P::VolumeB, gamma * b)?,
            },
            ratio: self.gain::<N>("area ratio B/A", P::AreaB, self.ratio())?,
            leakage: self.signal("leakage at supply pressure", P::InternalLeakage, leakage)?,
            leaks_fast: (leakage * (a + b)).value() > FAST_LEAKAGE,
            unity: self.steep::<N>("one", P::VolumeA, R::ONE)?,
        })
    }

    /// Compressibility of a chamber: V/E0 and its hose. (7)
    fn capacity(&self, volume: P) -> R {
        self.get(volume) / self.get(P::BulkModulus) + self.get(P::HoseCompliance)
    }

    /// The mass at which the step turns the oil spring as fast as the moving mass turns it in truth.
    ///
    /// One step multiplies a mode by R(z) = eᶻ + (γ − γ² − 1/6)·z³ + …, so an oil spring of K on m, with θ² = h²·K/m, turns
    /// slower by (γ − γ² − 1/6)·θ²; a mass smaller by twice that makes up for it. Of second order like the step itself, it
    /// fades where there is no ringing to keep: under strong damping, D² ≫ K·m, and where the step resolves none, θ > 1.
    fn sprung_mass(&self) -> R {
        let mass = self.get(P::MovingMass);
        let side = |area: P, volume: P| self.get(area) * self.get(area) / self.capacity(volume);
        let spring = side(P::AreaA, P::VolumeA) + side(P::AreaB, P::VolumeB);
        let damping = self.get(P::ViscousFriction);
        let turn = R::constant(self.tick_s * self.tick_s) * spring / mass;
        let fading = R::ONE + damping * damping / (spring * mass) + turn * turn;
        mass / (R::ONE + R::constant(2.0 * (GAMMA - GAMMA * GAMMA - 1.0 / 6.0)) * turn / fading)
    }

    /// h·D/m
    fn damping(&self, mass: R) -> R {
        self.get(P::ViscousFriction) * R::constant(self.tick_s) / mass
    }

    /// 1 + γ·h·D/m
    fn own_diagonal(&self, mass: R) -> R {
        R::ONE + R::constant(GAMMA) * self.damping(mass)
    }

    /// Velocity gained per tick at force 1, implicit in the viscous friction. (12)
    fn mobility(&self, mass: R) -> R {
        R::constant(self.tick_s * self.bases.force_n / self.bases.velocity_m_per_s) / (mass * self.own_diagonal(mass))
    }

    fn springs<N: Number<Real = R>>(&self) -> Result<[N::Steep; 2], MachineError> {
        let square = R::constant(GAMMA * GAMMA) * self.mobility(self.sprung_mass());
        let ratio = self.ratio();
        Ok([
            self.steep::<N>("oil spring A", P::MovingMass, square * self.stiffness(P::VolumeA))?,
            self.steep::<N>("oil spring B", P::MovingMass, square * ratio * ratio * self.stiffness(P::VolumeB))?,
        ])
    }

    fn mechanics<N: Number<Real = R>>(&self, mass: R) -> Result<Mechanics<N>, MachineError> {
        let constant = |value: f64| self.gain::<N>("a weight of the step", P::Stroke, R::constant(value));
        let force = R::constant(self.bases.force_n);
        let coulomb = self.get(P::CoulombFriction) / force;
        let travel = R::constant(self.tick_s * self.bases.velocity_m_per_s) / self.get(P::Stroke);
        Ok(Mechanics {
            mobility: self.gain::<N>("velocity gained per tick at full force", P::MovingMass, self.mobility(mass))?,
            drag: self.gain::<N>(
                "velocity lost per tick",
                P::ViscousFriction,
                self.damping(mass) / self.own_diagonal(mass),
            )?,
            back: self.gain::<N>("second stage", P::ViscousFriction, -(R::constant(2.0) / self.own_diagonal(mass)))?,
            mean: [constant(f64::midpoint(1.0, GAMMA))?, constant(0.5 * GAMMA)?],
            weights: [constant(1.5)?, constant(0.5)?],
            unity: constant(1.0)?,
            travel: self.gain::<N>("strokes per tick", P::Stroke, travel)?,
            coulomb: self.signal("dry friction over full force", P::CoulombFriction, coulomb)?,
            coulomb_turn: self.signal(
                "velocity that dry friction takes in a tick",
                P::CoulombFriction,
                R::constant(2.0) * coulomb * self.mobility(mass),
            )?,
            load: self.signal("load over full force", P::LoadForce, self.get(P::LoadForce) / force)?,
        })
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use crate::fixed_point::PerUnit;

    /// A 63/40 × 300 mm cylinder that moves next to nothing, without friction.
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
