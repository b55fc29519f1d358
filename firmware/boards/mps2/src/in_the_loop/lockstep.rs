//! The whole firmware with its parts at the other end of a serial line, in lockstep with a simulated machine.
//!
//! The same drivers, period, monitor and recorder as on a board; only the SPI frames go over the line ([`SerialLine`]). The firmware sends nothing
//! before the host has sent [`START`]. Then, before each period, it sends a report of the last period and receives the request for this
//! one, little-endian:
//!
//! | bytes | to the host: report | to the firmware: request |
//! |---|---|---|
//! | 0…3 | command, word | position wanted, word |
//! | 4…7 | measured position, word | velocity wanted, word |
//! | 8…11 | model's position, word | order u8, overrun u8 |
//! | 12…15 | mode u8, alarm u8, fed watchdog u8, refused order u8 | |
//! | 16…18 | faults logged since the start u8, kind of the last u8, oil to be cut off u8 | |
//!
//! A word is a per-unit signal's 32 bits. An alarm is the number of its signal, from 1. The recorder is streamed out when the host ends the run.

use embedded_hal::delay::DelayNs;
use embedded_io::{ErrorType, Read, Write};
use model_core::number::PerUnit;

use super::remote::{MOST_BYTES, RemoteError, SerialLine};
use firmware::app::{Ring, StationError, press, wired};
use firmware::commissioning::Note;
use firmware::monitor::Miss;
use firmware::period::{Answer, Report, Request, Timing, Watchdog};
use firmware::recorder::frame::{FrameError, FrameWriter};
use firmware::recorder::{Progress, Stream};
use firmware::set_point::SetPoint;
use firmware::supervision::{Command, Fault, Log, Mode};

/// What the host sends once, before anything else: not a key of a terminal.
pub const START: u8 = 0xA5;

/// Numbers of the parts on the line.
pub mod part {
    /// Analogue inputs, ADS8688.
    pub const INPUTS: u8 = 0;
    /// Analogue output, AD5754.
    pub const OUTPUT: u8 = 1;
    /// Encoder's counter, LS7366R.
    pub const COUNTER: u8 = 2;
    /// Report and request.
    pub const PERIOD: u8 = 16;
    /// Bytes of the recorder.
    pub const RECORD: u8 = 17;
}

/// What the host may order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Order {
    /// Nothing.
    None = 0,
    /// Follow the set point.
    Follow = 1,
    /// Stop.
    Stop = 2,
    /// Acknowledge the faults.
    Acknowledge = 3,
    /// The rod is at the position that is sent.
    Home = 4,
    /// Stream the recorder out, if it is full, and end.
    End = 5,
    /// Trigger the recorder.
    Record = 6,
    /// From now on an alarm of the monitor is told and leads to nothing.
    IgnoreAlarms = 7,
    /// From now on an alarm of the monitor stops the rod, as after the start.
    HeedAlarms = 8,
}

impl Order {
    const ALL: [Order; 9] = [
        Order::None,
        Order::Follow,
        Order::Stop,
        Order::Acknowledge,
        Order::Home,
        Order::End,
        Order::Record,
        Order::IgnoreAlarms,
        Order::HeedAlarms,
    ];

    fn of(byte: u8) -> Self {
        Self::ALL.into_iter().find(|order| *order as u8 == byte).unwrap_or(Order::None)
    }

    fn command(self) -> Option<Command> {
        match self {
            Order::Follow => Some(Command::Follow),
            Order::Stop => Some(Command::Stop),
            Order::Acknowledge => Some(Command::Acknowledge),
            Order::None | Order::Home | Order::End | Order::Record | Order::IgnoreAlarms | Order::HeedAlarms => None,
        }
    }
}

