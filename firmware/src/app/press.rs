//! The rig of the shipped drive: its values, its wiring, its limits, its tuning.
//!
//! The values are those that `host-sim export` wrote into `machine.rs`, or into the file that the environment variable
//! `FIRMWARE_MACHINE` names while the firmware is built: in this way identified or diagnosed values reach the controller.

use model_core::control::Tuning;
use model_core::machine::{Bases, Machine};

use crate::excitation::Excitation;
use crate::excitation::plan::Plan;
use crate::io::ads8688::{CHANNELS, Range};
use crate::measured::AnalogSignal;
use crate::monitor::{Monitor, MonitorError, Sensitivity, Spread};
use crate::period::Rig;
use crate::scaling::{Actuator, Band, Calibration, CalibrationError, Encoder, Point, Rising, Sensor, Travel};
use crate::set_point::Bounds;
use crate::supervision::{Allowed, Delay, Deviation, Limits, LimitsError, Response};

/// What `host-sim export` wrote.
pub mod values {
    include!(concat!(env!("OUT_DIR"), "/machine.rs"));
}

/// What `host-sim plan --firmware` wrote.
pub mod planned {
    include!(concat!(env!("OUT_DIR"), "/plan.rs"));
}

/// What the operator may play after the [`EXCITATIONS`]: the plan in `plan.rs`, or in the file that `FIRMWARE_PLAN` names while the firmware is built.
pub const PLAN: &Plan<'static> = &planned::PLAN;

/// Length of a tick, ns.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "two milliseconds at most")]
pub const TICK_NS: u32 = (values::TICK.seconds() * 1e9) as u32;

/// Ranges of the converter's channels: 1 spool, 2 and 3 pressures in A and B; where the command is read back, channel 0 has [`READ_BACK_RANGE`].
pub const RANGES: [Option<Range>; CHANNELS] =
    [None, Some(Range::Bipolar10V), Some(Range::Unipolar5V), Some(Range::Unipolar5V), None, None, None, None];

/// Range of channel 0, which the command is read back by.
pub const READ_BACK_RANGE: Range = Range::Bipolar10V;
/// The command at the valve's end of its wire, on channel 0.
pub const READ_BACK: Sensor = Sensor {
    channel: 0,
    low: Point { volts: -10.0, value: -10.0 },
    high: Point { volts: 10.0, value: 10.0 },
    working: Band { from_v: -10.05, to_v: 10.05 },
    open: None,
};
/// How long the voltage read back may differ from the output.
pub const READ_BACK_AWAY: Delay = Delay { by: 0.05, for_s: 0.005 };

/// Encoder counts per metre of rod, all edges: a 3600-impulse encoder on a rack of 0.2 m per turn.
pub const COUNTS_PER_M: f64 = 72_000.0;
/// Spool travel at 10 V of its LVDT.
pub const SPOOL_AT_10_V: f64 = 1.0;
/// Pressure at 4.5 V of its sensor, Pa; 0.5 V means no pressure.
pub const PRESSURE_AT_4_5_V_PA: f64 = 10e6;

/// Largest command, V, and its slew, V/s: the same for the loops and for the period that checks them, so that nothing winds up between the two.
pub(super) const COMMAND_V: f64 = 9.5;
const SLEW_V_PER_S: f64 = 2000.0;

/// Where the rod may be sent, and how fast. At its largest command the press moves out at 70 and in at 45 mm/s; with its values off by what the limits of
/// deviation allow for, it still reaches these bounds.
pub const BOUNDS: Bounds = Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.036, acceleration_m_per_s2: 0.5 };
/// How fast an operator at a keyboard sends the rod within them.
pub const BY_HAND: Bounds = Bounds { velocity_m_per_s: 0.03, acceleration_m_per_s2: 0.3, ..BOUNDS };

/// What the operator may play, by number: a sine, a sweep, strokes. Each takes the four seconds that the recorder keeps after its trigger.
pub const EXCITATIONS: [Excitation; 3] = [
    Excitation::Sine { amplitude_m: 3e-3, frequency_hz: 1.0, duration_s: 4.0 },
    Excitation::Sweep { amplitude_m: 0.01, from_hz: 0.5, to_hz: 10.0, duration_s: 4.0 },
    Excitation::Strokes { amplitude_m: 3e-3, rest_s: 0.05 },
];

