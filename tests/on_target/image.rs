//! Images that contain only the model's step, or the whole control period: their flash, and a check that nothing in them can panic.

use object::{Object, ObjectSymbol, SymbolKind};

use system_tests::emulator::Processor;

/// Images that contain only a step: of any drive, of the paper's model by itself, and of a baked drive.
const STEPS: [&str; 3] = ["step", "paper_step", "baked_step"];

/// Functions of an image, by their mangled names.
fn functions(processor: Processor, binary: &str) -> Vec<String> {
    let image = processor.image(binary);
    let image = object::File::parse(&*image).expect("cargo links ELF for this target");
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

/// Floating-point arithmetic of a processor without an FPU.
fn floats(functions: &[String]) -> Vec<&String> {
    let double = ["__aeabi_d", "__adddf3", "__subdf3", "__muldf3", "__divdf3"];
    functions.iter().filter(|name| double.iter().any(|start| name.starts_with(start))).collect()
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
