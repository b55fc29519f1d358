//! The vocabulary of the machine file: every SI parameter of a drive.
//!
//! Reader, coefficient builder, fit and report all speak of parameters by [`Parameter`]; key, unit,
//! admissible range and default stand here and, of the effects, in [their table](crate::effects), and nowhere else.

use super::Source;
use crate::effects::{Effect, effects};

/// Value of a parameter that the machine file does not give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fallback {
    /// The machine file must give it.
    Required,
    /// This value, in the parameter's unit.
    Value(f64),
    /// Half the stroke times the area of the chamber: the dead volume of hoses is then left out.
    HalfStrokeVolume,
}

/// Key, unit, range and default of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// The key as in the machine file, with its table: `valve.gain_per_v`.
    pub key: &'static str,
    /// SI unit, as a recording's header would write it.
    pub unit: &'static str,
    /// Smallest admissible value, included.
    pub min: f64,
    /// Largest admissible value, included.
    pub max: f64,
    /// Value where the file does not give one.
    pub default: Fallback,
    /// One line for people, with sign convention and the paper's equation where it has one.
    pub meaning: &'static str,
}

macro_rules! parameters {
    ([
        { $($first:ident: $first_key:literal, $first_unit:literal, $first_min:expr, $first_max:expr, $first_default:expr, $first_meaning:literal;)* }
        { $($last:ident: $last_key:literal, $last_unit:literal, $last_min:expr, $last_max:expr, $last_default:expr, $last_meaning:literal;)* }
    ]
    $($effect:ident $effect_name:literal in $link:ident {
        $($name:ident: $key:literal, $unit:literal, $min:expr, $max:expr, $default:expr, $meaning:literal;)*
    } trial { $($trial:tt)* } strong { $($strong:tt)* })*) => {
        rows! {
            $($first: $first_key, $first_unit, $first_min, $first_max, $first_default, None, $first_meaning;)*
            $($($name: concat!("effects.", $effect_name, ".", $key), $unit, $min, $max, Value($default), Some(Effect::$effect), $meaning;)*)*
            $($last: $last_key, $last_unit, $last_min, $last_max, $last_default, None, $last_meaning;)*
        }
    };
}

macro_rules! rows {
    ($($name:ident: $key:expr, $unit:literal, $min:expr, $max:expr, $default:expr, $effect:expr, $meaning:literal;)*) => {
        /// A parameter of the drive, in SI units.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum Parameter { $(#[doc = $meaning] $name,)* }

        impl Parameter {
            /// Every parameter, in the order of the machine file.
            pub const ALL: &'static [Parameter] = &[$(Parameter::$name,)*];

            /// How many there are.
            pub const COUNT: usize = Self::ALL.len();

            /// Key, unit, range and default.
            #[must_use]
            pub const fn description(self) -> Description {
                match self {
                    $(Parameter::$name => Description {
                        key: $key, unit: $unit, min: $min, max: $max, default: $default, meaning: $meaning,
                    },)*
                }
            }

            /// The effect that it belongs to; none for a base parameter and for the correction table.
            #[must_use]
            pub const fn effect(self) -> Option<Effect> {
                match self { $(Parameter::$name => $effect,)* }
            }
        }
    };
}

use Fallback::{HalfStrokeVolume, Required, Value};
const NONE: f64 = f64::INFINITY;

