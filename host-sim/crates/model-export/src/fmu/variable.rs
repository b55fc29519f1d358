//! The variables of an FMU: which exist, what they mean, and the numbers by which a tool refers to them.

use model_core::machine::{Machine, Parameter, Source};
use recording::Signal;
use simulation::Inputs;

/// What a variable is to the tool that imports the FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The simulated time.
    Time,
    /// The tool sets it, at any communication point; it is held until the next.
    Input,
    /// The tool may set it before the simulation begins.
    Parameter,
    /// The drive computes it.
    Output,
}

/// A variable of an FMU. All are real numbers in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variable {
    /// Simulated time, s.
    Time,
    /// Command at the valve, V; positive extends.
    Command,
    /// Speed of the pump, rev/s.
    PumpSpeed,
    /// Directional valve: positive leads the pump to A, negative to B, 0 is closed.
    ValveDirection,
    /// External force on the rod in addition to the machine's constant load, N; positive extends.
    LoadForce,
    /// Temperature of the oil, °C.
    OilTemperature,
    /// Position of the rod at the start, m; 0 is fully in.
    PositionAtStart,
    /// Spool.
    Spool,
    /// Position of the rod.
    Position,
    /// Velocity of the rod.
    Velocity,
    /// Pressure in chamber A.
    PressureA,
    /// Pressure in chamber B.
    PressureB,
    /// Flow into chamber A.
    Flow,
    /// Force of the oil on the rod.
    Force,
}

impl Variable {
    /// Every variable, in the order of their numbers.
    pub const ALL: [Variable; 14] = [
        Variable::Time,
        Variable::Command,
        Variable::PumpSpeed,
        Variable::ValveDirection,
        Variable::LoadForce,
        Variable::OilTemperature,
        Variable::PositionAtStart,
        Variable::Spool,
        Variable::Position,
        Variable::Velocity,
        Variable::PressureA,
        Variable::PressureB,
        Variable::Flow,
        Variable::Force,
    ];

