//! The residual of each link's own balance, from measured signals alone: no simulation, no pointwise derivative.
//!
//! Every balance is weighted with a window function φ(t) (Hann's, so that φ and φ′ vanish at both ends) over a short time; a rate of
//! change becomes ∫φ·ż dt = −∫φ′·z dt, an acceleration ∫φ·z̈ dt = ∫φ″·z dt. With C the capacity of a chamber:
//!
//! ```text
//! r_a = Ca·Δpa +  A·Δy − ∫φ·Qa dt          m³
//! r_b = Cb·Δpb − aA·Δy + ∫φ·Qb dt          m³
//! r_F = m·Δv + D·Δy − ∫φ·(A·pa − aA·pb + F) dt    N s
//! r_v = Δ(y − ŷ)                            m, where no pressures are recorded; ŷ is simulated from the spool
//! ```
//!
//! Each residual is linear in the measured signals, so that the standard deviation that sensor noise alone gives it is known.
//! Residuals of different links are compared as multiples of it.

use identification::experiment::JudgedSignal;
use model_core::drive::Drive;
use model_core::flow::PumpDrive;
use model_core::machine::{Machine, MachineError, Parameter, Source};
use model_core::ports::ChamberState;
use recording::Signal;
use simulation::signal::window::{WINDOW_S, Window, rows_in};
use simulation::{DELAY_LINE, simulate_f64};

use super::case::Case;

/// The flow link at one row, with its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowFlow {
    /// Flow into A, m³/s, less internal leakage.
    pub a: f64,
    /// Flow out of B, m³/s, less internal leakage.
    pub b: f64,
    /// Derivatives of both by the spool, m³/s.
    pub by_spool: (f64, f64),
    /// Derivatives of both by the supply pressure, m³/s/Pa.
    pub by_supply: (f64, f64),
    /// Derivatives of both by the tank pressure, m³/s/Pa.
    pub by_tank: (f64, f64),
    /// −∂Qa/∂pa and ∂Qb/∂pb, m³/s/Pa.
    pub yield_per_pa: (f64, f64),
}

/// All that is known of the drive's state along one recording, one value per row.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The recording's name.
    pub name: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Command, V; zeros where none is recorded.
    pub command: Vec<f64>,
    /// Spool, measured if recorded, else simulated.
    pub spool: Vec<f64>,
    /// Pressure in A, Pa, measured if recorded, else simulated.
    pub pressure_a_pa: Vec<f64>,
    /// Pressure in B, Pa, measured if recorded, else simulated.
    pub pressure_b_pa: Vec<f64>,
    /// Measured position, m.
    pub position_m: Vec<f64>,
    /// Measured less simulated position, m.
    pub missed_m: Vec<f64>,
    /// Velocity, m/s: slope of the position over half a window where both pressures are measured, else simulated.
    pub velocity_m_per_s: Vec<f64>,
    /// Recorded supply less the machine's, Pa.
    pub supply_off_pa: Option<Vec<f64>>,
    /// External force beside the constant one, N.
    pub load_n: Vec<f64>,
    /// Flow link at each row.
    pub flows: Vec<RowFlow>,
    /// Whether both pressures are measured.
    pub has_pressures: bool,
    /// Whether the spool is measured.
    pub has_spool: bool,
    /// Standard deviation of the spool's, both pressures' and the position's noise.
    pub noise: Noise,
}

/// Standard deviations of the sensors' noise, SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Spool.
    pub spool: f64,
    /// Pressure in A, Pa.
    pub a_pa: f64,
    /// Pressure in B, Pa.
    pub b_pa: f64,
    /// Position, m.
    pub position_m: f64,
}

