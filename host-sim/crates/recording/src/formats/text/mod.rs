//! Recordings as text: CSV in its dialects, and the export of `TwinCAT` Scope.

pub(crate) mod csv;
pub(crate) mod lines;
mod twincat;
