//! The flow out of B where only the flow into A is recorded.
//!
//! At constant pressures it is the share by area ratio. But when the rod reverses, both chambers of a differential
//! cylinder go to other pressures, and the oil that they store changes. Both edges of a valve belong to one spool, so
//! they are equally open, and the flow through each is proportional to the root of the pressure across it, (3) and (4):
//! if 1 enters A, √(Δpb/Δpa) leaves B. With the edges coupled in this way, the pressures stay where a valve holds them.
//!
//! With hardly any flow this would rectify a meter's noise, because the ratio differs between both directions. Then the
//! share by area ratio is used.

use model_core::machine::{Bases, Machine, Parameter, Source};
use model_core::number::{Field, Real};
use model_core::ports::{ChamberState, Flows};

/// Share of the full flow below which the flow out of B is the share by area ratio: twice a usual meter's noise, which is 0.5 %.
const HARDLY: f64 = 0.01;
/// The edge of A has at least this share of the supply pressure across it, so that the flow through it shows how far it is open.
const ACROSS: f64 = 0.01;
/// Pressure across the edge of B, as a share of the supply pressure, below which the root turns into a straight line.
const STRAIGHT: f64 = 1e-4;

/// State of the other links at the start of a tick, per unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Below<F> {
    /// Pressures of both chambers.
    pub(crate) pressures: ChamberState<F>,
    /// Velocity of the rod.
    pub(crate) velocity: F,
}

/// Coefficients of the flow through both edges of a valve, per unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<F> {
    supply: F,
    tank: F,
    /// Ab/Aa.
    ratio: F,
    /// Square of the flow below which there is hardly any.
    hardly: F,
    /// Pressure rise over a tick at flow 1, in A and in B.
    stiffness: (F, F),
}

impl<F: Field> Edges<F> {
    /// The edges of this drive; `None` for a pump drive, whose B is open to tank: its pressure hardly changes.
    pub(crate) fn of(machine: &Machine<F::Real>, bases: &Bases) -> Option<Self> {
        if machine.source != Source::Valve {
            return None;
        }
        let get = |parameter| F::coefficient(machine.get(parameter));
        let per = |value: F, base: f64| value / F::constant(base);
        let value = |parameter| machine.get(parameter).value();
        let full = value(Parameter::FlowCoefficient) * value(Parameter::SupplyPressure).sqrt();
        let hardly = HARDLY * full.min(value(Parameter::FlowLimit)) / bases.flow_m3_per_s;
        let per_tick = F::constant(bases.tick_s * bases.flow_m3_per_s / bases.pressure_pa);
        let stiffness =
            |volume| per_tick / (get(volume) / get(Parameter::BulkModulus) + get(Parameter::HoseCompliance));
        Some(Self {
            supply: per(get(Parameter::SupplyPressure), bases.pressure_pa),
            tank: per(get(Parameter::TankPressure), bases.pressure_pa),
            ratio: get(Parameter::AreaB) / get(Parameter::AreaA),
            hardly: F::constant((hardly * hardly).max(f64::MIN_POSITIVE)),
            stiffness: (stiffness(Parameter::VolumeA), stiffness(Parameter::VolumeB)),
        })
    }

    /// Flows at both ends of a tick, with the flow out of B through the valve's other edge, for these flows into A.
    pub(crate) fn through(&self, entering: (F, F), Below { pressures, velocity }: Below<F>) -> (Flows<F>, Flows<F>) {
        let begun = self.at(entering.0, pressures);
        let from = begun.leaving(begun.root(F::ZERO, F::ZERO));
        let a_ahead = pressures.a + self.stiffness.0 * (entering.0 - velocity);
        let ended = self.at(entering.1, ChamberState { a: a_ahead, b: pressures.b });
        let displaced = self.stiffness.1 * (self.ratio * velocity - ended.share);
        let root = ended.root(F::pick(ended.extends, displaced, -displaced), self.stiffness.1);
        let to = ended.leaving(root);
        // The tick uses the mean of both ends. The faster the pressure in B follows, the more weight its end needs.
        let follows = self.stiffness.1 * ended.opening;
        let magnitude = F::pick(root.above(F::ZERO), root, -root) + F::constant(STRAIGHT);
        let from = from + (to - from) * follows / (follows + F::constant(4.0) * magnitude);
        (Flows { a: entering.0, b: from }, Flows { a: entering.1, b: to })
    }

