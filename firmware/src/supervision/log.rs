//! What a period logs: faults when they are entered, changes of the mode, the monitor's alarm; and what the commissioning tells.

use super::fault::{ActiveFaults, Fault, Response};
use super::mode::Mode;
use crate::commissioning::Note;
use crate::monitor::Miss;

/// Receiver of these messages. `()` ignores them.
pub trait Log {
    /// A fault was entered; it is logged once until it is acknowledged.
    fn fault(&mut self, fault: &Fault);
    /// The mode changed.
    fn mode(&mut self, from: Mode, to: Mode);
    /// The model no longer predicts what a sensor shows; logged once until the monitor is reset.
    fn alarm(&mut self, miss: &Miss);
    /// A step of the commissioning began, measured something, passed or was refused.
    fn commissioning(&mut self, note: &Note);
}

impl Log for () {
    fn fault(&mut self, _: &Fault) {}
    fn mode(&mut self, _: Mode, _: Mode) {}
    fn alarm(&mut self, _: &Miss) {}
    fn commissioning(&mut self, _: &Note) {}
}

/// Logs everything by defmt: faults as errors, alarms as warnings, modes as information.
#[cfg(feature = "defmt")]
#[derive(Clone, Copy, Debug, Default)]
pub struct Defmt;

#[cfg(feature = "defmt")]
impl Log for Defmt {
    fn fault(&mut self, fault: &Fault) {
        defmt::error!("fault: {}", fault);
    }
    fn mode(&mut self, from: Mode, to: Mode) {
        defmt::info!("mode: {} -> {}", from, to);
    }
    fn alarm(&mut self, miss: &Miss) {
        let Miss { link, signal, innovation, .. } = miss;
        let off = innovation.to_f64();
        defmt::warn!(
            "alarm: {} misses: {} is off by {} of its base, its mean square {}",
            link,
            signal,
            off,
            miss.square()
        );
    }
    fn commissioning(&mut self, note: &Note) {
        let words = defmt::Display2Format(note);
        match note {
            Note::Begun(_) | Note::Measured(..) | Note::Passed(_) => defmt::info!("{}", words),
            Note::Refused(..) => defmt::error!("{}", words),
        }
    }
}

/// What a period has found so far.
#[derive(Debug)]
pub(crate) struct Findings<'a, L> {
    log: &'a mut L,
    /// Active faults, including those of this period.
    pub(crate) active_faults: ActiveFaults,
    /// Most severe response to a fault of this period.
    pub(crate) worst: Option<Response>,
    /// Whether a fault of this period is one that a restart may cure.
    pub(crate) own: bool,
    /// Whether a fault of this period means that the encoder lost the rod's position.
    pub(crate) lost: bool,
}

impl<'a, L: Log> Findings<'a, L> {
    pub(crate) fn new(active_faults: ActiveFaults, log: &'a mut L) -> Self {
        Self { log, active_faults, worst: None, own: false, lost: false }
    }

    /// Notes a fault, and logs it if it is the first of its kind.
    pub(crate) fn note(&mut self, fault: &Fault) {
        if self.active_faults.enter(fault) {
            self.log.fault(fault);
        }
        self.worst = self.worst.max(Some(fault.response()));
        self.own |= fault.is_own();
        self.lost |= fault.loses_place();
    }

    pub(crate) fn tell_alarm(&mut self, miss: &Miss) {
        self.log.alarm(miss);
    }

    pub(crate) fn tell_mode(&mut self, from: Mode, to: Mode) {
        if from != to {
            self.log.mode(from, to);
        }
    }
}
