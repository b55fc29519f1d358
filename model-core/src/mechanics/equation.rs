//! The equation of motion of the mass in one tick, from the rod's present state: its diagonal, the forces at the two stages, and the step.
//!
//! ```text
//! m·dv/dt = F + A·pa − α·A·pb − Dw·v      (14), with what the effects add
//! ```
//!
//! Effects that add to the mass's own diagonal 1 + γ·h·D/m (viscosity, a spring, bristles, a stop) are computed as dampers s that act on the
//! velocity at the stage, v + γ·k. A spring of stiffness k is a damper s = γ·h·k plus the spring's force at the tick's start. With r = old
//! diagonal over new one, mobility and `back` are multiplied by r, and the drag becomes drag·r + (1 − r)/γ.

use core::marker::PhantomData;

use super::{Contact, MechanicalEffects, Mechanics, Resistance, Row};
use crate::effects::{Keeps, Knows};
use crate::mechanics::end_stop::Touch;
use crate::mechanics::friction::Level;
use crate::mechanics::lugre::Gripping;
use crate::number::{Mask, Number};
use crate::ports::{MotionState, States, Surroundings};

/// The oil springs that a stage's velocity works against; they yield as far as their chambers do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OilSpring<N> {
    /// None for a rod that sticks.
    gives: Option<Gives<N>>,
}

/// 1/(1 + γ·mobility·stiffness): the share of a driving force or velocity that remains against the oil spring; for a rod free of a stop and for
/// one that a stop holds.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gives<N> {
    free: N,
    held: N,
}

/// The equation of motion of the mass in one tick, from the rod's present state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equation<'a, N: Number, V, E> {
    mechanics: &'a Mechanics<N, E>,
    vocabulary: PhantomData<V>,
    pub(crate) row: Row<N>,
    /// Level of dry friction, where it holds rigidly.
    level: Level<N>,
    held: Option<Held<N>>,
    own: Option<Own<'a, N>>,
    /// States at the start of the tick, for the table of forces.
    states: States<N>,
    /// Force of that table at these states.
    pushed: Option<N>,
}

/// Forces on the mass at a stage, in addition to the net force and its own diagonal; at the second stage, half of their change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<N: Number> {
    sticks: N::Mask,
    /// Velocity at the start of the tick.
    velocity: N,
    /// Force of the mass's own viscous friction at this velocity.
    slowed: N,
    /// All forces except the stop's.
    beside: N,
    /// Force of the stop that the rod touches.
    stop: Option<N>,
}

/// Velocity that the first stage gains.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gained<N> {
    pub(crate) velocity: N,
    /// The force that causes it, less friction, where the gain is a single product of that force.
    effort: N,
    /// Gain of a rod free of the stop and gain of a held one, where the rod touches a stop.
    either: [N; 2],
}

/// Which of two cases is computed: a rod free of the stop, or one that the stop holds.
#[derive(Clone, Copy, Debug)]
enum Which {
    Free,
    Held,
}

impl Which {
    #[inline]
    fn of<N>(self, [free, held]: [N; 2]) -> N {
        match self {
            Which::Free => free,
            Which::Held => held,
        }
    }
}

/// The part of a signal that a spring leaves.
#[inline]
fn yields<N: Number>(give: Option<N>, signal: N) -> N {
    give.map_or(signal, |give| give.of(signal))
}

/// Sum of what acts beside the net force.
#[inline]
fn together<N: Number>(pushed: Option<N>, dry: N, own: Option<N>) -> N {
    let dry = pushed.map_or(dry, |pushed| pushed + dry);
    own.map_or(dry, |own| dry + own)
}

/// Forces that depend on the rod's own position, in one tick.
#[derive(Clone, Copy, Debug)]
struct Own<'a, N: Number> {
    from_middle: N,
    /// The bristles that dry friction acts through.
    grip: Option<Gripping<'a, N>>,
    /// Their sum at the start of the tick.
    start: N,
}

/// How the rod moved in a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved<N> {
    /// Mean velocity, as the equations were solved.
    pub(crate) solved: N,
    /// The part of it that a stop took away, where the rod met a stop.
    pub(crate) beyond: Option<N>,
    /// Whether a stage's gain was beyond the format.
    pub(crate) held: bool,
}

