//! Forces in time that come from outside the drive, in the shapes that they have: the load of each recording, pushes, a periodic force, a structure
//! that rings.

use std::f64::consts::TAU;

use identification::experiment::Prepared;
use model_core::machine::{Machine, Parameter};
use recording::Signal;
use simulation::between_rows;

/// What a force follows.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// Another load in each recording.
    Load,
    /// Pushes, at most one in a recording.
    Pushes(Vec<Window>),
    /// Periodic in time.
    Periodic {
        /// Frequency, Hz.
        hz: f64,
    },
    /// A mass on a spring and a damper that hangs on the rod.
    Structure {
        /// Its frequency while the rod stands, Hz.
        hz: f64,
        /// Its damping as a share of critical damping.
        damping: f64,
        /// Whether the machine file's moving mass has it in it.
        is_included: bool,
    },
}

/// When a push acts: nodes of a recording's force, between which it is linear. Outside them there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    /// The recording.
    pub(super) case: usize,
    /// The first node with a force.
    pub(super) first: usize,
    /// The last one.
    pub(super) last: usize,
}

/// Largest mass of a structure that the moving mass has in it, as a share of that.
const MOST_INCLUDED: f64 = 0.9;
/// The same of one beside it.
const MOST_BESIDE: f64 = 50.0;
/// Frequencies of a periodic force, Hz.
pub(super) const PERIODIC_HZ: (f64, f64) = (1.0, 60.0);
/// Frequencies of a structure, Hz.
pub(super) const STRUCTURE_HZ: (f64, f64) = (2.0, 60.0);
/// Dampings of a structure: with more it does not ring.
const DAMPING: (f64, f64) = (1e-3, 0.3);
/// Nodes of the force of a recording.
pub(super) const NODES: usize = 60;
/// A structure's acceleration is seen up to this many times its frequency: above, differences show a sensor's noise alone.
const SEEN_TO: f64 = 4.0;

/// Force of one amount of a shape in one recording, N at each point of its grid for an amount of 1.
pub(super) struct Unit {
    /// Which amount.
    pub(super) amount: usize,
    /// The recording.
    pub(super) case: usize,
    /// N per amount.
    pub(super) force_n: Vec<f64>,
}

impl Shape {
    /// Which of the shapes it is.
    pub(super) fn kind(&self) -> std::mem::Discriminant<Self> {
        std::mem::discriminant(self)
    }

    /// Number of amounts over this many recordings.
    pub(super) fn amounts(&self, cases: usize) -> usize {
        match self {
            Self::Load => cases,
            Self::Pushes(windows) => windows.iter().map(Window::nodes).sum(),
            Self::Periodic { .. } => 2 * cases,
            Self::Structure { .. } => 1,
        }
    }

    /// Values that shape it: a refit moves them by shares of themselves.
    pub(super) fn shaping(&self) -> usize {
        match self {
            Self::Load | Self::Pushes(_) => 0,
            Self::Periodic { .. } => 1,
            Self::Structure { .. } => 2,
        }
    }

    /// With the shaping value of this index moved by a share of itself.
    pub(super) fn moved(&self, index: usize, share: f64) -> Self {
        match (self, index) {
            (&Self::Periodic { hz }, _) => Self::Periodic { hz: within(PERIODIC_HZ, hz * (1.0 + share)) },
            (&Self::Structure { hz, damping, is_included }, 0) => {
                Self::Structure { hz: within(STRUCTURE_HZ, hz * (1.0 + share)), damping, is_included }
            }
            (&Self::Structure { hz, damping, is_included }, _) => {
                Self::Structure { hz, damping: within(DAMPING, damping * (1.0 + share)), is_included }
            }
            (other, _) => other.clone(),
        }
    }

    /// Whether its shaping values are within their ranges: a structure at an end of them does not ring.
    pub(super) fn is_within(&self) -> bool {
        let inside = |(low, high): (f64, f64), value: f64| low < value && value < high;
        match *self {
            Self::Load | Self::Pushes(_) => true,
            Self::Periodic { hz } => inside(PERIODIC_HZ, hz),
            Self::Structure { hz, damping, .. } => inside(STRUCTURE_HZ, hz) && inside(DAMPING, damping),
        }
    }

    /// Whether an amount cannot be negative.
    pub(super) fn is_positive(&self) -> bool {
        matches!(self, Self::Structure { .. })
    }

