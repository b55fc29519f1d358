//! What a recorded spool does that the model's spool does not: it sticks while it is driven, breaks away faster than the model's ever moves,
//! and rests in different places at the same command. These are descriptions, not effects: hysteresis, stiction, dirt and a worn spring share them.

use recording::Signal;
use simulation::Trajectory;

use super::case::Case;

/// What a spool does.
#[derive(Clone, Debug, PartialEq)]
pub enum Habit {
    /// It stays where it is while the model's spool moves on.
    Sticks {
        /// The recording that shows most of it.
        recording: String,
        /// Start, s.
        from_s: f64,
        /// End, s.
        to_s: f64,
        /// Where it sticks, as a share of full travel.
        at: f64,
        /// How far the model's spool moves meanwhile, as a share of full travel.
        modelled: f64,
        /// Recordings in which it is stuck.
        recordings: usize,
        /// Number of recordings with a spool signal.
        of: usize,
    },
    /// It breaks away faster than the model's spool moves there.
    BreaksAway {
        /// The recording.
        recording: String,
        /// When, s.
        at_s: f64,
        /// Its speed, in full travels per second.
        speed_per_s: f64,
        /// The highest speed of the model's spool meanwhile.
        modelled_per_s: f64,
    },
    /// It rests in two places at one command.
    RestsElsewhere {
        /// The command, V.
        command_v: f64,
        /// Recording and position (share of full travel) of each of the two rests.
        rests: [(String, f64); 2],
        /// Distance between the model's two positions there.
        modelled: f64,
    },
}

/// Two readings differ if they are more than six standard deviations of a reading apart: by noise alone that happens once in fifty thousand pairs.
const DIFFERS: f64 = 6.0;
/// A spool is stuck while it moves less than this share of the distance that the model's spool moves.
const STUCK: f64 = 0.25;
/// Longest stretch over which a stuck spool is searched for, s.
const LONGEST_S: f64 = 0.5;
/// It breaks away where it is more than this many times as fast as the model's spool.
const FASTER: f64 = 1.5;
/// Shortest time that a command is held for the spool to come to rest, s.
const HELD_S: f64 = 0.2;
/// Two commands are the same if they differ by at most this share of the commanded range.
const SAME: f64 = 0.01;

/// A recorded spool beside the model's.
struct Spool<'a> {
    recording: &'a str,
    time_s: &'a [f64],
    command_v: Option<&'a [f64]>,
    recorded: Vec<f64>,
    modelled: &'a [f64],
    noise: f64,
}

/// A rest of the spool at a held command: the command, and where both spools are.
struct Rest<'a> {
    recording: &'a str,
    command_v: f64,
    recorded: f64,
    modelled: f64,
    noise: f64,
}

