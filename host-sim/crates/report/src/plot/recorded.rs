//! The panels of a recording beside its simulation.

use recording::display_unit::{percent, unit_for_people, unit_of};
use recording::{Recording, Signal};
use simulation::figures_of_merit::SignalFit;
use simulation::{InputPoint, Trajectory};

use super::{Panel, Style, Trace};

/// A panel of the drive input, then one of every signal that `judged` names, recorded against simulated with the
/// residual below.
#[must_use]
pub fn panels(recording: &Recording, input_point: InputPoint, simulated: &Trajectory, judged: &[Signal]) -> Vec<Panel> {
    let time_s = recording.time_s();
    let unit_in = |signal: Signal| recording.column(signal).map_or_else(|| unit_for_people(signal), unit_of);
    let readable = |signal: Signal, values: &[f64]| -> Vec<f64> {
        let unit = unit_in(signal);
        values.iter().map(|value| unit.from_si(*value)).collect()
    };
    let empty = |signal: Signal| {
        let unit = unit_in(signal);
        let unit = if signal == Signal::Spool { "% of travel" } else { unit.symbol() };
        Panel::new(title(signal), unit, time_s.to_vec())
    };
    let signal = input_point.driving();
    let input = recording.signal(signal).map(|values| {
        empty(signal).trace(Trace::new("recorded, drives the model", readable(signal, values), Style::Input))
    });
    let compared = judged.iter().filter_map(|&signal| {
        let (measured, model) = (recording.signal(signal)?, simulated.signal(signal)?);
        let fit = SignalFit::of(signal, time_s, measured, model);
        let panel = empty(signal)
            .note(&format!("NRMSE fit {} %", percent(fit.nrmse_percent)))
            .trace(Trace::new("recorded", readable(signal, measured), Style::Recorded))
            .trace(Trace::new("simulated", readable(signal, model), Style::Simulated));
        Some(panel.residuals())
    });
    input.into_iter().chain(compared).collect()
}

/// A signal's name within a heading: its first letter is small, but a chamber's letter stays a capital.
pub(crate) fn within_title(signal: Signal) -> String {
    let mut letters = title(signal).chars();
    letters.next().map_or_else(String::new, |first| first.to_lowercase().chain(letters).collect())
}

/// A signal's name as a heading.
pub(crate) fn title(signal: Signal) -> &'static str {
    match signal {
        Signal::Time => "Time",
        Signal::Command => "Command",
        Signal::Spool => "Spool",
        Signal::Flow => "Flow into A",
        Signal::PumpSpeed => "Pump speed",
        Signal::ValveDirection => "Directional valve",
        Signal::PressureA => "Pressure A",
        Signal::PressureB => "Pressure B",
        Signal::SupplyPressure => "Supply pressure",
        Signal::OtherFlow | Signal::OtherFlow2 | Signal::OtherFlow3 => "Flow of another consumer",
        Signal::TankPressure => "Tank pressure",
        Signal::LoadForce => "Load force",
        Signal::Force => "Force",
        Signal::Position => "Position",
        Signal::Velocity => "Velocity",
        Signal::Angle => "Joint angle",
        Signal::OilTemperature => "Oil temperature",
        Signal::Reference => "Reference",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chamber_keeps_its_capital_within_a_heading() {
        assert_eq!(
            (within_title(Signal::PressureB), within_title(Signal::Spool)),
            ("pressure B".into(), "spool".into())
        );
    }
}
