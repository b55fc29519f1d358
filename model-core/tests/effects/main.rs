//! What the effects of chambers, mechanics and sensors do: neutral is nothing, examples by hand, fixed point as f64.

mod agreement;
mod bench;
mod bristles;
mod cavitation;
mod chambers;
mod friction;
mod neutral;
mod rod;
mod sensors;
