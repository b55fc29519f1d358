//! What a recording can show by how long it is and how often it was sampled: nothing else is told of it.

/// Share of a recording that a lag may have: with less than three of them it is no lag but a course.
const LONGEST_LAG: f64 = 1.0 / 3.0;
/// Share of the highest frequency that rows can hold up to which one is told: at that frequency itself a line is the rows' own.
const FASTEST: f64 = 0.9;
/// Share, below which it would be told as nothing.
const LEAST_SHARE: f64 = 0.005;

/// Whether a lag is one that a recording can show: not shorter than a row, not longer than a third of it.
#[must_use]
pub fn shows_lag(lag_s: f64, row_s: f64, duration_s: f64) -> bool {
    (0.999 * row_s..=LONGEST_LAG * duration_s).contains(&lag_s.abs())
}

/// Whether a frequency is one that a recording can show: two rows a period and more, and at least one period.
#[must_use]
pub fn shows_frequency(hz: f64, row_s: f64, duration_s: f64) -> bool {
    hz * duration_s >= 1.0 && hz <= FASTEST * 0.5 / row_s
}

/// Whether a share is more than nothing as it is told.
#[must_use]
pub fn shows_share(share: f64) -> bool {
    share >= LEAST_SHARE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_a_frequency_and_a_share_are_told_where_the_recording_can_show_them() {
        assert!(!shows_lag(398_526.0, 4.0, 236.0) && !shows_lag(80.0, 4.0, 236.0) && !shows_lag(1.0, 4.0, 236.0));
        assert!(shows_lag(4.0, 4.0, 236.0) && shows_lag(-8.0, 4.0, 236.0) && !shows_lag(f64::NAN, 4.0, 236.0));
        assert!(!shows_frequency(9.4, 0.0532, 25.0) && !shows_frequency(0.03, 0.0532, 25.0));
        assert!(shows_frequency(3.0, 0.0532, 25.0));
        assert!(!shows_share(0.0) && !shows_share(f64::NAN) && shows_share(0.01));
    }
}