/// What the monitor's alarm leads to, unless the operator says otherwise.
pub const ALARM: Option<Response> = Some(Response::RampDown);

/// How far the first set point may be from the rod.
const JUMP_M: f64 = 0.001;

/// What the monitor attributes to chance: sensor noise, and what the press's model is known not to predict.
pub const SENSITIVITY: Sensitivity = Sensitivity {
    spool: Spread { sigma: 5e-3, correlation_s: 0.02 },
    pressure: Spread { sigma: 1.5e5, correlation_s: 0.02 },
    position: Spread { sigma: 2e-4, correlation_s: 0.2 },
    memory_s: 0.5,
    between_false_alarms_s: 1e5,
};

/// Why no rig is made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PressError {
    /// The wiring.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The limits.
    #[error(transparent)]
    Limits(#[from] LimitsError),
    /// The monitor.
    #[error(transparent)]
    Monitor(#[from] MonitorError),
}

/// The drive.
#[must_use]
pub fn machine() -> Machine<f64> {
    Machine::with_defaults(values::SOURCE).with(values::VALUES)
}

/// Tuning by rule, for a measured spool and the encoder's resolution.
#[must_use]
pub fn tuning(machine: &Machine<f64>) -> Tuning {
    Tuning {
        position_resolution_m: 1.0 / COUNTS_PER_M,
        command_limit_v: COMMAND_V,
        slew_v_per_s: SLEW_V_PER_S,
        ..Tuning::by_rule(machine, true)
    }
}

/// Wiring and limits, for converters of these spans (µV per 2¹⁶ counts).
///
/// # Errors
/// A value of the drive does not fit wiring or limits.
pub fn rig(machine: &Machine<f64>, bases: &Bases, input_uv: u32, output_uv: u32) -> Result<Rig, PressError> {
    let spool = Sensor {
        channel: 1,
        low: Point { volts: 0.0, value: 0.0 },
        high: Point { volts: 10.0, value: SPOOL_AT_10_V },
        working: Band { from_v: -10.05, to_v: 10.05 },
        open: Some(Band { from_v: 10.15, to_v: 10.24 }),
    };
    let pressure = |channel| Sensor {
        channel,
        low: Point { volts: 0.5, value: 0.0 },
        high: Point { volts: 4.5, value: PRESSURE_AT_4_5_V_PA },
        working: Band { from_v: 0.4, to_v: 4.6 },
        open: Some(Band { from_v: 0.0, to_v: 0.3 }),
    };
    let sensors =
        [(AnalogSignal::Spool, spool), (AnalogSignal::PressureA, pressure(2)), (AnalogSignal::PressureB, pressure(3))];
    let actuator = Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -10.0, highest_v: 10.0 };
    let encoder =
        Encoder { counts_per_m: COUNTS_PER_M, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 };
    let allowed = Allowed {
        attempts: 3,
        settling_s: 0.1,
        bounds: BOUNDS,
        jump_m: JUMP_M,
        set_point_step_m: 0.0,
        command_v: COMMAND_V,
        slew_v_per_s: SLEW_V_PER_S,
        ramp_v_per_s: 50.0,
        still_position: Some(Delay { by: 0.003, for_s: 0.2 }),
        still_spool: Some(Delay { by: 0.1, for_s: 0.2 }),
        still_pressure: Some(Delay { by: 0.5e6, for_s: 0.5 }),
        read_back: None,
        deviation: Deviation { alarm: ALARM, ..Deviation::by_rule(machine, &tuning(machine), &BOUNDS, JUMP_M) },
    };
    let limits = Limits::new(&allowed, machine, bases)?;
    let calibration = Calibration::new(&sensors, input_uv, &actuator, output_uv, bases)?;
    let monitor = Some(Monitor::new(&SENSITIVITY, bases)?);
    Ok(Rig { calibration, travel: Travel::straight(&encoder, bases)?, limits, monitor })
}
