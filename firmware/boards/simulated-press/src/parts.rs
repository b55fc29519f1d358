//! Parts that answer at once, from memory, and the machine that they are wired to: as much of each data sheet as the drivers use.
//!
//! The frames sent to the parts are kept, so that they can be sent again without the firmware: that cost does not belong to the firmware.

use core::cell::RefCell;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use firmware::app::press;
use firmware::control::Reference;
use heapless::Vec;
use model_core::machine::{Machine, MachineError, Tick};
use model_core::number::PerUnit;

/// Delay line of the machine, ticks.
const DELAY: usize = 64;

/// Number of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// ADS8688.
    Inputs,
    /// AD5754.
    Output,
    /// LS7366R.
    Counter,
}

/// Longest frame, bytes.
const LONGEST: usize = 6;
/// Most frames of a period: three attempts at everything need fewer.
const FRAMES: usize = 64;

/// What a part was sent.
#[derive(Clone, Copy, Debug)]
struct Frame {
    part: Part,
    bytes: [u8; LONGEST],
    length: usize,
    answered: bool,
}

/// ADS8688, AD5754 (its first output) and LS7366R.
#[derive(Debug)]
pub struct Parts {
    frames: Vec<Frame, FRAMES>,
    /// This part answers only zeros.
    pub silent: Option<Part>,
    registers: [u8; 64],
    selected: Option<u8>,
    codes: [u16; 8],
    output: i16,
    power: u16,
    question: u8,
    mode: [u8; 2],
    status: u8,
    count: i32,
}

impl Default for Parts {
    fn default() -> Self {
        Self::new()
    }
}

impl Parts {
    /// As after power-on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            frames: Vec::new(),
            silent: None,
            registers: [0; 64],
            selected: None,
            codes: [0; 8],
            output: 0,
            power: 0,
            question: 0,
            mode: [0; 2],
            status: 0b1100,
            count: 0,
        }
    }

    fn frame(&mut self, part: Part, sent: &[u8], answered: bool) -> [u8; LONGEST] {
        let mut bytes = [0; LONGEST];
        for (kept, byte) in bytes.iter_mut().zip(sent) {
            *kept = *byte;
        }
        // Frames beyond this room would not be subtracted: the period would then look more expensive.
        let _ = self.frames.push(Frame { part, bytes, length: sent.len(), answered });
        match part {
            _ if self.silent == Some(part) => [0; LONGEST],
            Part::Inputs => self.convert(bytes),
            Part::Output => self.put_out(bytes),
            Part::Counter => self.counted(bytes),
        }
    }

    fn convert(&mut self, [command, value, ..]: [u8; LONGEST]) -> [u8; LONGEST] {
        if command != 0 && command & 0x80 == 0 {
            let register = &mut self.registers[usize::from(command >> 1)];
            if command & 1 == 1 {
                *register = value;
            }
            self.selected = None;
            return [0, 0, *register, 0, 0, 0];
        }
        let mut answer = [0; LONGEST];
        if let Some(channel) = self.selected {
            let [high, low] = self.codes[usize::from(channel)].to_be_bytes();
            let range = u16::from(self.registers[5 + usize::from(channel)]);
            let [first, second] = (u16::from(channel) << 12 | 2 << 10 | range << 7).to_be_bytes();
            answer = [0, 0, high, low, first, second];
        }
        self.selected = (command >= 0xC0).then_some(command >> 2 & 7);
        answer
    }

    fn put_out(&mut self, [first, high, low, ..]: [u8; LONGEST]) -> [u8; LONGEST] {
        let data = u16::from_be_bytes([high, low]);
        let asked = match self.question >> 3 & 7 {
            0 => self.output.cast_unsigned(),
            1 => self.registers[63].into(),
            2 => self.power,
            _ => self.registers[62].into(),
        };
        let [out_high, out_low] = asked.to_be_bytes();
        if first & 0x80 != 0 {
            self.question = first;
        } else {
            match first >> 3 & 7 {
                0 => self.output = data.cast_signed(),
                // Registers that the inputs do not have.
                1 => self.registers[63] = low & 7,
                2 => self.power = data & 0b1_1111,
                3 if first & 7 == 1 => self.registers[62] = low & 0b1111,
                _ => {}
            }
        }
        [first, out_high, out_low, 0, 0, 0]
    }

    fn counted(&mut self, [instruction, value, ..]: [u8; LONGEST]) -> [u8; LONGEST] {
        let [a, b, c, d] = self.count.to_be_bytes();
        match instruction {
            0x20 => self.count = 0,
            0x30 => self.status &= 0b1000,
            0x48 => return [0, self.mode[0], 0, 0, 0, 0],
            0x50 => return [0, self.mode[1], 0, 0, 0, 0],
            0x60 => return [0, a, b, c, d, 0],
            0x70 => return [0, self.status, 0, 0, 0, 0],
            0x88 => self.mode[0] = value,
            0x90 => self.mode[1] = value,
            _ => {}
        }
        [0; LONGEST]
    }

    /// Forgets what was sent.
    pub fn forget(&mut self) {
        self.frames.clear();
    }
}

