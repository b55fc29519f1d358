//! Images whose only work is the model's step, or the whole control period: their flash, and that nothing in them can panic.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use system_tests::emulator::Processor;

/// Bytes of these sections.
fn size(processor: Processor, binary: &str, sections: &[&str]) -> u64 {
    let image = processor.image(binary);
    let image = object::File::parse(&*image).expect("cargo links ELF for this target");
    sections.iter().filter_map(|name| image.section_by_name(name)).map(|section| section.size()).sum()
}

/// Code and constants of an image, bytes; the processor's start-up, some 200, is part of it.
pub(crate) fn flash(processor: Processor, binary: &str) -> u64 {
    size(processor, binary, &[".text", ".rodata"])
}

/// What an image has in RAM from the start to the end, bytes.
pub(crate) fn statics(processor: Processor, binary: &str) -> u64 {
    size(processor, binary, &[".data", ".bss"])
}

/// Functions of an image, their names mangled.
fn functions(processor: Processor, binary: &str) -> Vec<String> {
    let image = processor.image(binary);
    let image = object::File::parse(&*image).expect("cargo links ELF for this target");
    let functions = image.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text);
    functions.filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect()
}

/// What a panic has in its name: the handler, and `core`'s ways to it.
const PANICS: [&str; 5] = ["panic", "rust_begin_unwind", "_fail", "PanicInfo", "index_len"];

/// The functions of them.
fn panics(functions: &[String]) -> Vec<&String> {
    functions.iter().filter(|name| PANICS.iter().any(|part| name.contains(part))).collect()
}

#[test]
fn no_panic_can_be_reached_from_the_step() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            let functions = functions(processor, "step");
            assert!(functions.iter().any(|name| name == "main"), "{processor:?}: there is nothing in the image");
            assert_eq!(panics(&functions), Vec::<&String>::new(), "{processor:?}");
        }
    }
}

/// What is left of a panic in the control period, and why: a model that is started where the rod is has its valve's warmth set by
/// `Number::travel(0)` in `Drive::at_rest`, a conversion of a real number; the compiler does not see that it is one. No index, no
/// slice, no unwrapping, no overflow.
const LEFT: [&str; 3] = ["panic_fmt", "rust_begin_unwind", "PanicInfo"];

#[test]
fn the_control_period_has_one_panic_which_cannot_happen() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            let functions = functions(processor, "period");
            assert!(functions.iter().any(|name| name == "main"), "{processor:?}: there is nothing in the image");
            let others: Vec<&String> =
                panics(&functions).into_iter().filter(|name| !LEFT.iter().any(|left| name.contains(left))).collect();
            assert_eq!(others, Vec::<&String>::new(), "{processor:?}");
        }
    }
}

#[test]
fn a_panic_that_can_be_reached_would_show() {
    if Processor::M4F.can_be_built_for() {
        assert!(!panics(&functions(Processor::M4F, "parity")).is_empty(), "start-up code formats and unwraps");
    }
}
