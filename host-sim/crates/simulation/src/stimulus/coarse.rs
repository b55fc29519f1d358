//! A recording on a grid of twice the tick.

use model_core::machine::Tick;

use super::{Input, Stimulus};

/// A stimulus on a grid of twice the tick, with the rows of the recording that are kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarser {
    /// The stimulus, which drives the model at the kept rows.
    pub stimulus: Stimulus,
    /// The kept rows, in order: at most one per tick.
    pub kept: Vec<usize>,
}

impl Stimulus {
    /// The same on a grid of twice the tick; `None` where the core has no such tick, or a block of a whitened one would have no row.
    ///
    /// A value that is held over a tick becomes the mean of two: on average nothing is delayed, and what changes sign at every tick disappears.
    #[must_use]
    pub fn coarser(&self) -> Option<Coarser> {
        let tick = match self.tick {
            Tick::HalfMillisecond => Tick::OneMillisecond,
            Tick::OneMillisecond => Tick::TwoMilliseconds,
            Tick::TwoMilliseconds => return None,
        };
        let input = match &self.input {
            Input::Command(volts) => Input::Command(means(volts)),
            Input::Spool(spool) => Input::Spool(every_second(spool)),
            Input::Pump(speed, direction) => Input::Pump(means(speed), direction.iter().step_by(2).copied().collect()),
            Input::Flow(flow, ratio) => Input::Flow(every_second(flow), *ratio),
            Input::Force(force) => Input::Force(every_second(force)),
        };
        let mut kept = Vec::with_capacity(self.rows.len() / 2 + 1);
        let mut rows: Vec<(usize, f64)> = Vec::with_capacity(self.rows.len() / 2 + 1);
        for (row, &(point, share)) in self.rows.iter().enumerate() {
            let (at, share) = (point / 2, 0.5 * ((point % 2) as f64 + share));
            let is_within = at + usize::from(share > 0.0) <= self.ticks / 2;
            if is_within && rows.last().is_none_or(|(last, _)| *last != at) {
                rows.push((at, share));
                kept.push(row);
            }
        }
        let whitening = match &self.whitening {
            None => None,
            Some(whitening) => Some(whitening.of_kept(&kept)?),
        };
        let points = |values: &Option<Vec<f64>>| values.as_deref().map(every_second);
        let stimulus = Self {
            input_point: self.input_point,
            tick,
            start: self.start,
            ticks: rows.last().map_or(0, |(point, share)| point + usize::from(*share > 0.0)),
            input,
            spool: self.spool.as_deref().map(|spool| every_second(spool).into()),
            follows: self.follows,
            load_n: points(&self.load_n),
            other_flow: points(&self.other_flow),
            oil_c: points(&self.oil_c),
            damping: self.damping,
            rows,
            whitening,
            held: self.held.clone(),
        };
        Some(Coarser { stimulus, kept })
    }
}

/// Means of two values that are held one after the other; the last may be single.
fn means(held: &[f64]) -> Vec<f64> {
    held.chunks(2).map(|pair| pair.iter().sum::<f64>() / pair.len() as f64).collect()
}

/// Values at every second point.
fn every_second(points: &[f64]) -> Vec<f64> {
    points.iter().step_by(2).copied().collect()
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Parameter;
    use recording::{Column, Recording, Signal};
    use test_press::press;

    use super::*;
    use crate::initial_state::StartOffset;
    use crate::run::{Trajectory, simulate_f64};
    use crate::stimulus::InputPoint;

    fn at(times_s: Vec<f64>, tick: Tick, input_point: InputPoint) -> Stimulus {
        let command = times_s.iter().map(|time| if *time < 0.0995 { 0.0 } else { 5.0 - 9.0 * time }).collect();
        let spool = times_s.iter().map(|time| (0.4 * time).min(0.2)).collect();
        let position = vec![0.1; times_s.len()];
        let columns =
            [(Signal::Time, times_s), (Signal::Command, command), (Signal::Spool, spool), (Signal::Position, position)];
        let columns = columns.map(|(signal, values)| Column::si(signal, values)).to_vec();
        let recording = Recording::new("made", columns).unwrap();
        Stimulus::new(&recording, &press(&[]), input_point, LoadSource::Constant, tick).unwrap()
    }

    fn every(interval_s: f64, rows: u32) -> Vec<f64> {
        (0..rows).map(|row| f64::from(row) * interval_s).collect()
    }

    fn run(stimulus: &Stimulus) -> Trajectory {
        let machine = press(&[(Parameter::ViscousFriction, 4e4), (Parameter::TimeConstant2, 0.02)]);
        simulate_f64(&machine, stimulus, StartOffset::none()).unwrap()
    }

    /// Largest difference of a signal at the kept rows from that at the stimulus' own tick, as a share of its span.
    fn apart(fine: &Stimulus, signal: Signal) -> f64 {
        let Coarser { stimulus, kept } = fine.coarser().unwrap();
        let (fine, coarse) = (run(fine), run(&stimulus));
        let (fine, coarse) = (fine.signal(signal).unwrap(), coarse.signal(signal).unwrap());
        assert_eq!(coarse.len(), kept.len());
        let span = fine.iter().copied().fold(f64::MIN, f64::max) - fine.iter().copied().fold(f64::MAX, f64::min);
        kept.iter().zip(coarse).map(|(&row, coarse)| (fine[row] - coarse).abs() / span).fold(0.0, f64::max)
    }

    #[test]
    fn a_grid_of_twice_the_tick_drives_the_chain_the_same_but_for_the_steps_error() {
        use InputPoint::{Command, Spool};
        for (tick, input_point) in
            [(Tick::OneMillisecond, Command), (Tick::OneMillisecond, Spool), (Tick::HalfMillisecond, Command)]
        {
            // An even and an odd number of ticks, rows at half and twice the rate, and rows between the grid points.
            for times_s in
                [every(1e-3, 801), every(1e-3, 800), every(5e-4, 1601), every(2e-3, 401), every(0.93e-3, 860)]
            {
                let fine = at(times_s, tick, input_point);
                let (position, pressure) = (apart(&fine, Signal::Position), apart(&fine, Signal::PressureA));
                // Where a step falls within a tick, motion at the rate limit begins up to half a tick early.
                assert!(
                    position < 3e-3 && pressure < 0.02,
                    "{tick:?} {input_point:?}, {} rows: {position} {pressure}",
                    fine.rows()
                );
            }
        }
        assert!(at(every(2e-3, 401), Tick::TwoMilliseconds, Command).coarser().is_none());
    }

    #[test]
    fn at_most_one_row_is_kept_a_tick() {
        let kept = |times_s| at(times_s, Tick::OneMillisecond, InputPoint::Command).coarser().unwrap().kept;
        assert_eq!(kept(every(1e-3, 6)), [0, 2, 4]);
        assert_eq!(kept(every(2e-3, 5)), [0, 1, 2, 3, 4]);
        assert_eq!(kept(every(5e-4, 13)), [0, 4, 8, 12]);
    }
}
