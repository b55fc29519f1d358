//! Each effect as the people at the machine know it: what happens there, what they see of it, what to check.
//!
//! For a drive as it stands in a hall, not for the model: equations, and tests that tell an effect from others, are in the catalogue.

use model_core::effects::Effect;

/// An effect in the words of the hall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cause {
    /// Which.
    pub effect: Effect,
    /// What happens in the machine: a clause in small letters without full stop, as the other two are.
    pub happens: &'static str,
    /// What somebody beside the machine notices.
    pub seen: &'static str,
    /// What to check there.
    pub check: &'static str,
}

/// What an effect is at the machine.
#[must_use]
pub fn cause(effect: Effect) -> &'static Cause {
    // `every_effect_has_its_cause` holds that each is found.
    CAUSES.iter().find(|cause| cause.effect == effect).unwrap_or(&CAUSES[0])
}

/// Every effect's, in the order of the chain.
pub const CAUSES: [Cause; Effect::ALL.len()] = [
    Cause {
        effect: Effect::ValveHysteresis,
        happens: "the spool settles at different places when the command comes from above and from below",
        seen: "the drive needs more command after each change of direction, at every opening and however slow",
        check: "the valve's dither and amplifier, its pilot filter, and dirt or wear in the pilot stage",
    },
    Cause {
        effect: Effect::SpoolStiction,
        happens: "the spool sticks and then jumps",
        seen: "at a slow command the rod stands, then moves in jerks; the position loop oscillates a little at rest",
        check: "the oil's cleanliness and the valve's filter, varnish in the bore, dither, side forces from mounting bolts",
    },
    Cause {
        effect: Effect::NullDrift,
        happens: "the valve's neutral moves with time",
        seen: "the rod creeps at neutral, and differently after an hour than in the morning",
        check: "the valve's zero after warming up, the amplifier's supply, the temperature of pilot and electronics",
    },
    Cause {
        effect: Effect::SolenoidSaturation,
        happens: "the spool falls short at large commands",
        seen: "full speed is not reached, small moves are as they should be",
        check: "the supply voltage and current limit of the amplifier, the resistance of the coil, cable and plugs",
    },
    Cause {
        effect: Effect::FlowForce,
        happens: "the flow pushes the spool closed",
        seen: "the spool falls short where much oil flows at a high pressure drop",
        check: "the valve's power limit in its data sheet, pilot pressure, centring springs",
    },
    Cause {
        effect: Effect::DeadZoneAsymmetry,
        happens: "one side opens later than the other",
        seen: "the dead band is not centred: the rod starts sooner in one direction",
        check: "the valve's zero and its compensation of overlap in amplifier or controller; overlaps in the data sheet",
    },
    Cause {
        effect: Effect::FlowGainNonlinearity,
        happens: "the flow does not grow in proportion to the opening",
        seen: "the speed over the command is a curve or has a knee",
        check: "the spool's form in the data sheet (notches, progressive edges), and the characteristic set in the controller",
    },
    Cause {
        effect: Effect::MeteringAsymmetry,
        happens: "the four edges of the valve are not of one size",
        seen: "one direction is faster than the piston areas explain, or both pressures lie too high or too low while the rod moves",
        check: "the valve's type (a spool for differential cylinders?), its order code, and wear of the edges",
    },
    Cause {
        effect: Effect::SupplyDroop,
        happens: "the supply pressure falls when oil is taken",
        seen: "fast moves slow down towards their end, more when other drives move",
        check: "pump controller, accumulator's gas charge, suction and pressure filters, other consumers, the length of the line",
    },
    Cause {
        effect: Effect::TankBackPressure,
        happens: "the return line holds the oil back",
        seen: "fast moves are slower than slow ones promise; the pressure at the valve's tank port rises with the speed",
        check: "the return filter's indicator, cooler, hoses and couplings of the return line",
    },
    Cause {
        effect: Effect::ValveLeakage,
        happens: "the closed valve lets oil pass",
        seen: "the rod creeps at neutral; the tank line of the valve is warm or noisy at rest",
        check: "the valve's leakage at its centre by its data sheet, worn metering edges, dirt",
    },
    Cause {
        effect: Effect::Counterbalance,
        happens: "a load-holding valve opens only above a pressure",
        seen: "both pressures are high while the load goes down; it may judder",
        check: "the setting and the pilot ratio of the counterbalance or load-holding valve, and its pilot line",
    },
    Cause {
        effect: Effect::LaminarTransition,
        happens: "at a small pressure drop less oil flows than the valve's law says",
        seen: "the last part of a move under nearly full load is slow, more so with cold oil",
        check: "the oil's viscosity and temperature, throttles and strainers in the lines",
    },
    Cause {
        effect: Effect::PumpSlip,
        happens: "the pump loses oil inside",
        seen: "it moves more slowly under load than without; the pump's case drain gives much oil and is hot",
        check: "the flow and temperature of the pump's case drain; the pump's wear",
    },
    Cause {
        effect: Effect::InternalLeakage,
        happens: "oil passes the piston seal",
        seen: "with the valve closed the two pressures run together; the rod is slower under load",
        check: "the piston seal: rod at its end stop, pressure on that side, the other port open: measure what comes out; scores in the tube",
    },
    Cause {
        effect: Effect::ExternalLeakage,
        happens: "oil is lost from a chamber to the outside or to the tank",
        seen: "it is wet somewhere, or the rod drifts although the piston seal is good",
        check: "the rod seal, fittings and hoses, and valves between chamber and tank (relief, check, shut-off)",
    },
    Cause {
        effect: Effect::EntrainedAir,
        happens: "there is air in the oil",
        seen: "the drive is soft at low pressure and hard at high; it oscillates, foams or is loud",
        check: "oil level and suction line, bleeding of the cylinder, foam in the tank",
    },
    Cause {
        effect: Effect::HoseCompliance,
        happens: "hoses or lines yield with the pressure",
        seen: "the drive is softer than its oil and oscillates at a low frequency",
        check: "length and kind of the hoses, accumulators on the cylinder's side, clamps of the pipes",
    },
    Cause {
        effect: Effect::PositionDependentVolume,
        happens: "the volume of a chamber changes more or less with the stroke than the file says",
        seen: "the drive is stiffer near the ends of the stroke than in its middle, more or less than expected",
        check: "the volumes in the machine file: dead volume and lines of each side, and areas",
    },
    Cause {
        effect: Effect::Cavitation,
        happens: "a chamber's pressure falls to the vapour pressure and a cavity forms",
        seen: "bangs or a stop after fast braking or with a pulling load; the pressure stands near zero",
        check: "anti-cavitation valves, pre-charge of the return line, the speed of braking under a pulling load",
    },
    Cause {
        effect: Effect::CoulombFriction,
        happens: "something rubs, at every speed alike",
        seen: "a step in pressure or force at each change of direction",
        check: "guides, alignment, seals of rod and piston, lubrication, side load",
    },
    Cause {
        effect: Effect::StribeckFriction,
        happens: "it takes more force to break away than to slide on",
        seen: "stick-slip at low speed, a jump at the start",
        check: "seals and guides, lubrication, the pause before the move; a seal of low friction",
    },
    Cause {
        effect: Effect::FrictionAsymmetry,
        happens: "it rubs more in one direction than in the other",
        seen: "one direction needs more force (pressures times areas) at the same speed and load",
        check: "rod seal and wiper, alignment, a side load that turns with the direction",
    },
    Cause {
        effect: Effect::PositionDependentFriction,
        happens: "it rubs more at some places of the stroke",
        seen: "the force rises at the same places of every stroke, in both directions",
        check: "guides and tube at those places: dents, dirt, alignment, a bent rod",
    },
    Cause {
        effect: Effect::PressureDependentFriction,
        happens: "it rubs more at a high pressure",
        seen: "under high pressure it takes more force to move the rod, both ways",
        check: "the kind of the seals, extrusion gaps, side load that grows with the force",
    },
    Cause {
        effect: Effect::PositionDependentLoad,
        happens: "the load changes with the position",
        seen: "a force that belongs to the place, whichever way the rod moves",
        check: "springs, counterweights, linkage geometry, gravity on a tilting axis: is it in the machine file?",
    },
    Cause {
        effect: Effect::EndStop,
        happens: "the rod meets something before the end of the file's stroke",
        seen: "it stops or bounces at one place",
        check: "cushions, mechanical stops, the stroke and the zero of the position sensor in the file",
    },
    Cause {
        effect: Effect::Presliding,
        happens: "the rod yields like a spring before it slides",
        seen: "small moves come back; at rest the rod follows the force by tenths of a millimetre",
        check: "seals and guides with elastic parts; nothing is worn by this alone",
    },
    Cause {
        effect: Effect::LinkageBacklash,
        happens: "there is play between rod and position sensor",
        seen: "after each change of direction the measured position waits",
        check: "pins, bushes, coupling of the encoder, the mounting of the sensor",
    },
    Cause {
        effect: Effect::PositionSensorLag,
        happens: "the position is measured late",
        seen: "the position trails pressures and flow by a fixed time",
        check: "the sensor's filter time, the bus cycle, the filter in the logger",
    },
    Cause {
        effect: Effect::SensorOffset,
        happens: "a sensor reads too much or too little",
        seen: "a pressure that is not zero with the oil drained; a spool reading without current that is not the data sheet's",
        check: "zero and range of the sensor, its input card and the scaling in the logger",
    },
    Cause {
        effect: Effect::OilTemperature,
        happens: "the oil warms up and gets thinner",
        seen: "it runs differently after an hour than when cold",
        check: "the oil's temperature and cooler, its viscosity class, how long the machine ran before",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_its_cause() {
        for effect in Effect::ALL {
            assert_eq!(cause(*effect).effect, *effect);
        }
    }

    #[test]
    fn each_is_a_clause_of_its_own() {
        for (index, one) in CAUSES.iter().enumerate() {
            for said in [one.happens, one.seen, one.check] {
                assert!(said.starts_with(char::is_lowercase) && !said.ends_with('.'), "{said}");
                assert!(said.len() <= 140, "{} letters: {said}", said.len());
            }
            assert!(one.happens.len() <= 90, "{}", one.happens);
            assert!(CAUSES[..index].iter().all(|other| other.happens != one.happens), "{}", one.happens);
        }
    }
}
