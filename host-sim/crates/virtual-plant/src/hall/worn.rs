//! Drives of which one part is worn or set beyond what a drawing allows: an effect of the catalogue beside all that every installed drive has.

use crate::{
    DryFriction, FlowEffect, FrictionLevel, GainCurve, LoadEffect, MeasuredSignal, PlantEffect, SensingEffect,
    SyntheticRecording, ValveEffect,
};
use model_core::machine::Parameter as P;
use recording::Signal;
use recording::seeded_noise::Noise;

use super::drive::Hall;
use super::recordings::{Change, RECORDINGS, Run, recorded, stays_inside};
use super::visibility::shows;

/// What is worn, by the names that are right for it: the first is its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Worn(usize);

const NAMES: [&[&str]; 17] = [
    &["internal-leakage"],
    &["external-leakage"],
    &["coulomb-friction", "stribeck-friction"],
    &["stribeck-friction", "presliding"],
    &["valve-hysteresis"],
    &["spool-stiction"],
    // The same the other way round: whose overlaps differ has, by what is measured, a spool sensor that reads too much.
    &["dead-zone-asymmetry", "sensor-offset"],
    &["metering-asymmetry"],
    &["flow-gain-nonlinearity"],
    &["supply-droop"],
    &["tank-back-pressure"],
    &["valve-leakage"],
    &["entrained-air"],
    &["end-stop"],
    &["linkage-backlash"],
    &["sensor-offset"],
    // Whose spool reads too much has, by that sensor, more overlap to one side: nothing tells the two apart.
    &["spool-offset", "sensor-offset", "dead-zone-asymmetry"],
];

/// The least difference that a worn part makes to some signal, over its noise.
const VISIBLE_FROM: f64 = 6.0;

