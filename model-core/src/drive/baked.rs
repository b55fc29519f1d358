//! A drive whose coefficients are constants: `host-sim export --bake` writes them, and no coefficient is computed on a controller.
//!
//! The equations are those of [`Drive`], compiled for the drive's own effects. Every function of the step asks a type for the coefficients of its link's
//! effects and is given the constants, so each branch on an effect that is off is a branch on a constant: the compiler leaves it out in every function,
//! inlined or not, at every level of optimisation that folds constants (1 and above, `s`, `z`). `tests/on_target/baked_images.rs` looks for
//! what is left of effects that are off in images, at several levels.

use core::fmt;
use core::marker::PhantomData;

use crate::chambers::ChamberEffects;
use crate::drive::state::{DriveInput, DriveState, Interfaces, Load};
use crate::drive::{Drive, OilSource};
use crate::effects::{Knows, Vocabulary};
use crate::flow::effects::EdgeEffects;
use crate::machine::Bases;
use crate::mechanics::MechanicalEffects;
use crate::number::Number;
use crate::oil::Viscosity;
use crate::ports::ChamberState;
use crate::sensing::Sensed;
use crate::valve::effects::ValveEffects;

/// Coefficients that are known when a program is compiled: the type `Exported` of a file that `host-sim export --bake` has written.
pub trait Baked: 'static {
    /// The number type.
    type Number: Number + 'static;
    /// The coefficients.
    const DRIVE: &'static Drive<Self::Number>;
}

/// A drive of baked coefficients. It occupies no memory, and its code is that of the effects that the drive has.
///
/// Its results are those of [`Drive`], bit for bit.
///
/// ```ignore
/// mod params {
///     include!("params.rs"); // host-sim export --machine M.toml --bake --out params.rs
/// }
/// let drive = BakedDrive::<params::Exported>::new();
/// let mut state: DriveState<PerUnit, { params::DELAY_LINE }> = drive.at_rest(PerUnit::ZERO, pressures, position);
/// drive.step(&mut state, DriveInput::Command(command), Load::NONE); // once a tick
/// ```
pub struct BakedDrive<B>(PhantomData<B>);

impl<B: Baked> BakedDrive<B> {
    /// The drive.
    #[must_use]
    pub const fn new() -> Self {
        Self(PhantomData)
    }

    /// The coefficients, for what asks for more than a step, such as control.
    #[must_use]
    pub const fn coefficients(&self) -> &'static Drive<B::Number> {
        B::DRIVE
    }

    /// The scales of all per-unit quantities.
    #[must_use]
    pub const fn bases(&self) -> &'static Bases {
        &B::DRIVE.bases
    }

    /// Whether the viscosity follows a measured temperature, [`DriveState::oil_temperature`].
    #[must_use]
    pub const fn measures_oil(&self) -> bool {
        matches!(B::DRIVE.viscosity, Some(Viscosity { thinning: Some(_), .. }))
    }

    /// A drive at rest, as [`Drive::at_rest`].
    #[must_use]
    pub fn at_rest<const DELAY: usize>(
        &self,
        command: B::Number,
        pressures: ChamberState<B::Number>,
        position: <B::Number as Number>::Travel,
    ) -> DriveState<B::Number, DELAY> {
        B::DRIVE.at_rest_with::<Only<B>, DELAY>(command, pressures, position)
    }

    /// One tick, as [`Drive::step`]. Where the kind of drive input is known at the place of the call, the code of the others is left out.
    ///
    /// It is inlined: call it in one place.
    #[inline(always)]
    pub fn step<const DELAY: usize>(
        &self,
        state: &mut DriveState<B::Number, DELAY>,
        drive_input: DriveInput<B::Number>,
        load: Load<B::Number>,
    ) -> Interfaces<B::Number> {
        let drive = B::DRIVE;
        if let Some(seen) = drive.step_plain(state, drive_input, load) {
            return seen;
        }
        if let Some(force) = drive.force(drive_input, load) {
            return drive.step_force::<Only<B, true>, DELAY>(state, force);
        }
        let Some(cavitation) = &drive.chambers.effects.cavitation else {
            return drive.step_fed::<Only<B>, DELAY>((&drive.chambers, &drive.mechanics), state, drive_input, load);
        };
        drive.cavitating::<Only<B>, DELAY>(cavitation, state, drive_input, |links, state, drive_input| {
            drive.step_fed::<Only<B>, DELAY>(links, state, drive_input, load)
        })
    }

    /// Readings of the sensors, as [`Drive::sensed`].
    #[must_use]
    #[inline]
    pub fn sensed<const DELAY: usize>(&self, state: &DriveState<B::Number, DELAY>) -> Sensed<B::Number> {
        let spool = B::DRIVE.spool_with::<Only<B>, DELAY>(state);
        B::DRIVE.sensors.read(&state.sensed, spool, state.chambers, &state.motion)
    }
}

