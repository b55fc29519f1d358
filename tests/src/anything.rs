//! Everything that may get any input, each as one function of bytes: `fuzz/` looks for bytes that break one, and `tests/anything`
//! repeats those that were kept.
//!
//! Each panics where something is wrong: where the code that it calls panics or overflows, and where the result breaks a promise.

use serde::de::DeserializeOwned;

use firmware::recorder::frame::{FrameWriter, PAYLOAD};
use host_sim::frames;
use machine_file::MachineFile;
use model_core::control::{Follower, Tuning};
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, Parameter, Source, Tick};
use model_core::number::{Number, PerUnit, Scalar, Single};
use model_core::ports::{Flows, Spool};
use recording::files::source_error::{Explained, render};
use recording::{ChannelMap, Mapping, Recording, RecordingError, Scale, Signal, StaticTable};

use crate::drives;
use crate::simulate::DELAY;

/// A name, and the function that takes the bytes.
pub type Target = (&'static str, fn(&[u8]));

/// All of them. The folders of `fuzz/corpus` and the programs of `fuzz/` have these names.
pub const TARGETS: [Target; 12] = [
    ("csv", csv),
    ("twincat", recording),
    ("mat", recording),
    ("mdf4", recording),
    ("parquet", recording),
    ("xlsx", recording),
    ("machine_file", machine_file),
    ("frames", frames),
    ("coefficients", coefficients),
    ("step_fixed", step::<PerUnit>),
    ("step_float", step::<f64>),
    ("step_single", step::<Single>),
];

/// Runs the target of this name.
///
/// # Panics
/// No target has this name.
pub fn feed(target: &str, bytes: &[u8]) {
    let known = TARGETS.iter().find(|(name, _)| *name == target);
    known.unwrap_or_else(|| panic!("no target {target}")).1(bytes);
}

/// A recording in whatever format its first bytes show: an explained error, or rising times and finite numbers.
pub fn recording(bytes: &[u8]) {
    let mut mapped = ChannelMap::default();
    mapped.insert(Signal::Position, Mapping::column("x [mm]", false));
    mapped
        .insert(Signal::Spool, Mapping { scale: Some(Scale { zero: 5.0, full: -5.0 }), ..Mapping::column("s", false) });
    for map in [ChannelMap::default(), mapped] {
        match recording::read_from("run", bytes, &map) {
            Ok(recording) => check(&recording),
            Err(error) => explained(&error),
        }
    }
}

/// Text, as a recording and as a table without a clock.
fn csv(bytes: &[u8]) {
    recording(bytes);
    match StaticTable::read_from("run", bytes) {
        Ok(table) => {
            let finite = |(_, values): &(String, Vec<f64>)| values.iter().all(|value| value.is_finite());
            assert!(table.columns().iter().all(finite), "a number that is none");
        }
        Err(error) => explained(&error),
    }
}

fn check(recording: &Recording) {
    let rows = recording.rows();
    assert!(rows >= 2 && recording.time_s().windows(2).all(|pair| pair[0] < pair[1]), "times that do not rise");
    for column in recording.columns() {
        assert_eq!(column.values.len(), rows, "{}", column.header);
        let odd = column.values.iter().find(|value| !value.is_finite());
        assert_eq!(odd, None, "{}", column.header);
    }
    for note in recording.notes() {
        let _ = note.to_string();
    }
}

fn explained(error: &impl Explained) {
    let told = render(error);
    assert!(told.starts_with("error: ") && told.contains("expected"), "{told}");
    let _ = error.to_string();
}

/// A machine file: an explained error, or a machine that is the same after it is written and read again, and becomes a drive or an error.
///
/// # Panics
/// It is none of these.
pub fn machine_file(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let file = match machine_file::read_text("machine.toml", text) {
        Ok(file) => file,
        Err(error) => return explained(&error),
    };
    match file.to_text("machine.toml") {
        Ok(text) => {
            let again =
                machine_file::read_text("machine.toml", &text).unwrap_or_else(|error| panic!("{error}:\n{text}"));
            assert_eq!(bits(&again), bits(&file), "{text}");
        }
        Err(error) => explained(&error),
    }
    drive_of(&file.machine, Tick::OneMillisecond);
}

fn bits(file: &MachineFile) -> Vec<u64> {
    Parameter::ALL.iter().map(|&parameter| file.machine.get(parameter).to_bits()).collect()
}

/// Bytes from a serial line: as they are, and as the payloads of whole frames, because random bytes never have a correct checksum.
///
/// # Panics
/// The imported text cannot be read.
pub fn frames(bytes: &[u8]) {
    stream(bytes);
    let mut rest = bytes;
    let (mut line, mut writer) = (Vec::new(), FrameWriter::default());
    while let Some((&[kind, length], after)) = rest.split_first_chunk::<2>() {
        let (payload, after) = after.split_at(usize::from(length).min(after.len()).min(PAYLOAD));
        writer.write(&mut line, kind, payload).unwrap_or_else(|error| panic!("{error}"));
        rest = after;
    }
    stream(&line);
}

/// An imported stream is a CSV in which every row reads; only its names and numbers may be wrong.
fn stream(bytes: &[u8]) {
    let Ok(stream) = frames::stream(bytes) else { return };
    for imported in stream.recordings {
        let _ = imported.rows_lost();
        let Ok(csv) = imported.csv() else { continue };
        match recording::read_from("taken.csv", csv.as_bytes(), &ChannelMap::default()) {
            Ok(recording) => check(&recording),
            Err(
                error @ (RecordingError::RaggedRow { .. }
                | RecordingError::OpenQuote { .. }
                | RecordingError::NotANumber { .. }
                | RecordingError::ControlCharacter { .. }
                | RecordingError::NotUtf8 { .. }
                | RecordingError::NotFinite { .. }
                | RecordingError::TimeBackwards { .. }),
            ) => panic!("{error}\n{csv}"),
            Err(error) => explained(&error),
        }
    }
}

/// Any parameters: an error, or coefficients that three ticks can be computed with.
pub fn coefficients(bytes: &[u8]) {
    let mut words = Words(bytes);
    let (machine, tick) = words.machine();
    drive_of(&machine, tick);
}

fn drive_of(machine: &Machine<f64>, tick: Tick) {
    fn some_ticks<N: Scalar<Real = f64>>(machine: &Machine<f64>, tick: Tick) {
        let Ok(drive) = Drive::<N>::new::<DELAY>(machine, tick) else { return };
        let mut state: DriveState<N, DELAY> = drive.at_rest(
            N::saturated(0.1),
            model_core::ports::ChamberState { a: N::saturated(0.4), b: N::saturated(0.6) },
            N::travel(0.5),
        );
        for drive_input in [
            DriveInput::Command(N::saturated(0.5)),
            DriveInput::Spool(Spool { from: N::ZERO, to: N::saturated(-1.0) }),
            DriveInput::Pump(PumpDrive { speed: N::saturated(0.7), direction: -1 }),
        ] {
            drive.step(&mut state, drive_input, Load::NONE);
            let _ = drive.sensed(&state);
        }
    }
    some_ticks::<PerUnit>(machine, tick);
    some_ticks::<f64>(machine, tick);
    some_ticks::<Single>(machine, tick);
    // The controller's rules divide by values that a machine may not have.
    if machine.check().is_ok() {
        let _ = Follower::<PerUnit>::new(machine, &Tuning::by_rule(machine, true), tick);
    }
}

/// Any machine, any state, any inputs, also stored states that no run leads to.
///
/// # Panics
/// A number type that promises to stay finite does not.
pub fn step<N>(bytes: &[u8])
where
    N: Word + DeserializeOwned,
    N::Travel: DeserializeOwned,
{
    let mut words = Words(bytes);
    let (machine, tick) = words.machine();
    let Ok(drive) = Drive::<N>::new::<DELAY>(&machine, tick) else { return };
    let Ok((mut state, rest)) = postcard::take_from_bytes::<DriveState<N, DELAY>>(words.0) else { return };
    let mut words = Words(rest);
    for _ in 0..64 {
        let Some(drive_input) = words.drive_input() else { break };
        let load = Load { from: words.word(), to: words.word() };
        drive.step(&mut state, drive_input, load);
        let sensed = drive.sensed(&state);
        if N::STAYS_FINITE {
            let text = format!("{state:?} {sensed:?}");
            assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        }
    }
}

/// A number type in which any bits are a number.
pub trait Word: Number<Real = f64> {
    /// Whether it has NaN and infinities, and promises that none arises.
    const STAYS_FINITE: bool = false;

    /// The number of these bits.
    fn any(bits: u64) -> Self;
}

impl Word for PerUnit {
    #[expect(clippy::cast_possible_truncation, reason = "the lower half is the word")]
    fn any(bits: u64) -> Self {
        PerUnit::from_bits((bits as u32).cast_signed())
    }
}

impl Word for Single {
    const STAYS_FINITE: bool = true;

    #[expect(clippy::cast_possible_truncation, reason = "the lower half is the word")]
    fn any(bits: u64) -> Self {
        Single::new(f32::from_bits(bits as u32))
    }
}

impl Word for f64 {
    fn any(bits: u64) -> Self {
        f64::from_bits(bits)
    }
}

/// Bytes that are used up from the front; after their end only zeros follow.
struct Words<'a>(&'a [u8]);

