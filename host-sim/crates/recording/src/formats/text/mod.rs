//! Recordings as text: CSV in its dialects, and the export of `TwinCAT` Scope.

pub(crate) mod clock;
pub(crate) mod csv;
pub(crate) mod decimal_mark;
pub(crate) mod heading;
pub(crate) mod lines;
mod twincat;
