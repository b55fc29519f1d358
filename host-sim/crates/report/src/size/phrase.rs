//! The phrase for each effect parameter: how much, and of what.

use model_core::effects::Link;
use model_core::machine::{ATMOSPHERE_PA, Parameter};
use recording::display_unit::significant;

use super::{Drive, percent};

/// Amount and what it is of; `None` for a parameter that belongs to no effect of the catalogue.
pub(super) fn phrase(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    match parameter.effect()?.link() {
        Link::Valve => valve(drive, parameter, value),
        Link::Flow => orifices(drive, parameter, value),
        Link::Chambers => chambers(drive, parameter, value),
        Link::Mechanics => mechanics(drive, parameter, value),
        Link::Sensing => sensing(drive, parameter, value),
    }
}

/// The words for a value of either sign.
fn which(value: f64, positive: &'static str, negative: &'static str) -> &'static str {
    if value < 0.0 { negative } else { positive }
}

fn valve(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    use Parameter as P;
    let supply_pa = drive.supply_pa();
    Some(match parameter {
        P::HysteresisWidth => travel(drive, value, "between settling from above and from below"),
        P::StictionBand => travel(drive, value, "before the spool breaks away"),
        P::NullDriftTravel => travel(drive, value, which(value, "towards extending", "towards retracting")),
        P::HysteresisSpread => said(percent(value), "by which the widths of its elements differ from their mean"),
        P::StictionKept => said(percent(value), "of the band by which kinetic friction keeps it short"),
        P::SolenoidOnset => said(percent(value), "of full spool travel, where the gain starts to fall"),
        P::SolenoidCurvature => {
            let beyond = (1.0 - drive.get(P::SolenoidOnset)).max(0.0);
            said(
                percent(1.0 - 1.0 / (1.0 + value * beyond)),
                "less travel beyond the onset at a command for full travel",
            )
        }
        P::SolenoidLoss => said(percent(value), "of the gain lost beyond the onset"),
        P::FlowForce => {
            said(percent(value * supply_pa), &format!("of its travel closed by {} over the edges", bar(supply_pa)))
        }
        P::NullDriftTime => (time(value), String::new()),
        _ => return None,
    })
}

fn orifices(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    use Parameter as P;
    let supply_pa = drive.supply_pa();
    let at_supply = format!("at {}", bar(supply_pa));
    Some(match parameter {
        P::DeadZoneDifference => travel(
            drive,
            value,
            which(value, "more overlap on the extending side", "more overlap on the retracting side"),
        ),
        P::FlowGainLinear => {
            said(percent(value), which(value, "more flow gain at full opening", "less flow gain at full opening"))
        }
        P::FlowGainBeyond => {
            said(percent(value), which(value, "more flow gain beyond the notch", "less flow gain beyond the notch"))
        }
        P::FlowGainNotch => said(percent(value), "opening, where the notch ends"),
        P::MeteringRatio => {
            said(percent(value), which(value, "larger tank than supply edges", "smaller tank than supply edges"))
        }
        P::MeteringPorts => {
            said(percent(value), which(value, "larger edges of B than of A", "smaller edges of B than of A"))
        }
        P::MeteringDirections => said(
            percent(value),
            which(
                value,
                "larger edges for retracting than for extending",
                "smaller edges for retracting than for extending",
            ),
        ),
        P::DroopResistance | P::ReturnLaminar => at_full_flow(drive, value * drive.full_flow_m3_per_s()),
        P::ReturnResistance => at_full_flow(drive, value * drive.full_flow_m3_per_s().powi(2)),
        P::ValveLeakageOpening => {
            // Supply and tank edge of a port in series, and two ports.
            let each = value * drive.get(P::FlowCoefficient) * (0.5 * supply_pa).sqrt();
            flow(drive, 2.0 * each, &format!("from supply to tank {at_supply}, spool at its centre"))
        }
        P::ValveLeakageReach => said(percent(value), "of full spool travel, where half of it is left"),
        P::EdgeRounding => said(percent(value), "of full spool travel, over which an edge opens gradually"),
        P::LaminarPressure => said(bar(drive.get(P::LaminarTransition) + value), "below which the flow is laminar"),
        P::HoldingSetA => said(bar(value), "in A open its load-holding valve without a pilot"),
        P::HoldingSetB => said(bar(value), "in B open its load-holding valve without a pilot"),
        P::PilotRatio => {
            said(format!("{} times", significant(value, 2)), "as much as its own the other side's pressure opens it")
        }
        P::HoldingSpan => said(bar(value), "beyond that it is as wide as a metering edge at full travel"),
        P::HoldingSize => said(percent(value), "of a metering edge at full travel, its opening at the stop"),
        P::PumpSlip => flow(drive, value * supply_pa, &at_supply),
        P::DroopTime | P::HoldingTime => (time(value), String::new()),
        _ => return None,
    })
}

fn chambers(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    use Parameter as P;
    let supply_pa = drive.supply_pa();
    let at_supply = format!("at {}", bar(supply_pa));
    Some(match parameter {
        P::InternalLeakage => flow(drive, value * supply_pa, &format!("{at_supply} across the piston")),
        P::ExternalLeakageA => flow(drive, value * supply_pa, &format!("{at_supply} in A")),
        P::ExternalLeakageB => flow(drive, value * supply_pa, &format!("{at_supply} in B")),
        P::AirShare => said(percent(value), "of the oil by volume, at atmospheric pressure"),
        P::HoseCompliance => said(format!("{} cm³", significant(1e13 * value, 2)), "per 100 bar in each chamber"),
        P::VolumeShare => said(percent(value), "of what the piston displaces"),
        P::CavitationFloor => said(bar(ATMOSPHERE_PA + value), "absolute, below which no pressure falls"),
        _ => return None,
    })
}