    /// The two parts of the flow out of B while this flow enters A.
    fn at(&self, entering: F, pressures: ChamberState<F>) -> Passing<F> {
        let extends = entering.above(F::ZERO);
        let across_a = F::pick(extends, self.supply - pressures.a, pressures.a - self.tank);
        let across = F::pick(extends, pressures.b - self.tank, self.supply - pressures.b);
        let square = entering * entering;
        let told = square / (square + self.hardly);
        let magnitude = F::pick(extends, entering, -entering);
        Passing {
            extends,
            share: entering * self.ratio * (F::ONE - told),
            opening: magnitude * told / across_a.larger(F::constant(ACROSS)).sqrt(),
            across,
        }
    }
}

/// The two parts of the flow out of B: the share by area ratio, for hardly any flow, and the flow through the edge.
#[derive(Clone, Copy, Debug)]
struct Passing<F: Field> {
    extends: F::Mask,
    share: F,
    /// Opening of the edge: flow per root of the pressure across it.
    opening: F,
    /// Pressure across it.
    across: F,
}

impl<F: Field> Passing<F> {
    /// Root of the pressure across the edge at the end of a tick, in which this pressure rises by `rises` and falls by
    /// `stiffness` times the flow. It is solved implicitly for the end, so it does not oscillate, however small the chamber.
    fn root(&self, rises: F, stiffness: F) -> F {
        let (all, half) = (self.across + rises, stiffness * self.opening);
        let magnitude = F::pick(all.above(F::ZERO), all, -all) + F::constant(STRAIGHT);
        (all + all) / (half + (half * half + F::constant(4.0) * magnitude).sqrt())
    }

    /// Flow out of B with this root.
    fn leaving(&self, root: F) -> F {
        let passes = self.opening * root;
        self.share + F::pick(self.extends, passes, -passes)
    }
}

#[cfg(test)]
mod tests {
    use test_press::press;

    use super::*;

    const RATIO: f64 = 0.6;

    fn edges() -> Edges<f64> {
        Edges { supply: 1.0, tank: 0.0, ratio: RATIO, hardly: 1e-8, stiffness: (0.1, 0.1) }
    }

    fn leaving(flow: f64, a: f64, b: f64) -> f64 {
        let passing = edges().at(flow, ChamberState { a, b });
        passing.leaving(passing.root(0.0, 0.0))
    }

    #[test]
    fn where_a_valve_holds_both_pressures_the_area_ratios_share_leaves() {
        // Both edges pass the displaced oil at pb = α²·(p0 − pa) extending, and at p0 − pb = α²·pa retracting.
        let (extending, retracting) =
            (leaving(0.1, 0.3, RATIO * RATIO * 0.7), leaving(-0.1, 0.3, 1.0 - RATIO * RATIO * 0.3));
        assert!((extending / 0.1 - RATIO).abs() < 1e-3, "{extending}");
        assert!((retracting / -0.1 - RATIO).abs() < 1e-3, "{retracting}");
    }

    #[test]
    fn what_is_hardly_a_flow_is_not_rectified() {
        let both = |flow: f64| leaving(flow, 0.3, 0.9) + leaving(-flow, 0.3, 0.9);
        assert!(both(1e-6).abs() < 1e-3 * RATIO * 1e-6, "{}", both(1e-6));
        assert!(both(1e-2).abs() > 0.1 * RATIO * 1e-2, "{}", both(1e-2));
    }

    #[test]
    fn a_chamber_that_empties_within_a_tick_does_not_swing() {
        let machine = press(&[(Parameter::VolumeB, 1e-6)]);
        let bases =
            Bases { pressure_pa: 7e6, flow_m3_per_s: 1e-3, tick_s: 2e-3, velocity_m_per_s: 0.3, ..bases_of_one() };
        let edges = Edges::<f64>::of(&machine, &bases).unwrap();
        let mut b = 0.2;
        for _ in 0..10 {
            let below = Below { pressures: ChamberState { a: 0.3, b }, velocity: 0.0 };
            let (from, to) = edges.through((0.1, 0.1), below);
            let end = b - edges.stiffness.1 * 0.5 * (from.b + to.b);
            assert!((-0.01..=b.max(0.0) + 0.01).contains(&end), "{b} {end}");
            b = end;
        }
    }

    fn bases_of_one() -> Bases {
        Bases {
            pressure_pa: 1.0,
            velocity_m_per_s: 1.0,
            flow_m3_per_s: 1.0,
            force_n: 1.0,
            stroke_m: 1.0,
            command_v: 1.0,
            pump_speed_rev_per_s: 1.0,
            temperature_c: 1.0,
            tick_s: 1.0,
        }
    }
}
