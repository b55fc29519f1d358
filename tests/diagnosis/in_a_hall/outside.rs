//! Causes that no catalogue of effects has, each drawn until the recordings show it.

use model_core::machine::Parameter as P;
use recording::Signal;
use recording::seeded_noise::Noise;
use virtual_plant::hall::{Change, DURATION_S, Hall, RECORDINGS, Run, channel, recorded, shows, stays_inside};
use virtual_plant::{FlowEffect, LoadEffect, LoadProfile, PlantEffect, SensingEffect, SyntheticRecording};

/// Where it comes from that a drive does not do what its model does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cause {
    Push,
    Neighbour,
    Structure,
    Supply,
    Load,
    Gain,
    Scale,
    Stuck,
    Mount,
}

impl Cause {
    pub(super) const ALL: [Self; 9] = [
        Self::Push,
        Self::Neighbour,
        Self::Structure,
        Self::Supply,
        Self::Load,
        Self::Gain,
        Self::Scale,
        Self::Stuck,
        Self::Mount,
    ];

    /// For the name of a case.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Push => "push",
            Self::Neighbour => "neighbour",
            Self::Structure => "structure",
            Self::Supply => "supply",
            Self::Load => "load",
            Self::Gain => "gain",
            Self::Scale => "scale",
            Self::Stuck => "stuck",
            Self::Mount => "mount",
        }
    }

    pub(super) const fn what(self) -> &'static str {
        match self {
            Self::Push => "a push that happens once",
            Self::Neighbour => "a machine nearby, 3 to 30 Hz",
            Self::Structure => "a structure that rings, 8 to 40 Hz",
            Self::Supply => "a supply that pulsates, 8 to 60 Hz",
            Self::Load => "another load in every recording",
            Self::Gain => "a sensor whose gain drifts",
            Self::Scale => "a position scale that is not linear",
            Self::Stuck => "a spool that sticks once",
            Self::Mount => "a position sensor whose mount rings",
        }
    }
}

/// The least difference that a cause makes to some signal, over its noise: root mean square, offset and ramp taken out.
const VISIBLE_FROM: f64 = 3.0;

/// What a drawn cause does.
#[derive(Default)]
struct Put {
    changes: [Change; RECORDINGS],
    /// Recording, and from when to when its spool stays where it is told to be, s.
    held: Option<(usize, f64, f64)>,
    misread: Option<Misread>,
}

enum Misread {
    /// The gain is lost by this share until the last recording ends.
    Gain { signal: Signal, lost: f64 },
    /// A wave over the stroke: its height and length, and where it begins, m.
    Scale { height_m: f64, length_m: f64, from_m: f64 },
}

/// The recordings of a drive with this cause; none where it does not show or drives the rod out of its stroke.
pub(super) fn made(hall: &Hall, cause: Cause, runs: &[Run], dice: &mut Noise) -> Option<Vec<SyntheticRecording>> {
    let put = Put::draw(hall, cause, dice);
    let mut most = 0.0_f64;
    let mut kept = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let (with, commanded) = put.whole(hall, index, run)?;
        if !stays_inside(hall, &with) {
            return None;
        }
        let without = commanded.whole(hall, &Change::default())?;
        let mut with = recorded(hall, run, &with);
        if let Some(misread) = &put.misread {
            misread.over(&mut with, index);
        }
        most = most.max(shows(hall, &with, &recorded(hall, run, &without)));
        kept.push(with);
    }
    (most > VISIBLE_FROM).then_some(kept)
}

