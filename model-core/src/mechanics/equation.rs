//! The equation of the mass in one tick, from where the rod stands: its diagonal, what acts at the two stages, and the step.
//!
//! Effects that add to the mass's own diagonal 1 + γ·h·D/m (viscosity, a spring, bristles, a stop) do so as dampers s that act on the
//! velocity at the stage, v + γ·k: a spring of stiffness k is one of s = γ·h·k, with its force at the tick's start beside it. With
//! r the old diagonal over the new, mobility and `back` shrink by r and the drag becomes drag·r + (1 − r)/γ.

use core::marker::PhantomData;

use super::{Contact, MechanicalEffects, Mechanics, MotionState, Resistance, Row, Surroundings};
use crate::bristles::Gripping;
use crate::end_stop::Touch;
use crate::friction::Level;
use crate::number::{Mask, Number};
use crate::unnamed::States;
use crate::vocabulary::{Keeps, Vocabulary};

/// A factor on a stage's velocity, by which a drive's oil springs hold it; for a rod that is free of a stop and one that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gives<N> {
    pub(crate) free: N,
    pub(crate) held: N,
}

/// The equation of the mass in one tick, from where the rod stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Equation<'a, N: Number, V, E> {
    mechanics: &'a Mechanics<N, E>,
    vocabulary: PhantomData<V>,
    pub(crate) row: Row<N>,
    /// Of friction that holds rigidly.
    level: Level<N>,
    held: Option<Held<N>>,
    own: Option<Own<'a, N>>,
    /// States at the start of the tick, for the table of forces.
    states: States<N>,
    /// Force of the table there.
    pushed: Option<N>,
}

/// What acts on the mass at a stage beside the net force and its own diagonal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage<N: Number> {
    sticks: N::Mask,
    /// Velocity at the stage, and what the first stage gained of it.
    velocity: N,
    gained: N,
    /// Force of the table.
    pushed: Option<N>,
    dry: N,
    /// Force of the rod's own position.
    own: Option<N>,
    /// Force of the stop that the rod touches.
    stop: Option<N>,
}

impl<N: Number> Stage<N> {
    /// A net force with all that acts beside it but a stop.
    #[inline]
    fn with(&self, force: N) -> N {
        let force = self.pushed.map_or(force, |pushed| force + pushed) + self.dry;
        self.own.map_or(force, |own| force + own)
    }
}

/// Forces of the rod's own position in one tick.
#[derive(Clone, Copy, Debug)]
struct Own<'a, N: Number> {
    resistance: &'a Resistance<N>,
    from_middle: N,
    /// The bristles that dry friction acts through.
    grip: Option<Gripping<'a, N>>,
    /// At the start of the tick.
    start: N,
}

/// How the rod moved in a tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved<N> {
    /// Mean velocity, as the equations were solved.
    pub(crate) solved: N,
    /// What of it a stop took that the rod met.
    pub(crate) beyond: Option<N>,
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

    /// A force with that of the stop, where it is touched.
    #[inline]
    fn with(&self, force: N, stop: N) -> N {
        N::pick(self.touch.any(), force + stop, force)
    }
}

impl<N: Number> Row<N> {
    /// With more on the diagonal; `share` is the old one over the new.
    #[inline]
    fn braked(&self, share: N, per_gamma: N::Gain) -> Self {
        let shrunk = |gain: N::Gain| N::dot([gain], [share]);
        Self {
            mobility: shrunk(self.mobility).as_gain(),
            drag: (shrunk(self.drag) + N::dot([per_gamma], [N::ONE - share])).as_gain(),
            back: shrunk(self.back).as_gain(),
            share: Some(share),
        }
    }
}

impl<N: Number> Own<'_, N> {
    /// Of the second stage, at the velocity `there`, after `ahead` of mean velocity in the first, which moved the rod by `moved`
    /// strokes.
    #[inline]
    fn second(&self, there: N, ahead: N, moved: N) -> N {
        let spring = self.resistance.load.map_or(N::ZERO, |load| load.second(self.from_middle, moved));
        spring - self.grip.map_or(N::ZERO, |grip| grip.second(ahead, there))
    }
}

