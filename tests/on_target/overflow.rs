//! Is a stack that overflows caught before it overwrites anything?

use system_tests::emulator::Processor;

#[test]
fn a_stack_that_overflows_is_a_fault_and_overwrites_nothing() {
    for processor in Processor::ALL {
        if !processor.can_be_emulated() {
            return;
        }
        let said = processor.run("overflow");
        println!("{processor:?}: {said}");
        let depth =
            said.strip_prefix("overflow caught after ").and_then(|rest| rest.split(' ').next()?.parse::<u32>().ok());
        // 128 KiB of stack in calls of 256 bytes and a little more.
        assert!(depth.is_some_and(|depth| (400..512).contains(&depth)), "{said}");
        assert!(said.trim_end().ends_with("by the guard: true, memory whole: true"), "{said}");
    }
}
