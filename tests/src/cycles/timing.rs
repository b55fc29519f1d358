//! The timing table: what each kind of instruction takes by Arm's technical reference manuals.
//!
//! M4: *Cortex-M4 Technical Reference Manual*, DDI 0439D (r0p1), table 3-1, table 3-2 (DSP), section 3.3.2 (loads and stores), table 7-1 with its
//! notes (FPU). M3: *Cortex-M3 Technical Reference Manual*, `100165_0201_02` (r2p1), the later edition of DDI 0337I, table 3-1 and section 3.3.2.
//! Both are for memory without wait states.
//!
//! A figure that the manuals leave open has three readings ([`Reading`]). P, the refill of the pipeline after a jump, is 1, 2 and 3: "1 to 3
//! depending on the alignment and width of the target instruction, and whether the processor manages to speculate the address early".

use crate::emulator::Processor;

/// How what the manuals leave open is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// The fewest cycles that the manuals allow.
    Low,
    /// In between, or what they call normal.
    Nominal,
    /// The most cycles: nothing is paired.
    High,
}

impl Reading {
    /// All, from few cycles to many.
    pub const ALL: [Self; 3] = [Self::Low, Self::Nominal, Self::High];

    /// One of three values.
    #[must_use]
    pub const fn of(self, values: [f64; 3]) -> f64 {
        values[self as usize]
    }

    /// P, the refill of the pipeline.
    #[must_use]
    pub const fn refill(self) -> f64 {
        self.of([1.0, 2.0, 3.0])
    }
}

/// Kinds of instructions with a timing of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Data processing, also into the program counter.
    Plain,
    /// `MLA`, `MLS`.
    Accumulate,
    /// `SMULL`, `UMULL`.
    LongProduct,
    /// `SMLAL`, `UMLAL`.
    LongAccumulate,
    /// Products of the DSP extension.
    Dsp,
    /// `SDIV`, `UDIV`.
    Divide,
    /// `IT`.
    IfThen,
    /// `MRS`, `MSR`.
    Special,
    /// Branches.
    Branch,
    /// `TBB`, `TBH`.
    TableBranch,
    /// Load of one register.
    Load,
    /// Load of the program counter.
    LoadPc,
    /// Store of one register at a constant distance.
    Store,
    /// Store of one register at a distance in a register.
    StoreIndexed,
    /// Load or store of several registers.
    Multiple,
    /// The same with the program counter.
    MultiplePc,
    /// Addition, product, conversion of the FPU.
    FpArithmetic,
    /// `VCMP`.
    FpCompare,
    /// Product with a sum of the FPU.
    FpAccumulate,
    /// `VDIV`, `VSQRT`.
    FpDivide,
    /// Moves within the FPU, of half a double, and of its status.
    FpMove,
    /// Moves between the FPU's registers and those of the core.
    FpTransfer,
    /// `VLDR`.
    FpLoad,
    /// `VSTR`.
    FpStore,
}

impl Class {
    /// Whether it writes its result in its last cycle, so that the next address must wait for it.
    #[must_use]
    pub const fn is_data_processing(self) -> bool {
        use Class::{Accumulate, Divide, Dsp, LongAccumulate, LongProduct, Plain};
        matches!(self, Plain | Accumulate | LongProduct | LongAccumulate | Dsp | Divide)
    }

    /// Whether it is a load of one register, behind which a load or store can be pipelined.
    #[must_use]
    pub const fn is_single_load(self) -> bool {
        matches!(self, Class::Load | Class::FpLoad)
    }

    /// Whether its result is a cycle late for the next instruction of the FPU.
    #[must_use]
    pub const fn is_fp_arithmetic(self) -> bool {
        matches!(self, Class::FpArithmetic | Class::FpCompare | Class::FpAccumulate | Class::FpDivide)
    }

    /// Whether the FPU executes it.
    #[must_use]
    pub const fn is_fp(self) -> bool {
        use Class::{FpLoad, FpMove, FpStore, FpTransfer};
        self.is_fp_arithmetic() || matches!(self, FpMove | FpTransfer | FpLoad | FpStore)
    }
}

