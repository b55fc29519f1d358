#![expect(clippy::float_cmp, reason = "what is set comes back as it was")]

use tempfile::TempDir;

use super::*;

pub(crate) const PRESS: &str = "name = \"press\"\n[supply]\n[valve]\ngain_per_v = 0.0559\ntime_constants_s = [0.018]\n\
    [cylinder]\narea_a_m2 = 3.117e-3\narea_b_m2 = 1.861e-3\n[effects.internal-leakage]\nconductance_m3_per_s_pa = 2.0e-12\n";
const PUMP: &str = "name = \"pump\"\n[pump]\n[cylinder]\narea_a_m2 = 3.117e-3\narea_b_m2 = 1.861e-3\n";

/// The resources of an FMU of this drive.
pub(crate) fn resources(machine: &str, arithmetic: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("machine.toml"), machine).unwrap();
    let settings = format!("{{\"tick\":\"OneMillisecond\",\"arithmetic\":\"{arithmetic}\"}}");
    std::fs::write(folder.path().join("settings.json"), settings).unwrap();
    folder
}

fn instance(machine: &str) -> Instance {
    Instance::of(Contents::read(resources(machine, "fixed").path()).unwrap())
}

fn get(instance: &mut Instance, variable: Variable) -> f64 {
    let mut value = [f64::NAN];
    instance.get(&[variable.reference()], &mut value).unwrap();
    value[0]
}

fn set(instance: &mut Instance, variable: Variable, value: f64) -> Result<(), Refusal> {
    instance.set(&[variable.reference()], &[value])
}

fn begun(machine: &str) -> Instance {
    let mut instance = instance(machine);
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    instance
}

#[test]
fn the_start_follows_what_is_set_before_it() {
    let mut instance = instance(PRESS);
    assert_eq!(get(&mut instance, Variable::PositionAtStart), 0.15);
    set(&mut instance, Variable::PositionAtStart, 0.075).unwrap();
    assert!(matches!(instance.start_at(f64::NAN), Err(Refusal::StartTime { .. })));
    instance.start_at(2.0).unwrap();
    instance.enter_initialization().unwrap();
    assert!(matches!(instance.start_at(3.0), Err(Refusal::Mode { .. })));
    assert_eq!(get(&mut instance, Variable::Position), 0.075);
    assert_eq!(get(&mut instance, Variable::Time), 2.0);
    set(&mut instance, Variable::Command, 10.0).unwrap();
    assert!((get(&mut instance, Variable::Spool) - 0.559).abs() < 1e-6, "the command was held for long");
    instance.exit_initialization().unwrap();
    assert_eq!(instance.step(2.0, 0.003).unwrap(), 2.003);
    let late = set(&mut instance, Variable::PositionAtStart, 0.1).unwrap_err().to_string();
    assert!(late.starts_with("position_start: set in mode Step"), "{late}");
    instance.reset();
    assert_eq!(get(&mut instance, Variable::Position), 0.15);
    assert_eq!(get(&mut instance, Variable::Command), 0.0);
}

#[test]
fn ten_steps_are_one_of_ten_times_the_length() {
    let (mut fine, mut coarse) = (begun(PRESS), begun(PRESS));
    for instance in [&mut fine, &mut coarse] {
        set(instance, Variable::Command, 4.0).unwrap();
        set(instance, Variable::LoadForce, -500.0).unwrap();
    }
    for k in 0..200 {
        fine.step(f64::from(k) * 0.001, 0.001).unwrap();
    }
    for k in 0..20 {
        coarse.step(f64::from(k) * 0.01, 0.01).unwrap();
    }
    assert_eq!(fine.snapshot(), coarse.snapshot());
    assert!(get(&mut fine, Variable::Position) > 0.151);
}

#[test]
fn steps_that_the_ticks_do_not_fill_are_refused_with_both() {
    let mut instance = begun(PRESS);
    for step_s in [0.0015, 0.0, -0.001, 1e-5, f64::NAN, f64::INFINITY] {
        let refused = instance.step(0.0, step_s).unwrap_err();
        assert!(matches!(refused, Refusal::Step { .. }), "{refused}");
    }
    let refused = instance.step(0.0, 0.0015).unwrap_err().to_string();
    assert!(
        refused.starts_with("a communication step of 0.0015 s; expected a whole number of ticks of 0.001 s"),
        "{refused}"
    );
    let elsewhere = instance.step(0.5, 0.001).unwrap_err().to_string();
    assert!(elsewhere.starts_with("a step from 0.5 s; expected it from 0 s"), "{elsewhere}");
    // A rounding error from adding up times does not count as a different time.
    instance.step(1e-9, 0.001 + 1e-13).unwrap();
}

