//! Where the rod is wanted.

use model_core::fixed_point::PerUnit;

/// Where the rod is wanted, and how fast it is wanted to go there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetPoint {
    /// Of the stroke.
    pub position: PerUnit,
    /// Of the velocity base; positive extends.
    pub velocity: PerUnit,
}
