//! The commissioning at the keyboard: a healthy machine passes every step, and each wrong sign is refused at its step before the rod has moved far.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use firmware::app::press::{self, BY_HAND};
use firmware::app::{Desk, DeskError, wired_read_back};
use firmware::commissioning::{CommissioningError, Note, Reading, Refusal, Step, Way, What};
use firmware::monitor::Miss;
use firmware::period::{Report, Timing};
use firmware::supervision::{Fault, Log, Mode};
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::ports::{ChamberState, Flows, Spool};

use crate::world::{Plant, STROKE_M, Seen, World};

/// Where the rod stands, as a share of the stroke.
const START: f64 = 0.4;
/// Pressures of the supply, Pa.
const LOW_PA: f64 = 2e6;
const WORKING_PA: f64 = 7e6;

/// What is wrong with a machine.
#[derive(Clone, Copy, PartialEq)]
enum Wrong {
    Nothing,
    EncoderTurned,
    CommandExchanged,
    PressuresExchanged,
    SpoolTurned,
    SpoolJammed,
    /// The output holds this voltage, whatever it is told.
    OutputHolds(f64),
}

/// What a machine is connected to.
#[derive(Clone, Copy)]
struct Hall {
    /// Pressure of the supply, Pa; 0 is no oil.
    supply_pa: f64,
    /// Whether the valve has current.
    energised: bool,
    wrong: Wrong,
}

const HEALTHY: Hall = Hall { supply_pa: 0.0, energised: false, wrong: Wrong::Nothing };

/// The press at rest, at a pressure of the supply.
struct Filled {
    drive: Drive<f64>,
    state: DriveState<f64, 64>,
    supply_pa: f64,
}

impl Filled {
    fn new(machine: &Machine<f64>, supply_pa: f64, position: f64) -> Self {
        // Without oil there is still a model, whose pressures are 0.
        let machine = machine.with(&[(P::SupplyPressure, supply_pa.max(1e6))]);
        let drive = Drive::<f64>::new::<64>(&machine, Tick::OneMillisecond).unwrap();
        let ratio = machine.get(P::AreaB) / machine.get(P::AreaA);
        let b = if supply_pa > 0.0 { 0.5 } else { 0.0 };
        let neutral = -machine.get(P::ValveOffset) / machine.get(P::ValveGain) / drive.bases().command_v;
        let state = drive.at_rest(neutral, ChamberState { a: b * ratio, b }, position);
        Self { drive, state, supply_pa }
    }
}

fn plant(machine: &Machine<f64>, hall: Rc<Cell<Hall>>) -> Plant {
    let machine = machine.with(&[]);
    let mut filled = Filled::new(&machine, 0.0, START);
    Box::new(move |volts| {
        let now = hall.get();
        if now.supply_pa.to_bits() != filled.supply_pa.to_bits() {
            filled = Filled::new(&machine, now.supply_pa, filled.state.motion.position);
        }
        let Filled { drive, state, .. } = &mut filled;
        let bases = *drive.bases();
        let volts = match now.wrong {
            Wrong::OutputHolds(held_v) => held_v,
            Wrong::CommandExchanged => -volts.unwrap_or(0.0),
            _ => volts.unwrap_or(0.0),
        };
        let rests = Spool { from: 0.0, to: 0.0 };
        // Springs close a valve without current.
        let closed = -machine.get(P::ValveOffset) / machine.get(P::ValveGain);
        let still = now.wrong == Wrong::SpoolJammed || !now.energised;
        let volts = if now.energised { volts } else { closed };
        if still {
            drive.valve().unwrap().step(&mut state.valve, volts / bases.command_v);
        }
        let input = if still {
            DriveInput::Spool(rests)
        } else if now.supply_pa > 0.0 {
            DriveInput::Command(volts / bases.command_v)
        } else {
            drive.valve().unwrap().step(&mut state.valve, volts / bases.command_v);
            DriveInput::Flow { from: Flows { a: 0.0, b: 0.0 }, to: Flows { a: 0.0, b: 0.0 } }
        };
        drive.step(state, input, Load::NONE);
        let spool = if still { 0.0 } else { drive.spool(state) };
        let [a, b] = [state.chambers.a * bases.pressure_pa, state.chambers.b * bases.pressure_pa];
        let [pressure_a_pa, pressure_b_pa] = if now.wrong == Wrong::PressuresExchanged { [b, a] } else { [a, b] };
        Seen {
            spool: if now.wrong == Wrong::SpoolTurned { -spool } else { spool },
            position_m: state.motion.position * bases.stroke_m,
            pressure_a_pa,
            pressure_b_pa,
        }
    })
}

