//! Short sequences with totals known from Arm's manuals, most of them their own examples: is the path of a tick weighed as they say?

#![expect(clippy::float_cmp, reason = "halves of cycles and their sums are exact")]

use system_tests::cycles::Reading;
use system_tests::cycles::decoded::{Code, Instruction};
use system_tests::cycles::path;
use system_tests::cycles::timing::{Class, TABLE, row};
use system_tests::emulator::Processor;

/// Where a sequence stands.
const START: u32 = 0x1000;

/// An instruction by its text, which the decoder must give back, and its code.
type Coded = (&'static str, &'static [u16]);

const LDR_R0_R1: Coded = ("ldr r0, [r1]", &[0x6808]);
const LDR_R1_R2: Coded = ("ldr r1, [r2]", &[0x6811]);
const LDR_INDEXED: Coded = ("ldr r0, [r1, r2]", &[0x5888]);
const STR_R0: Coded = ("str r0, [r3, #0x14]", &[0x6158]);
const STR_INDEXED: Coded = ("str r1, [r3, r2]", &[0x5099]);
const ADDS_R1: Coded = ("adds r1, r1, r2", &[0x1889]);
const SMULL: Coded = ("smull r0, r1, r2, r3", &[0xfb82, 0x0103]);
const SMLAL: Coded = ("smlal r0, r1, r2, r3", &[0xfbc2, 0x0103]);
const UDIV: Coded = ("udiv r0, r1, r2", &[0xfbb1, 0xf0f2]);
const VADD_S0: Coded = ("vadd.f32 s0, s1, s2", &[0xee30, 0x0a81]);
const VMUL_OF_S0: Coded = ("vmul.f32 s3, s0, s1", &[0xee60, 0x1a20]);
const VFMA_TO_S0: Coded = ("vfma.f32 s0, s1, s2", &[0xeea0, 0x0a81]);
const VDIV_S0: Coded = ("vdiv.f32 s0, s1, s2", &[0xee80, 0x0a81]);
const VLDR: Coded = ("vldr s0, [r0]", &[0xed90, 0x0a00]);

fn decoded(sequence: &[Coded]) -> Vec<Instruction> {
    let bytes = sequence.iter().flat_map(|(_, code)| code.iter().flat_map(|half| half.to_le_bytes())).collect();
    let mut code = Code::of(START, bytes).unwrap();
    let mut address = START;
    let one = |&(text, _): &Coded| {
        let instruction = code.at(address).unwrap().clone();
        assert_eq!(instruction.text, text);
        address += instruction.size;
        instruction
    };
    sequence.iter().map(one).collect()
}

/// Cycles of a sequence in the three readings; `back` is where it goes on, counted from its start, `None` behind its end.
fn cycles(processor: Processor, sequence: &[Coded], back: Option<u32>) -> [f64; 3] {
    let instructions = decoded(sequence);
    let path: Vec<&Instruction> = instructions.iter().collect();
    let end = instructions.last().map_or(START, |last| last.address + last.size);
    let cost = path::cost(processor, &path, back.map_or(end, |back| START + back));
    assert_eq!(cost.instructions, sequence.len() as f64);
    cost.cycles
}

/// On both processors, straight on.
fn on_both(sequence: &[Coded]) -> [f64; 3] {
    let [one, other] = Processor::ALL.map(|processor| cycles(processor, sequence, None));
    assert_eq!(one, other);
    one
}

fn on_m4f(sequence: &[Coded]) -> [f64; 3] {
    cycles(Processor::M4F, sequence, None)
}

#[test]
fn neighbouring_loads_and_stores_take_what_the_manuals_examples_say() {
    // Section 3.3.2: "normally three cycles total", three times, and "normally four".
    assert_eq!(on_both(&[LDR_R0_R1, ("ldr r2, [r3, #4]", &[0x685a])]), [3.0, 3.0, 4.0]);
    assert_eq!(on_both(&[LDR_R0_R1, LDR_R1_R2]), [3.0, 3.0, 4.0]);
    assert_eq!(on_both(&[LDR_INDEXED, STR_R0]), [3.0, 3.0, 4.0]);
    assert_eq!(on_both(&[LDR_INDEXED, STR_INDEXED]), [3.0, 3.0, 4.0]);
    let three = [("ldr r0, [r1, r5]", &[0x5948][..]), LDR_R1_R2, ("ldr r2, [r3, #4]", &[0x685a])];
    assert_eq!(on_both(&three), [4.0, 4.0, 6.0]);
}

