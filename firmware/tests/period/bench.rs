//! A rig made of closures, and what it logged.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::commissioning::Note;
use firmware::control::{Control, Predicted, Reference};
use firmware::io::{AnalogIn, AnalogOut, FromFn, PositionIn};
use firmware::measured::{AnalogSignal, Measured};
use firmware::monitor::Miss;
use firmware::period::{Devices, Period, PeriodState, Place, Report, Request, Rig, Timing};
use firmware::scaling::{Actuator, Band, Calibration, Encoder, Point, Rising, Sensor, Travel};
use firmware::set_point::{Bounds, Envelope, SetPoint};
use firmware::supervision::{Command, Delay, Deviation, DeviationLimits, Fault, Limits, Log, Mode, Patience, Reach};
use model_core::machine::{Bases, Machine, Parameter, Source, Tick};
use model_core::number::{Number, PerUnit};

pub(crate) const INPUTS_UV: u32 = 5_120_000;
pub(crate) const OUTPUT_UV: u32 = 20_000_000;
/// Counts of 78.125 µV in a volt.
pub(crate) const VOLT: i32 = 12_800;
/// Counts of the encoder over the stroke.
pub(crate) const STROKE: i32 = 21_600;

/// Everything outside of the firmware.
#[derive(Clone, Debug)]
pub(crate) struct World {
    pub(crate) count: i32,
    pub(crate) voltages: [i32; 4],
    pub(crate) position_silent: bool,
    pub(crate) inputs_silent: bool,
    pub(crate) output_silent: bool,
    pub(crate) asked: u32,
    pub(crate) written: i32,
    pub(crate) predicted: Predicted,
    /// The spool less its model's.
    pub(crate) spool_off: Option<PerUnit>,
    pub(crate) wanted: PerUnit,
    pub(crate) started: u32,
    /// The set point that the control got last.
    pub(crate) set_point: Option<SetPoint>,
}

impl World {
    pub(crate) fn new() -> Self {
        let zero = PerUnit::ZERO;
        Self {
            count: 0,
            // The output sets the first voltage.  Spool in the middle; pressures of 2.5 and 3 V.
            voltages: [0, 0, 5 * VOLT / 2, 3 * VOLT],
            position_silent: false,
            inputs_silent: false,
            output_silent: false,
            asked: 0,
            written: 0,
            predicted: Predicted { spool: zero, pressure_a: zero, pressure_b: zero, velocity: zero, position: zero },
            spool_off: None,
            wanted: neutral(),
            started: 0,
            set_point: None,
        }
    }
}

pub(crate) type Shared = Rc<RefCell<World>>;

/// A control whose command the test sets.
pub(crate) struct Wanting(pub(crate) Shared);

impl Control for Wanting {
    fn start(&mut self, measured: &Measured) {
        let mut world = self.0.borrow_mut();
        world.started += 1;
        world.predicted.position = measured.position;
    }
    fn predicted(&self) -> Predicted {
        self.0.borrow().predicted
    }
    fn follow(&mut self, set_point: SetPoint, _: &Measured) -> PerUnit {
        self.0.borrow_mut().set_point = Some(set_point);
        self.0.borrow().wanted
    }
    fn play(&mut self, command: PerUnit, _: &Measured) -> PerUnit {
        command
    }
    fn motion(&self) -> SetPoint {
        let Predicted { position, velocity, .. } = self.0.borrow().predicted;
        SetPoint { position, velocity }
    }
    fn accompany(&mut self, _: PerUnit, _: &Measured) {}
    fn spool_off(&self, _: &Measured) -> Option<PerUnit> {
        self.0.borrow().spool_off
    }
}

/// Keeps what is logged.
#[derive(Default)]
pub(crate) struct Told {
    pub(crate) faults: Vec<Fault>,
    pub(crate) modes: Vec<(Mode, Mode)>,
}

impl Log for Told {
    fn fault(&mut self, fault: &Fault) {
        self.faults.push(*fault);
    }
    fn mode(&mut self, from: Mode, to: Mode) {
        self.modes.push((from, to));
    }
    fn alarm(&mut self, _: &Miss) {}
    fn commissioning(&mut self, _: &Note) {}
}

pub(crate) fn percent(value: i32) -> PerUnit {
    PerUnit::saturated(f64::from(value) / 100.0)
}

