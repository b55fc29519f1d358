//! What the valve needs beyond the common search: both sides of a recorded spool searched by themselves, and a spool that sticks, which is judged by
//! its jumps, recorded or left in the position.

pub(crate) mod jump_spacing;
pub(crate) mod side;
mod spool_jumps;
mod stiction;
pub(crate) mod unmeasured_spool;
pub(crate) mod valve_first;
