//! A drive that its caller steps tick by tick, with inputs that are not known beforehand.
//!
//! It starts, steps and reads as [`run`](crate::run::run) does for a recording of the same inputs, bit for bit.

use machine_file::DELAY_LINE;
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, MachineError, Source, Tick};
use model_core::number::{PerUnit, Scalar};
use recording::Signal;

use crate::arithmetic::Arithmetic;
use crate::initial_state::{StartOffset, at_start};
use crate::recorded_start::Start;
use crate::run::reading;
use crate::stimulus::sign;

/// Inputs that act on a drive over a tick, SI; a drive uses those that its source needs. A mass that a force moves has `load_force_n` for it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Inputs {
    /// Command at the valve, V; positive extends.
    pub command_v: f64,
    /// Mean speed of the pump, rev/s.
    pub pump_speed_rev_per_s: f64,
    /// Directional valve: positive leads the pump to A, negative to B, 0 is closed.
    pub valve_direction: f64,
    /// External force on the rod in addition to the machine's constant load, N; positive extends.
    pub load_force_n: f64,
    /// Temperature of the oil, °C.
    pub oil_temperature_c: f64,
}

/// A drive and its state, in the number type that it was made with.
#[derive(Clone, Debug, PartialEq)]
pub struct Live(Number);

#[derive(Clone, Debug, PartialEq)]
enum Number {
    Fixed(Box<Stepped<PerUnit>>),
    Float(Box<Stepped<f64>>),
}

/// A stored state, from which a simulation can be continued.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Kept {
    /// Of a drive in fixed point.
    Fixed(Box<DriveState<PerUnit, DELAY_LINE>>),
    /// Of a drive in f64.
    Float(Box<DriveState<f64, DELAY_LINE>>),
}

/// A stored state has another number type than the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the state is of another number type than the drive")]
pub struct OtherArithmetic;

impl Live {
    /// A drive at rest.
    ///
    /// # Errors
    /// The number type does not hold the drive at this tick; the error names the value that does not fit.
    pub fn new(
        machine: &Machine<f64>,
        tick: Tick,
        start: &Start,
        arithmetic: Arithmetic,
    ) -> Result<Self, MachineError> {
        Ok(Self(match arithmetic {
            Arithmetic::Fixed => Number::Fixed(Box::new(Stepped::new(machine, tick, start)?)),
            Arithmetic::Float => Number::Float(Box::new(Stepped::new(machine, tick, start)?)),
        }))
    }

    /// One tick, over which the inputs are held.
    pub fn step(&mut self, inputs: &Inputs) {
        match &mut self.0 {
            Number::Fixed(drive) => drive.step(inputs),
            Number::Float(drive) => drive.step(inputs),
        }
    }

    /// The value of a signal as its sensor reads it, SI, if the drive computes it; for a pump, the flow under these inputs.
    #[must_use]
    pub fn signal(&self, signal: Signal, inputs: &Inputs) -> Option<f64> {
        match &self.0 {
            Number::Fixed(drive) => drive.signal(signal, inputs),
            Number::Float(drive) => drive.signal(signal, inputs),
        }
    }

    /// The state, to be stored.
    #[must_use]
    pub fn kept(&self) -> Kept {
        match &self.0 {
            Number::Fixed(drive) => Kept::Fixed(Box::new(drive.state)),
            Number::Float(drive) => Kept::Float(Box::new(drive.state)),
        }
    }

    /// Continues from a stored state.
    pub fn restore(&mut self, kept: &Kept) -> Result<(), OtherArithmetic> {
        match (&mut self.0, kept) {
            (Number::Fixed(drive), Kept::Fixed(state)) => drive.state = **state,
            (Number::Float(drive), Kept::Float(state)) => drive.state = **state,
            _ => return Err(OtherArithmetic),
        }
        Ok(())
    }
}

/// The same in one number type.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stepped<N: Scalar<Real = f64>> {
    machine: Machine<f64>,
    drive: Drive<N>,
    state: DriveState<N, DELAY_LINE>,
}