impl Observed {
    /// Computes all of this from a recording; nothing without a recorded position. `case` is driven by the measured spool where there is one.
    pub fn of(machine: &Machine<f64>, case: &Case<'_>) -> Result<Option<Self>, MachineError> {
        let prepared = case.prepared;
        let simulated = simulate_f64(machine, &prepared.stimulus, case.start.offset(machine, prepared))?;
        let channel = |signal| prepared.channels.iter().find(|channel| channel.signal == signal);
        let Some(position) = channel(Signal::Position) else { return Ok(None) };
        let rows = prepared.time_s.len();
        let of = |signal| simulated.signal(signal).map_or_else(|| vec![0.0; rows], <[f64]>::to_vec);
        let best = |signal| channel(signal).map_or_else(|| of(signal), JudgedSignal::bridged);
        let has_pressures = channel(Signal::PressureA).is_some() && channel(Signal::PressureB).is_some();
        let spool_as_read = case.recording.signal(Signal::Spool);
        let position_m = position.bridged();
        let missed_m = position_m.iter().zip(of(Signal::Position)).map(|(measured, simulated)| measured - simulated);
        let time_s = prepared.time_s.clone();
        let velocity_m_per_s = if has_pressures { slopes(&time_s, &position_m) } else { of(Signal::Velocity) };
        let noise_of = |signal| channel(signal).map_or(0.0, JudgedSignal::own_noise);
        let recorded = |signal| case.recording.signal(signal).map(<[f64]>::to_vec);
        let supply = machine.get(Parameter::SupplyPressure);
        let spool_as_read = spool_as_read.map(|values| JudgedSignal::of(Signal::Spool, &time_s, values));
        let spool = spool_as_read.as_ref().map_or_else(|| of(Signal::Spool), JudgedSignal::bridged);
        let mut observed = Self {
            name: prepared.name.clone(),
            command: recorded(Signal::Command).unwrap_or_else(|| vec![0.0; rows]),
            noise: Noise {
                spool: spool_as_read.as_ref().map_or(0.0, |channel| channel.noise),
                a_pa: noise_of(Signal::PressureA),
                b_pa: noise_of(Signal::PressureB),
                position_m: position.own_noise(),
            },
            spool,
            pressure_a_pa: best(Signal::PressureA),
            pressure_b_pa: best(Signal::PressureB),
            missed_m: missed_m.collect(),
            position_m,
            velocity_m_per_s,
            supply_off_pa: recorded(Signal::SupplyPressure)
                .map(|values| values.iter().map(|value| value - supply).collect()),
            load_n: recorded(Signal::LoadForce).unwrap_or_else(|| vec![0.0; rows]),
            flows: Vec::new(),
            has_pressures,
            has_spool: spool_as_read.is_some(),
            time_s,
        };
        observed.flows = observed.flow_link(machine, case)?;
        Ok(Some(observed))
    }

    /// How many rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.time_s.len()
    }

    /// A value for every row.
    pub fn each(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.rows()).map(value).collect()
    }

    fn flow_link(&self, machine: &Machine<f64>, case: &Case<'_>) -> Result<Vec<RowFlow>, MachineError> {
        const SUPPLY_STEP: f64 = 0.01;
        const TANK_STEP_PA: f64 = 1e4;
        const SPOOL_STEP: f64 = 1e-3;
        const PRESSURE_STEP: f64 = 1e-3;
        let (supply, leakage) = (machine.get(Parameter::SupplyPressure), machine.get(Parameter::InternalLeakage));
        let tick = case.prepared.stimulus.tick;
        let link = |machine: &Machine<f64>| Drive::<f64>::new::<DELAY_LINE>(machine, tick);
        let (raised, supply_step) = stepped(machine, Parameter::SupplyPressure, SUPPLY_STEP * supply);
        let (backed, tank_step) = stepped(machine, Parameter::TankPressure, TANK_STEP_PA);
        let (drive, raised, backed) = (link(machine)?, link(&raised)?, link(&backed)?);
        let speed = case.recording.signal(Signal::PumpSpeed);
        let direction = case.recording.signal(Signal::ValveDirection);
        Ok((0..self.rows())
            .map(|row| {
                let pump_rev_per_s = speed.map_or(0.0, |speed| speed[row]);
                let sense = direction.map_or(pump_rev_per_s, |direction| direction[row]);
                let sense = if sense.abs() < 1e-9 {
                    0
                } else if sense > 0.0 {
                    1
                } else {
                    -1
                };
                let at = |drive: &Drive<f64>, spool: f64, a: f64, b: f64| {
                    let bases = drive.bases();
                    let pump = PumpDrive { speed: pump_rev_per_s / bases.pump_speed_rev_per_s, direction: sense };
                    let state = ChamberState { a: a / bases.pressure_pa, b: b / bases.pressure_pa };
                    let flows = drive.flows(spool, pump, state);
                    (flows.a * bases.flow_m3_per_s, flows.b * bases.flow_m3_per_s)
                };
                let (x, a, b) = (self.spool[row], self.pressure_a_pa[row], self.pressure_b_pa[row]);
                let here = at(&drive, x, a, b);
                let per = |there: (f64, f64), step: f64| ((there.0 - here.0) / step, (there.1 - here.1) / step);
                let (above, below) = (at(&drive, x + SPOOL_STEP, a, b), at(&drive, x - SPOOL_STEP, a, b));
                let step = PRESSURE_STEP * supply;
                let (by_a, by_b) = (per(at(&drive, x, a + step, b), step), per(at(&drive, x, a, b + step), step));
                let leaked = leakage * (a - b);
                let by_spool = |above: f64, below: f64| (above - below) / (2.0 * SPOOL_STEP);
                RowFlow {
                    a: here.0 - leaked,
                    b: here.1 - leaked,
                    by_spool: if machine.source == Source::Valve {
                        (by_spool(above.0, below.0), by_spool(above.1, below.1))
                    } else {
                        (0.0, 0.0)
                    },
                    by_supply: per(at(&raised, x, a, b), supply_step),
                    by_tank: per(at(&backed, x, a, b), tank_step),
                    yield_per_pa: ((-by_a.0).max(0.0), by_b.1.max(0.0)),
                }
            })
            .collect())
    }
}

