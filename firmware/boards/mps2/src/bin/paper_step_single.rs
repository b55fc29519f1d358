//! An image that only runs the step of the paper's model in single precision: what it contains is that step's flash.
//!
//! It is not to be run; the drive and its state are never created.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

mps2::image_of_a_step!(PaperDrive, Single, core::convert::identity);