impl<N: Scalar<Real = f64>> Stepped<N> {
    fn new(machine: &Machine<f64>, tick: Tick, start: &Start) -> Result<Self, MachineError> {
        let drive = Drive::new::<DELAY_LINE>(machine, tick)?;
        let state = at_start(&drive, machine, start, StartOffset::none().lifted());
        Ok(Self { machine: *machine, drive, state })
    }

    /// One tick, over which the inputs are held.
    fn step(&mut self, inputs: &Inputs) {
        let bases = *self.drive.bases();
        let load = N::saturated(inputs.load_force_n / bases.force_n);
        let drive_input = match self.machine.source {
            Source::Valve => DriveInput::Command(N::saturated(inputs.command_v / bases.command_v)),
            Source::Pump => DriveInput::Pump(self.pump(inputs)),
            Source::Force => DriveInput::Force { from: N::ZERO, to: N::ZERO },
        };
        self.state.oil_temperature = N::saturated(inputs.oil_temperature_c / bases.temperature_c);
        self.drive.step(&mut self.state, drive_input, Load { from: load, to: load });
    }

    /// The value of a signal as its sensor reads it, SI, if the drive computes it; for a pump, the flow under these inputs.
    fn signal(&self, signal: Signal, inputs: &Inputs) -> Option<f64> {
        let spool = || self.drive.spool(&self.state);
        let sensed = || self.drive.sensed(&self.state).spool;
        let flow_a = || self.drive.flows_of(&self.state, spool(), self.pump(inputs)).a;
        let is_there = match self.machine.source {
            Source::Valve => true,
            Source::Pump => signal != Signal::Spool,
            Source::Force => matches!(signal, Signal::Velocity | Signal::Position),
        };
        if !is_there {
            return None;
        }
        reading(&self.drive, &self.machine, &self.state, signal, sensed, flow_a)
    }

    fn pump(&self, inputs: &Inputs) -> PumpDrive<N> {
        let full_speed = self.drive.bases().pump_speed_rev_per_s;
        PumpDrive {
            speed: N::saturated(inputs.pump_speed_rev_per_s / full_speed),
            direction: sign(inputs.valve_direction),
        }
    }
}

#[cfg(test)]
mod tests {
    use machine_file::LoadSource;
    use model_core::machine::Parameter;
    use recording::{Column, Recording};
    use test_press::press;

    use super::*;
    use crate::stimulus::{InputPoint, Stimulus, first_input_point};

    const TICK: Tick = Tick::OneMillisecond;
    const ROWS: usize = 1500;

    /// Every signal of a drive that is stepped live equals that of a simulation, at every tick.
    fn as_simulated(
        arithmetic: Arithmetic,
        machine: &Machine<f64>,
        inputs: impl Fn(usize) -> Inputs,
        given: &[Signal],
    ) {
        let column = |&signal: &Signal| {
            let value = |k: usize| match signal {
                Signal::Command => inputs(k).command_v,
                Signal::PumpSpeed => inputs(k).pump_speed_rev_per_s,
                Signal::ValveDirection => inputs(k).valve_direction,
                Signal::LoadForce => inputs(k).load_force_n,
                Signal::OilTemperature => inputs(k).oil_temperature_c,
                Signal::Position => 0.5 * machine.get(Parameter::Stroke),
                _ => k as f64 * TICK.seconds(),
            };
            Column::si(signal, (0..ROWS).map(value).collect())
        };
        let always = [Signal::Time, Signal::Position];
        let recording = Recording::new("inputs", always.iter().chain(given).map(column).collect()).unwrap();
        let input_point = first_input_point(machine.source, &recording).unwrap();
        let stimulus = Stimulus::new(&recording, machine, input_point, LoadSource::Constant, TICK).unwrap();
        let simulated = arithmetic.simulate(machine, &stimulus, StartOffset::none()).unwrap();
        let mut live = Live::new(machine, TICK, &stimulus.start, arithmetic).unwrap();
        // After the last row of a recording nothing acts any more: a pump's flow is 0 there.
        for k in 0..ROWS - 1 {
            for (signal, values) in &simulated.series {
                assert_eq!(live.signal(*signal, &inputs(k)), Some(values[k]), "{signal} at {k}");
            }
            live.step(&inputs(k));
        }
        assert_eq!(input_point == InputPoint::Pump, live.signal(Signal::Spool, &inputs(0)).is_none());
        assert_eq!(live.signal(Signal::OilTemperature, &inputs(0)), None);
    }

