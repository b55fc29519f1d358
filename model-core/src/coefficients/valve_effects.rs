//! Coefficients of the valve link's effects; `None` where the amount is 0.

use super::Builder;
use super::lags::{self, Lags};
use crate::machine::{MachineError, Parameter as P};
use crate::number::relaxation::{Relaxation, fineness};
use crate::number::{Number, Real};
use crate::valve::effects::{
    FlowForce, Hysteresis, NullDrift, STILL, SolenoidSaturation, SpeedLimit, Stiction, Swing, SwingingLimit,
    ValveEffects,
};

/// Largest ω·h that the limit of a spool's pull reckons with.
const MOST_TURN: f64 = 2.0;

impl<R: Real> Builder<'_, R> {
    pub(super) fn valve_effects<N: Number<Real = R>>(&self, lags: &Lags<R>) -> Result<ValveEffects<N>, MachineError> {
        Ok(ValveEffects {
            drift: self.unless_nil(P::NullDriftTravel, |travel| self.null_drift(travel))?,
            saturation: self.solenoid()?,
            hysteresis: self.unless_nil(P::HysteresisWidth, |width| self.hysteresis(width))?,
            flow_force: self.unless_nil(P::FlowForce, |closing| self.flow_force(closing, lags.share()))?,
            swing: lags.swing.as_ref().map(|swing| self.swing(swing)).transpose()?,
            speed_limit: self.speed_limit()?,
            stiction: self.unless_nil(P::StictionBand, |band| {
                Ok(Stiction {
                    band: self.signal("band of the stuck spool", P::StictionBand, band)?,
                    kept: self.signal(
                        "what kinetic friction keeps it short by",
                        P::StictionKept,
                        band * self.get(P::StictionKept),
                    )?,
                    still: self.signal("rest of the spool", P::StictionBand, R::constant(STILL))?,
                })
            })?,
        })
    }

    /// An effect, where its amount, or a derivative by the amount, is not 0.
    pub(super) fn unless_nil<T>(
        &self,
        strength: P,
        effect: impl FnOnce(R) -> Result<T, MachineError>,
    ) -> Result<Option<T>, MachineError> {
        let strength = self.get(strength);
        if strength.is_nil() { Ok(None) } else { effect(strength).map(Some) }
    }

    fn swing<N: Number<Real = R>>(&self, swing: &lags::Swing<R>) -> Result<Swing<N>, MachineError> {
        let of = P::NaturalFrequency;
        let older = |share: R| self.signal("share of an older set value", of, share);
        let [l, x] = swing.older;
        Ok(Swing {
            back: self.gain::<N>("coupling of the spool's speed", of, swing.back)?,
            older: [older(l)?, older(x)?],
        })
    }

    fn speed_limit<N: Number<Real = R>>(&self) -> Result<Option<SpeedLimit<N>>, MachineError> {
        let step = self.get(P::SpoolSpeedLimit) * R::constant(self.tick_s);
        let Some(step_limit) = N::signal(step) else { return Ok(None) };
        if self.get(P::NaturalFrequency).is_nil() {
            return Ok(Some(SpeedLimit { step: step_limit, swinging: None }));
        }
        let (turn, of) = (self.turn(), P::SpoolSpeedLimit);
        let lead = step / turn;
        let pull = R::constant(2.0) * self.get(P::SpoolDamping) * lead * (R::ONE + self.get(P::SpeedOverdrive));
        // A spool that turns by more than this in a tick follows within it, however it is pulled.
        let ahead = if turn.value() < MOST_TURN { R::constant(0.5) * turn } else { R::constant(0.5 * MOST_TURN) };
        let swinging = SwingingLimit {
            lead: Self::limit(lead),
            pull: Self::limit(pull),
            ahead: self.gain::<N>("half a tick of the spool's lead", of, ahead)?,
            unity: self.steep::<N>("one", of, R::ONE)?,
        };
        Ok(Some(SpeedLimit { step: step_limit, swinging: Some(swinging) }))
    }

    fn null_drift<N: Number<Real = R>>(&self, travel: R) -> Result<NullDrift<N>, MachineError> {
        let share = R::ONE - self.decay(self.get(P::NullDriftTime));
        let fine = fineness(share.value());
        let of = P::NullDriftTime;
        Ok(NullDrift {
            travel: self.signal("drift of the neutral", P::NullDriftTravel, travel)?,
            relaxation: Relaxation {
                share: self.gain::<N>("drift per tick", of, share * R::constant(fine))?,
                fine: self.gain::<N>("fineness of the drift", of, R::ONE / R::constant(fine))?,
            },
        })
    }

    fn solenoid<N: Number<Real = R>>(&self) -> Result<Option<SolenoidSaturation<N>>, MachineError> {
        let (curvature, loss) = (self.get(P::SolenoidCurvature), self.get(P::SolenoidLoss));
        if curvature.is_nil() && loss.is_nil() {
            return Ok(None);
        }
        Ok(Some(SolenoidSaturation {
            onset: self.signal("onset of the solenoid's saturation", P::SolenoidOnset, self.get(P::SolenoidOnset))?,
            curvature: self.steep::<N>("the solenoid's saturation", P::SolenoidCurvature, curvature)?,
            kept: self.signal("gain kept beyond the onset", P::SolenoidLoss, R::ONE - loss)?,
        }))
    }

    fn hysteresis<N: Number<Real = R>>(&self, width: R) -> Result<Hysteresis<N>, MachineError> {
        let spread = self.get(P::HysteresisSpread);
        let half = |share: R| self.signal("width of a play", P::HysteresisWidth, R::constant(0.5) * width * share);
        Ok(Hysteresis {
            half_widths: [half(R::ONE - spread)?, half(R::ONE)?, half(R::ONE + spread)?],
            third: self.gain::<N>("a third", P::HysteresisWidth, R::ONE / R::constant(3.0))?,
        })
    }

    fn flow_force<N: Number<Real = R>>(&self, closing: R, share: R) -> Result<FlowForce<N>, MachineError> {
        let closing = closing * R::constant(self.bases.pressure_pa);
        // Rounding may leave slow lags a share slightly below 0.
        let share = if share.value() < 0.0 { R::ZERO } else { share };
        let late = self.late_weight();
        let early = R::ONE - late;
        let weight = |value: R| self.gain::<N>("weight of an end of the tick", P::TimeConstant1, value);
        let through = |value: R| self.signal("share of the lags", P::TimeConstant1, value);
        Ok(FlowForce {
            closing: self.signal("flow force at supply pressure", P::FlowForce, closing)?,
            overlap: self.overlap()?,
            weights: [weight(early)?, weight(late)?],
            shares: [through(share * early)?, through(share * late)?],
            unity: self.steep::<N>("one", P::FlowForce, R::ONE)?,
        })
    }

    /// Weight of a tick's end in a lag's response to a straight line over the tick, (1 − (1 − e^−a)/a)/(1 − e^−a) with a = h/T, T the
    /// slower lag: ½ for a slow one, 1 for none.
    fn late_weight(&self) -> R {
        let (t1, t2) = (self.get(P::TimeConstant1), self.get(P::TimeConstant2));
        let slower = if !self.get(P::NaturalFrequency).is_nil() {
            self.machine.spool_lag_s()
        } else if t1.value() > t2.value() {
            t1
        } else {
            t2
        };
        let turn = R::constant(self.tick_s) / slower;
        if slower.value() <= 0.0 {
            R::ONE
        } else if turn.value() < 1e-3 {
            // A difference of two numbers near 1: then its series is used.
            R::constant(0.5) + turn / R::constant(12.0)
        } else {
            let share = R::ONE - self.decay(slower);
            (R::ONE - share / turn) / share
        }
    }
}
