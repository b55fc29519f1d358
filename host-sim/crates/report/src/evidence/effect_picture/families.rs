//! The measurement that is drawn for each effect: one small measurement for each family.

use diagnosis::catalogue::{Hypothesis, Subsystem};
use model_core::machine::{Machine, Parameter};
use recording::Signal;

use super::view::{Law, Moment};

/// A measurement on a drive over one window: the values across and upwards, and the branch that the point belongs to.
type Point = fn(&Law, &Moment) -> Option<(f64, f64, i8)>;

/// A kind of picture.
pub(crate) struct Family {
    pub(crate) title: &'static str,
    pub(crate) caption: &'static str,
    pub(crate) x: (&'static str, &'static str),
    pub(crate) y: (&'static str, &'static str),
    /// Channels that must be recorded, so that the recorded drive can be drawn.
    pub(crate) needs: &'static [Signal],
    pub(crate) point: Point,
}

pub(crate) const PRESSURES: &[Signal] = &[Signal::PressureA, Signal::PressureB, Signal::Position];
const SPOOL: &[Signal] = &[Signal::Spool];
const BAR: f64 = 1e-5;
const MM: f64 = 1e3;
const L_PER_MIN: f64 = 6e4;
/// Slower than this the rod rests, m/s.
const RESTS: f64 = 5e-4;
/// Highest pressure above the tank's at which a chamber may be near its floor, Pa.
const LOW_PA: f64 = 1e6;
/// Opening below which an edge's law cannot be measured.
const OPEN: f64 = 0.02;