    /// The largest amount on a machine: a structure is no heavier than what it is a part of; beside that it may be a machine frame. Its force comes from
    /// the recorded motion, so that without a limit it would make the model follow whatever was recorded.
    pub(super) fn most(&self, machine: &Machine<f64>) -> f64 {
        let moving_kg = machine.get(Parameter::MovingMass);
        match self {
            Self::Structure { is_included: true, .. } => MOST_INCLUDED * moving_kg,
            Self::Structure { .. } => MOST_BESIDE * moving_kg,
            _ => f64::INFINITY,
        }
    }

    /// The force of each amount in each recording where it acts.
    pub(super) fn units(&self, cases: &[&Prepared]) -> Vec<Unit> {
        let everywhere = 0..cases.len();
        match self {
            Self::Load => everywhere
                .map(|case| Unit { amount: case, case, force_n: vec![1.0; cases[case].stimulus.points()] })
                .collect(),
            Self::Pushes(windows) => {
                let nodes =
                    windows.iter().flat_map(|window| (window.first..=window.last).map(|node| (window.case, node)));
                nodes
                    .enumerate()
                    .map(|(amount, (case, node))| Unit { amount, case, force_n: at_node(cases[case], node) })
                    .collect()
            }
            &Self::Periodic { hz } => everywhere
                .flat_map(|case| {
                    let wave = move |phase: f64| {
                        each_point(cases[case], |time_s| libm::cos(TAU * (hz * time_s + phase))).collect::<Vec<f64>>()
                    };
                    [0.0, 0.25].into_iter().enumerate().map(move |(part, phase)| Unit {
                        amount: 2 * case + part,
                        case,
                        force_n: wave(phase),
                    })
                })
                .collect(),
            &Self::Structure { hz, damping, is_included } => everywhere
                .filter_map(|case| {
                    let force_n = of_structure(cases[case], hz, damping, is_included)?;
                    Some(Unit { amount: 0, case, force_n })
                })
                .collect(),
        }
    }
}

impl Window {
    /// Nodes with a force.
    pub(super) fn nodes(&self) -> usize {
        self.last + 1 - self.first
    }

    /// From when to when, s after the start of the recording.
    pub(super) fn time_s(&self, case: &Prepared) -> (f64, f64) {
        let apart_s = between_nodes_s(case);
        ((self.first as f64 - 1.0).max(0.0) * apart_s, ((self.last as f64 + 1.0) * apart_s).min(case.duration_s()))
    }
}

fn within((low, high): (f64, f64), value: f64) -> f64 {
    value.clamp(low, high)
}

/// Time between two nodes, s.
fn between_nodes_s(case: &Prepared) -> f64 {
    case.duration_s() / NODES as f64
}

/// 1 at a node, falling to 0 at the nodes beside it.
fn at_node(case: &Prepared, node: usize) -> Vec<f64> {
    let apart_s = between_nodes_s(case);
    each_point(case, |time_s| (1.0 - (time_s / apart_s - node as f64).abs()).max(0.0)).collect()
}

/// Something at the time of each point, s after the start.
fn each_point<'a>(case: &Prepared, of_time: impl Fn(f64) -> f64 + 'a) -> impl Iterator<Item = f64> + 'a {
    let tick_s = case.stimulus.tick.seconds();
    (0..case.stimulus.points()).map(move |point| of_time(point as f64 * tick_s))
}

/// Force on the rod of each kilogram that hangs on it by a spring and a damper. Where it is included in the moving mass, that mass lacks the force by
/// which it would follow the rod if it were fixed to it. By the recorded position; `None` where there is none.
fn of_structure(case: &Prepared, hz: f64, damping: f64, is_included: bool) -> Option<Vec<f64>> {
    let position = case.channels.iter().find(|channel| channel.signal == Signal::Position)?;
    let tick_s = case.stimulus.tick.seconds();
    let times_s = (0..case.stimulus.points()).map(|point| case.time_s[0] + point as f64 * tick_s);
    let rod_m = smooth(&between_rows(&case.time_s, &position.bridged(), times_s), SEEN_TO * hz * tick_s);
    let omega = TAU * hz;
    let last = rod_m.len() - 1;
    let velocity = |point: usize| {
        let (before, next) = (point.saturating_sub(1), (point + 1).min(last));
        (rod_m[next] - rod_m[before]) / ((next - before).max(1) as f64 * tick_s)
    };
    let (mut mass_m, mut mass_m_per_s) = (rod_m[0], velocity(0));
    let mut force_n = Vec::with_capacity(rod_m.len());
    for point in 0..=last {
        let rod_m_per_s = velocity(point);
        // At the ends nothing tells it.
        let is_end = point == 0 || point == last;
        let of_rod =
            if is_end { 0.0 } else { (rod_m[point + 1] - 2.0 * rod_m[point] + rod_m[point - 1]) / tick_s.powi(2) };
        let of_mass = omega * omega * (rod_m[point] - mass_m) + 2.0 * damping * omega * (rod_m_per_s - mass_m_per_s);
        force_n.push(if is_included { of_rod - of_mass } else { -of_mass });
        // Velocity first: then an undamped mass keeps its energy.
        mass_m_per_s += of_mass * tick_s;
        mass_m += mass_m_per_s * tick_s;
    }
    Some(force_n)
}

