//! Images that contain only the model's step, or the whole control period: their flash, and a check that nothing in them can panic.

use model_core::number::Single;
use mps2::trial::{every_effect, press};
use object::{Object, ObjectSymbol, SymbolKind};
use system_tests::emulator::Processor;

use crate::baked::Exports;

/// Images that contain only a step: of any drive, of the paper's model by itself, and of a baked drive.
const STEPS: [&str; 5] = ["step", "paper_step", "baked_step", SINGLE_STEPS[0], SINGLE_STEPS[1]];

/// The first two in single precision.
const SINGLE_STEPS: [&str; 2] = ["step_single", "paper_step_single"];

/// Functions of an image, by their mangled names.
fn functions(processor: Processor, binary: &str) -> Vec<String> {
    functions_of(&processor.image(binary))
}

fn functions_of(image: &[u8]) -> Vec<String> {
    let image = object::File::parse(image).expect("cargo links ELF for this target");
    let functions = image.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text);
    functions.filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect()
}

/// Parts of the names of panicking functions: the handler, and `core`'s functions that lead to it.
const PANICS: [&str; 5] = ["panic", "rust_begin_unwind", "_fail", "PanicInfo", "index_len"];

/// The functions that can panic.
fn panics(functions: &[String]) -> Vec<&String> {
    functions.iter().filter(|name| PANICS.iter().any(|part| name.contains(part))).collect()
}

#[test]
fn no_panic_can_be_reached_from_the_step() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            for binary in STEPS {
                let functions = functions(processor, binary);
                assert!(functions.iter().any(|name| name == "main"), "{processor:?}: there is nothing in {binary}");
                assert_eq!(panics(&functions), Vec::<&String>::new(), "{processor:?}: {binary}");
                assert_eq!(floats(&functions), Vec::<&String>::new(), "{processor:?}: {binary}");
            }
        }
    }
}

/// Functions for arithmetic in double precision, which no processor here has in its FPU.
const DOUBLE: &[&str] = &["__aeabi_d", "__aeabi_f2d", "__adddf3", "__subdf3", "__muldf3", "__divdf3", "__extendsfdf2"];
/// Functions for arithmetic in single precision on a processor without an FPU.
const SOFT_SINGLE: &[&str] = &["__aeabi_f", "__addsf3", "__subsf3", "__mulsf3", "__divsf3", "sqrtf"];

/// The functions with these names, or beginnings of them.
fn named<'a>(functions: &'a [String], starts: &[&str]) -> Vec<&'a String> {
    functions.iter().filter(|name| starts.iter().any(|start| name.starts_with(start))).collect()
}

fn floats(functions: &[String]) -> Vec<&String> {
    named(functions, DOUBLE)
}

#[test]
fn a_step_in_single_precision_has_nothing_in_double_precision_and_with_an_fpu_nothing_in_software() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            for binary in SINGLE_STEPS {
                let functions = functions(processor, binary);
                assert_eq!(floats(&functions), Vec::<&String>::new(), "{processor:?}: {binary}");
                let soft = named(&functions, SOFT_SINGLE);
                assert_eq!(soft.is_empty(), processor == Processor::M4F, "{processor:?}: {binary}: {soft:?}");
            }
        }
    }
}

#[test]
fn a_drive_baked_in_single_precision_panics_nowhere_and_has_nothing_in_double_precision_nor_in_software() {
    let processor = Processor::M4F;
    if processor.can_be_built_for() {
        for machine in [press(), every_effect(&press())] {
            let mut exports = Exports::new();
            let file = exports.add::<Single>("single", &machine, &[]);
            let functions = functions_of(&processor.image_with(&[("FIRMWARE_BAKED", &file)], "baked_step"));
            assert!(functions.iter().any(|name| name == "main"), "there is nothing in it");
            assert_eq!(panics(&functions), Vec::<&String>::new());
            assert_eq!(named(&functions, &[DOUBLE, SOFT_SINGLE].concat()), Vec::<&String>::new());
        }
    }
}

#[test]
fn no_panic_and_no_double_can_be_reached_from_a_whole_period_not_even_where_following_begins() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            let functions = functions(processor, "period");
            let more = processor.flash("period") > processor.flash("step");
            assert!(more, "{processor:?}: there is no more than the model in it");
            assert_eq!(panics(&functions), Vec::<&String>::new(), "{processor:?}");
            assert_eq!(floats(&functions), Vec::<&String>::new(), "{processor:?}");
        }
    }
}

#[test]
fn a_panic_that_can_be_reached_would_show() {
    if Processor::M4F.can_be_built_for() {
        let starting = functions(Processor::M4F, "parity");
        assert!(!panics(&starting).is_empty(), "start-up code formats and unwraps");
        assert!(!floats(&starting).is_empty(), "and converts from SI");
    }
}