/// Where the rod touches a stop.
#[derive(Clone, Copy, Debug)]
struct Held<N: Number> {
    touch: Touch<N>,
    stiffness: N::Steep,
    row: Row<N>,
}

impl<N: Number> Held<N> {
    /// Force of the stop at a depth; positive extends.
    #[inline]
    fn pushes(&self, depth: N) -> N {
        self.touch.push(depth.amplified(self.stiffness))
    }

    /// A force plus the stop's, where the rod touches the stop.
    #[inline]
    fn with(&self, force: N, stop: N) -> N {
        N::pick(self.touch.any(), force + stop, force)
    }
}

impl<N: Number> Row<N> {
    /// The row with a larger diagonal; `share` is the old diagonal over the new one.
    #[inline]
    fn braked(&self, share: N, per_gamma: N::Gain) -> Self {
        let shrunk = |gain: N::Gain| N::scaled(gain, share);
        Self {
            mobility: shrunk(self.mobility),
            pull: shrunk(self.pull),
            drag: (N::of_gain(shrunk(self.drag)) + N::dot([per_gamma], [N::ONE - share])).as_gain(),
            back: shrunk(self.back),
            share: Some(share),
        }
    }
}

impl<N: Number, E: Keeps<MechanicalEffects<N>>> Mechanics<N, E> {
    /// The equation of motion of the mass from this state.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn equation<V: Knows<MechanicalEffects<N>>>(
        &self,
        state: &MotionState<N>,
        around: Surroundings<N>,
    ) -> Equation<'_, N, V, E> {
        let effects = V::of(self.effects.kept());
        let equation = |row, level, held, own| Equation {
            mechanics: self,
            vocabulary: PhantomData,
            row,
            level,
            held,
            own,
            states: around.states,
            pushed: effects
                .and_then(|effects| effects.push.as_ref())
                .map(|push| push.at(States { velocity: state.velocity, ..around.states })),
        };
        let Some(effects) = effects else { return equation(self.row, Level::NONE, None, None) };
        let from_middle = || N::of_travel(state.position) - N::ONE.halved();
        let dry = &effects.dry;
        let level = if dry.varies() { dry.level(from_middle(), around.pressed) } else { dry.level(N::ZERO, N::ZERO) };
        let Some(resistance) = &effects.resistance else {
            return equation(self.row, level, None, None);
        };
        let from_middle = from_middle();
        let viscosity = resistance.drag.map_or(around.viscosity, |drag| drag.excess(from_middle, around.viscosity));
        let spring = resistance.load.map_or(N::ZERO, |load| load.at(from_middle));
        let grip = resistance.bristles.as_ref().map(|law| law.gripping(state.bristles, state.velocity, level));
        let bristle = grip.map_or(N::ZERO, |grip| grip.first());
        let [q, fading] = grip.map_or([N::ZERO; 2], |grip| grip.yielding());
        let [stiffness_weight, damping_weight] = grip.map_or([resistance.none; 2], |grip| grip.weights());
        let braked = |touches: N, stop: N::Steep| {
            let share = N::inverse_one_plus(
                [viscosity.max(N::ZERO), N::ONE, q, fading, touches],
                [resistance.viscosity, resistance.load_weight, stiffness_weight, damping_weight, stop],
            );
            self.row.braked(share, resistance.per_gamma)
        };
        let touched = resistance.stops.as_ref().map(|stops| (stops, stops.touched(state.position)));
        let touched = touched.filter(|(_, touch)| touch.any().any());
        let held =
            touched.map(|(stops, touch)| Held { touch, stiffness: stops.stiffness, row: braked(N::ONE, stops.weight) });
        let own = Some(Own { from_middle, grip, start: spring - bristle });
        let level = if grip.is_some() { Level::NONE } else { level };
        equation(braked(N::ZERO, resistance.none), level, held, own)
    }
}

