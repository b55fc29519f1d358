//! Whether a recording's values can be in the units of its headers: compared with the stroke, the supply pressure, and
//! the speed that the opened valve gives.

use model_core::machine::{Machine, Parameter, Source};
use recording::{Column, Recording, Signal, Unit};
use simulation::signal::noise::{extent, noise, quantile, resolution};
use simulation::signal::slope::slopes;
use simulation::signal::window::rows_in;

use super::advice::{Bound, UnitDoubt};
use super::command::command_doubt;

/// Largest position, in strokes: the zero is not always at an end.
const MOST_STROKES: f64 = 1.02;
/// Largest pressure of a chamber, over that of the supply: less than with a rod of a third of the piston, which is thin.
const MOST_SUPPLIES: f64 = 1.5;
/// It exceeds this share of the supply pressure at some time: 0.14 bar of 70.
const LEAST_SUPPLIES: f64 = 2e-3;
/// The largest speed of the rod over that of the opened valve, for any load that it can move and any load that helps.
const SPEED: std::ops::RangeInclusive<f64> = 0.02..=5.0;
/// The largest speed is the one that this share of the rows does not exceed.
const FASTEST: f64 = 0.99;
/// Speed is the slope over this time, s, or over two rows where they are further apart.
const OVER_S: f64 = 0.02;
/// A rod that travels less than this many times its sensor's noise does not move.
const MOVES: f64 = 20.0;
/// The valve opens by more than this beyond the dead zone, 1; for less, the dead zone is not known well enough.
const OPENS: f64 = 0.02;

/// What is doubtful about the units of a recording for this drive.
#[must_use]
pub fn unit_doubts(recording: &Recording, machine: &Machine<f64>) -> Vec<UnitDoubt> {
    let command = command_doubt(recording, machine);
    let position = position_doubt(recording, machine);
    // A position beyond the stroke also gives too high a speed, and too large an opening gives too low a speed.
    let speed = if position.is_none() && command.is_none() { speed_doubt(recording, machine) } else { None };
    let pressures = [Signal::PressureA, Signal::PressureB, Signal::SupplyPressure];
    let pressures = pressures.into_iter().filter_map(|signal| pressure_doubt(recording.column(signal)?, machine));
    command.into_iter().chain(position).chain(pressures).chain(speed).chain(load_doubt(machine)).collect()
}

/// Whether the constant load is more than the supply pressure can hold on the side of the piston that it presses on: B where it extends.
#[must_use]
pub fn load_doubt(machine: &Machine<f64>) -> Option<UnitDoubt> {
    let load_n = machine.get(Parameter::LoadForce);
    let area_m2 = machine.get(if load_n > 0.0 { Parameter::AreaB } else { Parameter::AreaA });
    let full_n = machine.get(Parameter::SupplyPressure) * area_m2;
    (machine.source != Source::Force && load_n.abs() > full_n).then_some(UnitDoubt::Load { load_n, full_n })
}

fn position_doubt(recording: &Recording, machine: &Machine<f64>) -> Option<UnitDoubt> {
    let column = recording.column(Signal::Position)?;
    let stroke = machine.get(Parameter::Stroke);
    let most = MOST_STROKES * stroke;
    let (low, high) = extent(&column.values);
    if low < stroke - most && high <= most {
        let (unit, bound) = (column.unit, Bound::Stroke);
        return Some(UnitDoubt::Beyond { signal: column.signal, unit, high: unit.from_si(low), bound, fitting: None });
    }
    (high > most).then(|| match beyond(column, Bound::Stroke, (0.01 * most, most)) {
        // No other unit of a position that follows from an angle would do.
        UnitDoubt::Beyond { signal, unit, high, bound, .. } if column.from_angle.is_some() => {
            UnitDoubt::Beyond { signal, unit, high, bound, fitting: None }
        }
        doubt => doubt,
    })
}

fn pressure_doubt(column: &Column, machine: &Machine<f64>) -> Option<UnitDoubt> {
    if machine.source == Source::Force {
        return None;
    }
    let supply = machine.get(Parameter::SupplyPressure);
    let (least, most) = (LEAST_SUPPLIES * supply, MOST_SUPPLIES * supply);
    let high = extent(&column.values).1;
    // A load may raise the pressures in a pump's cylinder above the pressure at which the pump is relieved.
    if high > most && machine.source == Source::Valve {
        return Some(beyond(column, Bound::FarAboveSupply, (least, most)));
    }
    let low = high < least && high > 0.0;
    low.then(|| beyond(column, Bound::FarBelowSupply, (least, most)))
}

/// A column that reaches an impossible value, with the unit in which this value comes nearest to the middle of the possible ones.
fn beyond(column: &Column, bound: Bound, (least, most): (f64, f64)) -> UnitDoubt {
    let high = column.unit.from_si(extent(&column.values).1);
    let off = |unit: &Unit| libm::log(unit.to_si(high) / (0.5 * most)).abs();
    let possible = |unit: &Unit| (least..=most).contains(&unit.to_si(high));
    let fitting = Unit::of(column.unit.dimension()).filter(possible).min_by(|a, b| off(a).total_cmp(&off(b)));
    UnitDoubt::Beyond { signal: column.signal, unit: column.unit, high, bound, fitting }
}

