//! What is worth a second look, or another recording. Sentences for it are formed by `report`.

use diagnosis::agreement::Suspicion;
use model_core::machine::Source;
use recording::{Signal, Unit};

/// One piece of advice.
#[derive(Clone, Debug, PartialEq)]
pub enum Advice {
    /// A channel has one value in every row and cannot be judged.
    Constant {
        /// Its signal.
        signal: Signal,
        /// The unit in which people read the value.
        unit: Unit,
        /// The value, SI.
        value: f64,
    },
    /// A unit can hardly be right.
    Unit(UnitDoubt),
    /// A signal does not do what the machine file's model does with the recorded input.
    Agreement(Suspicion),
    /// A sensor is at an end of its range.
    RangeEnd {
        /// The signal.
        signal: Signal,
        /// What it reads there, SI.
        reading: f64,
        /// The share of the rows.
        share: f64,
    },
    /// The valve stays in its dead zone.
    NeverOpens {
        /// What its opening is read from.
        by: Signal,
    },
    /// The valve opens to one side.
    OpensOneWay {
        /// What its opening is read from.
        by: Signal,
        /// Which side.
        extending: bool,
    },
    /// The rod does not move by more than its sensor's noise.
    DoesNotMove,
    /// The rod moves one way.
    MovesOneWay,
    /// The rod covers little of its stroke.
    LittleTravel,
    /// The rod never holds long enough to show leakage and drift.
    NeverHolds {
        /// What moves the rod.
        source: Source,
        /// How long it would have to, s.
        least_s: f64,
    },
}

/// Why a unit can hardly be right for this drive.
#[derive(Clone, Debug, PartialEq)]
pub enum UnitDoubt {
    /// A current that a file means otherwise.
    Current {
        /// The column and what it opens.
        command: CommandRange,
        /// Where it is a current of 4 to 20 mA: the current in its middle, mA, at which such a valve is closed and by the file is not.
        closed_at_ma: Option<f64>,
    },
    /// The measured spool goes further or less far than the file says of a held command.
    SpoolTravel {
        /// The command's unit.
        unit: Unit,
        /// Measured travel over that of the file, 1.
        share: f64,
    },
    /// A channel reaches an impossible value.
    Beyond {
        /// The channel.
        signal: Signal,
        /// Its unit in the recording.
        unit: Unit,
        /// Its largest value, in that unit; of a position that goes below zero, its least.
        high: f64,
        /// What it passes.
        bound: Bound,
        /// The unit in which the value would be possible.
        fitting: Option<Unit>,
    },
    /// The rod's speed does not agree with the valve's opening.
    Speed {
        /// Measured speed over that of the opened valve without load, 1.
        share: f64,
        /// The unit of time with which it would agree, and the share with it.
        fitting: Option<(Unit, f64)>,
    },
    /// The constant load of the machine file is more than the cylinder can hold.
    Load {
        /// The load, N; positive extends.
        load_n: f64,
        /// Supply pressure times the area of the side that the load presses on, N.
        full_n: f64,
    },
}

/// A command, and how far the machine file says that it opens the valve.
#[derive(Clone, Debug, PartialEq)]
pub struct CommandRange {
    /// The column's header.
    pub header: String,
    /// The recording's unit.
    pub unit: Unit,
    /// Lowest value, in this unit.
    pub low: f64,
    /// Highest value, in this unit.
    pub high: f64,
    /// Opening at the highest, 1.
    pub opening: f64,
}

/// What a value passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// Beyond the stroke.
    Stroke,
    /// 1.5 times the supply pressure or more.
    FarAboveSupply,
    /// Less than a hundredth of the supply pressure.
    FarBelowSupply,
}