    /// The variables of a drive with this source. A mass that a force moves has `load_force` for it.
    pub fn of(source: Source) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |variable| match variable {
            Variable::Command | Variable::Spool => source == Source::Valve,
            Variable::PumpSpeed | Variable::ValveDirection => source == Source::Pump,
            Variable::PressureA | Variable::PressureB | Variable::Flow | Variable::Force => source != Source::Force,
            _ => true,
        })
    }

    /// The number by which a tool refers to it.
    #[must_use]
    pub const fn reference(self) -> u32 {
        self as u32
    }

    /// What it is to the tool.
    #[must_use]
    pub const fn role(self) -> Role {
        match self {
            Variable::Time => Role::Time,
            Variable::Command
            | Variable::PumpSpeed
            | Variable::ValveDirection
            | Variable::LoadForce
            | Variable::OilTemperature => Role::Input,
            Variable::PositionAtStart => Role::Parameter,
            Variable::Spool
            | Variable::Position
            | Variable::Velocity
            | Variable::PressureA
            | Variable::PressureB
            | Variable::Flow
            | Variable::Force => Role::Output,
        }
    }

    /// The recorded signal that it corresponds to; for the position at the start, the signal whose value it is.
    #[must_use]
    pub const fn signal(self) -> Signal {
        match self {
            Variable::Time => Signal::Time,
            Variable::Command => Signal::Command,
            Variable::PumpSpeed => Signal::PumpSpeed,
            Variable::ValveDirection => Signal::ValveDirection,
            Variable::LoadForce => Signal::LoadForce,
            Variable::OilTemperature => Signal::OilTemperature,
            Variable::PositionAtStart | Variable::Position => Signal::Position,
            Variable::Spool => Signal::Spool,
            Variable::Velocity => Signal::Velocity,
            Variable::PressureA => Signal::PressureA,
            Variable::PressureB => Signal::PressureB,
            Variable::Flow => Signal::Flow,
            Variable::Force => Signal::Force,
        }
    }

    /// Its name, as in a recording.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Variable::PositionAtStart => "position_start",
            other => other.signal().name(),
        }
    }

    /// Its meaning, with its sign convention; for people.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Variable::Time => "Simulated time",
            Variable::Command => {
                "Command to the valve; positive extends. Held over a step; before the start it was held for long"
            }
            Variable::PumpSpeed => "Speed of the pump. Held over a step",
            Variable::ValveDirection => {
                "Directional valve: positive leads the pump to A, negative to B, 0 is closed. Held over a step"
            }
            Variable::LoadForce => {
                "External force on the rod beside the machine's constant load; positive extends. Held over a step"
            }
            Variable::OilTemperature => "Temperature of the oil. Held over a step",
            Variable::PositionAtStart => "Position of the rod at the start; 0 is fully in, positive is out",
            Variable::Spool => "Spool position as a part of full travel; positive extends",
            Variable::Position => "Position of the rod; 0 is fully in, positive is out",
            Variable::Velocity => "Velocity of the rod; positive extends",
            Variable::PressureA => "Pressure in chamber A; it extends",
            Variable::PressureB => "Pressure in chamber B; it retracts",
            Variable::Flow => "Flow into chamber A; positive extends",
            Variable::Force => "Force of the oil on the rod; positive extends",
        }
    }

    /// Its value before the tool sets it; `None` for values that the drive computes.
    #[must_use]
    pub fn start(self, machine: &Machine<f64>) -> Option<f64> {
        let inputs = inputs_at_start(machine);
        match self {
            Variable::PositionAtStart => Some(0.5 * machine.get(Parameter::Stroke)),
            other => other.of_inputs(&inputs),
        }
    }

    /// The smallest and the largest value that a tool may set; `None` where every finite one is allowed, or the drive computes it.
    #[must_use]
    pub fn range(self, machine: &Machine<f64>) -> Option<(f64, f64)> {
        (self == Variable::PositionAtStart).then(|| (0.0, machine.get(Parameter::Stroke)))
    }

    /// Its value among the inputs of a drive, if it is one.
    #[must_use]
    pub const fn of_inputs(self, inputs: &Inputs) -> Option<f64> {
        Some(match self {
            Variable::Command => inputs.command_v,
            Variable::PumpSpeed => inputs.pump_speed_rev_per_s,
            Variable::ValveDirection => inputs.valve_direction,
            Variable::LoadForce => inputs.load_force_n,
            Variable::OilTemperature => inputs.oil_temperature_c,
            _ => return None,
        })
    }

    /// Its place among the inputs of a drive, if it is one.
    #[must_use]
    pub const fn in_inputs(self, inputs: &mut Inputs) -> Option<&mut f64> {
        Some(match self {
            Variable::Command => &mut inputs.command_v,
            Variable::PumpSpeed => &mut inputs.pump_speed_rev_per_s,
            Variable::ValveDirection => &mut inputs.valve_direction,
            Variable::LoadForce => &mut inputs.load_force_n,
            Variable::OilTemperature => &mut inputs.oil_temperature_c,
            _ => return None,
        })
    }
}

/// The inputs before a tool sets any: all zero, except the oil temperature, which is the one that the machine's values are for.
#[must_use]
pub(crate) fn inputs_at_start(machine: &Machine<f64>) -> Inputs {
    Inputs {
        command_v: 0.0,
        pump_speed_rev_per_s: 0.0,
        valve_direction: 0.0,
        load_force_n: 0.0,
        oil_temperature_c: machine.get(Parameter::ReferenceTemperature),
    }
}

#[cfg(test)]
mod tests {
    use test_press::press;

    use super::*;

    #[test]
    fn a_variable_is_found_by_its_number_and_only_what_is_given_has_a_start() {
        for (number, variable) in Variable::ALL.into_iter().enumerate() {
            assert_eq!(variable.reference() as usize, number);
            let given = matches!(variable.role(), Role::Input | Role::Parameter);
            assert_eq!(variable.start(&press(&[])).is_some(), given, "{variable:?}");
        }
        assert_eq!(Variable::PositionAtStart.start(&press(&[(Parameter::Stroke, 0.3)])), Some(0.15));
    }

    #[test]
    fn a_mass_has_its_force_in_the_load_and_no_oil() {
        let names: Vec<&str> = Variable::of(Source::Force).map(Variable::name).collect();
        assert_eq!(names, ["time", "load_force", "oil_temperature", "position_start", "position", "velocity"]);
    }

    #[test]
    fn a_valve_has_a_command_and_a_spool_where_a_pump_has_speed_and_direction() {
        let names = |source| Variable::of(source).map(Variable::name).collect::<Vec<_>>();
        let (valve, pump) = (names(Source::Valve), names(Source::Pump));
        assert_eq!(valve[..4], ["time", "command", "load_force", "oil_temperature"]);
        assert_eq!(pump[..3], ["time", "pump_speed", "valve_direction"]);
        assert!(valve.contains(&"spool") && !pump.contains(&"spool"));
    }
}
