//! An effect at random: its form, and a strength distributed log-uniformly over its typical range.

use model_core::machine::{Machine, Parameter as P};
use recording::seeded_noise::Noise;

use super::Channels;
use crate::effect::flow::FlowEffect;
use crate::effect::friction::{DryFriction, FrictionLevel};
use crate::effect::load::LoadEffect;
use crate::effect::oil::{OilGrade, OilTemperature};
use crate::effect::sensing::{MeasuredSignal, SensingEffect};
use crate::effect::valve::ValveEffect;
use crate::effect::{Cavitation, LoadHolding, PlantEffect};
use crate::flow::edges::GainCurve;

/// What the size of an effect is scaled by.
pub(crate) struct About<'a> {
    pub(crate) machine: &'a Machine<f64>,
    pub(crate) channels: Channels,
    /// Lowest and highest position that the drive reaches without effects in most of its recordings, m.
    pub(crate) travel_m: (f64, f64),
    /// Whether the oil's temperature is measured.
    pub(crate) thermometer: bool,
}

impl About<'_> {
    fn get(&self, parameter: P) -> f64 {
        self.machine.get(parameter)
    }

    /// Supply pressure times the whole piston area, N.
    fn full_n(&self) -> f64 {
        self.get(P::SupplyPressure) * self.get(P::AreaA)
    }

    /// Flow at an opening of 0.4 and half the supply pressure, m³/s.
    fn full_flow(&self) -> f64 {
        0.4 * self.get(P::FlowCoefficient) * (0.5 * self.get(P::SupplyPressure)).sqrt()
    }

    fn place(&self, dice: &mut Noise, from: f64, to: f64) -> f64 {
        let (low, high) = self.travel_m;
        low + (high - low) * dice.uniform(from, to)
    }
}

