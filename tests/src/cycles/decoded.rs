//! The instructions of an image, as far as their timing asks: kind, registers, length.
//!
//! Decoded by capstone, which knows Thumb-2 with the FPU and needs no program beside cargo. An instruction that the timing table has no row for
//! is an error, not a guess.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use capstone::Capstone;
use capstone::arch::arm::{ArchExtraMode, ArchMode, ArmInsnDetail, ArmOperandType};
use capstone::arch::{BuildsCapstone, BuildsCapstoneExtraMode, DetailsArchInsn};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use super::classes::classify;
use super::timing::Class;

/// Registers as bits: r0 to r15, then s0 to s31, then the FPU's flags.
pub type Registers = u64;

/// Place of the FPU's flags among the registers.
const FLAGS: u32 = 48;

/// An instruction.
#[derive(Clone, Debug, PartialEq)]
pub struct Instruction {
    /// Where it stands.
    pub address: u32,
    /// Its length, bytes.
    pub size: u32,
    /// Its text, for messages.
    pub text: String,
    /// Its row in the timing table.
    pub class: Class,
    /// Words of its list.
    pub words: u32,
    /// Registers that get a result of it.
    pub writes: Registers,
    /// Registers that its address comes from.
    pub address_from: Registers,
    /// Registers of the FPU that it needs as it starts.
    pub consumes: Registers,
    /// Whether it changes the register that its address comes from.
    pub updates_base: bool,
    /// Whether it loads from beside the program counter.
    pub is_literal: bool,
}

/// Why an image cannot be counted.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// It cannot be read.
    #[error("{file}: {error}")]
    File {
        /// Which file.
        file: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// It is not an ELF file.
    #[error("{file}: {error}")]
    Elf {
        /// Which file.
        file: PathBuf,
        /// Why.
        error: object::Error,
    },
    /// The decoder does not work.
    #[error("the decoder: {0}")]
    Decoder(capstone::Error),
    /// No function, or several, are called so.
    #[error("no function is {name}, or several end so: {found:?}; expected its path without the hash")]
    Name {
        /// What was asked for.
        name: String,
        /// What could be meant.
        found: Vec<String>,
    },
    /// There is no instruction.
    #[error("at {0:#x} is no instruction")]
    Nothing(u32),
    /// The timing table does not know it.
    #[error("at {address:#x} is `{text}`, which has no row in the timing table")]
    Unknown {
        /// Where.
        address: u32,
        /// The instruction.
        text: String,
    },
}

/// A function of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name, without the hash.
    pub name: String,
    /// Address of its first instruction.
    pub address: u32,
    /// Its length, bytes.
    pub size: u32,
}

impl Function {
    /// Whether an address is in it.
    #[must_use]
    pub fn holds(&self, address: u32) -> bool {
        (self.address..self.address + self.size).contains(&address)
    }
}

/// The code of an image.
pub struct Code {
    decoder: Capstone,
    sections: Vec<(u32, Vec<u8>)>,
    functions: Vec<Function>,
    known: HashMap<u32, Instruction>,
}

impl std::fmt::Debug for Code {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "Code({} functions)", self.functions.len())
    }
}

impl Code {
    /// Of these bytes at an address, without functions.
    ///
    /// # Errors
    /// The decoder does not work.
    pub fn of(address: u32, bytes: Vec<u8>) -> Result<Self, DecodeError> {
        let modes = [ArchExtraMode::MClass];
        let decoder = Capstone::new().arm().mode(ArchMode::Thumb).extra_mode(modes.into_iter()).detail(true).build();
        let decoder = decoder.map_err(DecodeError::Decoder)?;
        Ok(Self { decoder, sections: vec![(address, bytes)], functions: Vec::new(), known: HashMap::new() })
    }