#[test]
fn a_load_or_store_by_itself_takes_two_cycles_and_a_buffered_store_one() {
    assert_eq!(on_both(&[LDR_R0_R1]), [2.0, 2.0, 2.0]);
    assert_eq!(on_both(&[STR_R0]), [1.0, 1.0, 2.0]);
    assert_eq!(on_both(&[STR_INDEXED]), [1.0, 2.0, 2.0]);
    // "Nothing can be pipelined after the store."
    assert_eq!(on_both(&[STR_R0, LDR_R0_R1]), [3.0, 3.0, 4.0]);
}

#[test]
fn a_load_whose_address_is_loaded_before_it_is_not_pipelined() {
    assert_eq!(on_both(&[LDR_R1_R2, LDR_R0_R1]), [4.0, 4.0, 4.0]);
}

#[test]
fn a_load_that_updates_its_base_is_not_pipelined() {
    assert_eq!(on_both(&[LDR_R0_R1, ("ldr r0, [r1, #4]!", &[0xf851, 0x0f04])]), [4.0, 4.0, 4.0]);
}

#[test]
fn an_address_that_was_computed_in_the_cycle_before_stalls_a_cycle() {
    assert_eq!(on_both(&[ADDS_R1, LDR_R0_R1]), [4.0, 4.0, 4.0]);
    // A cycle later it does not.
    assert_eq!(on_both(&[ADDS_R1, ("mov.w r8, sb", &[0xea4f, 0x0809]), LDR_R0_R1]), [4.0, 4.0, 4.0]);
    assert_eq!(on_both(&[ADDS_R1, LDR_R1_R2]), [3.0, 3.0, 3.0]);
}

#[test]
fn lists_take_a_cycle_and_one_for_each_word() {
    assert_eq!(on_both(&[("ldm r0!, {r1, r2, r3}", &[0xc80e])]), [4.0; 3]);
    assert_eq!(on_both(&[("stm r0!, {r1, r2, r3, r4, r5, r6, r7}", &[0xc0fe])]), [8.0; 3]);
    assert_eq!(on_both(&[("ldrd r0, r1, [r2]", &[0xe9d2, 0x0100])]), [3.0; 3]);
    assert_eq!(on_both(&[("strd r0, r1, [sp, #8]", &[0xe9cd, 0x0102])]), [3.0; 3]);
    assert_eq!(on_both(&[("push {r4, r5, lr}", &[0xb530])]), [4.0; 3]);
    assert_eq!(on_m4f(&[("vpush {d8, d9}", &[0xed2d, 0x8b04])]), [5.0; 3]);
}

#[test]
fn a_jump_refills_the_pipeline_and_a_branch_that_is_not_taken_does_not() {
    let beq: Coded = ("beq #0x1004", &[0xd000]);
    let pop: Coded = ("pop {r4, pc}", &[0xbd10]);
    for processor in Processor::ALL {
        assert_eq!(cycles(processor, &[beq], None), [1.0; 3]);
        assert_eq!(cycles(processor, &[beq], Some(4)), [2.0, 3.0, 4.0]);
        assert_eq!(cycles(processor, &[pop], Some(100)), [4.0, 5.0, 6.0]);
        assert_eq!(cycles(processor, &[("ldr.w pc, [r0, r1]", &[0xf850, 0xf001])], Some(100)), [3.0, 5.0, 5.0]);
        assert_eq!(cycles(processor, &[("tbb [pc, r0]", &[0xe8df, 0xf000])], Some(100)), [3.0, 5.0, 6.0]);
    }
}

#[test]
fn long_products_take_one_cycle_on_the_m4f_and_several_on_the_m3() {
    assert_eq!(on_m4f(&[SMULL, SMLAL]), [2.0; 3]);
    assert_eq!(cycles(Processor::M3, &[SMULL, SMLAL], None), [7.0, 9.5, 12.0]);
    let mla: Coded = ("mla r0, r1, r2, r3", &[0xfb01, 0x3002]);
    assert_eq!(on_m4f(&[mla]), [1.0; 3]);
    assert_eq!(cycles(Processor::M3, &[mla], None), [2.0; 3]);
    assert_eq!(on_m4f(&[("smmul r0, r1, r2", &[0xfb51, 0xf002])]), [1.0; 3]);
    assert_eq!(on_both(&[UDIV]), [2.0, 7.0, 12.0]);
}

#[test]
#[should_panic(expected = "a Cortex-M3 has no VADD")]
fn an_instruction_that_a_processor_does_not_have_is_an_error() {
    let _ = cycles(Processor::M3, &[VADD_S0], None);
}