/// A machine with one parameter moved by a step, and the step: downwards where the parameter is at the end of its range.
fn stepped(machine: &Machine<f64>, parameter: Parameter, step: f64) -> (Machine<f64>, f64) {
    let value = machine.get(parameter);
    let step = if value + step > parameter.description().max { -step } else { step };
    (machine.with(&[(parameter, value + step)]), step)
}

/// Slope of a series at each row: of a straight line fitted to the rows of half a window around it.
fn slopes(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let half = (rows_in(time_s, 0.5 * WINDOW_S) / 2).max(1);
    (0..values.len())
        .map(|row| {
            let (from, to) = (row.saturating_sub(half), (row + half).min(values.len() - 1));
            let count = (to - from + 1) as f64;
            let middle = time_s[from..=to].iter().sum::<f64>() / count;
            let mean = values[from..=to].iter().sum::<f64>() / count;
            let (mut above, mut below) = (0.0, 0.0);
            for index in from..=to {
                above += (time_s[index] - middle) * (values[index] - mean);
                below += (time_s[index] - middle).powi(2);
            }
            above / below
        })
        .collect()
}

/// Which balance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Balance {
    /// Oil of chamber A, `r_a`.
    ChamberA,
    /// Oil of chamber B, `r_b`.
    ChamberB,
    /// Measured spool against the one that the valve computes from the command, `r_x`.
    Spool,
    /// Momentum of the rod, `r_F`.
    Force,
    /// Measured motion against the simulated one, `r_v`.
    Motion,
}

/// One balance over one window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residual {
    /// Which.
    pub balance: Balance,
    /// The residual, SI.
    pub value: f64,
    /// Standard deviation that sensor noise alone gives it.
    pub sigma: f64,
}

/// Coefficients of the balances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Piston areas, m².
    pub area: (f64, f64),
    /// Capacities of the chambers, m³/Pa.
    pub capacity: (f64, f64),
    /// Mass, kg.
    pub mass: f64,
    /// Viscous friction, N s/m.
    pub damping: f64,
    /// Constant load, N.
    pub load: f64,
}

impl Coefficients {
    /// Those of a machine.
    #[must_use]
    pub fn of(machine: &Machine<f64>) -> Self {
        let get = |parameter| machine.get(parameter);
        let capacity = |volume| get(volume) / get(Parameter::BulkModulus) + get(Parameter::HoseCompliance);
        Self {
            area: (get(Parameter::AreaA), get(Parameter::AreaB)),
            capacity: (capacity(Parameter::VolumeA), capacity(Parameter::VolumeB)),
            mass: get(Parameter::MovingMass),
            damping: get(Parameter::ViscousFriction),
            load: get(Parameter::LoadForce),
        }
    }
}