#[test]
fn a_call_out_of_its_order_says_when_it_may_come() {
    let mut instance = instance(PRESS);
    let early = instance.step(0.0, 0.001).unwrap_err().to_string();
    assert_eq!(early, "called in mode Instantiated; expected it in mode Step");
    assert!(instance.exit_initialization().is_err() && instance.terminate().is_err());
    instance.enter_initialization().unwrap();
    assert!(instance.enter_initialization().is_err());
    instance.exit_initialization().unwrap();
    instance.terminate().unwrap();
    assert!(instance.step(0.0, 0.001).is_err());
    assert_eq!(get(&mut instance, Variable::Position), 0.15);
}

#[test]
fn what_cannot_be_set_leaves_all_as_it_was() {
    let mut instance = begun(PRESS);
    let command = Variable::Command.reference();
    let nan = instance.set(&[command, Variable::LoadForce.reference()], &[1.0, f64::NAN]).unwrap_err().to_string();
    assert_eq!(nan, "load_force = NaN: expected a finite number");
    let output = instance.set(&[command, Variable::Position.reference()], &[1.0, 0.0]).unwrap_err().to_string();
    assert!(output.starts_with("position: the drive computes it"), "{output}");
    assert!(matches!(instance.set(&[command], &[]), Err(Refusal::Lengths { .. })));
    let unknown = set(&mut instance, Variable::PumpSpeed, 1.0).unwrap_err().to_string();
    assert!(unknown.starts_with("value reference 2: no such variable"), "{unknown}");
    assert_eq!(get(&mut instance, Variable::Command), 0.0);
}

#[test]
fn a_pump_drives_its_rod_by_speed_and_direction() {
    let mut instance = begun(PUMP);
    set(&mut instance, Variable::PumpSpeed, 20.0).unwrap();
    assert_eq!(get(&mut instance, Variable::Flow), 0.0, "the valve is closed");
    set(&mut instance, Variable::ValveDirection, 1.0).unwrap();
    assert!(get(&mut instance, Variable::Flow) > 0.0, "at once");
    instance.step(0.0, 0.5).unwrap();
    assert!(get(&mut instance, Variable::Position) > 0.15);
}

#[test]
fn a_state_of_another_number_type_or_version_is_refused() {
    let (fixed, mut float) = (begun(PRESS), Instance::of(Contents::read(resources(PRESS, "float").path()).unwrap()));
    assert!(matches!(float.restore(&fixed.snapshot()), Err(Refusal::OtherDrive)));
    let bytes = fixed.snapshot().to_bytes("drive-fmu/0/valve").unwrap();
    let foreign = Snapshot::of_bytes(&fixed.token(), &bytes).unwrap_err().to_string();
    assert!(foreign.starts_with("the serialized state is of \"drive-fmu/0/valve\"; expected"), "{foreign}");
    let own = fixed.snapshot().to_bytes(&fixed.token()).unwrap();
    assert_eq!(Snapshot::of_bytes(&fixed.token(), &own).unwrap(), fixed.snapshot());
}

#[test]
fn a_state_of_another_drive_is_refused() {
    let (own, mut other) = (begun(PRESS), begun(&PRESS.replace("3.117e-3", "3.118e-3")));
    assert!(matches!(other.restore(&own.snapshot()), Err(Refusal::OtherDrive)));
    let bytes = own.snapshot().to_bytes(&own.token()).unwrap();
    assert!(matches!(Snapshot::of_bytes(&other.token(), &bytes), Err(Refusal::ForeignState { .. })));
    // Another name is no other drive.
    let mut renamed = begun(&PRESS.replace("\"press\"", "\"axis\""));
    renamed.restore(&Snapshot::of_bytes(&renamed.token(), &bytes).unwrap()).unwrap();
}

#[test]
fn a_start_beyond_the_stroke_is_refused() {
    let mut instance = instance(PRESS);
    for beyond in [-0.2, -1e-9, 0.301, 5.0, 100.0] {
        let refused = set(&mut instance, Variable::PositionAtStart, beyond).unwrap_err().to_string();
        assert_eq!(refused, format!("position_start = {beyond}: expected 0 to 0.3"));
    }
    for within in [0.0, 0.3] {
        set(&mut instance, Variable::PositionAtStart, within).unwrap();
    }
    assert_eq!(get(&mut instance, Variable::Position), 0.3);
}
