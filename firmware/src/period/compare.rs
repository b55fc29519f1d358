//! The machine against its model and against what it was told.

use model_core::number::{Number, PerUnit};

use super::{Period, Place};
use crate::control::{Control, Predicted};
use crate::measured::Measured;
use crate::monitor::{Innovation, Miss};
use crate::supervision::deviating::Now;
use crate::supervision::{Fault, Findings, Log, Mode, Response};

impl<A, P, O, C: Control> Period<A, P, O, C> {
    /// Compares the sensors with the model, and the spool with that of the valve's model, from which it is `spool_off`; the alarm is a fault, unless it is ignored.
    pub(super) fn monitor<L: Log>(
        &mut self,
        predicted: Option<Predicted>,
        spool_off: Option<PerUnit>,
        measured: &Measured,
        found: &mut Findings<'_, L>,
    ) -> Option<Miss> {
        let (monitor, watched) = (self.rig.monitor.as_ref()?, &mut self.state.watched);
        let Some(predicted) = predicted else {
            monitor.forget(watched);
            return None;
        };
        let innovation = Innovation::of(&predicted, &measured.observed());
        let innovation = spool_off.map_or(innovation, |off| innovation.with_spool(off));
        let miss = monitor.watch(watched, &innovation)?;
        found.tell_alarm(&miss);
        if let Some(response) = self.rig.limits.deviation.alarm {
            found.note(&Fault::Alarm { signal: miss.signal, response });
        }
        Some(miss)
    }

    /// Compares the machine with what it was told, unless a sensor's fault has already led to neutral.
    pub(super) fn deviate<L: Log>(
        &mut self,
        predicted: Option<Predicted>,
        spool_off: Option<PerUnit>,
        measured: &Measured,
        found: &mut Findings<'_, L>,
    ) {
        let (mode, limits, position) = (self.state.mode, &self.rig.limits.deviation, measured.position);
        let deviating = &mut self.state.deviating;
        if found.lost {
            deviating.displaced();
        }
        if found.worst == Some(Response::Neutral) {
            return;
        }
        let wanted = match mode {
            Mode::Following | Mode::Holding => Some(self.state.followed.at.position),
            Mode::Starting | Mode::RampingDown | Mode::Neutral => None,
        };
        let deviation = if mode.is_running() {
            deviating.controlled(limits, &Now { position, wanted, spool_off })
        } else {
            let judged = mode == Mode::Neutral || self.state.place == Place::Known;
            deviating.at_neutral(limits, position, judged)
        };
        let Some(deviation) = deviation else { return };
        // Where the encoder has stood for half of the error, it is the encoder that stands, and the rod may well have moved.
        let half = limits.position.map_or(PerUnit::ZERO, |limit| limit.travel.halved());
        let stands = predicted.is_some_and(|model| self.state.senses.position_stands(model.position, half));
        match deviation {
            Fault::FollowingError { .. } | Fault::VelocityError { .. } if stands => {
                found.note(&Fault::PositionStuck { position });
            }
            fault => found.note(&fault),
        }
    }
}
