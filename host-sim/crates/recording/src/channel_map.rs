//! Which column of a file holds which signal, where the header alone does not show it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::header::Offer;
use crate::linkage::Linkage;
use crate::signal::{Signal, split_header};
use crate::unit::Unit;

/// How the readings of a sensor become the signal's value in SI units: (reading − zero)/full.
///
/// Readings are taken as they stand in the file, in any unit, so that `zero` and `full` can be taken from a sensor's data
/// sheet: a spool that is centred at 5 V and fully open at 10 V has zero 5 and full 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The reading where the signal is 0.
    pub zero: f64,
    /// Rise of the reading for one SI unit of the signal; not 0, negative where the reading falls as the signal rises.
    pub full: f64,
}

/// One entry of a [`ChannelMap`].
#[derive(Clone, Debug, PartialEq)]
pub struct Mapping {
    /// The header of the column, with its unit in brackets: `Kolbenweg [mm]`.
    pub header: String,
    /// Whether a recording without this column is an error, or only noted.
    pub required: bool,
    /// How readings become values, where the unit in the header does not determine it.
    pub scale: Option<Scale>,
}

impl Mapping {
    /// A column that holds the signal in the unit of its header.
    #[must_use]
    pub fn column(header: impl Into<String>, required: bool) -> Self {
        Self { header: header.into(), required, scale: None }
    }
}

/// Known name → header text, from `--map "position=Kolbenweg [mm]"` or `[channels]` in the machine file.
///
/// A column whose header is a known name needs no entry. Where a signal has an entry and the mapped
/// column is in the file, the mapped column is used and not the one with the known name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelMap {
    entries: BTreeMap<Signal, Mapping>,
    /// Headers of columns that are not known by their names.
    unused: Vec<String>,
    /// The zero of all pressure sensors.
    pub pressure: PressureZero,
    /// The linkage through which the angle of the joint is a position of the rod, where it is known.
    pub linkage: Option<Arc<Linkage>>,
}

/// Where the pressure sensors of a drive read zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PressureZero {
    /// At the pressure of the air.
    #[default]
    Gauge,
    /// In a vacuum.
    Absolute,
    /// Not known.
    Unknown,
}

impl PressureZero {
    /// Its name in a machine file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            PressureZero::Gauge => "gauge",
            PressureZero::Absolute => "absolute",
            PressureZero::Unknown => "unknown",
        }
    }

    /// The zero of this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        [Self::Gauge, Self::Absolute, Self::Unknown].into_iter().find(|zero| zero.name() == name)
    }
}

/// Why a `--map` argument cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// The argument has no `=`.
    #[error("`{argument}` has no `=`; expected name=header, such as \"position=Kolbenweg [mm]\"")]
    NoEqualsSign {
        /// The argument.
        argument: String,
    },
    /// The part before `=` is not a known name.
    #[error("`{name}` is not a known signal; expected one of {known}; did you mean `{nearest}`?")]
    UnknownSignal {
        /// What was found.
        name: String,
        /// The known name most similar to it.
        nearest: &'static str,
        /// Every known name.
        known: String,
    },
    /// There is no name after `=`.
    #[error(
        "`{argument}` names no column; expected the header of a column after `=`. A column without a name cannot be mapped: such a one numbers the rows"
    )]
    NoHeader {
        /// The argument.
        argument: String,
    },
    /// The signal is mapped twice.
    #[error("`{signal}` is mapped to `{first}` and to `{second}`; expected one column for a signal")]
    Twice {
        /// The signal.
        signal: &'static str,
        /// The first header.
        first: String,
        /// The second header.
        second: String,
    },
}

impl ChannelMap {
    /// A map of `--map` arguments, each of the form `name=header`; their columns are required.
    pub fn from_arguments<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<Self, MapError> {
        let mut map = Self::default();
        for argument in arguments {
            let Some((name, header)) = argument.split_once('=') else {
                return Err(MapError::NoEqualsSign { argument: argument.to_owned() });
            };
            let signal = signal_named(name.trim())?;
            let header = header.trim().to_owned();
            if split_header(&header).0.is_empty() {
                return Err(MapError::NoHeader { argument: argument.to_owned() });
            }
            if let Some(first) = map.get(signal) {
                return Err(MapError::Twice { signal: signal.name(), first: first.header.clone(), second: header });
            }
            map.insert(signal, Mapping::column(header, true));
        }
        Ok(map)
    }

    /// Sets the column of a signal.
    pub fn insert(&mut self, signal: Signal, mapping: Mapping) {
        self.unused.retain(|header| !Offer::by_header(header).is_meant_by(&mapping));
        self.entries.insert(signal, mapping);
    }

    /// Leaves a column unused: no entry means it any longer, and its own name does not count.
    pub fn leave_unused(&mut self, header: &str) {
        let offer = Offer::by_header(header);
        self.entries.retain(|_, mapping| !offer.is_meant_by(mapping));
        if !self.unused.iter().any(|known| known == header) {
            self.unused.push(header.to_owned());
        }
    }