/// Whether the speed of the rod agrees roughly with the opening of the valve.
fn speed_doubt(recording: &Recording, machine: &Machine<f64>) -> Option<UnitDoubt> {
    if machine.source != Source::Valve {
        return None;
    }
    let (time_s, position) = (recording.time_s(), recording.signal(Signal::Position)?);
    let (low, high) = extent(position);
    if high - low < MOVES * noise(position, resolution(position)) {
        return None;
    }
    let reach = (rows_in(time_s, OVER_S) / 2).max(1);
    let fastest = quantile(slopes(time_s, position, reach).into_iter().map(f64::abs).collect(), FASTEST)?;
    let share = fastest / expected_m_per_s(recording, machine)?;
    if SPEED.contains(&share) {
        return None;
    }
    let time = recording.column(Signal::Time)?;
    let slower = |unit: Unit| unit.to_si(1.0) / time.unit.to_si(1.0);
    let fitting = Unit::of(time.unit.dimension()).find(|unit| SPEED.contains(&(share / slower(*unit))));
    Some(UnitDoubt::Speed { share, fitting: fitting.map(|unit| (unit, share / slower(unit))) })
}

/// The speed without load at the widest opening: each edge takes half of the supply pressure.
fn expected_m_per_s(recording: &Recording, machine: &Machine<f64>) -> Option<f64> {
    let get = |parameter| machine.get(parameter);
    let opening = |command: &f64| get(Parameter::ValveGain) * command + get(Parameter::ValveOffset);
    let spool = match recording.signal(Signal::Spool) {
        Some(spool) => spool.to_vec(),
        None => recording.signal(Signal::Command)?.iter().map(opening).collect(),
    };
    let open = spool.into_iter().map(|spool| (spool.abs() - get(Parameter::DeadZone)).min(1.0)).collect();
    let open = quantile(open, FASTEST).filter(|open| *open > OPENS)?;
    let flow_m3_per_s = get(Parameter::FlowCoefficient) * open * (0.5 * get(Parameter::SupplyPressure)).sqrt();
    Some(flow_m3_per_s / get(Parameter::AreaA))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use recording::{ChannelMap, read_from};

    use super::*;

    /// Two seconds of the press: half open for a second, then closed, with headers and factors of `columns`.
    fn recording(columns: [(&str, f64); 4]) -> Recording {
        let machine = test_press::press(&[]);
        let open = 0.5 - machine.get(Parameter::DeadZone);
        let speed =
            machine.get(Parameter::FlowCoefficient) * open * (0.5 * machine.get(Parameter::SupplyPressure)).sqrt()
                / machine.get(Parameter::AreaA);
        let header: Vec<String> = columns.iter().map(|(header, _)| (*header).to_owned()).collect();
        let mut text = format!("{}\n", header.join(","));
        for row in 0..200 {
            let time = f64::from(row) * 0.01;
            let opened = if time < 1.0 { 0.5 } else { 0.0 };
            let values = [time, opened, 0.1 + speed * time.min(1.0), 3.5e6 + 1e5 * (9.0 * time).sin()];
            let cells: Vec<String> =
                values.iter().zip(columns).map(|(value, (_, factor))| (value * factor).to_string()).collect();
            writeln!(text, "{}", cells.join(",")).unwrap();
        }
        read_from("r.csv", text.as_bytes(), &ChannelMap::default()).unwrap()
    }

    const RIGHT: [(&str, f64); 4] =
        [("time [s]", 1.0), ("spool", 1.0), ("position [mm]", 1e3), ("pressure_a [bar]", 1e-5)];

    fn doubts(index: usize, header: &'static str, factor: f64) -> Vec<UnitDoubt> {
        let mut columns = RIGHT;
        columns[index] = (header, factor);
        unit_doubts(&recording(columns), &test_press::press(&[]))
    }

    #[test]
    fn what_is_in_its_units_is_not_doubted() {
        assert_eq!(unit_doubts(&recording(RIGHT), &test_press::press(&[])), []);
        assert_eq!(doubts(0, "time [ms]", 1e3), []);
        assert_eq!(doubts(3, "pressure_a [psi]", 1.0 / 6894.757), []);
    }

    #[test]
    fn every_usual_mistake_is_doubted_with_the_unit_that_would_do() {
        for (index, header, factor, passed, instead) in [
            (0, "time [s]", 1e3, None, Some("ms")),
            (0, "time [ms]", 1.0, None, Some("s")),
            (2, "position [m]", 1e3, Some(Bound::Stroke), Some("mm")),
            (2, "position [mm]", 1.0, None, Some("ms")),
            (2, "position [mm]", -1e3, Some(Bound::Stroke), None),
            (3, "pressure_a [Pa]", 1e-5, Some(Bound::FarBelowSupply), Some("bar")),
            (3, "pressure_a [bar]", 1.0, Some(Bound::FarAboveSupply), Some("Pa")),
            (3, "pressure_a [bar]", 1.0 / 6894.757, Some(Bound::FarAboveSupply), Some("psi")),
        ] {
            let found = doubts(index, header, factor);
            let as_expected = match &found[..] {
                [UnitDoubt::Beyond { bound, fitting, .. }] => {
                    (Some(*bound), fitting.map(Unit::symbol)) == (passed, instead)
                }
                [UnitDoubt::Speed { share, fitting: Some((unit, with_it)) }] => {
                    let too_slow = index == 2 || factor > 1.0;
                    (None, Some(unit.symbol())) == (passed, instead)
                        && (!too_slow || (share / 1e-3 - 1.0).abs() < 0.01 && (with_it - 1.0).abs() < 0.01)
                }
                _ => false,
            };
            assert!(as_expected, "{header} · {factor}: {found:?}");
        }
    }
}
