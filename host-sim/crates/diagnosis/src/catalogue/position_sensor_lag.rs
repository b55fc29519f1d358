//! # Position-sensor lag
//!
//! ## What it adds
//! A filter or a bus between the rod and the recorded position: a first-order lag of time constant T, a dead time τ, or
//! both.
//!
//! ## How it shows
//! The measured position trails by (T + τ)·v: behind in both directions, right at rest. Pressures and spool are on
//! time.
//!
//! ## What looks alike
//! A slower valve delays everything behind it; a recorded spool or the pressures show which it is. Soft hoses let
//! the rod itself lag while pressure builds, and only then. Play does not grow with the speed.
//!
//! ## Parameters
//! T and τ in s, not negative: 1–40 ms.
//!
//! ## Source
//! E. O. Doebelin, *Measurement Systems: Application and Design*, McGraw-Hill (first-order instruments and dead time).

use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const LAG: EffectParameter =
    EffectParameter { parameter: Parameter::PositionLag, kind: Kind::Amount(|_| (5e-4, 0.05)) };
const DELAY: EffectParameter =
    EffectParameter { parameter: Parameter::PositionDelay, kind: Kind::Amount(|_| (5e-4, 0.04)) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "position-sensor-lag",
    subsystem: Subsystem::Sensing,
    equation: "T·dŷ/dt = y(t − τ) − ŷ",
    forms: &[&[LAG], &[DELAY], &[LAG, DELAY]],
    look_alikes: &[
        LookAlike {
            effect: "linkage-backlash",
            told_apart_by: "constant-speed strokes: play is the same at every speed, a lag grows with it",
        },
        LookAlike {
            effect: "hose-compliance",
            told_apart_by: "constant-speed strokes: at constant pressure compliance rests, a lag stays",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "constant-speed strokes at several speeds and a sine sweep, both pressures recorded",
    source: "Doebelin, Measurement Systems: Application and Design",
    shows_in: |scene| scene.judges(Signal::Position),
};
