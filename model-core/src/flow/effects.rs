//! Effects of the flow link: what the openings of the four metering edges have beyond the paper's dead zone.
//!
//! Everything here is in spool travel, before the flow gain `K_Q`. Each is `None` where its amount is 0; where all are,
//! and the supply does not droop, the flow link does not use this module at all.

use crate::effects::LinkEffects;
use crate::flow::load_holding::{LoadHolding, Poppets};
use crate::flow::opened::Four;
use crate::flow::supply::Droop;
use crate::number::{Mask, Number};

/// Coefficients of the edges' effects.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
pub struct EdgeEffects<N: Number> {
    #[doc(hidden)]
    pub curve: Option<GainCurve<N>>,
    #[doc(hidden)]
    pub sizes: EdgeSizes<N>,
    #[doc(hidden)]
    pub return_line: Option<ReturnLine<N>>,
    /// `tank-back-pressure`, its laminar part: half the return line's pressure drop per flow.
    #[doc(hidden)]
    pub half_laminar: Option<N::Gain>,
    #[doc(hidden)]
    pub leakage: Option<ValveLeakage<N>>,
    #[doc(hidden)]
    pub rounding: Option<RoundedEdge<N>>,
    #[doc(hidden)]
    pub droop: Option<Droop<N>>,
    #[doc(hidden)]
    pub holding: Option<LoadHolding<N>>,
    /// 1/`SLOPE_SCALE`: steepnesses are stored smaller by this factor, so that they fit a signal.
    #[doc(hidden)]
    pub slope_fraction: N,
    /// `SLOPE_SCALE`
    #[doc(hidden)]
    pub slope_scale: N::Steep,
}

/// Divisor with which an opening times its root's slope fits a signal: 8192 at most; a root has 2600 at Δp = 0 with the
/// machine's least laminar transition. Resolution 4e-6, finer than the slope itself.
pub(crate) const SLOPE_SCALE: f64 = 1024.0;

impl<N: Number> LinkEffects for EdgeEffects<N> {}

impl<N: Number> EdgeEffects<N> {
    /// Metering openings of either direction, not negative, with a spool this far from where it opens an edge: extending, retracting.
    #[inline]
    pub(crate) fn metered(&self, past_edges: [N; 2]) -> [N; 2] {
        past_edges.map(|travel| {
            let beyond = self.rounding.as_ref().map_or_else(|| travel.max(N::ZERO), |edge| edge.opening(travel));
            self.curve.as_ref().map_or(beyond, |curve| curve.opening(beyond))
        })
    }

    /// Opening of every edge in addition to its metering opening.
    #[inline]
    pub(crate) fn leaking(&self, spool: N) -> N {
        self.leakage.as_ref().map_or(N::ZERO, |leakage| leakage.opening(spool))
    }

    /// Openings with the load-holding valves behind them.
    #[inline]
    pub(super) fn behind_holding(&self, openings: &Four<N>, poppets: Poppets<N>, across: &Four<N>) -> Four<N> {
        self.holding.as_ref().map_or(*openings, |holding| holding.held(openings, poppets, across))
    }

    /// Opening of a tank edge with the return line behind it; nothing is computed of a closed one.
    #[inline]
    pub(crate) fn behind_line(&self, edge: N) -> N {
        let Some(line) = &self.return_line else { return edge };
        let closed = edge.is_nothing();
        closed.branch(|| N::ZERO, || line.opening(edge), |_, opening| N::pick(closed, N::ZERO, opening))
    }
}

/// `metering-asymmetry`: by which share the metering openings of the other edges exceed that of P-A. −1..4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct EdgeSizes<N: Number> {
    pub tank_a: Option<N::Gain>,
    pub supply_b: Option<N::Gain>,
    pub tank_b: Option<N::Gain>,
}

impl<N: Number> EdgeSizes<N> {
    /// Whether all edges have the same size.
    pub(crate) const fn are_one(&self) -> bool {
        self.tank_a.is_none() && self.supply_b.is_none() && self.tank_b.is_none()
    }

    /// A metering opening of the edge with that excess.
    #[inline]
    pub(crate) fn sized(excess: Option<N::Gain>, metered: N) -> N {
        match excess {
            Some(excess) => metered + N::dot([excess], [metered]),
            None => metered,
        }
    }
}

