// Constants of a drive, written by `host-sim export`: change the machine file and export again.

use model_core::machine::{Parameter, Source, Tick};

/// What the drive is called.
pub const NAME: &str = "press-63-40";
/// Where its oil comes from.
pub const SOURCE: Source = Source::Valve;
/// Control period that the values were checked for.
pub const TICK: Tick = Tick::OneMillisecond;
/// Ticks of the shortest delay line that holds its delays.
pub const DELAY_LINE: usize = 16;
/// Every value that is not the default, SI.
#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "every digit of an exported value counts")]
pub const VALUES: &[(Parameter, f64)] = &[
    (Parameter::FlowLimit, 0.0003), // supply.flow_limit_m3_per_s
    (Parameter::ValveGain, 0.0559), // valve.gain_per_v
    (Parameter::ValveOffset, 0.0345), // valve.offset
    (Parameter::DeadZone, 0.1049), // valve.dead_zone
    (Parameter::RateLimit, 12.0), // valve.rate_limit_per_s
    (Parameter::TimeConstant1, 0.018), // valve.time_constants_s[0]
    (Parameter::TimeConstant2, 0.0279), // valve.time_constants_s[1]
    (Parameter::TransportDelay, 0.007), // valve.transport_delay_s
    (Parameter::AreaA, 0.003117), // cylinder.area_a_m2
    (Parameter::AreaB, 0.001861), // cylinder.area_b_m2
    (Parameter::VolumeA, 0.00052), // cylinder.volume_a_m3
    (Parameter::VolumeB, 0.00033), // cylinder.volume_b_m3
    (Parameter::MovingMass, 18.3), // cylinder.moving_mass_kg
    (Parameter::ViscousFriction, 100000.0), // cylinder.viscous_friction_n_s_per_m
];

/// CRC-32 of the coefficients, which tells them from those of any other drive.
pub const FINGERPRINT: u32 = 0xd21f_b77c;
/// Bytes of a state with its delay lines.
pub const STATE_BYTES: usize = 272;

/// The drive with its coefficients as constants: see `model_core::drive::Baked`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exported;

#[rustfmt::skip]
#[allow(clippy::unreadable_literal, reason = "every digit of a coefficient counts")]
impl model_core::drive::Baked for Exported {
    type Number = model_core::number::PerUnit;
    const DRIVE: &'static model_core::drive::Drive<Self::Number> = {
        use model_core::literal::{Bases, ChamberEffects, Chambers, Drive, DryFriction, Edges, FixedI32, FixedU32, Flows, Lines, MechanicalEffects, Mechanics, OilSource, Overlap, PerUnit, Row, Sensors, StageWeights, Valve, ValveEffects};
        &Drive {
            source: OilSource::Valve(Valve {
                gain: FixedI32::from_bits(150055420),
                offset: PerUnit(FixedI32::from_bits(9261023)),
                step_limit: PerUnit(FixedI32::from_bits(3221225)),
                half_per_step: FixedU32::from_bits(2730667),
                delay_ticks: 7,
                delay_rest: PerUnit(FixedI32::from_bits(0)),
                decay_1: FixedI32::from_bits(253929061),
                decay_2: FixedI32::from_bits(258984497),
                cross: FixedI32::from_bits(9191702),
                effects: ValveEffects {
                    drift: None,
                    saturation: None,
                    hysteresis: None,
                    flow_force: None,
                    swing: None,
                    speed_limit: None,
                    stiction: None,
                },
            }, Edges {
                overlap: Overlap {
                    extending: PerUnit(FixedI32::from_bits(28158879)),
                    retracting: PerUnit(FixedI32::from_bits(28158879)),
                },
                gain: FixedI32::from_bits(238543731),
                limit: PerUnit(FixedI32::from_bits(112701320)),
                unity: FixedU32::from_bits(65536),
                transition: PerUnit(FixedI32::from_bits(76696)),
                turbulent: PerUnit(FixedI32::from_bits(19634136)),
                lines: Lines {
                    supply: PerUnit(FixedI32::from_bits(268435456)),
                    tank: PerUnit(FixedI32::from_bits(0)),
                },
                effects: None,
            }),
            chambers: Chambers {
                stiffness_a: FixedI32::from_bits(63234177),
                stiffness_b: FixedI32::from_bits(99641734),
                implicit: Flows {
                    a: PerUnit(FixedI32::from_bits(18520862)),
                    b: PerUnit(FixedI32::from_bits(29184388)),
                },
                ahead: [FixedI32::from_bits(18520862), FixedI32::from_bits(-17424494)],
                ratio: FixedI32::from_bits(160268971),
                unity: FixedU32::from_bits(65536),
                effects: ChamberEffects {
                    leakage: PerUnit(FixedI32::from_bits(0)),
                    leaks_fast: false,
                    external: None,
                    capacity: None,
                    cavitation: None,
                },
            },
            mechanics: Mechanics {
                row: Row {
                    mobility: FixedI32::from_bits(538439911),
                    pull: FixedI32::from_bits(157705399),
                    drag: FixedI32::from_bits(565715049),
                    back: FixedI32::from_bits(72649108),
                    share: None,
                },
                viscous: FixedI32::from_bits(282033285),
                hard: false,
                gamma: FixedI32::from_bits(78622925),
                travel: FixedI32::from_bits(205123),
                turn: PerUnit(FixedI32::from_bits(0)),
                load: PerUnit(FixedI32::from_bits(0)),
                effects: MechanicalEffects {
                    dry: DryFriction {
                        extending: PerUnit(FixedI32::from_bits(0)),
                        retracting: PerUnit(FixedI32::from_bits(0)),
                        stribeck: None,
                        placed: None,
                        seals: None,
                    },
                    resistance: None,
                    push: None,
                },
            },
            unsprung: Mechanics {
                row: Row {
                    mobility: FixedI32::from_bits(536870912),
                    pull: FixedI32::from_bits(157245850),
                    drag: FixedI32::from_bits(564066571),
                    back: FixedI32::from_bits(72990519),
                    share: None,
                },
                viscous: FixedI32::from_bits(282033285),
                hard: false,
                gamma: FixedI32::from_bits(78622925),
                travel: FixedI32::from_bits(205123),
                turn: PerUnit(FixedI32::from_bits(0)),
                load: PerUnit(FixedI32::from_bits(0)),
                effects: MechanicalEffects {
                    dry: DryFriction {
                        extending: PerUnit(FixedI32::from_bits(0)),
                        retracting: PerUnit(FixedI32::from_bits(0)),
                        stribeck: None,
                        placed: None,
                        seals: None,
                    },
                    resistance: None,
                    push: None,
                },
            },
            weights: StageWeights {
                rest: FixedI32::from_bits(189812531),
                half: FixedI32::from_bits(134217728),
            },
            sensors: Sensors {
                half_play: None,
                lag: None,
                delay: None,
                position: None,
                pressure_a: None,
                pressure_b: None,
                spool: None,
                unity: FixedI32::from_bits(268435456),
            },
            viscosity: None,
            unnamed: None,
            plain: true,
            bases: Bases {
                pressure_pa: 7000000.0,
                velocity_m_per_s: 0.22924260251492393,
                flow_m3_per_s: 0.0007145491920390179,
                force_n: 21819.0,
                stroke_m: 0.3,
                command_v: 10.0,
                pump_speed_rev_per_s: 50.0,
                temperature_c: 25.0,
                tick_s: 0.001,
            },
        }
    };
}