/// A row of the timing table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Which instructions.
    pub class: Class,
    /// Their names.
    pub instructions: &'static str,
    /// Cycles on the M4F by reading, without what is added below.
    pub m4f: [f64; 3],
    /// The same on the M3; it has no DSP extension and no FPU.
    pub m3: Option<[f64; 3]>,
    /// Added for each word of the list.
    pub word: f64,
    /// Where it says so; what is read from it.
    pub source: &'static str,
}

/// A row where both processors are alike.
const fn both(class: Class, instructions: &'static str, cycles: [f64; 3], source: &'static str) -> Row {
    Row { class, instructions, m4f: cycles, m3: Some(cycles), word: 0.0, source }
}

/// A row of what the M4F alone has.
const fn m4f(class: Class, instructions: &'static str, cycles: [f64; 3], source: &'static str) -> Row {
    Row { class, instructions, m4f: cycles, m3: None, word: 0.0, source }
}

/// A row of a list.
const fn list(mut row: Row) -> Row {
    row.word = 1.0;
    row
}

/// The table. P is added to each row where it jumps, but to those that say so.
pub const TABLE: [Row; 24] = [
    both(
        Class::Plain,
        "data processing, MUL, shifts, CLZ, SSAT, bit fields, NOP",
        [1.0; 3],
        "table 3-1: 1; 1 + P into PC",
    ),
    Row {
        class: Class::Accumulate,
        instructions: "MLA, MLS",
        m4f: [1.0; 3],
        m3: Some([2.0; 3]),
        word: 0.0,
        source: "table 3-1: M4 1, M3 2",
    },
    Row {
        class: Class::LongProduct,
        instructions: "SMULL, UMULL",
        m4f: [1.0; 3],
        m3: Some([3.0, 4.0, 5.0]),
        word: 0.0,
        source: "table 3-1: M4 1, M3 3 to 5 by the values, which a trace does not show",
    },
    Row {
        class: Class::LongAccumulate,
        instructions: "SMLAL, UMLAL",
        m4f: [1.0; 3],
        m3: Some([4.0, 5.5, 7.0]),
        word: 0.0,
        source: "table 3-1: M4 1, M3 4 to 7 by the values",
    },
    m4f(Class::Dsp, "SMMUL, SMMLA, UMAAL, SMLAxy and all of the DSP extension", [1.0; 3], "table 3-2: 1"),
    both(Class::Divide, "SDIV, UDIV", [2.0, 7.0, 12.0], "table 3-1: 2 to 12 by the values"),
    both(Class::IfThen, "IT", [1.0; 3], "table 3-1: 1; low: 0 behind an instruction of 16 bits, note d"),
    both(Class::Special, "MRS, MSR", [1.0, 1.5, 2.0], "table 3-1: 1 or 2"),
    both(Class::Branch, "B, BL, BX, BLX, CBZ, CBNZ", [1.0; 3], "table 3-1: 1, taken 1 + P"),
    both(Class::TableBranch, "TBB, TBH", [3.0, 5.0, 6.0], "table 3-1: 2 + P; section 3.3.2: at least 6; P is in it"),
    both(Class::Load, "LDR, LDRB, LDRH, LDRSB, LDRSH", [2.0; 3], "table 3-1: 2; 1 behind another load, section 3.3.2"),
    both(Class::LoadPc, "LDR PC", [3.0, 5.0, 5.0], "table 3-1: 2 + P; section 3.3.2: at least 5; P is in it"),
    both(
        Class::Store,
        "STR, STRB, STRH at a constant distance",
        [1.0, 1.0, 2.0],
        "section 3.3.2: always 1; table 3-1: 2",
    ),
    both(
        Class::StoreIndexed,
        "STR at a distance in a register",
        [1.0, 2.0, 2.0],
        "table 3-1: 2; 1 behind a load, section 3.3.2",
    ),
    list(both(
        Class::Multiple,
        "LDRD, STRD, LDM, STM, PUSH, POP, VLDM, VSTM, VPUSH, VPOP",
        [1.0; 3],
        "tables 3-1, 7-1: 1 + N words",
    )),
    list(both(Class::MultiplePc, "LDM, POP with PC", [1.0; 3], "table 3-1: 1 + N + P")),
    m4f(Class::FpArithmetic, "VADD, VSUB, VMUL, VNMUL, VABS, VNEG, VCVT", [1.0; 3], "table 7-1: 1"),
    m4f(Class::FpCompare, "VCMP, VCMPE", [1.0; 3], "table 7-1: 1"),
    m4f(Class::FpAccumulate, "VMLA, VMLS, VFMA, VFMS, VFNMA, VFNMS, VNMLA, VNMLS", [3.0; 3], "table 7-1: 3"),
    m4f(
        Class::FpDivide,
        "VDIV, VSQRT",
        [1.0, 1.0, 14.0],
        "table 7-1: 14; its notes: 1 where no instruction of the FPU follows within 13",
    ),
    m4f(Class::FpMove, "VMOV within the FPU, of a constant and of half a double, VMRS, VMSR", [1.0; 3], "table 7-1: 1"),
    m4f(
        Class::FpTransfer,
        "VMOV between FPU and core",
        [1.0, 2.0, 2.0],
        "table 7-1: 2; low: 1 for one word, as of half a double",
    ),
    list(m4f(Class::FpLoad, "VLDR", [1.0; 3], "table 7-1: 2, double 3; low: pipelined as LDR is")),
    list(m4f(Class::FpStore, "VSTR", [0.0, 1.0, 1.0], "table 7-1: 2, double 3; low: written as STR is")),
];

