//! Coefficients of the mechanics.

use super::Builder;
use crate::chambers::cavitation::Unsprung;
use crate::coefficients::bases::{SLIPPERIEST, least_drag, thinnest};
use crate::machine::{Bases, Machine, MachineError, Parameter as P, Source};
use crate::mechanics::end_stop::{Face, Stops};
use crate::mechanics::friction::{DryFriction, Placed, PlacedDrag, STRIBECK_WIDTH, Stribeck};
use crate::mechanics::lugre::{Bend, Bristles};
use crate::mechanics::position_load::{PositionLoad, Signed};
use crate::mechanics::{GAMMA, MechanicalEffects, Mechanics, Resistance, Row};
use crate::number::{Number, Real};

/// Largest steep coefficient of the bristles and of a rod that meets a stop, given by the format. Steeper ones are limited to it.
const STEEPEST: f64 = 6e4;
/// Velocity at which the direction counts half for the bristles.
const AT_REST: f64 = 6.1e-5;
/// Positions beyond this many strokes are out of a signal's range: no stop is there.
const OUT_OF_REACH: f64 = 7.9;

impl<R: Real> Machine<R> {
    /// The largest dry friction of all laws together, each at its largest over the stroke and its seals under as much as the supply's pressure in both
    /// chambers together, N. It is the unit of the bristles' force.
    #[must_use]
    pub fn largest_friction_n(&self, bases: &Bases) -> f64 {
        let seals_n = self.get(P::PressureFriction).value() * bases.pressure_pa;
        self.dry_friction_n() + if self.source == Source::Force { 0.0 } else { seals_n }
    }

    /// The same without the seals under pressure.
    pub(super) fn dry_friction_n(&self) -> f64 {
        let force_n = |of: P| self.get(of).value();
        let constant_n = force_n(P::CoulombFriction) + force_n(P::PreslidingForce) + force_n(P::StribeckForce);
        let directed_n = force_n(P::AsymmetricExtending).max(force_n(P::AsymmetricRetracting));
        let placed_n = force_n(P::PositionFriction)
            + force_n(P::PositionFrictionSlope).abs()
            + force_n(P::PositionFrictionBow).abs();
        constant_n + force_n(P::StribeckExcess) + directed_n + placed_n
    }

    /// Whether dry friction acts through bristles.
    #[must_use]
    pub fn has_bristles(&self, bases: &Bases) -> bool {
        self.get(P::PreslidingStiffness).value() > 0.0 && self.largest_friction_n(bases) > 0.0
    }
}

