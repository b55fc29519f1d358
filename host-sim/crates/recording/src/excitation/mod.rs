//! Input signals to excite a drive with, and their short form as text (`step:4V`).

pub mod signals;
pub mod text;
