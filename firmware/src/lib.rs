//! The reference model on a controller.
#![no_std]
#![forbid(unsafe_code)]
