//! Weighs the path of a tick: each instruction by the table, and what its neighbours change.

use super::decoded::Instruction;
use super::timing::{ADDRESS, BENEATH, CONSUMED, Class, LITERAL, PIPELINED, Reading, row};
use crate::emulator::Processor;

/// What a tick costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Instructions.
    pub instructions: f64,
    /// Cycles by [`Reading`].
    pub cycles: [f64; 3],
}

impl Cost {
    /// Each figure with that of another.
    #[must_use]
    pub fn with(&self, other: &Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let mut cycles = self.cycles;
        for (one, other) in cycles.iter_mut().zip(other.cycles) {
            *one = of(*one, other);
        }
        Self { instructions: of(self.instructions, other.instructions), cycles }
    }
}

/// Cost of a path; `back` is the address at which it goes on.
#[must_use]
pub fn cost(processor: Processor, path: &[&Instruction], back: u32) -> Cost {
    let cycles = Reading::ALL.map(|reading| weigh(processor, reading, path, back).iter().sum());
    Cost { instructions: path.len() as f64, cycles }
}

/// Cycles of each instruction of a path in one reading.
#[must_use]
pub fn weigh(processor: Processor, reading: Reading, path: &[&Instruction], back: u32) -> Vec<f64> {
    let mut weighed = Vec::with_capacity(path.len());
    // Cycles since the start, and until when the FPU works on a quotient or a root.
    let (mut now, mut busy) = (0.0, 0.0_f64);
    let mut before: Option<&Instruction> = None;
    for (place, instruction) in path.iter().enumerate() {
        let next = path.get(place + 1).map_or(back, |next| next.address);
        let row = row(instruction.class);
        let mut cycles = row.cycles(processor, reading, instruction.words);
        if next != instruction.address + instruction.size && row.refills() {
            cycles += reading.refill();
        }
        if instruction.is_literal {
            cycles += reading.of(LITERAL);
        }
        if let Some(before) = before {
            cycles += beside(reading, before, instruction);
        }
        if instruction.class.is_fp() && reading != Reading::High {
            cycles += (busy - now).max(0.0);
        }
        now += cycles;
        if instruction.class == Class::FpDivide && reading != Reading::High {
            busy = now + BENEATH;
        }
        weighed.push(cycles);
        before = Some(instruction);
    }
    weighed
}

/// Cycles that an instruction takes more, or less, behind another.
fn beside(reading: Reading, before: &Instruction, instruction: &Instruction) -> f64 {
    let mut cycles = 0.0;
    let is_addressed_by_it = instruction.address_from & before.writes != 0;
    if is_addressed_by_it && before.class.is_data_processing() {
        cycles += ADDRESS;
    }
    if before.class.is_single_load() && !is_addressed_by_it && can_be_pipelined(reading, before, instruction) {
        cycles += reading.of(PIPELINED);
    }
    if instruction.class == Class::IfThen && reading == Reading::Low && before.size == 2 {
        // Folded onto the instruction before it.
        cycles -= 1.0;
    }
    let is_consumed = before.class.is_fp_arithmetic() && instruction.consumes & before.writes != 0;
    if is_consumed && instruction.class.is_fp() {
        cycles += CONSUMED;
    }
    cycles
}

/// Whether a load or store of one register can be pipelined behind a load: of the core, and in the low reading also of the FPU. A store at a
/// constant distance takes one cycle anyway; a load that updates its base is "not normally pipelined".
fn can_be_pipelined(reading: Reading, before: &Instruction, instruction: &Instruction) -> bool {
    let is_first_of_core = before.class == Class::Load || reading == Reading::Low;
    let is_second = match instruction.class {
        Class::Load => !instruction.updates_base,
        // In the low reading a store is one cycle already.
        Class::StoreIndexed => reading == Reading::Nominal,
        Class::FpLoad => reading == Reading::Low,
        _ => false,
    };
    is_first_of_core && is_second
}
