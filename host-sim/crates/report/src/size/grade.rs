//! How a size compares with what sources say of cylinders.

use std::fmt;

use model_core::machine::Parameter;

use super::Drive;

/// How much of something a cylinder has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// As much as every sealed cylinder has.
    Usual,
    /// More than that.
    Raised,
    /// Dry friction beyond what any seal makes.
    Jammed,
    /// A leakage with which a cylinder no longer holds its load.
    Worn,
}

impl fmt::Display for Grade {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Grade::Usual => "usual for a sealed cylinder",
            Grade::Raised => "raised",
            Grade::Jammed => "worn or jammed",
            Grade::Worn => "worn",
        })
    }
}

/// Dry friction as a share of full force. Seals of low friction have 1 to 3 %, standard ones up to 5 % (catalogues of cylinders and seals).
/// Twice the upper end of good seals is beyond seals: guides that jam, bent rods, seals that have swollen.
const FRICTION: Bounds = Bounds { usual: 0.03, raised: 0.06 };

/// Leakage past a seal at the supply pressure, as a share of full flow. Seals let next to nothing through: new or repaired, 0.16 ml/min is allowed for a
/// bore of 63 mm and 1.0 ml/min for 160 mm (service manual of JCB JS130, 9803/6410, inspection of rams), 0.33 ml/min whatever the bore (service manual of
/// Takeuchi TB215R, leak test of cylinders); ISO 10100 tests for it. That is below 0.1 % of full flow for every drive from 1 l/min on. At 1 % of
/// full flow, a rod whose full speed is 100 mm/s drifts by 60 mm/min under load.
const LEAKAGE: Bounds = Bounds { usual: 1e-3, raised: 1e-2 };

/// Up to where a size is usual, and from where on it is more than raised.
struct Bounds {
    usual: f64,
    raised: f64,
}

impl Bounds {
    fn grade(&self, share: f64, beyond: Grade) -> Grade {
        match share {
            share if share <= self.usual => Grade::Usual,
            share if share <= self.raised => Grade::Raised,
            _ => beyond,
        }
    }
}

/// What a value is a share of.
enum Share {
    OfFullForce,
    OfFullFlow,
}

impl Share {
    /// How a parameter is judged, where a source has bounds.
    fn of(parameter: Parameter) -> Option<(Self, &'static Bounds, Grade)> {
        use Parameter as P;
        match parameter {
            P::CoulombFriction
            | P::StribeckForce
            | P::AsymmetricExtending
            | P::AsymmetricRetracting
            | P::PositionFriction
            | P::PreslidingForce => Some((Self::OfFullForce, &FRICTION, Grade::Jammed)),
            P::InternalLeakage | P::ExternalLeakageA | P::ExternalLeakageB => {
                Some((Self::OfFullFlow, &LEAKAGE, Grade::Worn))
            }
            _ => None,
        }
    }

    /// The share that a value is.
    fn in_drive(&self, drive: &Drive<'_>, value: f64) -> Option<f64> {
        match self {
            Self::OfFullForce => drive.of_full_force(value),
            Self::OfFullFlow => Some(drive.of_full_flow(value * drive.supply_pa())),
        }
    }
}

impl Grade {
    /// The grade of a value of an effect parameter, where a source has bounds.
    pub(super) fn of(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<Self> {
        let (share, bounds, beyond) = Share::of(parameter)?;
        Some(bounds.grade(share.in_drive(drive, value)?, beyond))
    }
}

/// The value beyond which the grade is the worst one. Shares are proportional to values.
pub(super) fn worn(drive: &Drive<'_>, parameter: Parameter) -> Option<f64> {
    let (share, bounds, _) = Share::of(parameter)?;
    let worn = bounds.raised / share.in_drive(drive, 1.0)?;
    worn.is_finite().then_some(worn)
}
