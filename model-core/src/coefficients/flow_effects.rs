//! Coefficients of the flow link's effects; `None` where the amount is 0.

use super::Builder;
use crate::flow::effects::{EdgeEffects, EdgeSizes, GainCurve, ReturnLine, RoundedEdge, SLOPE_SCALE, ValveLeakage};
use crate::flow::load_holding::LoadHolding;
use crate::flow::supply::Droop;
use crate::machine::{MachineError, Parameter as P};
use crate::number::relaxation::fineness;
use crate::number::{Number, Real};
use crate::ports::{ChamberState, Overlap};

/// A-T, P-B and B-T, each with the two shares by which it is larger than P-A.
const OTHER_EDGES: [[P; 2]; 3] = [
    [P::MeteringRatio, P::MeteringDirections],
    [P::MeteringPorts, P::MeteringDirections],
    [P::MeteringRatio, P::MeteringPorts],
];

/// The rounding of an edge that is as good as sharp.
const SHARP: f64 = 1e-6;

impl<R: Real> Builder<'_, R> {
    /// The dead zone of either side, none below 0.
    pub(super) fn overlap<N: Number<Real = R>>(&self) -> Result<Overlap<N>, MachineError> {
        let (both, half) = (self.get(P::DeadZone), R::constant(0.5) * self.get(P::DeadZoneDifference));
        let side = |travel: R| {
            let travel = if travel.value() < 0.0 { R::ZERO } else { travel };
            self.signal("dead zone", P::DeadZone, travel)
        };
        Ok(Overlap { extending: side(both + half)?, retracting: side(both - half)? })
    }

    /// What makes the four edges differ, or the supply droop.
    pub(super) fn edge_effects<N: Number<Real = R>>(&self) -> Result<Option<EdgeEffects<N>>, MachineError> {
        let (linear, beyond) = (self.get(P::FlowGainLinear), self.get(P::FlowGainBeyond));
        let bends = !(linear.is_nil() && beyond.is_nil());
        let curve = if bends { Some(self.gain_curve(linear, beyond)?) } else { None };
        let effects = EdgeEffects {
            curve,
            sizes: self.edge_sizes()?,
            return_line: self.unless_nil(P::ReturnResistance, |resistance| self.return_line(resistance))?,
            half_laminar: self.unless_nil(P::ReturnLaminar, |laminar| {
                let drop = laminar * R::constant(0.5 * self.bases.flow_m3_per_s / self.bases.pressure_pa);
                self.gain::<N>("return line's laminar pressure drop", P::ReturnLaminar, drop)
            })?,
            leakage: self.unless_nil(P::ValveLeakageOpening, |opening| self.valve_leakage(opening))?,
            rounding: self.unless_nil(P::EdgeRounding, |rounding| self.rounded_edge(rounding))?,
            droop: self.unless_nil(P::DroopResistance, |resistance| self.droop(resistance))?,
            holding: self.load_holding()?,
            slope_fraction: self.signal("a slope's scale", P::FlowCoefficient, R::ONE / R::constant(SLOPE_SCALE))?,
            slope_scale: self.steep::<N>("a slope's scale", P::FlowCoefficient, R::constant(SLOPE_SCALE))?,
        };
        self.check_largest_opening::<N>()?;
        let EdgeEffects { curve, sizes, return_line, half_laminar, leakage, rounding, droop, holding, .. } = &effects;
        let returns = return_line.is_some() || half_laminar.is_some();
        let differ = curve.is_some() || !sizes.are_one() || returns || leakage.is_some() || rounding.is_some();
        Ok((differ || droop.is_some() || holding.is_some()).then_some(effects))
    }

    /// A pressure of the least that its parameter takes stands for no valve.
    fn load_holding<N: Number<Real = R>>(&self) -> Result<Option<LoadHolding<N>>, MachineError> {
        let pressure = R::constant(self.bases.pressure_pa);
        let setting = |of: P| {
            let setting = self.get(of);
            let there = setting.value() > of.description().min;
            if there { self.signal("load-holding pressure", of, setting / pressure).map(Some) } else { Ok(None) }
        };
        let settings = ChamberState { a: setting(P::HoldingSetA)?, b: setting(P::HoldingSetB)? };
        if settings.a.is_none() && settings.b.is_none() {
            return Ok(None);
        }
        let (quarter, gain) = (R::constant(0.25), self.orifice(P::FlowCoefficient));
        let opening = R::constant(4.0) * gain * pressure / self.get(P::HoldingSpan);
        Ok(Some(LoadHolding {
            settings,
            quarters: [
                self.gain::<N>("a quarter", P::PilotRatio, quarter)?,
                self.gain::<N>("a quarter of the pilot ratio", P::PilotRatio, quarter * self.get(P::PilotRatio))?,
            ],
            opening: self.steep::<N>("load-holding valve's opening per pressure", P::HoldingSpan, opening)?,
            widest: self.signal("load-holding valve's opening", P::HoldingSize, gain * self.get(P::HoldingSize))?,
            share: self.gain::<N>(
                "load-holding valve's rate",
                P::HoldingTime,
                R::ONE - self.decay(self.get(P::HoldingTime)),
            )?,
            unity: self.steep::<N>("one", P::HoldingSpan, R::ONE)?,
        }))
    }

    /// By how much each edge exceeds P-A: tank edges by one share, B's by another, those open while retracting by a third.
    fn edge_sizes<N: Number<Real = R>>(&self) -> Result<EdgeSizes<N>, MachineError> {
        let sized = |shares: [P; 2]| {
            let (excess, of) = self.edge_excess(shares);
            if excess.is_nil() { Ok(None) } else { self.gain::<N>("excess of an edge", of, excess).map(Some) }
        };
        let [tank_a, supply_b, tank_b] = OTHER_EDGES;
        Ok(EdgeSizes { tank_a: sized(tank_a)?, supply_b: sized(supply_b)?, tank_b: sized(tank_b)? })
    }

    /// (1 + a)·(1 + b) − 1, and the larger one of a and b.
    fn edge_excess(&self, [first, second]: [P; 2]) -> (R, P) {
        let (a, b) = (self.get(first), self.get(second));
        (a + b + a * b, if b.value() > a.value() { second } else { first })
    }

    /// Checks that the format holds the largest opening: full travel, bent, on the largest edge, and the leakage.
    fn check_largest_opening<N: Number<Real = R>>(&self) -> Result<(), MachineError> {
        let bent = self.get(P::FlowGainLinear) + self.get(P::FlowGainBeyond);
        let larger = |most: (R, P), edge: (R, P)| if edge.0.value() > most.0.value() { edge } else { most };
        let (excess, of) =
            OTHER_EDGES.map(|shares| self.edge_excess(shares)).into_iter().fold((R::ZERO, P::FlowGainLinear), larger);
        let travel = R::ONE + R::constant(0.5) * self.get(P::EdgeRounding);
        let opening = travel * (R::ONE + bent) * (R::ONE + excess) + self.get(P::ValveLeakageOpening);
        let of = if excess.value() > bent.value() { of } else { P::FlowGainLinear };
        self.signal::<N>("opening at full travel with its effects", of, opening)?;
        let flow = self.orifice(P::FlowCoefficient) * opening;
        self.signal::<N>("flow at full opening with its effects", of, flow).map(|_| ())
    }

    fn gain_curve<N: Number<Real = R>>(&self, linear: R, beyond: R) -> Result<GainCurve<N>, MachineError> {
        let quarter = |of: P, value: R| self.gain::<N>("bend of the flow gain", of, R::constant(0.25) * value);
        Ok(GainCurve {
            quarters: [quarter(P::FlowGainLinear, linear)?, quarter(P::FlowGainBeyond, beyond)?],
            notch: self.signal("end of the notch", P::FlowGainNotch, self.get(P::FlowGainNotch))?,
        })
    }

    /// R·Q²/p per unit, at the flow of full opening and full pressure.
    fn return_line<N: Number<Real = R>>(&self, resistance: R) -> Result<ReturnLine<N>, MachineError> {
        let coefficient = self.get(P::FlowCoefficient);
        Ok(ReturnLine {
            resistance: self.gain::<N>(
                "return line's share of the pressure over the edge",
                P::ReturnResistance,
                resistance * coefficient * coefficient,
            )?,
        })
    }

    fn valve_leakage<N: Number<Real = R>>(&self, opening: R) -> Result<ValveLeakage<N>, MachineError> {
        let reach = self.get(P::ValveLeakageReach);
        Ok(ValveLeakage {
            opening: self.signal("opening at the centre", P::ValveLeakageOpening, opening)?,
            narrowness: self.steep::<N>(
                "inverse square of the reach",
                P::ValveLeakageReach,
                R::ONE / (reach * reach),
            )?,
        })
    }

    /// A rounding of 0 whose derivative is wanted is as good as none: at the edge of a sharp one there is none.
    fn rounded_edge<N: Number<Real = R>>(&self, rounding: R) -> Result<RoundedEdge<N>, MachineError> {
        let sharp = R::constant(SHARP);
        let rounding = if rounding.value() < SHARP { rounding + sharp } else { rounding };
        Ok(RoundedEdge { rounding: self.signal("rounding of an edge", P::EdgeRounding, rounding)? })
    }

    fn droop<N: Number<Real = R>>(&self, resistance: R) -> Result<Droop<N>, MachineError> {
        let resistance = resistance * R::constant(self.bases.flow_m3_per_s / self.bases.pressure_pa);
        let time_constant = self.get(P::DroopTime);
        let share = R::ONE - self.decay(time_constant);
        let at_end = R::ONE - share * time_constant / R::constant(self.tick_s);
        // For a slow supply this is a difference of two numbers near 1; then its series is used, h/2τ − (h/τ)²/6.
        let ticks = time_constant.value() / self.tick_s;
        let at_end = if ticks > 1e4 {
            let turn = R::constant(self.tick_s) / time_constant;
            turn * (R::constant(0.5) - turn / R::constant(6.0))
        } else {
            at_end
        };
        let at_once = resistance * at_end;
        let at_start = resistance * (share - at_end);
        let fine = fineness([share, at_once, at_start].map(Real::value).into_iter().fold(0.0, f64::max));
        let scaled = |value: R| {
            self.gain::<N>("fall of the supply pressure per flow", P::DroopResistance, value * R::constant(fine))
        };
        Ok(Droop {
            shares: [scaled(share)?, scaled(-at_start)?, scaled(-at_once)?],
            fine: self.gain::<N>("fineness of the droop", P::DroopTime, R::ONE / R::constant(fine))?,
            at_once: self.gain::<N>("fall of the supply pressure per flow", P::DroopResistance, at_once)?,
        })
    }
}