/// The effect with this name; none where the name is not an effect of a valve-controlled drive.
pub(crate) fn draw(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<PlantEffect> {
    valve(name, about, dice)
        .map(PlantEffect::Valve)
        .or_else(|| flow(name, about, dice).map(PlantEffect::Flow))
        .or_else(|| chambers(name, about, dice))
        .or_else(|| friction(name, about, dice).map(PlantEffect::Friction))
        .or_else(|| load(name, about, dice).map(PlantEffect::Load))
        .or_else(|| sensing(name, about, dice).map(PlantEffect::Sensing))
}

fn valve(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<ValveEffect> {
    Some(match name {
        "valve-hysteresis" => {
            let width = dice.decades(0.004, 0.05);
            if dice.happens(0.5) {
                ValveEffect::WeightedPlays { width }
            } else {
                ValveEffect::BoucWen { width, turning: width * dice.uniform(0.5, 1.5) }
            }
        }
        "spool-stiction" => ValveEffect::Stiction {
            break_away: dice.decades(0.005, 0.03),
            kinetic_share: dice.uniform(0.05, 0.3),
            jump_s: if dice.happens(0.5) { 0.0 } else { dice.decades(8e-4, 3e-3) },
        },
        "null-drift" => {
            ValveEffect::NullDrift { travel: dice.sign() * dice.decades(0.006, 0.03), period_s: dice.uniform(4.0, 8.0) }
        }
        "solenoid-saturation" => {
            ValveEffect::Saturation { ceiling: 8.0 * about.get(P::ValveGain) * dice.decades(0.7, 1.6) }
        }
        "flow-force" => ValveEffect::FlowForce {
            closing_per_pa: dice.decades(0.03, 0.25) / about.get(P::SupplyPressure),
            braking_s_per_root_pa: dice.uniform(0.0, 1.0e-6),
        },
        _ => return None,
    })
}

fn flow(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<FlowEffect> {
    let full_flow = about.full_flow();
    Some(match name {
        "dead-zone-asymmetry" => {
            let more = dice.decades(0.01, 0.07);
            let more = if dice.happens(0.4) { -more.min(0.6 * about.get(P::DeadZone)) } else { more };
            let (extending, retracting) = if dice.happens(0.5) { (more, 0.0) } else { (0.0, more) };
            FlowEffect::DeadZone { extending, retracting }
        }
        "flow-gain-nonlinearity" => FlowEffect::Gain(if dice.happens(0.6) {
            GainCurve::Notch {
                knee: dice.uniform(0.08, 0.22),
                slope: 1.0 - dice.decades(0.15, 0.75),
                rounding: dice.uniform(0.01, 0.05),
            }
        } else {
            GainCurve::Power { exponent: 1.0 + dice.decades(0.08, 0.4), unchanged_at: dice.uniform(0.2, 0.4) }
        }),
        "metering-asymmetry" => {
            // The edges to tank differ in size from those of the supply, or B's edges from A's.
            let to_tank = dice.happens(0.7);
            let size = 1.0 + dice.sign() * dice.decades(0.1, if to_tank { 0.4 } else { 0.5 });
            let [supply_b, tank_a] = if to_tank { [1.0, size] } else { [size, 1.0] };
            let mut near = || dice.uniform(0.96, 1.04);
            FlowEffect::Metering { sizes: [near(), size * near(), supply_b * near(), tank_a * near()] }
        }
        "supply-droop" => {
            let fall_pa = dice.decades(5e5, 3e6).min(0.3 * about.get(P::SupplyPressure));
            let resistance = fall_pa / full_flow;
            let memory_s = dice.decades(0.02, 0.25);
            FlowEffect::SupplyDroop {
                resistance_pa_s_per_m3: resistance,
                gas_volume_m3: memory_s * 1.25 * about.get(P::SupplyPressure) / resistance,
                line_pa_s2_per_m6: dice.uniform(0.05, 0.3) * fall_pa / (full_flow * full_flow),
            }
        }
        "tank-back-pressure" => {
            let drop_pa = dice.decades(1e5, 2.5e6).min(0.25 * about.get(P::SupplyPressure));
            let laminar = dice.uniform(0.1, 0.35);
            FlowEffect::BackPressure {
                linear_pa_s_per_m3: laminar * drop_pa / full_flow,
                quadratic_pa_s2_per_m6: (1.0 - laminar) * drop_pa / (full_flow * full_flow),
            }
        }
        "valve-leakage" => FlowEffect::Leakage {
            opening: dice.decades(0.003, 0.04),
            reach: about.get(P::DeadZone) * dice.uniform(0.5, 1.3),
            laminar_pa: dice.decades(5e4, 1e6),
        },
        "counterbalance" => {
            let supply_pa = about.get(P::SupplyPressure);
            let setting_pa = supply_pa * dice.uniform(1.5, 2.5);
            let settings_pa = if dice.happens(0.5) { [setting_pa, f64::INFINITY] } else { [f64::INFINITY, setting_pa] };
            FlowEffect::Counterbalance(LoadHolding {
                settings_pa,
                pilot_ratio: dice.uniform(2.0, 4.0),
                span_pa: supply_pa * dice.decades(0.3, 1.5),
                time_constant_s: dice.decades(0.01, 0.03),
            })
        }
        "laminar-transition" => FlowEffect::LaminarTransition { pressure_pa: dice.decades(3e4, 5e5) },
        "~pump-ripple" => {
            FlowEffect::PumpRipple { share: dice.decades(0.01, 0.06), frequency_hz: dice.decades(12.0, 60.0) }
        }
        _ => return None,
    })
}

fn chambers(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<PlantEffect> {
    Some(match name {
        "internal-leakage" => PlantEffect::InternalLeakage {
            conductance_m3_per_s_pa: dice.decades(3e-13, 1e-11),
            turbulent_share: dice.uniform(0.0, 0.4),
            transition_pa: 3.0e6,
        },
        "external-leakage" => {
            let conductance = dice.decades(5e-13, 1e-11);
            let other = conductance * dice.uniform(0.0, 0.15);
            let both = if dice.happens(0.5) { [conductance, other] } else { [other, conductance] };
            PlantEffect::external_leakage(both)
        }
        "entrained-air" => {
            PlantEffect::EntrainedAir { share: dice.decades(0.003, 0.05), dissolving_pa: dice.decades(4.0e6, 1.5e7) }
        }
        // Half of them are vapour alone; the other half also contain air that the oil releases.
        "cavitation" => PlantEffect::Cavitation(Cavitation {
            floor_pa: -dice.uniform(3e4, 1e5),
            steepness_pa: dice.decades(5e2, 3e3),
            released: if dice.happens(0.5) { 0.0 } else { dice.decades(1e-3, 2e-2) },
        }),
        "position-dependent-volume" => PlantEffect::PositionDependentVolume,
        // 3 to 20 % of the pump's flow at 20 turns per second and 3·10⁶ Pa.
        "pump-slip" => PlantEffect::PumpSlip {
            conductance_m3_per_s_pa: dice.decades(0.03, 0.2) * 20.0 * about.get(P::PumpDisplacement) / 3.0e6,
            turbulent_share: dice.uniform(0.0, 0.3),
            reference_pressure_pa: 3.0e6,
        },
        // A share of the oil's own compressibility.
        "hose-compliance" => {
            PlantEffect::hose_compliance(dice.decades(0.3, 2.0) * about.get(P::VolumeA) / about.get(P::BulkModulus))
        }
        "oil-temperature" if about.thermometer => PlantEffect::OilGrade(oil_grade(dice)),
        "oil-temperature" => PlantEffect::OilTemperature(OilTemperature {
            rise_k_per_s: dice.decades(0.6, 4.0),
            share_of_power: dice.uniform(0.0, 0.9),
            reference_power_w: 0.5 * about.get(P::SupplyPressure) * about.full_flow(),
        }),
        _ => return None,
    })
}

/// ISO VG 22 to 68 with a usual viscosity index; the machine's values are for about 40 °C.
fn oil_grade(dice: &mut Noise) -> OilGrade {
    let at_40_mm2_per_s = dice.decades(22.0, 68.0);
    // At a viscosity index of 100, VG 22 has 4.3 mm²/s at 100 °C, and VG 68 has 8.7.
    let at_100_mm2_per_s = 4.3 * libm::pow(at_40_mm2_per_s / 22.0, 0.625) * dice.uniform(0.97, 1.15);
    let reference_c = dice.uniform(35.0, 45.0);
    OilGrade { at_40_mm2_per_s, at_100_mm2_per_s, reference_c, temperature_c: reference_c }
}

fn friction(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<DryFriction> {
    let full_n = about.full_n();
    let stiff = |level: FrictionLevel, dice: &mut Noise| DryFriction::stiff(level, dice.decades(1e-6, 4e-6));
    Some(match name {
        "coulomb-friction" => stiff(FrictionLevel::Constant(full_n * dice.decades(0.01, 0.05)), dice),
        "stribeck-friction" => {
            let sliding_n = full_n * dice.decades(0.008, 0.03);
            let break_away_n = sliding_n * dice.uniform(1.25, 2.5);
            let velocity_m_per_s = dice.decades(2e-3, 4e-2);
            stiff(FrictionLevel::Stribeck { sliding_n, break_away_n, velocity_m_per_s }, dice)
        }
        "friction-asymmetry" => {
            let (mean_n, off) = (full_n * dice.decades(0.012, 0.05), dice.sign() * dice.decades(0.15, 0.6));
            let level =
                FrictionLevel::Asymmetric { extending_n: mean_n * (1.0 + off), retracting_n: mean_n * (1.0 - off) };
            stiff(level, dice)
        }
        // Otherwise the viscous friction changes along the stroke.
        "position-dependent-friction" if dice.happens(0.5) => {
            let force_n = full_n * dice.decades(0.008, 0.03);
            if dice.happens(0.6) {
                let (low, high) = about.travel_m;
                let level = FrictionLevel::Bump {
                    force_n,
                    rise_n: force_n * dice.decades(0.5, 3.0),
                    at_m: about.place(dice, 0.25, 0.75),
                    width_m: (high - low) * dice.uniform(0.08, 0.25),
                };
                stiff(level, dice)
            } else {
                let (less, more) = (force_n * dice.uniform(0.1, 0.5), force_n * dice.uniform(1.5, 3.0));
                let (retracted_n, extended_n) = if dice.happens(0.5) { (less, more) } else { (more, less) };
                stiff(FrictionLevel::Slope { retracted_n, extended_n, stroke_m: about.get(P::Stroke) }, dice)
            }
        }
        "pressure-dependent-friction" => {
            let level = FrictionLevel::Pressure {
                area_m2: about.get(P::AreaA) * dice.decades(0.01, 0.06),
                share_of_higher: dice.uniform(0.6, 0.9),
                least_n: 0.001 * full_n,
            };
            stiff(level, dice)
        }
        "presliding" => {
            let sliding_n = full_n * dice.decades(0.015, 0.05);
            let break_away_n = sliding_n * dice.uniform(1.02, 1.2);
            DryFriction {
                level: FrictionLevel::Presliding { sliding_n, break_away_n },
                // From soft bristles to a third of the oil's stiffness; stiffer bristles occur in all dry friction.
                stiffness_n_per_m: about.machine.oil_spring_n_per_m() * dice.decades(3e-3, 1.0 / 3.0),
                damping_n_s_per_m: 4e3,
            }
        }
        _ => return None,
    })
}

fn load(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<LoadEffect> {
    let (low, high) = about.travel_m;
    let range = high - low;
    Some(match name {
        "position-dependent-load" => {
            let force_n = about.full_n() * dice.decades(0.03, 0.15);
            if dice.happens(0.5) {
                let from_m = about.place(dice, 0.2, 0.6);
                LoadEffect::ProgressiveSpring { from_m, stiffness: force_n / libm::pow(high - from_m, 1.5) }
            } else {
                let neutral_m = about.place(dice, 0.2, 0.8);
                LoadEffect::Linkage {
                    force_n: dice.sign() * force_n,
                    neutral_m,
                    reach_m: range * dice.uniform(0.4, 1.0),
                }
            }
        }
        "end-stop" => {
            let extending = dice.happens(0.5);
            let inside = range * dice.uniform(0.06, 0.2);
            LoadEffect::EndStop {
                at_m: if extending { high - inside } else { low + inside },
                extending,
                // 1e7 to 3e8 N/m at a tenth of a millimetre
                stiffness: dice.decades(1e7, 3e8) / (1.5 * 0.01),
                damping_s_per_m: dice.uniform(0.5, 4.0),
            }
        }
        "position-dependent-friction" => LoadEffect::NarrowBore {
            most_n_s_per_m: about.get(P::ViscousFriction) * dice.decades(0.3, 3.0),
            fits_at_m: about.place(dice, 0.1, 0.9),
            width_m: range * dice.uniform(0.3, 0.8),
        },
        _ => return None,
    })
}

fn sensing(name: &str, about: &About<'_>, dice: &mut Noise) -> Option<SensingEffect> {
    Some(match name {
        "linkage-backlash" => SensingEffect::Backlash { play_m: dice.decades(1e-4, 1.5e-3) },
        "position-sensor-lag" => {
            let lag_s = dice.decades(2e-3, 3e-2);
            if dice.happens(0.5) {
                SensingEffect::PositionDelay { delay_s: lag_s }
            } else {
                let damping = dice.uniform(0.6, 1.0);
                SensingEffect::PositionFilter { frequency_hz: damping / (std::f64::consts::PI * lag_s), damping }
            }
        }
        "sensor-offset" => {
            let channel = match about.channels {
                Channels::Position => MeasuredSignal::Position,
                Channels::Spool => [MeasuredSignal::Spool, MeasuredSignal::Position][dice.below(2)],
                _ => [MeasuredSignal::Spool, MeasuredSignal::PressureA, MeasuredSignal::PressureB][dice.below(3)],
            };
            let offset = match channel {
                MeasuredSignal::Spool => dice.decades(0.004, 0.03),
                MeasuredSignal::Position => 0.0,
                MeasuredSignal::PressureA | MeasuredSignal::PressureB => {
                    about.get(P::SupplyPressure) * dice.decades(0.006, 0.05)
                }
            };
            if channel == MeasuredSignal::Position || dice.happens(0.35) {
                SensingEffect::Factor { channel, excess: dice.sign() * dice.decades(0.015, 0.08) }
            } else {
                SensingEffect::Offset { channel, offset: dice.sign() * offset }
            }
        }
        "~structural-flexibility" => SensingEffect::Flexibility {
            frequency_hz: dice.decades(7.0, 30.0),
            damping: dice.decades(0.01, 0.06),
            share: dice.uniform(0.4, 1.5),
        },
        _ => return None,
    })
}
