//! A drive as its sensors show it, moment by moment: means and derivatives over short windows, for recorded and for simulated
//! drives alike.

use std::borrow::Cow;

use diagnosis::localisation::balances::Coefficients;
use diagnosis::{Diagnosis, Shown};
use identification::fit::settle;
use model_core::drive::Drive;
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use model_core::ports::ChamberState;
use recording::{Recording, Signal};
use simulation::signal::window::Window;
use simulation::{DELAY_LINE, InputPoint, Trajectory, simulate_f64};

use super::Drives;

/// Length of a moment, s.
const MOMENT_S: f64 = 0.03;

/// The model's laws that a picture is measured against, with the effect itself taken out.
pub(crate) struct Law {
    /// The machine after without the effect.
    pub(crate) machine: Machine<f64>,
    /// The machine after.
    after: Machine<f64>,
    pub(crate) by: Coefficients,
    pub(crate) dead_zone: f64,
    pub(crate) flow_coefficient: f64,
    pub(crate) supply_pa: f64,
    pub(crate) tank_pa: f64,
}

impl Law {
    pub(crate) fn of(machine: &Machine<f64>, after: &Machine<f64>) -> Self {
        Self {
            machine: *machine,
            after: *after,
            by: Coefficients::of(machine),
            dead_zone: machine.get(Parameter::DeadZone),
            flow_coefficient: machine.get(Parameter::FlowCoefficient),
            supply_pa: machine.get(Parameter::SupplyPressure),
            tank_pa: machine.get(Parameter::TankPressure),
        }
    }
}

/// A drive over one window.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Since the recording's start, s.
    pub(crate) time_s: f64,
    pub(crate) command_v: f64,
    /// Direction of the spool's last movement.
    pub(crate) turned: i8,
    pub(crate) spool: f64,
    /// Spool position less that of the model without the effect.
    pub(crate) spool_off: f64,
    pub(crate) a_pa: f64,
    pub(crate) b_pa: f64,
    /// Pressures less those of the model without the effect.
    pub(crate) a_off_pa: f64,
    pub(crate) b_off_pa: f64,
    pub(crate) a_rate: f64,
    pub(crate) b_rate: f64,
    pub(crate) supply_pa: f64,
    pub(crate) position_m: f64,
    /// Position and velocity less those of the model without the effect.
    pub(crate) position_off_m: f64,
    pub(crate) velocity_off: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    /// Of the oil, or as it was measured where that drives the model, N.
    pub(crate) force_n: f64,
    /// External force without the constant one, N.
    pub(crate) load_n: f64,
    pub(crate) pump_rev_per_s: f64,
    /// `None` where it is not recorded.
    pub(crate) oil_c: Option<f64>,
    /// Flow through the model's ports at this spool position and these pressures, m³/s.
    pub(crate) port_a: f64,
    pub(crate) port_b: f64,
}

/// One value per row, of one drive.
struct View<'a> {
    spool: Cow<'a, [f64]>,
    a: Cow<'a, [f64]>,
    b: Cow<'a, [f64]>,
    supply: Cow<'a, [f64]>,
    position: Cow<'a, [f64]>,
}

/// Every moment of every recording, for the recorded drive and both models.
pub(crate) fn moments(law: &Law, diagnosis: &Diagnosis, recordings: &[&Recording]) -> Result<Drives, MachineError> {
    let mut drives = Drives { recorded: Vec::new(), before: Vec::new(), after: Vec::new() };
    for (shown, recording) in diagnosis.shown.iter().zip(recordings) {
        let windows = Window::over(&shown.prepared.time_s, MOMENT_S);
        let before = simulated(law, shown, recording, &shown.before);
        let after = simulated(law, shown, recording, &shown.after);
        let recorded = recorded(shown, &before);
        let start = settle(&law.after, &shown.prepared)?.offset(&law.after, &shown.prepared);
        let reference = simulate_f64(&law.machine, &shown.prepared.stimulus, start)?;
        let reference = simulated(law, shown, recording, &reference);
        let flows = |view: &View<'_>| ports(law, shown.prepared.stimulus.tick, recording, view);
        let of = |view: &View<'_>| -> Result<Vec<Moment>, MachineError> {
            Ok(over(law, &windows, shown, recording, view, &reference, &flows(view)?))
        };
        drives.recorded.extend(of(&recorded)?);
        drives.before.extend(of(&before)?);
        drives.after.extend(of(&after)?);
    }
    Ok(drives)
}

fn simulated<'a>(law: &Law, shown: &Shown, recording: &'a Recording, trajectory: &'a Trajectory) -> View<'a> {
    let rows = shown.prepared.time_s.len();
    let of = |signal: Signal, else_value: f64| {
        let known = trajectory.signal(signal).or_else(|| recording.signal(signal));
        known.map_or_else(|| Cow::Owned(vec![else_value; rows]), Cow::Borrowed)
    };
    View {
        spool: of(Signal::Spool, 0.0),
        a: of(Signal::PressureA, 0.0),
        b: of(Signal::PressureB, 0.0),
        supply: of(Signal::SupplyPressure, law.supply_pa),
        position: of(Signal::Position, 0.0),
    }
}

/// The recorded drive; what is not recorded is taken from the model before.
fn recorded<'a>(shown: &Shown, before: &View<'a>) -> View<'a> {
    let of = |signal: Signal, simulated: &Cow<'a, [f64]>| {
        let channel = shown.prepared.channels.iter().find(|channel| channel.signal == signal);
        channel.map_or_else(|| simulated.clone(), |channel| Cow::Owned(channel.bridged()))
    };
    View {
        spool: of(Signal::Spool, &before.spool),
        a: of(Signal::PressureA, &before.a),
        b: of(Signal::PressureB, &before.b),
        supply: of(Signal::SupplyPressure, &before.supply),
        position: of(Signal::Position, &before.position),
    }
}

