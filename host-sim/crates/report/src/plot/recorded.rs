//! The panels of a recording beside its simulation.

use recording::display_unit::{percent, unit_for_people, unit_of};
use recording::{Recording, Signal, Unit};
use simulation::figures_of_merit::SignalFit;
use simulation::{InputPoint, Trajectory};

use super::{Panel, Style, Trace};

/// A panel of the drive input, then one of every signal that `judged` names, recorded against simulated with the
/// residual below.
#[must_use]
pub fn panels(recording: &Recording, input_point: InputPoint, simulated: &Trajectory, judged: &[Signal]) -> Vec<Panel> {
    panels_of(recording, input_point, &[("simulated", simulated)], judged)
}

/// The same of several simulations, each with its name: all of them over each other in every panel.
#[must_use]
pub fn panels_of(
    recording: &Recording,
    input_point: InputPoint,
    simulated: &[(&str, &Trajectory)],
    judged: &[Signal],
) -> Vec<Panel> {
    let signal = input_point.driving();
    let input = recording.signal(signal).map(|values| {
        let trace = Trace::new("recorded, drives the model", readable(recording, signal, values), Style::Input);
        empty(recording, signal).trace(trace)
    });
    let compared = judged.iter().filter_map(|&signal| {
        let measured = recording.signal(signal)?;
        let mut panel = empty(recording, signal).trace(Trace::new(
            "recorded",
            readable(recording, signal, measured),
            Style::Recorded,
        ));
        let mut fits = Vec::new();
        for ((index, (name, trajectory)), number) in simulated.iter().enumerate().zip(0_u8..) {
            let Some(model) = trajectory.signal(signal) else { continue };
            let fit = percent(SignalFit::of(signal, recording.time_s(), measured, model).nrmse_percent);
            let style = if simulated.len() == 1 { Style::Simulated } else { Style::Model(number) };
            panel = panel.trace(Trace::new(name, readable(recording, signal, model), style));
            fits.push(if index == 0 { format!("NRMSE fit {fit} %") } else { format!("{fit} %") });
        }
        (!fits.is_empty()).then(|| panel.note(&fits.join(", ")).residuals())
    });
    input.into_iter().chain(compared).collect()
}

/// Values in the unit in which the recording has the signal.
fn readable(recording: &Recording, signal: Signal, values: &[f64]) -> Vec<f64> {
    let unit = unit_in(recording, signal);
    values.iter().map(|value| unit.from_si(*value)).collect()
}

fn unit_in(recording: &Recording, signal: Signal) -> Unit {
    recording.column(signal).map_or_else(|| unit_for_people(signal), unit_of)
}

/// A panel of a signal, without traces.
fn empty(recording: &Recording, signal: Signal) -> Panel {
    let unit = unit_in(recording, signal);
    let unit = if signal == Signal::Spool { "% of travel" } else { unit.symbol() };
    Panel::new(title(signal), unit, recording.time_s().to_vec())
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