/// A series without what is faster than this many cycles a point, without a delay: a lag of second order forwards and backwards.
fn smooth(series: &[f64], cycles_a_point: f64) -> Vec<f64> {
    let pass = |series: &mut dyn Iterator<Item = f64>, start: f64| -> Vec<f64> {
        let keep = libm::exp(-TAU * cycles_a_point);
        let (mut first, mut second) = (start, start);
        series
            .map(|value| {
                first += (1.0 - keep) * (value - first);
                second += (1.0 - keep) * (first - second);
                second
            })
            .collect()
    };
    let forwards = pass(&mut series.iter().copied(), series.first().copied().unwrap_or(0.0));
    let mut backwards = pass(&mut forwards.iter().rev().copied(), forwards.last().copied().unwrap_or(0.0));
    backwards.reverse();
    backwards
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use test_press::{extending, press};

    use super::*;

    fn case() -> Prepared {
        let machine = press(&[]);
        Prepared::new(&extending(&machine), &machine, LoadSource::Constant, None).unwrap()
    }

    /// What a shape gives with every amount 1.
    fn sum(shape: &Shape, case: &Prepared) -> Vec<f64> {
        let mut sum = vec![0.0; case.stimulus.points()];
        for unit in shape.units(&[case]) {
            for (sum, force_n) in sum.iter_mut().zip(unit.force_n) {
                *sum += force_n;
            }
        }
        sum
    }

    #[test]
    fn the_nodes_of_a_whole_recording_together_are_a_constant_force() {
        let case = case();
        let shape = Shape::Pushes(vec![Window { case: 0, first: 0, last: NODES }]);
        assert_eq!((shape.amounts(1), shape.units(&[&case]).len()), (NODES + 1, NODES + 1));
        assert!(sum(&shape, &case).iter().all(|force_n| (force_n - 1.0).abs() < 1e-9));
    }

    #[test]
    fn a_push_acts_within_its_window_alone() {
        let case = case();
        let window = Window { case: 0, first: 20, last: 24 };
        let (from_s, to_s) = window.time_s(&case);
        let tick_s = case.stimulus.tick.seconds();
        for (point, force_n) in sum(&Shape::Pushes(vec![window]), &case).iter().enumerate() {
            let time_s = point as f64 * tick_s;
            assert!(*force_n == 0.0 || (from_s..=to_s).contains(&time_s), "{force_n} at {time_s}");
        }
    }

    #[test]
    fn two_amounts_give_a_wave_any_phase() {
        let case = case();
        let units = Shape::Periodic { hz: 7.0 }.units(&[&case]);
        for (cosine, sine) in units[0].force_n.iter().zip(&units[1].force_n) {
            assert!((cosine.hypot(*sine) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn what_hangs_on_a_stiff_spring_is_as_good_as_fixed_to_the_rod() {
        let mut case = case();
        let position = case.channels.iter_mut().find(|channel| channel.signal == Signal::Position).unwrap();
        for (position_m, time_s) in position.recorded.iter_mut().zip(&case.time_s) {
            *position_m = 0.05 * (1.0 - (TAU * 2.0 * time_s).cos());
        }
        let of = |hz: f64, is_included: bool| of_structure(&case, hz, 0.7, is_included).unwrap();
        let square = |series: Vec<f64>| series.into_iter().map(|one| one * one).sum::<f64>();
        // Fixed to the rod it changes nothing where it was included, and is a further mass where it was not.
        let (stiff, stiff_beside) = (square(of(60.0, true)), square(of(60.0, false)));
        assert!(stiff < 0.2 * stiff_beside, "{stiff} of {stiff_beside}");
        // On a soft spring it keeps still: the rod lacks its mass where it was included.
        let (soft, soft_beside) = (square(of(0.3, true)), square(of(0.3, false)));
        assert!(soft_beside < 0.2 * soft, "{soft_beside} of {soft}");
    }
}