#[test]
fn an_instruction_without_a_row_is_an_error_with_its_text() {
    let mut code = Code::of(START, vec![0x00, 0xdf]).unwrap();
    let error = code.at(START).unwrap_err();
    assert_eq!(error.to_string(), "at 0x1000 is `svc #0`, which has no row in the timing table");
    assert_eq!(code.at(START + 2).unwrap_err().to_string(), "at 0x1002 is no instruction");
}

#[test]
fn if_then_is_folded_in_the_low_reading_behind_a_short_instruction() {
    let it: [Coded; 2] = [("it eq", &[0xbf08]), ("mov r0, r1", &[0x4608])];
    assert_eq!(on_both(&[ADDS_R1, it[0], it[1]]), [2.0, 3.0, 3.0]);
    assert_eq!(on_both(&[("mov.w r8, sb", &[0xea4f, 0x0809]), it[0], it[1]]), [3.0, 3.0, 3.0]);
}

#[test]
fn a_literal_may_wait_for_the_fetch() {
    assert_eq!(on_both(&[("ldr r0, [pc, #4]", &[0x4801])]), [2.0, 2.0, 3.0]);
}

#[test]
fn a_result_of_the_fpu_is_a_cycle_late_but_not_as_the_sum_of_a_product() {
    assert_eq!(on_m4f(&[VADD_S0, VMUL_OF_S0]), [3.0; 3]);
    assert_eq!(on_m4f(&[VADD_S0, ADDS_R1, VMUL_OF_S0]), [3.0; 3]);
    assert_eq!(on_m4f(&[VADD_S0, VFMA_TO_S0]), [4.0; 3]);
    assert_eq!(on_m4f(&[VFMA_TO_S0, VMUL_OF_S0]), [5.0; 3]);
    assert_eq!(
        on_m4f(&[("vcmp.f32 s0, s1", &[0xeeb4, 0x0a60]), ("vmrs apsr_nzcv, fpscr", &[0xeef1, 0xfa10])]),
        [3.0; 3]
    );
}

#[test]
fn a_quotient_goes_on_beneath_instructions_of_the_core() {
    // By itself one cycle, "if no more floating-point instructions are executed"; high: all of its 14.
    assert_eq!(on_m4f(&[VDIV_S0]), [1.0, 1.0, 14.0]);
    // The next one of the FPU waits: 14, then its own and that of the result.
    assert_eq!(on_m4f(&[VDIV_S0, VMUL_OF_S0]), [16.0; 3]);
    // Ten beneath it: 1 + 10 + 3 waited + 1.
    let mut sequence = vec![VDIV_S0];
    sequence.extend([ADDS_R1; 10]);
    sequence.push(VMUL_OF_S0);
    assert_eq!(on_m4f(&sequence), [15.0, 15.0, 25.0]);
    // Fourteen hide it.
    sequence.splice(1..1, [ADDS_R1; 4]);
    assert_eq!(on_m4f(&sequence), [16.0, 16.0, 29.0]);
}

#[test]
fn moves_loads_and_stores_of_the_fpu_take_what_its_table_says() {
    assert_eq!(on_m4f(&[("vmov.f32 s0, s1", &[0xeeb0, 0x0a60])]), [1.0; 3]);
    assert_eq!(on_m4f(&[("vmov.f32 s22, #1.000000e+00", &[0xeeb7, 0xba00])]), [1.0; 3]);
    assert_eq!(on_m4f(&[("vmov r0, s0", &[0xee10, 0x0a10])]), [1.0, 2.0, 2.0]);
    assert_eq!(on_m4f(&[VLDR]), [2.0; 3]);
    assert_eq!(on_m4f(&[VLDR, ("vldr d1, [r0]", &[0xed90, 0x1b00])]), [4.0, 5.0, 5.0]);
    assert_eq!(on_m4f(&[("vstr s0, [r0]", &[0xed80, 0x0a00])]), [1.0, 2.0, 2.0]);
}

#[test]
fn every_kind_has_one_row_and_its_readings_are_in_order() {
    for entry in TABLE {
        assert_eq!(row(entry.class), &entry, "two rows of {:?}", entry.class);
        for cycles in [Some(entry.m4f), entry.m3].into_iter().flatten() {
            assert!(cycles.is_sorted(), "{}: {cycles:?}", entry.instructions);
        }
        // The M3 has what the M4F has besides its two extensions.
        assert_eq!(entry.m3.is_none(), entry.class.is_fp() || entry.class == Class::Dsp, "{}", entry.instructions);
    }
    assert_eq!(Reading::ALL.map(Reading::refill), [1.0, 2.0, 3.0]);
}
