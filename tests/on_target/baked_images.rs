//! Images of baked drives hold the code of the drive's own effects alone.

use std::collections::BTreeSet;

use addr2line::Loader;
use model_core::machine::Machine;
use model_core::number::{PerUnit, Single};
use model_export::rust::BakedNumber;
use mps2::trial::{SETS, Set, mass, press, pump};
use object::{Object, ObjectSection};
use system_tests::emulator::Processor;

use crate::baked::Exports;

/// A part of the model's source, by the names of its functions, and what needs it: effects by their names, or `pump`, `valve`.
const PARTS: &[(&str, &[&str])] = &[
    ("valve::Valve", &["valve"]),
    ("flow::pump", &["pump"]),
    ("NullDrift", &["null-drift"]),
    ("SolenoidSaturation", &["solenoid-saturation"]),
    ("Hysteresis", &["valve-hysteresis"]),
    ("FlowForce", &["flow-force"]),
    ("Stiction", &["spool-stiction"]),
    ("GainCurve", &["flow-gain-nonlinearity"]),
    ("ReturnLine", &["tank-back-pressure"]),
    ("ValveLeakage", &["valve-leakage"]),
    (
        "four_edges",
        &[
            "flow-gain-nonlinearity",
            "metering-asymmetry",
            "supply-droop",
            "tank-back-pressure",
            "valve-leakage",
            "counterbalance",
        ],
    ),
    ("flow::supply::Droop", &["supply-droop"]),
    ("flow::load_holding", &["counterbalance"]),
    ("chambers::capacity", &["entrained-air", "position-dependent-volume"]),
    ("cavitati", &["cavitation"]),
    ("mechanics::friction::Stribeck", &["stribeck-friction"]),
    ("mechanics::friction::PlacedDrag", &["position-dependent-friction"]),
    ("mechanics::lugre", &["presliding"]),
    ("mechanics::position_load", &["position-dependent-load"]),
    ("mechanics::end_stop", &["end-stop"]),
    ("correction_table", &["unnamed"]),
    ("oil::Viscosity", &["oil-temperature"]),
];

/// The functions of which an image has instructions, the inlined ones too.
fn functions(image: &[u8]) -> BTreeSet<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image");
    std::fs::write(&path, image).unwrap();
    let loader = Loader::new(&path).unwrap();
    let file = object::File::parse(image).unwrap();
    let text = file.section_by_name(".text").unwrap();
    let mut functions = BTreeSet::new();
    for address in (text.address()..text.address() + text.size()).step_by(2) {
        let mut frames = loader.find_frames(address).unwrap();
        while let Some(frame) = frames.next().unwrap() {
            if let Some(name) = frame.function {
                functions.insert(name.demangle().unwrap().into_owned());
            }
        }
    }
    functions
}

/// Asserts that the image of a baked drive holds no part but those that these effects need. Of what is on, folded constants may leave no function with a
/// name; what should not be there was not folded, and shows as it does in the image of any drive.
fn assert_parts<N: BakedNumber>(name: &str, machine: &Machine<f64>, on: &[&str], level: &str) {
    let mut exports = Exports::new();
    let file = exports.add::<N>(name, machine, &[]);
    let image = Processor::M4F.described(&[("FIRMWARE_BAKED", &file)], "baked_step", level);
    let functions = functions(&image);
    assert!(functions.iter().any(|function| function.contains("main")), "{functions:#?}");
    for (part, needed) in PARTS {
        let found: Vec<&String> = functions.iter().filter(|function| function.contains(part)).collect();
        let is_needed = needed.iter().any(|effect| on.contains(effect));
        assert!(is_needed || found.is_empty(), "{name}, level {level}: {part} is of no use: {found:#?}");
    }
}

/// Asserts that every part has functions that show in an image: here, in that of any drive.
fn assert_every_part_shows() {
    let functions = functions(&Processor::M4F.described(&[], "step", "3"));
    let shows = |part: &str| functions.iter().any(|function| function.contains(part));
    let missing: Vec<&str> = PARTS.iter().map(|(part, _)| *part).filter(|part| !shows(part)).collect();
    assert_eq!(missing, Vec::<&str>::new(), "{functions:#?}");
}

fn names(set: &Set, source: &'static str) -> Vec<&'static str> {
    set.effects.iter().map(|effect| effect.name()).chain([source]).collect()
}

#[test]
fn an_image_of_a_baked_drive_holds_the_code_of_its_own_effects_alone() {
    if !Processor::M4F.can_be_built_for() {
        return;
    }
    assert_every_part_shows();
    assert_parts::<PerUnit>("pump", &pump(), &["pump"], "3");
    assert_parts::<PerUnit>("mass", &mass(), &[], "3");
    for level in ["3", "2", "\"s\""] {
        assert_parts::<PerUnit>("paper", &press(), &["valve"], level);
    }
    // For size the compiler inlines, and so folds, the least.
    for set in SETS {
        assert_parts::<PerUnit>(set.name, &set.on(&press()), &names(set, "valve"), "\"s\"");
    }
    assert_parts::<Single>("paper, f32", &press(), &["valve"], "3");
    for set in SETS {
        assert_parts::<Single>(set.name, &set.on(&press()), &names(set, "valve"), "3");
    }
}