impl<B: Baked> Default for BakedDrive<B> {
    fn default() -> Self {
        Self::new()
    }
}

impl<B> Clone for BakedDrive<B> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B> Copy for BakedDrive<B> {}

impl<B> fmt::Debug for BakedDrive<B> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("BakedDrive")
    }
}

/// A vocabulary that has the coefficients of every link's effects.
pub(crate) trait KnowsLinks<N: Number>:
    Knows<ValveEffects<N>> + Knows<EdgeEffects<N>> + Knows<ChamberEffects<N>> + Knows<MechanicalEffects<N>>
{
}

impl<N: Number, V> KnowsLinks<N> for V where
    V: Knows<ValveEffects<N>> + Knows<EdgeEffects<N>> + Knows<ChamberEffects<N>> + Knows<MechanicalEffects<N>>
{
}

/// The effects of a baked drive; its mass is that of a drive under a given force, if it is `UNSPRUNG`.
pub(crate) struct Only<B, const UNSPRUNG: bool = false>(PhantomData<B>);

impl<B, const UNSPRUNG: bool> Clone for Only<B, UNSPRUNG> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<B, const UNSPRUNG: bool> Copy for Only<B, UNSPRUNG> {}

impl<B, const UNSPRUNG: bool> fmt::Debug for Only<B, UNSPRUNG> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Only")
    }
}

impl<B: Baked, const UNSPRUNG: bool> Vocabulary for Only<B, UNSPRUNG> {
    const PLAIN: bool = false;
    const KNOWN: bool = true;
    const METERED: bool = matches!(B::DRIVE.source, OilSource::Valve(..));
    const PUMPED: bool = matches!(B::DRIVE.source, OilSource::Pump(_));
    const WARMS: bool = B::DRIVE.viscosity.is_some();
    const TABLED: bool = B::DRIVE.unnamed.is_some();
    const HARD: Option<bool> = Some(if UNSPRUNG { B::DRIVE.unsprung.hard } else { B::DRIVE.mechanics.hard });

    #[inline(always)]
    fn on<T>(effect: Option<&T>) -> Option<&T> {
        effect
    }
}

impl<B: Baked, const UNSPRUNG: bool> Knows<ValveEffects<B::Number>> for Only<B, UNSPRUNG> {
    #[inline(always)]
    fn of(_: Option<&ValveEffects<B::Number>>) -> Option<&ValveEffects<B::Number>> {
        if let OilSource::Valve(valve, _) = &B::DRIVE.source { Some(&valve.effects) } else { None }
    }
}

impl<B: Baked, const UNSPRUNG: bool> Knows<EdgeEffects<B::Number>> for Only<B, UNSPRUNG> {
    #[inline(always)]
    fn of(_: Option<&EdgeEffects<B::Number>>) -> Option<&EdgeEffects<B::Number>> {
        if let OilSource::Valve(_, edges) = &B::DRIVE.source { edges.effects.as_ref() } else { None }
    }
}

impl<B: Baked, const UNSPRUNG: bool> Knows<ChamberEffects<B::Number>> for Only<B, UNSPRUNG> {
    #[inline(always)]
    fn of(_: Option<&ChamberEffects<B::Number>>) -> Option<&ChamberEffects<B::Number>> {
        Some(&B::DRIVE.chambers.effects)
    }
}

impl<B: Baked, const UNSPRUNG: bool> Knows<MechanicalEffects<B::Number>> for Only<B, UNSPRUNG> {
    #[inline(always)]
    fn of(_: Option<&MechanicalEffects<B::Number>>) -> Option<&MechanicalEffects<B::Number>> {
        let drive = B::DRIVE;
        Some(if UNSPRUNG { &drive.unsprung.effects } else { &drive.mechanics.effects })
    }
}
