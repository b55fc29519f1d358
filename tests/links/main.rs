//! Can the chain be cut anywhere?
//!
//! Each link, stepped alone with its own simulated input, gives the chain's output bit for bit; a drive entered at a
//! downstream signal goes on as the whole chain did.

mod alone;
mod drive_inputs;
mod sensing;
