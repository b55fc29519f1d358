//! The plant compared with independent solutions, and each of its effects with a hand calculation. Tests only.

#[cfg(test)]
mod behaviour;
#[cfg(test)]
mod effects;
#[cfg(test)]
pub(crate) mod validation;