    /// The headers of columns that are not known by their names. An entry that means one of them counts all the same.
    #[must_use]
    pub fn unused(&self) -> &[String] {
        &self.unused
    }

    /// The column of a signal, where it is mapped.
    #[must_use]
    pub fn get(&self, signal: Signal) -> Option<&Mapping> {
        self.entries.get(&signal)
    }

    /// The unit in which the machine counts its command, V or mA, where the header of its column has one and no sensor's scale changes it.
    #[must_use]
    pub fn command_unit(&self) -> Option<Unit> {
        let mapping = self.get(Signal::Command).filter(|mapping| mapping.scale.is_none())?;
        let (_, unit) = split_header(&mapping.header);
        unit.and_then(Unit::parse).map(|unit| Unit::si(unit.dimension()))
    }

    /// This map without the entry of a signal.
    pub(crate) fn without(&self, signal: Signal) -> Self {
        let entries = self.entries.iter().filter(|(own, _)| **own != signal);
        Self { entries: entries.map(|(own, mapping)| (*own, mapping.clone())).collect(), ..self.clone() }
    }

    /// All entries.
    pub fn iter(&self) -> impl Iterator<Item = (Signal, &Mapping)> {
        self.entries.iter().map(|(&signal, mapping)| (signal, mapping))
    }

    /// Whether there are no entries.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// This map with the entries of another; where both have an entry, the other's counts: the command line overrides the machine file.
    #[must_use]
    pub fn overlaid_with(mut self, other: &Self) -> Self {
        for (signal, mapping) in other.iter() {
            self.insert(signal, mapping.clone());
        }
        for header in &other.unused {
            self.leave_unused(header);
        }
        self
    }
}

/// The signal of this name, or an error that suggests one.
fn signal_named(name: &str) -> Result<Signal, MapError> {
    Signal::parse(name).ok_or_else(|| MapError::UnknownSignal {
        name: name.to_owned(),
        nearest: nearest_signal(name),
        known: Signal::ALL.iter().map(|signal| signal.name()).collect::<Vec<_>>().join(" "),
    })
}

/// The name of the signal that is spelt most like this one.
pub fn nearest_signal(name: &str) -> &'static str {
    let alike = |signal: &&Signal| strsim::jaro_winkler(name, signal.name());
    let nearest = Signal::ALL.iter().max_by(|a, b| alike(a).total_cmp(&alike(b)));
    nearest.map_or("time", |signal| signal.name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_map_names_to_headers() {
        let map = ChannelMap::from_arguments(["position=Kolbenweg [mm]", "command = U=f(t) [V]"]).unwrap();
        assert_eq!(map.get(Signal::Position).unwrap().header, "Kolbenweg [mm]");
        assert_eq!(map.get(Signal::Command).unwrap().header, "U=f(t) [V]");
    }

    #[test]
    fn arguments_that_cannot_be_used_say_why() {
        let error = |argument| ChannelMap::from_arguments([argument]).unwrap_err();
        assert!(matches!(error("position"), MapError::NoEqualsSign { .. }));
        assert!(matches!(error("position="), MapError::NoHeader { .. }));
        assert!(matches!(error("time= [s]"), MapError::NoHeader { .. }), "the index that pandas writes");
        assert!(matches!(error("positon=x"), MapError::UnknownSignal { nearest: "position", .. }));
        let twice = ChannelMap::from_arguments(["spool=a", "spool=b"]).unwrap_err();
        assert!(matches!(twice, MapError::Twice { .. }));
    }

    #[test]
    fn a_column_is_either_mapped_or_unused() {
        let mut map = ChannelMap::from_arguments(["position=Kolbenweg", "spool=x"]).unwrap();
        map.leave_unused("Kolbenweg [mm]");
        assert_eq!((map.get(Signal::Position), map.unused()), (None, ["Kolbenweg [mm]".to_owned()].as_slice()));
        assert!(map.get(Signal::Spool).is_some());
        let mapped = map.overlaid_with(&ChannelMap::from_arguments(["position=Kolbenweg [mm]"]).unwrap());
        assert!(mapped.get(Signal::Position).is_some() && mapped.unused().is_empty(), "{mapped:?}");
    }

    #[test]
    fn the_command_line_goes_over_the_machine_file() {
        let mut file = ChannelMap::default();
        file.insert(Signal::Spool, Mapping::column("x", false));
        file.insert(Signal::Flow, Mapping::column("Q", false));
        let both = file.overlaid_with(&ChannelMap::from_arguments(["spool=y"]).unwrap());
        assert_eq!(both.get(Signal::Spool).unwrap().header, "y");
        assert_eq!(both.get(Signal::Flow).unwrap().header, "Q");
    }
}