/// Flow into A and out of B through the law's ports at every row.
fn ports(law: &Law, tick: Tick, recording: &Recording, view: &View<'_>) -> Result<(Vec<f64>, Vec<f64>), MachineError> {
    let drive = Drive::<f64>::new::<DELAY_LINE>(&law.machine, tick)?;
    let bases = *drive.bases();
    let speed = recording.signal(Signal::PumpSpeed);
    let direction = recording.signal(Signal::ValveDirection);
    Ok((0..view.spool.len())
        .map(|row| {
            let speed = speed.map_or(0.0, |speed| speed[row]);
            let sense = direction.map_or(speed, |direction| direction[row]);
            let direction = i8::from(sense > 1e-9) - i8::from(sense < -1e-9);
            let pump = PumpDrive { speed: speed / bases.pump_speed_rev_per_s, direction };
            let state = ChamberState { a: view.a[row] / bases.pressure_pa, b: view.b[row] / bases.pressure_pa };
            let flows = if law.machine.source == Source::Valve {
                drive.flows_from(view.supply[row] / bases.pressure_pa, view.spool[row], pump, state)
            } else {
                drive.flows(view.spool[row], pump, state)
            };
            (flows.a * bases.flow_m3_per_s, flows.b * bases.flow_m3_per_s)
        })
        .unzip())
}

fn over(
    law: &Law,
    windows: &[Window],
    shown: &Shown,
    recording: &Recording,
    view: &View<'_>,
    reference: &View<'_>,
    (port_a, port_b): &(Vec<f64>, Vec<f64>),
) -> Vec<Moment> {
    let time_s = &shown.prepared.time_s;
    let rows = time_s.len();
    let given = |signal: Signal| recording.signal(signal).map_or_else(|| Cow::Owned(vec![0.0; rows]), Cow::Borrowed);
    let drives = if recording.has(Signal::Command) { Signal::Command } else { Signal::PumpSpeed };
    let (command, load, pump) = (given(drives), given(Signal::LoadForce), given(Signal::PumpSpeed));
    let oil = recording.signal(Signal::OilTemperature);
    let (area_a, area_b) = law.by.area;
    let measured = recording.signal(Signal::Force).filter(|_| is_entered_at_force(shown));
    let force = measured.map_or_else(
        || Cow::Owned(view.a.iter().zip(&*view.b).map(|(a, b)| area_a * a - area_b * b).collect()),
        Cow::Borrowed,
    );
    let turned = turns(&reference.spool);
    let minus = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let position_off = minus(&view.position, &reference.position);
    let ones = vec![1.0; rows];
    windows
        .iter()
        .map(|window| {
            let weight = window.sum(&ones);
            let mean = |values: &[f64]| window.sum(values) / weight;
            let slope = |values: &[f64]| window.change(values) / weight;
            Moment {
                time_s: time_s[window.middle()] - time_s[0],
                command_v: mean(&command),
                turned: turned[window.middle()],
                spool: mean(&view.spool),
                spool_off: mean(&view.spool) - mean(&reference.spool),
                a_pa: mean(&view.a),
                b_pa: mean(&view.b),
                a_off_pa: mean(&view.a) - mean(&reference.a),
                b_off_pa: mean(&view.b) - mean(&reference.b),
                a_rate: slope(&view.a),
                b_rate: slope(&view.b),
                supply_pa: mean(&view.supply),
                position_m: mean(&view.position),
                position_off_m: mean(&position_off),
                velocity_off: slope(&position_off),
                velocity: slope(&view.position),
                acceleration: window.curvature(&view.position) / weight,
                force_n: mean(&force),
                load_n: mean(&load),
                pump_rev_per_s: mean(&pump),
                oil_c: oil.map(&mean),
                port_a: mean(port_a),
                port_b: mean(port_b),
            }
        })
        .collect()
}

/// Whether a measured force, or that of both pressures, drives the model.
pub(crate) fn is_entered_at_force(shown: &Shown) -> bool {
    shown.prepared.stimulus.input_point == InputPoint::Force
}

/// Smallest travel that counts as a movement of the spool, as a share of its full travel.
const TURNS: f64 = 2e-3;

/// Direction of a series' last movement, at each row.
fn turns(values: &[f64]) -> Vec<i8> {
    let (mut last, mut low, mut high) = (0, f64::MAX, f64::MIN);
    values
        .iter()
        .map(|value| {
            (low, high) = (low.min(*value), high.max(*value));
            if *value > low + TURNS && last != 1 {
                (last, high) = (1, *value);
            } else if *value < high - TURNS && last != -1 {
                (last, low) = (-1, *value);
            }
            // While it moves one way, the opposite extreme is updated with it.
            match last {
                1 => low = high,
                -1 => high = low,
                _ => {}
            }
            last
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_turns_where_it_comes_back_and_not_where_it_trembles() {
        let mut values: Vec<f64> = (0..100).map(|k| 0.01 * f64::from(k)).collect();
        values.extend((0..100).map(|k| 0.99 + 5e-4 * f64::from(k % 2)));
        values.extend((0..100).map(|k| 0.99 - 0.01 * f64::from(k)));
        let turned = turns(&values);
        assert_eq!((turned[0], turned[50], turned[150], turned[199], turned[210], turned[299]), (0, 1, 1, 1, -1, -1));
    }
}