impl<'a, N: Number, V: Knows<MechanicalEffects<N>>, E: Keeps<MechanicalEffects<N>>> Equation<'a, N, V, E> {
    #[inline]
    fn effects(&self) -> Option<&'a MechanicalEffects<N>> {
        V::of(self.mechanics.effects.kept())
    }

    /// Effects on the mass's own diagonal.
    #[inline]
    fn resistance(&self) -> Option<&'a Resistance<N>> {
        self.effects()?.resistance.as_ref()
    }

    /// Forces that depend on the rod's own position.
    #[inline]
    fn own(&self) -> Option<&Own<'a, N>> {
        if V::KNOWN && self.resistance().is_none() { None } else { V::on(self.own.as_ref()) }
    }

    /// The stop that the rod touches.
    #[inline]
    fn held(&self) -> Option<&Held<N>> {
        let within_reach = || self.resistance().is_some_and(|resistance| resistance.stops.is_some());
        if V::KNOWN && !within_reach() { None } else { V::on(self.held.as_ref()) }
    }

    /// The bristles that dry friction acts through.
    #[inline]
    fn grip(&self) -> Option<&Gripping<'a, N>> {
        let bristly = || self.resistance().is_some_and(|resistance| resistance.bristles.is_some());
        if V::KNOWN && !bristly() { None } else { self.own()?.grip.as_ref() }
    }

    /// Force of the table at the states of the tick's start.
    #[inline]
    fn pushed(&self) -> Option<N> {
        let pushes = || self.effects().is_some_and(|effects| effects.push.is_some());
        if V::KNOWN && !pushes() { None } else { V::on(self.pushed.as_ref()).copied() }
    }

    /// Level of dry friction, where it holds rigidly.
    #[inline]
    fn level(&self) -> Level<N> {
        match self.effects() {
            Some(effects) if V::KNOWN && effects.dry.is_off() => Level::NONE,
            Some(effects) if V::KNOWN && effects.dry.stribeck.is_none() => self.level.without_stribeck(),
            _ => self.level,
        }
    }

    /// Whether it is known that no dry friction holds the rod.
    #[inline]
    fn glides(&self) -> bool {
        V::PLAIN || V::KNOWN && self.effects().is_none_or(|effects| effects.dry.is_off())
    }

    /// How dry friction acts on a rod with this velocity under this force at the start of the tick.
    #[inline]
    pub(crate) fn contact(&self, velocity: N, force: N) -> Contact<N::Mask> {
        if self.glides() {
            return Contact::FREE;
        }
        let force = self.own().map_or(force, |own| force + own.start);
        let force = self.pushed().map_or(force, |pushed| force + pushed);
        let force = self.held().map_or(force, |held| held.with(force, held.pushes(held.touch.depth)));
        self.level().contact(velocity, force)
    }

    /// A force with what acts beside it; in a step without effects that is nothing.
    #[inline]
    fn with(force: N, beside: N) -> N {
        if V::PLAIN { force } else { force + beside }
    }

    /// Force per velocity that brakes the rod, where this is viscous friction alone and fits a gain. An effort is then the accelerating force;
    /// a single product turns it into the velocity gained.
    #[inline]
    fn viscous(&self) -> Option<N::Gain> {
        let braked = || if V::KNOWN { self.resistance().is_some() } else { self.row.share.is_some() };
        let otherwise = !V::PLAIN && (V::HARD.unwrap_or(self.mechanics.hard) || braked());
        if otherwise { None } else { Some(self.mechanics.viscous) }
    }

    /// The oil spring of this stiffness that the rod works against.
    #[inline]
    pub(crate) fn on_spring(&self, contact: Contact<N::Mask>, stiffness: N) -> OilSpring<N> {
        let give = |row: &Row<N>| N::inverse_one_plus_product(row.pull, stiffness);
        let gives = || {
            let free = give(&self.row);
            Gives { free, held: self.held().map_or(free, |held| give(&held.row)) }
        };
        OilSpring { gives: if contact.sticks.all() { None } else { Some(gives()) } }
    }

    /// What acts at the first stage.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn first_stage(&self, contact: Contact<N::Mask>, velocity: N) -> Stage<N> {
        let (pushed, own) = (self.pushed(), self.own().map(|own| own.start));
        Stage {
            sticks: contact.sticks,
            velocity,
            slowed: self.viscous().map_or(N::ZERO, |viscous| N::dot([viscous], [velocity])),
            beside: together(pushed, self.level().force(contact, velocity), own),
            stop: self.held().map(|held| held.pushes(held.touch.depth)),
        }
    }

    /// What acts at the second stage, after the first stage gained this velocity: half of the change from the first stage.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn second_stage(&self, contact: Contact<N::Mask>, first: &Stage<N>, gained: N) -> Stage<N> {
        let plain = Stage { beside: N::ZERO, stop: None, ..*first };
        if V::PLAIN || plain.sticks.all() {
            return plain;
        }
        let (velocity, there) = (first.velocity, first.velocity + gained);
        let pushed = self
            .effects()
            .and_then(|effects| effects.push.as_ref())
            .map(|push| push.at(States { velocity: there, ..self.states }));
        let dry = self.level().force(contact, there);
        let changed = |own: Option<N>| (together(pushed, dry, own) - first.beside).halved();
        let (Some(own), Some(resistance)) = (self.own(), self.resistance()) else {
            return Stage { beside: changed(None), ..plain };
        };
        let ahead = velocity + gained.small_part(self.mechanics.gamma);
        let moved = N::dot([self.mechanics.travel], [ahead]);
        let stop = self.held().zip(first.stop).map(|(held, stop)| {
            // The share of the first stage's travel that is left in a spring's second; `push` counts it out of the stop's face.
            let left = N::dot([resistance.second], [moved]);
            (held.pushes(held.touch.depth - held.touch.push(left)) - stop).halved()
        });
        // At the velocity `there`, after a first stage of mean velocity `ahead`, which moved the rod by `moved` strokes.
        let spring = resistance.load.map_or(N::ZERO, |load| load.second(own.from_middle, moved));
        let second = spring - self.grip().map_or(N::ZERO, |grip| grip.second(ahead, there));
        Stage { beside: changed(Some(second)), stop, ..plain }
    }

    /// Net force at the first stage; `trial` is this force at the rod's present velocity, `after` is this force after a gain of velocity.
    #[inline]
    pub(crate) fn first_force(&self, stage: &Stage<N>, trial: N, spring: &OilSpring<N>, after: impl Fn(N) -> N) -> N {
        let Some(gives) = spring.gives else { return trial };
        let force = || {
            if self.viscous().is_none() {
                let gained = self.first_under(stage, trial, Some(gives)).velocity;
                return after(gained.small_part(self.mechanics.gamma));
            }
            gives.free.of(Self::with(trial - stage.slowed, stage.beside)) - stage.beside + stage.slowed
        };
        N::choose(stage.sticks, || trial, force)
    }

    /// Velocity that the first stage gains under a net force.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn first(&self, stage: &Stage<N>, force: N) -> Gained<N> {
        self.first_under(stage, force, None)
    }

    /// Net force at the second stage, likewise; `trial` is this force if no velocity is gained.
    #[inline]
    pub(crate) fn second_force(
        &self,
        stage: &Stage<N>,
        first: &Gained<N>,
        trial: N,
        spring: &OilSpring<N>,
        after: impl Fn(N) -> N,
    ) -> N {
        let Some(gives) = spring.gives else { return trial };
        let force = || {
            if self.viscous().is_none() {
                let gained = self.second_under(stage, first, trial, Some(gives));
                return after(gained.small_part(self.mechanics.gamma));
            }
            let back = N::dot([self.row.back], [first.effort]);
            gives.free.of(Self::with(trial, stage.beside) + back) - back - stage.beside
        };
        N::choose(stage.sticks, || trial, force)
    }

    /// Velocity that the second stage gains under a net force.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn second(&self, stage: &Stage<N>, first: &Gained<N>, force: N) -> N {
        if self.viscous().is_none() {
            return self.second_under(stage, first, force, None);
        }
        let effort = || Self::with(force, stage.beside) + N::dot([self.row.back], [first.effort]);
        N::dot([self.row.mobility], [N::choose(stage.sticks, || N::ZERO, effort)])
    }

    /// [`Self::first`], reduced by the oil spring.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn first_under(&self, stage: &Stage<N>, force: N, gives: Option<Gives<N>>) -> Gained<N> {
        let velocity = -stage.velocity;
        let either = self.either(stage, force, gives, |row, force, give, _| {
            N::dot([row.mobility, row.drag], [yields(give, force), yields(give, velocity)])
        });
        let effort = Self::with(force - stage.slowed, stage.beside);
        Gained { velocity: self.less_into_stop(stage, either), effort, either }
    }

    /// [`Self::second`], likewise.
    #[inline]
    fn second_under(&self, stage: &Stage<N>, first: &Gained<N>, force: N, gives: Option<Gives<N>>) -> N {
        let either = self.either(stage, force, gives, |row, force, give, which| {
            let gained = N::dot([row.mobility, row.back], [yields(give, force), yields(give, first.velocity)]);
            // The case (free or held) that did not apply in the first stage starts from the velocity that it would have had there.
            which.map_or(gained, |which| gained + yields(give, (which.of(first.either) - first.velocity).halved()))
        });
        self.less_into_stop(stage, either)
    }

    /// Gain of a rod free of the stop and gain of a held one, where it touches a stop; `solved` evaluates the stage's equation for a row.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    fn either(
        &self,
        stage: &Stage<N>,
        force: N,
        gives: Option<Gives<N>>,
        solved: impl Fn(&Row<N>, N, Option<N>, Option<Which>) -> N,
    ) -> [N; 2] {
        let (force, free) = (Self::with(force, stage.beside), gives.map(|gives| gives.free));
        let (Some(held), Some(stop)) = (self.held(), stage.stop) else {
            return [solved(&self.row, force, free, None); 2];
        };
        let by_stop = solved(&held.row, force + stop, gives.map(|gives| gives.held), Some(Which::Held));
        [solved(&self.row, force, free, Some(Which::Free)), by_stop]
    }

    /// Of the two gains of a stage, the one that moves the rod less into the stop that it touches; 0 for a rod that sticks.
    #[inline]
    fn less_into_stop(&self, stage: &Stage<N>, [free, held]: [N; 2]) -> N {
        let moves = || self.held().map_or(free, |stop| stop.touch.hold(free, held));
        N::choose(stage.sticks, || N::ZERO, moves)
    }

    /// Moves the rod by the gains of both stages, of which the share γ is `ahead`, and returns how it moved.
    ///
    /// Where a stage's gain is held at the end of the format, the step no longer follows the method and is no longer stable: two
    /// held stages can throw the rod to and fro for ever. The rod then moves on in the direction of the push, with a velocity of one half at
    /// most, where the step is linear again.
    #[cfg_attr(target_os = "none", inline)]
    #[cfg_attr(not(target_os = "none"), inline(always))]
    pub(crate) fn finish(
        &self,
        contact: Contact<N::Mask>,
        state: &mut MotionState<N>,
        [first, second]: [N; 2],
        ahead: [N; 2],
    ) -> Moved<N> {
        let mechanics = self.mechanics;
        let [first_ahead, second_ahead] = ahead;
        let slow = N::ONE.halved();
        let started = state.velocity + first_ahead;
        let (mut mean, mut moved) = (started + second_ahead, started + second);
        let held = first.is_held() || second.is_held();
        if held {
            let limit = |velocity: N| if first.is_held() { first.limited(slow) } else { velocity.limited(slow) };
            (mean, moved) = (limit(mean), limit(moved));
        }
        state.position = N::travelled(state.position, [mechanics.travel], [mean]);
        // Friction reversed with the velocity somewhere within the tick: give back what it took in excess, at most until the rod rests.
        let retracts = contact.retracts & moved.above(N::ZERO);
        let back = || N::choose(retracts, || (moved - self.turn()).max(self.turned(moved)), || moved);
        let extends = contact.extends & N::ZERO.above(moved);
        let turned = N::choose(extends, || (moved + self.turn()).min(self.turned(moved)), back);
        state.velocity = turned.within_range();
        if let Some(grip) = self.grip() {
            state.bristles = grip.after(mean);
        }
        if let Some(stops) = self.resistance().and_then(|resistance| resistance.stops.as_ref()) {
            let was_free = !self.held().map_or(N::Mask::NONE, |held| held.touch.any());
            return Moved { solved: mean, beyond: stops.set_down(&mut state.position, was_free), held };
        }
        Moved { solved: mean, beyond: None, held }
    }

    /// What remains of a velocity that has reversed within the tick, if friction holds as hard as it can.
    #[inline]
    fn turned(&self, moved: N) -> N {
        self.grip().map_or(N::ZERO, |grip| moved.times(grip.turned()))
    }

    /// Velocity that dry friction of both directions together takes in a tick.
    #[inline]
    fn turn(&self) -> N {
        let Some(effects) = self.effects() else { return N::ZERO };
        if self.own().is_none() && !effects.dry.varies() {
            return self.mechanics.turn;
        }
        N::dot([self.row.mobility], [self.grip().map_or_else(|| self.level().both(), Gripping::both)])
    }
}
