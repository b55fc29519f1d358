//! Which links a recording can test: a link is tested where both its input and its output are measured.

use diagnosis::catalogue::Subsystem;
use model_core::machine::Source;
use recording::Signal;
use simulation::{InputPoint, computed_below};

/// How well a recording can test a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Alone: a misfit is caused there.
    Alone {
        /// Where the model is driven.
        input_point: InputPoint,
        /// The signals by which it is judged.
        judged: Vec<Signal>,
    },
    /// Together with others: a misfit may be caused in any of them.
    Together {
        /// Where the model is driven.
        input_point: InputPoint,
        /// The signals by which they are judged.
        judged: Vec<Signal>,
    },
    /// Not at all.
    No,
}

/// One link, and how well a recording can test it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkTest {
    /// The link.
    pub link: Subsystem,
    /// How well it is tested.
    pub reach: Reach,
    /// Signals that would also have to be recorded to test it alone; empty where it is tested alone.
    pub missing: Vec<Signal>,
    /// Signals of which one is sufficient to test it together with other links; empty where it is tested, or where more than one is needed.
    pub enough: Vec<Signal>,
}

/// What has to be measured to test a link by itself.
struct Way {
    input_point: InputPoint,
    needs: &'static [Signal],
    judged: &'static [Signal],
}

use Signal::{Command, Flow, Force, Position, PressureA, PressureB, PumpSpeed, Spool, Velocity};

/// Signals that may be added to a recording, the most usual first.
const ENOUGH: [Signal; 6] = [Command, Spool, PumpSpeed, Position, PressureA, PressureB];

const MOTION: &[Signal] = &[Position, Velocity];

/// What moves from a force on.
fn by_force() -> Vec<Way> {
    let by = |needs| Way { input_point: InputPoint::Force, needs, judged: MOTION };
    vec![by(&[PressureA, PressureB, Position]), by(&[Force, Position])]
}

fn ways(link: Subsystem, source: Source) -> Vec<Way> {
    const PRESSURES: &[Signal] = &[PressureA, PressureB];
    let way = |input_point, needs, judged| Way { input_point, needs, judged };
    // A pump's speed replaces the spool, and a force all above it.
    let (feed, with_pressures): (InputPoint, &'static [Signal]) = match source {
        Source::Force => return by_force(),
        Source::Valve => (InputPoint::Spool, &[Spool, PressureA, PressureB, Position]),
        Source::Pump => (InputPoint::Pump, &[PumpSpeed, PressureA, PressureB, Position]),
    };
    match link {
        Subsystem::Valve => vec![way(InputPoint::Command, &[Command, Spool], &[Spool])],
        // Two sensors of the same motion have to agree.
        Subsystem::Flow | Subsystem::Sensing => vec![way(feed, with_pressures, MOTION)],
        Subsystem::Chambers => vec![
            way(feed, with_pressures, PRESSURES),
            way(InputPoint::Flow, &[Flow, PressureA, PressureB, Position], PRESSURES),
        ],
        Subsystem::Mechanics => by_force(),
    }
}

/// Every link of a drive with this source, in the model's order, and how well the signals test it.
#[must_use]
pub(crate) fn links(source: Source, has: impl Fn(Signal) -> bool) -> Vec<LinkTest> {
    let all = [Subsystem::Valve, Subsystem::Flow, Subsystem::Chambers, Subsystem::Mechanics, Subsystem::Sensing];
    let of_drive = all.into_iter().filter(|link| match source {
        Source::Valve => true,
        Source::Pump => *link != Subsystem::Valve,
        Source::Force => matches!(link, Subsystem::Mechanics | Subsystem::Sensing),
    });
    of_drive.map(|link| tested(link, source, &has)).collect()
}

fn tested(link: Subsystem, source: Source, has: &impl Fn(Signal) -> bool) -> LinkTest {
    // A velocity is sufficient where a position is missing.
    let there = |signal: Signal| has(signal) || (signal == Position && has(Velocity));
    let lacks = |way: &Way| way.needs.iter().copied().filter(|signal| !there(*signal)).collect::<Vec<_>>();
    let nearest = ways(link, source).into_iter().min_by_key(|way| lacks(way).len());
    let Some(way) = nearest else {
        return LinkTest { link, reach: Reach::No, missing: Vec::new(), enough: Vec::new() };
    };
    let missing = lacks(&way);
    let reach = if missing.is_empty() {
        let judged = way.judged.iter().copied().filter(|signal| has(*signal)).collect();
        Reach::Alone { input_point: way.input_point, judged }
    } else {
        together(link, source, has)
    };
    let reaches = |one: &Signal| together(link, source, &|signal| signal == *one || has(signal)) != Reach::No;
    let enough = if reach == Reach::No { ENOUGH.into_iter().filter(reaches).collect() } else { Vec::new() };
    LinkTest { link, reach, missing, enough }
}

