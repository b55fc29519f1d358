//! # Linkage backlash
//!
//! ## What it adds
//! Play between the rod and the position's sensor: after a reversal the rod travels by the play before the sensor
//! moves. The drive itself is not affected. Where in its play the rod starts is found from what it does later, in each
//! recording.
//!
//! ## How it shows
//! The measured position is off by half the play, with the sign of the direction; it rests at each reversal while
//! pressures and flow show motion.
//!
//! ## What looks alike
//! A rod held by friction really rests, and the pressures build up. Valve hysteresis delays the spool. A slow sensor
//! is off by an amount that grows with the velocity.
//!
//! ## Parameters
//! Play in m at the rod, not negative: 0.05–3 mm.
//!
//! ## Source
//! M. Nordin and P.-O. Gutman, *Controlling mechanical systems with backlash – a survey*, Automatica 38, 2002; M. A.
//! Krasnosel'skii and A. V. Pokrovskii, *Systems with Hysteresis*, Springer 1989 (the play operator).

use model_core::machine::Parameter;
use recording::Signal;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "linkage-backlash",
    subsystem: Subsystem::Sensing,
    equation: "measured y = play of the true y, by its width",
    forms: &[&[EffectParameter { parameter: Parameter::BacklashPlay, kind: Kind::Amount(|_| (5e-5, 3e-3)) }]],
    look_alikes: &[
        LookAlike {
            effect: "coulomb-friction",
            told_apart_by: "slow triangle, both pressures recorded: they build up when friction holds the rod",
        },
        LookAlike {
            effect: "presliding",
            told_apart_by: "sine sweep of small amplitude, both pressures recorded: play leaves no force",
        },
        LookAlike {
            effect: "valve-hysteresis",
            told_apart_by: "slow triangle with spool or pressures recorded: a valve's hysteresis delays them",
        },
        LookAlike {
            effect: "position-sensor-lag",
            told_apart_by: "constant-speed strokes: play is the same at every speed, a lag grows with it",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "slow triangle, both pressures recorded",
    source: "Nordin & Gutman, Automatica 38, 2002",
    shows_in: |scene| scene.judges(Signal::Position),
};