impl Put {
    fn draw(hall: &Hall, cause: Cause, dice: &mut Noise) -> Self {
        let mut put = Self::default();
        let everywhere =
            |effect: PlantEffect| std::array::from_fn(|_| Change { effects: vec![effect], ..Change::default() });
        match cause {
            Cause::Push => {
                let (often, first) = ([1, 1, 2, 3][dice.below(4)], dice.below(RECORDINGS));
                for index in 0..often {
                    put.changes[(first + index) % RECORDINGS].load = push(hall, dice);
                }
            }
            Cause::Neighbour => {
                let (hertz, force_n) = (dice.decades(3.0, 30.0), hall.full_n() * dice.decades(0.02, 0.12));
                for change in &mut put.changes {
                    change.load = wave(force_n, hertz, dice.uniform(0.0, 1.0));
                }
            }
            Cause::Structure => {
                put.changes = everywhere(PlantEffect::Load(LoadEffect::HungMass {
                    mass_kg: hall.truth.get(P::MovingMass) * dice.decades(0.2, 1.0),
                    frequency_hz: dice.decades(8.0, 40.0),
                    damping: dice.uniform(0.01, 0.05),
                }));
            }
            Cause::Supply => {
                let (share, frequency_hz) = (dice.decades(0.01, 0.06), dice.decades(8.0, 60.0));
                put.changes = everywhere(PlantEffect::Flow(FlowEffect::PumpRipple { share, frequency_hz }));
            }
            Cause::Load => {
                let most_n = hall.full_n() * dice.decades(0.05, 0.15);
                for change in &mut put.changes {
                    change.load = through(vec![(0.0, most_n * dice.uniform(-1.0, 1.0))]);
                }
            }
            Cause::Gain => {
                let signal = hall.signals[dice.below(hall.signals.len())];
                let usual = match signal {
                    Signal::Position => 0.03,
                    Signal::Spool => 0.06,
                    _ => 0.12,
                };
                put.misread = Some(Misread::Gain { signal, lost: usual * dice.decades(0.5, 1.6) });
            }
            Cause::Scale => {
                let stroke_m = hall.truth.get(P::Stroke);
                let (height_m, length_m) = (stroke_m * dice.decades(3e-3, 0.015), stroke_m * dice.decades(0.4, 1.5));
                put.misread = Some(Misread::Scale { height_m, length_m, from_m: dice.uniform(0.0, stroke_m) });
            }
            Cause::Stuck => {
                let from_s = dice.uniform(0.2, 1.4);
                put.held = Some((dice.below(RECORDINGS), from_s, from_s + dice.uniform(0.1, 0.35)));
            }
            Cause::Mount => {
                put.changes = everywhere(PlantEffect::Sensing(SensingEffect::Flexibility {
                    frequency_hz: dice.decades(8.0, 40.0),
                    damping: dice.uniform(0.02, 0.05),
                    share: dice.decades(0.1, 1.0),
                }));
            }
        }
        put
    }

    /// A run with the cause, and the run that has the same commands.
    fn whole(&self, hall: &Hall, index: usize, run: &Run) -> Option<(SyntheticRecording, Run)> {
        let change = &self.changes[index];
        let whole = run.whole(hall, change)?;
        let commanded = run.commanded(whole.command_v.clone());
        let Some((_, from_s, to_s)) = self.held.filter(|held| held.0 == index) else { return Some((whole, commanded)) };
        // The spool stays where it was told to be, but what is recorded is what it is told.
        let before_s = run.before_s(hall);
        let told = &whole.command_v;
        let mut held = told.clone();
        let from = whole.time_s.partition_point(|&time_s| time_s < before_s + from_s);
        let to = whole.time_s.partition_point(|&time_s| time_s < before_s + to_s);
        held[from..to].fill(told[from]);
        let stuck = run.commanded(held);
        Some((SyntheticRecording { command_v: told.clone(), ..stuck.whole(hall, change)? }, commanded))
    }
}

/// Somebody leans on the load.
fn push(hall: &Hall, dice: &mut Noise) -> LoadProfile {
    let force_n = dice.sign() * hall.full_n() * dice.decades(0.05, 0.25);
    let (from_s, rise_s, hold_s) = (dice.uniform(0.2, 1.3), dice.uniform(0.02, 0.1), dice.uniform(0.1, 0.4));
    let (full_s, over_s) = (from_s + rise_s, from_s + rise_s + hold_s);
    through(vec![(from_s, 0.0), (full_s, force_n), (over_s, force_n), (over_s + rise_s, 0.0)])
}

/// A sine, from before the recording until it has ended.
fn wave(force_n: f64, hertz: f64, phase: f64) -> LoadProfile {
    const A_TURN: f64 = 16.0;
    let (from_s, to_s) = (-1.5, DURATION_S + 0.1);
    let mut points = Vec::new();
    let mut time_s = from_s;
    while time_s < to_s {
        points.push((time_s, force_n * sine(hertz * time_s + phase)));
        time_s += 1.0 / (A_TURN * hertz);
    }
    through(points)
}

fn sine(turns: f64) -> f64 {
    (std::f64::consts::TAU * turns).sin()
}

fn through(points: Vec<(f64, f64)>) -> LoadProfile {
    LoadProfile::through(points).unwrap()
}

impl Misread {
    /// Reads wrongly what the recording of this number shows.
    fn over(&self, kept: &mut SyntheticRecording, index: usize) {
        match *self {
            Self::Gain { signal, lost } => {
                let (rows, all) = (kept.len(), kept.len() * RECORDINGS);
                let values = channel(kept, signal);
                for (row, value) in values.iter_mut().enumerate() {
                    *value *= 1.0 - lost * (index * rows + row) as f64 / all as f64;
                }
            }
            Self::Scale { height_m, length_m, from_m } => {
                for position_m in &mut kept.position_m {
                    *position_m += height_m * sine((*position_m - from_m) / length_m);
                }
            }
        }
        *kept = std::mem::take(kept).rounded();
    }
}
