//! The native half of the Python package `host_sim`, which nobody imports by itself: `python/host_sim` gives its results types and names.
//!
//! A recording or a machine becomes an object (`recording`, `machine`); each function of `commands`, `simulate` and `diagnose` does what the command of
//! its name does, by the same crates and in the same order, and returns the JSON that the command writes. All long work runs in a pool of its own
//! without Python's lock, and ends on Ctrl-C (`unlocked`).
#![forbid(unsafe_code)]
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]
#![expect(clippy::needless_pass_by_value, reason = "what Python passes is taken as it comes")]

mod commands;
mod diagnose;
mod error;
mod fleet;
mod in_memory;
mod machine;
mod page;
mod recording;
mod simulate;
mod table;
mod unlocked;

use pyo3::prelude::*;

/// The native half of `host_sim`.
#[pymodule]
mod _native {
    use pyo3::exceptions::PyImportError;
    use pyo3::prelude::*;
    use simulation::number::cpu;

    #[pymodule_export]
    use crate::commands::{compare, fit, inspect, plan};
    #[pymodule_export]
    use crate::diagnose::{Diagnosed, diagnose};
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::fleet::{FleetTable, fleet, judge, nights, nights_of, unusable};
    #[pymodule_export]
    use crate::in_memory::{from_arrow, from_columns};
    #[pymodule_export]
    use crate::machine::Machine;
    #[pymodule_export]
    use crate::page::Page;
    #[pymodule_export]
    use crate::recording::{Recording, listed, read};
    #[pymodule_export]
    use crate::simulate::{Simulated, simulate};
    #[pymodule_export]
    use crate::table::Table;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        cpu::check().map_err(|error| PyImportError::new_err(error.to_string()))?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
