//! Which row of the timing table an instruction has.

use super::decoded::{PC, Parts};
use super::timing::Class;

/// The row of an instruction by its name without condition and width; `None` where the table has none.
#[expect(clippy::match_same_arms, reason = "in the order of the timing table, guards where a name is not enough")]
pub(super) fn classify(name: &str, mnemonic: &str, parts: &Parts) -> Option<Class> {
    let is_list_with_pc = parts.behind(0) & PC != 0;
    Some(match name {
        "adc" | "add" | "addw" | "adr" | "and" | "asr" | "bfc" | "bfi" | "bic" | "clz" | "cmn" | "cmp" | "eor"
        | "lsl" | "lsr" | "mov" | "movs" | "movt" | "movw" | "mul" | "mvn" | "neg" | "orn" | "orr" | "rbit" | "rev"
        | "rev16" | "revsh" | "ror" | "rrx" | "rsb" | "sbc" | "sbfx" | "ssat" | "sub" | "subw" | "sxtb" | "sxth"
        | "teq" | "tst" | "ubfx" | "usat" | "uxtb" | "uxth" => Class::Plain,
        "hint" if mnemonic.starts_with("nop") => Class::Plain,
        "mla" | "mls" => Class::Accumulate,
        "smull" | "umull" => Class::LongProduct,
        "smlal" | "umlal" => Class::LongAccumulate,
        "sdiv" | "udiv" => Class::Divide,
        "it" => Class::IfThen,
        "mrs" | "msr" => Class::Special,
        "b" | "bl" | "bx" | "blx" | "cbz" | "cbnz" => Class::Branch,
        "tbb" | "tbh" => Class::TableBranch,
        "ldr" if parts.first(1) == PC => Class::LoadPc,
        "ldr" | "ldrb" | "ldrh" | "ldrsb" | "ldrsh" => Class::Load,
        "str" | "strb" | "strh" if parts.index != 0 => Class::StoreIndexed,
        "str" | "strb" | "strh" => Class::Store,
        "ldm" | "ldmdb" | "pop" if is_list_with_pc => Class::MultiplePc,
        "ldrd" | "strd" | "ldm" | "ldmdb" | "stm" | "stmdb" | "push" | "pop" => Class::Multiple,
        "vldmia" | "vldmdb" | "vstmia" | "vstmdb" | "vpush" | "vpop" => Class::Multiple,
        "vadd" | "vsub" | "vmul" | "vnmul" | "vabs" | "vneg" | "vcvt" | "vcvtr" | "vcvtb" | "vcvtt" => {
            Class::FpArithmetic
        }
        "vcmp" | "vcmpe" => Class::FpCompare,
        "vmla" | "vmls" | "vnmla" | "vnmls" | "vfma" | "vfms" | "vfnma" | "vfnms" => Class::FpAccumulate,
        "vdiv" | "vsqrt" => Class::FpDivide,
        "vmrs" | "vmsr" | "fmstat" => Class::FpMove,
        // With `.32` it is half of a double.
        "vmov" if (parts.is_core(0) || parts.is_core(1)) && !mnemonic.ends_with(".32") => Class::FpTransfer,
        // The decoder calls a constant that is moved so.
        "vmov" | "fconsts" => Class::FpMove,
        "vldr" => Class::FpLoad,
        "vstr" => Class::FpStore,
        _ if is_dsp(name) => Class::Dsp,
        _ => return None,
    })
}

/// Whether an instruction is one of table 3-2.
fn is_dsp(name: &str) -> bool {
    let products = ["smmul", "smmla", "smmls", "smla", "smul", "smls", "smua", "smus", "umaal"];
    let sums = [
        "qadd", "qsub", "qdadd", "qdsub", "sel", "usad", "ssat16", "usat16", "pkh", "sxta", "uxta", "sxtb16", "uxtb16",
    ];
    let parallel =
        ["sadd", "ssub", "shadd", "shsub", "uadd", "usub", "uhadd", "uhsub", "uqadd", "uqsub", "sasx", "ssax"];
    [&products[..], &sums, &parallel].into_iter().flatten().any(|start| name.starts_with(start))
}
