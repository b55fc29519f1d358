//! The drive of a case on its bench: signals that keep it inside its stroke, and the recordings made.

use model_core::machine::{Machine, Parameter as P, Source};
use recording::seeded_noise::Noise;

use super::{Channels, Mode, signals};
use crate::effect::PlantEffect;
use crate::excitation::input::{LoadProfile, PumpCommand};
use crate::plant::{InitialState, Plant, PlantError};
use crate::rig::recorded::SyntheticRecording;
use crate::rig::run::{Bench, Drive};
use crate::sensor::sensors::{PositionSensor, PressureSensor, Sensors, SpoolSensor, Thermometer};

/// Tolerance of drawn recordings: an order of magnitude below what their sensors resolve.
const TOLERANCE: f64 = 1e-6;
/// The drive settles before the recording starts, s.
const SETTLING_S: f64 = 0.4;
/// Share of the stroke that is kept free at each end.
const MARGIN: f64 = 0.02;

/// The excitation of a recording; it is scaled until the rod stays inside its stroke.
#[derive(Clone, Debug)]
pub(crate) struct RunInput {
    /// Within ±1, from the start of the recording.
    pub(crate) shape: Vec<f64>,
    /// V, or m in closed loop; towards extending and retracting.
    pub(crate) amplitude: [f64; 2],
    /// Where the recording starts, m.
    pub(crate) start_m: f64,
    pub(crate) seed: u64,
    pub(crate) load: LoadProfile,
    /// Temperature of the oil where it is measured, °C.
    pub(crate) oil_c: Option<f64>,
}

/// What all recordings of a case have in common.
#[derive(Clone, Debug)]
pub(crate) struct Setting {
    pub(crate) machine: Machine<f64>,
    pub(crate) mode: Mode,
    pub(crate) channels: Channels,
    pub(crate) tick_s: f64,
    /// Relative to the usual noise.
    pub(crate) noise: f64,
    pub(crate) pressure_noise_share: f64,
    pub(crate) pressure_bits: u8,
    /// V and Hz.
    pub(crate) dither: (f64, f64),
    /// V/m.
    pub(crate) gain_v_per_m: f64,
}

impl Setting {
    /// The sensors of the case.
    pub(crate) fn sensors(&self) -> Sensors {
        let supply_pa = self.machine.get(P::SupplyPressure);
        Sensors {
            spool: SpoolSensor { counts_per_unit: 32_768.0, noise_std: 5e-4 * self.noise },
            position: PositionSensor::Linear { resolution_m: 2.5e-5 },
            position_noise_m: 8e-6 * self.noise,
            pressure: PressureSensor {
                noise_std_pa: self.pressure_noise_share * supply_pa * self.noise,
                range_pa: 1.5 * supply_pa,
                bits: self.pressure_bits,
            },
            sees_supply: self.channels == Channels::Full,
        }
    }

    /// Standard deviations of spool, position, both pressures, rounding included.
    pub(crate) fn noise_of(&self) -> [f64; 4] {
        let sensors = self.sensors();
        let with_step = |std: f64, step: f64| std.hypot(step / 12.0_f64.sqrt());
        let pressure_step = sensors.pressure.range_pa * 2.0_f64.powi(1 - i32::from(self.pressure_bits));
        let pressure = with_step(sensors.pressure.noise_std_pa, pressure_step);
        [
            with_step(sensors.spool.noise_std, 1.0 / sensors.spool.counts_per_unit),
            with_step(sensors.position_noise_m, 2.5e-5),
            pressure,
            pressure,
        ]
    }

    /// A run of the drive with these effects from rest, without the settling time before the recording.
    pub(crate) fn run(&self, effects: &[PlantEffect], signal: &RunInput) -> Result<SyntheticRecording, PlantError> {
        let settling = signals::ticks(SETTLING_S, self.tick_s);
        let shape = std::iter::repeat_n(0.0, settling).chain(signal.shape.iter().copied());
        let scaled: Vec<f64> = shape.map(|s| s * signal.amplitude[usize::from(s < 0.0)]).collect();
        let drive = match self.mode {
            Mode::Closed => Drive::Closed {
                reference_m: scaled.iter().map(|off_m| signal.start_m + off_m).collect(),
                gain_v_per_m: self.gain_v_per_m,
            },
            Mode::Open => Drive::Commands(scaled),
            Mode::Pump => {
                // The bench holds a speed over a tick, but a real pump changes it continuously: the mean over the tick is used.
                let next = scaled.iter().skip(1).chain(scaled.last());
                Drive::Pump(scaled.iter().zip(next).map(|(now, next)| turning(0.5 * (now + next))).collect())
            }
            Mode::Dither => {
                let (volts, hertz) = self.dither;
                let dither = |tick: usize| {
                    let since_s = (tick.max(settling) - settling) as f64 * self.tick_s;
                    volts * libm::sin(std::f64::consts::TAU * hertz * since_s)
                };
                Drive::Commands(scaled.iter().enumerate().map(|(tick, volts)| volts + dither(tick)).collect())
            }
        };
        let thermometer = signal.oil_c.map(|oil_c| Thermometer { oil_c, noise_std_k: 0.1, resolution_k: 0.01 });
        let bench = self.bench(effects, signal, self.sensors(), self.load_later(signal))?;
        let mut recording =
            Bench { thermometer, ..bench }.record(&drive, &InitialState::at_rest(&self.machine, signal.start_m))?;
        recording.cut_before(settling);
        Ok(recording)
    }

