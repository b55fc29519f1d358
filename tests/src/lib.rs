//! What the system tests share: the drives, the core and the oracle on the same commands, and machines drawn at random.

pub mod drives;
pub mod simulate;
