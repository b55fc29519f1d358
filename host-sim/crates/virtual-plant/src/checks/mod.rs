//! TODO.

#[cfg(test)]
mod behaviour;
#[cfg(test)]
mod effects;
#[cfg(test)]
pub(crate) mod validation;
