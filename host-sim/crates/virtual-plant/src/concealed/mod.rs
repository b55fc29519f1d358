//! Concealed cases: drives at random, with effects that their machine files know nothing of.
//!
//! A [`Lot`] says what is drawn; case `index` of it is the same whatever else is drawn. Each case is a drive of its own
//! with a machine file that is off the truth by what its `[fit.sigma]` says, two to four recordings to train on and two
//! held out, and the truth. An effect that its sensors could not show is drawn again.

mod bench;
mod case;
mod drive;
mod signals;
mod strength;
mod truth;
mod visibility;

use machine_file::MachineFile;

use crate::rig::recorded::SyntheticRecording;

pub use case::draw;
pub use truth::{CaseTruth, to_json};

/// What is concealed in the cases of a lot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Concealed {
    /// Nothing.
    None,
    /// One effect each.
    Single,
    /// Two effects each.
    Pair,
    /// Something outside the vocabulary.
    Outside,
    /// Of all of them some, most of them single.
    Mixed,
}

/// What is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Lot {
    /// The same seed draws the same cases.
    pub seed: u64,
    /// What is concealed.
    pub concealed: Concealed,
    /// Whether nominal values are rough and recordings poor.
    pub hard: bool,
    /// Names to choose from; without any, all of [`VOCABULARY`], and of [`OUTSIDE`] where that is asked for.
    pub only: Vec<String>,
    /// Whether the oil's temperature is recorded: each recording is made in warmer oil than the one before, and `oil-temperature` is
    /// oil that thins by it, not oil that warms in the course of a recording.
    pub thermometer: bool,
}

/// The effects that are drawn without being asked for: those that differ in more than name from another one.
/// (`hose-compliance` is a softer oil and a larger volume, `pump-slip` makes another kind of drive, `cavitation` a heavier one; these and
/// `laminar-transition` can be asked for.)
pub const VOCABULARY: [&str; 27] = [
    "valve-hysteresis",
    "spool-stiction",
    "null-drift",
    "solenoid-saturation",
    "flow-force",
    "dead-zone-asymmetry",
    "flow-gain-nonlinearity",
    "metering-asymmetry",
    "supply-droop",
    "tank-back-pressure",
    "valve-leakage",
    "internal-leakage",
    "external-leakage",
    "entrained-air",
    "position-dependent-volume",
    "coulomb-friction",
    "stribeck-friction",
    "friction-asymmetry",
    "position-dependent-friction",
    "pressure-dependent-friction",
    "position-dependent-load",
    "end-stop",
    "presliding",
    "linkage-backlash",
    "position-sensor-lag",
    "sensor-offset",
    "oil-temperature",
];

/// What can be asked for beside [`VOCABULARY`].
pub const ON_REQUEST: [&str; 4] = ["hose-compliance", "laminar-transition", PUMP_SLIP, CAVITATION];

/// The one that makes a pump-controlled drive of the case.
const PUMP_SLIP: &str = "pump-slip";
/// The one that needs a load heavy enough to draw the rod on.
const CAVITATION: &str = "cavitation";

/// What is drawn from outside the vocabulary.
pub const OUTSIDE: [&str; 3] = ["~external-disturbance", "~pump-ripple", "~structural-flexibility"];

/// Which channels a case records beside the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channels {
    Position,
    Spool,
    Pressures,
    /// Everything, the supply pressure too.
    Full,
    /// Of a pump drive: its speed and direction, pressures, position.
    Pump,
}

impl Channels {
    fn name(self) -> &'static str {
        match self {
            Self::Position => "uy",
            Self::Spool => "uxy",
            Self::Pressures => "uxpy",
            Self::Full => "full",
            Self::Pump => "upy",
        }
    }

    /// Spool, position, pressure in A and in B.
    fn recorded(self) -> [bool; 4] {
        let pressures = matches!(self, Self::Pressures | Self::Full | Self::Pump);
        [!matches!(self, Self::Position | Self::Pump), true, pressures, pressures]
    }
}

/// How the drive is commanded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    Open,
    Dither,
    Closed,
    /// Speed and direction of a pump, open loop.
    Pump,
}

impl Mode {
    fn name(self) -> &'static str {
        match self {
            Self::Open | Self::Pump => "open",
            Self::Dither => "dither",
            Self::Closed => "closed",
        }
    }
}

/// A drawn case.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Its name, which is its folder's.
    pub id: String,
    /// Nominal values.
    pub file: MachineFile,
    /// File names and what is in them; the held-out ones last.
    pub recordings: Vec<(String, SyntheticRecording)>,
    /// What is concealed.
    pub truth: CaseTruth,
}

#[cfg(test)]
mod tests;