impl Worn {
    /// Every part that can be worn.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..NAMES.len()).map(Self)
    }

    /// Its name: that of the effect.
    #[must_use]
    pub const fn name(self) -> &'static str {
        NAMES[self.0][0]
    }

    /// Names that are right for it, its own first.
    #[must_use]
    pub const fn right(self) -> &'static [&'static str] {
        NAMES[self.0]
    }

    /// Those of which there can be more or less.
    pub fn that_grow() -> impl Iterator<Item = Self> {
        const WITHOUT: [&str; 5] =
            ["spool-stiction", "metering-asymmetry", "flow-gain-nonlinearity", "end-stop", "spool-offset"];
        Self::all().filter(|worn| !WITHOUT.contains(&worn.name()))
    }

    /// Its effect, in place of what the drive has within its drawing.
    fn draw(self, hall: &Hall, runs: &[Run], dice: &mut Noise) -> Option<PlantEffect> {
        let get = |parameter| hall.truth.get(parameter);
        let (supply_pa, full_n) = (get(P::SupplyPressure), hall.full_n());
        let open = get(P::FlowCoefficient) * (1.0 - get(P::DeadZone));
        let (area_a, area_b) = (get(P::AreaA), get(P::AreaB));
        let full_m3_per_s = open * area_a * (supply_pa * area_a / (area_a.powi(3) + area_b.powi(3))).sqrt();
        // Sliding as a share of full force, breaking away as a multiple of that, each between two values; slow up to a velocity.
        let rubs = |sliding: [f64; 2], breaking_away: [f64; 2], slow_m_per_s: f64, dice: &mut Noise| {
            let sliding_n = full_n * dice.uniform(sliding[0], sliding[1]);
            let level = FrictionLevel::Stribeck {
                sliding_n,
                break_away_n: sliding_n * dice.uniform(breaking_away[0], breaking_away[1]),
                velocity_m_per_s: dice.uniform(5e-3, slow_m_per_s),
            };
            let give_m = dice.decades(1e-5, 5e-5);
            let bristles_n_s_per_m = dice.decades(0.05, 0.3) * (sliding_n / give_m * get(P::MovingMass)).sqrt();
            PlantEffect::Friction(DryFriction::giving(level, give_m, bristles_n_s_per_m))
        };
        let leak = |share: f64| share * full_m3_per_s / supply_pa;
        // Of a sensor, as a share of what it reads at most.
        let off = |most: f64, dice: &mut Noise| most * dice.sign() * dice.decades(0.015, 0.05);
        Some(match self.name() {
            "internal-leakage" => PlantEffect::InternalLeakage {
                conductance_m3_per_s_pa: leak(dice.decades(0.01, 0.1)),
                turbulent_share: dice.uniform(0.0, 0.4),
                transition_pa: 3e6,
            },
            "external-leakage" => {
                let conductance = leak(dice.decades(0.01, 0.1));
                PlantEffect::external_leakage(if dice.happens(0.5) { [conductance, 0.0] } else { [0.0, conductance] })
            }
            "coulomb-friction" => rubs([0.05, 0.12], [1.0, 1.15], 0.015, dice),
            "stribeck-friction" => rubs([0.03, 0.06], [1.8, 3.0], 0.02, dice),
            "valve-hysteresis" => PlantEffect::Valve(ValveEffect::WeightedPlays { width: dice.decades(0.015, 0.05) }),
            "spool-stiction" => PlantEffect::Valve(ValveEffect::Stiction {
                break_away: dice.decades(0.01, 0.03),
                kinetic_share: dice.uniform(0.05, 0.3),
                jump_s: 0.0,
            }),
            "dead-zone-asymmetry" => {
                let more = dice.decades(0.045, 0.09);
                let [extending, retracting] = if dice.happens(0.5) { [more, 0.0] } else { [0.0, more] };
                PlantEffect::Flow(FlowEffect::DeadZone { extending, retracting })
            }
            "metering-asymmetry" => {
                let other = 1.0 + dice.sign() * dice.decades(0.18, 0.35);
                let mut near = || dice.uniform(0.98, 1.02);
                let sizes = [near(), other * near(), near(), other * near()];
                PlantEffect::Flow(FlowEffect::Metering { sizes })
            }
            "flow-gain-nonlinearity" => PlantEffect::Flow(FlowEffect::Gain(GainCurve::Power {
                exponent: 1.0 + dice.decades(0.12, 0.4),
                unchanged_at: dice.uniform(0.2, 0.4),
            })),
            "supply-droop" => {
                let droop = dice.decades(0.06, 0.2) * supply_pa / full_m3_per_s;
                PlantEffect::Flow(FlowEffect::SupplyDroop {
                    resistance_pa_s_per_m3: droop,
                    gas_volume_m3: dice.decades(5e-5, 3e-4),
                    line_pa_s2_per_m6: 0.1 * droop / full_m3_per_s,
                })
            }
            "tank-back-pressure" => PlantEffect::Flow(FlowEffect::BackPressure {
                linear_pa_s_per_m3: dice.uniform(0.0, 1e5) / full_m3_per_s,
                quadratic_pa_s2_per_m6: dice.decades(5e5, 2e6) / full_m3_per_s.powi(2),
            }),
            "valve-leakage" => PlantEffect::Flow(FlowEffect::Leakage {
                opening: dice.decades(0.015, 0.04),
                reach: get(P::DeadZone).max(0.01) * dice.uniform(0.6, 1.2),
                laminar_pa: dice.decades(1e5, 1e6),
            }),
            "entrained-air" => PlantEffect::entrained_air(dice.decades(0.015, 0.05)),
            "end-stop" => PlantEffect::Load(stop(hall, runs, dice)?),
            "linkage-backlash" => {
                PlantEffect::Sensing(SensingEffect::Backlash { play_m: get(P::Stroke) * dice.decades(7e-4, 3e-3) })
            }
            "spool-offset" => {
                let channel = hall.signals.contains(&Signal::Spool).then_some(MeasuredSignal::Spool)?;
                PlantEffect::Sensing(SensingEffect::Offset { channel, offset: off(1.0, dice) })
            }
            _ => {
                let side =
                    [(Signal::PressureA, MeasuredSignal::PressureA), (Signal::PressureB, MeasuredSignal::PressureB)];
                let measured: Vec<_> = side.into_iter().filter(|(signal, _)| hall.signals.contains(signal)).collect();
                let (_, channel) = *measured.get(dice.below(measured.len().max(1)))?;
                PlantEffect::Sensing(SensingEffect::Offset {
                    channel,
                    offset: off(hall.sensors.pressure.range_pa, dice),
                })
            }
        })
    }
}

