//! Concealed cases: drives at random, with effects that their machine files do not contain.
//!
//! A [`Lot`] specifies what is drawn; case `index` of it does not depend on which other cases are drawn. Each case is a drive of its own
//! with a machine file that differs from the truth as its `[fit.sigma]` states, two to four recordings for training and two
//! held out, and the truth. If the sensors could not show an effect, the case is drawn again.

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
    /// An effect outside the vocabulary.
    Outside,
    /// Some of each kind, most of them single effects.
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
    /// Names to choose from; if empty, all of [`VOCABULARY`], and all of [`OUTSIDE`] where effects outside the vocabulary are drawn.
    pub only: Vec<String>,
    /// Whether the oil's temperature is recorded. If so, each recording is made in warmer oil than the one before, and `oil-temperature` is
    /// oil whose viscosity falls with this temperature, not oil that warms up during a recording.
    pub thermometer: bool,
}

/// The effects that are drawn by default: those that differ from one another in more than their name.
/// (`hose-compliance` is a softer oil and a larger volume, `pump-slip` needs another kind of drive, `cavitation` a heavier load; these and
/// `laminar-transition` can be requested.)
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

/// Effects that can be requested in addition to [`VOCABULARY`].
pub const ON_REQUEST: [&str; 5] = ["hose-compliance", "laminar-transition", PUMP_SLIP, CAVITATION, "counterbalance"];

/// The effect that makes the case a pump-controlled drive.
const PUMP_SLIP: &str = "pump-slip";
/// The effect that needs a load heavy enough to pull the rod on.
const CAVITATION: &str = "cavitation";

/// The effects outside the vocabulary that are drawn.
pub const OUTSIDE: [&str; 3] = ["~external-disturbance", "~pump-ripple", "~structural-flexibility"];

/// Which channels a case records in addition to the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Channels {
    Position,
    Spool,
    Pressures,
    /// Everything, including the supply pressure.
    Full,
    /// In a pump drive: its speed and direction, pressures, position.
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
    /// Its name, which is also the name of its folder.
    pub id: String,
    /// Nominal values.
    pub file: MachineFile,
    /// File names and contents; the held-out recordings come last.
    pub recordings: Vec<(String, SyntheticRecording)>,
    /// The concealed effects.
    pub truth: CaseTruth,
}