/// The picture of an effect. `after` shows which channel's sensor is off.
#[expect(clippy::too_many_lines, reason = "one entry a family")]
pub(crate) fn of(effect: &Hypothesis, after: &Machine<f64>) -> Family {
    match effect.name {
        "valve-hysteresis" | "spool-stiction" => Family {
            title: "Spool beside a linear valve, over the command",
            caption: "Recorded spool less that of the model after without the effect. Two branches: it was sent up last, or down last; hysteresis parts them by its width, at any rate.",
            x: ("command", "V"),
            y: ("spool − model without it", "% of travel"),
            needs: SPOOL,
            point: |_, m| Some((m.command_v, 100.0 * m.spool_off, m.turned)),
        },
        "solenoid-saturation" => Family {
            title: "Spool over the command",
            caption: "The static characteristic bends where the solenoid saturates.",
            x: ("command", "V"),
            y: ("spool", "% of travel"),
            needs: SPOOL,
            point: |_, m| Some((m.command_v, 100.0 * m.spool, 0)),
        },
        "null-drift" => Family {
            title: "Drift of the spool's neutral",
            caption: "Spool less that of the model without drift, since the recording's start.",
            x: ("time", "s"),
            y: ("spool − model without it", "% of travel"),
            needs: SPOOL,
            point: |_, m| Some((m.time_s, 100.0 * m.spool_off, 0)),
        },
        "flow-force" => Family {
            title: "Spool pushed closed, over the pressure difference at both open edges",
            caption: "In parts of its own travel; negative: closer than the model after without the effect.",
            x: ("pressure difference over the edges", "bar"),
            y: ("change of the spool", "% of its travel"),
            needs: &[Signal::Spool, Signal::PressureA, Signal::PressureB],
            point: |law, m| {
                let travel = m.spool.abs();
                (travel > 0.1).then(|| (BAR * edges(law, m), 100.0 * m.spool_off * m.spool.signum() / travel, 0))
            },
        },
        "dead-zone-asymmetry" | "flow-gain-nonlinearity" => Family {
            title: "Opening that the flow into A speaks for, over the spool",
            caption: "Flow over root of the pressure difference, A·v and the oil's compression, in parts of the flow coefficient.",
            x: ("spool", "% of travel"),
            y: ("opening of the edge at A", "% of travel"),
            needs: PRESSURES,
            point: |law, m| Some((100.0 * m.spool, 100.0 * opening_a(law, m)?, 0)),
        },
        "valve-leakage" => Family {
            title: "Flow into A about the centre of the valve",
            caption: "Within the overlap a tight valve passes nothing.",
            x: ("spool", "% of travel"),
            y: ("flow into A", "l/min"),
            needs: PRESSURES,
            point: |law, m| {
                (m.spool.abs() < 1.5 * law.dead_zone + 0.02).then(|| (100.0 * m.spool, L_PER_MIN * into_a(law, m), 0))
            },
        },
        "metering-asymmetry" => Family {
            title: "Tank edge against supply edge",
            caption: "Openings that the flows into and out of the cylinder speak for; a way whose two edges are of one size lies on the diagonal.",
            x: ("opening of the supply edge", "% of travel"),
            y: ("opening of the tank edge", "% of travel"),
            needs: PRESSURES,
            point: |law, m| {
                let (a, b) = (opening_a(law, m)?.abs(), opening_b(law, m)?.abs());
                let (supply, tank) = if m.spool > 0.0 { (a, b) } else { (b, a) };
                (m.spool.abs() > law.dead_zone + OPEN).then_some((100.0 * supply, 100.0 * tank, 0))
            },
        },
        "supply-droop" => Family {
            title: "Pressure lost before the supply edge, over the flow",
            caption: "Supply pressure of the machine file, less the pressure in the chamber, less the edge's own drop.",
            x: ("flow from the supply", "l/min"),
            y: ("pressure lost", "bar"),
            needs: PRESSURES,
            point: |law, m| {
                let (flow, chamber) =
                    if m.spool > 0.0 { (into_a(law, m), m.a_pa) } else { (-out_of_b(law, m), m.b_pa) };
                let lost = law.supply_pa - chamber - drop(law, m, flow)?;
                Some((L_PER_MIN * flow, BAR * lost, 0))
            },
        },
        "tank-back-pressure" => Family {
            title: "Pressure behind the tank edge, over the flow",
            caption: "Pressure in the chamber that empties, less the edge's own drop, above the tank's.",
            x: ("flow to the tank", "l/min"),
            y: ("back pressure", "bar"),
            needs: PRESSURES,
            point: |law, m| {
                let (flow, chamber) =
                    if m.spool > 0.0 { (out_of_b(law, m), m.b_pa) } else { (-into_a(law, m), m.a_pa) };
                let lost = chamber - law.tank_pa - drop(law, m, flow)?;
                Some((L_PER_MIN * flow, BAR * lost, 0))
            },
        },
        "counterbalance" => Family {
            title: "Pressure lost on the way out of a chamber, over the other chamber's pressure",
            caption: "Pressure in the chamber that empties, less the edge's own drop, above the tank's. A load-holding valve opens the wider the higher the other side's pressure.",
            x: ("pressure in the other chamber", "bar"),
            y: ("pressure lost", "bar"),
            needs: PRESSURES,
            point: |law, m| {
                let (flow, chamber, other) =
                    if m.spool > 0.0 { (out_of_b(law, m), m.b_pa, m.a_pa) } else { (-into_a(law, m), m.a_pa, m.b_pa) };
                let lost = chamber - law.tank_pa - drop(law, m, flow)?;
                Some((BAR * other, BAR * lost, 0))
            },
        },
        "laminar-transition" => Family {
            title: "Flow of the edge at A against the root law, over its pressure difference",
            caption: "1 is the turbulent law; at small pressure differences a laminar edge passes less.",
            x: ("pressure difference", "bar"),
            y: ("flow over root law", "1"),
            needs: PRESSURES,
            point: |law, m| {
                let open = m.spool.abs() - law.dead_zone;
                let (_, over) = edge_a(law, m);
                (open > OPEN).then(|| {
                    (
                        BAR * over.abs(),
                        into_a(law, m).abs() / (law.flow_coefficient * open * over.abs().max(1.0).sqrt()),
                        0,
                    )
                })
            },
        },
        "pump-slip" => Family {
            title: "Flow that the pump lacks, over the pressure that it works against",
            caption: "Flow of the model's ports less the flow into the chamber that is filled.",
            x: ("pressure", "bar"),
            y: ("missing flow", "l/min"),
            needs: PRESSURES,
            point: |law, m| {
                let fills_a = m.port_a > 0.0;
                let (missing, pressure) =
                    if fills_a { (missing_a(law, m), m.a_pa) } else { (-missing_b(law, m), m.b_pa) };
                (m.pump_rev_per_s.abs() > 1.0).then_some((BAR * (pressure - law.tank_pa), L_PER_MIN * missing, 0))
            },
        },
        "internal-leakage" => Family {
            title: "Flow missing from A, over the pressure across the piston",
            caption: "What the ports pass into A less what moves the piston and compresses the oil; at closed edges the clearest.",
            x: ("pressure A − pressure B", "bar"),
            y: ("missing flow", "l/min"),
            needs: PRESSURES,
            point: |law, m| nearly_closed(law, m).then(|| (BAR * (m.a_pa - m.b_pa), L_PER_MIN * missing_a(law, m), 0)),
        },
        "external-leakage" => Family {
            title: "Flow missing from a chamber, over its pressure",
            caption: "What the ports pass in less what moves the piston and compresses the oil, of the chamber that leaks most.",
            x: ("pressure", "bar"),
            y: ("missing flow", "l/min"),
            needs: PRESSURES,
            point: if after.get(Parameter::ExternalLeakageA) >= after.get(Parameter::ExternalLeakageB) {
                |law, m| nearly_closed(law, m).then(|| (BAR * m.a_pa, L_PER_MIN * missing_a(law, m), 0))
            } else {
                |law, m| nearly_closed(law, m).then(|| (BAR * m.b_pa, L_PER_MIN * missing_b(law, m), 0))
            },
        },
        "entrained-air" | "hose-compliance" => Family {
            title: "Stiffness of chamber A, over its pressure",
            caption: "Flow that is compressed over the rate of pressure, as the bulk modulus that the chamber's volume would have.",
            x: ("pressure A", "bar"),
            y: ("effective bulk modulus", "MPa"),
            needs: PRESSURES,
            point: |law, m| {
                let compressed = m.port_a - law.by.area.0 * m.velocity;
                let modulus = law.machine.get(Parameter::VolumeA) * m.a_rate / compressed;
                let fast = m.a_rate.abs() > law.supply_pa && compressed * m.a_rate > 0.0;
                let sensible = modulus < 4.0 * law.machine.get(Parameter::BulkModulus);
                (fast && sensible).then_some((BAR * m.a_pa, 1e-6 * modulus, 0))
            },
        },
        "cavitation" => Family {
            title: "Pressure in the emptier chamber, over the flow that is drawn from it",
            caption: "What the piston makes room for less what the port passes in. At the floor the pressure no longer falls, whatever is drawn.",
            x: ("flow drawn from the chamber", "l/min"),
            y: ("pressure", "bar"),
            needs: PRESSURES,
            point: |law, m| {
                let (pressure, drawn) = if m.a_pa < m.b_pa {
                    (m.a_pa, law.by.area.0 * m.velocity - m.port_a)
                } else {
                    (m.b_pa, m.port_b - law.by.area.1 * m.velocity)
                };
                (pressure < law.tank_pa + LOW_PA).then_some((L_PER_MIN * drawn, BAR * pressure, 0))
            },
        },
        "position-dependent-volume" => Family {
            title: "Volume that chamber A acts with, over the position",
            caption: "Flow that is compressed over the rate of pressure, times the bulk modulus.",
            x: ("position", "mm"),
            y: ("effective volume", "cm³"),
            needs: PRESSURES,
            point: |law, m| {
                let compressed = m.port_a - law.by.area.0 * m.velocity;
                let volume = compressed * law.machine.get(Parameter::BulkModulus) / m.a_rate;
                let sensible = volume > 0.0 && volume < 5.0 * law.machine.get(Parameter::VolumeA);
                (m.a_rate.abs() > law.supply_pa && sensible).then_some((MM * m.position_m, 1e6 * volume, 0))
            },
        },
        "coulomb-friction" | "stribeck-friction" | "friction-asymmetry" | "presliding" => Family {
            title: "Force that brakes the rod, over the velocity",
            caption: "Balance of forces: the oil's or the measured one and the load, less inertia and viscous friction.",
            x: ("velocity", "mm/s"),
            y: ("braking force", "N"),
            needs: PRESSURES,
            point: |law, m| (m.velocity.abs() > RESTS).then(|| (MM * m.velocity, braking(law, m), 0)),
        },
        "pressure-dependent-friction" => Family {
            title: "Friction over the sum of both pressures",
            caption: "Force against motion beside viscous friction.",
            x: ("pressure A + pressure B", "bar"),
            y: ("friction", "N"),
            needs: PRESSURES,
            point: |law, m| {
                let moves = m.velocity.abs() > 4.0 * RESTS;
                moves.then(|| (BAR * (m.a_pa + m.b_pa), braking(law, m) * m.velocity.signum(), 0))
            },
        },
        "position-dependent-friction" if is_viscous(after) => {
            viscous("Viscous friction over the position", ("position", "mm"), |law, m| {
                drag(law, m).map(|drag| (MM * m.position_m, drag, 0))
            })
        }
        "position-dependent-friction" => Family {
            title: "Friction over the position",
            caption: "Force against motion beside viscous friction.",
            x: ("position", "mm"),
            y: ("friction", "N"),
            needs: PRESSURES,
            point: |law, m| {
                let moves = m.velocity.abs() > 4.0 * RESTS;
                moves.then(|| (MM * m.position_m, braking(law, m) * m.velocity.signum(), 0))
            },
        },
        "position-dependent-load" | "end-stop" => Family {
            title: "Force against extending, over the position",
            caption: "Balance of forces: the oil's or the measured one and the load, less inertia and viscous friction.",
            x: ("position", "mm"),
            y: ("force", "N"),
            needs: PRESSURES,
            point: |law, m| Some((MM * m.position_m, braking(law, m), 0)),
        },
        "oil-temperature" => oil(after),
        "linkage-backlash" => Family {
            title: "Sensed position beside that of a perfect sensor, over the velocity",
            caption: "Play shifts what is sensed against the way that the rod moves.",
            x: ("velocity", "mm/s"),
            y: ("position − model without it", "mm"),
            needs: &[Signal::Position],
            point: |_, m| Some((MM * m.velocity, MM * m.position_off_m, 0)),
        },
        "position-sensor-lag" => Family {
            title: "Sensed position beside that of a perfect sensor, over the velocity",
            caption: "A lag of the sensor leaves velocity times its time behind.",
            x: ("velocity", "mm/s"),
            y: ("position − model without it", "mm"),
            needs: &[Signal::Position],
            point: |_, m| (m.velocity.abs() > RESTS).then_some((MM * m.velocity, MM * m.position_off_m, 0)),
        },
        "sensor-offset" => sensor(after),
        _ => lacking_motion(effect),
    }
}

