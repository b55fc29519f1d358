//! Every effect that a drive may have beyond the paper's model, in one table: the place where an effect is added.
//!
//! An entry gives the effect's name, the link that it belongs to, its parameters, and two lists of values that switch it on:
//!
//! ```text
//! Name "name" in Link {
//!     Parameter: "key", "unit", least, largest, default, "meaning";       key in the machine file: effects.<name>.<key>
//! } trial {
//!     "": Parameter = value, …;              moderate: host and target run it alike, and its cost is counted
//!     ", another form": Parameter = value;   forms that cost or act differently; the first is part of all effects at once
//! } strong {
//!     "": Parameter = value, …;              so strong that an error of its equations shows: fixed point against f64, tick against tick
//! }
//! ```
//!
//! From it come [`Effect`] with name and link, [`Parameter`](crate::machine::Parameter) with keys, units and ranges, and the forms of
//! [`Effect::trial`] and [`Effect::strong`], which the tests go through. The equations of an effect are in its link's folder. How a plant
//! really behaves is in the virtual plant, which on purpose takes nothing from here.

mod compiled;

pub(crate) use compiled::{AnyEffect, Keeps, Knows, LinkEffects, Nothing, Plain, Vocabulary};

/// Passes the table to the macro `$then`, after that macro's other arguments. A new effect is a new entry, in the order of the chain, which is also
/// the order of the machine file.
macro_rules! effects {
    ($then:ident => $($with:tt)*) => {
        $then! {
            [$($with)*]

            ValveHysteresis "valve-hysteresis" in Valve {
                HysteresisWidth: "width", "1", 0.0, 0.5, 0.0, "Spool travel between settling from above and from below.";
                HysteresisSpread: "spread", "1", 0.0, 1.0, 0.0, "How far the widths of the three play elements lie apart: 0 all alike (backlash), 1 from nil to twice the mean.";
            } trial {
                "": HysteresisWidth = 0.02, HysteresisSpread = 0.5;
            } strong {
                "": HysteresisWidth = 0.05, HysteresisSpread = 0.5;
            }

            SpoolStiction "spool-stiction" in Valve {
                StictionBand: "band", "1", 0.0, 0.5, 0.0, "Spool travel that must be asked for before the stuck spool breaks away.";
                StictionKept: "kept", "1", 0.0, 0.95, 0.0, "Kinetic over static friction: share of the band by which it keeps the spool short of its target.";
            } trial {
                "": StictionBand = 0.01, StictionKept = 0.2;
            } strong {
                "": StictionBand = 0.02, StictionKept = 0.3;
            }

            NullDrift "null-drift" in Valve {
                NullDriftTravel: "travel", "1", -0.5, 0.5, 0.0, "Spool travel that the neutral drifts by in the end; positive extends.";
                NullDriftTime: "time_constant_s", "s", 1e-2, 1e5, 10.0, "Time constant with which the neutral drifts.";
            } trial {
                "": NullDriftTravel = 0.02, NullDriftTime = 2.0;
            } strong {
                "": NullDriftTravel = 0.03, NullDriftTime = 0.3;
            }

            SolenoidSaturation "solenoid-saturation" in Valve {
                SolenoidOnset: "onset", "1", 0.0, 2.0, 0.5, "Spool travel from centre where the solenoid's gain starts to fall.";
                SolenoidCurvature: "curvature", "1", 0.0, 1e3, 0.0, "How fast it falls: beyond the onset travel t becomes t/(1 + curvature·t).";
                SolenoidLoss: "gain_loss", "1", 0.0, 0.95, 0.0, "Share of the gain that is gone at once beyond the onset.";
            } trial {
                "": SolenoidOnset = 0.3, SolenoidCurvature = 0.8, SolenoidLoss = 0.1;
            } strong {
                "": SolenoidOnset = 0.2, SolenoidCurvature = 2.0;
            }

            FlowForce "flow-force" in Valve {
                FlowForce: "closing_per_pa", "1/Pa", 0.0, 1e-6, 0.0, "Share of its travel that the spool is pushed closed by, per pressure difference over both open edges.";
            } trial {
                "": FlowForce = 3e-8;
            } strong {
                "": FlowForce = 4e-8;
            }

            DeadZoneAsymmetry "dead-zone-asymmetry" in Flow {
                DeadZoneDifference: "difference", "1", -1.0, 1.0, 0.0, "Overlap on the extending side less that on the retracting side; half of it is added to one and taken from the other.";
            } trial {
                "": DeadZoneDifference = 0.02;
            } strong {
                "": DeadZoneDifference = 0.1;
            }

            FlowGainNonlinearity "flow-gain-nonlinearity" in Flow {
                FlowGainLinear: "linear", "1", -0.95, 10.0, 0.0, "Relative change of the flow gain per opening.";
                FlowGainBeyond: "beyond", "1", -0.95, 10.0, 0.0, "Relative change of the flow gain beyond the notch.";
                FlowGainNotch: "notch", "1", 0.0, 2.0, 0.2, "Opening at which the notch ends.";
            } trial {
                "": FlowGainLinear = 0.3, FlowGainBeyond = 0.2, FlowGainNotch = 0.1;
            } strong {
                "": FlowGainLinear = 0.5, FlowGainBeyond = -0.5;
            }

            MeteringAsymmetry "metering-asymmetry" in Flow {
                MeteringRatio: "ratio", "1", -0.95, 4.0, 0.0, "Size of the tank edges over that of the supply edges, less 1.";
                MeteringPorts: "ports", "1", -0.95, 4.0, 0.0, "Size of B's edges over that of A's, less 1.";
                MeteringDirections: "directions", "1", -0.95, 4.0, 0.0, "Size of the edges that are open while retracting over that of those open while extending, less 1.";
            } trial {
                "": MeteringRatio = 0.2, MeteringPorts = -0.1, MeteringDirections = 0.05;
                ", tank edges alone": MeteringRatio = 0.2;
            } strong {
                "": MeteringRatio = 0.4, MeteringPorts = -0.3, MeteringDirections = 0.2;
            }

            SupplyDroop "supply-droop" in Flow {
                DroopResistance: "resistance_pa_s_per_m3", "Pa s/m3", 0.0, 1e13, 0.0, "Fall of the supply pressure per delivered flow.";
                DroopTime: "time_constant_s", "s", 0.0, 1e3, 0.0, "Time constant of that fall: the resistance times the accumulator's capacity.";
            } trial {
                "": DroopResistance = 3e9, DroopTime = 0.05;
                ", without memory": DroopResistance = 3e9;
            } strong {
                ", static": DroopResistance = 8e9;
                ", 20 ms": DroopResistance = 8e9, DroopTime = 0.02;
            }

            TankBackPressure "tank-back-pressure" in Flow {
                ReturnResistance: "resistance_pa_s2_per_m6", "Pa s2/m6", 0.0, 1e18, 0.0, "Pressure drop of the return line per flow squared.";
                ReturnLaminar: "laminar_pa_s_per_m3", "Pa s/m3", 0.0, 1e13, 0.0, "Pressure drop of the return line per flow.";
            } trial {
                "": ReturnResistance = 3e12, ReturnLaminar = 1e9;
            } strong {
                "": ReturnResistance = 2e13;
            }

            ValveLeakage "valve-leakage" in Flow {
                ValveLeakageOpening: "opening", "1", 0.0, 0.5, 0.0, "Opening that supply and tank edges of both ports have at the centre.";
                ValveLeakageReach: "reach", "1", 4e-3, 1.0, 0.05, "Spool travel from centre over which that opening falls to half.";
                EdgeRounding: "rounding", "1", 0.0, 0.2, 0.0, "Spool travel over which every edge opens gradually, as its corner is rounded and its spool has play; half of it is open at the edge.";
            } trial {
                "": ValveLeakageOpening = 0.01, EdgeRounding = 0.01;
                ", rounded edges alone": EdgeRounding = 0.01;
            } strong {
                "": ValveLeakageOpening = 0.02, ValveLeakageReach = 0.05;
                ", rounded edges": EdgeRounding = 0.04;
            }

            Counterbalance "counterbalance" in Flow {
                HoldingSetA: "set_a_pa", "Pa", -1e9, 1e9, -1e9, "Pressure of chamber A that opens its load-holding valve without a pilot; A has none where the file does not give it.";
                HoldingSetB: "set_b_pa", "Pa", -1e9, 1e9, -1e9, "The same for chamber B.";
                PilotRatio: "pilot_ratio", "1", 0.0, 15.0, 3.0, "How many times as much as the chamber's own pressure the other side's opens its load-holding valve.";
                HoldingSpan: "span_pa", "Pa", 1e4, 1e9, 2e6, "Pressure beyond its setting at which a load-holding valve is as wide as a metering edge at full travel.";
                HoldingSize: "size", "1", 0.01, 2.0, 2.0, "Opening at its stop, as a share of a metering edge's at full travel.";
                HoldingTime: "time_constant_s", "s", 2e-3, 1.0, 0.02, "Time constant of its poppet.";
            } trial {
                "": HoldingSetA = 6e6, HoldingSetB = 6e6, PilotRatio = 2.0, HoldingSpan = 3e6, HoldingSize = 1.5, HoldingTime = 0.03;
                ", of chamber A": HoldingSetA = 6e6, PilotRatio = 2.0, HoldingSpan = 3e6;
            } strong {
                "": HoldingSetA = 9e6, HoldingSetB = 7e6, PilotRatio = 1.0, HoldingSpan = 4e6;
            }

            LaminarTransition "laminar-transition" in Flow {
                LaminarPressure: "pressure_pa", "Pa", 0.0, 1e7, 0.0, "What the pressure difference of transition is more than the valve's own.";
            } trial {
                "": LaminarPressure = 5e4;
            } strong {
                "": LaminarPressure = 2e5;
            }

            PumpSlip "pump-slip" in Flow {
                PumpSlip: "conductance_m3_per_s_pa", "m3/s/Pa", 0.0, 1e-6, 0.0, "Flow lost inside the turning pump per pressure difference across it.";
            } trial {
                "": PumpSlip = 1e-12;
            } strong {
                "": PumpSlip = 2e-12;
            }

            InternalLeakage "internal-leakage" in Chambers {
                InternalLeakage: "conductance_m3_per_s_pa", "m3/s/Pa", 0.0, 1e-6, 0.0, "Laminar leakage past the piston per (pa - pb); positive from A to B.";
            } trial {
                "": InternalLeakage = 2e-12;
            } strong {
                "": InternalLeakage = 4e-12;
            }

            ExternalLeakage "external-leakage" in Chambers {
                ExternalLeakageA: "conductance_a_m3_per_s_pa", "m3/s/Pa", 0.0, 1e-6, 0.0, "Laminar leakage out of chamber A per pressure above tank.";
                ExternalLeakageB: "conductance_b_m3_per_s_pa", "m3/s/Pa", 0.0, 1e-6, 0.0, "Laminar leakage out of chamber B per pressure above tank.";
            } trial {
                "": ExternalLeakageA = 2e-12, ExternalLeakageB = 4e-12;
            } strong {
                "": ExternalLeakageA = 2e-12, ExternalLeakageB = 4e-12;
            }

            EntrainedAir "entrained-air" in Chambers {
                AirShare: "share", "1", 0.0, 0.5, 0.0, "Volume of free air in the oil at atmospheric pressure, as a share.";
            } trial {
                "": AirShare = 0.01;
            } strong {
                "": AirShare = 0.01;
            }

            HoseCompliance "hose-compliance" in Chambers {
                HoseCompliance: "compliance_m3_per_pa", "m3/Pa", 0.0, 1e-6, 0.0, "Volume that each chamber's hose takes up per pressure, beside V/E0.";
            } trial {
                "": HoseCompliance = 1e-13;
            } strong {
                "": HoseCompliance = 2e-13;
            }

            PositionDependentVolume "position-dependent-volume" in Chambers {
                VolumeShare: "share", "1", 0.0, 1.5, 0.0, "How much of the piston's displacement from mid-stroke the chamber volumes follow; 1 is geometry.";
            } trial {
                "": VolumeShare = 1.0;
            } strong {
                "": VolumeShare = 1.0;
            }

            Cavitation "cavitation" in Chambers {
                CavitationFloor: "floor_pa", "Pa", -1e9, 1e7, -1e9, "Pressure that a chamber does not fall below, that of the oil's vapour or of the air that it gives off, from the same zero as the tank's: from a vacuum, -101300, up to the tank's pressure. Oil pulls without limit where the file does not give it.";
            } trial {
                "": CavitationFloor = -3e4;
            } strong {
                "": CavitationFloor = -3e4;
            }

            CoulombFriction "coulomb-friction" in Mechanics {
                CoulombFriction: "force_n", "N", 0.0, 1e8, 0.0, "Dry friction force against motion; the rod sticks while the other forces stay below it.";
            } trial {
                "": CoulombFriction = 500.0;
            } strong {
                "": CoulombFriction = 500.0;
            }

            StribeckFriction "stribeck-friction" in Mechanics {
                StribeckForce: "force_n", "N", 0.0, 1e8, 0.0, "Dry friction force at speed.";
                StribeckExcess: "excess_n", "N", 0.0, 1e8, 0.0, "What the force to break away is more than that.";
                StribeckVelocity: "velocity_m_per_s", "m/s", 1e-5, 10.0, 0.01, "Velocity at which half of the excess is gone.";
            } trial {
                "": StribeckForce = 300.0, StribeckExcess = 300.0, StribeckVelocity = 0.02;
            } strong {
                "": StribeckForce = 300.0, StribeckExcess = 300.0, StribeckVelocity = 0.02;
            }

            FrictionAsymmetry "friction-asymmetry" in Mechanics {
                AsymmetricExtending: "extending_n", "N", 0.0, 1e8, 0.0, "Dry friction force while extending.";
                AsymmetricRetracting: "retracting_n", "N", 0.0, 1e8, 0.0, "Dry friction force while retracting.";
            } trial {
                "": AsymmetricExtending = 200.0, AsymmetricRetracting = 100.0;
            } strong {
                "": AsymmetricExtending = 600.0, AsymmetricRetracting = 300.0;
            }

            PositionDependentFriction "position-dependent-friction" in Mechanics {
                PositionFriction: "force_n", "N", 0.0, 1e8, 0.0, "Dry friction force at mid-stroke.";
                PositionFrictionSlope: "slope_n", "N", -1e8, 1e8, 0.0, "What it is more with the rod fully out, and less with it fully in.";
                PositionFrictionBow: "bow_n", "N", -1e8, 1e8, 0.0, "What it is more at both ends of the stroke.";
                PositionDragSlope: "viscous_slope", "1", -7.9, 7.9, 0.0, "Share of the viscous friction that it is more with the rod fully out, and less with it fully in.";
                PositionDragBow: "viscous_bow", "1", -7.9, 7.9, 0.0, "Share of the viscous friction that it is more at both ends of the stroke.";
            } trial {
                "": PositionFriction = 200.0, PositionFrictionSlope = 100.0, PositionFrictionBow = 50.0, PositionDragSlope = 0.5, PositionDragBow = -0.2;
            } strong {
                "": PositionFriction = 400.0, PositionFrictionSlope = 200.0, PositionFrictionBow = 100.0;
                ", viscous": PositionDragSlope = 0.8, PositionDragBow = -0.4;
            }

            PressureDependentFriction "pressure-dependent-friction" in Mechanics {
                PressureFriction: "area_m2", "m2", 0.0, 1.0, 0.0, "Dry friction force per sum of both chamber pressures.";
            } trial {
                "": PressureFriction = 3e-5;
            } strong {
                "": PressureFriction = 5e-5;
            }

            PositionDependentLoad "position-dependent-load" in Mechanics {
                LoadSpring: "stiffness_n_per_m", "N/m", -1e9, 1e9, 0.0, "Force against extending per position from mid-stroke.";
                LoadSpringForce: "force_n", "N", -1e8, 1e8, 0.0, "Force against extending at mid-stroke.";
                LoadSpringBow: "bow_n_per_m2", "N/m2", -1e10, 1e10, 0.0, "Force against extending per square of the position from mid-stroke.";
            } trial {
                "": LoadSpring = 5e3, LoadSpringForce = 500.0, LoadSpringBow = 1e4;
            } strong {
                "": LoadSpring = 2e4, LoadSpringForce = 500.0, LoadSpringBow = 1e4;
            }

            EndStop "end-stop" in Mechanics {
                StopRetracted: "retracted_at_m", "m", -100.0, 100.0, -100.0, "Position below which the retracted stop pushes back.";
                StopExtended: "extended_at_m", "m", -100.0, 100.0, 100.0, "Position above which the extended stop pushes back.";
                StopStiffness: "stiffness_n_per_m", "N/m", 0.0, 1e11, 0.0, "Force of a stop per depth.";
                StopDamping: "damping_n_s_per_m", "N s/m", 0.0, 1e9, 0.0, "Force of a stop per velocity into it.";
            } trial {
                "": StopRetracted = 0.12, StopExtended = 0.18, StopStiffness = 1e8, StopDamping = 1e4;
            } strong {
                "": StopRetracted = 0.115, StopExtended = 0.125, StopStiffness = 1e8, StopDamping = 1e4;
            }

            Presliding "presliding" in Mechanics {
                PreslidingForce: "force_n", "N", 0.0, 1e8, 0.0, "Dry friction force while sliding.";
                PreslidingStiffness: "stiffness_n_per_m", "N/m", 0.0, 1e12, 0.0, "Stiffness of the bristles that all dry friction acts through before the rod slides; 0 holds rigidly.";
            } trial {
                "": PreslidingForce = 300.0, PreslidingStiffness = 1e8;
            } strong {
                "": PreslidingForce = 500.0, PreslidingStiffness = 1e8;
            }

            LinkageBacklash "linkage-backlash" in Sensing {
                BacklashPlay: "play_m", "m", 0.0, 0.1, 0.0, "Travel of the rod that the position's sensor does not notice after a reversal.";
            } trial {
                "": BacklashPlay = 1e-3;
            } strong {
                "": BacklashPlay = 1e-3;
            }

            PositionSensorLag "position-sensor-lag" in Sensing {
                PositionLag: "time_constant_s", "s", 0.0, 1.0, 0.0, "Time constant of the position's sensor.";
                PositionDelay: "delay_s", "s", 0.0, 0.05, 0.0, "Dead time of the position's sensor.";
            } trial {
                "": PositionLag = 5e-3, PositionDelay = 7.3e-3;
            } strong {
                "": PositionLag = 5e-3, PositionDelay = 7.3e-3;
            }

            SensorOffset "sensor-offset" in Sensing {
                PressureAOffset: "pressure_a_pa", "Pa", -1e7, 1e7, 0.0, "What the pressure sensor of chamber A reads too much.";
                PressureBOffset: "pressure_b_pa", "Pa", -1e7, 1e7, 0.0, "What the pressure sensor of chamber B reads too much.";
                SpoolOffset: "spool", "1", -0.5, 0.5, 0.0, "What the spool's sensor reads too much.";
                PressureAFactor: "pressure_a_factor", "1", -0.9, 1.0, 0.0, "Gain error of the pressure sensor of chamber A.";
                PressureBFactor: "pressure_b_factor", "1", -0.9, 1.0, 0.0, "Gain error of the pressure sensor of chamber B.";
                SpoolFactor: "spool_factor", "1", -0.9, 1.0, 0.0, "Gain error of the spool's sensor.";
                PositionFactor: "position_factor", "1", -0.9, 1.0, 0.0, "Gain error of the position's sensor, from where the recording starts.";
            } trial {
                "": PressureAOffset = 1e5, PressureBOffset = -5e4, SpoolOffset = 0.01, PressureAFactor = 0.01, PressureBFactor = 0.02, SpoolFactor = -0.01, PositionFactor = 0.01;
            } strong {
                "": PressureAOffset = 1e5, PressureBFactor = 0.02, SpoolOffset = 0.01, PositionFactor = 0.01;
            }

            OilTemperature "oil-temperature" in Mechanics {
                ViscosityLoss: "viscosity_loss", "1", -3.0, 0.95, 0.0, "Share of the oil's viscosity that is lost in the end as it warms; viscous friction falls with it, leakage rises.";
                WarmingTime: "time_constant_s", "s", 1e-2, 1e5, 10.0, "Time constant with which the oil warms.";
                ViscosityLossPerKelvin: "viscosity_loss_per_k", "1/K", 0.0, 0.1, 0.0, "Relative loss of viscosity per kelvin of measured temperature: viscosity is e^(-loss (T - reference)) of that at the reference, within 1/8 to 8.";
                ReferenceTemperature: "reference_temperature_c", "°C", -20.0, 120.0, 40.0, "Temperature of the oil that the file's values are for, and where nobody measures it.";
            } trial {
                "": ViscosityLoss = 0.3, WarmingTime = 5.0, ViscosityLossPerKelvin = 0.04, ReferenceTemperature = 40.0;
            } strong {
                "": ViscosityLoss = 0.6, WarmingTime = 0.5, InternalLeakage = 2e-12;
                ", measured": ViscosityLossPerKelvin = 0.04, ReferenceTemperature = 30.0, InternalLeakage = 2e-12;
            }
        }
    };
}
pub(crate) use effects;

