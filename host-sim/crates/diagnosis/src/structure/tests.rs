use identification::experiment::Prepared;
use identification::yardstick::yardsticks;
use machine_file::LoadSource;
use model_core::machine::{Machine, Parameter, Tick};
use recording::seeded_noise::Noise;
use recording::{Column, Recording, Signal};
use simulation::{InputPoint, StartOffset, Stimulus, simulate_f64};
use test_press::press;

use super::*;

const STEP_S: f64 = 2e-3;

/// A command that steps to a new value, held for so many rows.
fn stepping(stream: u64, rows: usize, held: usize, volts: f64) -> Vec<f64> {
    let mut noise = Noise::new(17, stream);
    let mut value = 0.0;
    (0..rows)
        .map(|row| {
            if row % held == 0 {
                value = noise.gaussian(volts).clamp(-2.0 * volts, 2.0 * volts);
            }
            value
        })
        .collect()
}

fn made(name: &str, command: Vec<f64>, position_m: Vec<f64>, further: Vec<Column>) -> Recording {
    let time_s = (0..command.len()).map(|row| STEP_S * row as f64).collect();
    let columns = [(Signal::Time, time_s), (Signal::Command, command), (Signal::Position, position_m)];
    let columns = columns.map(|(signal, values)| Column::si(signal, values)).into_iter().chain(further);
    Recording::new(name, columns.collect()).unwrap()
}

/// The position of a machine under a command, with the noise of a sensor.
fn moved(machine: &Machine<f64>, command: &[f64], from_m: f64) -> Vec<f64> {
    let driven = made("driven", command.to_vec(), vec![from_m; command.len()], Vec::new());
    let tick = Tick::OneMillisecond;
    let stimulus = Stimulus::new(&driven, machine, InputPoint::Command, LoadSource::Constant, tick).unwrap();
    let run = simulate_f64(machine, &stimulus, StartOffset::none()).unwrap();
    noisy(run.signal(Signal::Position).unwrap())
}

fn noisy(position_m: &[f64]) -> Vec<f64> {
    let mut noise = Noise::new(23, 5);
    position_m.iter().map(|position_m| position_m + noise.gaussian(5e-5)).collect()
}

/// What is found where this machine is the one that the diagnosis ends with; the last recording is held out.
fn found(machine: &Machine<f64>, recordings: &[Recording]) -> Structure {
    let prepare = |recording| Prepared::new(recording, machine, LoadSource::Constant, None).unwrap();
    let cases: Vec<Prepared> = recordings.iter().map(prepare).collect();
    let (training, held_out) = cases.split_at(cases.len() - 1);
    let linear = yardsticks(&training.iter().collect::<Vec<_>>(), &held_out.iter().collect::<Vec<_>>());
    let shown = |(index, case): (usize, &Prepared)| {
        let run = simulate_f64(machine, &case.stimulus, StartOffset::none()).unwrap();
        let held_out = index + 1 == cases.len();
        Shown { prepared: case.clone(), held_out, before: run.clone(), after: run }
    };
    let shown: Vec<Shown> = cases.iter().enumerate().map(shown).collect();
    let supply_pa: Vec<_> = recordings.iter().map(|recording| recording.signal(Signal::SupplyPressure)).collect();
    structure(linear, &shown, machine, &supply_pa)
}

/// Three recordings of the same kind.
fn three(each: impl Fn(u64) -> Recording) -> Vec<Recording> {
    (0..3).map(each).collect()
}

#[test]
fn of_a_smooth_residual_few_squares_are_independent() {
    let smooth: Vec<f64> = (0..1000).map(|row| (0.01 * f64::from(row)).sin()).collect();
    let rough: Vec<f64> = (0..1000).map(|row| if row % 2 == 0 { 1.0 } else { -1.0 }).collect();
    assert!(independent_squares(&smooth) < 20.0 && independent_squares(&rough) > 999.0);
}

#[test]
fn a_drive_that_the_model_follows_has_no_wrong_structure_and_neither_has_one_that_lacks_an_effect() {
    use Parameter as P;
    let machine = press(&[]);
    let lacking: [&[(P, f64)]; 5] = [
        &[],
        &[(P::InternalLeakage, 8e-12)],
        &[(P::CoulombFriction, 900.0)],
        &[(P::DeadZone, 0.15), (P::ValveOffset, 0.05)],
        &[(P::LoadForce, -3000.0), (P::InternalLeakage, 5e-12)],
    ];
    for further in lacking {
        let real = press(further);
        let recordings = three(|index| {
            let command = stepping(index, 4000, 350, 2.0);
            made("r", command.clone(), moved(&real, &command, 0.15), Vec::new())
        });
        let found = found(&machine, &recordings);
        assert!(found.shows.is_empty(), "{further:?}: {:?} {}", found.shows, found.measured[0].training_percent);
        // The model that lacks nothing follows them better than a linear one.
        assert!(!further.is_empty() || found.below().is_none(), "{:?}", found.below());
    }
}

/// A plant of second order that comes to rest at 20 mm for each volt.
fn follower(command: &[f64], omega: f64, damping: f64) -> Vec<f64> {
    let (mut value, mut rate) = (0.15, 0.0);
    let position_m: Vec<f64> = command
        .iter()
        .map(|volts| {
            let before = value;
            for _ in 0..20 {
                let by = 0.05 * STEP_S;
                rate += by * (omega * omega * (0.15 + 0.02 * volts - value) - 2.0 * damping * omega * rate);
                value += by * rate;
            }
            before
        })
        .collect();
    noisy(&position_m)
}