/// Viscous friction over what the oil's viscosity depends on: its measured temperature, or the time.
fn oil(after: &Machine<f64>) -> Family {
    if after.get(Parameter::ViscosityLossPerKelvin) > 0.0 {
        viscous("Viscous friction over the oil's temperature", ("oil temperature", "°C"), |law, m| {
            m.oil_c.zip(drag(law, m)).map(|(oil_c, drag)| (oil_c, drag, 0))
        })
    } else {
        viscous("Viscous friction since the start", ("time", "s"), |law, m| {
            drag(law, m).map(|drag| (m.time_s, drag, 0))
        })
    }
}

fn viscous(title: &'static str, x: (&'static str, &'static str), point: Point) -> Family {
    Family {
        title,
        caption: "Force against motion over velocity, while the rod moves.",
        x,
        y: ("viscous friction", "kN s/m"),
        needs: PRESSURES,
        point,
    }
}

/// Viscous friction, kN s/m; no value while the rod hardly moves.
fn drag(law: &Law, m: &Moment) -> Option<f64> {
    /// m/s
    const FAST: f64 = 0.03;
    (m.velocity.abs() > FAST).then(|| 1e-3 * (braking(law, m) / m.velocity + law.by.damping))
}

/// Whether the viscous friction is what changes along the stroke.
fn is_viscous(after: &Machine<f64>) -> bool {
    after.get(Parameter::PositionDragSlope) != 0.0 || after.get(Parameter::PositionDragBow) != 0.0
}

