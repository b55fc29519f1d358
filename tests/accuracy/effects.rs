//! Each effect, what an installed drive has beside the paper's model, and the pump drive, against the oracle's own form of it in its textbook limit.

use model_core::machine::{BASE_FORMS, Machine, Parameter as P, Tick};
use model_core::number::{PerUnit, Single};
use recording::excitation::signals::Excitation;
use system_tests::drives;
use system_tests::simulate::{Distance, core, core_pump, distance, oracle_with};
use virtual_plant::{Cavitation, Commands, InitialState, LoadEffect, PlantEffect, PumpCommand};

use crate::table::{self, TableLine, five};
use crate::tolerances::{Case, of};

const TICK: Tick = Tick::OneMillisecond;

const LEAKAGE_M3_PER_S_PA: f64 = 4e-12;
/// About the oil's own compressibility in A.
const COMPLIANCE_M3_PER_PA: f64 = 4e-13;
const FRICTION_N: f64 = 800.0;
const SLIP_M3_PER_S_PA: f64 = 1e-12;
/// Speed at which slip is compared.
const SLIPPING_REV_PER_S: f64 = 30.0;
/// Speed at which the oracle's slip has faded to half. The core's slip does not fade: the oracle is given that much more.
const SLIP_FADE_REV_PER_S: f64 = 0.2;

const LEAKAGE: PlantEffect = PlantEffect::InternalLeakage {
    conductance_m3_per_s_pa: LEAKAGE_M3_PER_S_PA,
    turbulent_share: 0.0,
    transition_pa: 3.0e6,
};
const HOSES: PlantEffect =
    PlantEffect::HoseCompliance { compliance_m3_per_pa: COMPLIANCE_M3_PER_PA, stiffening_pressure_pa: f64::INFINITY };
/// Bristles that yield by 8 nm, almost set-valued: with ten times softer ones the largest error is a tenth to a quarter larger.
const FRICTION: PlantEffect =
    PlantEffect::CoulombFriction { force_n: FRICTION_N, stiffness_n_per_m: 1e11, damping_n_s_per_m: 2e5 };
/// Bristles that yield by 27 µm, damped as in the core: this compares the core's step on them.
const LUGRE: PlantEffect = PlantEffect::CoulombFriction {
    force_n: FRICTION_N,
    stiffness_n_per_m: STIFFNESS_N_PER_M,
    damping_n_s_per_m: 8.8e3,
};
const STIFFNESS_N_PER_M: f64 = 3e7;
/// A position that every signal reaches.
const STOP_M: f64 = 0.18;
/// So hard that neither this stop nor the core's yields by more than 30 µm under the full force.
const STOP: PlantEffect =
    PlantEffect::Load(LoadEffect::EndStop { at_m: STOP_M, extending: true, stiffness: 2e11, damping_s_per_m: 3.0 });
const STOP_N_PER_M: f64 = 1e9;
const STOP_N_S_PER_M: f64 = 3e5;
/// Oil that boils within 0.1 kPa: almost a fixed floor of the pressure.
const BOILING: PlantEffect =
    PlantEffect::Cavitation(Cavitation { floor_pa: FLOOR_PA, steepness_pa: 1e2, released: 0.0 });
const FLOOR_PA: f64 = -9e4;
/// With little friction, this force moves the rod faster than the valve fills A.
const PULL_N: f64 = 9e3;
const SLIP: PlantEffect = PlantEffect::PumpSlip {
    conductance_m3_per_s_pa: SLIP_M3_PER_S_PA * (SLIPPING_REV_PER_S + SLIP_FADE_REV_PER_S) / SLIPPING_REV_PER_S,
    turbulent_share: 0.0,
    reference_pressure_pa: 5.0e6,
};

/// The largest error over the paper's signals and five of random steps.
fn valve(machine: &Machine<f64>, effects: &[PlantEffect]) -> [Distance; 5] {
    let mut signals = vec![Excitation::paper_steps(4.0), Excitation::paper_steps(10.0), Excitation::paper_sweep()];
    signals.extend((1..=5).map(Excitation::random_steps));
    let mut worst = [Distance::default(); 5];
    for signal in signals {
        let volts = signal.sample(TICK.seconds());
        let initial = InitialState::at_rest(machine, 0.15);
        let truth = oracle_with(machine, effects, TICK, &Commands::Valve(volts.clone()), &initial);
        let real = core::<f64>(machine, TICK, &volts, &initial);
        let fixed = core::<PerUnit>(machine, TICK, &volts, &initial);
        let found = five(&truth, &real, &fixed, &core::<Single>(machine, TICK, &volts, &initial));
        worst = std::array::from_fn(|index| worst[index].or(found[index]));
    }
    worst
}

fn pump(machine: &Machine<f64>, effects: &[PlantEffect], commands: &[PumpCommand]) -> [Distance; 5] {
    let initial = InitialState::at_rest_with_level(machine, 0.1, 5e5);
    let truth = oracle_with(machine, effects, TICK, &Commands::Pump(commands.to_vec()), &initial);
    let real = core_pump::<f64>(machine, TICK, commands, &initial);
    let fixed = core_pump::<PerUnit>(machine, TICK, commands, &initial);
    five(&truth, &real, &fixed, &core_pump::<Single>(machine, TICK, commands, &initial))
}

