//! What effects do: neutral is nothing, examples by hand, fixed point as f64 for every effect of the table.

mod agreement;
mod bench;
mod bristles;
mod cavitation;
mod chambers;
mod friction;
mod neutral;
mod rod;
mod sensors;
