//! Whether recordings and machine file belong together, asked before anything is searched.
//!
//! A sensor that counts the other way, exchanged pressure lines or a position in the wrong unit is no missing physics. But a refit follows much of it:
//! with a tenth of the position, a tenfold bulk modulus and a tenth of the flow fit as well as before. So a cheap test comes first: how far, and which
//! way, the machine file's model moves compared with what was recorded (`response`). Only where that raises a doubt, changes of the recordings that
//! would remove it (`direction`, `scale`, `place`, `late`, `cylinder`) are tried by rough refits of short parts (`trial`).

mod change;
mod cylinder;
mod direction;
mod far_value;
mod follower;
mod late;
mod place;
mod response;
mod scale;
mod tolerated;
mod trial;

use identification::fit::{FitError, Free};
use identification::parallel;
use machine_file::MachineFile;
use recording::{Recording, Signal};

use response::Responses;

pub use change::Change;
pub(crate) use far_value::FAR_FROM;
pub use far_value::{Cause, FarValue, far_values};
pub use follower::{Follower, follower};
pub(crate) use tolerated::USED_UP;
pub use tolerated::{Tolerated, has_sensor, not_tolerated, sensor_of, tolerated};
pub use trial::Trial;

/// Most recordings that a doubt is tried on.
const MOST_RECORDINGS: usize = 3;

/// A change of the recordings with which the machine file agrees clearly better.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// The recordings that raise it.
    pub recordings: Vec<String>,
    /// Whether all recordings do.
    pub in_all: bool,
    /// The signals that raise it, which the fits below are of.
    pub signals: Vec<Signal>,
    /// The refit to the recordings as they are.
    pub as_recorded: Trial,
    /// The refit to the changed recordings.
    pub changed: Trial,
    /// Other changes that do about as well.
    pub others: Vec<Trial>,
    /// Whether it is beyond doubt: as they are, the recordings cannot be those of this machine file.
    pub is_certain: bool,
}

/// What a first look at a recording shows beside the machine file's model, without a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Suspicion {
    /// This signal runs against the model's.
    RunsAgainst(Signal),
    /// Each pressure is nearer to the other one's simulation than to its own.
    PressuresCrossed,
    /// This signal moves so many times as far as the model's; infinite where that hardly moves.
    MovesOtherwise(Signal, f64),
}

/// What a first look at a recording shows; nothing where it cannot be simulated.
#[must_use]
pub fn first_look(file: &MachineFile, recording: &Recording) -> Vec<Suspicion> {
    let Some(responses) = Responses::of(file, recording) else { return Vec::new() };
    let each = || responses.each.iter();
    let against = each().filter(|response| direction::runs_against(response));
    let crossed = direction::are_crossed(&responses).then_some(Suspicion::PressuresCrossed);
    let off = each().filter(|response| scale::is_off(response.ratio));
    against
        .map(|response| Suspicion::RunsAgainst(response.signal))
        .chain(crossed)
        .chain(off.map(|response| Suspicion::MovesOtherwise(response.signal, response.ratio)))
        .collect()
}

/// A doubt that a first look raises: which changes are to be tried, in which signals it shows, and in which of the recordings.
struct Raised {
    changes: Vec<Vec<Change>>,
    signals: Vec<Signal>,
    recordings: Vec<usize>,
    /// Whether nothing speaks for it yet.
    is_possible: bool,
}

impl Raised {
    /// Adds the changes that it does not try yet.
    fn try_also(&mut self, changes: Vec<Vec<Change>>) {
        for change in changes {
            if !self.changes.contains(&change) {
                self.changes.push(change);
            }
        }
    }

    /// Takes in what another recording raises, where a change would remove both; else gives it back.
    fn joined(&mut self, (changes, signals): (Vec<Vec<Change>>, Vec<Signal>), index: usize) -> Result<(), Found> {
        if !changes.iter().any(|change| self.changes.contains(change)) {
            return Err((changes, signals));
        }
        self.try_also(changes);
        // Where it shows in all of them, if there is such a signal.
        if self.signals.iter().any(|signal| signals.contains(signal)) {
            self.signals.retain(|signal| signals.contains(signal));
        }
        self.recordings.push(index);
        Ok(())
    }
}

/// Changes to try, and the signals that call for them.
type Found = (Vec<Vec<Change>>, Vec<Signal>);

/// What is doubtful about recordings for this drive, whose `free` parameters may move; nothing where they agree.
pub fn doubts(file: &MachineFile, free: &[Free], recordings: &[&Recording]) -> Result<Vec<Doubt>, FitError> {
    let responses = parallel::each(recordings, |recording| Responses::of(file, recording));
    let mut raised: Vec<Raised> = Vec::new();
    for (index, responses) in responses.iter().enumerate() {
        let found = responses.iter().flat_map(|responses| {
            let of_cylinder = cylinder::changes(&file.machine, recordings[index]);
            [direction::changes(responses), scale::changes(responses), of_cylinder]
        });
        for found in found.filter(|(changes, _)| !changes.is_empty()) {
            let left = raised.iter_mut().try_fold(found, |found, known| match known.joined(found, index) {
                Ok(()) => Err(()),
                Err(found) => Ok(found),
            });
            if let Ok((changes, signals)) = left {
                raised.push(Raised { changes, signals, recordings: vec![index], is_possible: false });
            }
        }
    }
    let of_all = |(changes, signals)| Raised {
        changes,
        signals,
        recordings: (0..recordings.len()).collect(),
        is_possible: false,
    };
    let (changes, signals) = place::changes(&file.machine, recordings);
    match raised.iter_mut().find(|known| known.changes.iter().any(|change| changes.contains(change))) {
        Some(known) => known.try_also(changes),
        None => raised.push(of_all((changes, signals))),
    }
    raised.push(of_all(scale::times(recordings)));
    raised.push(of_all(late::changes(&file.machine, &responses)));
    raised.retain(|raised| !raised.changes.is_empty());
    if raised.is_empty() && free.iter().any(|free| free.tolerance().is_some()) {
        let other = of_all(cylinder::of_other_size(&file.machine, recordings));
        raised.extend((!other.changes.is_empty()).then_some(Raised { is_possible: true, ..other }));
    }
    let mut doubts = Vec::new();
    for raised in raised {
        let of = &raised.recordings;
        let few: Vec<&Recording> = of.iter().take(MOST_RECORDINGS).map(|&index| recordings[index]).collect();
        let Some(tried) = trial::tried(file, free, &few, &raised)? else { continue };
        doubts.push(Doubt {
            recordings: of.iter().map(|&index| recordings[index].name().to_owned()).collect(),
            in_all: of.len() == recordings.len(),
            ..tried
        });
    }
    if !doubts.is_empty() {
        // Of what follows its input instead of integrating it no channel is to blame, unless with another one the drive's model does better.
        let follower = follower(file, free, recordings)?;
        doubts.retain(|doubt| follower.is_none_or(|follower| doubt.changed.fit_percent > follower.follows_percent));
    }
    Ok(doubts)
}
