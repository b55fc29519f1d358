//! The description by FMI 3.0, with the types of `fmi-schema`.

use fmi_schema::fmi3::{
    Category, DefaultExperiment, Fmi3CoSimulation, Fmi3ModelDescription, Fmi3Unknown, FmiFloat64, LogCategories,
    ModelStructure, ModelVariables, TypeDefinition, TypeDefinitions, UnitDefinitions, Variable as Described,
    VariableDependency,
};
use fmi_schema::utils::AttrList;

use model_core::machine::Source;

use super::{LOG_CATEGORY, MODEL_IDENTIFIER, NAMES, TOOL, at_once, kind, of, outputs, printable, quantities, summary};
use crate::fmu::contents::Contents;
use crate::fmu::token;
use crate::fmu::units::Quantity;
use crate::fmu::variable::Variable;

/// The description of a drive's variables, and of what its library can do.
pub(crate) fn description(contents: &Contents) -> Fmi3ModelDescription {
    let source = contents.machine.source;
    let tick_s = contents.settings.tick.seconds();
    let quantities = quantities(source);
    let (category, meaning) = LOG_CATEGORY;
    Fmi3ModelDescription {
        fmi_version: "3.0".to_owned(),
        model_name: printable(&contents.name),
        instantiation_token: token(contents),
        description: Some(summary(contents)),
        generation_tool: Some(TOOL.to_owned()),
        variable_naming_convention: Some(NAMES.to_owned()),
        co_simulation: Some(Fmi3CoSimulation {
            model_identifier: MODEL_IDENTIFIER.to_owned(),
            can_get_and_set_fmu_state: Some(true),
            can_serialize_fmu_state: Some(true),
            // Steps are whole numbers of ticks.
            can_handle_variable_communication_step_size: Some(true),
            fixed_internal_step_size: Some(tick_s),
            ..Fmi3CoSimulation::default()
        }),
        unit_definitions: Some(UnitDefinitions { units: quantities.iter().map(Quantity::fmi3_unit).collect() }),
        type_definitions: Some(TypeDefinitions {
            type_definitions: quantities.iter().map(Quantity::float64_type).map(TypeDefinition::Float64).collect(),
        }),
        log_categories: Some(LogCategories {
            categories: vec![Category {
                name: category.to_owned(),
                description: Some(meaning.to_owned()),
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
    let (causality, variability, initial) = kind(variable);
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

/// The outputs, by their value references.
fn structure(source: Source) -> ModelStructure {
    let output = |variable: Variable| {
        let inputs = at_once(source, variable).iter().map(|input| input.reference()).collect();
        VariableDependency::Output(Fmi3Unknown {
            value_reference: variable.reference(),
            dependencies: Some(AttrList(inputs)),
            ..Fmi3Unknown::default()
        })
    };
    let initial = |variable: Variable| {
        VariableDependency::InitialUnknown(Fmi3Unknown {
            value_reference: variable.reference(),
            ..Fmi3Unknown::default()
        })
    };
    ModelStructure { unknowns: outputs(source).map(output).chain(outputs(source).map(initial)).collect() }
}

#[cfg(test)]
mod tests {
    use fmi_schema::fmi3::{AbstractVariableTrait, InitializableVariableTrait, TypedVariableTrait};

    use model_core::machine::Parameter;
    use test_press::press;

    use super::super::tests::contents;
    use super::*;

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
}
