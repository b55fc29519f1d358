//! # Position-dependent volume
//!
//! ## What it adds
//! The oil in a chamber changes with the stroke, Va = Va0 + s·A·(y − mid-stroke) and Vb = Vb0 − s·aA·(y − mid-stroke);
//! equation (7) keeps it at its mid-stroke value. It is a finding for machine files of constant volumes only: with `volume_follows_piston`, as `init`
//! writes it, the volumes change by the geometry anyway.
//!
//! ## How it shows
//! The flow that the model lacks follows dp/dt and changes its sign with the side of mid-stroke. Near an end the small
//! chamber is stiff: the oil-spring frequency rises towards both ends.
//!
//! ## What looks alike
//! Hoses are equally soft at every position; air is soft at low pressure.
//!
//! ## Parameters
//! Share s of the geometric change, not negative: 1 is geometry; 0.2 where the volume beside the piston is large or not
//! well known, 1.2 where the areas are not well known.
//!
//! ## Source
//! H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 6 (valve-controlled piston); M. Jelali and A. Kroll,
//! *Hydraulic Servo-systems*, Springer 2003, chapter 4.

use model_core::machine::Parameter;
use recording::Signal;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "position-dependent-volume",
    subsystem: Subsystem::Chambers,
    equation: "Va = Va0 + s·A·(y − y_mid), Vb = Vb0 − s·aA·(y − y_mid)",
    forms: &[&[EffectParameter { parameter: Parameter::VolumeShare, kind: Kind::Amount(|_| (0.2, 1.2)) }]],
    look_alikes: &[
        LookAlike {
            effect: "hose-compliance",
            told_apart_by: "strokes over the whole stroke: hoses are as soft at both ends",
        },
        LookAlike {
            effect: "entrained-air",
            told_apart_by: "strokes over the whole stroke: air is as soft at both ends",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "strokes over the whole stroke, or small steps near both ends, both pressures recorded",
    source: "Merritt, Hydraulic Control Systems, 1967, ch. 6",
    // Without a position it is not known on which side of mid-stroke the rod is.
    shows_in: |scene| scene.input_point != InputPoint::Force && scene.judges(Signal::Position),
};
