//! The plant held against independent solutions, and each of its effects against what it must do by head. Tests only.

#[cfg(test)]
mod behaviour;
#[cfg(test)]
mod effects;
#[cfg(test)]
pub(crate) mod validation;
