//! Can the model be driven at any link?
//!
//! Each link, stepped alone with its own simulated input, gives the whole model's output bit for bit; a drive that is driven by a
//! downstream signal continues as the whole model did.

mod alone;
mod drive_inputs;
mod sensing;
