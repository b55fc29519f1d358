//! The three parts as their data sheets describe them, register by register. They share nothing with the drivers.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

/// What a part does in one frame: it sends as many bytes as it receives.
pub(crate) trait Part {
    fn frame(&mut self, sent: &[u8]) -> Vec<u8>;

    /// Its supply is lost and comes back: every register as after power-on.
    fn lose_power(&mut self);
}

/// What happens to the line from a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WireState {
    Whole,
    /// It is stuck at this level.
    Hangs(u8),
    /// The bus fails.
    Fails,
    /// Each byte is replaced by noise from this xorshift.
    Noise(u32),
    /// After so many more frames bits of one are wrong, by this mask; then the line is whole again.
    Flips(usize, u8),
    /// After so many more frames the part loses its supply within one, after so many of its bytes; then the supply is back, or stays away.
    LosesPower {
        frames: usize,
        bytes: usize,
        stays_away: bool,
    },
    /// The part has no supply yet, for so many more frames.
    Sleeps(usize),
}

/// A part on its own chip select, shared with the test.
pub(crate) struct Wire<P> {
    pub(crate) part: Rc<RefCell<P>>,
    pub(crate) line: Rc<RefCell<WireState>>,
    pub(crate) bytes: Rc<RefCell<usize>>,
}

impl<P: Part> Wire<P> {
    /// What arrives of the part's answer.
    fn answer(&self, sent: &[u8]) -> Vec<u8> {
        let (mut part, mut line) = (self.part.borrow_mut(), self.line.borrow_mut());
        match &mut *line {
            WireState::Sleeps(left) if *left > 0 => {
                *left -= 1;
                vec![0; sent.len()]
            }
            WireState::LosesPower { frames: 0, bytes, stays_away } => {
                let mut answer = part.frame(sent);
                answer.iter_mut().skip(*bytes).for_each(|byte| *byte = 0);
                part.lose_power();
                *line = if *stays_away { WireState::Hangs(0) } else { WireState::Whole };
                answer
            }
            WireState::Flips(0, mask) => {
                let mut answer = part.frame(sent);
                // The status itself, or a byte of a count that the rod cannot have moved by.
                let place = if answer.len() == 2 { 1 } else { answer.len().saturating_sub(2) };
                answer[place] ^= *mask;
                *line = WireState::Whole;
                answer
            }
            WireState::LosesPower { frames: left, .. } | WireState::Flips(left, _) => {
                *left -= 1;
                part.frame(sent)
            }
            WireState::Hangs(level) => {
                part.frame(sent);
                vec![*level; sent.len()]
            }
            WireState::Noise(word) => part.frame(sent).into_iter().map(|_| noise(word)).collect(),
            WireState::Whole | WireState::Fails | WireState::Sleeps(_) => part.frame(sent),
        }
    }
}

/// A byte of a xorshift.
fn noise(word: &mut u32) -> u8 {
    *word ^= *word << 13;
    *word ^= *word >> 17;
    *word ^= *word << 5;
    let [noise, ..] = word.to_be_bytes();
    noise
}

impl<P> ErrorType for Wire<P> {
    type Error = ErrorKind;
}

impl<P: Part> SpiDevice for Wire<P> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let line = *self.line.borrow();
        if line == WireState::Fails {
            return Err(ErrorKind::Other);
        }
        for operation in operations {
            let (sent, read): (&[u8], &mut [u8]) = match operation {
                Operation::Write(sent) => (sent, &mut []),
                Operation::Transfer(read, sent) => (sent, read),
                _ => panic!("the drivers write and transfer only"),
            };
            *self.bytes.borrow_mut() += sent.len();
            let answer = self.answer(sent);
            read.iter_mut().zip(answer).for_each(|(byte, answered)| *byte = answered);
        }
        Ok(())
    }
}

/// ADS8688, SBAS582C: command register (table 6), program registers (8.5.2), output format (tables 12 to 14).
pub(crate) struct Adc {
    registers: [u8; 64],
    selected: Option<u8>,
    /// Volts at each input; an open one floats to some +2 V by its own 1 MΩ.
    pub(crate) inputs_v: [Option<f64>; 8],
}

impl Adc {
    pub(crate) fn new() -> Self {
        let mut part = Self { registers: [0; 64], selected: None, inputs_v: [None; 8] };
        part.lose_power();
        part
    }

    fn code(&self, channel: u8) -> u16 {
        if self.registers[2] & 1 << channel != 0 {
            return 0;
        }
        let volts = self.inputs_v[usize::from(channel)].unwrap_or(2.2);
        let (low_v, high_v) = match self.registers[5 + usize::from(channel)] {
            0 => (-10.24, 10.24),
            1 => (-5.12, 5.12),
            2 => (-2.56, 2.56),
            5 => (0.0, 10.24),
            6 => (0.0, 5.12),
            other => panic!("no range {other}"),
        };
        let code = ((volts - low_v) / (high_v - low_v) * 65_536.0).round().clamp(0.0, 65_535.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "held within the type")]
        let code = code as u16;
        code
    }
}