fn mechanics(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    use Parameter as P;
    let supply_pa = drive.supply_pa();
    let half_stroke_m = 0.5 * drive.get(P::Stroke);
    Some(match parameter {
        P::CoulombFriction
        | P::StribeckForce
        | P::StribeckExcess
        | P::PreslidingForce
        | P::PositionFriction
        | P::AsymmetricExtending
        | P::AsymmetricRetracting => force(drive, value, ""),
        P::LoadSpringForce => force(drive, value, which(value, " against extending", " against retracting")),
        P::PositionFrictionSlope => {
            force(drive, value, which(value, " more with the rod out", " more with the rod in"))
        }
        P::PositionFrictionBow => force(drive, value, which(value, " more at both ends", " less at both ends")),
        P::PositionDragSlope => said(
            percent(value),
            which(value, "more viscous friction with the rod out", "more viscous friction with the rod in"),
        ),
        P::PositionDragBow => said(
            percent(value),
            which(value, "more viscous friction at both ends", "less viscous friction at both ends"),
        ),
        P::PressureFriction => {
            force(drive, value * supply_pa, &format!(" where both pressures add up to {}", bar(supply_pa)))
        }
        P::LoadSpring => force(
            drive,
            value * half_stroke_m,
            which(
                value,
                " at each end of the stroke, towards its middle",
                " at each end of the stroke, away from its middle",
            ),
        ),
        P::LoadSpringBow => force(
            drive,
            value * half_stroke_m.powi(2),
            which(value, " more against extending at both ends", " less against extending at both ends"),
        ),
        P::StribeckVelocity => {
            said(format!("{} mm/s", significant(1e3 * value, 2)), "where half of the excess is gone")
        }
        P::StopRetracted | P::StopExtended => {
            said(format!("{} mm", significant(1e3 * value, 3)), "is where the stop begins")
        }
        P::StopStiffness => said(format!("{} kN/mm", significant(1e-6 * value, 2)), "in the stop"),
        P::StopDamping => said(format!("{} N", significant(0.1 * value, 2)), "at 100 mm/s into the stop"),
        P::PreslidingStiffness => said(format!("{} N", significant(1e-6 * value, 2)), "per µm before the rod slides"),
        P::ViscosityLoss => {
            said(percent(value), which(value, "less viscosity in the end", "more viscosity in the end"))
        }
        P::ViscosityLossPerKelvin => said(percent(value), "less viscosity per kelvin"),
        P::ReferenceTemperature => {
            said(format!("{} °C", significant(value, 3)), "is the temperature of the file's values")
        }
        P::WarmingTime => (time(value), String::new()),
        _ => return None,
    })
}

fn sensing(drive: &Drive<'_>, parameter: Parameter, value: f64) -> Option<(String, String)> {
    use Parameter as P;
    let supply_pa = drive.supply_pa();
    Some(match parameter {
        P::BacklashPlay => {
            let share = percent(value / drive.get(P::Stroke));
            (format!("{} mm", significant(1e3 * value, 2)), format!(", {share} of the stroke"))
        }
        P::PressureAOffset | P::PressureBOffset => {
            let share = percent(value / supply_pa);
            (
                bar(value.abs()),
                format!(" {}, {share} of the supply pressure", which(value, "read too much", "read too little")),
            )
        }
        P::PressureAFactor | P::PressureBFactor | P::SpoolFactor | P::PositionFactor => {
            said(percent(value), which(value, "read too much", "read too little"))
        }
        P::SpoolOffset => travel(drive, value, which(value, "read too much", "read too little")),
        P::PositionLag | P::PositionDelay => (time(value), String::new()),
        _ => return None,
    })
}

fn said(amount: String, of: &str) -> (String, String) {
    (amount, format!(" {of}"))
}

/// A share of full spool travel, with the command that it takes.
fn travel(drive: &Drive<'_>, share: f64, what: &str) -> (String, String) {
    let command = share / drive.get(Parameter::ValveGain);
    let volts = if command.is_finite() { format!(" ({} V)", significant(command.abs(), 2)) } else { String::new() };
    (percent(share), format!(" of full spool travel{volts} {what}"))
}

fn flow(drive: &Drive<'_>, m3_per_s: f64, at: &str) -> (String, String) {
    let share = percent(drive.of_full_flow(m3_per_s));
    (format!("{} l/min", significant(6e4 * m3_per_s.abs(), 2)), format!(" {at}, {share} of full flow"))
}

fn at_full_flow(drive: &Drive<'_>, pa: f64) -> (String, String) {
    said(bar(pa), &format!("at a full flow of {} l/min", significant(6e4 * drive.full_flow_m3_per_s(), 2)))
}

fn force(drive: &Drive<'_>, newton: f64, where_to: &str) -> (String, String) {
    let size = newton.abs();
    let amount =
        if size < 1e4 { format!("{} N", significant(size, 3)) } else { format!("{} kN", significant(1e-3 * size, 3)) };
    let share = drive.of_full_force(newton).map(|share| format!(", {} of full force", percent(share)));
    (amount, format!("{where_to}{}", share.unwrap_or_default()))
}

fn bar(pa: f64) -> String {
    format!("{} bar", significant(1e-5 * pa, 2))
}

fn time(s: f64) -> String {
    match s.abs() {
        short if short < 1.0 => format!("{} ms", significant(1e3 * s, 2)),
        long if long >= 120.0 => format!("{} min", significant(s / 60.0, 2)),
        _ => format!("{} s", significant(s, 2)),
    }
}
