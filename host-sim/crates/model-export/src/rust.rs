//! A drive as constants for the firmware: Rust source that a controller compiles in, or a C99 header.
//!
//! It holds SI values and no coefficients: the core computes its fixed-point coefficients from them on the controller as it does here,
//! so that only one place converts. All effects of the machine file are included.

use std::fmt::{self, Write};

use model_core::drive::{Drive, DriveState};
use model_core::machine::{Machine, MachineError, Parameter, Source, Tick};
use model_core::number::{PerUnit, Scalar, Single, Written};
use simulation::DELAY_LINE;

use crate::literal::Literal;

/// What a controller needs to know about a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants {
    /// What the drive is called.
    pub name: String,
    /// The drive.
    pub machine: Machine<f64>,
    /// Control period.
    pub tick: Tick,
    /// Ticks of the shortest delay line that holds the drive's transport delays: a power of two.
    pub delay_line: usize,
}

/// A number type in which a drive can be baked.
pub trait BakedNumber: Scalar<Real = f64> + Written {
    /// Its path.
    const PATH: &'static str;
}

impl BakedNumber for PerUnit {
    const PATH: &'static str = "model_core::number::PerUnit";
}

impl BakedNumber for Single {
    const PATH: &'static str = "model_core::number::Single";
}

type Builder = fn(&Machine<f64>, Tick) -> Result<Drive<PerUnit>, MachineError>;
/// Delay lines that are shorter than the simulation's, shortest first.
const SHORTER: [(usize, Builder); 6] = [
    (8, Drive::new::<8>),
    (16, Drive::new::<16>),
    (32, Drive::new::<32>),
    (64, Drive::new::<64>),
    (128, Drive::new::<128>),
    (256, Drive::new::<256>),
];

impl Constants {
    /// The constants of a drive.
    ///
    /// # Errors
    /// The controller's arithmetic cannot represent the drive at this tick; the error names the value that does not fit.
    pub fn of(name: &str, machine: &Machine<f64>, tick: Tick) -> Result<Self, MachineError> {
        Drive::<PerUnit>::new::<DELAY_LINE>(machine, tick)?;
        let fits = SHORTER.iter().find(|(_, drive)| drive(machine, tick).is_ok());
        let delay_line = fits.map_or(DELAY_LINE, |(ticks, _)| *ticks);
        Ok(Self { name: name.to_owned(), machine: *machine, tick, delay_line })
    }

    /// Rust source.
    #[must_use]
    pub fn rust(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write_rust(&mut text);
        text
    }

    /// Rust source with the coefficients of a number type: what [`Constants::rust`] gives, and a type that has them as constants.
    ///
    /// # Errors
    /// The number type cannot represent the drive; [`Constants::of`] refuses what fixed point cannot.
    pub fn baked<N: BakedNumber>(&self) -> Result<String, MachineError> {
        let baked = self.coefficients::<N>()?;
        let mut text = self.rust();
        // Writing to a string cannot fail.
        let _ = baked.write(&mut text);
        Ok(text)
    }

    /// The coefficients.
    pub(crate) fn coefficients<N: BakedNumber>(&self) -> Result<Coefficients<N>, MachineError> {
        let drive = Drive::<N>::new::<DELAY_LINE>(&self.machine, self.tick)?;
        let literal = Literal::of(&drive).expect("coefficients are numbers, choices and groups of them");
        let mut crc = flate2::Crc::new();
        crc.update(literal.expression.as_bytes());
        crc.update(&(self.delay_line as u64).to_le_bytes());
        let shortest = SHORTER[0].0;
        let lines = 2 * size_of::<N>() * (self.delay_line - shortest);
        let state_bytes = size_of::<DriveState<N, { SHORTER[0].0 }>>() + lines;
        Ok(Coefficients { drive, literal, fingerprint: crc.sum(), state_bytes })
    }

    fn write_rust(&self, out: &mut impl Write) -> fmt::Result {
        let source = match self.machine.source {
            Source::Valve => "Valve",
            Source::Pump => "Pump",
            Source::Force => "Force",
        };
        let tick = match self.tick {
            Tick::HalfMillisecond => "HalfMillisecond",
            Tick::OneMillisecond => "OneMillisecond",
            Tick::TwoMilliseconds => "TwoMilliseconds",
        };
        writeln!(
            out,
            "// Constants of a drive, written by `host-sim export`: change the machine file and export again.\n"
        )?;
        writeln!(out, "use model_core::machine::{{Parameter, Source, Tick}};\n")?;
        writeln!(out, "/// What the drive is called.\npub const NAME: &str = {:?};", self.name)?;
        writeln!(out, "/// Where its oil comes from.\npub const SOURCE: Source = Source::{source};")?;
        writeln!(out, "/// Control period that the values were checked for.\npub const TICK: Tick = Tick::{tick};")?;
        writeln!(
            out,
            "/// Ticks of the shortest delay line that holds its delays.\npub const DELAY_LINE: usize = {};",
            self.delay_line
        )?;
        writeln!(out, "/// Every value that is not the default, SI.\n#[rustfmt::skip]")?;
        writeln!(out, "#[allow(clippy::unreadable_literal, reason = \"every digit of an exported value counts\")]")?;
        writeln!(out, "pub const VALUES: &[(Parameter, f64)] = &[")?;
        let default = Machine::with_defaults(self.machine.source);
        for &parameter in Parameter::ALL {
            let value = self.machine.get(parameter);
            if value.to_bits() != default.get(parameter).to_bits() {
                // Written so that Rust reads them back bit for bit.
                writeln!(out, "    (Parameter::{parameter:?}, {value:?}), // {}", parameter.description().key)?;
            }
        }
        writeln!(out, "];")
    }
}

