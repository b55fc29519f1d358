//! Plans for drives for which it is known what can be distinguished.

use std::sync::atomic::{AtomicUsize, Ordering};

use experiment::plan::{Outlook, Plan, PlanError, Planned, plan, steps};
use experiment::sensor::Sensor;
use identification::fit::{Free, Freedom};
use model_core::machine::{Machine, Parameter, Tick};
use recording::Signal;
use simulation::{StartOffset, rows_f64};
use test_press::with_papers_valve as drive;

fn uncertain(machine: &Machine<f64>) -> Vec<Free> {
    [Parameter::FlowCoefficient, Parameter::ViscousFriction, Parameter::BulkModulus, Parameter::DeadZone]
        .map(|parameter| {
            let nominal = machine.get(parameter);
            Free { parameter, freedom: Freedom::Around { nominal, sigma: 0.1 * nominal } }
        })
        .to_vec()
}

fn planned(machine: &Machine<f64>, signals: &[Signal], longest_s: f64) -> Result<Plan, PlanError> {
    let sensors: Vec<Sensor> = signals.iter().map(|&signal| Sensor::usual(signal, machine)).collect();
    let base_parameters = uncertain(machine);
    let asked = Planned {
        machine,
        base_parameters: &base_parameters,
        sensors: &sensors,
        largest_v: 10.0,
        can_load: false,
        longest_s,
    };
    let taken = AtomicUsize::new(0);
    let plan = plan(&asked, None, &|| {
        taken.fetch_add(1, Ordering::Relaxed);
    })?;
    assert_eq!(taken.into_inner(), steps(&asked));
    Ok(plan)
}

fn place(outlook: &Outlook, name: &str) -> usize {
    outlook.effects.iter().position(|prospect| prospect.effect.name == name).unwrap()
}

#[test]
fn with_the_position_alone_effects_pass_for_each_other_that_a_spool_and_pressures_tell_apart() {
    let machine = drive();
    let blind = planned(&machine, &[Signal::Position], 9.0).unwrap();
    let all = [Signal::Spool, Signal::PressureA, Signal::PressureB, Signal::Position];
    let seeing = planned(&machine, &all, 9.0).unwrap();
    let share = |plan: &Plan| plan.best.isolability.confused().count();
    assert!(share(&blind) > 2 * share(&seeing), "{} {}", share(&blind), share(&seeing));
    let (hysteresis, stiction) = (place(&seeing.best, "valve-hysteresis"), place(&seeing.best, "spool-stiction"));
    assert!(
        seeing.best.isolability.separated[hysteresis][stiction]
            && seeing.best.isolability.separated[stiction][hysteresis]
    );
    // A spool or a pressure sensor is what the position alone lacks, and nothing more is advised where all are present.
    let better = &blind.additions[0];
    assert!(better.confused < share(&blind) || better.accepted > blind.best.isolability.accepted().count());
    assert!(seeing.additions.is_empty());
}

#[test]
fn what_is_accepted_from_the_smallest_amount_on_is_not_accepted_below_it() {
    let machine = drive();
    let sensors =
        [Signal::PressureA, Signal::PressureB, Signal::Position].map(|signal| Sensor::usual(signal, &machine));
    let base_parameters = uncertain(&machine);
    let asked = Planned {
        machine: &machine,
        base_parameters: &base_parameters,
        sensors: &sensors,
        largest_v: 10.0,
        can_load: false,
        longest_s: 9.0,
    };
    let outlook = plan(&asked, None, &|| {}).unwrap().best;
    for name in ["internal-leakage", "coulomb-friction"] {
        let prospect = &outlook.effects[place(&outlook, name)];
        let (parameter, usual) = prospect.amount().unwrap();
        let smallest = prospect.smallest_value().unwrap();
        assert!(smallest > 0.0 && smallest < usual, "{name}: {smallest} of {usual}");
        // The noise of every sensor is ten times as large: the smallest visible amount is then also about ten times as large.
        let noisy = sensors.map(|sensor| Sensor { noise: 10.0 * sensor.noise, ..sensor });
        let louder = plan(&Planned { sensors: &noisy, ..asked.clone() }, None, &|| {}).unwrap().best;
        let larger = louder.effects[place(&louder, name)].smallest_value().unwrap();
        assert!((3.0..30.0).contains(&(larger / smallest)), "{name} ({parameter:?}): {smallest} {larger}");
    }
}

#[test]
fn the_excitation_comes_back_to_the_middle_after_every_test_and_is_no_longer_than_asked() {
    let machine = drive();
    let plan = planned(&machine, &[Signal::Position, Signal::PressureA], 12.0).unwrap();
    assert!(!plan.tests.is_empty() && plan.excitation.duration_s() <= 12.0);
    let stimulus = plan.excitation.stimulus(&machine, Tick::OneMillisecond).unwrap();
    let mut end_m = f64::NAN;
    rows_f64(&machine, &stimulus, StartOffset::none(), &mut |_, signal| end_m = signal(Signal::Position).unwrap())
        .unwrap();
    let middle_m = 0.5 * machine.get(Parameter::Stroke);
    assert!((end_m - middle_m).abs() < 0.1 * middle_m, "{end_m}");
}

#[test]
fn a_time_too_short_for_any_test_is_refused_and_so_are_no_sensors() {
    let machine = drive();
    assert!(matches!(planned(&machine, &[Signal::Position], 0.5), Err(PlanError::TooShort { .. })));
    let asked = Planned {
        machine: &machine,
        base_parameters: &[],
        sensors: &[],
        largest_v: 10.0,
        can_load: false,
        longest_s: 9.0,
    };
    assert!(matches!(plan(&asked, None, &|| {}), Err(PlanError::NoSensor)));
}
