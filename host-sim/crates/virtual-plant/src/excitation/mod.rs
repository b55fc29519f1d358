//! What drives the plant: commands at the control ticks and a load force over time.

pub(crate) mod input;