impl<N: Number, E: Keeps<MechanicalEffects<N>>> Mechanics<N, E> {
    /// The equation of the mass from where it stands.
    #[inline]
    pub(crate) fn equation<V: Vocabulary>(
        &self,
        state: &MotionState<N>,
        around: Surroundings<N>,
    ) -> Equation<'_, N, V, E> {
        let effects = V::on(self.effects.kept());
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
        let own = Some(Own { resistance, from_middle, grip, start: spring - bristle });
        let level = if grip.is_some() { Level::NONE } else { level };
        equation(braked(N::ZERO, resistance.none), level, held, own)
    }
}

impl<'a, N: Number, V: Vocabulary, E: Keeps<MechanicalEffects<N>>> Equation<'a, N, V, E> {
    #[inline]
    fn effects(&self) -> Option<&'a MechanicalEffects<N>> {
        V::on(self.mechanics.effects.kept())
    }

    /// Forces of the rod's own position.
    #[inline]
    fn own(&self) -> Option<&Own<'a, N>> {
        V::on(self.own.as_ref())
    }

    /// The stop that the rod touches.
    #[inline]
    fn held(&self) -> Option<&Held<N>> {
        V::on(self.held.as_ref())
    }

    /// How dry friction acts on a rod with this velocity under this force at the start.
    #[inline]
    pub(crate) fn contact(&self, velocity: N, force: N) -> Contact<N::Mask> {
        if V::PLAIN {
            return Contact::FREE;
        }
        let force = self.own().map_or(force, |own| force + own.start);
        let force = V::on(self.pushed.as_ref()).map_or(force, |&pushed| force + pushed);
        let force = self.held().map_or(force, |held| held.with(force, held.pushes(held.touch.depth)));
        self.level.contact(velocity, force)
    }

    /// What `give` yields for the mass's own diagonal of a rod that is free of a stop, and one that is held.
    #[inline]
    pub(crate) fn gives(&self, give: impl Fn(Option<N>) -> N) -> Gives<N> {
        let free = give(V::on(self.row.share.as_ref()).copied());
        Gives { free, held: self.held().map_or(free, |held| give(held.row.share)) }
    }

    /// What acts at the first stage.
    #[inline]
    pub(crate) fn first_stage(&self, contact: Contact<N::Mask>, velocity: N) -> Stage<N> {
        Stage {
            sticks: contact.sticks,
            velocity,
            gained: N::ZERO,
            pushed: V::on(self.pushed.as_ref()).copied(),
            dry: self.level.force(contact, velocity),
            own: self.own().map(|own| own.start),
            stop: self.held().map(|held| held.pushes(held.touch.depth)),
        }
    }

    /// What acts at the second stage, after the velocity that the first has gained.
    #[inline]
    pub(crate) fn second_stage(&self, contact: Contact<N::Mask>, velocity: N, gained: N) -> Stage<N> {
        let there = velocity + gained;
        let plain = Stage {
            sticks: contact.sticks,
            velocity: there,
            gained,
            pushed: None,
            dry: N::ZERO,
            own: None,
            stop: None,
        };
        if V::PLAIN || plain.sticks.all() {
            return plain;
        }
        let pushed = self
            .effects()
            .and_then(|effects| effects.push.as_ref())
            .map(|push| push.at(States { velocity: there, ..self.states }));
        let dry = self.level.force(contact, there);
        let Some(own) = self.own() else { return Stage { pushed, dry, ..plain } };
        let ahead = velocity + N::dot([own.resistance.gamma], [gained]);
        let moved = N::dot([self.mechanics.travel], [ahead]);
        let stop = self.held().map(|held| {
            // How much deeper a spring's second stage starts, in the direction out of the face.
            let left = N::dot([own.resistance.second], [moved]);
            held.pushes(held.touch.depth - held.touch.push(left))
        });
        Stage { pushed, dry, own: Some(own.second(there, ahead, moved)), stop, ..plain }
    }

    /// Velocity increment of the first stage.
    #[inline]
    pub(crate) fn first_increment(&self, stage: &Stage<N>, force: N, gives: Option<Gives<N>>) -> N {
        self.increment(stage, force, gives, |row, force, give| {
            let yields = |signal: N| give.map_or(signal, |give| give.of(signal));
            N::dot([row.mobility, row.drag], [yields(force), yields(-stage.velocity)])
        })
    }

    /// Velocity increment of the second stage.
    #[inline]
    pub(crate) fn second_increment(&self, stage: &Stage<N>, force: N, gives: Option<Gives<N>>) -> N {
        self.increment(stage, force, gives, |row, force, give| {
            let yields = |signal: N| give.map_or(signal, |give| give.of(signal));
            let signals = [yields(force), yields(-stage.velocity), yields(stage.gained)];
            N::dot([row.mobility, row.drag, row.back], signals)
        })
    }

    /// What a stage's equation, `solved` for a row, yields: none of a rod that sticks, and of a rod on a stop what moves it less into it.
    #[inline]
    fn increment(
        &self,
        stage: &Stage<N>,
        force: N,
        gives: Option<Gives<N>>,
        solved: impl Fn(&Row<N>, N, Option<N>) -> N,
    ) -> N {
        let moves = || {
            let force = stage.with(force);
            let free = solved(&self.row, force, gives.map(|gives| gives.free));
            match (self.held(), stage.stop) {
                (Some(held), Some(stop)) => {
                    held.touch.hold(free, solved(&held.row, force + stop, gives.map(|gives| gives.held)))
                }
                _ => free,
            }
        };
        N::choose(stage.sticks, || N::ZERO, moves)
    }

    /// Moves the rod by the two increments and returns how fast.
    ///
    /// Where an increment is held at the end of the format the step is no longer the method's, and no longer stable: two
    /// held stages can throw the rod to and fro for ever. It then goes on where it is pushed to, with a velocity of one half at
    /// most, from where the step is linear.
    #[inline]
    pub(crate) fn finish(
        &self,
        contact: Contact<N::Mask>,
        state: &mut MotionState<N>,
        first: N,
        second: N,
    ) -> Moved<N> {
        let mechanics = self.mechanics;
        let [weigh_first, weigh_second] = mechanics.mean;
        let mean = N::dot([mechanics.unity, weigh_first, weigh_second], [state.velocity, first, second]);
        let slow = N::ONE.halved();
        let limit = |velocity: N| {
            if first.is_held() {
                first.limited(slow)
            } else if second.is_held() {
                velocity.limited(slow)
            } else {
                velocity
            }
        };
        let mean = limit(mean);
        state.position = N::travelled(state.position, [mechanics.travel], [mean]);
        let moved = limit(state.velocity + first.weighed(second));
        // Friction turned with the velocity somewhere within the tick: give back what it took too much, at most to rest.
        let retracts = contact.retracts & moved.above(N::ZERO);
        let back = || N::choose(retracts, || (moved - self.turn()).max(self.turned(moved)), || moved);
        let extends = contact.extends & N::ZERO.above(moved);
        state.velocity = N::choose(extends, || (moved + self.turn()).min(self.turned(moved)), back);
        if let Some(Own { resistance: Resistance { stops, .. }, grip, .. }) = self.own() {
            if let Some(grip) = grip {
                state.bristles = grip.after(mean);
            }
            if let Some(stops) = stops {
                let was_free = !self.held().map_or(N::Mask::NONE, |held| held.touch.any());
                return Moved { solved: mean, beyond: stops.set_down(&mut state.position, was_free) };
            }
        }
        Moved { solved: mean, beyond: None }
    }

    /// What is left of a velocity that has turned within the tick, if friction holds as hard as it can.
    #[inline]
    fn turned(&self, moved: N) -> N {
        self.own().and_then(|own| own.grip).map_or(N::ZERO, |grip| moved.times(grip.turned()))
    }

    /// What all dry friction takes of the velocity in a tick, to both sides.
    #[inline]
    fn turn(&self) -> N {
        let Some(effects) = self.effects() else { return N::ZERO };
        if self.own().is_none() && !effects.dry.varies() {
            return effects.dry.turn;
        }
        let grip = self.own().and_then(|own| own.grip);
        N::dot([self.row.mobility], [grip.map_or_else(|| self.level.both(), |grip| grip.both())])
    }
}
