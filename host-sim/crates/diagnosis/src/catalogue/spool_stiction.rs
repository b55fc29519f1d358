//! # Spool stiction
//!
//! ## What it adds
//! The spool sticks in its bore, by lateral forces or dirt, until the command asks for a travel that differs by more
//! than the band: x holds while `|x_set − x| ≤ band`. Then kinetic friction keeps it short. A spool that follows two lags has no mass: it jumps at once to
//! `kept·band` from `x_set` and sticks again. A spool of second order slides, pulled towards that place, until it would turn round.
//!
//! ## How it shows
//! Flats in the spool while the command moves, then steps: the residual of the valve link is a saw-tooth as high as the
//! band. A spool with mass is held only at the start of a move and after a reversal; under a creeping command it sticks and slips.
//!
//! ## What looks alike
//! Valve hysteresis follows without jumps once its play is taken up. Dither hides both. A rod that sticks and slips
//! lets the pressures build up before it jumps; a stuck spool leaves them flat. A stiction that keeps most of its
//! band does not jump either, and acts as a play: beside a hysteresis three times as wide as its band it only changes the shape
//! of the hysteresis loop, and is never accepted there.
//!
//! ## Parameters
//! Band in parts of full travel, not negative: 0.5–3 %, 6 % in a silted valve; the share of the band by which the spool stays short of its target,
//! which is the ratio of kinetic to static friction.
//!
//! ## Source
//! J. F. Blackburn, G. Reethof, J. L. Shearer, *Fluid Power Control*, MIT Press 1960 (lateral forces, hydraulic lock);
//! M. A. A. S. Choudhury, N. F. Thornhill, S. L. Shah, *Modelling valve stiction*, Control Engineering Practice 13,
//! 2005.

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

const BAND: EffectParameter =
    EffectParameter { parameter: Parameter::StictionBand, kind: Kind::Jump(|_| (2e-3, 0.06)) };
const KEPT: EffectParameter = EffectParameter { parameter: Parameter::StictionKept, kind: Kind::Jump(|_| (0.05, 0.8)) };

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "spool-stiction",
    subsystem: Subsystem::Valve,
    equation: "x holds while |x_set − x| ≤ band, then it is pulled to x_set ∓ kept·band",
    forms: &[&[BAND], &[BAND, KEPT]],
    look_alikes: &[
        LookAlike { effect: "valve-hysteresis", told_apart_by: "slow triangle: play follows without jumps" },
        LookAlike {
            effect: "stribeck-friction",
            told_apart_by: "constant-speed strokes, both pressures recorded: they build up before a rod breaks away",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "slow triangle without dither, spool recorded",
    source: "Choudhury, Thornhill, Shah, Control Engineering Practice 13, 2005",
    shows_in: |scene| scene.input_point == InputPoint::Command,
};
