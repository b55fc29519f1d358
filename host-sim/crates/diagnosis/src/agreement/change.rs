//! Changes that are tried: of a recording, as though a channel had been connected or scaled otherwise, and of the cylinder that it is taken for.

use model_core::machine::{Machine, Parameter};
use recording::{Column, Recording, Signal};
use simulation::signal::noise::extent;

/// A change of what was recorded, or of what the machine file says of the cylinder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// This signal with the other sign; a position counts from the other end.
    Reversed(Signal),
    /// The valve with its ports A and B exchanged: what opens it to extend, retracts.
    PortsExchanged,
    /// The pressures of A and B exchanged.
    PressuresExchanged,
    /// This signal so many times as large; both pressures, where it is one of them.
    Scaled(Signal, f64),
    /// This signal larger by so much, SI.
    Moved(Signal, f64),
    /// This signal so many seconds earlier than its stamps say.
    Earlier(Signal, f64),
    /// A cylinder with another bore and rod.
    Cylinder {
        /// mm.
        bore_mm: f64,
        /// mm.
        rod_mm: f64,
    },
}

impl Change {
    /// The signals that it replaces.
    pub(super) fn signals(self) -> &'static [Signal] {
        use Signal as S;
        const PRESSURES: &[Signal] = &[S::PressureA, S::PressureB];
        match self {
            Self::PortsExchanged => &[S::Command, S::Spool],
            Self::Cylinder { .. } => &[],
            Self::PressuresExchanged | Self::Scaled(S::PressureA | S::PressureB, _) => PRESSURES,
            Self::Reversed(signal) | Self::Scaled(signal, _) | Self::Moved(signal, _) | Self::Earlier(signal, _) => {
                let at = Signal::ALL.iter().position(|known| *known == signal).unwrap_or_default();
                &Signal::ALL[at..=at]
            }
        }
    }

    /// The recording with it.
    #[must_use]
    pub fn of(self, recording: &Recording, machine: &Machine<f64>) -> Recording {
        let mut changed = recording.clone();
        for &signal in self.signals() {
            let Some(values) = recording.signal(signal) else { continue };
            let each = |with: &dyn Fn(f64) -> f64| values.iter().map(|&value| with(value)).collect::<Vec<f64>>();
            let values = match self {
                Self::Scaled(_, factor) => each(&|value| factor * value),
                Self::Moved(_, by) => each(&|value| value + by),
                Self::Earlier(_, by_s) => {
                    let time_s = recording.time_s();
                    let at = |time: &f64| time_s.partition_point(|other| *other <= time + by_s).saturating_sub(1);
                    time_s.iter().map(|time| values[at(time)]).collect()
                }
                Self::PressuresExchanged => {
                    let other = if signal == Signal::PressureA { Signal::PressureB } else { Signal::PressureA };
                    recording.signal(other).unwrap_or(values).to_vec()
                }
                Self::PortsExchanged => {
                    let middle = if signal == Signal::Command { neutral_v(machine) } else { 0.0 };
                    each(&|value| 2.0 * middle - value)
                }
                Self::Reversed(Signal::Position) => {
                    let whole = from_other_end(values, machine.get(Parameter::Stroke));
                    each(&|value| whole - value)
                }
                Self::Reversed(_) => each(&|value| -value),
                Self::Cylinder { .. } => values.to_vec(),
            };
            changed.replace(signal, &values);
        }
        changed
    }

    /// The machine with it: areas of another cylinder, with the oil in it.
    #[must_use]
    pub fn on(self, machine: &Machine<f64>) -> Machine<f64> {
        let Self::Cylinder { bore_mm, rod_mm } = self else { return *machine };
        let circle = |across_mm: f64| 0.25 * std::f64::consts::PI * (1e-3 * across_mm).powi(2);
        let (whole, ring) = (circle(bore_mm), circle(bore_mm) - circle(rod_mm));
        let half_stroke_m = 0.5 * machine.get(Parameter::Stroke);
        let volume = |volume, area, is: f64| {
            let more_m3 = (is - machine.get(area)) * half_stroke_m;
            (machine.get(volume) + more_m3).max(is * half_stroke_m)
        };
        machine.with(&[
            (Parameter::AreaA, whole),
            (Parameter::AreaB, ring),
            (Parameter::VolumeA, volume(Parameter::VolumeA, Parameter::AreaA, whole)),
            (Parameter::VolumeB, volume(Parameter::VolumeB, Parameter::AreaB, ring)),
        ])
    }
}

/// The command at which the valve is in its middle.
fn neutral_v(machine: &Machine<f64>) -> f64 {
    let gain = machine.get(Parameter::ValveGain);
    if gain == 0.0 { 0.0 } else { -machine.get(Parameter::ValveOffset) / gain }
}

/// What a position and that from the other end add up to: the stroke; nothing, where it counts the stroke downwards from 0; or what keeps it where it
/// is, where it does not lie within the stroke either way.
fn from_other_end(values: &[f64], stroke_m: f64) -> f64 {
    let (low, high) = extent(values);
    let is_within = |low: f64, high: f64| low >= 0.0 && high <= stroke_m;
    if is_within(low, high) {
        stroke_m
    } else if is_within(-high, -low) {
        0.0
    } else {
        low + high
    }
}

/// The rows of a recording in this range.
pub(super) fn rows(recording: &Recording, range: std::ops::Range<usize>) -> Option<Recording> {
    let cut = |column: &Column| Column { values: column.values[range.clone()].to_vec(), ..column.clone() };
    Recording::new(recording.path(), recording.columns().iter().map(cut).collect()).ok()
}