/// `flow-gain-nonlinearity`: o becomes o·(1 + linear·o) + beyond·max(0, o − notch), held where it would change its sign.
///
/// o is the travel beyond the dead zone: `linear` bends the characteristic of the whole edge, `beyond` is the full edge that follows a notch.
/// Two steps (7.5e-9) of error. Notched edges: Jelali & Kroll 2003, ch. 4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct GainCurve<N: Number> {
    /// A quarter of both coefficients, which may be as large as 10.
    pub quarters: [N::Gain; 2],
    /// Opening at which the notch ends.
    pub notch: N,
}

impl<N: Number> GainCurve<N> {
    #[inline]
    fn opening(&self, beyond: N) -> N {
        let quarter = N::dot(self.quarters, [beyond.times(beyond), (beyond - self.notch).max(N::ZERO)]);
        let half = quarter + quarter;
        (beyond + half + half).max(N::ZERO)
    }
}

/// `tank-back-pressure`, its turbulent part: the return line, an orifice in series with the tank edge, o becomes o/√(1 + R·o²).
///
/// With Q = o·√(p − pr) and pr − pt = R·Q², the pressure pr between them is eliminated: Q = o/√(1 + R·o²)·√(p − pt). So each chamber
/// has its own line; this is valid because only one of them returns at a time. R per unit, `K_Q`² included; error a step and 1e-8 of the opening.
/// Two orifices in series: Merritt 1967, ch. 3.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct ReturnLine<N: Number> {
    pub resistance: N::Gain,
}

impl<N: Number> ReturnLine<N> {
    #[inline]
    fn opening(&self, edge: N) -> N {
        edge.over_root_of_one_plus(N::dot([self.resistance], [edge.times(edge)]))
    }
}

/// Flow of an orifice with a laminar line behind it, per opening: with a pressure drop of 2·ℓ·Q in the line,
/// Q = o·(√(Δp + (ℓ·o)²) − ℓ·o). As a difference of two regular roots it is odd, and 0 at Δp = 0. `reduced` is ℓ·o.
///
/// The slope is that of the first root, which is steeper than the true chord.
#[inline]
pub(crate) fn behind_laminar_line<N: Number>(across: N, reduced: N, transition: N) -> (N, N::Steep) {
    let square = reduced.times(reduced);
    let (whole, slope) = (across.magnitude() + square).orifice_root(transition);
    let (part, _) = square.orifice_root(transition);
    let root = (whole - part).max(N::ZERO);
    (across.select_positive(root, -root), slope)
}

/// `valve-leakage`: in addition to its metering opening, every edge is open by `opening`/(1 + (x/reach)²).
///
/// x is the spool's travel from the centre. Turbulent like the edges themselves, and limited with them. Error 2e-8 of the opening,
/// and 2e-9/reach² of it where x is about as large as reach. The leakage flow of a worn or underlapped spool: Merritt 1967, 5-4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct ValveLeakage<N: Number> {
    pub opening: N,
    /// 1/reach²
    pub narrowness: N::Steep,
}

impl<N: Number> ValveLeakage<N> {
    #[inline]
    fn opening(&self, spool: N) -> N {
        self.opening.times(N::inverse_one_plus([spool.times(spool)], [self.narrowness]))
    }
}

/// `valve-leakage`, its rounded edges: a spool that has moved b past an edge opens it by (b + √(b² + c²))/2 in place of max(0, b).
///
/// Far open it is b, at the edge c/2, and covered by far c²/4|b|: what leaks through the play of the spool falls with the length of its overlap.
/// Error 1.5e-8 of full travel. Radial clearance and rounded corners: Merritt 1967, 5-2; leakage over an overlap: ibid., 5-4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(bound = "N: crate::number::Written"))]
#[doc(hidden)]
pub struct RoundedEdge<N: Number> {
    /// c
    pub rounding: N,
}