/// Everything that was told.
#[derive(Default)]
struct Heard {
    notes: RefCell<Vec<Note>>,
    faults: Vec<Fault>,
}

impl Log for Heard {
    fn fault(&mut self, fault: &Fault) {
        println!("{fault:?}");
        self.faults.push(*fault);
    }
    fn mode(&mut self, _: Mode, _: Mode) {}
    fn alarm(&mut self, miss: &Miss) {
        println!("{miss:?}");
    }
    fn commissioning(&mut self, note: &Note) {
        println!("{note}");
        self.notes.borrow_mut().push(*note);
    }
}

/// What a commissioning came to.
struct Ended {
    passed: Vec<Step>,
    refused: Option<(Step, Refusal)>,
    faults: Vec<Fault>,
    /// Farthest that the rod was from where it stood, m.
    moved_m: f64,
    report: Report,
}

/// What the operator types, with the supply's pressure from then on.
type Script<'a> = &'a [(f64, &'a str)];

const STEPS: Script<'_> = &[
    (0.0, "1c"),
    (0.0, "2c"),
    (0.0, "3c"),
    (0.0, "120z"),
    (0.0, "4c"),
    (LOW_PA, "5c"),
    (WORKING_PA, "6c"),
    (WORKING_PA, "7c"),
];

/// Types the script into a machine with this wrong, until a step is refused; 8 s for each.
fn commissioned(wrong: Wrong, script: Script<'_>) -> Ended {
    on(&press::machine(), wrong, script)
}

fn on(machine: &Machine<f64>, wrong: Wrong, script: Script<'_>) -> Ended {
    let hall = Rc::new(Cell::new(Hall { wrong, ..HEALTHY }));
    let mut world = World::new(plant(machine, hall.clone()));
    (world.output, world.sense) = (0, if wrong == Wrong::EncoderTurned { -1 } else { 1 });
    world.tick();
    let (mut memory, mut heard) = (None, Heard::default());
    let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
    let (inputs, counter, output) = world.wires();
    let mut desk = Desk::new(wired_read_back(inputs, counter, output, delay, &mut memory).unwrap(), BY_HAND);
    let stood_m = world.position_m;
    let mut moved_m = 0.0_f64;
    let mut report = desk.step(Timing::Kept, &mut heard);
    for (supply_pa, keys) in [(0.0, "")].iter().chain(script) {
        hall.set(Hall { supply_pa: *supply_pa, ..hall.get() });
        for period in 0..8000 {
            // The oil has had half a second.
            if period == 500 {
                keys.bytes().for_each(|key| desk.key(key).unwrap());
            }
            report = desk.step(Timing::Kept, &mut heard);
            hall.set(Hall { energised: report.energised, ..hall.get() });
            world.tick();
            if let Wrong::OutputHolds(held_v) = wrong {
                world.adc.borrow_mut().inputs_v[0] = Some(held_v);
            }
            moved_m = moved_m.max((world.position_m - stood_m).abs());
        }
        if heard.notes.borrow().iter().any(|note| matches!(note, Note::Refused(..))) {
            break;
        }
    }
    let notes = heard.notes.take();
    let passed = notes.iter().filter_map(|note| if let Note::Passed(step) = note { Some(*step) } else { None });
    let refused =
        notes.iter().find_map(|note| if let Note::Refused(step, why) = note { Some((*step, *why)) } else { None });
    Ended { passed: passed.collect(), refused, faults: heard.faults, moved_m, report }
}

/// Which value a step was refused for.
fn refused(ended: &Ended) -> (Step, What) {
    let Some((step, Refusal::Value(Reading { what, .. }))) = ended.refused else { panic!("{:?}", ended.refused) };
    (step, what)
}

#[test]
fn a_healthy_machine_passes_every_step_and_is_neutral_afterwards() {
    let ended = commissioned(Wrong::Nothing, STEPS);
    assert_eq!((ended.passed.as_slice(), ended.refused), (&Step::ALL[..], None));
    assert_eq!((ended.faults.as_slice(), ended.report.mode), (&[][..], Mode::Neutral));
    println!("{:.2} mm", ended.moved_m * 1e3);
    assert!(ended.moved_m < 5.5e-3, "{}", ended.moved_m);
}

#[test]
fn each_wrong_sign_is_refused_at_its_step_without_a_fault_and_before_the_rod_has_moved_far() {
    let cases = [
        ("encoder turned", Wrong::EncoderTurned, What::Rod(Way::Extends), 0.6e-3),
        ("command's wires exchanged", Wrong::CommandExchanged, What::Spool(Way::Extends), 0.1e-3),
        ("spool's sensor turned", Wrong::SpoolTurned, What::Spool(Way::Extends), 0.1e-3),
        ("spool jammed", Wrong::SpoolJammed, What::Spool(Way::Extends), 0.1e-3),
        ("pressure sensors exchanged", Wrong::PressuresExchanged, What::PressureSigns, 2e-3),
    ];
    for (name, wrong, what, most_m) in cases {
        let ended = commissioned(wrong, STEPS);
        println!("{name}: {:.2} mm", ended.moved_m * 1e3);
        assert_eq!(ended.passed, Step::ALL[..4], "{name}");
        assert_eq!(refused(&ended), (Step::Direction, what), "{name}");
        assert_eq!((ended.faults.as_slice(), ended.report.energised), (&[][..], false), "{name}");
        assert!(ended.moved_m < most_m, "{name}: {}", ended.moved_m);
    }
}

#[test]
fn an_output_that_does_not_follow_is_refused_before_there_is_oil() {
    let neutral_v = -0.0345 / 0.0559;
    let ended = commissioned(Wrong::OutputHolds(neutral_v), STEPS);
    assert_eq!(ended.passed, [Step::NoOil, Step::Voltages]);
    assert_eq!(refused(&ended), (Step::Output, What::ReadBack));
    assert!(ended.moved_m < 1e-9 && ended.report.mode != Mode::Following);
}

#[test]
fn oil_too_early_and_pressure_that_is_not_low_are_refused() {
    let early = commissioned(Wrong::Nothing, &[(LOW_PA, "1c")]);
    assert!(matches!(refused(&early), (Step::NoOil, What::PressureA | What::PressureB)));
    let during = commissioned(Wrong::Nothing, &[(0.0, "1c"), (0.0, "2c"), (LOW_PA, "3c")]);
    assert!(matches!(refused(&during), (Step::Output, What::PressureA | What::PressureB)));
    let script = [&STEPS[..5], &[(WORKING_PA, "5c")]].concat();
    let high = commissioned(Wrong::Nothing, &script);
    assert_eq!((refused(&high), high.passed.len()), ((Step::Direction, What::PressureB), 4));
    // The model's rod goes, the encoder stands: that is a fault, and its place is lost.
    let dry = commissioned(Wrong::Nothing, &[&STEPS[..5], &[(0.0, "5c")]].concat());
    assert_eq!(refused(&dry), (Step::Direction, What::Rod(Way::Extends)));
    assert!(matches!(dry.faults[..], [Fault::PositionStuck { .. }]) && dry.report.mode == Mode::Neutral);
}

#[test]
fn a_rod_that_nobody_homed_is_refused_at_its_place() {
    let ended = commissioned(Wrong::Nothing, &[(0.0, "1c"), (0.0, "2c"), (0.0, "3c"), (0.0, "4c")]);
    assert_eq!(ended.refused, Some((Step::Place, Refusal::Lost)));
    let beyond = commissioned(Wrong::Nothing, &[(0.0, "1c"), (0.0, "2c"), (0.0, "3c"), (0.0, "5z"), (0.0, "4c")]);
    assert_eq!(refused(&beyond), (Step::Place, What::Position));
}

#[test]
fn a_drive_slower_than_its_model_is_refused_at_its_tuning() {
    let slow = press::machine().with(&[(P::FlowLimit, 0.2e-4)]);
    let ended = on(&slow, Wrong::Nothing, STEPS);
    assert_eq!(refused(&ended), (Step::Tuning, What::FollowingError));
    assert!(ended.faults.is_empty() || !ended.report.energised);
}

#[test]
fn steps_wait_for_those_before_them_and_other_moves_for_their_end() {
    let mut world = World::of_press(plant(&press::machine(), Rc::new(Cell::new(HEALTHY))));
    let (mut memory, mut heard) = (None, Heard::default());
    let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
    let (inputs, counter, output) = world.wires();
    let mut desk = Desk::new(wired_read_back(inputs, counter, output, delay, &mut memory).unwrap(), BY_HAND);
    let mut run = |desk: &mut Desk<'_, _, _, _>, keys: &str, periods| {
        let result = keys.bytes().try_for_each(|key| desk.key(key));
        for _ in 0..periods {
            desk.step(Timing::Kept, &mut heard);
            world.tick();
        }
        result
    };
    let refused = |error| Err(DeskError::Commissioning(error));
    assert_eq!(run(&mut desk, "", 200), Ok(()));
    assert_eq!(run(&mut desk, "2c", 1), refused(CommissioningError::Order { asked: 2, next: 1 }));
    assert_eq!(run(&mut desk, "8c", 1), refused(CommissioningError::NoStep { found: 8 }));
    assert_eq!(run(&mut desk, "1c", 10), Ok(()));
    assert_eq!(run(&mut desk, "1c", 1), refused(CommissioningError::Busy));
    assert_eq!(run(&mut desk, "f", 500), refused(CommissioningError::Busy));
    assert_eq!(run(&mut desk, "3c", 1), refused(CommissioningError::Order { asked: 3, next: 2 }));
    assert_eq!(run(&mut desk, "120z", 1), Ok(()));
    assert_eq!(run(&mut desk, "f", 1), refused(CommissioningError::Unfinished));
    // A step that is stopped has not been passed.
    assert_eq!(run(&mut desk, "2cs", 500), Ok(()));
    assert_eq!(run(&mut desk, "3c", 1), refused(CommissioningError::Order { asked: 3, next: 2 }));
    assert_eq!(run(&mut desk, "0cf", 1), Ok(()));
    assert_eq!(heard.notes.take().last(), Some(&Note::Refused(Step::Voltages, Refusal::Stopped)));
}

