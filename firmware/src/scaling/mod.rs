//! Scaling: counts to the model's per unit and back, each as a straight line in whole numbers.

mod calibration;
mod line;
mod output;
mod scale;
mod travel;

pub use calibration::{Calibration, Point, Reading, Row, Sensor};
pub use output::{Actuator, Output};
pub use scale::{Band, CalibrationError};
pub use travel::{Encoder, Jump, Rising, Travel, TravelState};