/// A drive's coefficients, and what tells them from those of another.
pub(crate) struct Coefficients<N: BakedNumber> {
    pub(crate) drive: Drive<N>,
    literal: Literal,
    pub(crate) fingerprint: u32,
    /// Of a state with its delay lines.
    pub(crate) state_bytes: usize,
}

impl<N: BakedNumber> Coefficients<N> {
    /// The type that has them as constants.
    fn write(&self, out: &mut impl Write) -> fmt::Result {
        let Literal { expression, types, .. } = &self.literal;
        let types = types.iter().copied().collect::<Vec<_>>().join(", ");
        let expression = expression.replace('\n', "\n        ");
        writeln!(out, "\n/// CRC-32 of the coefficients, which tells them from those of any other drive.")?;
        let [upper, lower] = [self.fingerprint >> 16, self.fingerprint & 0xffff];
        writeln!(out, "pub const FINGERPRINT: u32 = 0x{upper:04x}_{lower:04x};")?;
        writeln!(
            out,
            "/// Bytes of a state with its delay lines.\npub const STATE_BYTES: usize = {};",
            self.state_bytes
        )?;
        writeln!(out, "\n/// The drive with its coefficients as constants: see `model_core::drive::Baked`.")?;
        writeln!(out, "#[derive(Clone, Copy, Debug, PartialEq, Eq)]\npub struct Exported;\n")?;
        writeln!(out, "#[rustfmt::skip]")?;
        writeln!(out, "#[allow(clippy::unreadable_literal, reason = \"every digit of a coefficient counts\")]")?;
        writeln!(out, "impl model_core::drive::Baked for Exported {{")?;
        writeln!(out, "    type Number = {};", N::PATH)?;
        writeln!(out, "    const DRIVE: &'static model_core::drive::Drive<Self::Number> = {{")?;
        writeln!(out, "        use model_core::literal::{{{types}}};\n        &{expression}\n    }};\n}}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_not_the_default_is_written_and_reads_back_to_the_last_bit() {
        let mut machine = test_press::press(&[(Parameter::InternalLeakage, 1.0 / 3e11)]);
        machine.set(Parameter::TransportDelay, 0.0071);
        let constants = Constants::of("press \"63-40\"", &machine, Tick::OneMillisecond).unwrap();
        // A delay of 7.1 ticks lies between the values seven and eight ticks ago, and the line holds the present value as well.
        assert_eq!(constants.delay_line, 16);
        let text = constants.rust();
        assert!(text.contains("pub const NAME: &str = \"press \\\"63-40\\\"\";"), "{text}");
        let values: Vec<(Parameter, f64)> = text
            .lines()
            .filter_map(|line| line.trim().strip_prefix("(Parameter::")?.split_once("), // "))
            .map(|(pair, key)| {
                let (name, value) = pair.split_once(", ").unwrap();
                let mut all = Parameter::ALL.iter().copied();
                let parameter = all.find(|parameter| format!("{parameter:?}") == name).unwrap();
                assert_eq!(parameter.description().key, key);
                (parameter, value.parse().unwrap())
            })
            .collect();
        assert_eq!(Machine::with_defaults(Source::Valve).with(&values), machine);
        assert!(values.iter().all(|(parameter, _)| *parameter != Parameter::StopStiffness));
    }

    #[test]
    fn a_baked_drive_says_how_large_its_state_is_and_what_it_is_made_of_in_both_number_types() {
        fn baked<N: BakedNumber>(constants: &Constants, state_bytes: usize) -> u32 {
            let coefficients = constants.coefficients::<N>().unwrap();
            assert_eq!(coefficients.state_bytes, state_bytes, "{}", N::PATH);
            let text = constants.baked::<N>().unwrap();
            assert!(text.contains(&format!("type Number = {};", N::PATH)), "{text}");
            assert!(text.contains(&format!("pub const STATE_BYTES: usize = {state_bytes};")), "{text}");
            coefficients.fingerprint
        }
        let machine = test_press::press(&[(Parameter::TransportDelay, 0.0071)]);
        let constants = Constants::of("late", &machine, Tick::OneMillisecond).unwrap();
        assert_eq!(constants.delay_line, 16);
        let fixed = baked::<PerUnit>(&constants, size_of::<DriveState<PerUnit, 16>>());
        let single = baked::<Single>(&constants, size_of::<DriveState<Single, 16>>());
        assert_ne!(fixed, single);
    }

    #[test]
    fn a_drive_that_the_controller_cannot_hold_is_refused_by_name() {
        let machine = test_press::press(&[(Parameter::TransportDelay, 0.9)]);
        let refused = Constants::of("late", &machine, Tick::OneMillisecond).unwrap_err();
        assert!(refused.to_string().starts_with("valve.transport_delay_s = 0.9 s: needs"), "{refused}");
    }
}