impl<R: Real> Builder<'_, R> {
    /// The mass with which the step gives the oil spring the frequency that the moving mass gives it in reality.
    ///
    /// One step multiplies a mode by R(z) = eᶻ + (γ − γ² − 1/6)·z³ + …, so an oil spring of K on m, with θ² = h²·K/m, oscillates
    /// more slowly by (γ − γ² − 1/6)·θ²; a mass smaller by twice that compensates. The correction is of second order like the step itself and
    /// fades where there is no oscillation to keep: under strong damping, D² ≫ K·m, and where the step resolves none, θ > 1.
    pub(super) fn sprung_mass(&self) -> R {
        self.get(P::MovingMass)
            / self.lightening(self.spring_of(P::AreaA, P::VolumeA) + self.spring_of(P::AreaB, P::VolumeB))
    }

    /// Stiffness of a chamber's oil under the rod, N/m.
    fn spring_of(&self, area: P, volume: P) -> R {
        self.get(area) * self.get(area) / self.capacity(volume)
    }

    /// The moving mass over the mass with which the step gives this spring the same frequency.
    fn lightening(&self, spring: R) -> R {
        let (mass, damping) = (self.get(P::MovingMass), self.get(P::ViscousFriction));
        let turn = R::constant(self.tick_s * self.tick_s) * spring / mass;
        let fading = R::ONE + damping * damping / (spring * mass) + turn * turn;
        R::ONE + R::constant(2.0 * (GAMMA - GAMMA * GAMMA - 1.0 / 6.0)) * turn / fading
    }

    /// By how much the mass grows where chambers cavitate.
    pub(super) fn unsprung<N: Number<Real = R>>(&self) -> Result<Unsprung<N>, MachineError> {
        let (a, b) = (self.spring_of(P::AreaA, P::VolumeA), self.spring_of(P::AreaB, P::VolumeB));
        let both = self.lightening(a + b);
        let without = |left: R| R::ONE - left / both;
        let (no_a, no_b) = (without(self.lightening(b)), without(self.lightening(a)));
        let gain = |value: R| self.gain::<N>("share of the mass without its oil spring", P::MovingMass, value);
        Ok(Unsprung { a: gain(no_a)?, b: gain(no_b)?, together: gain(without(R::ONE) - no_a - no_b)? })
    }

    /// h·D/m in the thinnest oil at the place where it brakes least, plus the damping of the table of forces.
    fn damping(&self, mass: R) -> R {
        let damping = self.get(P::ViscousFriction) * least_drag(self.machine) + self.table_damping();
        damping * R::constant(self.tick_s) / mass
    }

    /// 1 + γ·h·D/m
    fn own_diagonal(&self, mass: R) -> R {
        R::ONE + R::constant(GAMMA) * self.damping(mass)
    }

    /// Velocity gained per tick at force 1, implicit in the viscous friction. (12)
    fn mobility(&self, mass: R) -> R {
        R::constant(self.tick_s * self.bases.force_n / self.bases.velocity_m_per_s) / (mass * self.own_diagonal(mass))
    }

    /// Force per velocity of the viscous friction that is on the mass's own diagonal.
    fn viscous(&self, mass: R) -> R {
        self.damping(mass) / (self.own_diagonal(mass) * self.mobility(mass))
    }

    pub(super) fn mechanics<N: Number<Real = R>>(&self, mass: R) -> Result<Mechanics<N>, MachineError> {
        let viscous = self.viscous(mass);
        let hard = N::gain(viscous).is_none();
        let travel = R::constant(self.tick_s * self.bases.velocity_m_per_s) / self.get(P::Stroke);
        let (dry, turn) = self.dry_friction(mass)?;
        Ok(Mechanics {
            row: Row {
                mobility: self.gain::<N>(
                    "velocity gained per tick at full force",
                    P::MovingMass,
                    self.mobility(mass),
                )?,
                pull: self.gain::<N>(
                    "velocity gained per tick at full force",
                    P::MovingMass,
                    R::constant(GAMMA) * self.mobility(mass),
                )?,
                drag: self.gain::<N>(
                    "velocity lost per tick",
                    P::ViscousFriction,
                    self.damping(mass) / self.own_diagonal(mass),
                )?,
                back: self.gain::<N>(
                    "second stage",
                    P::ViscousFriction,
                    R::constant(1.0 - GAMMA) / self.own_diagonal(mass),
                )?,
                share: None,
            },
            viscous: self.gain::<N>("viscous force", P::ViscousFriction, if hard { R::ZERO } else { viscous })?,
            hard,
            gamma: self.gain::<N>("the step's γ", P::Stroke, R::constant(GAMMA))?,
            travel: self.gain::<N>("strokes per tick", P::Stroke, travel)?,
            load: self.signal("load over full force", P::LoadForce, self.force(P::LoadForce))?,
            turn,
            effects: MechanicalEffects { dry, resistance: self.resistance(mass)?, push: self.push()? },
        })
    }

    /// A force over the full force.
    fn force(&self, of: P) -> R {
        self.get(of) / R::constant(self.bases.force_n)
    }

    fn is_on(&self, strengths: &[P]) -> bool {
        strengths.iter().any(|&strength| !self.get(strength).is_nil())
    }

    /// Dry friction, and the velocity that its constant parts, of both directions together, take in a tick.
    fn dry_friction<N: Number<Real = R>>(&self, mass: R) -> Result<(DryFriction<N>, N), MachineError> {
        // With bristles the levels are shares of their reference.
        let scale = if self.machine.has_bristles(&self.bases) {
            self.bases.force_n / self.machine.largest_friction_n(&self.bases)
        } else {
            1.0
        };
        let share = |of: P| self.force(of) * R::constant(scale);
        let force = |of: P| self.signal::<N>("dry friction over full force", of, share(of));
        let alike = share(P::CoulombFriction) + share(P::StribeckForce) + share(P::PreslidingForce);
        let extending = alike + share(P::AsymmetricExtending);
        let retracting = alike + share(P::AsymmetricRetracting);
        // The parameter that moves it most.
        let largest = [P::StribeckForce, P::PreslidingForce, P::AsymmetricExtending, P::AsymmetricRetracting]
            .into_iter()
            .fold(P::CoulombFriction, |most, of| if self.get(of).value() > self.get(most).value() { of } else { most });
        let stribeck = if self.is_on(&[P::StribeckExcess]) {
            let per_velocity =
                R::constant(STRIBECK_WIDTH * self.bases.velocity_m_per_s) / self.get(P::StribeckVelocity);
            Some(Stribeck {
                excess: force(P::StribeckExcess)?,
                per_velocity: self.steep::<N>("inverse of the Stribeck velocity", P::StribeckVelocity, per_velocity)?,
                unity: self.steep::<N>("one", P::StribeckVelocity, R::ONE)?,
            })
        } else {
            None
        };
        let placed = if self.is_on(&[P::PositionFriction, P::PositionFrictionSlope, P::PositionFrictionBow]) {
            Some(Placed {
                level: force(P::PositionFriction)?,
                slope: force(P::PositionFrictionSlope)?,
                bow: force(P::PositionFrictionBow)?,
            })
        } else {
            None
        };
        let has_oil = self.machine.source != Source::Force;
        let seals = if has_oil && self.is_on(&[P::PressureFriction]) {
            let share = self.get(P::PressureFriction) / self.get(P::AreaA) * R::constant(scale);
            Some(self.signal("friction of the seals over full force", P::PressureFriction, share)?)
        } else {
            None
        };
        let dry = DryFriction {
            extending: self.signal("dry friction over full force", largest, extending)?,
            retracting: self.signal("dry friction over full force", largest, retracting)?,
            stribeck,
            placed,
            seals,
        };
        let turn = (extending + retracting) * self.mobility(mass);
        Ok((dry, self.signal("velocity that dry friction takes in a tick", largest, turn)?))
    }

    /// What a damper of 1 N s/m adds to the mass's own diagonal, over the diagonal.
    fn weight(&self, mass: R) -> R {
        R::constant(GAMMA * self.tick_s) / (mass * self.own_diagonal(mass))
    }

    fn resistance<N: Number<Real = R>>(&self, mass: R) -> Result<Option<Resistance<N>>, MachineError> {
        let load = self.is_on(&[P::LoadSpring, P::LoadSpringForce, P::LoadSpringBow]);
        let stops = self.is_on(&[P::StopStiffness, P::StopDamping]);
        let bristles = self.machine.has_bristles(&self.bases);
        let drag = self.is_on(&[P::PositionDragSlope, P::PositionDragBow]);
        let warms = self.is_on(&[P::ViscosityLoss, P::ViscosityLossPerKelvin]);
        if !(load || stops || bristles || warms || drag) {
            return Ok(None);
        }
        let none = self.steep::<N>("nothing", P::Stroke, R::ZERO)?;
        let gain = |value: f64| self.gain::<N>("a weight of the step", P::Stroke, R::constant(value));
        let viscosity = self.get(P::ViscousFriction) * self.weight(mass);
        let load_weight = self.solved_stiffness() * R::constant(GAMMA * self.tick_s) * self.weight(mass);
        Ok(Some(Resistance {
            drag: if drag { Some(self.placed_drag()?) } else { None },
            viscosity: if warms || drag {
                self.steep::<N>("viscous friction on the mass", P::ViscousFriction, viscosity)?
            } else {
                none
            },
            load: if load { Some(self.position_load()?) } else { None },
            load_weight: self.steep::<N>("load's stiffness on the mass", P::LoadSpring, load_weight)?,
            bristles: if bristles { Some(self.bristles(mass)?) } else { None },
            stops: if stops { Some(self.stops(mass)?) } else { None },
            per_gamma: gain(1.0 / GAMMA)?,
            second: gain(1.0 - 2.0 * GAMMA)?,
            none,
        }))
    }

    fn placed_drag<N: Number<Real = R>>(&self) -> Result<PlacedDrag<N>, MachineError> {
        let signal = |of: P, value: R| self.signal::<N>("share of the viscous friction", of, value);
        Ok(PlacedDrag {
            share: Placed {
                level: N::ONE,
                slope: signal(P::PositionDragSlope, self.get(P::PositionDragSlope))?,
                bow: signal(P::PositionDragBow, self.get(P::PositionDragBow))?,
            },
            slipperiest: N::saturated(SLIPPERIEST),
            thinnest: signal(P::ViscosityLoss, thinnest(self.machine))?,
            least: signal(P::PositionDragSlope, least_drag(self.machine))?,
        })
    }

    /// The load's stiffness where it holds the rod, N/m: this is solved implicitly. A stiffness that pushes the rod away from mid-stroke is not.
    fn solved_stiffness(&self) -> R {
        let stiffness = self.get(P::LoadSpring);
        if stiffness.value() > 0.0 { stiffness } else { R::ZERO }
    }

    fn position_load<N: Number<Real = R>>(&self) -> Result<PositionLoad<N>, MachineError> {
        let force = R::constant(self.bases.force_n);
        let stroke = self.get(P::Stroke);
        let signed = |of: P, value: R| -> Result<Signed<N>, MachineError> {
            let negative = value.value() < 0.0;
            let magnitude =
                self.steep::<N>("load of a stroke over full force", of, if negative { -value } else { value })?;
            Ok(Signed { magnitude, negative })
        };
        let taken_back = R::constant(2.0 * GAMMA) * self.solved_stiffness() * stroke / force;
        Ok(PositionLoad {
            force: self.signal(
                "load at mid-stroke over full force",
                P::LoadSpringForce,
                self.force(P::LoadSpringForce),
            )?,
            stiffness: signed(P::LoadSpring, self.get(P::LoadSpring) * stroke / force)?,
            bow: signed(P::LoadSpringBow, self.get(P::LoadSpringBow) * stroke * stroke / force)?,
            taken_back: self.steep::<N>("load of a stroke over full force", P::LoadSpring, taken_back)?,
        })
    }

    fn stops<N: Number<Real = R>>(&self, mass: R) -> Result<Stops<N>, MachineError> {
        let face = |at: P| {
            let strokes = self.get(at) / self.get(P::Stroke);
            (strokes.value().abs() < OUT_OF_REACH).then(|| Face { place: N::travel(strokes) })
        };
        let (stiffness, damping) = (self.get(P::StopStiffness), self.get(P::StopDamping));
        let force = stiffness * self.get(P::Stroke) / R::constant(self.bases.force_n);
        let weight = (damping + R::constant(GAMMA * self.tick_s) * stiffness) * self.weight(mass);
        let per_stroke_a_tick = self.get(P::Stroke) / R::constant(self.tick_s * self.bases.velocity_m_per_s);
        let steepest = R::constant(STEEPEST);
        let per_stroke_a_tick = if per_stroke_a_tick.value() < STEEPEST { per_stroke_a_tick } else { steepest };
        Ok(Stops {
            retracted: face(P::StopRetracted),
            extended: face(P::StopExtended),
            stiffness: self.steep::<N>("stop's force of a stroke over full force", P::StopStiffness, force)?,
            weight: self.steep::<N>("stop on the mass", P::StopStiffness, weight)?,
            per_stroke: self.steep::<N>("velocity of a stroke a tick", P::Stroke, per_stroke_a_tick)?,
        })
    }

    fn bristles<N: Number<Real = R>>(&self, mass: R) -> Result<Bristles<N>, MachineError> {
        let reference_n = self.machine.largest_friction_n(&self.bases);
        // Per stiffness: the bend of a tick at velocity 1, and the part that is solved on the mass.
        let bend = self.tick_s * self.bases.velocity_m_per_s / reference_n;
        let weight = R::constant(GAMMA * self.tick_s) * self.weight(mass);
        let stiffest = STEEPEST / bend.max(weight.value());
        let stiffness = self.get(P::PreslidingStiffness);
        let stiffness = if stiffness.value() < stiffest { stiffness } else { R::constant(stiffest) };
        let of_step = R::constant(GAMMA * self.tick_s) * stiffness;
        let square = R::constant(4.0) * stiffness * self.get(P::MovingMass);
        let critical = if square.value() < of_step.value() * of_step.value() { square.sqrt() } else { of_step };
        let steep = |coefficient: &'static str, value: R| self.steep::<N>(coefficient, P::PreslidingStiffness, value);
        let bend =
            |share: f64| steep("bend of the bristles in a tick at velocity 1", R::constant(share * bend) * stiffness);
        Ok(Bristles {
            reference: self.signal(
                "friction of the bristles over full force",
                P::PreslidingStiffness,
                R::constant(reference_n / self.bases.force_n),
            )?,
            bend: Bend { half: bend(0.5)?, ahead: bend(GAMMA)?, second: bend(1.0 - 2.0 * GAMMA)? },
            stiffness_weight: steep("stiffness of the bristles on the mass", weight * stiffness)?,
            damping_weight: steep("damping of the bristles on the mass", critical * self.weight(mass))?,
            at_rest: steep("velocity of rest", R::constant(AT_REST))?,
            unity: steep("one", R::ONE)?,
        })
    }
}
