//! A run on the test bed: from plant, sensors, and the excitation to a recording.

use recording::excitation::signals::{Dither, Excitation};

use super::recorded::SyntheticRecording;
use crate::effect::PlantEffect;
use crate::excitation::input::{Command, PumpCommand};
use crate::plant::{InitialState, Plant, PlantError};
use crate::sensor::before_noise::Sight;
use crate::sensor::sensors::{Measuring, Sensors, Thermometer};

/// Where the command comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Drive {
    /// Open loop.
    Open(Excitation),
    /// Open loop, one command per tick, V.
    Commands(Vec<f64>),
    /// A proportional controller on the measured position: u = gain · (reference − position).
    Closed {
        /// Set position at every tick, m.
        reference_m: Vec<f64>,
        /// Gain, V/m.
        gain_v_per_m: f64,
    },
    /// Open loop on a pump drive, one command per tick.
    Pump(Vec<PumpCommand>),
}

/// Largest command of the output card, V.
const COMMAND_LIMIT_V: f64 = 10.0;

/// A test bed: a drive with sensors, a control tick and a seed for its noise.
#[derive(Clone, Debug)]
pub struct Bench {
    /// The drive.
    pub plant: Plant,
    /// Its sensors.
    pub sensors: Sensors,
    /// The sensor of the oil's temperature, where that is measured.
    pub thermometer: Option<Thermometer>,
    /// Control tick, s.
    pub tick_s: f64,
    /// Added to a valve's command, and recorded as part of it.
    pub dither: Option<Dither>,
    /// Seed of the sensors' noise.
    pub seed: u64,
}

impl Bench {
    /// A bench with a tick of 1 ms, no dither, and seed 0.
    #[must_use]
    pub const fn new(plant: Plant, sensors: Sensors) -> Self {
        Self { plant, sensors, thermometer: None, tick_s: 1e-3, dither: None, seed: 0 }
    }

