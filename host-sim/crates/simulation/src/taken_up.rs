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
/// A window that tells is not made wider than this on either side, s: of a rest it would be as long as the recording.
const WIDEST_S: f64 = 1.0;

impl TakenUp {
    /// What a recording shows at the first calm moment after the time that its start leaves unknown, s; where there is none, at one that is far calmer than those before. `None` where it
    /// is too short, or does not show both pressures and the motion.
    pub(crate) fn of(mended: &Mended<'_>, unknown_for_s: f64) -> Option<Self> {
        let time_s = mended.recording.time_s();
        let channels = Channels::of(|signal| {
            let values = mended.recording.signal(signal)?;
            Some(Channel::new(time_s, values, move |rows| mended.is_at_end(signal, rows)))
        })?;
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
            let Some((taken_up, calm_s)) = channels.at(after_s) else { continue };
            if calmest.is_none_or(|(known, _)| calm_s > BY * known) {
                calmest = Some((calm_s, taken_up));
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

/// The channels of a recording that tell how oil and mass move.
pub(crate) struct Channels<'a> {
    pressures: (Channel<'a>, Channel<'a>),
    velocity: Option<Channel<'a>>,
    position: Option<Channel<'a>>,
}

impl<'a> Channels<'a> {
    /// `None` where a pressure is not recorded.
    pub(crate) fn of(channel: impl Fn(Signal) -> Option<Channel<'a>>) -> Option<Self> {
        let pressures = (channel(Signal::PressureA)?, channel(Signal::PressureB)?);
        Some(Self { pressures, velocity: channel(Signal::Velocity), position: channel(Signal::Position) })
    }

    /// What they show after this time, s, and for how long their rows tell the same; `None` where one does not tell.
    pub(crate) fn at(&self, after_s: f64) -> Option<(TakenUp, f64)> {
        let Self { pressures: (a, b), velocity, position } = self;
        let value = |channel: &Channel<'_>| channel.value(after_s);
        let ((a, calm_a), (b, calm_b)) = (value(a)?, value(b)?);
        let motion = velocity.as_ref().and_then(value).or_else(|| position.as_ref()?.slope(after_s));
        let (velocity_m_per_s, calm_v) = motion?;
        let position_m = position.as_ref().and_then(value).map(|(position_m, _)| position_m);
        let shown = TakenUp { after_s, pressures_pa: (a, b), velocity_m_per_s, position_m };
        Some((shown, calm_a.min(calm_b).min(calm_v)))
    }
}

/// A channel of a recording.
pub(crate) struct Channel<'a> {
    time_s: &'a [f64],
    values: &'a [f64],
    noise: f64,
    /// Whether these rows say nothing.
    is_lost: Box<dyn Fn(Range<usize>) -> bool + 'a>,
}

impl<'a> Channel<'a> {
    pub(crate) fn new(time_s: &'a [f64], values: &'a [f64], is_lost: impl Fn(Range<usize>) -> bool + 'a) -> Self {
        Self { time_s, values, noise: noise_of(values), is_lost: Box::new(is_lost) }
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
    /// rows say nothing, or are too few.
    fn estimate(&self, after_s: f64, least_rows: usize, quantity: impl Fn(&Line) -> (f64, f64)) -> Option<(f64, f64)> {
        let mut half_s = self.time_s.get(least_rows)? - self.time_s[0];
        let (mut low, mut high, mut found) = (f64::NEG_INFINITY, f64::INFINITY, None);
        while half_s <= after_s {
            let rows = self.rows(after_s, half_s);
            if (self.is_lost)(rows.clone()) {
                break;
            }
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
            if found.is_some() && half_s > WIDEST_S {
                break;
            }
        }
        found
    }

    /// The rows that are no further from a moment than this, s.
    fn rows(&self, after_s: f64, half_s: f64) -> Range<usize> {
        let at_s = self.time_s[0] + after_s;
        self.time_s.partition_point(|time| *time < at_s - half_s)
            ..self.time_s.partition_point(|time| *time <= at_s + half_s)
    }
}
