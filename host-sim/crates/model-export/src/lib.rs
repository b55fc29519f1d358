//! A drive for programs of others: its machine file as Rust constants, as a C99 header, or as an FMU.
//!
//! A [`MachineFile`](machine_file::MachineFile) goes in, text or an archive comes out. Start at [`rust`] for the constants in both languages, and at
//! [`fmu`] for the archive; the library inside an FMU is the crate `drive-fmu`, which takes its variables from here. Nothing here converts SI
//! values to fixed point: `model-core` does that, on every target alike.
#![forbid(unsafe_code)]
// What there is to say is returned: nothing but the program prints.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro))]

mod c99;
pub mod fmu;
pub mod rust;
