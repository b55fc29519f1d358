//! The other end of the firmware's `loop`: the parts on its lines are simulated here, wired to a machine's readings, period by period.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use firmware::app::press;
use firmware::period::Timing;
use firmware::set_point::SetPoint;
use firmware::supervision::Mode;
use model_core::machine::Machine;
use model_core::number::PerUnit;
use mps2::in_the_loop::lockstep::{Order, REQUEST, START, part};
use virtual_plant::Sensors;
use virtual_plant::sensor::sensors::PositionSensor;

use crate::emulator::Processor;
use crate::parts::{Adc, Counter, Dac, Part};
use crate::rig::{Controller, Readings, Rig, Wanted};

/// Periods before the firmware is told to follow: sensors and valve settle, and are at rest for as long as the recorder looks back.
pub const SETTLING: usize = 800;
/// Period in which the recorder is triggered if nothing has triggered it before.
pub const RECORDED_FROM: usize = SETTLING + 1000;
/// Longest that either side waits for the other.
const PATIENCE: Duration = Duration::from_secs(30);

/// A rig with the encoder that the firmware is wired to.
#[must_use]
pub fn rig(machine: &Machine<f64>, wanted: Vec<Wanted>) -> Rig {
    let position = PositionSensor::Linear { resolution_m: 1.0 / press::COUNTS_PER_M };
    Rig { sensors: Sensors::with_position(machine, position), ..Rig::new(machine, wanted) }
}

/// What the firmware reports of a period; [`mps2::in_the_loop::lockstep`] has the layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Said {
    /// Mode after the period, as a number.
    pub mode: u8,
    /// Signal whose innovation is beyond its limit, counted from 1.
    pub alarm: u8,
    /// Whether the watchdog was fed.
    pub fed: bool,
    /// Whether the order was refused.
    pub refused: bool,
    /// Faults reported since the start, and the kind of the last: [`firmware::supervision::Fault::kind`].
    pub faults: u8,
    /// Kind of the last fault.
    pub last_fault: u8,
    /// Whether the oil must be cut off by an independent valve.
    pub shut_off: bool,
    /// Command that was output, in 10 V.
    pub command: PerUnit,
    /// Measured position, of the stroke.
    pub position: PerUnit,
    /// Position of the model.
    pub model: PerUnit,
}

impl Said {
    fn of(frame: &[u8]) -> Self {
        let word = |at: usize| PerUnit::from_bits(i32::from_le_bytes([0, 1, 2, 3].map(|byte| frame[at + byte])));
        Self {
            mode: frame[12],
            alarm: frame[13],
            fed: frame[14] == 1,
            refused: frame[15] == 1,
            faults: frame[16],
            last_fault: frame[17],
            shut_off: frame[18] == 1,
            command: word(0),
            position: word(4),
            model: word(8),
        }
    }

    /// Whether the firmware is in this mode.
    #[must_use]
    pub fn is(&self, mode: Mode) -> bool {
        self.mode == mode as u8
    }
}

/// What is wrong with parts and wires; nothing by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrong {
    /// Voltage at the spool's input in place of its sensor's.
    pub spool_v: Option<f64>,
    /// The same of pressure A.
    pub pressure_a_v: Option<f64>,
    /// Which way the rod turns the encoder, if not as it should: -1 the wrong way, 0 not at all.
    pub sense: Option<i32>,
    /// The command's wires are exchanged at the valve.
    pub exchanged: bool,
    /// The spool is jammed where this voltage would have it.
    pub jammed_v: Option<f64>,
    /// The line from this part ([`part`]) is stuck at this level.
    pub hangs: Option<(u8, u8)>,
    /// The output is shorted.
    pub shorted: bool,
}

/// What remains when the firmware has ended.
#[derive(Clone, Debug)]
pub struct Ended {
    /// What its recorder streamed out.
    pub record: Vec<u8>,
    /// What it printed on the console.
    pub console: String,
}

impl Ended {
    /// Stack that the firmware used from its start to its end, bytes.
    ///
    /// # Panics
    /// The console does not show it.
    #[must_use]
    pub fn stack(&self) -> u64 {
        let bytes = self.console.split("stack ").nth(1).and_then(|rest| rest.split_whitespace().next()?.parse().ok());
        bytes.unwrap_or_else(|| panic!("no stack in `{}`", self.console))
    }
}

