//! Which effects a step is compiled for: the equations stand once, and a drive without effects does not pay for asking after each.

/// A set of effects that a drive may have.
pub(crate) trait Vocabulary: Copy + core::fmt::Debug {
    /// Whether there is none.
    const PLAIN: bool;

    /// The coefficients of an effect, where it is on.
    fn on<T>(effect: Option<&T>) -> Option<&T>;
}

/// No effect: every one is known to be off.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain;

/// Any effect may be on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effects;

impl Vocabulary for Plain {
    const PLAIN: bool = true;

    #[inline]
    fn on<T>(_: Option<&T>) -> Option<&T> {
        None
    }
}

impl Vocabulary for Effects {
    const PLAIN: bool = false;

    #[inline]
    fn on<T>(effect: Option<&T>) -> Option<&T> {
        effect
    }
}
