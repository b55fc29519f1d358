use proptest::prelude::*;

use super::*;
use crate::number::PerUnit;

/// Half a step, relative.
const ROUNDED: f64 = 1.0 / (1_u64 << 24) as f64;

/// Words of any size up to that of a state, both signs.
fn word() -> impl Strategy<Value = f32> {
    prop_oneof![6 => (-8.0_f32..=8.0, 0_i32..60).prop_map(|(value, small)| value * 0.5_f32.powi(small)), 1 => Just(0.0), 1 => Just(8.0)]
}

fn steep() -> impl Strategy<Value = f32> {
    (0.0_f32..65536.0, 0_i32..60).prop_map(|(value, small)| value * 0.5_f32.powi(small))
}

#[test]
fn whatever_enters_is_finite_and_within_the_range() {
    for value in [f32::NAN, f32::INFINITY, -f32::INFINITY, 1e38, -9.0, 8.0, 1e-45] {
        let signal = Single::from(value);
        assert!(signal.value().abs() <= 8.0, "{value} becomes {signal:?}");
        assert_eq!(signal, Single::saturated(f64::from(value)));
    }
    assert_eq!([Single::new(f32::NAN), Single::new(-9.0)], [Single::ZERO, -Single::new(8.0)]);
    assert_eq!((Single::signal(8.0), Single::signal(f64::NAN), Single::gain(4.0)), (None, None, None));
    assert_eq!((Single::steep(-0.1), Single::steep(65536.0)), (None, None));
    assert_eq!((Single::counted(1 << 15), Single::counted(i32::MIN)), (Single::new(0.5), Single::new(-8.0)));
}

#[test]
fn root_of_a_quarter_is_a_half_and_of_nothing_nothing() {
    let (root, slope) = Single::new(0.25).orifice_root(Single::new(1e-6));
    assert!((root.to_f64() - 0.5).abs() < 2e-7 && (slope - 2.0).abs() < 1e-6, "{root:?} {slope}");
    let (nothing, slope) = Single::ZERO.orifice_root(Single::ZERO);
    assert!(nothing == Single::ZERO && (1e9..1e10).contains(&slope), "{slope}");
}

/// Every word from 1 to 16, which are all mantissas with all four remainders of the exponent.
#[test]
fn the_inverse_fourth_root_is_within_two_steps_everywhere() {
    let (mut worst, mut bits) = (0.0_f64, 1.0_f32.to_bits());
    while bits < 16.0_f32.to_bits() {
        let w = f32::from_bits(bits);
        let exact = 1.0 / libm::sqrt(libm::sqrt(f64::from(w)));
        worst = worst.max((f64::from(inverse_fourth_root(w)) / exact - 1.0).abs());
        bits += 5;
    }
    assert!(worst < 1.3e-7, "{worst:e}");
    for power in [-126, -56, -20, 4, 100, 126] {
        let w = 2.0_f32.powi(power);
        let found = f64::from(inverse_fourth_root(w)) * libm::exp2(0.25 * f64::from(power));
        assert!((found - 1.0).abs() < 1.3e-7, "2^{power}: {found}");
    }
}