/// The firmware on an emulated processor, with its parts.
pub struct Board {
    emulator: Child,
    line: UnixStream,
    inputs: Adc,
    output: Dac,
    counter: Counter,
    /// Last count of the encoder.
    counts: i32,
    /// What is wrong from now on.
    pub wrong: Wrong,
    said: Said,
    record: Vec<u8>,
    // Holds the line's socket.
    _folder: TempDir,
}

impl std::fmt::Debug for Board {
    fn fmt(&self, formatter: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(formatter, "Board({:?})", self.said)
    }
}

impl Board {
    /// Starts an image, up to its first period.
    ///
    /// # Panics
    /// The emulator or the image does not start.
    #[must_use]
    pub fn start(processor: Processor, image: &Path, at_rest: &Readings) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("line");
        let emulator = Command::new("qemu-system-arm")
            .args(processor.machine())
            .args(["-display", "none", "-monitor", "none", "-semihosting-config", "enable=on,target=native"])
            .args(["-chardev", &format!("socket,id=line,path={},server=on,wait=on", socket.display())])
            .args(["-serial", "chardev:line", "-kernel"])
            .arg(image)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = connected(&socket);
        line.write_all(&[START]).expect("the firmware waits for its machine");
        let mut board = Self {
            emulator,
            line,
            inputs: Adc::new(),
            output: Dac::new(),
            counter: Counter::new(),
            counts: counts(at_rest),
            wrong: Wrong::default(),
            said: Said::default(),
            record: Vec::new(),
            _folder: folder,
        };
        board.show(at_rest);
        board.serve();
        board
    }

    /// One period: the set point, the order and the timing that it is given, and what the sensors show.
    ///
    /// # Panics
    /// The firmware has ended, or asks for a part that does not exist.
    pub fn period(&mut self, wanted: SetPoint, order: Order, timing: Timing, seen: &Readings) -> Said {
        self.show(seen);
        self.ask(wanted, order, timing);
        self.serve();
        self.said
    }

    /// Voltage at the valve.
    ///
    /// # Panics
    /// The output is down.
    #[must_use]
    pub fn volts(&self) -> f64 {
        let volts = self.output.volts(0).expect("the output is up");
        self.wrong.jammed_v.unwrap_or(if self.wrong.exchanged { -volts } else { volts })
    }

    /// The encoder's count jumps.
    pub fn jump(&mut self, edges: i32) {
        self.counter.turn(edges);
    }

    /// From now on the sensors show these readings, except where a fault is set.
    fn show(&mut self, seen: &Readings) {
        let pressure_v = |pressure_pa: f64| 0.5 + 4.0 * pressure_pa / press::PRESSURE_AT_4_5_V_PA;
        let Wrong { spool_v, pressure_a_v, sense, shorted, .. } = self.wrong;
        self.inputs.inputs_v[1] = Some(spool_v.unwrap_or(10.0 * seen.spool / press::SPOOL_AT_10_V));
        self.inputs.inputs_v[2] = Some(pressure_a_v.unwrap_or(pressure_v(seen.pressure_a_pa)));
        self.inputs.inputs_v[3] = Some(pressure_v(seen.pressure_b_pa));
        self.output.shorted = shorted.then_some(0);
        let counts = counts(seen);
        self.counter.turn(sense.unwrap_or(1) * (counts - self.counts));
        self.counts = counts;
    }

    /// Answers the firmware's requests up to the end of its period.
    fn serve(&mut self) {
        loop {
            let (number, mut frame, from) = self.asked().expect("the firmware goes on");
            if number == part::PERIOD {
                self.said = Said::of(&frame);
                return;
            }
            // A part is clocked for the longer of the two directions.
            frame.resize(frame.len().max(from), 0);
            let mut answer = match number {
                part::INPUTS => self.inputs.frame(&frame),
                part::OUTPUT => self.output.frame(&frame),
                part::COUNTER => self.counter.frame(&frame),
                other => panic!("there is no part {other}"),
            };
            answer.truncate(from);
            if let Some((_, level)) = self.wrong.hangs.filter(|(part, _)| *part == number) {
                answer.fill(level);
            }
            self.line.write_all(&answer).expect("the firmware waits for an answer");
        }
    }

    /// The firmware's next request: the part, the bytes to it, and how many bytes it wants back. `None` where the firmware has ended.
    fn asked(&mut self) -> Option<(u8, Vec<u8>, usize)> {
        let mut head = [0; 3];
        self.line.read_exact(&mut head).ok()?;
        let [number, to, from] = head;
        let mut frame = vec![0; to.into()];
        self.line.read_exact(&mut frame).expect("the firmware sends whole frames");
        Some((number, frame, from.into()))
    }

    fn ask(&mut self, wanted: SetPoint, order: Order, timing: Timing) {
        let mut request = [0; REQUEST];
        request[..4].copy_from_slice(&wanted.position.to_bits().to_le_bytes());
        request[4..8].copy_from_slice(&wanted.velocity.to_bits().to_le_bytes());
        request[8] = order as u8;
        request[9] = u8::from(timing == Timing::Overrun);
        self.line.write_all(&request).expect("the firmware waits for a request");
    }

    /// Ends the firmware.
    ///
    /// # Panics
    /// It ends with an error.
    #[must_use]
    pub fn end(mut self) -> Ended {
        let nothing = SetPoint { position: self.said.position, velocity: PerUnit::from_bits(0) };
        self.ask(nothing, Order::End, Timing::Kept);
        while let Some((number, frame, _)) = self.asked() {
            assert_eq!(number, part::RECORD, "nothing but the record follows");
            self.record.extend(frame);
        }
        let status = self.emulator.wait().unwrap();
        let mut console = String::new();
        let out = self.emulator.stdout.as_mut().expect("it is piped");
        out.read_to_string(&mut console).unwrap();
        assert!(status.success(), "{status}: {console}");
        Ended { record: std::mem::take(&mut self.record), console }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        // It has ended already, or a test has failed and no longer needs it.
        let _ = self.emulator.kill();
        let _ = self.emulator.wait();
    }
}

