//! The parts and the machine that they are wired to.

use std::cell::RefCell;
use std::rc::Rc;

use firmware::control::Control;
use firmware::io::ad5754::{Ad5754, Channel, Reference};
use firmware::io::ads8688::{Ads8688, Range};
use firmware::io::ls7366r::{FilterClock, Ls7366r};
use firmware::io::{AnalogIn, AnalogOut};
use firmware::measured::AnalogSignal;
use firmware::monitor::Monitor;
use firmware::period::{Devices, Period, Place, Rig};
use firmware::scaling::{Actuator, Band, Calibration, Encoder, Point, Rising, Sensor, Travel};
use firmware::set_point::Bounds;
use firmware::supervision::{Allowed, Delay, Deviation, Limits};
use model_core::drive::Drive;
use model_core::machine::{Machine, Parameter, Source, Tick};
use model_core::number::PerUnit;

use crate::parts::{Adc, Counter, Dac, Wire, WireState};

/// Counts of the encoder per metre: 3600 impulses, counted fourfold, on a pinion of 0.2 m circumference.
pub(crate) const COUNTS_PER_M: f64 = 72_000.0;
pub(crate) const STROKE_M: f64 = 0.3;
/// Valve: travel per volt and without voltage, overlap; rod: m/s per opening.
pub(crate) const GAIN_PER_V: f64 = 0.0559;
pub(crate) const OFFSET: f64 = 0.0345;
pub(crate) const OVERLAP: f64 = 0.1049;
pub(crate) const SPEED_M_PER_S: f64 = 0.2;

/// What the machine's sensors measure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) spool: f64,
    pub(crate) position_m: f64,
    pub(crate) pressure_a_pa: f64,
    pub(crate) pressure_b_pa: f64,
}

/// A machine: one millisecond with this voltage at the valve, or with none.
pub(crate) type Plant = Box<dyn FnMut(Option<f64>) -> Seen>;

/// A valve with overlap and no lag, and a rod whose speed is proportional to the opening.
pub(crate) fn simple_plant() -> Plant {
    let mut position_m: f64 = 0.0;
    Box::new(move |volts| {
        // A spring holds a valve whose wire carries nothing.
        let spool = volts.map_or(0.0, |volts| GAIN_PER_V * volts + OFFSET);
        let opening = spool.signum() * (spool.abs() - OVERLAP).max(0.0);
        position_m = (position_m + opening * SPEED_M_PER_S * 1e-3).clamp(0.0, STROKE_M);
        Seen { spool, position_m, pressure_a_pa: 5.0e6, pressure_b_pa: 6.25e6 }
    })
}

/// The parts, and the machine that they are wired to.
pub(crate) struct World {
    pub(crate) plant: Plant,
    pub(crate) adc: Rc<RefCell<Adc>>,
    pub(crate) counter: Rc<RefCell<Counter>>,
    pub(crate) dac: Rc<RefCell<Dac>>,
    /// The output that leads to the valve.
    pub(crate) output: usize,
    pub(crate) lines: [Rc<RefCell<WireState>>; 3],
    pub(crate) bytes: Rc<RefCell<usize>>,
    pub(crate) position_m: f64,
    pub(crate) edges: i64,
    pub(crate) ticks: u32,
    /// Which way the rod turns the encoder: 1 as it should, -1 the wrong way, 0 not at all.
    pub(crate) sense: i32,
    /// Whether the wire of pressure A is intact.
    pub(crate) wired: bool,
    /// Whether there are 100 kΩ to ground at its input.
    pub(crate) pulled: bool,
}

pub(crate) type Wired<C> = Period<Ads8688<Wire<Adc>>, Ls7366r<Wire<Counter>>, Ad5754<Wire<Dac>>, C>;

impl World {
    pub(crate) fn new(plant: Plant) -> Self {
        let line = || Rc::new(RefCell::new(WireState::Whole));
        let mut world = Self {
            plant,
            adc: Rc::new(RefCell::new(Adc::new())),
            counter: Rc::new(RefCell::new(Counter::new())),
            dac: Rc::new(RefCell::new(Dac::new())),
            output: 1,
            lines: [line(), line(), line()],
            bytes: Rc::default(),
            position_m: 0.0,
            edges: 0,
            ticks: 0,
            sense: 1,
            wired: true,
            pulled: true,
        };
        world.tick();
        world
    }

    /// With the valve at the press's own output.
    pub(crate) fn of_press(plant: Plant) -> Self {
        let mut world = Self::new(plant);
        world.output = 0;
        world.tick();
        world
    }

    /// The buses of all three parts: inputs, counter, output.
    pub(crate) fn wires(&self) -> (Wire<Adc>, Wire<Counter>, Wire<Dac>) {
        (self.wire(&self.adc, 0), self.wire(&self.counter, 1), self.wire(&self.dac, 2))
    }

    pub(crate) fn wire<P>(&self, part: &Rc<RefCell<P>>, line: usize) -> Wire<P> {
        Wire { part: part.clone(), line: self.lines[line].clone(), bytes: self.bytes.clone() }
    }

