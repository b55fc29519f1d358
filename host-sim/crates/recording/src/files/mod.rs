//! Files as such: written whole or not at all, and errors in a text with the place and carets.

pub mod atomic;
pub mod folder;
pub mod source_error;