#[test]
fn a_fault_on_the_way_leads_where_it_always_does_and_refuses_the_step() {
    let hall = Rc::new(Cell::new(HEALTHY));
    let mut world = World::of_press(plant(&press::machine(), hall.clone()));
    let (mut memory, mut heard) = (None, Heard::default());
    let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
    let (inputs, counter, output) = world.wires();
    let mut desk = Desk::new(wired_read_back(inputs, counter, output, delay, &mut memory).unwrap(), BY_HAND);
    let mut run = |supply_pa, keys: &str, periods: u32, broken: bool| {
        hall.set(Hall { supply_pa, ..hall.get() });
        world.wired = !broken;
        for period in 0..periods {
            if period == 500 {
                keys.bytes().for_each(|key| desk.key(key).unwrap());
            }
            let report = desk.step(Timing::Kept, &mut heard);
            hall.set(Hall { energised: report.energised, ..hall.get() });
            world.tick();
        }
        world.position_m
    };
    for (supply_pa, keys) in &STEPS[..5] {
        run(*supply_pa, keys, 2000, false);
    }
    // On the way out, a wire of pressure A breaks.
    let before_m = run(LOW_PA, "5c", 2800, false);
    let after_m = run(LOW_PA, "", 1000, true);
    assert!((after_m - before_m).abs() < 1e-3 && (after_m / STROKE_M - START).abs() < 0.01);
    assert!(matches!(heard.faults[..], [Fault::OpenWire { .. }]), "{:?}", heard.faults);
    assert_eq!(heard.notes.take().last(), Some(&Note::Refused(Step::Direction, Refusal::Fault)));
    assert_eq!(desk.step(Timing::Kept, &mut heard).mode, Mode::Neutral);
}
