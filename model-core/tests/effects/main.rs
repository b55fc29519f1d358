//! What effects do: an amount of 0 changes nothing, examples by hand, fixed point agrees with f64 for every effect of the table.

mod agreement;
mod bench;
mod bristles;
mod cavitation;
mod chambers;
mod friction;
mod load_holding;
mod neutral;
mod rod;
mod sensors;
