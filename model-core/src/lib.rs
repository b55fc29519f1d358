//! Reference model of a valve-controlled hydraulic drive.
#![no_std]
#![forbid(unsafe_code)]

pub mod machine;
pub mod parameter;