effects! { parameters =>
    {
        SupplyPressure: "supply.pressure_pa", "Pa", 1e5, 1e8, Value(7.0e6), "Supply pressure p0, constant; with a pump drive the pressure all others are scaled by. (3), (4)";
        TankPressure: "supply.tank_pressure_pa", "Pa", 0.0, 1e7, Value(0.0), "Pressure of the return line, gauge: above that of the atmosphere.";
        FlowLimit: "supply.flow_limit_m3_per_s", "m3/s", 1e-7, NONE, Value(NONE), "Largest flow through either valve edge, both signs.";
        LevelAtRest: "supply.level_at_rest", "1", 0.02, 0.98, Value(0.5), "Share of supply pressure in chamber B at rest, where a simulation of a recording without pressures starts; no step uses it.";
        ValveGain: "valve.gain_per_v", "1/V", -10.0, 10.0, Value(0.1), "Slope of the static characteristic: spool travel per volt. (15)";
        ValveOffset: "valve.offset", "1", -1.0, 1.0, Value(0.0), "Spool position at zero volts; positive extends. (15)";
        DeadZone: "valve.dead_zone", "1", 0.0, 0.999, Value(0.0), "Overlap: spool travel from centre, to both sides, that passes no oil.";
        RateLimit: "valve.rate_limit_per_s", "1/s", 1e-3, NONE, Value(NONE), "Largest speed of the spool's set value, both signs. Fig. 5";
        TimeConstant1: "valve.time_constants_s[0]", "s", 0.0, 10.0, Value(0.0), "First lag of the spool. (16)";
        TimeConstant2: "valve.time_constants_s[1]", "s", 0.0, 10.0, Value(0.0), "Second lag of the spool. (16)";
        NaturalFrequency: "valve.natural_frequency_hz", "Hz", 0.0, 1e4, Value(0.0), "Natural frequency of the spool as a second-order system, in place of both lags; 0: the lags of (16).";
        SpoolDamping: "valve.damping", "1", 0.05, 20.0, Value(1.0), "Damping ratio of that system: below 1 the spool overshoots, at 1 it is two equal lags.";
        SpoolSpeedLimit: "valve.speed_limit_per_s", "1/s", 1e-3, NONE, Value(NONE), "Largest speed of the spool itself, both signs, behind its lags.";
        SpeedOverdrive: "valve.speed_overdrive", "1", 0.0, 1e3, Value(0.0), "How much more a second-order spool can be pulled than its largest speed takes: 0 where a pilot stage opens no further, many where its speed itself is limited.";
        TransportDelay: "valve.transport_delay_s", "s", 0.0, 1.0, Value(0.0), "Dead time between command and spool. (16)";
        FlowCoefficient: "valve.flow_coefficient", "m3/s/sqrt(Pa)", 1e-12, 1.0, Value(2.4e-7), "K_Q: flow per spool travel beyond the dead zone and root of pressure. (3), (4)";
        LaminarTransition: "valve.laminar_transition_pa", "Pa", 1.0, 1e6, Value(2e3), "Pressure difference p_t below which the root becomes linear.";
        AreaA: "cylinder.area_a_m2", "m2", 1e-6, 10.0, Required, "Piston area on side A; its pressure extends. (5)";
        AreaB: "cylinder.area_b_m2", "m2", 1e-6, 10.0, Required, "Piston area on side B, the rod side; its pressure retracts. (5)";
        Stroke: "cylinder.stroke_m", "m", 1e-3, 100.0, Value(0.3), "Length of travel.";
        VolumeA: "cylinder.volume_a_m3", "m3", 1e-9, 10.0, HalfStrokeVolume, "Oil in chamber A and its hose at mid-stroke. (7)";
        VolumeB: "cylinder.volume_b_m3", "m3", 1e-9, 10.0, HalfStrokeVolume, "Oil in chamber B and its hose at mid-stroke. (7)";
        VolumeFollows: "cylinder.volume_follows_piston", "1", 0.0, 1.0, Value(0.0), "1: the chamber volumes change with the piston, by area times its way from mid-stroke, as in every cylinder; 0: they are constant, as in the paper. (7)";
        BulkModulus: "cylinder.bulk_modulus_pa", "Pa", 1e6, 1e11, Value(1.2e9), "Bulk modulus E0 of the oil. (7)";
        MovingMass: "cylinder.moving_mass_kg", "kg", 1e-2, 1e7, Value(20.0), "Moving mass m, load reduced to the rod included. (8)";
        ViscousFriction: "cylinder.viscous_friction_n_s_per_m", "N s/m", 0.0, 1e9, Value(1.0e4), "Viscous friction D. (8)";
        LoadForce: "load.force_n", "N", -1e8, 1e8, Value(0.0), "External force F on the rod; positive extends. (8)";
        PumpDisplacement: "pump.displacement_m3_per_rev", "m3/rev", 1e-9, 1.0, Value(1.6e-6), "Oil delivered per turn by the pump of a pump-controlled drive.";
        PumpReverseRatio: "pump.reverse_ratio", "1", 0.2, 5.0, Value(1.0), "Oil delivered per turn into B over that into A: pumps built for one sense deliver differently in the other.";
        ReturnCoefficient: "directional_valve.flow_coefficient", "m3/s/sqrt(Pa)", 1e-12, 1.0, Value(1.0e-6), "Flow per root of pressure from the returning chamber to tank, with the directional valve open.";
        LvdtCounts: "sensing.lvdt_counts_per_unit", "1", 1.0, 1e9, Value(32768.0), "Counts of the spool's LVDT per full spool travel (16 bit, both signs).";
        EncoderCounts: "sensing.encoder_counts_per_rev", "1", 1.0, 1e9, Value(3600.0), "Counts of the joint's encoder per turn.";
        LinkageBase: "linkage.base_m", "m", 1e-3, 100.0, Value(0.6), "Side of the linkage triangle from joint to the cylinder's foot.";
        LinkageArm: "linkage.arm_m", "m", 1e-3, 100.0, Value(0.5), "Side of the linkage triangle from joint to the rod's eye.";
        LinkageLengthRetracted: "linkage.length_retracted_m", "m", 1e-3, 100.0, Value(0.45), "Third side, foot to rod eye, with the rod fully in (position 0).";
        LinkageAngleAtZero: "linkage.angle_at_zero_rad", "rad", -7.0, 7.0, Value(0.0), "Angle of the triangle at the joint where the encoder counts 0.";
    }
    // The effects stand between these two. The last ones are the correction table's.
    {
        TableQuantity: "effects.unnamed.quantity", "1", 0.0, 4.0, Value(0.0), "What the table adds to: 0 nothing, 1 force on the rod in N (positive extends), 2 flow into A and 3 flow out of B in m3/s, 4 spool travel after the lags.";
        TableOver: "effects.unnamed.over", "1", 0.0, 5.0, Value(0.0), "State that its seven nodes are over: 0 none, 1 velocity in m/s, 2 position in m, 3 spool, 4 pressure A and 5 pressure B in Pa.";
        TableOver2: "effects.unnamed.over_2", "1", 0.0, 5.0, Value(0.0), "State that each node's three values are over, by the same numbers; 0: one value a node.";
        TableFrom: "effects.unnamed.from", "1", -1e9, 1e9, Value(0.0), "State at the first node, SI; below it the table holds its first value.";
        TableTo: "effects.unnamed.to", "1", -1e9, 1e9, Value(1.0), "State at the seventh node, SI; above it the table holds its last value.";
        TableFrom2: "effects.unnamed.from_2", "1", -1e9, 1e9, Value(0.0), "Second state at the first of three values.";
        TableTo2: "effects.unnamed.to_2", "1", -1e9, 1e9, Value(1.0), "Second state at the third of three values.";
        TableValue0: "effects.unnamed.values[0]", "1", -1e9, 1e9, Value(0.0), "Value 0 of the table, in the unit of its quantity.";
        TableValue1: "effects.unnamed.values[1]", "1", -1e9, 1e9, Value(0.0), "Value 1 of the table, in the unit of its quantity.";
        TableValue2: "effects.unnamed.values[2]", "1", -1e9, 1e9, Value(0.0), "Value 2 of the table, in the unit of its quantity.";
        TableValue3: "effects.unnamed.values[3]", "1", -1e9, 1e9, Value(0.0), "Value 3 of the table, in the unit of its quantity.";
        TableValue4: "effects.unnamed.values[4]", "1", -1e9, 1e9, Value(0.0), "Value 4 of the table, in the unit of its quantity.";
        TableValue5: "effects.unnamed.values[5]", "1", -1e9, 1e9, Value(0.0), "Value 5 of the table, in the unit of its quantity.";
        TableValue6: "effects.unnamed.values[6]", "1", -1e9, 1e9, Value(0.0), "Value 6 of the table, in the unit of its quantity.";
        TableValue7: "effects.unnamed.values[7]", "1", -1e9, 1e9, Value(0.0), "Value 7 of the table, in the unit of its quantity.";
        TableValue8: "effects.unnamed.values[8]", "1", -1e9, 1e9, Value(0.0), "Value 8 of the table, in the unit of its quantity.";
        TableValue9: "effects.unnamed.values[9]", "1", -1e9, 1e9, Value(0.0), "Value 9 of the table, in the unit of its quantity.";
        TableValue10: "effects.unnamed.values[10]", "1", -1e9, 1e9, Value(0.0), "Value 10 of the table, in the unit of its quantity.";
        TableValue11: "effects.unnamed.values[11]", "1", -1e9, 1e9, Value(0.0), "Value 11 of the table, in the unit of its quantity.";
        TableValue12: "effects.unnamed.values[12]", "1", -1e9, 1e9, Value(0.0), "Value 12 of the table, in the unit of its quantity.";
        TableValue13: "effects.unnamed.values[13]", "1", -1e9, 1e9, Value(0.0), "Value 13 of the table, in the unit of its quantity.";
        TableValue14: "effects.unnamed.values[14]", "1", -1e9, 1e9, Value(0.0), "Value 14 of the table, in the unit of its quantity.";
        TableValue15: "effects.unnamed.values[15]", "1", -1e9, 1e9, Value(0.0), "Value 15 of the table, in the unit of its quantity.";
        TableValue16: "effects.unnamed.values[16]", "1", -1e9, 1e9, Value(0.0), "Value 16 of the table, in the unit of its quantity.";
        TableValue17: "effects.unnamed.values[17]", "1", -1e9, 1e9, Value(0.0), "Value 17 of the table, in the unit of its quantity.";
        TableValue18: "effects.unnamed.values[18]", "1", -1e9, 1e9, Value(0.0), "Value 18 of the table, in the unit of its quantity.";
        TableValue19: "effects.unnamed.values[19]", "1", -1e9, 1e9, Value(0.0), "Value 19 of the table, in the unit of its quantity.";
        TableValue20: "effects.unnamed.values[20]", "1", -1e9, 1e9, Value(0.0), "Value 20 of the table, in the unit of its quantity.";
    }
}

