//! The description by FMI 2.0.
//!
//! What `fmi-schema` writes as the standard has it is taken from there. It writes a variable without its limits, no empty list of
//! dependencies, and the elements in another order than the standard's schema: these have types here.

use fmi_schema::fmi2::{Category, CoSimulation, DefaultExperiment, LogCategories, TypeDefinitions, UnitDefinitions};
use fmi_schema::fmi3::{Causality, Initial, Variability};
use fmi_schema::utils::AttrList;
use hard_xml::XmlWrite;
use model_core::machine::Source;

use super::{LOG_CATEGORY, MODEL_IDENTIFIER, NAMES, TOOL, at_once, kind, of, outputs, printable, quantities, summary};
use crate::fmu::contents::Contents;
use crate::fmu::token;
use crate::fmu::units::Quantity;
use crate::fmu::variable::Variable;

/// A description, in the order of the standard's schema.
#[derive(Debug, XmlWrite)]
#[xml(tag = "fmiModelDescription")]
pub(crate) struct ModelDescription {
    #[xml(attr = "fmiVersion")]
    fmi_version: String,
    #[xml(attr = "modelName")]
    model_name: String,
    /// The same token as in FMI 3.0.
    #[xml(attr = "guid")]
    guid: String,
    #[xml(attr = "description")]
    description: String,
    #[xml(attr = "generationTool")]
    generation_tool: String,
    #[xml(attr = "variableNamingConvention")]
    variable_naming_convention: String,
    #[xml(child = "CoSimulation")]
    co_simulation: CoSimulation,
    #[xml(child = "UnitDefinitions")]
    unit_definitions: UnitDefinitions,
    #[xml(child = "TypeDefinitions")]
    type_definitions: TypeDefinitions,
    #[xml(child = "LogCategories")]
    log_categories: LogCategories,
    #[xml(child = "DefaultExperiment")]
    default_experiment: DefaultExperiment,
    #[xml(child = "ModelVariables")]
    model_variables: ModelVariables,
    #[xml(child = "ModelStructure")]
    model_structure: ModelStructure,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "ModelVariables")]
struct ModelVariables {
    #[xml(child = "ScalarVariable")]
    variables: Vec<ScalarVariable>,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "ScalarVariable")]
struct ScalarVariable {
    #[xml(attr = "name")]
    name: String,
    #[xml(attr = "valueReference")]
    value_reference: u32,
    #[xml(attr = "description")]
    description: String,
    #[xml(attr = "causality")]
    causality: Causality,
    #[xml(attr = "variability")]
    variability: Variability,
    #[xml(attr = "initial")]
    initial: Option<Initial>,
    #[xml(child = "Real")]
    real: Real,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "Real")]
struct Real {
    #[xml(attr = "declaredType")]
    declared_type: String,
    #[xml(attr = "min")]
    min: Option<f64>,
    #[xml(attr = "max")]
    max: Option<f64>,
    #[xml(attr = "start")]
    start: Option<f64>,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "ModelStructure")]
struct ModelStructure {
    #[xml(child = "Outputs")]
    outputs: Outputs,
    #[xml(child = "InitialUnknowns")]
    initial_unknowns: InitialUnknowns,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "Outputs")]
struct Outputs {
    #[xml(child = "Unknown")]
    unknowns: Vec<Unknown>,
}

#[derive(Debug, XmlWrite)]
#[xml(tag = "InitialUnknowns")]
struct InitialUnknowns {
    #[xml(child = "Unknown")]
    unknowns: Vec<Unknown>,
}

/// An output, by its place among the variables; the first is 1.
#[derive(Debug, XmlWrite)]
#[xml(tag = "Unknown")]
struct Unknown {
    #[xml(attr = "index")]
    index: usize,
    #[xml(attr = "dependencies")]
    dependencies: Option<AttrList<usize>>,
}

