//! A recording judged by the band of a healthy drive.

use firmware::monitor::{Innovation, Link, Miss, Monitor, MonitoredSignal, SIGNALS, Sensitivity, Spread};
use machine_file::{Band, MachineFile};
use model_core::machine::{Bases, Tick};
use model_core::number::{Number, PerUnit};
use recording::{Recording, Signal};
use simulation::tick_for;

use crate::error::WatchError;
use crate::innovation::{Innovations, base, bases, column};

/// Share of the recordings of a healthy drive that may be told by chance, unless another is asked for.
pub const FALSE_ALARMS: f64 = 1e-3;

/// What the monitor says of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Watched {
    /// The recording.
    pub recording: String,
    /// Its length, s.
    pub duration_s: f64,
    /// The signals that were judged, in the chain's order.
    pub signals: Vec<Seen>,
    /// Where the drive left its band first; `None` where it did not.
    pub left: Option<Left>,
}

/// What the monitor saw of one signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// The signal.
    pub signal: Signal,
    /// The largest average of the innovation's square over that of the healthy drive; at most 32.
    pub square: f64,
    /// Where it was that large, s.
    pub at_s: f64,
    /// The alarm's limit.
    pub limit: f64,
}

/// The first signal beyond its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// The signal.
    pub signal: Signal,
    /// The link whose model is wrong.
    pub link: Link,
    /// When, s.
    pub at_s: f64,
    /// Recorded less simulated there, SI.
    pub off_by: f64,
}

/// Judges a recording by the band of its drive's machine file. Of the recordings of a healthy drive the share `false_alarms` may be told by chance, or less:
/// the limit is on the safe side.
///
/// # Errors
/// The file has no band, the recording has none of its signals or cannot be compared with the machine, or so few false alarms cannot be told from chance
/// within the band's memory.
pub fn watch(
    file: &MachineFile,
    recording: &Recording,
    tick: Option<Tick>,
    false_alarms: f64,
) -> Result<Watched, WatchError> {
    let band = file.band.as_ref().ok_or(WatchError::NoBand)?;
    let tick = tick.unwrap_or_else(|| tick_for(recording, &file.machine));
    Watched::of(band, &Innovations::of(file, recording, tick)?, &bases(file, tick)?, false_alarms)
}

impl Watched {
    /// The same of innovations.
    pub(crate) fn of(
        band: &Band,
        innovations: &Innovations,
        bases: &Bases,
        false_alarms: f64,
    ) -> Result<Self, WatchError> {
        let recording = || innovations.recording.clone();
        let spreads = spreads(band);
        let is_judged = std::array::from_fn(|k| spreads[k].is_some() && innovations.values[k].is_some());
        if is_judged == [false; SIGNALS] {
            let of_band = MonitoredSignal::ALL.into_iter().zip(spreads).filter(|(_, spread)| spread.is_some());
            let expected = of_band.map(|(signal, _)| column(signal).name()).collect::<Vec<_>>().join(", ");
            return Err(WatchError::NothingWatched { recording: recording(), expected });
        }
        let duration_s = innovations.period_s * innovations.time_s.len() as f64;
        let sensitivity = sensitivity(band, bases, duration_s / false_alarms);
        let monitor = Monitor::with_period(&sensitivity, bases, innovations.period_s)
            .map_err(|cause| WatchError::Monitor { recording: recording(), cause })?;
        Ok(run(&monitor, innovations, is_judged, bases, duration_s))
    }
}

/// The spread of each monitored signal.
fn spreads(band: &Band) -> [Option<machine_file::Spread>; SIGNALS] {
    [band.spool, band.pressure, band.pressure, band.position]
}

/// The monitor's settings. What the band does not have is never looked at: its spread is any that the monitor takes.
fn sensitivity(band: &Band, bases: &Bases, between_false_alarms_s: f64) -> Sensitivity {
    let spread = |of: Option<machine_file::Spread>, base: f64| {
        of.map_or(Spread { sigma: 0.5 * base, correlation_s: 0.0 }, |machine_file::Spread { sigma, correlation_s }| {
            Spread { sigma, correlation_s }
        })
    };
    Sensitivity {
        spool: spread(band.spool, 1.0),
        pressure: spread(band.pressure, bases.pressure_pa),
        position: spread(band.position, bases.stroke_m),
        memory_s: band.memory_s,
        between_false_alarms_s,
    }
}

/// The monitor over every row.
fn run(
    monitor: &Monitor,
    innovations: &Innovations,
    is_judged: [bool; SIGNALS],
    bases: &Bases,
    duration_s: f64,
) -> Watched {
    let limits = monitor.limits();
    let mut seen: [Option<Seen>; SIGNALS] = std::array::from_fn(|k| {
        let signal = column(MonitoredSignal::ALL[k]);
        is_judged[k].then_some(Seen { signal, square: 0.0, at_s: innovations.time_s[0], limit: limits[k] })
    });
    let mut state = monitor.at_rest();
    let mut left = None;
    for (row, &at_s) in innovations.time_s.iter().enumerate() {
        let value = |k: usize| {
            let value_si = innovations.values[k].as_ref().filter(|_| is_judged[k])?[row]?;
            Some(PerUnit::saturated(value_si / base(MonitoredSignal::ALL[k], bases)))
        };
        let missed = monitor.watch(&mut state, &Innovation::new(std::array::from_fn(value)));
        for (seen, square) in seen.iter_mut().zip(state.squares()) {
            if let Some(seen) = seen.as_mut().filter(|seen| square > seen.square) {
                (seen.square, seen.at_s) = (square, at_s);
            }
        }
        left = left.or(missed.map(|Miss { signal, link, innovation, .. }| Left {
            signal: column(signal),
            link,
            at_s,
            off_by: innovation.to_f64() * base(signal, bases),
        }));
    }
    Watched {
        recording: innovations.recording.clone(),
        duration_s,
        signals: seen.into_iter().flatten().collect(),
        left,
    }
}