/// Out, rest, back, rest, 0.3 s each.
fn out_and_back(speed_rev_per_s: impl Fn(f64) -> f64) -> Vec<PumpCommand> {
    let command = |tick: u32| {
        let direction = [1, 0, -1, 0][(tick / 300) as usize % 4];
        PumpCommand { speed_rev_per_s: speed_rev_per_s(f64::from(tick) * TICK.seconds()), direction }
    };
    (0..2400).map(command).collect()
}

#[test]
fn each_effect_and_the_pump_drive_follow_the_oracle() {
    let mut lines = Vec::new();
    let mut add = |drive: &str, signal: &str, found: [Distance; 5], case, rounds| {
        lines.push((TableLine::of(drive, signal.to_owned(), found), case, rounds));
    };
    for drive in drives::named() {
        for (parameter, value, effect, case, rounds) in [
            (P::InternalLeakage, LEAKAGE_M3_PER_S_PA, LEAKAGE, Case::Effects, Case::Rounding),
            (P::HoseCompliance, COMPLIANCE_M3_PER_PA, HOSES, Case::Effects, Case::Rounding),
            (P::CoulombFriction, FRICTION_N, FRICTION, Case::DryFriction, Case::DryFrictionRounding),
        ] {
            let found = valve(&drive.machine.with(&[(parameter, value)]), &[effect]);
            add(drive.name, effect.name(), found, case, rounds);
        }
        let machine =
            drive.machine.with(&[(P::CoulombFriction, FRICTION_N), (P::PreslidingStiffness, STIFFNESS_N_PER_M)]);
        add(drive.name, "... on bristles", valve(&machine, &[LUGRE]), Case::DryFriction, Case::DryFrictionRounding);
        let machine = drive.machine.with(&[
            (P::StopExtended, STOP_M),
            (P::StopStiffness, STOP_N_PER_M),
            (P::StopDamping, STOP_N_S_PER_M),
        ]);
        add(drive.name, STOP.name(), valve(&machine, &[STOP]), Case::Stop, Case::StopRounding);
        for form in BASE_FORMS {
            let found = valve(&drive.machine.with(form.values), &[]);
            let is_late = form.values.iter().any(|(parameter, _)| *parameter == P::TransportDelay);
            let case = if is_late { Case::SpoolWithinTick } else { Case::Effects };
            add(drive.name, form.name, found, case, Case::Rounding);
        }
        let machine =
            drive.machine.with(&[(P::CavitationFloor, FLOOR_PA), (P::LoadForce, PULL_N), (P::ViscousFriction, 5.0e3)]);
        add(drive.name, BOILING.name(), valve(&machine, &[BOILING]), Case::Void, Case::VoidRounding);
    }
    let machine = drives::pump();
    let loaded = machine.with(&[(P::LoadForce, -4e3)]);
    let constant = out_and_back(|_| SLIPPING_REV_PER_S);
    let changing = out_and_back(|time_s| 25.0 + 15.0 * (9.0 * time_s).sin());
    let slipping = loaded.with(&[(P::PumpSlip, SLIP_M3_PER_S_PA)]);
    add("pump", "constant speed", pump(&machine, &[], &constant), Case::Pump, Case::Rounding);
    add("pump", "changing speed", pump(&machine, &[], &changing), Case::Pump, Case::Rounding);
    add("pump", "changing, -4 kN", pump(&loaded, &[], &changing), Case::Pump, Case::Rounding);
    add("pump", SLIP.name(), pump(&slipping, &[SLIP], &constant), Case::Pump, Case::Rounding);
    for (line, case, rounds) in &lines {
        line.check(of(*case), of(*rounds));
    }
    table::compare("effects.txt", &lines.into_iter().map(|(line, ..)| line).collect::<Vec<_>>());
}

/// Random signals on which dry friction is compared in both number types; none was chosen.
const SEEDS: u64 = 40;

#[test]
fn dry_friction_parts_fixed_point_from_f64_only_where_a_rod_breaks_away() {
    for drive in drives::named() {
        let machine = drive.machine.with(&[(P::CoulombFriction, FRICTION_N)]);
        let initial = InitialState::at_rest(&machine, 0.15);
        let parted = |seed| {
            let volts = Excitation::random_steps(seed).sample(TICK.seconds());
            distance(&core::<PerUnit>(&machine, TICK, &volts, &initial), &core::<f64>(&machine, TICK, &volts, &initial))
        };
        let mut found: Vec<Distance> = (1..=SEEDS).map(parted).collect();
        found.sort_by(|one, other| one.pressure.total_cmp(&other.pressure));
        let (median, worst) = (found[found.len() / 2], found[found.len() - 1]);
        println!(
            "{:<8} pressure: median {:.6} %, worst of {SEEDS} {:.6} %",
            drive.name,
            100.0 * median.pressure,
            100.0 * worst.pressure
        );
        assert!(of(Case::Rounding).holds(median), "{}: the median parts by {median:?}", drive.name);
        assert!(found.iter().all(|&found| of(Case::DryFrictionRounding).holds(found)), "{}: {worst:?}", drive.name);
    }
}