    /// One millisecond of the machine.
    pub(crate) fn tick(&mut self) {
        self.ticks += 1;
        let volts = self.dac.borrow().volts(self.output);
        let seen = (self.plant)(volts);
        self.position_m = seen.position_m;
        #[expect(clippy::cast_possible_truncation, reason = "some 20 000 over the stroke")]
        let edges = (self.position_m * COUNTS_PER_M).round() as i64;
        self.counter.borrow_mut().turn(self.sense * i32::try_from(edges - self.edges).unwrap());
        self.edges = edges;
        // Sensors never give exactly the same value twice.
        let noise_v = f64::from(self.ticks % 2) * 6e-4;
        let pressure_v = |pressure_pa: f64| Some(0.5 + pressure_pa * 4e-7 + noise_v);
        let open_v = if self.pulled { Some(0.2) } else { None };
        let pressure_a_v = if self.wired { pressure_v(seen.pressure_a_pa) } else { open_v };
        let spool_v = Some(seen.spool * 10.0 + noise_v);
        self.adc.borrow_mut().inputs_v =
            [volts, spool_v, pressure_a_v, pressure_v(seen.pressure_b_pa), None, None, None, None];
    }

    pub(crate) fn begin<C: Control>(&self, control: C) -> Wired<C> {
        self.begin_with(control, &machine(), &allowed(), &sensors(), None)
    }

    pub(crate) fn begin_with<C: Control>(
        &self,
        control: C,
        machine: &Machine<f64>,
        allowed: &Allowed,
        sensors: &[(AnalogSignal, Sensor)],
        monitor: Option<Monitor>,
    ) -> Wired<C> {
        let drive = Drive::<PerUnit>::new::<64>(machine, Tick::OneMillisecond).unwrap();
        let bases = drive.bases();
        let ranges = [
            Some(Range::Bipolar10V),
            Some(Range::Bipolar10V),
            Some(Range::Unipolar5V),
            Some(Range::Unipolar5V),
            None,
            None,
            None,
            None,
        ];
        let limits = Limits::new(allowed, machine, bases).unwrap();
        let calibration = Calibration::new(
            sensors,
            <Ads8688<Wire<Adc>> as AnalogIn>::SPAN_UV,
            &Actuator { zero_v: 0.0, full_v: 10.0, lowest_v: -9.6, highest_v: 9.6 },
            <Ad5754<Wire<Dac>> as AnalogOut>::SPAN_UV,
            bases,
        )
        .unwrap();
        let encoder =
            Encoder { counts_per_m: COUNTS_PER_M, rising: Rising::Extends, reference_m: 0.0, fastest_m_per_s: 0.5 };
        let travel = Travel::straight(&encoder, bases).unwrap();
        let delay = &mut embedded_hal_mock::eh1::delay::NoopDelay::new();
        let neutral = calibration.output.count(limits.neutral);
        let output = Ad5754::begin(self.wire(&self.dac, 2), delay, Channel::B, Reference::External, neutral).unwrap();
        let inputs = Ads8688::begin(self.wire(&self.adc, 0), ranges).unwrap();
        let position = Ls7366r::begin(self.wire(&self.counter, 1), FilterClock::Undivided).unwrap();
        let rig = Rig { calibration, travel, limits, monitor };
        Period::begin(Devices { inputs, position, output }, rig, control, Place::Lost).unwrap()
    }
}

pub(crate) fn machine() -> Machine<f64> {
    let mut machine = Machine::with_defaults(Source::Valve);
    machine.set(Parameter::AreaA, 3.117e-3);
    machine.set(Parameter::AreaB, 1.861e-3);
    machine.set(Parameter::VolumeA, 5.2e-4);
    machine.set(Parameter::VolumeB, 3.3e-4);
    machine.set(Parameter::Stroke, STROKE_M);
    machine.set(Parameter::ValveGain, GAIN_PER_V);
    machine.set(Parameter::ValveOffset, OFFSET);
    machine.set(Parameter::DeadZone, OVERLAP);
    machine
}

/// Permitted set points; most of these tests are not about their acceleration.
pub(crate) const BOUNDS: Bounds =
    Bounds { from_m: 0.0, to_m: STROKE_M, velocity_m_per_s: 0.1, acceleration_m_per_s2: 1000.0 };

pub(crate) fn allowed() -> Allowed {
    Allowed {
        attempts: 3,
        settling_s: 0.02,
        bounds: BOUNDS,
        jump_m: 0.3,
        set_point_step_m: 0.0,
        command_v: 9.5,
        slew_v_per_s: 1000.0,
        ramp_v_per_s: 100.0,
        still_position: Some(Delay { by: 0.002, for_s: 0.02 }),
        still_spool: Some(Delay { by: 0.05, for_s: 0.1 }),
        still_pressure: Some(Delay { by: 7e5, for_s: 0.1 }),
        read_back: Some(Delay { by: 0.05, for_s: 0.005 }),
        deviation: Deviation::UNWATCHED,
    }
}

pub(crate) fn sensors() -> [(AnalogSignal, Sensor); 4] {
    let volts = |volts, value| Point { volts, value };
    let pressure = |channel| Sensor {
        channel,
        low: volts(0.5, 0.0),
        high: volts(4.5, 1e7),
        working: Band { from_v: 0.4, to_v: 4.6 },
        open: Some(Band { from_v: 0.0, to_v: 0.3 }),
    };
    let ten_volts = |channel, value: f64| Sensor {
        channel,
        low: volts(-10.0, -value),
        high: volts(10.0, value),
        working: Band { from_v: -10.1, to_v: 10.1 },
        open: None,
    };
    [
        (AnalogSignal::Command, ten_volts(0, 10.0)),
        (AnalogSignal::Spool, ten_volts(1, 1.0)),
        (AnalogSignal::PressureA, pressure(2)),
        (AnalogSignal::PressureB, pressure(3)),
    ]
}