/// −0.0345/0.0559 V: the middle of the press's dead zone.
pub(crate) fn neutral() -> PerUnit {
    PerUnit::saturated(-0.061_72)
}

pub(crate) fn limits() -> Limits {
    let patience = |travel, periods| Some(Patience { travel: percent(travel), periods });
    let bases = bases();
    let bounds = Bounds {
        from_m: 0.0,
        to_m: bases.stroke_m,
        velocity_m_per_s: 1.5 * bases.velocity_m_per_s,
        acceleration_m_per_s2: 1.0,
    };
    Limits {
        attempts: 3,
        settling: 5,
        envelope: Envelope::new(&bounds, &bases, 0.0).unwrap(),
        most_jump: percent(10),
        neutral: neutral(),
        most_command: percent(95),
        slew: percent(5),
        ramp: percent(2),
        still_position: patience(2, 50),
        still: [None, patience(5, 40), patience(5, 60), patience(5, 60), None],
        read_back: patience(3, 4),
        deviation: DeviationLimits::new(&deviation(), &bases).unwrap(),
    }
}

/// A fifth of the stroke and 0.3 m/s for 20 ms, 0.1 of the spool for 5 ms, 5 to 45 % of the stroke.
pub(crate) fn deviation() -> Deviation {
    let delay = |by, for_s| Some(Delay { by, for_s });
    let stroke_m = bases().stroke_m;
    Deviation {
        position: delay(0.2 * stroke_m, 0.02),
        velocity: delay(0.3, 0.02),
        spool: delay(0.1, 0.005),
        range: Some(Reach { from_m: 0.05 * stroke_m, to_m: 0.45 * stroke_m }),
        rest: None,
        alarm: None,
    }
}

pub(crate) fn bases() -> Bases {
    let mut machine = Machine::with_defaults(Source::Valve);
    machine.set(Parameter::AreaA, 3.117e-3);
    machine.set(Parameter::AreaB, 1.861e-3);
    machine.set(Parameter::VolumeA, 5.2e-4);
    machine.set(Parameter::VolumeB, 3.3e-4);
    *Reference::<64>::at_rest(&machine, Tick::OneMillisecond, 0.5).unwrap().bases()
}

pub(crate) fn rig(limits: Limits) -> Rig {
    let band = |from_v, to_v| Band { from_v, to_v };
    let ten_volts = |channel, value: f64| Sensor {
        channel,
        low: Point { volts: -10.0, value: -value },
        high: Point { volts: 10.0, value },
        working: band(-9.9, 9.9),
        open: Some(band(10.1, 10.3)), // 100 kΩ to +15 V
    };
    let pressure = |channel| Sensor {
        channel,
        low: Point { volts: 0.5, value: 0.0 },
        high: Point { volts: 4.5, value: 1e7 },
        working: band(0.4, 4.6),
        open: Some(band(-0.1, 0.3)), // 100 kΩ to ground
    };
    let sensors = [
        (AnalogSignal::Command, ten_volts(0, 10.0)),
        (AnalogSignal::Spool, ten_volts(1, 1.0)),
        (AnalogSignal::PressureA, pressure(2)),
        (AnalogSignal::PressureB, pressure(3)),
    ];
    let actuator = Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -9.6, highest_v: 9.6 };
    let encoder = Encoder { counts_per_m: 72_000.0, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 };
    let bases = bases();
    Rig {
        calibration: Calibration::new(&sensors, INPUTS_UV, &actuator, OUTPUT_UV, &bases).unwrap(),
        travel: Travel::straight(&encoder, &bases).unwrap(),
        limits,
        monitor: None,
    }
}