impl Part for Adc {
    fn lose_power(&mut self) {
        self.registers = [0; 64];
        self.registers[1] = 0xFF;
        self.selected = None;
    }

    fn frame(&mut self, sent: &[u8]) -> Vec<u8> {
        // Bit 47 of `word` is the first of six bytes; the answer starts at the 16th clock.
        let mut word = 0_u64;
        let command = sent[0];
        if command != 0 && command & 0x80 == 0 {
            let address = usize::from(command >> 1);
            if command & 1 == 1 {
                self.registers[address] = sent[1];
            }
            word = u64::from(self.registers[address]) << 24;
            self.selected = None;
        } else {
            if let Some(channel) = self.selected {
                word = u64::from(self.code(channel)) << 16;
                let feature = self.registers[3];
                if feature & 0b111 == 3 {
                    let range = self.registers[5 + usize::from(channel)] & 0b111;
                    let tag = u64::from(channel) << 5 | u64::from(feature >> 6) << 3 | u64::from(range);
                    word |= tag << 7;
                }
            }
            match command {
                0x85 => self.lose_power(),
                0xC0..=0xDC if command.is_multiple_of(4) => self.selected = Some((command - 0xC0) >> 2),
                0x00 => {}
                other => panic!("no command {other:#x}"),
            }
        }
        word.to_be_bytes()[2..2 + sent.len()].to_vec()
    }
}

/// LS7366R: instructions of table 1, MDR0, MDR1, STR.
pub(crate) struct Counter {
    mode: [u8; 2],
    status: u8,
    count: i32,
}

impl Counter {
    pub(crate) fn new() -> Self {
        Self { mode: [0; 2], status: 0b1100, count: 0 }
    }

    /// Edges of both channels of the encoder.
    pub(crate) fn turn(&mut self, edges: i32) {
        if self.mode[0] & 0b11 == 3 {
            self.count = self.count.wrapping_add(edges);
        }
    }
}

impl Part for Counter {
    fn lose_power(&mut self) {
        *self = Self::new();
    }

    fn frame(&mut self, sent: &[u8]) -> Vec<u8> {
        let mut answer = vec![0; sent.len()];
        match (sent[0] >> 6, sent[0] >> 3 & 7) {
            (0, 1) => self.mode[0] = 0,
            (0, 2) => self.mode[1] = 0,
            (0, 4) => self.count = 0,
            (0, 6) => self.status &= 0b1000,
            (1, 1) => answer[1] = self.mode[0],
            (1, 2) => answer[1] = self.mode[1],
            (1, 4) => answer[1..].copy_from_slice(&self.count.to_be_bytes()),
            (1, 6) => answer[1] = self.status,
            (2, 1) => self.mode[0] = sent[1],
            (2, 2) => self.mode[1] = sent[1],
            other => panic!("no instruction {other:?}"),
        }
        answer
    }
}

/// AD5754: input shift register, DAC, output range, power control and control registers. BIN/2sCOMP low, LDAC low.
pub(crate) struct Dac {
    codes: [i16; 4],
    ranges: [u8; 4],
    power: u16,
    control: u8,
    /// What the next frame clocks out.
    out: u16,
    /// Overcurrent at this output.
    pub(crate) shorted: Option<usize>,
}

impl Dac {
    pub(crate) fn new() -> Self {
        Self { codes: [0; 4], ranges: [0; 4], power: 0, control: 0, out: 0, shorted: None }
    }

    /// Voltage of an output; none if the output is powered down.
    pub(crate) fn volts(&self, output: usize) -> Option<f64> {
        let up = self.power & 1 << output != 0;
        assert!(!up || self.ranges[output] == 4, "±10 V");
        up.then(|| f64::from(self.codes[output]) / 32_768.0 * 10.0)
    }

    fn register(&self, first: u8) -> u16 {
        let output = usize::from(first & 3);
        match first >> 3 & 7 {
            0 => self.codes[output].cast_unsigned(),
            1 => self.ranges[output].into(),
            2 => self.power | self.shorted.map_or(0, |output| 1 << (7 + output)),
            _ => self.control.into(),
        }
    }
}

impl Part for Dac {
    fn lose_power(&mut self) {
        *self = Self { shorted: self.shorted, ..Self::new() };
    }

    fn frame(&mut self, sent: &[u8]) -> Vec<u8> {
        let [first, high, low] = *sent else { panic!("24 bits") };
        let [out_high, out_low] = self.out.to_be_bytes();
        let data = u16::from_be_bytes([high, low]);
        if first & 0x80 != 0 {
            self.out = self.register(first & 0x3F);
        } else {
            let output = usize::from(first & 3);
            match (first >> 3 & 7, first & 7) {
                (0, 0..4) => self.codes[output] = data.cast_signed(),
                (1, 0..4) => self.ranges[output] = low & 7,
                (2, 0) => self.power = data & 0b1_1111,
                (3, 1) => self.control = low & 0b1111,
                (3, 0) => {}
                other => panic!("no register {other:?}"),
            }
        }
        vec![first, out_high, out_low]
    }
}
