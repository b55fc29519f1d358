//! A machine that can fail: spool, encoder, command's wires, oil, tick, load.

use std::cell::Cell;
use std::rc::Rc;

use firmware::app::press::SENSITIVITY;
use firmware::control::{Following, Reference};
use firmware::measured::AnalogSignal;
use firmware::monitor::Monitor;
use firmware::set_point::{Bounds, Course, CourseState, Leg};
use firmware::supervision::{Allowed, Command, Deviation, Mode};
use model_core::control::{Follower, Tuning};
use model_core::drive::{Drive, DriveInput, DriveState, Load};
use model_core::machine::{Machine, Parameter as P, Tick};
use model_core::number::{Number, PerUnit};
use model_core::ports::{ChamberState, Flows, Spool};

use crate::following::START;
use crate::world::{COUNTS_PER_M, Plant, STROKE_M, Seen, World, allowed, sensors};
use crate::{Bench, Told};

/// Ticks of the real machine in a period of the firmware.
pub(crate) const RIGHT: usize = 2;
/// At its largest command the press moves out at 70 and in at 45 mm/s; every case and every healthy drive has to keep to these bounds.
pub(crate) const BOUNDS: Bounds =
    Bounds { from_m: 0.01, to_m: 0.29, velocity_m_per_s: 0.036, acceleration_m_per_s2: 0.5 };
const JUMP_M: f64 = 1e-3;

/// What is wrong with the machine.
#[derive(Clone, Copy)]
pub(crate) struct Wrong {
    /// The spool is jammed here.
    pub(crate) jammed: Option<f64>,
    /// The command's wires are exchanged.
    pub(crate) exchanged: bool,
    /// There is no oil.
    pub(crate) dry: bool,
    /// Half milliseconds of the machine in a period.
    pub(crate) ticks: usize,
    /// Force on the rod, N; positive extends.
    pub(crate) force_n: f64,
    /// The independent valve has closed both ports.
    pub(crate) cut_off: bool,
}

pub(crate) const NOTHING: Wrong =
    Wrong { jammed: None, exchanged: false, dry: false, ticks: RIGHT, force_n: 0.0, cut_off: false };

/// The press in f64, at rest at [`START`], with what is wrong with it.
fn plant(machine: &Machine<f64>, wrong: Rc<Cell<Wrong>>) -> Plant {
    let drive = Drive::<f64>::new::<64>(machine, Tick::HalfMillisecond).unwrap();
    let bases = *drive.bases();
    let ratio = machine.get(P::AreaB) / machine.get(P::AreaA);
    let held = (machine.get(P::LoadForce) + wrong.get().force_n) / bases.force_n;
    // A force that pulls the rod out is held by the oil in B.
    let pressures = ChamberState { a: 0.8 * ratio - held, b: 0.8 };
    let neutral = -machine.get(P::ValveOffset) / machine.get(P::ValveGain) / bases.command_v;
    let mut state: DriveState<f64, 64> = drive.at_rest(neutral, pressures, START);
    let none = Flows { a: 0.0, b: 0.0 };
    Box::new(move |volts| {
        let Wrong { jammed, exchanged, dry, ticks, force_n, cut_off } = wrong.get();
        let command = volts.unwrap_or(0.0) / bases.command_v * if exchanged { -1.0 } else { 1.0 };
        let load = Load { from: force_n / bases.force_n, to: force_n / bases.force_n };
        for _ in 0..ticks {
            if cut_off || dry {
                drive.valve().unwrap().step(&mut state.valve, command);
            }
            if !cut_off {
                let input = match jammed {
                    _ if dry => DriveInput::Flow { from: none, to: none },
                    Some(spool) => DriveInput::Spool(Spool { from: spool, to: spool }),
                    None => DriveInput::Command(command),
                };
                drive.step(&mut state, input, load);
            }
        }
        Seen {
            spool: jammed.unwrap_or_else(|| drive.spool(&state)),
            position_m: state.motion.position * bases.stroke_m,
            pressure_a_pa: state.chambers.a * bases.pressure_pa,
            pressure_b_pa: state.chambers.b * bases.pressure_pa,
        }
    })
}

/// How the firmware is set up.
#[derive(Clone, Copy)]
pub(crate) struct Setup {
    pub(crate) deviation: fn(Deviation) -> Deviation,
    pub(crate) spool_is_measured: bool,
}

pub(crate) const AS_SHIPPED: Setup = Setup { deviation: |deviation| deviation, spool_is_measured: true };

pub(crate) struct Rig {
    pub(crate) bench: Bench<Following<64>>,
    pub(crate) wrong: Rc<Cell<Wrong>>,
}

impl Rig {
    /// A real machine that is not quite the model, at rest and followed.
    pub(crate) fn following(model: &Machine<f64>, real: &Machine<f64>, setup: Setup) -> Self {
        let tick = Tick::OneMillisecond;
        let tuning = Tuning {
            position_resolution_m: 1.0 / COUNTS_PER_M,
            command_limit_v: 9.5,
            slew_v_per_s: 1000.0,
            ..Tuning::by_rule(model, setup.spool_is_measured)
        };
        let reference = Reference::at_rest(model, tick, 0.5).unwrap();
        let monitor = Monitor::new(&SENSITIVITY, reference.bases()).unwrap();
        let control = Following::new(Follower::new(model, &tuning, tick).unwrap(), reference);
        let by_rule = Deviation::by_rule(model, &tuning, &BOUNDS, JUMP_M);
        let allowed = Allowed { bounds: BOUNDS, jump_m: JUMP_M, deviation: (setup.deviation)(by_rule), ..allowed() };
        let wrong = Rc::new(Cell::new(NOTHING));
        let world = World::new(plant(real, wrong.clone()));
        let mut wired = sensors().to_vec();
        wired.retain(|(signal, _)| match signal {
            // The press of the application does not read its command back.
            AnalogSignal::Command => false,
            AnalogSignal::Spool => setup.spool_is_measured,
            _ => true,
        });
        let mut period = world.begin_with(control, model, &allowed, &wired, Some(monitor));
        assert!(period.home(PerUnit::saturated(START)));
        let mut bench = Bench { world, period, told: Told::default(), wanted: START, sent: START };
        bench.run(150);
        bench.wanted = bench.step(None).measured.position.to_f64();
        bench.sent = bench.wanted;
        let report = bench.step(Some(Command::Follow));
        assert_eq!(report.mode, Mode::Following, "{:?} {:?}", bench.told.0, report);
        Self { bench, wrong }
    }

    /// Along the legs until they end; returns the largest distance between rod and set point, m.
    pub(crate) fn along(&mut self, legs: &[Leg]) -> f64 {
        let bases = *self.bench.period.control().reference().bases();
        let from_m = self.bench.wanted * STROKE_M;
        let course = Course::<8>::new(&bases, &BOUNDS, from_m, legs).unwrap();
        let (mut state, mut farthest_m) = (CourseState::default(), 0.0_f64);
        while !course.is_done(&state) {
            let wanted = course.step(&mut state);
            self.bench.step_to(wanted, None);
            (self.bench.wanted, self.bench.sent) = (wanted.position.to_f64(), wanted.position.to_f64());
            farthest_m = farthest_m.max((self.bench.wanted * STROKE_M - self.bench.world.position_m).abs());
        }
        farthest_m
    }
}
