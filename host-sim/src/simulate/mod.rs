//! Recording → simulation: the core driven by what was recorded.
//!
//! A [`Stimulus`] is a recording laid on the core's tick grid. [`run`] steps the core over it in any number type and hands out the
//! signals at the recorded rows.

mod grid;
mod rest;
mod stimulus;

use model_core::chambers::ChamberState;
use model_core::drive::{Drive, DriveState, Entry};
use model_core::machine::{Machine, MachineError};
use model_core::number::{Number, Real};
use model_core::parameter::Parameter;
use model_core::valve::Slider;

pub use rest::Start;
pub use stimulus::{EntryPoint, SimulateError, Stimulus, first_entry, natural_tick};

use crate::recording::Signal;

/// Ticks of delay line on the desktop: more than a quarter of a second at any tick.
pub const DELAY_LINE: usize = 512;

/// Signals of the chain at one recorded row, as the sensors read them, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<R> {
    /// Slider position, 1.
    pub spool: R,
    /// Supply pressure at the valve, Pa; without droop it is the machine's.
    pub supply_pressure_pa: R,
    /// Flow into A, m³/s; 0 where the stimulus does not want it.
    pub flow_a_m3_per_s: R,
    /// Pressure in A, Pa.
    pub pressure_a_pa: R,
    /// Pressure in B, Pa.
    pub pressure_b_pa: R,
    /// Force of the oil on the rod as it follows from both pressures, N.
    pub force_n: R,
    /// Velocity, m/s.
    pub velocity_m_per_s: R,
    /// Position, m.
    pub position_m: R,
}

impl<R: Real> Sample<R> {
    /// The value of a recorded signal, if the chain computes it.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<R> {
        match signal {
            Signal::Spool => Some(self.spool),
            Signal::SupplyPressure => Some(self.supply_pressure_pa),
            Signal::Flow => Some(self.flow_a_m3_per_s),
            Signal::PressureA => Some(self.pressure_a_pa),
            Signal::PressureB => Some(self.pressure_b_pa),
            Signal::Force => Some(self.force_n),
            Signal::Velocity => Some(self.velocity_m_per_s),
            Signal::Position => Some(self.position_m),
            _ => None,
        }
    }

    fn between(a: Self, b: Self, share: f64) -> Self {
        let mix = |a: R, b: R| a + (b - a) * R::constant(share);
        Self {
            spool: mix(a.spool, b.spool),
            supply_pressure_pa: mix(a.supply_pressure_pa, b.supply_pressure_pa),
            flow_a_m3_per_s: mix(a.flow_a_m3_per_s, b.flow_a_m3_per_s),
            pressure_a_pa: mix(a.pressure_a_pa, b.pressure_a_pa),
            pressure_b_pa: mix(a.pressure_b_pa, b.pressure_b_pa),
            force_n: mix(a.force_n, b.force_n),
            velocity_m_per_s: mix(a.velocity_m_per_s, b.velocity_m_per_s),
            position_m: mix(a.position_m, b.position_m),
        }
    }
}

/// Signals that the chain computes below an entry, in its order. A supply pressure only where the valve draws from it.
#[must_use]
pub fn computed_below(entry: EntryPoint) -> &'static [Signal] {
    const ALL: &[Signal] = &[
        Signal::Spool,
        Signal::SupplyPressure,
        Signal::Flow,
        Signal::PressureA,
        Signal::PressureB,
        Signal::Force,
        Signal::Velocity,
        Signal::Position,
    ];
    match entry {
        EntryPoint::Command => ALL,
        EntryPoint::Slider => &ALL[1..],
        EntryPoint::Pump => &ALL[2..],
        EntryPoint::Flow => &ALL[3..],
        EntryPoint::Force => &ALL[6..],
    }
}

/// The signals of a simulation at the recorded rows, in SI units.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Trajectory {
    /// One series for each signal computed below the entry.
    pub series: Vec<(Signal, Vec<f64>)>,
}

impl Trajectory {
    /// A computed signal.
    #[must_use]
    pub fn signal(&self, signal: Signal) -> Option<&[f64]> {
        self.series.iter().find(|(found, _)| *found == signal).map(|(_, values)| values.as_slice())
    }
}

/// Freedom of a run beyond the recording: what a fit may move about the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StartOffset<R> {
    /// Share of supply pressure in chamber B at rest, where pressures are not recorded; the machine's where it is `None`.
    pub level: Option<R>,
    /// What the rod stands further out than the recording's start, m: less than its sensor resolves.
    pub shift_m: R,
}

