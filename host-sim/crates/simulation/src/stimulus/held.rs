//! A recording near which its runs are held.
//!
//! Where a drive swings by itself, a free run with a slightly wrong value gets out of step, and the longer it lasts, the less it says of that value: a search
//! ends in one of many valleys. A run that takes pressures, velocity and position from the recording again and again (multiple shooting; Bock 1983) never gets
//! far out of step, and leads to the right valley from afar. It only leads there: what it takes has the sensors' errors, so a free run has the last word.

use std::sync::Arc;

use model_core::machine::Tick;
use recording::Signal;

use super::Stimulus;
use crate::taken_up::{Channel, Channels, TakenUp};

/// Shortest time from one moment to the next, s. Chosen: less than a swing of most drives.
const EVERY_S: f64 = 0.02;
/// Rows at least from one moment to the next: half of them tell a velocity on either side.
const LEAST_ROWS: f64 = 6.0;

/// A signal as recorded.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// Which one.
    pub signal: Signal,
    /// Its rows, SI.
    pub values: &'a [f64],
    /// The rows that say nothing.
    pub lost: &'a [bool],
}

/// What runs take from a recording, at moments that are equally far apart.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Held {
    /// From one to the next, s: a multiple of every tick.
    every_s: f64,
    /// The first is the start, at which nothing is taken. `None` where the rows do not tell.
    moments: Arc<[Option<TakenUp>]>,
}

impl Held {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a second over a tick")]
    pub(super) fn at(&self, point: usize, tick: Tick) -> Option<&TakenUp> {
        let every = (self.every_s / tick.seconds()).round() as usize;
        if point.is_multiple_of(every) { self.moments.get(point / every)?.as_ref() } else { None }
    }
}

impl Stimulus {
    /// The same with its runs held near the recording, so many times more seldom than its rows allow. `None` where it does not show both pressures and the motion.
    #[must_use]
    pub fn held(&self, time_s: &[f64], shown: &[Shown<'_>], times: u32) -> Option<Self> {
        let channel = |signal| {
            let Shown { values, lost, .. } = *shown.iter().find(|one| one.signal == signal)?;
            Some(Channel::new(time_s, values, move |rows| lost[rows].contains(&true)))
        };
        let channels = Channels::of(channel)?;
        let lasts_s = time_s.last()? - time_s.first()?;
        let grid_s = Tick::TwoMilliseconds.seconds();
        let row_s = lasts_s / time_s.len().saturating_sub(1) as f64;
        let every_s = (EVERY_S.max(LEAST_ROWS * row_s) / grid_s).ceil() * grid_s * f64::from(times);
        let at = |after_s: f64| channels.at(after_s).map(|(taken_up, _)| taken_up);
        let later = (1_u32..).map(|count| f64::from(count) * every_s).take_while(|after_s| *after_s < lasts_s);
        let moments: Arc<[Option<TakenUp>]> = std::iter::once(None).chain(later.map(at)).collect();
        moments.iter().any(Option::is_some).then(|| Self { held: Some(Held { every_s, moments }), ..self.clone() })
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Parameter;
    use recording::Recording;
    use test_press::{press, recorded};

    use super::*;
    use crate::{InputPoint, StartOffset, simulate_f64};

    const SENSORS: [(Signal, f64); 3] = [(Signal::PressureA, 1e4), (Signal::PressureB, 1e4), (Signal::Position, 1e-5)];
    const ROWS: usize = 2000;

    fn stimulus(recording: &Recording, tick: Tick) -> Stimulus {
        Stimulus::new(recording, &press(&[]), InputPoint::Command, LoadSource::Constant, tick).unwrap()
    }

    /// Held near a recording, of which some rows say nothing.
    fn held(recording: &Recording, tick: Tick, lost: &[bool], times: u32) -> Option<Stimulus> {
        let shown = |signal| recording.signal(signal).map(|values| Shown { signal, values, lost });
        let shown: Vec<Shown<'_>> = SENSORS.iter().filter_map(|(signal, _)| shown(*signal)).collect();
        stimulus(recording, tick).held(recording.time_s(), &shown, times)
    }

    #[test]
    fn a_run_of_a_wrong_model_stays_near_the_recording_while_it_is_held_there() {
        let recording = recorded(&press(&[(Parameter::ValveGain, 0.06)]), &SENSORS);
        let off_m = |stimulus: &Stimulus| {
            let run = simulate_f64(&press(&[]), stimulus, StartOffset::none()).unwrap();
            let [run, recorded] =
                [run.signal(Signal::Position), recording.signal(Signal::Position)].map(Option::unwrap);
            run.iter().zip(recorded).map(|(run, recorded)| (run - recorded).abs()).fold(0.0, f64::max)
        };
        let held = |times| held(&recording, Tick::OneMillisecond, &[false; ROWS], times).unwrap();
        let [free, seldom, often] =
            [stimulus(&recording, Tick::OneMillisecond), held(10), held(1)].map(|one| off_m(&one));
        assert!(often < 0.3 * seldom && seldom < 0.5 * free, "{often} {seldom} {free}");
    }

    #[test]
    fn a_moment_is_the_same_at_every_tick_and_none_where_the_rows_say_nothing() {
        let recording = recorded(&press(&[]), &SENSORS);
        let mut lost = [false; ROWS];
        lost[500..600].fill(true);
        let [fine, coarse] = [Tick::OneMillisecond, Tick::TwoMilliseconds];
        let [by_fine, by_coarse] = [fine, coarse].map(|tick| held(&recording, tick, &lost, 1).unwrap().held.unwrap());
        let moments: Vec<usize> = (0..ROWS).filter(|point| by_fine.at(*point, fine).is_some()).collect();
        assert!(
            moments.iter().all(|point| point % 20 == 0 && !(500..600).contains(point)) && moments.len() > 90,
            "{moments:?}"
        );
        assert!(moments.iter().all(|point| by_coarse.at(point / 2, coarse) == by_fine.at(*point, fine)));
        let pressures = recorded(&press(&[]), &SENSORS[..2]);
        assert!(held(&pressures, fine, &lost, 1).is_none(), "nothing shows the motion");
        assert!(held(&recording, fine, &[true; ROWS], 1).is_none());
    }
}
