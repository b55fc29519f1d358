//! `modelDescription.xml` of an FMU: what both versions of the standard say of a drive, each in its own words.

pub(crate) mod fmi2;
pub(crate) mod fmi3;

use fmi_schema::fmi3::{Causality, Initial, Variability};

use model_core::machine::Source;
use simulation::Arithmetic;

use super::contents::Contents;
use super::units::{Quantity, quantity};
use super::variable::{Role, Variable};

/// What the library is called in the archive.
pub const MODEL_IDENTIFIER: &str = "drive";
/// The program that wrote the description.
const TOOL: &str = concat!("host-sim ", env!("CARGO_PKG_VERSION"));
/// Which convention the variables' names follow.
const NAMES: &str = "flat";
/// The category of all messages of the library, and what it holds.
const LOG_CATEGORY: (&str, &str) = ("logStatusError", "Why a call could not be done");

/// What the FMU is, in one line.
fn summary(contents: &Contents) -> String {
    let arithmetic = match contents.settings.arithmetic {
        Arithmetic::Fixed => "fixed point, as a controller computes it",
        Arithmetic::Float => "floating point",
    };
    format!("Hydraulic drive, stepped by {} ms in {arithmetic}; SI units", 1e3 * contents.settings.tick.seconds())
}

/// What a variable is to the tool. The words are the same in both versions.
fn kind(variable: Variable) -> (Causality, Variability, Option<Initial>) {
    match variable.role() {
        Role::Time => (Causality::Independent, Variability::Continuous, None),
        Role::Input => (Causality::Input, Variability::Continuous, None),
        Role::Parameter => (Causality::Parameter, Variability::Fixed, Some(Initial::Exact)),
        Role::Output => (Causality::Output, Variability::Continuous, Some(Initial::Calculated)),
    }
}

/// The outputs of a drive with this source. The initial state of each depends on values that are given before it.
fn outputs(source: Source) -> impl Iterator<Item = Variable> {
    Variable::of(source).filter(|variable| matches!(variable.role(), Role::Output))
}

/// The inputs that an output follows at once. Outputs depend on the state; only a pump's flow changes at the same moment as the pump's inputs.
const fn at_once(source: Source, output: Variable) -> &'static [Variable] {
    match (source, output) {
        (Source::Pump, Variable::Flow) => &[Variable::PumpSpeed, Variable::ValveDirection],
        _ => &[],
    }
}

fn of(variable: Variable) -> Quantity {
    quantity(variable.signal().dimensions()[0])
}

/// The quantities of a drive's variables, each once.
fn quantities(source: Source) -> Vec<Quantity> {
    let mut all: Vec<Quantity> = Vec::new();
    for variable in Variable::of(source) {
        if all.iter().all(|known| known.name != of(variable).name) {
            all.push(of(variable));
        }
    }
    all
}

/// A name in which characters that XML does not allow are replaced by spaces.
fn printable(name: &str) -> String {
    let allowed = |c: char| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c };
    name.chars().map(allowed).collect()
}

#[cfg(test)]
mod tests {
    use model_core::machine::{Machine, Parameter, Tick};
    use test_press::press;

    use super::*;
    use crate::fmu::contents::Settings;
    use crate::fmu::token;

    pub(super) fn contents(name: &str, machine: &Machine<f64>) -> Contents {
        Contents {
            name: name.to_owned(),
            machine: *machine,
            settings: Settings { tick: Tick::OneMillisecond, arithmetic: Arithmetic::Fixed },
        }
    }

    #[test]
    fn the_token_is_that_of_one_drive_and_not_of_its_name() {
        let of = |name: &str, changes: &[(Parameter, f64)]| token(&contents(name, &press(changes)));
        assert_eq!(of("a", &[]), of("b", &[]));
        assert!(of("a", &[]).starts_with(concat!("drive-fmu/", env!("CARGO_PKG_VERSION"), "/valve/")));
        let next = press(&[]).get(Parameter::SupplyPressure).next_up();
        assert_ne!(of("a", &[]), of("a", &[(Parameter::SupplyPressure, next)]));
        let mut other = contents("a", &press(&[]));
        other.settings.tick = Tick::HalfMillisecond;
        assert_ne!(of("a", &[]), token(&other));
    }

    #[test]
    fn only_a_pumps_flow_follows_its_inputs_at_once() {
        let following = |source| {
            let inputs = |output| (output, at_once(source, output).len());
            outputs(source).map(inputs).filter(|(_, inputs)| *inputs > 0).collect::<Vec<_>>()
        };
        assert_eq!(following(Source::Valve), []);
        assert_eq!(following(Source::Pump), [(Variable::Flow, 2)]);
    }
}
