//! The images whose only work is a step of the model: their flash, and that nothing in them can panic.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use system_tests::emulator::Processor;

/// Images whose only work is a step: of any drive, and of the paper's model by itself.
pub(crate) const IMAGES: [&str; 2] = ["step", "paper_step"];

/// Code and constants of an image, bytes; the processor's start-up, some 200, is part of it.
pub(crate) fn flash(processor: Processor, binary: &str) -> u64 {
    let image = processor.image(binary);
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
            for binary in IMAGES {
                let functions = functions(processor, binary);
                assert!(functions.iter().any(|name| name == "main"), "{processor:?}: there is nothing in {binary}");
                assert_eq!(panics(&functions), Vec::<&String>::new(), "{processor:?}: {binary}");
            }
        }
    }
}

#[test]
fn a_panic_that_can_be_reached_would_show() {
    if Processor::M4F.can_be_built_for() {
        assert!(!panics(&functions(Processor::M4F, "parity")).is_empty(), "start-up code formats and unwraps");
    }
}