/// A link of the chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Link {
    /// Command → spool.
    Valve,
    /// Spool and pressures → flows.
    Flow,
    /// Flows and velocity → pressures.
    Chambers,
    /// Forces → motion.
    Mechanics,
    /// Motion → measured motion.
    Sensing,
}

impl Link {
    /// Its name, as used in a finding.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Link::Valve => "valve",
            Link::Flow => "flow",
            Link::Chambers => "chambers",
            Link::Mechanics => "mechanics",
            Link::Sensing => "sensing",
        }
    }
}

macro_rules! names {
    ([] $($effect:ident $name:literal in $link:ident { $($row:tt)* } trial { $($trial:tt)* } strong { $($strong:tt)* })*) => {
        /// An effect: what a drive may have and the paper's model leaves out. Neutral while its parameters are at their defaults.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub enum Effect { $(#[doc = concat!("`", $name, "`")] $effect,)* }

        impl Effect {
            /// Every effect, in the order of the machine file.
            pub const ALL: &'static [Effect] = &[$(Effect::$effect,)*];

            /// Its name in the machine file and in findings.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Effect::$effect => $name,)* }
            }

            /// The link that it belongs to.
            #[must_use]
            pub const fn link(self) -> Link {
                match self { $(Effect::$effect => Link::$link,)* }
            }
        }
    };
}
effects! { names => }

impl Effect {
    /// The effect of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|effect| effect.name() == name)
    }
}
