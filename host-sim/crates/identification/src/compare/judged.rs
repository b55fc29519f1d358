//! Judging a recording by some of its signals only.
//!
//! A signal that is not judged counts as not recorded, so no link is driven by it and no effect is tried for it: with the
//! spool alone, only the valve is examined. What drives the model stays: command, pump, load, and the pressures where the
//! load is taken from them.

use machine_file::LoadSource;
use model_core::machine::Source;
use recording::channel_map::nearest_signal;
use recording::{Recording, Signal};
use simulation::{InputPoint, SimulateError, first_input_point};

use super::judged;

/// Why a recording cannot be judged by the signals that were asked for.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// Nothing drives the model.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
    /// A signal is not recorded, or is an input.
    #[error("{recording}: {signal} cannot be judged; expected some of: {judgeable}")]
    NotJudgeable {
        /// The recording.
        recording: String,
        /// The signal.
        signal: Signal,
        /// The measured signals that the model computes.
        judgeable: String,
    },
}

/// A signal of this name, or what is wrong with the name.
pub fn named(name: &str) -> Result<Signal, String> {
    let name = name.trim();
    Signal::parse(name).ok_or_else(|| {
        let known: Vec<&str> = Signal::ALL.iter().map(|signal| signal.name()).collect();
        let nearest = nearest_signal(name);
        format!("`{name}` is not a known signal; expected one of {}; did you mean `{nearest}`?", known.join(" "))
    })
}

/// The recording as if, of the signals that the model computes, only `wanted` had been measured; unchanged without `wanted`.
pub fn judged_by(
    recording: Recording,
    source: Source,
    load: LoadSource,
    wanted: &[Signal],
) -> Result<Recording, JudgeError> {
    if wanted.is_empty() {
        return Ok(recording);
    }
    let input_point = first_input_point(source, &recording)?;
    let mut computed = judged(&recording, input_point, load);
    if source == Source::Valve && recording.has(Signal::SupplyPressure) && input_point <= InputPoint::Spool {
        computed.push(Signal::SupplyPressure);
    }
    if let Some(&signal) = wanted.iter().find(|signal| !computed.contains(signal)) {
        let judgeable = computed.iter().map(|signal| signal.name()).collect::<Vec<_>>().join(", ");
        return Err(JudgeError::NotJudgeable { recording: recording.name().to_owned(), signal, judgeable });
    }
    Ok(recording.limited_to(|signal| !computed.contains(&signal) || wanted.contains(&signal)))
}

#[cfg(test)]
mod tests {
    use recording::Column;

    use super::*;

    fn recording() -> Recording {
        let column = |signal| Column::si(signal, vec![0.0, 1.0]);
        let signals =
            [Signal::Time, Signal::Command, Signal::Spool, Signal::SupplyPressure, Signal::PressureA, Signal::Position];
        Recording::new("r.csv", signals.into_iter().map(column).collect()).unwrap()
    }

    fn limited(wanted: &[Signal]) -> Result<Recording, JudgeError> {
        judged_by(recording(), Source::Valve, LoadSource::Constant, wanted)
    }

    #[test]
    fn what_is_not_judged_counts_as_not_recorded_and_inputs_stay() {
        let signals =
            |recording: &Recording| recording.columns().iter().map(|column| column.signal).collect::<Vec<_>>();
        assert_eq!(signals(&limited(&[Signal::Spool]).unwrap()), [Signal::Time, Signal::Command, Signal::Spool]);
        assert_eq!(limited(&[]).unwrap(), recording());
    }

    #[test]
    fn an_input_or_an_absent_signal_cannot_be_judged() {
        for signal in [Signal::Command, Signal::PressureB] {
            let error = limited(&[signal]).unwrap_err().to_string();
            assert!(error.contains("expected some of: spool, "), "{error}");
        }
        assert!(named("spol").unwrap_err().contains("`spool`"));
    }
}