/// The residuals of every window, one window after the other: oil and momentum where both pressures are measured, else the motion.
/// Without `force` the load was taken from the pressures, so that the balance of forces says nothing and is left out.
#[must_use]
pub fn residuals(observed: &Observed, by: &Coefficients, windows: &[Window], force: bool) -> Vec<Residual> {
    let noise = &observed.noise;
    let of_motion = |window: &Window| noise.position_m.powi(2) * window.variance(|_| [0.0, 1.0, 0.0]);
    if !observed.has_pressures {
        return windows
            .iter()
            .map(|window| Residual {
                balance: Balance::Motion,
                value: window.change(&observed.missed_m),
                sigma: of_motion(window).sqrt(),
            })
            .collect();
    }
    let (area_a, area_b) = by.area;
    let (capacity_a, capacity_b) = by.capacity;
    let flows = &observed.flows;
    let (flow_a, flow_b) = (observed.each(|row| flows[row].a), observed.each(|row| flows[row].b));
    let driven = observed.each(|row| {
        area_a * observed.pressure_a_pa[row] - area_b * observed.pressure_b_pa[row] + by.load + observed.load_n[row]
    });
    let mut found = Vec::with_capacity(3 * windows.len());
    for window in windows {
        let (moved, of_motion) = (window.change(&observed.position_m), of_motion(window));
        let of_spool =
            |of: fn(&RowFlow) -> f64| noise.spool.powi(2) * window.variance(|row| [of(&flows[row]), 0.0, 0.0]);
        let a = capacity_a * window.change(&observed.pressure_a_pa) + area_a * moved - window.sum(&flow_a);
        let of_a = noise.a_pa.powi(2) * window.variance(|row| [flows[row].yield_per_pa.0, capacity_a, 0.0])
            + of_spool(|flow| flow.by_spool.0)
            + area_a.powi(2) * of_motion;
        let b = capacity_b * window.change(&observed.pressure_b_pa) - area_b * moved + window.sum(&flow_b);
        let of_b = noise.b_pa.powi(2) * window.variance(|row| [flows[row].yield_per_pa.1, capacity_b, 0.0])
            + of_spool(|flow| flow.by_spool.1)
            + area_b.powi(2) * of_motion;
        found.push(Residual { balance: Balance::ChamberA, value: a, sigma: of_a.sqrt() });
        found.push(Residual { balance: Balance::ChamberB, value: b, sigma: of_b.sqrt() });
        if force {
            let value = by.mass * window.curvature(&observed.position_m) + by.damping * moved - window.sum(&driven);
            let of_pressures = (noise.a_pa * area_a).powi(2) + (noise.b_pa * area_b).powi(2);
            let variance = of_pressures * window.variance(|_| [1.0, 0.0, 0.0])
                + noise.position_m.powi(2) * window.variance(|_| [0.0, by.damping, by.mass]);
            found.push(Residual { balance: Balance::Force, value, sigma: variance.sqrt() });
        }
    }
    found
}

/// The spool's balance over every window: recorded less simulated from the command, each row's `missed` in standard deviations
/// of the noise. The noise is also estimated from these residuals, in case the spool's own signal hides a part of it.
#[must_use]
pub fn spool_residuals(missed: &[f64], windows: &[Window]) -> Vec<Residual> {
    let noise = simulation::signal::noise::noise(missed, 0.0).max(1.0);
    windows
        .iter()
        .map(|window| Residual {
            balance: Balance::Spool,
            value: window.sum(missed),
            sigma: noise * window.variance(|_| [1.0, 0.0, 0.0]).sqrt(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use test_press::press;

    use super::*;

    #[test]
    fn a_parameter_at_the_end_of_its_range_steps_back_into_it() {
        let most = Parameter::TankPressure.description().max;
        for (value, step) in [(2e5, 1e4), (most, -1e4)] {
            let (machine, taken) = stepped(&press(&[(Parameter::TankPressure, value)]), Parameter::TankPressure, 1e4);
            assert!((taken - step).abs() < 1e-9 && machine.check().is_ok(), "{value}");
        }
    }
}
