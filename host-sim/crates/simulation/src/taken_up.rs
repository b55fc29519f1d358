//! Where a recording that begins in motion is taken up.
//!
//! What the first rows tell of pressures and velocity is only as good as the rows after them: there are none before. An error of some mm/s in the velocity
//! makes the oil spring ring, for as long as a short recording lasts. So a run from such a row goes on until the valve has settled and nothing changes
//! quickly, and then takes pressures, velocity and position from the rows on both sides of that moment. The rows before are not judged.

use std::ops::Range;

use machine_file::DELAY_LINE;
use model_core::drive::{Drive, DriveState};
use model_core::machine::{Bases, Machine, Parameter, Tick};
use model_core::number::{Real, Scalar};
use model_core::ports::ChamberState;
use recording::Signal;

use crate::initial_state::{Offset, beside};
use crate::sensor_bias::{PRESSURE_A, PRESSURE_B, behind, within};
use crate::sensor_fault::Mended;
use crate::start_in_motion::longest_unknown_s;
use crate::straight_line::{Line, noise_of};

/// The moving oil and mass at one moment of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakenUp {
    /// Time since the first row, s: a point of every grid.
    pub after_s: f64,
    /// Pressures in A and B as their sensors read them, Pa.
    pub pressures_pa: (f64, f64),
    /// Velocity, m/s.
    pub velocity_m_per_s: f64,
    /// Position as its sensor reads it, m; `None` where it is not recorded.
    pub position_m: Option<f64>,
}

/// Shortest time after which a run is taken up, s: rows enough on either side to tell a velocity.
const LEAST_S: f64 = 0.03;
/// Fewest rows on either side that tell a pressure, and a velocity.
const LEAST_ROWS: usize = 1;
const LEAST_ROWS_OF_SLOPE: usize = 3;
/// Where rows tell the same for so long on either side, s, nothing changes quickly. A later moment is not looked for.
const CALM_S: f64 = 0.015;
/// By how much calmer a later moment has to be: the rows before it are lost.
const BY: f64 = 2.0;
/// Intervals of this many standard deviations hold what they estimate (Katkovnik 1999: 2 to 3).
const INTERVAL: f64 = 2.5;
/// How much wider each window is than the one before.
const WIDER: f64 = 1.4;

impl TakenUp {
    /// What a recording shows at the first calm moment after the time that its start leaves unknown, s; where there is none, at one that is far calmer than those before. `None` where it
    /// is too short, or does not show both pressures and the motion.
    pub(crate) fn of(mended: &Mended<'_>, unknown_for_s: f64) -> Option<Self> {
        let time_s = mended.recording.time_s();
        let channel = |signal| Channel::new(mended, signal);
        let (a, b) = (channel(Signal::PressureA)?, channel(Signal::PressureB)?);
        let (velocity, position) = (channel(Signal::Velocity), channel(Signal::Position));
        let of_rows_s = time_s.get(LEAST_ROWS_OF_SLOPE)? - time_s[0];
        let grid_s = Tick::TwoMilliseconds.seconds();
        let on_grid = |after_s: f64| (after_s / grid_s).ceil() * grid_s;
        let first_s = on_grid(unknown_for_s.max(LEAST_S).max(of_rows_s));
        let longest_s = longest_unknown_s(time_s).max(unknown_for_s) + grid_s;
        let mut calmest: Option<(f64, Self)> = None;
        for later in (0_u32..).map(f64::from) {
            let after_s = on_grid(first_s + later * CALM_S);
            if after_s > longest_s {
                break;
            }
            let value = |channel: &Channel<'_>| channel.value(after_s);
            let motion = velocity.as_ref().and_then(value).or_else(|| position.as_ref()?.slope(after_s));
            let (Some((a, calm_a)), Some((b, calm_b)), Some((velocity, calm_v))) = (value(&a), value(&b), motion)
            else {
                continue;
            };
            let calm_s = calm_a.min(calm_b).min(calm_v);
            if calmest.is_none_or(|(known, _)| calm_s > BY * known) {
                let position_m = position.as_ref().and_then(value).map(|(position_m, _)| position_m);
                calmest =
                    Some((calm_s, Self { after_s, pressures_pa: (a, b), velocity_m_per_s: velocity, position_m }));
            }
            if calm_s >= CALM_S {
                break;
            }
        }
        calmest.map(|(_, taken_up)| taken_up)
    }

    /// The point of the grid at which a run is taken up.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a second over a tick")]
    pub(crate) fn point(&self, tick: Tick) -> usize {
        (self.after_s / tick.seconds()).round() as usize
    }