/// The description of a drive's variables, and of what its library can do.
pub(crate) fn description(contents: &Contents) -> ModelDescription {
    let source = contents.machine.source;
    let quantities = quantities(source);
    let (category, meaning) = LOG_CATEGORY;
    ModelDescription {
        fmi_version: "2.0".to_owned(),
        model_name: printable(&contents.name),
        guid: token(contents),
        description: summary(contents),
        generation_tool: TOOL.to_owned(),
        variable_naming_convention: NAMES.to_owned(),
        co_simulation: CoSimulation {
            model_identifier: MODEL_IDENTIFIER.to_owned(),
            can_get_and_set_fmu_state: Some(true),
            can_serialize_fmu_state: Some(true),
            // Steps are whole numbers of ticks.
            can_handle_variable_communication_step_size: Some(true),
            // It takes its memory by itself.
            can_not_use_memory_management_functions: Some(true),
            ..CoSimulation::default()
        },
        unit_definitions: UnitDefinitions { units: quantities.iter().map(Quantity::fmi2_unit).collect() },
        type_definitions: TypeDefinitions { types: quantities.iter().map(Quantity::simple_type).collect() },
        log_categories: LogCategories {
            categories: vec![Category { name: category.to_owned(), description: Some(meaning.to_owned()) }],
        },
        default_experiment: DefaultExperiment {
            start_time: Some(0.0),
            step_size: Some(contents.settings.tick.seconds()),
            ..DefaultExperiment::default()
        },
        model_variables: ModelVariables {
            variables: Variable::of(source).map(|variable| described(variable, contents)).collect(),
        },
        model_structure: structure(source),
    }
}

fn described(variable: Variable, contents: &Contents) -> ScalarVariable {
    let (causality, variability, initial) = kind(variable);
    let (min, max) = variable.range(&contents.machine).unzip();
    let start = variable.start(&contents.machine);
    ScalarVariable {
        name: variable.name().to_owned(),
        value_reference: variable.reference(),
        description: variable.meaning().to_owned(),
        causality,
        variability,
        initial,
        real: Real { declared_type: of(variable).name.to_owned(), min, max, start },
    }
}

/// The outputs, by their places.
fn structure(source: Source) -> ModelStructure {
    // Every variable that is asked for is one of this source.
    let index = |asked: Variable| 1 + Variable::of(source).take_while(|&variable| variable != asked).count();
    let output = |variable: Variable| {
        let inputs = at_once(source, variable).iter().map(|&input| index(input)).collect();
        Unknown { index: index(variable), dependencies: Some(AttrList(inputs)) }
    };
    let initial = |variable: Variable| Unknown { index: index(variable), dependencies: None };
    ModelStructure {
        outputs: Outputs { unknowns: outputs(source).map(output).collect() },
        initial_unknowns: InitialUnknowns { unknowns: outputs(source).map(initial).collect() },
    }
}

#[cfg(test)]
mod tests {
    use fmi_schema::fmi2::Fmi2ModelDescription;
    use model_core::machine::Parameter;
    use test_press::press;

    use super::super::tests::contents;
    use super::*;

    fn written(contents: &Contents) -> String {
        fmi_schema::serialize(&description(contents), false).unwrap()
    }

    #[test]
    fn a_variable_has_its_type_its_start_and_its_limits() {
        let xml = written(&contents("press <63> & \"40\"\u{1}", &press(&[(Parameter::Stroke, 0.3)])));
        let read: Fmi2ModelDescription = fmi_schema::deserialize(&xml).unwrap();
        assert_eq!((read.fmi_version.as_str(), read.model_name.as_str()), ("2.0", "press <63> & \"40\" "));
        for expected in [
            r#" causality="independent" variability="continuous"><Real declaredType="Time"/>"#,
            r#" causality="input" variability="continuous"><Real declaredType="Voltage" start="0"/>"#,
            r#"<Real declaredType="Length" min="0" max="0.3" start="0.15"/>"#,
            r#" causality="output" variability="continuous" initial="calculated"><Real declaredType="Pressure"/>"#,
            r#"<Unit name="V"><BaseUnit kg="1" m="2" s="-3" A="-1"/></Unit>"#,
            r#"<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>"#,
        ] {
            assert!(xml.contains(expected), "{expected}: {xml}");
        }
    }

    #[test]
    fn an_output_is_named_by_its_place_and_with_what_it_follows_at_once() {
        let structure = structure(Source::Pump);
        let outputs: Vec<String> =
            structure.outputs.unknowns.iter().map(|output| output.to_string().unwrap()).collect();
        assert_eq!(outputs[0], r#"<Unknown index="7" dependencies=""/>"#);
        assert_eq!(outputs[4], r#"<Unknown index="11" dependencies="2 3"/>"#);
        assert_eq!(structure.initial_unknowns.unknowns[0].to_string().unwrap(), r#"<Unknown index="7"/>"#);
    }
}
