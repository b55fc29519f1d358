//! The image whose only work is the model's step: its flash, and that nothing in it can panic.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use system_tests::emulator::Processor;

/// Code and constants of the step, bytes; the processor's start-up, some 200, is part of it.
pub(crate) fn flash(processor: Processor) -> u64 {
    let image = processor.image("step");
    let image = object::File::parse(&*image).expect("cargo links ELF for this target");
    [".text", ".rodata"].iter().filter_map(|name| image.section_by_name(name)).map(|section| section.size()).sum()
}

/// Functions of an image, their names mangled.
fn functions(processor: Processor, binary: &str) -> Vec<String> {
    let image = processor.image(binary);
    let image = object::File::parse(&*image).expect("cargo links ELF for this target");
    let functions = image.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text);
    functions.filter_map(|symbol| symbol.name().ok().map(str::to_owned)).collect()
}

/// What a panic brings with it: the handler, and `core`'s way to it.
fn panics(functions: &[String]) -> Vec<&String> {
    functions.iter().filter(|name| name.contains("panic") || name.contains("rust_begin_unwind")).collect()
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

#[test]
fn a_panic_that_can_be_reached_would_show() {
    if Processor::M4F.can_be_built_for() {
        assert!(!panics(&functions(Processor::M4F, "parity")).is_empty(), "start-up code formats and unwraps");
    }
}
