//! TODO.

pub mod discriminate;
pub mod inspect;
pub mod plan;
pub mod sensor;
pub mod standard_tests;