/// So many times as much of an effect; `None` of one that has no amount here.
#[must_use]
pub fn times(effect: PlantEffect, by: f64) -> Option<PlantEffect> {
    use PlantEffect as E;
    Some(match effect {
        E::InternalLeakage { conductance_m3_per_s_pa, turbulent_share, transition_pa } => {
            E::InternalLeakage { conductance_m3_per_s_pa: by * conductance_m3_per_s_pa, turbulent_share, transition_pa }
        }
        E::ExternalLeakage { conductances_m3_per_s_pa, turbulent_share, transition_pa } => E::ExternalLeakage {
            conductances_m3_per_s_pa: conductances_m3_per_s_pa.map(|conductance| by * conductance),
            turbulent_share,
            transition_pa,
        },
        E::EntrainedAir { share, dissolving_pa } => E::EntrainedAir { share: by * share, dissolving_pa },
        // The seals yield by as much as before.
        E::Friction(DryFriction {
            level: FrictionLevel::Stribeck { sliding_n, break_away_n, velocity_m_per_s },
            stiffness_n_per_m,
            damping_n_s_per_m,
        }) => E::Friction(DryFriction {
            level: FrictionLevel::Stribeck {
                sliding_n: by * sliding_n,
                break_away_n: by * break_away_n,
                velocity_m_per_s,
            },
            stiffness_n_per_m: by * stiffness_n_per_m,
            damping_n_s_per_m,
        }),
        E::Valve(ValveEffect::WeightedPlays { width }) => E::Valve(ValveEffect::WeightedPlays { width: by * width }),
        E::Flow(FlowEffect::DeadZone { extending, retracting }) => {
            E::Flow(FlowEffect::DeadZone { extending: by * extending, retracting: by * retracting })
        }
        E::Flow(FlowEffect::SupplyDroop { resistance_pa_s_per_m3, gas_volume_m3, line_pa_s2_per_m6 }) => {
            E::Flow(FlowEffect::SupplyDroop {
                resistance_pa_s_per_m3: by * resistance_pa_s_per_m3,
                gas_volume_m3,
                line_pa_s2_per_m6: by * line_pa_s2_per_m6,
            })
        }
        E::Flow(FlowEffect::BackPressure { linear_pa_s_per_m3, quadratic_pa_s2_per_m6 }) => {
            E::Flow(FlowEffect::BackPressure {
                linear_pa_s_per_m3: by * linear_pa_s_per_m3,
                quadratic_pa_s2_per_m6: by * quadratic_pa_s2_per_m6,
            })
        }
        E::Flow(FlowEffect::Leakage { opening, reach, laminar_pa }) => {
            E::Flow(FlowEffect::Leakage { opening: by * opening, reach, laminar_pa })
        }
        E::Sensing(SensingEffect::Backlash { play_m }) => E::Sensing(SensingEffect::Backlash { play_m: by * play_m }),
        E::Sensing(SensingEffect::Offset { channel, offset }) => {
            E::Sensing(SensingEffect::Offset { channel, offset: by * offset })
        }
        _ => return None,
    })
}

