//! The number types that trials run in.

use core::hash::Hash;

use model_core::number::{Number, PerUnit, Scalar, Single};

use super::input::Moment;

/// A number type whose words are compared between host and target.
pub trait Traced: Scalar<Real = f64, Travel: Hash> + Hash {
    /// What stands before the name of a trial.
    const PREFIX: &'static str;

    /// The raw word of a signal.
    fn word(self) -> i32;

    /// The raw words of a position.
    fn place(position: Self::Travel) -> i64;

    /// The inputs of a tick in this type.
    fn moment(moment: Moment) -> Moment<Self>;
}

impl Traced for PerUnit {
    const PREFIX: &'static str = "";

    fn word(self) -> i32 {
        self.to_bits()
    }
    fn place(position: Self::Travel) -> i64 {
        position.to_bits()
    }
    fn moment(moment: Moment) -> Moment {
        moment
    }
}

impl Traced for Single {
    const PREFIX: &'static str = "f32, ";

    fn word(self) -> i32 {
        self.to_bits().cast_signed()
    }
    fn place(position: <Self as Number>::Travel) -> i64 {
        let [high, low] = position.words().map(f32::to_bits);
        i64::from(high.cast_signed()) << 32 | i64::from(low)
    }
    fn moment(moment: Moment) -> Moment<Self> {
        moment.rounded_to()
    }
}