#[test]
fn a_million_parts_that_a_pressure_would_swallow_fill_it() {
    let (mut pressure, mut rest) = (Single::new(0.5), Single::ZERO);
    for _ in 0..1_000_000 {
        (pressure, rest) = pressure.accumulated(rest, [0.5], [Single::new(2e-9)]);
    }
    assert!((pressure.to_f64() + rest.to_f64() - 0.501).abs() < 1e-9, "{pressure:?} {rest:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn root_and_slope_agree_with_the_formula(delta in word(), pt in 1e-7_f32..0.1) {
        let (root, slope) = Single::new(delta).orifice_root(Single::new(pt));
        let (d, p) = (f64::from(delta), f64::from(pt));
        let exact = (d * d + p * p).powf(-0.25);
        prop_assert!((f64::from(slope) / exact - 1.0).abs() <= 3e-7, "{slope} {exact}");
        prop_assert!((root.to_f64() - d * exact).abs() <= 3e-7 * (d * exact).abs() + 1e-38, "{root:?} {exact}");
        prop_assert_eq!(Single::new(-delta).orifice_root(Single::new(pt)).0, -root);
    }

    #[test]
    fn inverse_and_share_agree_with_their_formulas(part in word(), weight in word(), steep in steep()) {
        let (p, w, s) = (f64::from(part.abs()), f64::from(weight.abs()), f64::from(steep));
        let [part, weight] = [part, weight].map(|word| Single::new(word.abs()));
        let inverse = Single::inverse_one_plus([weight], [steep]).to_f64();
        prop_assert!((inverse * (1.0 + w * s) - 1.0).abs() <= 3e-7, "{inverse}");
        let share = Single::share(part, [weight], [steep]).to_f64();
        let exact = if p > 0.0 { p / (p + w * s) } else { 0.0 };
        prop_assert!((share - exact).abs() <= 3e-7 * exact && share <= 1.0, "{share} {exact}");
        let of_product = Single::inverse_one_plus_product(steep.min(4.0), weight).to_f64();
        prop_assert!((of_product * (1.0 + w * s.min(4.0)) - 1.0).abs() <= 3e-7, "{of_product}");
    }

    #[test]
    fn accumulating_loses_no_more_than_the_rounding_of_its_parts(
        gain in -4.0_f32..4.0, signals in prop::collection::vec((-1.0_f32..1.0, 0_i32..40), 1..200),
    ) {
        let (mut sum, mut rest, mut exact, mut size) = (Single::ZERO, Single::ZERO, 0.0_f64, 0.0_f64);
        for (signal, small) in signals {
            let signal = signal * 0.5_f32.powi(small);
            let part = f64::from(gain) * f64::from(signal);
            if (exact + part).abs() > 7.0 {
                break;
            }
            (sum, rest) = sum.accumulated(rest, [gain], [Single::new(signal)]);
            (exact, size) = (exact + part, size + part.abs() + rest.to_f64().abs());
            prop_assert!((sum.to_f64() + rest.to_f64() - exact).abs() <= 4.0 * ROUNDED * size);
            prop_assert!(rest.to_f64().abs() <= ROUNDED * 8.0);
        }
    }

    #[test]
    fn what_a_state_keeps_is_finite_and_within_the_range(value in word(), gain in -4.0_f32..4.0, by in steep()) {
        let large = Single::new(value).amplified(by).amplified(by);
        let (pressure, rest) = Single::new(value).accumulated(Single::new(value), [gain], [large]);
        for kept in [pressure, rest, large.within_range()] {
            prop_assert!(kept.value().abs() <= 8.0, "{kept:?}");
        }
        let travel = Single::travelled(large.within_range().as_travel(), [gain], [large]);
        prop_assert!(Single::of_travel(travel).value().abs() <= 128.0, "{travel:?}");
    }

    #[test]
    fn a_value_that_fits_fixed_point_fits_here_and_the_other_way_round(value in -10.0_f64..10.0, steep in -1.0_f64..7e4) {
        prop_assume!((value.abs() - 8.0).abs() > 1e-6 && (value.abs() - 4.0).abs() > 1e-6);
        prop_assert_eq!(Single::signal(value).is_some(), PerUnit::signal(value).is_some());
        prop_assert_eq!(Single::gain(value).is_some(), <PerUnit as Number>::gain(value).is_some());
        prop_assert_eq!(Single::steep(steep).is_some(), <PerUnit as Number>::steep(steep).is_some());
        prop_assert!(Single::signal(value).is_none_or(|signal| (signal.to_f64() - value).abs() <= ROUNDED * value.abs()));
    }

    #[test]
    fn a_signal_is_a_position_to_the_bit(value in word()) {
        let signal = Single::new(value);
        prop_assert_eq!(signal.as_travel(), Single::travel(f64::from(value)));
        prop_assert_eq!(Single::of_travel(signal.as_travel()), signal);
        prop_assert_eq!(Single::of_sum(Single::summed(Single::ZERO.as_travel(), signal)), signal);
    }
}
