//! # Valve leakage
//!
//! ## What it adds
//! Clearance and worn edges let supply and tank edges of both ports pass a little near the centre: an opening o at x =
//! 0 on all four, half of it at |x| = reach, next to nothing far out.
//!
//! No edge is sharp, and every spool has play in its bore: within tolerance an edge that is passed by b opens by
//! (b + √(b² + rounding²))/2, half of `rounding` at the edge itself, and leaks the less the further it is covered. That is
//! no finding; more of it, from wear, is.
//!
//! ## How it shows
//! With the valve at its centre the chambers settle at a common level between supply and tank, and the rod creeps under
//! load; flow that the model lacks is there near x = 0 only.
//!
//! ## What looks alike
//! Leakage past the piston goes on at every spool position, and the level of both pressures is free. A wide laminar
//! transition acts at small pressure differences, at every opening.
//!
//! ## Parameters
//! Opening in parts of full travel, not negative: 0.2–5 % of rated. Reach in parts of full travel: 0.01–0.2, about the
//! overlap. Rounding of a sound edge in parts of full travel: 0.002–0.01, up to 0.02 of a servo valve's short travel.
//!
//! ## Source
//! B. Eryilmaz and B. H. Wilson, *Unified modeling and analysis of a proportional valve*, J. Franklin Institute 343,
//! 2006; H. E. Merritt, *Hydraulic Control Systems*, Wiley 1967, chapter 5 (leakage at the null).

use model_core::machine::Parameter;
use simulation::InputPoint;

use super::{EffectParameter, Hypothesis, Kind, LookAlike, Subsystem};

pub(crate) const HYPOTHESIS: Hypothesis = Hypothesis {
    name: "valve-leakage",
    subsystem: Subsystem::Flow,
    equation: "Q_leak = K_Q·o(x)·√Δp on all four edges, o halved at |x| = reach; or edges that open by (b + √(b² + c²))/2, b past the edge",
    forms: &[
        &[
            EffectParameter { parameter: Parameter::ValveLeakageOpening, kind: Kind::Amount(|_| (1e-3, 0.06)) },
            EffectParameter { parameter: Parameter::ValveLeakageReach, kind: Kind::Shape(|_| (0.01, 0.2), 3) },
        ],
        &[EffectParameter { parameter: Parameter::EdgeRounding, kind: Kind::Amount(|_| (2e-3, 0.12)) }],
    ],
    look_alikes: &[
        LookAlike {
            effect: "internal-leakage",
            told_apart_by: "closed-valve hold under load and strokes at two loads: the piston leaks at every opening",
        },
        LookAlike {
            effect: "laminar-transition",
            told_apart_by: "closed-valve hold under load: without leakage a closed valve holds",
        },
    ],
    refined: &[],
    extends: None,
    separated_by: "closed-valve hold under load, both pressures recorded",
    source: "Eryilmaz & Wilson, J. Franklin Institute 343, 2006",
    shows_in: |scene| matches!(scene.input_point, InputPoint::Command | InputPoint::Spool),
};