/// A part on its chip select.
#[derive(Clone, Copy, Debug)]
pub struct Wire<'a> {
    /// All of them.
    pub parts: &'a RefCell<Parts>,
    /// This one.
    pub part: Part,
}

impl ErrorType for Wire<'_> {
    type Error = ErrorKind;
}

impl SpiDevice for Wire<'_> {
    // Not inlined: the same code for every caller.
    #[inline(never)]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        for operation in operations {
            let (sent, read): (&[u8], &mut [u8]) = match operation {
                Operation::Write(sent) => (sent, &mut []),
                Operation::Transfer(read, sent) => (sent, read),
                // The drivers write and transfer only.
                _ => return Err(ErrorKind::Other),
            };
            let answer = self.parts.borrow_mut().frame(self.part, sent, !read.is_empty());
            for (byte, answered) in read.iter_mut().zip(answer) {
                *byte = answered;
            }
        }
        Ok(())
    }
}

/// Sends again what was sent since the last time.
#[inline(never)]
pub fn ask_again(parts: &RefCell<Parts>) {
    let frames = core::mem::take(&mut parts.borrow_mut().frames);
    for Frame { part, bytes, length, answered } in &frames {
        let mut wire = Wire { parts, part: *part };
        let (sent, mut answer) = (&bytes[..*length], [0; LONGEST]);
        let done = if *answered { wire.transfer(&mut answer[..*length], sent) } else { wire.write(sent) };
        core::hint::black_box((done, answer).0.is_ok());
    }
}

/// The machine: another model of the same drive.
#[derive(Debug)]
pub struct Plant {
    model: Reference<DELAY>,
    counts: i32,
}

impl Plant {
    /// At rest at [`PLACE`].
    ///
    /// # Errors
    /// The machine is not valid.
    pub fn new(machine: &Machine<f64>) -> Result<Self, MachineError> {
        let model = Reference::at_rest(machine, Tick::OneMillisecond, PLACE)?;
        let counts = counts(&model);
        Ok(Self { model, counts })
    }

    /// One millisecond of the machine; not counted.
    pub fn tick(&mut self, parts: &RefCell<Parts>) {
        let mut parts = parts.borrow_mut();
        let seen = self.model.step(PerUnit::from_bits(i32::from(parts.output) << 13));
        let pressure_pa = |pressure: PerUnit| pressure.to_f64() * self.model.bases().pressure_pa;
        let pressure_v = |pressure| 0.5 + 4.0 * pressure_pa(pressure) / press::PRESSURE_AT_4_5_V_PA;
        parts.codes[1] = code((10.0 * seen.spool.to_f64() / press::SPOOL_AT_10_V + 10.24) / 20.48);
        parts.codes[2] = code(pressure_v(seen.pressure_a) / 5.12);
        parts.codes[3] = code(pressure_v(seen.pressure_b) / 5.12);
        let counts = counts(&self.model);
        parts.count = parts.count.wrapping_add(counts - self.counts);
        self.counts = counts;
    }
}

/// Where the rod stands at the start, as a share of the stroke.
pub const PLACE: f64 = 0.3;

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast from f64 saturates")]
fn code(share: f64) -> u16 {
    (share * 65_536.0) as u16
}

#[expect(clippy::cast_possible_truncation, reason = "some ten thousand in a stroke")]
fn counts(model: &Reference<DELAY>) -> i32 {
    (model.predicted().position.to_f64() * model.bases().stroke_m * press::COUNTS_PER_M) as i32
}