    /// The pressures behind what the sensors read, and the velocity, per unit.
    pub(crate) fn per_unit<R: Real>(&self, machine: &Machine<R>, bases: &Bases) -> (ChamberState<R>, f64) {
        let pressure = |sensor, reading| behind(machine, sensor, R::constant(reading)) / R::constant(bases.pressure_pa);
        let (a, b) = self.pressures_pa;
        let pressures = ChamberState { a: pressure(PRESSURE_A, a), b: pressure(PRESSURE_B, b) };
        (pressures, self.velocity_m_per_s / bases.velocity_m_per_s)
    }

    /// How much further than where its sensor reads it the rod is, strokes. A fit's shift of the start stays in it; its place within a play is the run's.
    pub(crate) fn further<R: Real>(&self, machine: &Machine<R>, offset: Offset<R>, reading_m: R) -> R {
        let Some(position_m) = self.position_m else { return R::ZERO };
        let shift_m = offset.shift_m - beside(machine, offset.shift_m);
        (R::constant(position_m) + shift_m - reading_m) / machine.get(Parameter::Stroke)
    }

    /// Goes on from what the recording shows.
    pub(crate) fn take<N: Scalar>(
        &self,
        drive: &Drive<N>,
        machine: &Machine<N::Real>,
        offset: Offset<N::Real>,
        state: &mut DriveState<N, DELAY_LINE>,
    ) {
        let reading_m = N::strokes(drive.sensed(state).position) * machine.get(Parameter::Stroke);
        let further = self.further(machine, offset, reading_m);
        state.motion.position = N::travel(N::strokes(state.motion.position) + further);
        state.sensed.shift(within(further));
        let (pressures, velocity) = self.per_unit(machine, drive.bases());
        state.chambers = ChamberState { a: within(pressures.a), b: within(pressures.b) };
        state.motion.velocity = N::saturated(velocity);
    }
}

/// A channel of a recording.
struct Channel<'a> {
    mended: &'a Mended<'a>,
    signal: Signal,
    time_s: &'a [f64],
    values: &'a [f64],
    noise: f64,
}

impl<'a> Channel<'a> {
    /// `None` where the signal is not recorded.
    fn new(mended: &'a Mended<'a>, signal: Signal) -> Option<Self> {
        let values = mended.recording.signal(signal)?;
        Some(Self { mended, signal, time_s: mended.recording.time_s(), values, noise: noise_of(values) })
    }

    /// Its value after this time, s, and for how long its rows tell the same.
    fn value(&self, after_s: f64) -> Option<(f64, f64)> {
        let at_s = self.time_s[0] + after_s;
        self.estimate(after_s, LEAST_ROWS, |line| (line.at(at_s), line.std_at(at_s)))
    }

    /// Its slope after this time, s, and for how long its rows tell the same.
    fn slope(&self, after_s: f64) -> Option<(f64, f64)> {
        self.estimate(after_s, LEAST_ROWS_OF_SLOPE, |line| (line.slope, line.slope_std))
    }

    /// What the rows tell of a moment, by the widest window that agrees with all narrower ones within the noise: of a straight stretch many rows, of a bend
    /// few (intersection of confidence intervals; Goldenshluger and Nemirovski 1997). `quantity` gives a value and its standard deviation. `None` where the
    /// sensor is at an end of its range, or there are too few rows.
    fn estimate(&self, after_s: f64, least_rows: usize, quantity: impl Fn(&Line) -> (f64, f64)) -> Option<(f64, f64)> {
        let mut half_s = self.time_s.get(least_rows)? - self.time_s[0];
        let (mut low, mut high, mut found) = (f64::NEG_INFINITY, f64::INFINITY, None);
        while half_s <= after_s {
            let rows = self.rows(after_s, half_s);
            if rows.len() > least_rows {
                let line = Line::through(&self.time_s[rows.clone()], &self.values[rows], self.noise);
                let (value, std) = quantity(&line);
                (low, high) = (low.max(value - INTERVAL * std), high.min(value + INTERVAL * std));
                if low > high {
                    break;
                }
                found = Some((value, half_s));
            }
            half_s *= WIDER;
        }
        found.filter(|(_, half_s)| !self.mended.is_at_end(self.signal, self.rows(after_s, *half_s)))
    }

    /// The rows that are no further from a moment than this, s.
    fn rows(&self, after_s: f64, half_s: f64) -> Range<usize> {
        let at_s = self.time_s[0] + after_s;
        self.time_s.partition_point(|time| *time < at_s - half_s)
            ..self.time_s.partition_point(|time| *time <= at_s + half_s)
    }
}