/// The reading of the sensor that is off less the model before, for this channel.
fn sensor(after: &Machine<f64>) -> Family {
    let is_off = |offset, factor| after.get(offset) != 0.0 || after.get(factor) != 0.0;
    let family = |x, y, needs, point| Family {
        title: "What the sensor reads beside a right one",
        caption: "A constant shifts all readings alike; a wrong gain tilts them.",
        x,
        y,
        needs,
        point,
    };
    let bar = ("reading − model without it", "bar");
    if is_off(Parameter::PressureAOffset, Parameter::PressureAFactor) {
        family(("pressure A", "bar"), bar, &[Signal::PressureA], |_, m| Some((BAR * m.a_pa, BAR * m.a_off_pa, 0)))
    } else if is_off(Parameter::PressureBOffset, Parameter::PressureBFactor) {
        family(("pressure B", "bar"), bar, &[Signal::PressureB], |_, m| Some((BAR * m.b_pa, BAR * m.b_off_pa, 0)))
    } else if is_off(Parameter::SpoolOffset, Parameter::SpoolFactor) {
        let y = ("reading − model without it", "% of travel");
        family(("spool", "% of travel"), y, SPOOL, |_, m| Some((100.0 * m.spool, 100.0 * m.spool_off, 0)))
    } else {
        let y = ("reading − model without it", "mm");
        family(("position", "mm"), y, &[Signal::Position], |_, m| Some((MM * m.position_m, MM * m.position_off_m, 0)))
    }
}