/// Why the run ended early.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LockstepError {
    /// It did not begin.
    #[error(transparent)]
    Station(#[from] StationError),
    /// The line failed.
    #[error(transparent)]
    Line(#[from] RemoteError),
    /// The record did not go out.
    #[error("the record was not sent completely")]
    Record,
}

/// Runs from the host's [`START`] until the host ends the run. `memory` holds the recorder, which is too large for a stack.
///
/// # Errors
/// The exported values do not make a rig, a part does not answer as it must at the start, or the line fails.
pub fn run<L: Read + Write>(
    line: L,
    delay: &mut impl DelayNs,
    log: &mut impl Log,
    memory: &mut Option<Ring>,
) -> Result<(), LockstepError> {
    let line = SerialLine::new(line);
    line.wait_for(START)?;
    let [inputs, counter, output] = [part::INPUTS, part::COUNTER, part::OUTPUT].map(|number| line.part(number));
    let mut station = wired(inputs, counter, output, delay, memory)?;
    let (mut heard, mut report) = (Heard { log, faults: 0, last: 0 }, [0; REPORT]);
    loop {
        let mut asked = [0; REQUEST];
        line.exchange(part::PERIOD, &report, &mut asked)?;
        let (order, request) = read(asked);
        match order {
            Order::End => break,
            Order::Home => _ = station.home(request.set_point.position),
            Order::Record => station.trigger(),
            Order::IgnoreAlarms => station.answer_alarms(None),
            Order::HeedAlarms => station.answer_alarms(press::ALARM),
            Order::None | Order::Follow | Order::Stop | Order::Acknowledge => {}
        }
        let now = station.step(&request, &mut heard);
        report = written(&now, station.predicted().position, &heard);
    }
    streamed(station.recorder(), &line)
}

/// Passes on all log messages, and remembers what a report contains of them.
struct Heard<'a, L> {
    log: &'a mut L,
    /// Faults logged, and the kind of the last.
    faults: u8,
    last: u8,
}

impl<L: Log> Log for Heard<'_, L> {
    fn fault(&mut self, fault: &Fault) {
        self.faults = self.faults.wrapping_add(1);
        self.last = fault.kind();
        self.log.fault(fault);
    }

    fn mode(&mut self, from: Mode, to: Mode) {
        self.log.mode(from, to);
    }

    fn alarm(&mut self, miss: &Miss) {
        self.log.alarm(miss);
    }

    fn commissioning(&mut self, note: &Note) {
        self.log.commissioning(note);
    }
}

/// Bytes of a report.
pub const REPORT: usize = 19;
/// Bytes of a request.
pub const REQUEST: usize = 10;

/// The request for the next period.
fn read(bytes: [u8; REQUEST]) -> (Order, Request) {
    let [p0, p1, p2, p3, v0, v1, v2, v3, order, overrun] = bytes;
    let order = Order::of(order);
    let word = |bytes| PerUnit::from_bits(i32::from_le_bytes(bytes));
    let set_point = SetPoint { position: word([p0, p1, p2, p3]), velocity: word([v0, v1, v2, v3]) };
    let timing = if overrun == 0 { Timing::Kept } else { Timing::Overrun };
    (order, Request { set_point, command: order.command(), timing })
}

/// The report of a period.
fn written<L>(report: &Report, model: PerUnit, heard: &Heard<'_, L>) -> [u8; REPORT] {
    let [c0, c1, c2, c3] = report.command.to_bits().to_le_bytes();
    let [p0, p1, p2, p3] = report.measured.position.to_bits().to_le_bytes();
    let [m0, m1, m2, m3] = model.to_bits().to_le_bytes();
    let alarm = report.alarm.map_or(0, |miss| 1 + miss.signal as u8);
    let fed = u8::from(report.watchdog == Watchdog::Feed);
    let refused = u8::from(report.answer.is_some_and(|answer| answer != Answer::Taken));
    let (mode, shut_off) = (report.mode as u8, u8::from(report.shut_off));
    [c0, c1, c2, c3, p0, p1, p2, p3, m0, m1, m2, m3, mode, alarm, fed, refused, heard.faults, heard.last, shut_off]
}

/// Streams a full recorder out.
fn streamed<L: Read + Write>(recorder: &Ring, line: &SerialLine<L>) -> Result<(), LockstepError> {
    let (mut stream, mut frames, mut out) = (Stream::new(), FrameWriter::default(), Record { line });
    loop {
        let progress = stream.write(recorder, press::values::NAME, press::TICK_NS, &mut frames, &mut out);
        match progress {
            Ok(Progress::More) => {}
            Ok(Progress::Done) => return Ok(()),
            Err(FrameError::Line(error)) => return Err(error.into()),
            Err(FrameError::TooLong { .. }) => return Err(LockstepError::Record),
        }
    }
}

/// Where the recorder's bytes go.
#[derive(Debug)]
struct Record<'a, L> {
    line: &'a SerialLine<L>,
}

impl<L> ErrorType for Record<'_, L> {
    type Error = RemoteError;
}

impl<L: Read + Write> Write for Record<'_, L> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        let (sent, _) = bytes.split_at_checked(MOST_BYTES).unwrap_or((bytes, &[]));
        self.line.exchange(part::RECORD, sent, &mut [])?;
        Ok(sent.len())
    }

    fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}
