//! The firmware on the emulated processor as a controller: its parts are simulated here, and go with it period by period.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use firmware::lockstep::{Order, part};
use firmware::mode::Mode;
use firmware::press;
use tempfile::TempDir;

use crate::parts::{Adc, Counter, Dac, Part};
use crate::rig::{Controller, Readings, Wanted};

/// Periods before the firmware is told to follow: sensors and valve settle, and are at rest for as long as the recorder looks back.
pub(crate) const SETTLING: usize = 800;
/// Period in which the recorder is triggered where nothing has triggered it before.
const RECORDED_FROM: usize = SETTLING + 1000;
/// Longest that either side waits for the other.
const PATIENCE: Duration = Duration::from_secs(30);

/// What the firmware says of a period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Said {
    pub(crate) mode: u8,
    /// Signal whose innovation is beyond its limit, counted from 1.
    pub(crate) alarm: u8,
}

/// The emulated processor with its parts.
pub(crate) struct Processor {
    emulator: Child,
    line: UnixStream,
    inputs: Adc,
    output: Dac,
    counter: Counter,
    /// Where the encoder was last.
    counts: i32,
    said: Said,
    /// Periods so far, and the first of them with an alarm.
    periods: usize,
    pub(crate) alarm: Option<(usize, u8)>,
    record: Vec<u8>,
    // Holds the line's socket.
    _folder: TempDir,
}

impl Processor {
    /// Starts an image, up to its first period.
    pub(crate) fn start(image: &Path, at_rest: &Readings) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("line");
        let emulator = Command::new("qemu-system-arm")
            .args(["-machine", "mps2-an386", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-chardev", &format!("socket,id=line,path={},server=on,wait=on", socket.display())])
            .args(["-serial", "chardev:line", "-kernel"])
            .arg(image)
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let mut processor = Self {
            emulator,
            line: connected(&socket),
            inputs: Adc::new(),
            output: Dac::new(),
            counter: Counter::new(),
            counts: counts(at_rest),
            said: Said::default(),
            periods: 0,
            alarm: None,
            record: Vec::new(),
            _folder: folder,
        };
        processor.show(at_rest);
        processor.serve();
        processor
    }

    /// The sensors show these readings from now on.
    fn show(&mut self, seen: &Readings) {
        let pressure_v = |pressure_pa: f64| 0.5 + 4.0 * pressure_pa / press::PRESSURE_AT_4_5_V_PA;
        self.inputs.inputs_v[1] = Some(10.0 * seen.slider / press::SLIDER_AT_10_V);
        self.inputs.inputs_v[2] = Some(pressure_v(seen.pressure_a_pa));
        self.inputs.inputs_v[3] = Some(pressure_v(seen.pressure_b_pa));
        let counts = counts(seen);
        self.counter.turn(counts - self.counts);
        self.counts = counts;
    }

    /// Answers what the firmware asks for, up to the end of its period.
    fn serve(&mut self) {
        loop {
            let mut head = [0; 2];
            self.line.read_exact(&mut head).expect("the firmware goes on");
            let [number, length] = head;
            let mut frame = vec![0; usize::from(length)];
            self.line.read_exact(&mut frame).expect("the firmware sends whole frames");
            let answer = match number {
                part::INPUTS => self.inputs.frame(&frame),
                part::OUTPUT => self.output.frame(&frame),
                part::COUNTER => self.counter.frame(&frame),
                part::RECORD => {
                    self.record.extend(&frame);
                    frame
                }
                part::PERIOD => {
                    self.said = Said { mode: frame[12], alarm: frame[13] };
                    return;
                }
                other => panic!("there is no part {other}"),
            };
            self.line.write_all(&answer).expect("the firmware waits for an answer");
        }
    }

    fn ask(&mut self, wanted: Wanted, order: Order) {
        let mut request = [0; 16];
        request[..4].copy_from_slice(&wanted.per_unit.position.to_bits().to_le_bytes());
        request[4..8].copy_from_slice(&wanted.per_unit.velocity.to_bits().to_le_bytes());
        request[8] = order as u8;
        self.line.write_all(&request).expect("the firmware waits for a request");
    }

    /// Ends the firmware; gives what its recorder streamed out.
    pub(crate) fn end(mut self, wanted: Wanted) -> Vec<u8> {
        self.ask(wanted, Order::End);
        let mut head = [0; 2];
        while self.line.read_exact(&mut head).is_ok() {
            let mut frame = vec![0; usize::from(head[1])];
            self.line.read_exact(&mut frame).expect("the firmware sends whole frames");
            assert_eq!(head[0], part::RECORD, "nothing but the record follows");
            self.line.write_all(&frame).expect("the firmware waits for an answer");
            self.record.extend(frame);
        }
        let status = self.emulator.wait().unwrap();
        assert!(status.success(), "{status}");
        std::mem::take(&mut self.record)
    }
}

impl Drop for Processor {
    fn drop(&mut self) {
        // It has ended already, or a test has failed and nobody needs it any more.
        let _ = self.emulator.kill();
        let _ = self.emulator.wait();
    }
}

impl Controller for Processor {
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64 {
        self.show(seen);
        let order = match self.periods {
            0 => Order::Refer,
            SETTLING => Order::Follow,
            RECORDED_FROM => Order::Record,
            _ => Order::None,
        };
        self.ask(wanted, order);
        self.serve();
        let follows = self.said.mode == Mode::Following as u8;
        assert_eq!(follows, self.periods >= SETTLING, "period {}: mode {}", self.periods, self.said.mode);
        if self.said.alarm > 0 && self.alarm.is_none() {
            self.alarm = Some((self.periods, self.said.alarm));
        }
        self.periods += 1;
        self.output.volts(0).expect("the output is up")
    }
}

/// Edges of the encoder since the reference.
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
