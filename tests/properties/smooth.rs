//! Runs in which nothing switches: there the step shows its second order on any machine.
//!
//! The spool moves along a sine to one side and is given at both ends of each tick; no dead zone, no limit, no dry friction; the pressures
//! stay away from the corner of the root at Δp = 0; and the oil spring is damped, so that nothing rings: with ringing at ω·h near 1 no tick
//! here is short enough to show any order. Before each run the drive runs in at the shortest tick.

use std::f64::consts::TAU;

use proptest::prelude::*;

use model_core::drive::{DriveInput, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::Number;
use model_core::ports::Spool;
use system_tests::any_machine::any_machine;
use system_tests::simulate::{Row, State, at_rest, drive, row};
use virtual_plant::InitialState;

/// The ticks, longest first.
pub(crate) const TICKS: [Tick; 3] = [Tick::TwoMilliseconds, Tick::OneMillisecond, Tick::HalfMillisecond];
/// Length of a run, s.
const LENGTH_S: f64 = 0.4;
/// Time to run in, s; during three quarters of it the spool opens to its sine.
const RUN_IN_S: f64 = 2.0;
/// Least damping of the oil spring, as a share of the critical damping.
const DAMPING: f64 = 0.25;
/// Least pressure difference over an open edge, supply pressures.
const CORNER: f64 = 0.02;

/// A drive and the motion of its spool.
#[derive(Clone, Debug)]
pub(crate) struct Smooth {
    pub(crate) machine: Machine<f64>,
    /// Mean travel, signed.
    travel: f64,
    frequency_hz: f64,
}

/// The state at a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    pub(crate) spool: f64,
    pub(crate) row: Row,
}

pub(crate) fn any_smooth() -> impl Strategy<Value = Smooth> {
    (any_machine(), 0.02..0.5_f64, 0.5..3.0_f64, any::<bool>()).prop_map(|(machine, travel, frequency_hz, extends)| {
        let get = |parameter| machine.get(parameter);
        let spring =
            |area, volume| get(area) * get(area) / (get(volume) / get(P::BulkModulus) + get(P::HoseCompliance));
        let spring = spring(P::AreaA, P::VolumeA) + spring(P::AreaB, P::VolumeB);
        let damping = 2.0 * DAMPING * (spring * get(P::MovingMass)).sqrt();
        let machine = machine.with(&[
            (P::FlowLimit, f64::INFINITY),
            (P::DeadZone, 0.0),
            (P::CoulombFriction, 0.0),
            (P::ViscousFriction, get(P::ViscousFriction).max(damping)),
        ]);
        Smooth { machine, travel: if extends { travel } else { -travel }, frequency_hz }
    })
}

impl Smooth {
    fn spool(&self, time_s: f64) -> f64 {
        let opened = ((time_s + RUN_IN_S) / (0.75 * RUN_IN_S)).min(1.0);
        let opened = 0.2 + 0.8 * opened * opened * (3.0 - 2.0 * opened);
        self.travel * opened * (1.0 + 0.4 * (TAU * self.frequency_hz * time_s).sin())
    }

    fn drive_input(&self, row: usize, tick_s: f64, from_s: f64) -> DriveInput<f64> {
        let at = |row: usize| self.spool(from_s + row as f64 * tick_s);
        DriveInput::Spool(Spool { from: at(row), to: at(row + 1) })
    }

    /// The run at a tick, one state for each tick; `None` where it comes near a corner.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of ticks")]
    pub(crate) fn run(&self, tick: Tick) -> Option<Vec<At>> {
        let ticks = |length_s: f64, tick: Tick| (length_s / tick.seconds()).round() as usize;
        let shortest = drive::<f64>(&self.machine, Tick::HalfMillisecond);
        let mut state: State<f64> = at_rest(&shortest, 0.0, &InitialState::at_rest(&self.machine, 0.0));
        for row in 0..ticks(RUN_IN_S, Tick::HalfMillisecond) {
            shortest.step(&mut state, self.drive_input(row, Tick::HalfMillisecond.seconds(), -RUN_IN_S), Load::NONE);
        }
        state.motion.position = f64::travel(0.0);
        let drive = drive::<f64>(&self.machine, tick);
        state.motion.velocity *= shortest.bases().velocity_m_per_s / drive.bases().velocity_m_per_s;
        let count = ticks(LENGTH_S, tick);
        let mut seen = Vec::with_capacity(count);
        for index in 0..count {
            seen.push(At { spool: self.spool(index as f64 * tick.seconds()), row: row(&state) });
            drive.step(&mut state, self.drive_input(index, tick.seconds(), 0.0), Load::NONE);
        }
        let tank = self.machine.get(P::TankPressure) / self.machine.get(P::SupplyPressure);
        let clear = |at: &At| {
            let Row { pressure_a, pressure_b, .. } = at.row;
            let (fed, drained) = if self.travel > 0.0 { (pressure_a, pressure_b) } else { (pressure_b, pressure_a) };
            (1.0 - fed).abs() > CORNER && (drained - tank).abs() > CORNER
        };
        seen.iter().all(clear).then_some(seen)
    }
}

/// Quantile of the factors by which halving the tick divides an error, over many machines: the share `of` them is at most this.
pub(crate) fn quantile(ratios: &mut [f64], of: f64) -> f64 {
    ratios.sort_by(f64::total_cmp);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index")]
    let index = (of * (ratios.len() - 1) as f64) as usize;
    ratios[index]
}