    const NOTHING: Inputs = Inputs {
        command_v: 0.0,
        pump_speed_rev_per_s: 0.0,
        valve_direction: 0.0,
        load_force_n: 0.0,
        oil_temperature_c: 40.0,
    };

    fn thinning() -> Machine<f64> {
        press(&[
            (Parameter::InternalLeakage, 2e-12),
            (Parameter::CoulombFriction, 300.0),
            (Parameter::ViscosityLossPerKelvin, 0.03),
        ])
    }

    #[test]
    fn a_valve_drive_does_live_what_it_does_in_a_simulation() {
        let inputs = |k: usize| Inputs {
            command_v: if k < 300 { 0.5 } else { -3.0 },
            load_force_n: -700.0,
            oil_temperature_c: 55.0,
            ..NOTHING
        };
        let given = [Signal::Command, Signal::LoadForce, Signal::OilTemperature];
        as_simulated(Arithmetic::Float, &thinning(), inputs, &given);
        as_simulated(Arithmetic::Fixed, &thinning(), inputs, &given);
    }

    #[test]
    fn oil_at_the_machines_reference_is_oil_that_nobody_measures() {
        let inputs = |k: usize| Inputs { command_v: 1e-3 * k as f64, ..NOTHING };
        as_simulated(Arithmetic::Float, &thinning(), inputs, &[Signal::Command]);
        as_simulated(Arithmetic::Fixed, &thinning(), inputs, &[Signal::Command]);
    }

    #[test]
    fn a_pump_drive_does_live_what_it_does_in_a_simulation() {
        let mut machine = Machine::with_defaults(Source::Pump);
        let press = press(&[]);
        for parameter in [Parameter::AreaA, Parameter::AreaB, Parameter::VolumeA, Parameter::VolumeB] {
            machine.set(parameter, press.get(parameter));
        }
        let inputs = |_| Inputs { pump_speed_rev_per_s: 20.0, valve_direction: -1.0, ..NOTHING };
        let given = [Signal::PumpSpeed, Signal::ValveDirection];
        as_simulated(Arithmetic::Float, &machine, inputs, &given);
        as_simulated(Arithmetic::Fixed, &machine, inputs, &given);
    }

    /// Its force is the load, of which live and recorded inputs know one kind.
    #[test]
    fn a_mass_is_moved_live_by_its_load_and_shows_only_its_motion() {
        let values = [(Parameter::MovingMass, 20.0), (Parameter::ViscousFriction, 50.0)];
        let machine = Machine::with_defaults(Source::Force).with(&values);
        let inputs = Inputs { load_force_n: 10.0, ..NOTHING };
        for arithmetic in [Arithmetic::Fixed, Arithmetic::Float] {
            let mut live = Live::new(&machine, TICK, &Start::at_rest(0.0, None, 0.15), arithmetic).unwrap();
            for _ in 0..8000 {
                live.step(&inputs);
            }
            let velocity = live.signal(Signal::Velocity, &inputs).unwrap();
            assert!((velocity - 10.0 / 50.0).abs() < 1e-5, "{velocity}");
            assert!(live.signal(Signal::Position, &inputs).is_some_and(|position| position > 1.0));
            assert_eq!(
                [Signal::PressureA, Signal::Spool, Signal::Flow].map(|one| live.signal(one, &inputs)),
                [None; 3]
            );
        }
    }
}