#[test]
fn what_comes_to_rest_where_the_command_says_follows_it() {
    for (omega, damping) in [(6.0, 0.4), (4.0, 1.0), (12.0, 4.0)] {
        let recordings = three(|index| {
            let command = stepping(index, 4000, 450, 2.0);
            made("r", command.clone(), follower(&command, omega, damping), Vec::new())
        });
        let found = found(&press(&[]), &recordings);
        let Some(Shows::Follows { gain, settling_s, follows_percent, .. }) = found.shows.first() else {
            panic!("{:?}", found.shows)
        };
        assert!((gain / 0.02 - 1.0).abs() < 0.05 && *follows_percent > 95.0, "{gain} {follows_percent}");
        assert!((settling_s * omega / (2.0 * damping) - 1.0).abs() < 0.15, "{settling_s}");
        assert!(found.follows() && found.below().is_some());
    }
}

/// A position that swings as it likes under a command that steps: a free swing fits it, and nothing follows.
#[test]
fn what_swings_by_itself_follows_nothing() {
    let recordings = three(|index| {
        let command = stepping(index, 2000, 250, 2.0);
        let swings = (0..2000).map(|row| 0.1 + 0.02 * (3.0 * f64::from(row) * STEP_S).sin()).collect::<Vec<_>>();
        made("r", command, noisy(&swings), Vec::new())
    });
    assert!(!found(&press(&[]), &recordings).follows());
}

/// The press in closed position control: the set value, and where the rod goes.
fn controlled(set_m: &[f64]) -> Vec<f64> {
    let (mut position_m, mut opening) = (0.15, 0.0);
    let rows: Vec<f64> = set_m
        .iter()
        .map(|set_m| {
            let before = position_m;
            let asked = (12.0 * (set_m - position_m)).clamp(-1.0, 1.0);
            opening += STEP_S / 0.03 * (asked - opening);
            // Extending it is slower than retracting.
            position_m += STEP_S * opening * if opening > 0.0 { 0.25 } else { 0.35 };
            before
        })
        .collect();
    noisy(&rows)
}

#[test]
fn a_set_value_that_is_recorded_as_the_command_is_followed() {
    let recordings = three(|index| {
        let set_v = stepping(index, 6000, 750, 1.5);
        let set_m: Vec<f64> = set_v.iter().map(|volts| 0.15 + 0.03 * volts).collect();
        made("r", set_v, controlled(&set_m), Vec::new())
    });
    let found = found(&press(&[]), &recordings);
    assert!(matches!(found.shows.first(), Some(Shows::Follows { .. })), "{:?}", found.shows);
}

#[test]
fn a_rod_that_another_command_moves_as_well_moves_where_no_command_does() {
    let machine = press(&[]);
    let recordings = three(|index| {
        let rows = 4000;
        let own = |row: usize| if (500..800).contains(&row) || (2500..2800).contains(&row) { 1.5 } else { 0.0 };
        let other = |row: usize| if (1400..1900).contains(&row) { -2.0 - 0.2 * index as f64 } else { 0.0 };
        let total: Vec<f64> = (0..rows).map(|row| own(row) + other(row)).collect();
        made("r", (0..rows).map(own).collect(), moved(&machine, &total, 0.15), Vec::new())
    });
    let found = found(&machine, &recordings);
    let moves = found.shows.iter().find_map(|shows| match shows {
        Shows::MovesUncommanded(moves) => Some(moves),
        _ => None,
    });
    let moves = moves.unwrap_or_else(|| panic!("{:?}", found.shows));
    assert!(moves.only_retracts && moves.is_never_asked && moves.at_neutral_m > 0.2 * moves.all_m, "{moves:?}");
    assert!(moves.from_s < 2.9 && moves.to_s > 3.7, "{moves:?}");
}

#[test]
fn a_supply_that_falls_while_the_own_command_rests_is_told_where_the_model_is_wrong_anyway() {
    let machine = press(&[]);
    // What moves the rod at other times also takes oil.
    let recording = |index: u64, is_shared: bool| {
        let rows = 4000;
        let own = |row: usize| if (300..600).contains(&row) { 1.5 } else { 0.0 };
        let other = |row: usize| if (1400..2200).contains(&row) { -3.0 } else { 0.0 };
        let total: Vec<f64> = (0..rows).map(|row| own(row) + other(row)).collect();
        let mut noise = Noise::new(29, index);
        let supply = |row: usize| {
            let falls = if is_shared && (1400..2200).contains(&row) { 2e6 } else { 0.0 };
            7e6 - falls + noise.gaussian(2e4)
        };
        let supply = Column::si(Signal::SupplyPressure, (0..rows).map(supply).collect());
        made("r", (0..rows).map(own).collect(), moved(&machine, &total, 0.15), vec![supply])
    };
    let says = |is_shared| {
        let found = found(&machine, &three(|index| recording(index, is_shared)));
        found.shows.iter().any(|shows| matches!(shows, Shows::SupplySags(_)))
    };
    assert!(says(true) && !says(false));
}

#[test]
fn of_few_rows_or_a_command_that_never_moves_nothing_is_said() {
    let machine = press(&[]);
    let command = stepping(1, 10, 5, 2.0);
    let short = three(|_| made("r", command.clone(), moved(&machine, &command, 0.15), Vec::new()));
    let rest = vec![1.0; 2000];
    let still = three(|_| made("r", rest.clone(), moved(&machine, &rest, 0.05), Vec::new()));
    for recordings in [short, still] {
        let found = found(&machine, &recordings);
        assert!(found.measured.is_empty() && found.shows.is_empty(), "{:?}", found.shows);
    }
}
