//! Runs an image in QEMU, one instruction at a time, and collects the ticks.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::decoded::{Code, DecodeError, Function, Instruction};
use super::path::{self, Cost};
use crate::emulator::Processor;

/// Why an image was not traced.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// Its code cannot be read.
    #[error(transparent)]
    Decode(#[from] DecodeError),
    /// The emulator cannot be started or read.
    #[error("qemu-system-arm: {0}")]
    Emulator(#[from] std::io::Error),
    /// A line of the trace is not understood.
    #[error("not a line of a trace: {0}")]
    Line(String),
    /// The functions were never called by the caller.
    #[error(
        "no tick was seen: {functions:?} were not called, or did not return to their caller; the emulator said: {said}"
    )]
    NoTick {
        /// The functions.
        functions: Vec<String>,
        /// What the emulator said beside the trace.
        said: String,
    },
}

/// What a run has cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Each tick, in their order.
    pub ticks: Vec<Cost>,
    /// What the image has printed.
    pub printed: String,
}

/// Which part of an image is counted: from the entry of one of `functions` until `caller` goes on.
#[derive(Clone, Copy, Debug)]
pub struct Counted<'a> {
    /// Their names, see [`Code::named`].
    pub functions: &'a [&'a str],
    /// The function that calls them.
    pub caller: &'a str,
    /// After so many ticks the emulator is stopped.
    pub at_most: usize,
}

/// Runs an image and weighs every tick.
///
/// # Errors
/// The image cannot be read, a name is not one of its functions, the emulator fails, or there is no tick.
pub fn trace(processor: Processor, image: &Path, counted: Counted) -> Result<Traced, TraceError> {
    let mut code = Code::read(image)?;
    let mut entries = Vec::new();
    for name in counted.functions {
        entries.extend(code.named(name)?);
    }
    let callers = code.named(counted.caller)?;
    let reached = reached(&mut code, &entries);
    let shown: Vec<&Function> = reached.iter().chain(&callers).collect();
    let mut emulator = Emulator(emulator(processor, image, &shown)?);
    let log = emulator.0.stderr.take().ok_or_else(|| std::io::Error::other("its trace is no pipe"))?;
    let mut lines = BufReader::with_capacity(1 << 20, log);
    let starts: BTreeSet<u32> = entries.iter().map(|entry| entry.address).collect();
    let (mut ticks, mut passed, mut is_inside) = (Vec::new(), Vec::new(), false);
    let (mut line, mut said) = (Vec::new(), String::new());
    while ticks.len() < counted.at_most {
        line.clear();
        if lines.read_until(b'\n', &mut line)? == 0 {
            break;
        }
        let Some(address) = address(&line)? else {
            if !line.starts_with(b"Stopped") {
                said += &String::from_utf8_lossy(&line);
            }
            continue;
        };
        if is_inside && callers.iter().any(|caller| caller.holds(address)) {
            is_inside = false;
            ticks.push(cost(processor, &mut code, &passed, address)?);
        } else if is_inside {
            // A block that was left before it ran is told again.
            if passed.last() != Some(&address) {
                passed.push(address);
            }
        } else if starts.contains(&address) {
            is_inside = true;
            passed.clear();
            passed.push(address);
        }
    }
    if ticks.is_empty() {
        let functions = counted.functions.iter().map(|&name| name.to_owned()).collect();
        return Err(TraceError::NoTick { functions, said });
    }
    let _ = emulator.0.kill();
    // An image prints little: it fits the pipe until it is read.
    let mut printed = String::new();
    if let Some(mut output) = emulator.0.stdout.take() {
        output.read_to_string(&mut printed)?;
    }
    Ok(Traced { ticks, printed })
}

fn cost(processor: Processor, code: &mut Code, passed: &[u32], back: u32) -> Result<Cost, DecodeError> {
    for &address in passed {
        code.at(address)?;
    }
    let path: Vec<&Instruction> = passed.iter().filter_map(|&address| code.known(address)).collect();
    Ok(path::cost(processor, &path, back))
}

/// The program counter of a line of the trace, `Trace 0: host [flags/counter/…] name`; `None` for lines of other kinds.
fn address(line: &[u8]) -> Result<Option<u32>, TraceError> {
    if !line.starts_with(b"Trace") {
        return Ok(None);
    }
    let counter = line.split(|&byte| byte == b'/').nth(1).and_then(|counter| std::str::from_utf8(counter).ok());
    match counter.and_then(|counter| u32::from_str_radix(counter, 16).ok()) {
        Some(counter) => Ok(Some(counter)),
        None => Err(TraceError::Line(String::from_utf8_lossy(line).into_owned())),
    }
}

/// These functions and all that they can come to by direct branches; all functions of the image where one branches to an address in a register.
fn reached(code: &mut Code, entries: &[Function]) -> Vec<Function> {
    let all = code.functions().to_vec();
    let mut reached = Vec::new();
    let mut left = entries.to_vec();
    while let Some(function) = left.pop() {
        if reached.contains(&function) {
            continue;
        }
        let mut address = function.address;
        while function.holds(address) {
            // Constants stand between the instructions: what is not one is passed over.
            let Ok(instruction) = code.at(address) else {
                address += 2;
                continue;
            };
            if instruction.text.starts_with("blx r") {
                return all;
            }
            if let Some(to) = branch(&instruction.text) {
                left.extend(all.iter().filter(|other| other.holds(to) && **other != function).cloned());
            }
            address += instruction.size;
        }
        reached.push(function);
    }
    reached
}

/// Where a direct branch goes.
fn branch(text: &str) -> Option<u32> {
    let (mnemonic, operands) = text.split_once(' ')?;
    if !mnemonic.starts_with('b') && !mnemonic.starts_with("cb") {
        return None;
    }
    u32::from_str_radix(operands.rsplit("#0x").next().filter(|_| operands.contains("#0x"))?, 16).ok()
}

/// An emulator that ends with this value.
struct Emulator(Child);

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts the emulator so that it writes each program counter in these functions.
fn emulator(processor: Processor, image: &Path, shown: &[&Function]) -> std::io::Result<Child> {
    let ranges: Vec<String> =
        shown.iter().map(|function| format!("{:#x}+{:#x}", function.address, function.size)).collect();
    let mut command = Command::new("qemu-system-arm");
    command.args(processor.machine()).args(["-icount", "shift=0"]);
    command.args(["-semihosting-config", "enable=on,target=native"]);
    command.args(["-display", "none", "-monitor", "none", "-serial", "none"]);
    command.args(one_instruction_at_a_time()?);
    command.args(["-d", "exec,nochain", "-dfilter", &ranges.join(",")]).arg("-kernel").arg(image);
    // The trace goes to its standard error, what the image prints to its standard output.
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn()
}

/// The option for it, which has another name from QEMU 8.1 on.
fn one_instruction_at_a_time() -> std::io::Result<&'static [&'static str]> {
    let output = Command::new("qemu-system-arm").arg("--version").output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    let version = text.split_whitespace().find(|word| word.starts_with(|first: char| first.is_ascii_digit()));
    let mut numbers = version.unwrap_or("").split('.').map(|number| number.parse::<u32>().unwrap_or(0));
    let version = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
    Ok(if version < (8, 1) { &["-singlestep"] } else { &["-accel", "tcg,one-insn-per-tb=on"] })
}