/// The drive input furthest upstream, if it lies above the link and something below the link is measured.
fn together(link: Subsystem, source: Source, has: &impl Fn(Signal) -> bool) -> Reach {
    let input_points = match source {
        Source::Valve => &[(InputPoint::Command, Command), (InputPoint::Spool, Spool), (InputPoint::Flow, Flow)][..],
        Source::Pump => &[(InputPoint::Pump, PumpSpeed), (InputPoint::Flow, Flow)],
        // Whatever is measured of a mass and its force tests the mass alone.
        Source::Force => &[],
    };
    let Some((input_point, _)) = input_points.iter().find(|(_, signal)| has(*signal)) else { return Reach::No };
    let (above, below): (&[InputPoint], &[Signal]) = match link {
        Subsystem::Valve => (&[InputPoint::Command], computed_below(InputPoint::Command)),
        Subsystem::Flow => (
            &[InputPoint::Command, InputPoint::Spool, InputPoint::Pump],
            &[Flow, PressureA, PressureB, Velocity, Position],
        ),
        Subsystem::Chambers => (
            &[InputPoint::Command, InputPoint::Spool, InputPoint::Pump, InputPoint::Flow],
            &[PressureA, PressureB, Velocity, Position],
        ),
        Subsystem::Mechanics | Subsystem::Sensing => {
            (&[InputPoint::Command, InputPoint::Spool, InputPoint::Pump, InputPoint::Flow], &[Velocity, Position])
        }
    };
    let computed = computed_below(*input_point);
    let judged: Vec<Signal> =
        below.iter().copied().filter(|signal| has(*signal) && computed.contains(signal)).collect();
    if above.contains(input_point) && !judged.is_empty() {
        Reach::Together { input_point: *input_point, judged }
    } else {
        Reach::No
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reached(signals: &[Signal], source: Source) -> Vec<(Subsystem, &'static str, Vec<Signal>)> {
        let name = |reach: &Reach| match reach {
            Reach::Alone { .. } => "alone",
            Reach::Together { .. } => "together",
            Reach::No => "no",
        };
        let found = links(source, |signal| signals.contains(&signal));
        found.into_iter().map(|test| (test.link, name(&test.reach), test.missing)).collect()
    }

    #[test]
    fn with_everything_measured_every_link_is_tested_by_itself() {
        let found = reached(&[Command, Spool, PressureA, PressureB, Position], Source::Valve);
        assert_eq!(found.len(), 5);
        assert!(found.iter().all(|(_, reach, missing)| *reach == "alone" && missing.is_empty()), "{found:?}");
    }

    #[test]
    fn without_pressures_all_below_the_spool_is_one() {
        let found = reached(&[Command, Spool, Position], Source::Valve);
        assert_eq!(found[0], (Subsystem::Valve, "alone", vec![]));
        for (link, reach, missing) in &found[1..] {
            assert_eq!(
                (*reach, missing.as_slice()),
                if *link == Subsystem::Mechanics {
                    ("together", &[Force][..])
                } else {
                    ("together", &[PressureA, PressureB][..])
                }
            );
        }
    }

    #[test]
    fn one_signal_more_tests_links_together() {
        let enough = |signals: &[Signal]| {
            let found = links(Source::Valve, |signal| signals.contains(&signal));
            found.into_iter().map(|test| test.enough).collect::<Vec<_>>()
        };
        let mechanics = vec![Command, Spool];
        assert_eq!(
            enough(&[Position]),
            [vec![Command], vec![Command, Spool], vec![Command, Spool], mechanics.clone(), mechanics]
        );
        assert_eq!(enough(&[Command])[0], [Spool, Position, PressureA, PressureB]);
        assert_eq!(enough(&[]), vec![vec![]; 5]);
    }

    #[test]
    fn a_command_alone_tests_nothing() {
        let found = reached(&[Command], Source::Valve);
        assert!(found.iter().all(|(_, reach, missing)| *reach == "no" && !missing.is_empty()), "{found:?}");
    }

    #[test]
    fn a_mass_that_a_force_moves_has_neither_valve_nor_oil_to_test() {
        let links = [Subsystem::Mechanics, Subsystem::Sensing];
        for by in [&[Force, Velocity][..], &[PressureA, PressureB, Position], &[Force, PressureA, Position]] {
            assert_eq!(reached(by, Source::Force), links.map(|link| (link, "alone", vec![])));
        }
        assert_eq!(reached(&[Position, Command], Source::Force), links.map(|link| (link, "no", vec![Force])));
    }

    #[test]
    fn a_pump_drive_has_no_proportional_valve_to_test() {
        let found = reached(&[PumpSpeed, PressureA, PressureB, Position], Source::Pump);
        assert!(found.iter().all(|(link, reach, _)| *link != Subsystem::Valve && *reach == "alone"), "{found:?}");
    }
}
