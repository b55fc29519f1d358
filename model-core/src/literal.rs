//! The types of which the coefficients of a drive are made, for the files that `host-sim export --bake` writes. They are no part of the interface: only
//! `coefficients` turns SI values into them, and a baked file is written by the same version that reads it.

pub use fixed::{FixedI32, FixedI64, FixedU32};

pub use crate::chambers::capacity::{Capacity, ChamberCapacity};
pub use crate::chambers::cavitation::{Cavitation, Unsprung};
pub use crate::chambers::{ChamberEffects, Chambers, ExternalLeakage};
pub use crate::correction_table::{Axis, Push, State, Unnamed, ValueGrid};
pub use crate::drive::step::StageWeights;
pub use crate::drive::{Drive, OilSource};
pub use crate::flow::effects::{EdgeEffects, EdgeSizes, GainCurve, ReturnLine, RoundedEdge, ValveLeakage};
pub use crate::flow::load_holding::LoadHolding;
pub use crate::flow::supply::Droop;
pub use crate::flow::{Edges, Lines, Pump};
pub use crate::machine::Bases;
pub use crate::mechanics::end_stop::{Face, Stops};
pub use crate::mechanics::friction::{DryFriction, Placed, PlacedDrag, Stribeck};
pub use crate::mechanics::lugre::{Bend, Bristles};
pub use crate::mechanics::position_load::{PositionLoad, Signed};
pub use crate::mechanics::{MechanicalEffects, Mechanics, Resistance, Row};
pub use crate::number::relaxation::Relaxation;
pub use crate::number::{PerUnit, Single, SinglePair};
pub use crate::oil::{Thinning, Viscosity, Warming};
pub use crate::ports::{ChamberState, Flows, Overlap};
pub use crate::sensing::Sensors;
pub use crate::sensing::sensors::{Delay, Lag, Reading};
pub use crate::valve::Valve;
pub use crate::valve::effects::{
    FlowForce, Hysteresis, NullDrift, SolenoidSaturation, SpeedLimit, Stiction, Swing, SwingingLimit, ValveEffects,
};