    /// The same commands applied to another drive, seen by ideal sensors.
    pub(crate) fn repeat(
        &self,
        machine: &Machine<f64>,
        effects: &[PlantEffect],
        made: &SyntheticRecording,
        signal: &RunInput,
        pushed: bool,
    ) -> Result<SyntheticRecording, PlantError> {
        let settling = signals::ticks(SETTLING_S, self.tick_s);
        let drive = if self.mode == Mode::Pump {
            Drive::Pump(held_before(&made.pump, settling))
        } else {
            Drive::Commands(held_before(&made.command_v, settling))
        };
        let load = if pushed { self.load_later(signal) } else { LoadProfile::none() };
        let other = Self { machine: *machine, ..self.clone() };
        let mut recording =
            other.bench(effects, signal, Sensors::exact(), load)?.record(&drive, &resting(machine, signal.start_m))?;
        recording.cut_before(settling);
        Ok(recording)
    }

    fn load_later(&self, signal: &RunInput) -> LoadProfile {
        signal.load.later(signals::ticks(SETTLING_S, self.tick_s) as f64 * self.tick_s)
    }

    fn bench(
        &self,
        effects: &[PlantEffect],
        signal: &RunInput,
        sensors: Sensors,
        load: LoadProfile,
    ) -> Result<Bench, PlantError> {
        let in_oil = |effect: &PlantEffect| signal.oil_c.map_or(*effect, |oil_c| effect.in_oil_at(oil_c));
        let effects: Vec<PlantEffect> = effects.iter().map(in_oil).collect();
        let plant = Plant::new(&self.machine, TOLERANCE)?.with_effects(&effects).with_load(load);
        Ok(Bench { tick_s: self.tick_s, seed: signal.seed, ..Bench::new(plant, sensors) })
    }

    /// The recording, after the signal was made smaller and the start was moved until the rod stays inside its stroke.
    pub(crate) fn fitted(
        &self,
        effects: &[PlantEffect],
        signal: &mut RunInput,
    ) -> Result<Option<SyntheticRecording>, PlantError> {
        let stroke_m = self.machine.get(P::Stroke);
        for _ in 0..14 {
            let recording = self.run(effects, signal)?;
            let (low, high) = travel(&recording);
            if low > MARGIN * stroke_m && high < (1.0 - MARGIN) * stroke_m {
                return Ok(Some(recording));
            }
            let room_m = (1.0 - 4.0 * MARGIN) * stroke_m;
            if high - low < room_m && self.mode != Mode::Closed {
                signal.start_m += 0.5 * stroke_m - 0.5 * (low + high);
                signal.start_m = signal.start_m.clamp(2.0 * MARGIN * stroke_m, (1.0 - 2.0 * MARGIN) * stroke_m);
                continue;
            }
            // The side towards which the rod drifts is driven less; if it does not drift, both sides are.
            let ends = recording.truth.first().zip(recording.truth.last());
            let wandered = ends.map_or(0.0, |(first, last)| last.position_m - first.position_m);
            let [extending, retracting] = &mut signal.amplitude;
            let drifts = wandered.abs() > 0.4 * (high - low);
            if !drifts || wandered > 0.0 {
                *extending *= 0.85;
            }
            if !drifts || wandered < 0.0 {
                *retracting *= 0.85;
            }
        }
        Ok(None)
    }
}

/// Signed turns per second as a command of the pump and its directional valve; the valve is closed at rest.
fn turning(signed_rev_per_s: f64) -> PumpCommand {
    let direction = if signed_rev_per_s.abs() < 1e-3 {
        0
    } else if signed_rev_per_s > 0.0 {
        1
    } else {
        -1
    };
    PumpCommand { speed_rev_per_s: signed_rev_per_s.abs(), direction }
}

/// Commands, preceded by some rows in which the first one is held.
fn held_before<T: Copy>(commands: &[T], rows: usize) -> Vec<T> {
    let before = commands.first().into_iter().flat_map(|&first| std::iter::repeat_n(first, rows));
    before.chain(commands.iter().copied()).collect()
}

/// At rest; in a pump drive the chambers are near the tank's pressure, in a valve drive at half the supply pressure.
fn resting(machine: &Machine<f64>, position_m: f64) -> InitialState {
    match machine.source {
        Source::Valve | Source::Force => InitialState::at_rest(machine, position_m),
        Source::Pump => InitialState::at_rest_with_level(machine, position_m, 2.0e6),
    }
}

/// Lowest and highest true position, m.
pub(crate) fn travel(recording: &SyntheticRecording) -> (f64, f64) {
    let positions = recording.truth.iter().map(|state| state.position_m);
    positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)))
}

/// Adds occasional spikes, independent of the signal, of up to three of its standard deviations.
pub(crate) fn spiked(values: &mut [f64], rate: f64, dice: &mut Noise) {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt();
    for value in values.iter_mut() {
        if dice.happens(rate) {
            *value += dice.sign() * dice.uniform(0.5, 3.0) * deviation;
        }
    }
}