/// The motion that the model before lacks, which can always be drawn.
pub(crate) fn lacking_motion(effect: &Hypothesis) -> Family {
    let family = |x, point| Family {
        title: "Velocity that the model lacks without the effect",
        caption: "Sensed velocity less that of the model after without the effect; the curves: what the models before and after make of it.",
        x,
        y: ("lacking velocity", "mm/s"),
        needs: &[Signal::Position],
        point,
    };
    match (effect.subsystem, effect.name) {
        (_, "oil-temperature" | "null-drift") => family(("time", "s"), |_, m| Some((m.time_s, MM * m.velocity_off, 0))),
        (Subsystem::Valve, _) => family(("command", "V"), |_, m| Some((m.command_v, MM * m.velocity_off, m.turned))),
        (Subsystem::Flow, _) => family(("command", "V"), |_, m| Some((m.command_v, MM * m.velocity_off, 0))),
        (_, "position-dependent-friction" | "position-dependent-load" | "end-stop" | "position-dependent-volume") => {
            family(("position", "mm"), |_, m| Some((MM * m.position_m, MM * m.velocity_off, 0)))
        }
        _ => family(("velocity", "mm/s"), |_, m| Some((MM * m.velocity, MM * m.velocity_off, 0))),
    }
}

/// Force on the rod that neither the oil or what was measured in its place, nor inertia, nor viscous friction explain, positive against extending, N.
fn braking(law: &Law, m: &Moment) -> f64 {
    m.force_n + law.by.load + m.load_n - law.by.mass * m.acceleration - law.by.damping * m.velocity
}

fn into_a(law: &Law, m: &Moment) -> f64 {
    law.by.area.0 * m.velocity + law.by.capacity.0 * m.a_rate
}

fn out_of_b(law: &Law, m: &Moment) -> f64 {
    law.by.area.1 * m.velocity - law.by.capacity.1 * m.b_rate
}

fn missing_a(law: &Law, m: &Moment) -> f64 {
    m.port_a - into_a(law, m)
}

/// Into B: the flow through the port less the flow that the chamber takes up.
fn missing_b(law: &Law, m: &Moment) -> f64 {
    out_of_b(law, m) - m.port_b
}

/// Whether the edges pass so little oil that an error of their law does not hide a leak.
fn nearly_closed(law: &Law, m: &Moment) -> bool {
    m.spool.abs() < law.dead_zone + OPEN
}

/// Direction of the flow at A, and its pressure difference.
fn edge_a(law: &Law, m: &Moment) -> (f64, f64) {
    if m.spool > 0.0 { (1.0, m.supply_pa - m.a_pa) } else { (-1.0, m.a_pa - law.tank_pa) }
}

/// Opening at A, with the sign of the flow.
fn opening_a(law: &Law, m: &Moment) -> Option<f64> {
    let (_, over) = edge_a(law, m);
    (over > 1e5).then(|| into_a(law, m) / (law.flow_coefficient * over.sqrt()))
}

fn opening_b(law: &Law, m: &Moment) -> Option<f64> {
    let over = if m.spool > 0.0 { m.b_pa - law.tank_pa } else { m.supply_pa - m.b_pa };
    (over > 1e5).then(|| out_of_b(law, m) / (law.flow_coefficient * over.sqrt()))
}

/// Pressure drop of the edge itself at this flow, Pa.
fn drop(law: &Law, m: &Moment, flow: f64) -> Option<f64> {
    let open = m.spool.abs() - law.dead_zone;
    (open > 4.0 * OPEN && flow > 0.0).then(|| (flow / (law.flow_coefficient * open)).powi(2))
}

/// Sum of the pressure differences over both open edges, Pa.
fn edges(law: &Law, m: &Moment) -> f64 {
    if m.spool > 0.0 {
        m.supply_pa - m.a_pa + m.b_pa - law.tank_pa
    } else {
        m.supply_pa - m.b_pa + m.a_pa - law.tank_pa
    }
}

#[cfg(test)]
mod tests {
    use diagnosis::catalogue::CATALOGUE;
    use model_core::machine::Source;

    use super::*;

    #[test]
    fn every_effect_of_the_catalogue_has_a_picture_of_its_own() {
        let machine = Machine::with_defaults(Source::Valve);
        for effect in CATALOGUE {
            let family = of(effect, &machine);
            assert_ne!(family.title, lacking_motion(effect).title, "{}", effect.name);
            assert!(!family.x.0.is_empty() && !family.y.1.is_empty() && !family.needs.is_empty(), "{}", effect.name);
        }
    }
}