pub(crate) fn devices(
    world: &Shared,
) -> Devices<impl AnalogIn + use<>, impl PositionIn + use<>, impl AnalogOut + use<>> {
    let (inputs, position, output) = (world.clone(), world.clone(), world.clone());
    Devices {
        inputs: FromFn::<_, INPUTS_UV>(move |channel: u8| {
            let mut world = inputs.borrow_mut();
            world.asked += 1;
            if world.inputs_silent { Err("no clock") } else { Ok(world.voltages[usize::from(channel)]) }
        }),
        position: FromFn::<_>(move || {
            let mut world = position.borrow_mut();
            world.asked += 1;
            if world.position_silent { Err("no clock") } else { Ok(world.count) }
        }),
        output: FromFn::<_, OUTPUT_UV>(move |count: i32| {
            let mut world = output.borrow_mut();
            world.asked += 1;
            if world.output_silent {
                return Err("no clock");
            }
            world.written = count;
            // The read-back wire.  A count of the output is 305.2 µV, one of the inputs 78.1 µV.
            world.voltages[0] = i32::try_from(i64::from(count) * 20_000_000 / 5_120_000).unwrap();
            Ok(())
        }),
    }
}

/// A rig, its world, and what it logged.
pub(crate) struct Bench {
    pub(crate) world: Shared,
    pub(crate) period: Box<dyn Steps>,
    pub(crate) told: Told,
    pub(crate) request: Request,
}

/// `Period` without its types.
pub(crate) trait Steps {
    fn step(&mut self, request: &Request, log: &mut Told) -> Report;
    fn home(&mut self, position: PerUnit) -> bool;
    fn put_out_by_hand(&mut self, command: PerUnit);
    fn play(&mut self, command: PerUnit);
    fn state(&self) -> PeriodState;
    fn restore(&mut self, state: &PeriodState);
}

impl<A: AnalogIn, P: PositionIn, O: AnalogOut, C: Control> Steps for Period<A, P, O, C> {
    fn step(&mut self, request: &Request, log: &mut Told) -> Report {
        Period::step(self, request, log)
    }
    fn home(&mut self, position: PerUnit) -> bool {
        Period::home(self, position)
    }
    fn put_out_by_hand(&mut self, command: PerUnit) {
        Period::put_out_by_hand(self, command);
    }
    fn play(&mut self, command: PerUnit) {
        Period::play(self, command);
    }
    fn state(&self) -> PeriodState {
        *Period::state(self)
    }
    fn restore(&mut self, state: &PeriodState) {
        Period::restore(self, *state);
    }
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self::with(limits())
    }

    pub(crate) fn with(limits: Limits) -> Self {
        Self::of(&rig(limits))
    }

    pub(crate) fn of(rig: &Rig) -> Self {
        let world = Rc::new(RefCell::new(World::new()));
        let period = Period::begin(devices(&world), *rig, Wanting(world.clone()), Place::Known).unwrap();
        let set_point = SetPoint { position: PerUnit::ZERO, velocity: PerUnit::ZERO };
        let request = Request { set_point, command: None, timing: Timing::Kept };
        Self { world, period: Box::new(period), told: Told::default(), request }
    }

    /// The rod follows, at 30 % of the stroke, and the valve is open.
    pub(crate) fn following() -> Self {
        Self::new().follows()
    }

    /// The same of this one.
    pub(crate) fn follows(self) -> Self {
        let mut bench = self;
        bench.travel(STROKE * 3 / 10);
        bench.request.set_point.position = percent(30);
        bench.follow();
        bench.world.borrow_mut().wanted = percent(50);
        bench.run(50);
        assert_eq!(bench.command(None).command, percent(50));
        assert_eq!(bench.told.faults, []);
        bench.told = Told::default();
        bench
    }

    /// The rod travels by so many counts, no faster than it can.
    pub(crate) fn travel(&mut self, counts: i32) {
        for _ in 0..counts / 30 {
            self.world.borrow_mut().count += 30;
            self.command(None);
        }
    }

    pub(crate) fn follow(&mut self) {
        assert_eq!(self.command(Some(Command::Follow)).mode, Mode::Following);
    }

    pub(crate) fn command(&mut self, command: Option<Command>) -> Report {
        self.request.command = command;
        let report = self.period.step(&self.request, &mut self.told);
        self.request.command = None;
        report
    }

    /// Sensors move by a count to and fro, as working ones do.
    pub(crate) fn run(&mut self, periods: u16) -> Report {
        let mut report = self.command(None);
        for period in 1..periods {
            let noise = i32::from(period % 2) * 2 - 1;
            {
                let mut world = self.world.borrow_mut();
                world.count += noise;
                world.voltages.iter_mut().skip(1).for_each(|volts| *volts += noise);
            }
            report = self.command(None);
        }
        report
    }
}