/// A load or store of which the address comes from the instruction before it: "stalls the pipeline for an additional cycle", section 3.3.2.
pub const ADDRESS: f64 = 1.0;
/// A load or store of one register behind a load of one register, section 3.3.2: "one cycle is removed". High: not pipelined (note b).
pub const PIPELINED: [f64; 3] = [-1.0, -1.0, 0.0];
/// `LDR Rx, [PC, #imm]` "might add a cycle because of contention with the fetch unit", section 3.3.2.
pub const LITERAL: [f64; 3] = [0.0, 0.0, 1.0];
/// Instructions of the FPU "take one cycle longer if their result is consumed by the following instruction"; but not as the sum of a product
/// with a sum, table 7-1.
pub const CONSUMED: f64 = 1.0;
/// Cycles for which the FPU goes on with a quotient or a root beneath other instructions, table 7-1.
pub const BENEATH: f64 = 13.0;

/// The row of a kind.
#[must_use]
pub fn row(class: Class) -> &'static Row {
    TABLE.iter().find(|row| row.class == class).unwrap_or(&TABLE[0])
}

impl Row {
    /// Cycles of it with a list of so many words, without what neighbours change.
    ///
    /// # Panics
    /// The processor does not have it.
    #[must_use]
    pub fn cycles(&self, processor: Processor, reading: Reading, words: u32) -> f64 {
        let cycles = match processor {
            Processor::M4F => Some(self.m4f),
            Processor::M3 => self.m3,
        };
        let cycles = cycles.unwrap_or_else(|| panic!("a {} has no {}", processor.name(), self.instructions));
        reading.of(cycles) + self.word * f64::from(words)
    }

    /// The row as in the book: cycles low / nominal / high, or one figure where they are alike.
    #[must_use]
    pub fn line(&self) -> String {
        let readings = |cycles: Option<[f64; 3]>| match cycles {
            None => "–".to_owned(),
            Some([low, nominal, high]) => {
                let words = if self.word > 0.0 { " + N" } else { "" };
                let alike = low.total_cmp(&high).is_eq();
                if alike { format!("{low}{words}") } else { format!("{low} / {nominal} / {high}{words}") }
            }
        };
        format!("| {} | {} | {} | {} |", self.instructions, readings(Some(self.m4f)), readings(self.m3), self.source)
    }

    /// Whether a jump adds a refill.
    #[must_use]
    pub const fn refills(&self) -> bool {
        !matches!(self.class, Class::TableBranch | Class::LoadPc)
    }
}
