//! What the valve needs beyond the common search: both sides of a recorded spool searched by themselves, and a sticking spool, judged by its jumps,
//! which are seen in the recorded spool or in the position's residual.

pub(crate) mod jump_spacing;
pub(crate) mod side;
mod sliding;
mod spool_jumps;
mod stiction;
pub(crate) mod unmeasured_spool;
pub(crate) mod valve_first;