    /// Runs the drive and records what the sensors show.
    ///
    /// The sensors read at the tick, before the command of that tick acts; the controller sees
    /// that reading.
    pub fn record(&self, drive: &Drive, initial: &InitialState) -> Result<SyntheticRecording, PlantError> {
        let commands_v = match drive {
            Drive::Open(excitation) => excitation.sample(self.tick_s),
            Drive::Commands(commands_v) => commands_v.clone(),
            Drive::Closed { .. } | Drive::Pump(_) => Vec::new(),
        };
        let ticks = match drive {
            Drive::Open(_) | Drive::Commands(_) => commands_v.len(),
            Drive::Closed { reference_m, .. } => reference_m.len(),
            Drive::Pump(commands) => commands.len(),
        };
        let mut recording = SyntheticRecording {
            time_s: (0..ticks).map(|tick| tick as f64 * self.tick_s).collect(),
            ..SyntheticRecording::default()
        };
        if let Drive::Closed { reference_m, .. } = drive {
            recording.reference_m.clone_from(reference_m);
        }

        if let Some(thermometer) = &self.thermometer {
            recording.oil_temperature_c = thermometer.read(self.seed, ticks);
        }

        let time_s = recording.time_s.clone();
        let other = self.plant.physics.effects().iter().find_map(PlantEffect::other_consumer);
        recording.other_flow_m3_per_s =
            other.map_or(Vec::new(), |other| time_s.iter().map(|&time_s| other.taken_m3_per_s(time_s)).collect());
        let mut measuring = Measuring::new(self.sensors, self.seed);
        let mut sight = Sight::new(self.plant.physics.effects());
        recording.truth = self.plant.run(initial, &time_s, |tick, state| {
            let seen = sight.see(time_s[tick], state);
            let reading = measuring.read(&seen);
            recording.seen.push(seen);
            recording.position_m.push(reading.position_m);
            recording.pressure_a_pa.push(reading.pressure_a_pa);
            recording.pressure_b_pa.push(reading.pressure_b_pa);
            if self.sensors.sees_supply {
                recording.supply_pressure_pa.push(reading.supply_pressure_pa);
            }
            let wanted_v = match drive {
                Drive::Pump(commands) => {
                    recording.pump.push(commands[tick]);
                    return Command::Pump(commands[tick]);
                }
                Drive::Open(_) | Drive::Commands(_) => commands_v[tick],
                Drive::Closed { reference_m, gain_v_per_m } => gain_v_per_m * (reference_m[tick] - reading.position_m),
            };
            let dither_v = self.dither.map_or(0.0, |dither| dither.at(time_s[tick]));
            // The valve's amplifier adds its dither after its input.
            let command_v = wanted_v.clamp(-COMMAND_LIMIT_V, COMMAND_LIMIT_V) + dither_v;
            recording.command_v.push(command_v);
            recording.spool.push(reading.spool);
            Command::Valve(command_v)
        })?;
        // The spool rests at the position of the first command, which was not yet chosen when the sensors were read.
        if let (Some(state), Some(seen)) = (recording.truth.first(), recording.seen.first_mut()) {
            *seen = Sight::new(self.plant.physics.effects()).see(0.0, state);
            if let Some(spool) = recording.spool.first_mut() {
                *spool = Measuring::new(self.sensors, self.seed).read(seen).spool;
            }
        }
        Ok(recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks::validation::{heavy, press, printed};
    use crate::excitation::input::LoadProfile;

    fn bench(effects: &[PlantEffect], dither: Option<Dither>) -> Bench {
        let machine = press();
        let plant = Plant::new(&machine, 1e-7).unwrap().with_effects(effects);
        Bench { dither, ..Bench::new(plant, Sensors::of(&machine).unwrap()) }
    }

    #[test]
    fn a_recording_repeats_bit_for_bit_and_its_seed_changes_the_noise_only() {
        let initial = InitialState::at_rest(&press(), 0.15);
        let drive = Drive::Open(Excitation::paper_steps(4.0));
        let mut bench = bench(&[], None);
        let one = bench.record(&drive, &initial).unwrap();
        assert_eq!(one, bench.record(&drive, &initial).unwrap());
        assert_eq!(one.len(), 1801);
        bench.seed = 1;
        let other = bench.record(&drive, &initial).unwrap();
        assert_eq!(one.truth, other.truth);
        assert_ne!(one.pressure_a_pa, other.pressure_a_pa);
    }

    #[test]
    fn the_first_row_shows_the_spool_resting_on_the_first_command() {
        let initial = InitialState::at_rest(&press(), 0.15);
        let recording = bench(&[], None).record(&Drive::Commands(vec![3.0; 5]), &initial).unwrap();
        assert!((recording.spool[0] - (0.0559 * 3.0 + 0.0345)).abs() < 1.0 / 32768.0);
    }

    #[test]
    fn a_closed_loop_reaches_its_reference_and_keeps_to_the_command_limit() {
        let initial = InitialState::at_rest(&press(), 0.10);
        let reference_m = vec![0.2; 3000];
        let drive = Drive::Closed { reference_m, gain_v_per_m: 200.0 };
        let recording = bench(&[], None).record(&drive, &initial).unwrap();
        assert!(recording.command_v.iter().all(|volts| volts.abs() <= 10.0));
        assert!((recording.command_v[0] - 10.0).abs() < 1e-12);
        // The dead zone leaves an error of (dead zone - offset) / (gain / V) / (V / m) = 6.3 mm.
        assert!((recording.position_m[2999] - 0.2).abs() < 8e-3, "{}", recording.position_m[2999]);
    }

    /// Prints run times; the limits are generous, for debug builds on busy machines.
    #[test]
    fn runs_take_milliseconds() {
        let friction = [PlantEffect::coulomb_friction(800.0)];
        let all = [friction[0], PlantEffect::hose_compliance(1e-13), PlantEffect::internal_leakage(2e-12)];
        let dither = Some(Dither { amplitude_v: 0.3, frequency_hz: 120.0 });
        let closed = Drive::Closed {
            reference_m: (0..4001).map(|k| 0.15 + 0.05 * (f64::from(k) * 2e-3).sin()).collect(),
            gain_v_per_m: 200.0,
        };
        let random = Drive::Open(Excitation::random_steps(5));
        let sweep = Drive::Open(Excitation::paper_sweep());
        let runs: [(&str, &Drive, &[PlantEffect], Option<Dither>); 6] = [
            ("random", &random, &[], None),
            ("random, friction", &random, &friction, None),
            ("sweep", &sweep, &[], None),
            ("sweep, three effects", &sweep, &all, None),
            ("sweep, dither", &sweep, &[], dither),
            ("closed loop, three effects, dither", &closed, &all, dither),
        ];
        for (name, drive, effects, dither) in runs {
            for machine in [printed(), heavy()] {
                for tolerance in [1e-7, 1e-10] {
                    let plant = Plant::new(&machine, tolerance).unwrap().with_effects(effects);
                    let mut bench = Bench::new(plant.with_load(LoadProfile::none()), Sensors::exact());
                    bench.dither = dither;
                    let clock = std::time::Instant::now();
                    bench.record(drive, &InitialState::at_rest(&machine, 0.15)).unwrap();
                    let took = clock.elapsed();
                    println!("{name} at {tolerance:.0e}: {took:?}");
                    assert!(took.as_secs_f64() < 10.0, "{name}: {took:?}");
                }
            }
        }
    }
}
