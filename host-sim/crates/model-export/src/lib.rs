//! A drive for use in other programs: its machine file as Rust constants, as a C99 header, baked for Rust and C, or as an FMU.
//!
//! The input is a [`MachineFile`](machine_file::MachineFile), the output a text or an archive. Start at [`rust`] for the constants in both languages,
//! and at [`fmu`] for the archive; the library inside an FMU is the crate `drive-fmu`, which takes its variables from here. Nothing here converts SI
//! values to fixed point: `model-core` does this in the same way on every target.
#![forbid(unsafe_code)]
// All output is returned to the caller: only the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod c99;
mod c_library;
pub mod fmu;
mod literal;
pub mod rust;