impl Parameter {
    /// Values of the correction table: one per node, or, with a second state, three per node, row by row.
    pub const TABLE_VALUES: [Parameter; 21] = [
        Parameter::TableValue0,
        Parameter::TableValue1,
        Parameter::TableValue2,
        Parameter::TableValue3,
        Parameter::TableValue4,
        Parameter::TableValue5,
        Parameter::TableValue6,
        Parameter::TableValue7,
        Parameter::TableValue8,
        Parameter::TableValue9,
        Parameter::TableValue10,
        Parameter::TableValue11,
        Parameter::TableValue12,
        Parameter::TableValue13,
        Parameter::TableValue14,
        Parameter::TableValue15,
        Parameter::TableValue16,
        Parameter::TableValue17,
        Parameter::TableValue18,
        Parameter::TableValue19,
        Parameter::TableValue20,
    ];

    /// Whether a drive with this source has a use for it. A cylinder's areas are optional where a force moves the mass: they turn recorded pressures
    /// into that force.
    #[must_use]
    pub fn is_of(self, source: Source) -> bool {
        let is_between = |first: Parameter, last: Parameter| (first..=last).contains(&self);
        let is_of_pump = is_between(Parameter::PumpDisplacement, Parameter::ReturnCoefficient);
        match source {
            Source::Valve => !is_of_pump,
            Source::Pump => !is_between(Parameter::ValveGain, Parameter::LaminarTransition),
            Source::Force => self.effect().map_or_else(
                || {
                    self.is_of_mass()
                        || is_between(Parameter::EncoderCounts, Parameter::LinkageAngleAtZero)
                        || self >= Parameter::TableQuantity
                },
                |effect| source.has_effect(effect),
            ),
        }
    }

    /// Whether it is a base parameter of the mass, or an area.
    const fn is_of_mass(self) -> bool {
        use Parameter::{AreaA, AreaB, LoadForce, MovingMass, Stroke, ViscousFriction};
        matches!(self, AreaA | AreaB | Stroke | MovingMass | ViscousFriction | LoadForce)
    }

    /// Whether it selects one of several cases, so that only whole numbers are valid.
    #[must_use]
    pub const fn is_whole(self) -> bool {
        matches!(
            self,
            Parameter::VolumeFollows | Parameter::TableQuantity | Parameter::TableOver | Parameter::TableOver2
        )
    }
}