impl<R: Real> StartOffset<R> {
    /// The machine's level, and the position as recorded.
    #[must_use]
    pub fn none() -> Self {
        Self { level: None, shift_m: R::ZERO }
    }
}

/// Pressures at the start where the recording has none: the level in B, and the balance of forces.
fn balanced<R: Real>(machine: &Machine<R>, level: R, position_m: R) -> (R, R) {
    let get = |parameter| machine.get(parameter);
    let beyond = position_m - get(Parameter::Stroke) * R::constant(0.5);
    let spring = get(Parameter::LoadSpringForce)
        + beyond * (get(Parameter::LoadSpring) + beyond * get(Parameter::LoadSpringBow));
    let force = get(Parameter::LoadForce) - spring;
    let supply = get(Parameter::SupplyPressure);
    let a = (level * supply * get(Parameter::AreaB) - force) / get(Parameter::AreaA);
    let (low, high) = (supply * R::constant(0.02), supply * R::constant(0.98));
    let a = if a < low {
        low
    } else if a > high {
        high
    } else {
        a
    };
    let b = (a * get(Parameter::AreaA) + force) / get(Parameter::AreaB);
    (
        a,
        if b < low {
            low
        } else if b > high {
            high
        } else {
            b
        },
    )
}

/// Runs the core over a stimulus and hands each recorded row's sample to `sink`, in order.
pub fn run<N: Number>(
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    offset: StartOffset<N::Real>,
    mut sink: impl FnMut(usize, &Sample<N::Real>),
) -> Result<(), MachineError> {
    let machine = &unbraked(machine, stimulus);
    let drive = Drive::<N>::new::<DELAY_LINE>(machine, stimulus.tick)?;
    let bases = *drive.bases();
    let constant = N::Real::constant;
    let position_m = constant(stimulus.start.position_m) + offset.shift_m;
    let (pressure_a, pressure_b) = match stimulus.start.pressures_pa {
        Some((a, b)) => (behind(machine, PRESSURE_A, constant(a)), behind(machine, PRESSURE_B, constant(b))),
        None => balanced(machine, offset.level.unwrap_or(machine.get(Parameter::LevelAtRest)), position_m),
    };
    let fit = |value: N::Real| N::signal(value).unwrap_or_else(|| N::saturated(value.value()));
    let pressures = ChamberState {
        a: fit(pressure_a / constant(bases.pressure_pa)),
        b: fit(pressure_b / constant(bases.pressure_pa)),
    };
    let position = N::travel(position_m / machine.get(Parameter::Stroke));
    let command = N::saturated(stimulus.start.command_v / bases.command_v);
    let mut state: DriveState<N, DELAY_LINE> = drive.at_rest(command, pressures, position);

    let mut rows = stimulus.rows.iter().enumerate().peekable();
    let mut before = sample(&drive, machine, stimulus, &state, 0);
    for point in 0..=stimulus.ticks {
        if point > 0 {
            let tick = point - 1;
            let entry = entered(machine, stimulus.entry_at(tick, &bases));
            if let Some(temperature) = stimulus.oil_at(tick, &bases) {
                state.oil_temperature = temperature;
            }
            drive.step(&mut state, entry, stimulus.load_at(tick, &bases));
        }
        // A row lies on this point, or in the tick before it.
        let wanted = |at: usize, share: f64| if share == 0.0 { at == point } else { at + 1 == point };
        if rows.peek().is_none_or(|(_, (at, _))| *at > point) {
            continue;
        }
        let now = sample(&drive, machine, stimulus, &state, point);
        while let Some((row, &(_, share))) = rows.next_if(|(_, (at, share))| wanted(*at, *share)) {
            if share == 0.0 {
                sink(row, &now);
            } else {
                sink(row, &Sample::between(before, now, share));
            }
        }
        before = now;
    }
    Ok(())
}

/// Gain error and offset of a sensor.
type SensorError = (Parameter, Parameter);
const PRESSURE_A: SensorError = (Parameter::PressureAFactor, Parameter::PressureAOffset);
const PRESSURE_B: SensorError = (Parameter::PressureBFactor, Parameter::PressureBOffset);
const SPOOL: SensorError = (Parameter::SpoolFactor, Parameter::SpoolOffset);

/// The true value behind what a sensor read: (reading − offset)/(1 + factor).
fn behind<R: Real>(machine: &Machine<R>, (factor, offset): SensorError, reading: R) -> R {
    (reading - machine.get(offset)) / (R::ONE + machine.get(factor))
}