    /// Of an image.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(file: &Path) -> Result<Self, DecodeError> {
        let image = std::fs::read(file).map_err(|error| DecodeError::File { file: file.to_owned(), error })?;
        let of_elf = |error| DecodeError::Elf { file: file.to_owned(), error };
        let image = object::File::parse(&*image).map_err(of_elf)?;
        let mut code = Self::of(0, Vec::new())?;
        code.sections.clear();
        for section in image.sections().filter(|section| section.kind() == SectionKind::Text) {
            code.sections.push((word(section.address()), section.data().map_err(of_elf)?.to_vec()));
        }
        for symbol in image.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0) {
            let name = format!("{:#}", rustc_demangle::demangle(symbol.name().map_err(of_elf)?));
            // The lowest bit says that it is Thumb code.
            code.functions.push(Function { name, address: word(symbol.address()) & !1, size: word(symbol.size()) });
        }
        Ok(code)
    }

    /// All functions.
    #[must_use]
    pub fn functions(&self) -> &[Function] {
        &self.functions
    }

    /// The function with this name, or with a name that ends so behind `::`; each instance of a generic one.
    ///
    /// # Errors
    /// There is none, or functions of different names end so.
    pub fn named(&self, name: &str) -> Result<Vec<Function>, DecodeError> {
        let end = format!("::{name}");
        let of = |is_it: &dyn Fn(&Function) -> bool| -> Vec<Function> {
            self.functions.iter().filter(|function| is_it(function)).cloned().collect()
        };
        let mut found = of(&|function| function.name == name);
        if found.is_empty() {
            found = of(&|function| function.name.ends_with(&end));
        }
        let names: BTreeSet<&str> = found.iter().map(|function| function.name.as_str()).collect();
        if names.len() == 1 {
            return Ok(found);
        }
        let found = names.into_iter().map(str::to_owned).collect();
        Err(DecodeError::Name { name: name.to_owned(), found })
    }

    /// The instruction at an address.
    ///
    /// # Errors
    /// There is none, or the timing table has no row for it.
    pub fn at(&mut self, address: u32) -> Result<&Instruction, DecodeError> {
        if !self.known.contains_key(&address) {
            let instruction = self.decoded(address)?;
            self.known.insert(address, instruction);
        }
        self.known.get(&address).ok_or(DecodeError::Nothing(address))
    }

    /// The instruction at an address, where it was decoded already.
    #[must_use]
    pub fn known(&self, address: u32) -> Option<&Instruction> {
        self.known.get(&address)
    }

    fn decoded(&self, address: u32) -> Result<Instruction, DecodeError> {
        let bytes = self.bytes(address).ok_or(DecodeError::Nothing(address))?;
        let one = self.decoder.disasm_count(bytes, u64::from(address), 1).map_err(DecodeError::Decoder)?;
        let found = one.iter().next().ok_or(DecodeError::Nothing(address))?;
        let text = format!("{} {}", found.mnemonic().unwrap_or(""), found.op_str().unwrap_or("")).trim_end().to_owned();
        let detail = self.decoder.insn_detail(found).map_err(DecodeError::Decoder)?;
        let name = self.decoder.insn_name(found.id()).unwrap_or_default();
        let detail = detail.arch_detail();
        let arm = detail.arm().ok_or(DecodeError::Nothing(address))?;
        let parts = self.parts(arm);
        let class = classify(&name, found.mnemonic().unwrap_or(""), &parts)
            .ok_or_else(|| DecodeError::Unknown { address, text: text.clone() })?;
        let size = u32::from(found.bytes().len() == 4) * 2 + 2;
        Ok(parts.instruction(
            &name,
            class,
            Instruction {
                address,
                size,
                text,
                class,
                words: 0,
                writes: 0,
                address_from: 0,
                consumes: 0,
                updates_base: arm.writeback(),
                is_literal: false,
            },
        ))
    }

    /// The bytes of the longest instruction from an address on.
    fn bytes(&self, address: u32) -> Option<&[u8]> {
        self.sections.iter().find_map(|(start, bytes)| {
            let from = usize::try_from(address.checked_sub(*start)?).ok()?;
            bytes.get(from..bytes.len().min(from + 4)).filter(|bytes| !bytes.is_empty())
        })
    }

    fn parts(&self, arm: &ArmInsnDetail) -> Parts {
        let mut parts = Parts::default();
        for operand in arm.operands() {
            match operand.op_type {
                ArmOperandType::Reg(register) => {
                    parts.registers.push(self.decoder.reg_name(register).as_deref().map_or(0, bits));
                }
                ArmOperandType::Mem(memory) => {
                    let of = |register| self.decoder.reg_name(register).as_deref().map_or(0, bits);
                    parts.is_memory = true;
                    parts.index = of(memory.index());
                    parts.address = of(memory.base()) | parts.index;
                }
                _ => {}
            }
        }
        parts
    }
}

