//! A machine file from the values of a data sheet and a drawing: each value is given, derived by a formula, or assumed with a reason.
//!
//! ```text
//! A = π/4·bore²,  aA = A − π/4·rod²                              areas
//! x_N = reading of the spool at the rated signal U_N,  gain = x_N/U_N
//! dead zone = overlap·x_N
//! K_Q = Q_N/(√Δp_N·(x_N − dead zone)),  Δp_N over one edge        flow coefficient
//! f0 = 0.467/(t_90 − T_t), or where it is 90° late, T_t = t_90/20  spool as a second-order system, and its dead time
//! V = A·stroke/2 + π/4·d²·l + dead volume                         each chamber, at mid-stroke
//! v = K_Q·(x_N − dead zone)·√(p0·A/(A³ + aA³)), at most Q_max/A   speed without load, extending
//! D = F_friction/v                                                viscous friction
//! ```
//!
//! 0.467 is 1/2π of the angle ω·t at which a second-order system of damping 0.8 reaches 90 % of a step. The volumes follow the piston.
//!
//! `[fit.sigma]` is narrow for given values and wide for assumed ones, so that a fit moves the values that were unknown. Areas and stroke are
//! taken as exact. `[fit.tolerance]` lists what every drive has within its drawing.

mod derive;
mod item;
mod quantity;
mod spool;
mod text;
mod tolerances;

pub use derive::{Derived, Edges, Entry, Origin, SheetError, Sigma, derived};
pub use item::{Answers, Item, Need, Question};
pub use quantity::{Quantity, QuantityError};
pub use text::{checked_toml, toml};
