//! `modelDescription.xml` of an FMU, with the types of FMI 3.0.

use fmi_schema::fmi3::{
    Category, Causality, DefaultExperiment, Fmi3CoSimulation, Fmi3ModelDescription, Fmi3Unknown, FmiFloat64, Initial,
    LogCategories, ModelStructure, ModelVariables, TypeDefinition, TypeDefinitions, UnitDefinitions, Variability,
    Variable as Described, VariableDependency,
};
use fmi_schema::utils::AttrList;

use model_core::machine::Source;
use simulation::Arithmetic;

use super::contents::Contents;
use super::token;
use super::units::{Quantity, quantity};
use super::variable::{Role, Variable};

/// What the library is called in the archive.
pub const MODEL_IDENTIFIER: &str = "drive";
/// The category of all messages of the library.
const LOG_CATEGORY: &str = "logStatusError";

/// The description of a drive's variables, and of what its library can do.
#[must_use]
pub fn description(contents: &Contents) -> Fmi3ModelDescription {
    let source = contents.machine.source;
    let tick_s = contents.settings.tick.seconds();
    let arithmetic = match contents.settings.arithmetic {
        Arithmetic::Fixed => "fixed point, as a controller computes it",
        Arithmetic::Float => "floating point",
    };
    let quantities = quantities(source);
    Fmi3ModelDescription {
        fmi_version: "3.0".to_owned(),
        model_name: printable(&contents.name),
        instantiation_token: token(contents),
        description: Some(format!("Hydraulic drive, stepped by {} ms in {arithmetic}; SI units", 1e3 * tick_s)),
        generation_tool: Some(concat!("host-sim ", env!("CARGO_PKG_VERSION")).to_owned()),
        variable_naming_convention: Some("flat".to_owned()),
        co_simulation: Some(Fmi3CoSimulation {
            model_identifier: MODEL_IDENTIFIER.to_owned(),
            can_get_and_set_fmu_state: Some(true),
            can_serialize_fmu_state: Some(true),
            // Steps are whole numbers of ticks.
            can_handle_variable_communication_step_size: Some(true),
            fixed_internal_step_size: Some(tick_s),
            ..Fmi3CoSimulation::default()
        }),
        unit_definitions: Some(UnitDefinitions { units: quantities.iter().map(Quantity::defined).collect() }),
        type_definitions: Some(TypeDefinitions {
            type_definitions: quantities.iter().map(|quantity| TypeDefinition::Float64(quantity.declared())).collect(),
        }),
        log_categories: Some(LogCategories {
            categories: vec![Category {
                name: LOG_CATEGORY.to_owned(),
                description: Some("Why a call could not be done".to_owned()),
                annotations: None,
            }],
        }),
        default_experiment: Some(DefaultExperiment {
            start_time: Some(0.0),
            step_size: Some(tick_s),
            ..DefaultExperiment::default()
        }),
        model_variables: ModelVariables {
            variables: Variable::of(source).map(|variable| Described::Float64(described(variable, contents))).collect(),
        },
        model_structure: structure(source),
        ..Fmi3ModelDescription::default()
    }
}

fn described(variable: Variable, contents: &Contents) -> FmiFloat64 {
    let (causality, variability, initial) = match variable.role() {
        Role::Time => (Causality::Independent, Variability::Continuous, None),
        Role::Input => (Causality::Input, Variability::Continuous, None),
        Role::Parameter => (Causality::Parameter, Variability::Fixed, Some(Initial::Exact)),
        Role::Output => (Causality::Output, Variability::Continuous, Some(Initial::Calculated)),
    };
    let range = variable.range(&contents.machine);
    FmiFloat64 {
        min: range.map(|(min, _)| min),
        max: range.map(|(_, max)| max),
        declared_type: Some(of(variable).name.to_owned()),
        ..FmiFloat64::new(
            variable.name().to_owned(),
            variable.reference(),
            Some(variable.meaning().to_owned()),
            causality,
            variability,
            variable.start(&contents.machine).map(|start| vec![start]),
            initial,
        )
    }
}

/// Outputs depend on the state; only a pump's flow changes at the same moment as the pump's inputs. The initial state
/// depends on values that are given before it.
fn structure(source: Source) -> ModelStructure {
    let outputs = || Variable::of(source).filter(|variable| matches!(variable.role(), Role::Output));
    let at_once = |output: Variable| match (source, output) {
        (Source::Pump, Variable::Flow) => {
            vec![Variable::PumpSpeed.reference(), Variable::ValveDirection.reference()]
        }
        _ => Vec::new(),
    };
    let output = |variable: Variable| {
        VariableDependency::Output(Fmi3Unknown {
            value_reference: variable.reference(),
            dependencies: Some(AttrList(at_once(variable))),
            ..Fmi3Unknown::default()
        })
    };
    let initial = |variable: Variable| {
        VariableDependency::InitialUnknown(Fmi3Unknown {
            value_reference: variable.reference(),
            ..Fmi3Unknown::default()
        })
    };
    ModelStructure { unknowns: outputs().map(output).chain(outputs().map(initial)).collect() }
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
    use fmi_schema::fmi3::{AbstractVariableTrait, InitializableVariableTrait, TypedVariableTrait};

    use model_core::machine::{Machine, Parameter, Tick};
    use test_press::press;

    use super::*;
    use crate::fmu::contents::Settings;

    fn contents(name: &str, machine: &Machine<f64>) -> Contents {
        Contents {
            name: name.to_owned(),
            machine: *machine,
            settings: Settings { tick: Tick::OneMillisecond, arithmetic: Arithmetic::Fixed },
        }
    }

    #[test]
    fn a_description_reads_back_with_names_types_and_starts() {
        let contents = contents("press <63> & \"40\"\u{1}", &press(&[]));
        let xml = fmi_schema::serialize(&description(&contents), false).unwrap();
        let read: Fmi3ModelDescription = fmi_schema::deserialize(&xml).unwrap();
        assert_eq!(read, description(&contents));
        assert_eq!(read.model_name, "press <63> & \"40\" ");
        let variables = read.model_variables.float64();
        let command = variables.iter().find(|variable| variable.name() == "command").unwrap();
        assert_eq!((command.declared_type(), command.start()), (Some("Voltage"), Some(&[0.0][..])));
        let start = variables.iter().find(|variable| variable.name() == "position_start").unwrap();
        let stroke_m = contents.machine.get(Parameter::Stroke);
        assert_eq!(start.start(), Some(&[0.5 * stroke_m][..]));
        assert_eq!((start.min, start.max, variables[0].max), (Some(0.0), Some(stroke_m), None));
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
        let dependencies = |source| {
            let structure = structure(source);
            let of_output =
                |unknown: &Fmi3Unknown| (unknown.value_reference, unknown.dependencies.as_ref().unwrap().len());
            structure.outputs().map(of_output).filter(|(_, inputs)| *inputs > 0).collect::<Vec<_>>()
        };
        assert_eq!(dependencies(Source::Valve), []);
        assert_eq!(dependencies(Source::Pump), [(Variable::Flow.reference(), 2)]);
    }
}
