//! TODO.

mod jump_spacing;
mod spool_jumps;
mod stiction;
pub(crate) mod unmeasured_spool;
pub(crate) mod valve_first;