/// How much there is of a worn part, SI, and which amounts of a machine file say so: several, where each of the names that are right for it has its own. `None`
/// where the file's form shares no number with it. Losses of pressure are those at a usual flow, m³/s.
pub(super) fn amount(effect: &PlantEffect, usual_m3_per_s: f64) -> Option<(&'static [P], f64)> {
    use PlantEffect as E;
    Some(match *effect {
        E::InternalLeakage { conductance_m3_per_s_pa, .. } => (&[P::InternalLeakage], conductance_m3_per_s_pa),
        E::ExternalLeakage { conductances_m3_per_s_pa: [a, b], .. } => {
            (if a > b { &[P::ExternalLeakageA] } else { &[P::ExternalLeakageB] }, a.max(b))
        }
        E::EntrainedAir { share, .. } => (&[P::AirShare], share),
        E::Friction(DryFriction { level: FrictionLevel::Stribeck { sliding_n, .. }, .. }) => {
            (&[P::CoulombFriction, P::StribeckForce], sliding_n)
        }
        E::Valve(ValveEffect::WeightedPlays { width }) => (&[P::HysteresisWidth], width),
        E::Flow(FlowEffect::DeadZone { extending, retracting }) => (&[P::DeadZoneDifference], extending - retracting),
        E::Flow(FlowEffect::SupplyDroop { resistance_pa_s_per_m3, line_pa_s2_per_m6, .. }) => {
            (&[P::DroopResistance], resistance_pa_s_per_m3 + line_pa_s2_per_m6 * usual_m3_per_s)
        }
        E::Flow(FlowEffect::Leakage { opening, .. }) => (&[P::ValveLeakageOpening], opening),
        E::Sensing(SensingEffect::Backlash { play_m }) => (&[P::BacklashPlay], play_m),
        E::Sensing(SensingEffect::Offset { channel, offset }) => match channel {
            MeasuredSignal::Spool => (&[P::SpoolOffset], offset),
            MeasuredSignal::PressureA => (&[P::PressureAOffset], offset),
            MeasuredSignal::PressureB => (&[P::PressureBOffset], offset),
            MeasuredSignal::Position => return None,
        },
        _ => return None,
    })
}

/// A stop within reach of the rod.
fn stop(hall: &Hall, runs: &[Run], dice: &mut Noise) -> Option<LoadEffect> {
    let (mut low, mut high) = (f64::MAX, f64::MIN);
    for run in runs {
        for state in &run.whole(hall, &Change::default())?.truth {
            (low, high) = (low.min(state.position_m), high.max(state.position_m));
        }
    }
    let (extending, inside) = (dice.happens(0.5), (high - low) * dice.uniform(0.08, 0.2));
    Some(LoadEffect::EndStop {
        at_m: if extending { high - inside } else { low + inside },
        extending,
        stiffness: dice.decades(1e7, 3e8) / (1.5 * 0.01),
        damping_s_per_m: dice.uniform(0.5, 4.0),
    })
}

/// What one drawn effect takes the place of; a sensor's fault comes on top.
fn replaces(worn: PlantEffect, usual: &PlantEffect) -> bool {
    let friction = |effect: &PlantEffect| matches!(effect, PlantEffect::Friction(_));
    !matches!(worn, PlantEffect::Sensing(_)) && (worn.name() == usual.name() || friction(&worn) && friction(usual))
}

/// The recordings of a drive of which this is worn, and what it has then; none where it does not show in the
/// training recordings, or the rod leaves its stroke.
pub fn made(hall: &mut Hall, worn: Worn, runs: &[Run], dice: &mut Noise) -> Option<Vec<SyntheticRecording>> {
    let effect = worn.draw(hall, runs, dice)?;
    let usual = hall.clone();
    hall.effects.retain(|kept| !replaces(effect, kept));
    hall.effects.push(effect);
    // An offset is in every row, many times its noise.
    let is_offset = matches!(effect, PlantEffect::Sensing(SensingEffect::Offset { .. }));
    let mut most = if is_offset { f64::INFINITY } else { 0.0 };
    let mut kept = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let with = run.whole(hall, &Change::default())?;
        if !stays_inside(hall, &with) {
            return None;
        }
        let without = run.commanded(with.command_v.clone()).whole(&usual, &Change::default())?;
        let with = recorded(hall, run, &with);
        if index < RECORDINGS - 1 {
            most = most.max(shows(hall, &with, &recorded(hall, run, &without)));
        }
        kept.push(with);
    }
    (most > VISIBLE_FROM).then_some(kept)
}