impl<N: Number> RoundedEdge<N> {
    #[inline]
    fn opening(&self, travel: N) -> N {
        // With s = (b² + c²)^-¼, √(b² + c²) = (s·b)² + (s·c)².
        let ((along, _), (across, _)) =
            (travel.orifice_root(self.rounding), self.rounding.orifice_root(travel.magnitude()));
        let hypotenuse = along.times(along) + across.times(across);
        (travel + hypotenuse).halved().max(N::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use crate::drive::Drive;
    use crate::flow::PumpDrive;
    use crate::machine::{Machine, MachineError, Parameter as P, Source, Tick};
    use crate::number::{Number, PerUnit};
    use crate::ports::{ChamberState, Flows};

    fn machine(changes: &[(P, f64)]) -> Machine<f64> {
        let mut machine = Machine::with_defaults(Source::Valve);
        let cylinder = [(P::AreaA, 3e-3), (P::AreaB, 2e-3), (P::VolumeA, 5e-4), (P::VolumeB, 3e-4)];
        for &(parameter, value) in cylinder.iter().chain(changes) {
            machine.set(parameter, value);
        }
        machine
    }

    /// Flows over `K_Q`·√p0 at a spool, with the chambers at 1/4 (A) and 4/9 (B) of the supply.
    fn flows(changes: &[(P, f64)], spool: f64) -> Flows<f64> {
        let machine = machine(changes);
        let drive = Drive::<PerUnit>::new::<64>(&machine, Tick::OneMillisecond).unwrap();
        let pressures = ChamberState { a: PerUnit::saturated(0.25), b: PerUnit::saturated(4.0 / 9.0) };
        let closed = PumpDrive { speed: PerUnit::ZERO, direction: 0 };
        let found = drive.flows(PerUnit::saturated(spool), closed, pressures);
        let full = machine.get(P::FlowCoefficient) * libm::sqrt(7e6) / drive.bases().flow_m3_per_s;
        Flows { a: found.a.to_f64() / full, b: found.b.to_f64() / full }
    }

    fn assert_near(found: Flows<f64>, [a, b]: [f64; 2]) {
        // 2 kPa of laminar transition change a root by at most 1e-6 of itself here.
        assert!((found.a - a).abs() < 1e-6 && (found.b - b).abs() < 1e-6, "{found:?}, expected {a} {b}");
    }

    /// √(1 − 1/4) and √(1 − 4/9): roots over the supply edges; those over the tank edges are 1/2 and 2/3.
    const FROM_SUPPLY: [f64; 2] = [0.866_025_403_8, 0.745_355_992_5];

    #[test]
    fn the_dead_zones_differ_by_the_difference() {
        let changes = [(P::DeadZone, 0.2), (P::DeadZoneDifference, 0.1)];
        assert_near(flows(&changes, 0.25), [0.0, 0.0]);
        assert_near(flows(&changes, 0.45), [0.2 * FROM_SUPPLY[0], 0.2 * 2.0 / 3.0]);
        assert_near(flows(&changes, -0.35), [-0.2 * 0.5, -0.2 * FROM_SUPPLY[1]]);
    }

    #[test]
    fn a_flow_gain_bends_and_rises_beyond_its_notch_and_never_turns() {
        let changes = [(P::FlowGainLinear, 0.5), (P::FlowGainBeyond, 1.0), (P::FlowGainNotch, 0.375)];
        // 0.5·(1 + 0.25) + 0.125
        assert_near(flows(&changes, 0.5), [0.75 * FROM_SUPPLY[0], 0.75 * 2.0 / 3.0]);
        assert_near(flows(&changes, -0.5), [-0.75 * 0.5, -0.75 * FROM_SUPPLY[1]]);
        assert_near(flows(&[(P::FlowGainLinear, -0.9), (P::FlowGainBeyond, -0.9)], 0.9), [0.0, 0.0]);
    }

    #[test]
    fn only_the_tank_edges_grow_with_the_metering_ratio() {
        let changes = [(P::MeteringRatio, 0.5)];
        assert_near(flows(&changes, 0.5), [0.5 * FROM_SUPPLY[0], 0.75 * 2.0 / 3.0]);
        assert_near(flows(&changes, -0.5), [-0.75 * 0.5, -0.5 * FROM_SUPPLY[1]]);
    }

    #[test]
    fn ports_and_directions_have_edges_of_their_own_size() {
        let b_half = [(P::MeteringPorts, -0.5)];
        assert_near(flows(&b_half, 0.5), [0.5 * FROM_SUPPLY[0], 0.25 * 2.0 / 3.0]);
        assert_near(flows(&b_half, -0.5), [-0.5 * 0.5, -0.25 * FROM_SUPPLY[1]]);
        let slower_in = [(P::MeteringDirections, -0.5)];
        assert_near(flows(&slower_in, 0.5), [0.5 * FROM_SUPPLY[0], 0.5 * 2.0 / 3.0]);
        assert_near(flows(&slower_in, -0.5), [-0.25 * 0.5, -0.25 * FROM_SUPPLY[1]]);
        // Shares of one edge multiply.
        let all = [(P::MeteringRatio, 0.5), (P::MeteringPorts, 0.2), (P::MeteringDirections, -0.25)];
        assert_near(flows(&all, 0.5), [0.5 * FROM_SUPPLY[0], 0.5 * 1.5 * 1.2 * 2.0 / 3.0]);
        assert_near(flows(&all, -0.5), [-0.5 * 1.5 * 0.75 * 0.5, -0.5 * 1.2 * 0.75 * FROM_SUPPLY[1]]);
    }

    #[test]
    fn a_return_line_three_times_as_tight_as_the_edge_halves_what_returns() {
        // R·K² = 3: with the edge fully open three quarters of the pressure are lost in the line.
        let changes = [(P::ReturnResistance, 3.0 / (2.4e-7 * 2.4e-7))];
        assert_near(flows(&changes, 1.0), [FROM_SUPPLY[0], 0.5 * 2.0 / 3.0]);
        assert_near(flows(&changes, -1.0), [-0.5 * 0.5, -FROM_SUPPLY[1]]);
    }

    #[test]
    fn a_laminar_line_takes_pressure_in_proportion_to_the_flow() {
        // R·K/√p0 = 3/2: Q² + 3/2·Q = 4/9 over the open tank edge gives Q = ¼; Q² + 3/2·Q = 1/4 gives 0.151.
        let changes = [(P::ReturnLaminar, 1.5 * libm::sqrt(7e6) / 2.4e-7)];
        assert_near(flows(&changes, 1.0), [FROM_SUPPLY[0], (libm::sqrt(2.25 + 16.0 / 9.0) - 1.5) / 2.0]);
        assert_near(flows(&changes, -1.0), [-(libm::sqrt(3.25) - 1.5) / 2.0, -FROM_SUPPLY[1]]);
    }

    #[test]
    fn near_the_centre_every_edge_leaks() {
        let changes = [(P::DeadZone, 0.2), (P::ValveLeakageOpening, 0.1), (P::ValveLeakageReach, 0.1)];
        let leaks = [FROM_SUPPLY[0] - 0.5, 2.0 / 3.0 - FROM_SUPPLY[1]];
        assert_near(flows(&changes, 0.0), leaks.map(|leak| 0.1 * leak));
        assert_near(flows(&changes, -0.1), leaks.map(|leak| 0.05 * leak));
        // 0.1 beyond the dead zone, and a tenth of the leakage.
        assert_near(flows(&changes, 0.3), [0.1 * FROM_SUPPLY[0] + 0.01 * leaks[0], 0.1 * 2.0 / 3.0 + 0.01 * leaks[1]]);
    }

    #[test]
    fn a_rounded_edge_opens_gradually_and_leaks_less_the_further_it_is_covered() {
        let changes = [(P::DeadZone, 0.2), (P::EdgeRounding, 0.06)];
        let opening = |beyond: f64| 0.5 * (beyond + beyond.hypot(0.06));
        for spool in [-0.6, -0.28, -0.2, 0.0, 0.12, 0.2, 0.21, 0.9] {
            let (out, back) = (opening(spool - 0.2), opening(-spool - 0.2));
            let expected = [out * FROM_SUPPLY[0] - back * 0.5, out * 2.0 / 3.0 - back * FROM_SUPPLY[1]];
            assert_near(flows(&changes, spool), expected);
        }
        assert!((opening(-0.2) - 0.06 * 0.06 / 0.8).abs() < 1e-4);
    }

    #[test]
    fn laminar_pressures_add_up() {
        let apart = flows(&[(P::LaminarTransition, 1e5), (P::LaminarPressure, 3e5)], 0.5);
        assert_eq!(apart, flows(&[(P::LaminarTransition, 4e5)], 0.5));
    }

    #[test]
    fn an_opening_that_does_not_fit_is_refused_by_its_name() {
        let refused = |changes: &[(P, f64)]| {
            let drive = Drive::<PerUnit>::new::<64>(&machine(changes), Tick::OneMillisecond);
            let Err(MachineError::DoesNotFit { parameter, .. }) = drive else { panic!("{drive:?}") };
            parameter
        };
        assert_eq!(refused(&[(P::FlowGainLinear, 10.0), (P::FlowGainBeyond, 10.0)]), P::FlowGainLinear);
        assert_eq!(refused(&[(P::MeteringRatio, 4.0)]), P::MeteringRatio);
        assert_eq!(refused(&[(P::MeteringRatio, 0.5), (P::MeteringPorts, 4.0)]), P::MeteringPorts);
        assert_eq!(refused(&[(P::ReturnResistance, 1e18)]), P::ReturnResistance);
        assert_eq!(refused(&[(P::DroopResistance, 1e13)]), P::DroopResistance);
        assert_eq!(refused(&[(P::SupplyPressure, 1e7), (P::FlowForce, 1e-6)]), P::FlowForce);
    }
}
