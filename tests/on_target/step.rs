//! Images whose only work is the model's step, or a whole period: the step's flash, and that nothing in them can panic.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use system_tests::emulator::Processor;

/// Code and constants of the step, bytes; the processor's start-up, some 200, is part of it.
pub(crate) fn flash(processor: Processor) -> u64 {
    size(processor, "step")
}

fn size(processor: Processor, binary: &str) -> u64 {
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
            let functions = functions(processor, "step");
            assert!(functions.iter().any(|name| name == "main"), "{processor:?}: there is nothing in the image");
            assert_eq!(panics(&functions), Vec::<&String>::new(), "{processor:?}");
        }
    }
}

/// Arithmetic in floating point, of a processor without it.
fn floats(functions: &[String]) -> Vec<&String> {
    let double = ["__aeabi_d", "__adddf3", "__subdf3", "__muldf3", "__divdf3"];
    functions.iter().filter(|name| double.iter().any(|start| name.starts_with(start))).collect()
}

#[test]
fn no_panic_and_no_double_can_be_reached_from_a_whole_period_not_even_where_following_begins() {
    for processor in Processor::ALL {
        if processor.can_be_built_for() {
            let functions = functions(processor, "period");
            assert!(
                size(processor, "period") > flash(processor),
                "{processor:?}: there is no more than the model in it"
            );
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
