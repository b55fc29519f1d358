//! A machine file from the values of a data sheet and a drawing: each value is given, derived by a formula, or assumed with a reason.
//!
//! ```text
//! A = π/4·bore²,  aA = A − π/4·rod²                              areas
//! x_N = reading of the spool at the rated signal U_N,  gain = x_N/U_N
//! dead zone = overlap·x_N
//! K_Q = Q_N/(√Δp_N·(x_N − dead zone)),  Δp_N over one edge        flow coefficient
//! T1 = (t_90 − T_t)/5.939,  T2 = 2·T1,  T_t = t_90/20              lags and dead time of the spool
//! V = A·stroke/2 + π/4·d²·l + dead volume                         each chamber, at mid-stroke
//! v = K_Q·(x_N − dead zone)·√(p0·A/(A³ + aA³)), at most Q_max/A   speed without load, extending
//! D = F_friction/v                                                viscous friction
//! ```
//!
//! 5.939 = −2·ln(1 − √0.9): two lags, one twice the other, reach 90 % of a step after 5.939·T1. The lags are not taken
//! as equal, because then no recording shows in which direction they differ: the response is stationary there.
//!
//! `[fit.sigma]` is narrow for given values and wide for assumed ones, so that a fit moves the values that were unknown. Areas, stroke
//! and supply pressure are taken as exact.

mod derive;
mod item;
mod quantity;
mod text;

pub use derive::{Derived, Edges, Entry, Origin, SheetError, Sigma, derived};
pub use item::{Answers, Item, Need, Question};
pub use quantity::{Quantity, QuantityError};
pub use text::toml;