/// An address of this target, which has 32 bits.
fn word(value: u64) -> u32 {
    u32::try_from(value).unwrap_or(u32::MAX)
}

/// The bits of a register by its name.
fn bits(name: &str) -> Registers {
    let numbered = |start: &str| name.strip_prefix(start).and_then(|number| number.parse::<u32>().ok());
    match name {
        "sb" => 1 << 9,
        "sl" => 1 << 10,
        "fp" => 1 << 11,
        "ip" => 1 << 12,
        "sp" => 1 << 13,
        "lr" => 1 << 14,
        "pc" => PC,
        "fpscr" => 1 << FLAGS,
        _ => match (numbered("r"), numbered("s"), numbered("d")) {
            (Some(number @ 0..16), ..) => 1 << number,
            (_, Some(number @ 0..32), _) => 1 << (16 + number),
            (.., Some(number @ 0..16)) => 3 << (16 + 2 * number),
            _ => 0,
        },
    }
}

pub(super) const PC: Registers = 1 << 15;
const CORE: Registers = 0xffff;

/// Operands of an instruction.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// Registers, in their order.
    registers: Vec<Registers>,
    is_memory: bool,
    /// Registers of its address.
    address: Registers,
    /// That of its distance.
    pub(super) index: Registers,
}

impl Parts {
    fn all(&self) -> Registers {
        self.registers.iter().fold(0, |all, register| all | register)
    }

    /// The first so many registers.
    pub(super) fn first(&self, count: usize) -> Registers {
        self.registers.iter().take(count).fold(0, |all, register| all | register)
    }

    /// All registers but the first so many.
    pub(super) fn behind(&self, count: usize) -> Registers {
        self.registers.iter().skip(count).fold(0, |all, register| all | register)
    }

    pub(super) fn is_core(&self, place: usize) -> bool {
        self.registers.get(place).is_some_and(|register| register & CORE != 0)
    }

    /// Words of its registers from one on: a double has two.
    fn words(&self, from: usize) -> u32 {
        self.behind(from).count_ones()
    }

    /// Fills in registers and words.
    fn instruction(&self, name: &str, class: Class, mut instruction: Instruction) -> Instruction {
        // A list has its base before it, but on the stack.
        let is_on_stack = matches!(name, "push" | "pop" | "vpush" | "vpop");
        instruction.address_from = self.address;
        match class {
            Class::Multiple | Class::MultiplePc if self.is_memory => {
                instruction.words = self.words(0);
                instruction.writes = if name.starts_with("ldr") { self.all() } else { 0 };
            }
            Class::Multiple | Class::MultiplePc => {
                let base = usize::from(!is_on_stack);
                instruction.words = self.words(base);
                instruction.address_from = if is_on_stack { bits("sp") } else { self.first(1) };
                let loads = name.starts_with("ld") || name.starts_with("vld") || name.ends_with("pop");
                instruction.writes = if loads { self.behind(base) } else { 0 };
            }
            Class::Store | Class::StoreIndexed | Class::Branch | Class::IfThen | Class::TableBranch => {}
            Class::LongProduct | Class::LongAccumulate => instruction.writes = self.first(2),
            Class::Dsp
                if matches!(name, "umaal" | "smlald" | "smlaldx" | "smlalbb" | "smlalbt" | "smlaltb" | "smlaltt") =>
            {
                instruction.writes = self.first(2);
            }
            Class::Plain if matches!(name, "cmp" | "cmn" | "tst" | "teq") => {}
            Class::FpStore => {
                instruction.words = self.words(0);
                instruction.consumes = self.all();
            }
            Class::FpCompare => {
                instruction.consumes = self.all();
                instruction.writes = 1 << FLAGS;
            }
            Class::FpLoad => {
                instruction.words = self.words(0);
                instruction.writes = self.all();
            }
            Class::FpMove if matches!(name, "vmrs" | "fmstat") => instruction.consumes = 1 << FLAGS,
            Class::FpTransfer => {
                // To the core's registers or from them: what it reads are those behind.
                let split = if self.registers.len() > 2 && self.is_core(0) { 2 } else { 1 };
                (instruction.writes, instruction.consumes) = (self.first(split), self.behind(split));
            }
            _ => {
                instruction.writes = self.first(1);
                instruction.consumes = self.behind(1);
            }
        }
        instruction.is_literal = class == Class::Load && self.address & PC != 0;
        instruction
    }
}