/// The firmware as a controller: it is homed, settles, follows, and triggers its recorder.
#[derive(Debug)]
pub struct Follows {
    board: Board,
    /// Periods so far.
    periods: usize,
    /// The first period with an alarm, and the signal it was for.
    pub alarm: Option<(usize, u8)>,
}

impl Follows {
    /// On a board that has just started.
    #[must_use]
    pub fn on(board: Board) -> Self {
        Self { board, periods: 0, alarm: None }
    }

    /// Ends the firmware.
    ///
    /// # Panics
    /// It ends with an error.
    #[must_use]
    pub fn end(self) -> Ended {
        self.board.end()
    }
}

impl Controller for Follows {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        let order = match self.periods {
            0 => Order::Home,
            // A machine that is recorded for a diagnosis differs from its model.
            1 => Order::IgnoreAlarms,
            SETTLING => Order::Follow,
            RECORDED_FROM => Order::Record,
            _ => Order::None,
        };
        let said = self.board.period(wanted.per_unit, order, Timing::Kept, seen);
        assert_eq!(said.is(Mode::Following), self.periods >= SETTLING, "period {}: {said:?}", self.periods);
        if said.alarm > 0 && self.alarm.is_none() {
            self.alarm = Some((self.periods, said.alarm));
        }
        self.periods += 1;
        self.board.volts()
    }
}

/// Edges of the encoder since homing.
#[expect(clippy::cast_possible_truncation, reason = "a stroke has some ten thousand")]
fn counts(seen: &Readings) -> i32 {
    (seen.position_m * press::COUNTS_PER_M).round() as i32
}

/// The line, as soon as the emulator has opened it.
fn connected(socket: &Path) -> UnixStream {
    let until = Instant::now() + PATIENCE;
    loop {
        match UnixStream::connect(socket) {
            Ok(line) => {
                line.set_read_timeout(Some(PATIENCE)).unwrap();
                return line;
            }
            Err(error) if Instant::now() > until => panic!("{}: {error}", socket.display()),
            Err(_) => std::thread::sleep(Duration::from_millis(10)),
        }
    }
}
