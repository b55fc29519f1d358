//! The machine on the bench: plant, sensors, and a controller at its period.

use firmware::set_point::{Bounds, Course, CourseState, Leg, SetPoint};
use model_core::machine::{Bases, Machine, Parameter as P, Tick};
use virtual_plant::sensor::sensors::{PositionSensor, PressureSensor};
use virtual_plant::{Command, InitialState, LoadProfile, Plant, PlantEffect, PlantState, Sensors};

/// The control period.
pub const TICK: Tick = Tick::OneMillisecond;
/// The output card's range, V: the same for every controller.
pub const COMMAND_LIMIT_V: f64 = 10.0;
/// The output's slew, V/s: the same for every controller.
pub const SLEW_V_PER_S: f64 = 2000.0;
/// Relative tolerance of the plant: its error is far below the resolution of a sensor.
const TOLERANCE: f64 = 1e-6;

/// What the sensors show in a period, SI units.
#[derive(Clone, Copy, Debug, Default)]
pub struct Readings {
    /// Position of the rod, m.
    pub position_m: f64,
    /// Spool, of full travel.
    pub spool: f64,
    /// Pressure in A, Pa.
    pub pressure_a_pa: f64,
    /// Pressure in B, Pa.
    pub pressure_b_pa: f64,
}

/// Set point in SI units.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Position, m.
    pub position_m: f64,
    /// The same set point in the firmware's format.
    pub per_unit: SetPoint,
}

/// A controller: gives the command of a period, V.
pub trait Controller {
    /// Called once a period, with what is wanted and what the sensors show.
    fn command_v(&mut self, wanted: Wanted, seen: &Readings) -> f64;
}

/// A machine with its load and its set points.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The machine's values.
    pub machine: Machine<f64>,
    /// Effects that it has beyond these values.
    pub effects: Vec<PlantEffect>,
    /// Force on the rod over time.
    pub load: LoadProfile,
    /// Set points, one a period.
    pub wanted: Vec<Wanted>,
    /// Its sensors.
    pub sensors: Sensors,
    /// How long a period really lasts, s.
    pub period_s: f64,
}

/// One period of a run.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Wanted position of the rod, m.
    pub wanted_m: f64,
    /// True position of the rod, m.
    pub true_m: f64,
}

/// Scales of a machine's fixed-point signals.
#[must_use]
pub fn bases(machine: &Machine<f64>) -> Bases {
    *crate::simulate::drive::<model_core::number::PerUnit>(machine, TICK).bases()
}

/// The set points of `legs` from a position.
///
/// # Panics
/// There are no legs.
#[must_use]
pub fn course(machine: &Machine<f64>, bounds: &Bounds, from_m: f64, legs: &[Leg]) -> Vec<Wanted> {
    let bases = bases(machine);
    let course = Course::<16>::new(&bases, bounds, from_m, legs).unwrap();
    let mut state = CourseState::default();
    let wanted = |per_unit: SetPoint| Wanted { position_m: per_unit.position.to_f64() * bases.stroke_m, per_unit };
    (0..course.ticks()).map(|_| wanted(course.step(&mut state))).collect()
}

impl Rig {
    /// With the paper's sensors.
    ///
    /// # Panics
    /// The machine has no sensors.
    #[must_use]
    pub fn new(machine: &Machine<f64>, wanted: Vec<Wanted>) -> Self {
        let sensors = Sensors::of(machine).unwrap();
        Self {
            machine: *machine,
            effects: Vec::new(),
            load: LoadProfile::none(),
            wanted,
            sensors,
            period_s: TICK.seconds(),
        }
    }

    /// What the sensors show before anything has moved.
    ///
    /// # Panics
    /// There are no set points.
    #[must_use]
    pub fn at_rest(&self) -> Readings {
        let initial = self.initial();
        let state = PlantState {
            pressure_a_pa: initial.pressure_a_pa,
            pressure_b_pa: initial.pressure_b_pa,
            position_m: initial.position_m,
            ..PlantState::default()
        };
        Eyes::new(self.sensors).read(&state)
    }

    fn initial(&self) -> InitialState {
        InitialState::at_rest(&self.machine, self.wanted[0].position_m)
    }

    /// Runs the controller on the machine.
    ///
    /// # Panics
    /// The plant cannot be simulated, or a command leaves the output's range.
    pub fn run(&self, controller: &mut dyn Controller) -> Vec<Row> {
        let plant = Plant::new(&self.machine, TOLERANCE).unwrap();
        let plant = plant.with_effects(&self.effects).with_load(self.load.clone());
        let times_s: Vec<f64> = (0..self.wanted.len()).map(|tick| tick as f64 * self.period_s).collect();
        let mut eyes = Eyes::new(self.sensors);
        let mut rows = Vec::with_capacity(self.wanted.len());
        plant
            .run(&self.initial(), &times_s, |tick, state| {
                let wanted = self.wanted[tick];
                let command_v = controller.command_v(wanted, &eyes.read(state));
                assert!(command_v.abs() <= COMMAND_LIMIT_V + 1e-6, "{command_v} V at tick {tick}");
                rows.push(Row { wanted_m: wanted.position_m, true_m: state.position_m });
                Command::Valve(command_v)
            })
            .unwrap();
        rows
    }
}

/// Root of the mean square of the true distance to the set point, mm.
#[must_use]
pub fn rms_mm(rows: &[Row]) -> f64 {
    let squares: f64 = rows.iter().map(|row| (row.wanted_m - row.true_m).powi(2)).sum();
    1e3 * (squares / rows.len() as f64).sqrt()
}

/// Largest true distance to the set point, mm.
#[must_use]
pub fn worst_mm(rows: &[Row]) -> f64 {
    1e3 * rows.iter().map(|row| (row.wanted_m - row.true_m).abs()).fold(0.0, f64::max)
}

/// The test bed's sensors on the plant, with noise that repeats.
struct Eyes {
    sensors: Sensors,
    random: u64,
}

impl Eyes {
    fn new(sensors: Sensors) -> Self {
        Self { sensors, random: 1 }
    }

    /// Standard normal, as the sum of twelve uniform numbers: without tails, which make no difference to a controller.
    fn noise(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            // splitmix64
            *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut mixed = *state;
            mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.random)).sum::<f64>() - 6.0
    }

    fn read(&mut self, state: &PlantState) -> Readings {
        let PressureSensor { noise_std_pa, range_pa, bits } = self.sensors.pressure;
        let step_pa = range_pa / f64::from(1_u32 << (bits - 1));
        let mut pressure = |pressure_pa: f64| ((pressure_pa + noise_std_pa * self.noise()) / step_pa).round() * step_pa;
        let (pressure_a_pa, pressure_b_pa) = (pressure(state.pressure_a_pa), pressure(state.pressure_b_pa));
        let counts = self.sensors.spool.counts_per_unit;
        let position: &PositionSensor = &self.sensors.position;
        Readings {
            position_m: position.measure(state.position_m),
            spool: (state.spool * counts).round() / counts,
            pressure_a_pa,
            pressure_b_pa,
        }
    }
}

/// Largest force of the oil, extending, N.
#[must_use]
pub fn largest_force_n(machine: &Machine<f64>) -> f64 {
    machine.get(P::AreaA) * machine.get(P::SupplyPressure)
}