impl Words<'_> {
    fn byte(&mut self) -> u8 {
        let (&byte, rest) = self.0.split_first().unwrap_or((&0, &[]));
        self.0 = rest;
        byte
    }

    fn bits(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    fn word<N: Word>(&mut self) -> N {
        N::any(self.bits())
    }

    /// The press or a pump drive, or the mass of either moved by a force, with up to 255 changes of parameters: each to an end of its range, a share of the range, a multiple of
    /// its value, or anything.
    fn machine(&mut self) -> (Machine<f64>, Tick) {
        let kind = self.byte();
        let mut machine = if kind & 1 == 0 { drives::press() } else { drives::pump() };
        machine.source = match kind {
            0b1010_0000..0b1100_0000 => Source::Force,
            _ if kind & 1 == 0 => Source::Valve,
            _ => Source::Pump,
        };
        let tick = match kind >> 1 & 3 {
            0 | 3 => Tick::OneMillisecond,
            1 => Tick::HalfMillisecond,
            _ => Tick::TwoMilliseconds,
        };
        for _ in 0..self.byte() {
            let parameter = Parameter::ALL[usize::from(self.byte()) % Parameter::COUNT];
            let what = parameter.description();
            let value = match self.byte() % 5 {
                0 => what.min,
                1 => what.max,
                2 => what.min + (what.max.min(1e12) - what.min) * f64::from(self.byte()) / 255.0,
                3 => machine.get(parameter) * (f64::from(self.byte().cast_signed()) / 8.0).exp2(),
                _ => f64::from_bits(self.bits()),
            };
            let whole = if parameter.is_whole() { value.floor() } else { value };
            machine.set(parameter, whole);
        }
        (machine, tick)
    }

    fn drive_input<N: Word>(&mut self) -> Option<DriveInput<N>> {
        if self.0.is_empty() {
            return None;
        }
        Some(match self.byte() % 6 {
            0 => DriveInput::Command(self.word()),
            1 => DriveInput::Spool(Spool { from: self.word(), to: self.word() }),
            2 => DriveInput::Followed { command: self.word(), spool: Spool { from: self.word(), to: self.word() } },
            3 => DriveInput::Pump(PumpDrive { direction: self.byte().cast_signed(), speed: self.word() }),
            4 => DriveInput::Flow {
                from: Flows { a: self.word(), b: self.word() },
                to: Flows { a: self.word(), b: self.word() },
            },
            _ => DriveInput::Force { from: self.word(), to: self.word() },
        })
    }
}
