//! An image that only runs the model's step: what it contains is the step's flash, and any panic that the step could reach.
//!
//! It is not to be run; the drive and its state are never created.
#![cfg_attr(all(target_arch = "arm", target_os = "none"), no_std, no_main)]

mps2::image_of_a_step!(Drive, PerUnit, model_core::drive::DriveInput::Command);