/// What the spools of all recordings do; nothing where none is recorded.
pub(crate) fn habits(cases: &[Case<'_>], trajectories: &[Trajectory]) -> Vec<Habit> {
    let spools: Vec<Spool<'_>> = cases
        .iter()
        .zip(trajectories)
        .filter_map(|(case, trajectory)| {
            let channel = case.prepared.channels.iter().find(|channel| channel.signal == Signal::Spool)?;
            Some(Spool {
                recording: &case.prepared.name,
                time_s: &case.prepared.time_s,
                command_v: case.recording.signal(Signal::Command),
                recorded: channel.bridged(),
                modelled: trajectory.signal(Signal::Spool)?,
                noise: channel.noise,
            })
        })
        .collect();
    described(&spools)
}

fn described(spools: &[Spool<'_>]) -> Vec<Habit> {
    let stretches: Vec<(&Spool<'_>, Stuck)> =
        spools.iter().filter_map(|spool| Some((spool, spool.sticks()?))).collect();
    let mut found = Vec::new();
    if let Some((spool, stuck)) = stretches.iter().max_by(|a, b| a.1.behind.total_cmp(&b.1.behind)) {
        found.push(Habit::Sticks {
            recording: spool.recording.to_owned(),
            from_s: spool.time_s[stuck.first],
            to_s: spool.time_s[stuck.last],
            at: spool.recorded[stuck.first],
            modelled: (spool.modelled[stuck.last] - spool.modelled[stuck.first]).abs(),
            recordings: stretches.len(),
            of: spools.len(),
        });
        found.extend(spool.breaks_away(stuck));
    }
    found.extend(rests_apart(spools));
    found
}

/// A stretch in which the spool is stuck.
struct Stuck {
    first: usize,
    last: usize,
    /// How much further the model's spool moves, in standard deviations of the noise.
    behind: f64,
}

impl Spool<'_> {
    /// The stretch in which it falls furthest behind the model's spool while it hardly moves.
    fn sticks(&self) -> Option<Stuck> {
        let moved = |series: &[f64], from: usize, to: usize| series[to] - series[from];
        let mut best: Option<Stuck> = None;
        for first in 0..self.time_s.len() {
            for last in first + 1..self.time_s.len() {
                if self.time_s[last] - self.time_s[first] > LONGEST_S {
                    break;
                }
                let (own, modelled) = (moved(&self.recorded, first, last), moved(self.modelled, first, last));
                let behind = (modelled.abs() - own.abs()) / self.noise;
                // The model's motion is so large that noise can neither imitate nor hide the share of it that counts.
                let is_one = modelled.abs() * STUCK > DIFFERS * self.noise && own.abs() < STUCK * modelled.abs();
                if is_one && best.as_ref().is_none_or(|known| behind > known.behind) {
                    best = Some(Stuck { first, last, behind });
                }
            }
        }
        best
    }

    /// Where it breaks away after it was stuck, if it is then faster than the model's spool at any time up to half a second after the stretch.
    fn breaks_away(&self, stuck: &Stuck) -> Option<Habit> {
        let until_s = self.time_s[stuck.last] + LONGEST_S;
        let rows =
            || (stuck.first..self.time_s.len().saturating_sub(2)).take_while(|row| self.time_s[row + 2] < until_s);
        // Over two rows: a single step of a noisy reading gives no usable speed.
        let speed = |series: &[f64], row: usize| {
            (series[row + 2] - series[row]).abs() / (self.time_s[row + 2] - self.time_s[row])
        };
        let fastest = rows()
            .filter(|row| *row >= stuck.last.saturating_sub(2))
            .max_by(|a, b| speed(&self.recorded, *a).total_cmp(&speed(&self.recorded, *b)))?;
        let (own, modelled) =
            (speed(&self.recorded, fastest), rows().map(|row| speed(self.modelled, row)).fold(0.0, f64::max));
        let is_seen = (self.recorded[fastest + 2] - self.recorded[fastest]).abs() > DIFFERS * self.noise;
        (is_seen && own > FASTER * modelled).then(|| Habit::BreaksAway {
            recording: self.recording.to_owned(),
            at_s: self.time_s[fastest],
            speed_per_s: own,
            modelled_per_s: modelled,
        })
    }

    /// Its rests at held commands, each the mean over the last quarter of the time that the command is held.
    fn rests(&self, same_v: f64) -> Vec<Rest<'_>> {
        let Some(command) = self.command_v else { return Vec::new() };
        let mut rests = Vec::new();
        let mut first = 0;
        for end in 1..=command.len() {
            if end < command.len() && (command[end] - command[first]).abs() <= same_v {
                continue;
            }
            if self.time_s[end - 1] - self.time_s[first] >= HELD_S {
                let last = end - ((end - first) / 4).max(1)..end;
                let mean = |series: &[f64]| series[last.clone()].iter().sum::<f64>() / last.len() as f64;
                rests.push(Rest {
                    recording: self.recording,
                    command_v: mean(command),
                    recorded: mean(&self.recorded),
                    modelled: mean(self.modelled),
                    noise: self.noise,
                });
            }
            first = end;
        }
        rests
    }
}

/// The two rests at one command whose distance differs most from the model's, if the model explains less than half of the distance.
fn rests_apart(spools: &[Spool<'_>]) -> Option<Habit> {
    let commands = || spools.iter().filter_map(|spool| spool.command_v).flatten().copied();
    let (low, high) = simulation::signal::noise::extent(commands());
    let same_v = SAME * (high - low);
    let rests: Vec<Rest<'_>> = spools.iter().flat_map(|spool| spool.rests(same_v)).collect();
    let mut best: Option<(f64, Habit)> = None;
    for (index, one) in rests.iter().enumerate() {
        for other in &rests[index + 1..] {
            let (recorded, modelled) = (other.recorded - one.recorded, other.modelled - one.modelled);
            let unexplained = (recorded - modelled).abs();
            let is_apart = (one.command_v - other.command_v).abs() <= same_v
                && unexplained > DIFFERS * one.noise.max(other.noise)
                && unexplained > 0.5 * recorded.abs();
            if is_apart && best.as_ref().is_none_or(|(known, _)| unexplained > *known) {
                let of = |rest: &Rest<'_>| (rest.recording.to_owned(), rest.recorded);
                let rests = [of(one), of(other)];
                let command_v = f64::midpoint(one.command_v, other.command_v);
                best = Some((unexplained, Habit::RestsElsewhere { command_v, rests, modelled: modelled.abs() }));
            }
        }
    }
    best.map(|(_, habit)| habit)
}

impl Habit {
    /// Its kind in reports.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Habit::Sticks { .. } => "hangs",
            Habit::BreaksAway { .. } => "breaks-away",
            Habit::RestsElsewhere { .. } => "rests-apart",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times() -> Vec<f64> {
        (0..1000).map(|row| f64::from(row) * 1e-3).collect()
    }

    fn spool<'a>(
        recording: &'a str,
        time_s: &'a [f64],
        command_v: &'a [f64],
        recorded: Vec<f64>,
        modelled: &'a [f64],
    ) -> Spool<'a> {
        Spool { recording, time_s, command_v: Some(command_v), recorded, modelled, noise: 1e-4 }
    }

    /// A command that rises for half a second and is held, and a spool that follows it.
    fn followed(time_s: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let command: Vec<f64> = time_s.iter().map(|t| 4.0 * (t - 0.3).clamp(0.0, 0.4)).collect();
        let free = command.iter().map(|command| 0.2 * command).collect();
        (command, free)
    }

    #[test]
    fn a_spool_that_follows_has_no_habit() {
        let time_s = times();
        let (command, free) = followed(&time_s);
        let noisy = free.iter().enumerate().map(|(row, x)| x + if row % 2 == 0 { 1e-4 } else { -1e-4 }).collect();
        assert_eq!(described(&[spool("a", &time_s, &command, noisy, &free)]), []);
    }

    #[test]
    fn one_that_sticks_and_breaks_away_is_found_with_place_and_speed() {
        let time_s = times();
        let (command, free) = followed(&time_s);
        // It sticks at 0.04 until the free spool is 0.1 ahead, and has caught up with it 20 ms later.
        let sticks = time_s.iter().zip(&free).map(|(t, free)| match t {
            t if *t < 0.35 => *free,
            t if *t < 0.475 => 0.04,
            t if *t < 0.495 => 0.04 + (t - 0.475) * (0.156 - 0.04) / 0.02,
            _ => *free,
        });
        let found = described(&[spool("a", &time_s, &command, sticks.collect(), &free)]);
        let [
            Habit::Sticks { from_s, to_s, at, modelled, .. },
            Habit::BreaksAway { at_s, speed_per_s, modelled_per_s, .. },
        ] = found.as_slice()
        else {
            panic!("{found:?}")
        };
        // It moved a little before it stuck: less than a quarter of what the free spool moved.
        assert!((0.3..0.37).contains(from_s) && (0.46..0.48).contains(to_s), "{found:?}");
        assert!(*at < 0.045 && *modelled > 0.09, "{found:?}");
        assert!((0.47..0.5).contains(at_s) && (speed_per_s - 5.8).abs() < 0.1 && (modelled_per_s - 0.8).abs() < 0.01);
    }

    #[test]
    fn one_that_comes_to_rest_elsewhere_at_the_same_command_does_not_come_home() {
        let time_s = times();
        let (up, free_up) = followed(&time_s);
        let (down, free_down): (Vec<f64>, Vec<f64>) =
            (up.iter().rev().copied().collect(), free_up.iter().rev().copied().collect());
        let late = free_down.iter().map(|free| free.max(0.05)).collect();
        let found = described(&[
            spool("up", &time_s, &up, free_up.clone(), &free_up),
            spool("down", &time_s, &down, late, &free_down),
        ]);
        let apart = found
            .iter()
            .find(|habit| matches!(habit, Habit::RestsElsewhere { .. }))
            .unwrap_or_else(|| panic!("{found:?}"));
        let Habit::RestsElsewhere { command_v, rests: [(one, here), (other, there)], .. } = apart else {
            unreachable!()
        };
        assert_eq!((one.as_str(), other.as_str()), ("up", "down"));
        // The command counts as held until it has changed by a hundredth of the commanded range.
        assert!(command_v.abs() < 1e-3 && here.abs() < 1e-3 && (there - 0.05).abs() < 1e-9, "{found:?}");
    }
}