/// What the chain is entered with where the recording has the reading of a sensor.
fn entered<N: Number>(machine: &Machine<N::Real>, entry: Entry<N>) -> Entry<N> {
    let true_slider = |Slider { from, to }| Slider { from: true_slider(machine, from), to: true_slider(machine, to) };
    match entry {
        Entry::Slider(slider) => Entry::Slider(true_slider(slider)),
        Entry::Followed { command, slider } => Entry::Followed { command, slider: true_slider(slider) },
        other => other,
    }
}

fn true_slider<N: Number>(machine: &Machine<N::Real>, reading: N) -> N {
    let (factor, offset) = SPOOL;
    if machine.get(factor).is_nil() && machine.get(offset).is_nil() {
        return reading;
    }
    let slider = behind(machine, SPOOL, reading.to_real());
    N::signal(slider).unwrap_or_else(|| N::saturated(slider.value()))
}

/// What a load that balances the recorded pressures holds already: every force on the rod but viscous friction and the constant load.
const BALANCED: [Parameter; 17] = [
    Parameter::CoulombFriction,
    Parameter::StribeckForce,
    Parameter::StribeckExcess,
    Parameter::AsymmetricExtending,
    Parameter::AsymmetricRetracting,
    Parameter::PositionFriction,
    Parameter::PositionFrictionSlope,
    Parameter::PositionFrictionBow,
    Parameter::PositionDragSlope,
    Parameter::PositionDragBow,
    Parameter::PressureFriction,
    Parameter::PreslidingForce,
    Parameter::LoadSpring,
    Parameter::LoadSpringForce,
    Parameter::LoadSpringBow,
    Parameter::StopStiffness,
    Parameter::StopDamping,
];

/// The machine with light damping in place of its friction where the load balances the recorded pressures.
fn unbraked<R: Real>(machine: &Machine<R>, stimulus: &Stimulus) -> Machine<R> {
    let mut machine = *machine;
    if let Some(damping) = stimulus.damping {
        machine.set(Parameter::ViscousFriction, R::constant(damping));
        for parameter in BALANCED {
            machine.set(parameter, R::ZERO);
        }
        // So is a table of forces.
        if (machine.get(Parameter::TableQuantity).value() - 1.0).abs() < 0.5 {
            machine.set(Parameter::TableQuantity, R::ZERO);
        }
    }
    machine
}

fn sample<N: Number>(
    drive: &Drive<N>,
    machine: &Machine<N::Real>,
    stimulus: &Stimulus,
    state: &DriveState<N, DELAY_LINE>,
    point: usize,
) -> Sample<N::Real> {
    let bases = drive.bases();
    let constant = N::Real::constant;
    let sensed = drive.sensed(state);
    let recorded = stimulus.metering_at::<N>(point);
    let slider = recorded.map_or_else(|| drive.slider(state), |reading| true_slider(machine, reading));
    let read = recorded.filter(|_| stimulus.entry == EntryPoint::Slider).unwrap_or(sensed.spool);
    let supply = state.supply.pressure;
    let flow_a = if stimulus.wants_flow {
        drive.flows_from(supply, slider, stimulus.pump_at(point, bases), state.chambers).a
    } else {
        N::ZERO
    };
    let pressure_a_pa = sensed.pressure_a.to_real() * constant(bases.pressure_pa);
    let pressure_b_pa = sensed.pressure_b.to_real() * constant(bases.pressure_pa);
    Sample {
        spool: read.to_real(),
        supply_pressure_pa: supply.to_real() * constant(bases.pressure_pa),
        flow_a_m3_per_s: flow_a.to_real() * constant(bases.flow_m3_per_s),
        pressure_a_pa,
        pressure_b_pa,
        force_n: machine.get(Parameter::AreaA) * pressure_a_pa - machine.get(Parameter::AreaB) * pressure_b_pa,
        velocity_m_per_s: sensed.velocity.to_real() * constant(bases.velocity_m_per_s),
        position_m: N::strokes(sensed.position) * machine.get(Parameter::Stroke),
    }
}

/// A whole simulation in a plain number type.
pub fn simulate<N: Number<Real = f64>>(
    machine: &Machine<f64>,
    stimulus: &Stimulus,
    offset: StartOffset<f64>,
) -> Result<Trajectory, MachineError> {
    let signals = computed_below(stimulus.entry);
    let mut series: Vec<(Signal, Vec<f64>)> =
        signals.iter().map(|&signal| (signal, Vec::with_capacity(stimulus.rows()))).collect();
    run::<N>(machine, stimulus, offset, |_, sample| {
        for (signal, values) in &mut series {
            values.extend(sample.signal(*signal));
        }
    })?;
    Ok(Trajectory { series })
}

#[cfg(test)]
mod tests;
