//! One number and eight go through the same kernels: their bits are the same.

use super::Lanes;
use crate::kernels::{self, SinglePrecision};
use crate::real::Real;

/// One number in this many is tried.
const STRIDE: usize = 10_007;

fn assert_same(name: &str, wide: fn(Lanes) -> Lanes, single: fn(f64) -> f64) {
    let numbers: Vec<f32> = (0..=u32::MAX).step_by(STRIDE).map(f32::from_bits).collect();
    for x in numbers.as_chunks::<8>().0 {
        for (x, found) in x.iter().zip(wide(Lanes::new(*x)).to_array()) {
            let expected = f32::narrow(single(x.widen()));
            let same = found.to_bits() == expected.to_bits() || found.is_nan() && expected.is_nan();
            assert!(same, "{name}({x:e}): {found:e}, {expected:e}");
        }
    }
}

#[test]
fn lanes_have_the_bits_of_one_number() {
    macro_rules! each {
        ($($name:ident)*) => {
            $(assert_same(stringify!($name), <Lanes as Real>::$name, kernels::$name);)*
        };
    }
    each! {
        cbrt exp exp_m1 ln ln_1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh
    }
    assert_same(
        "atan2",
        |y| y.atan2(Lanes::splat(-0.3)),
        |y| kernels::atan2(y, f64::from(-0.3f32)),
    );
    assert_same(
        "hypot",
        |y| y.hypot(Lanes::splat(-0.3)),
        |y| kernels::hypot(y, f64::from(-0.3f32)),
    );
    assert_same("powf", |x| x.powf(Lanes::splat(-0.3)), |x| kernels::powf(x, f64::from(-0.3f32)));
    assert_same("powf", |y| Lanes::splat(1.7).powf(y), |y| kernels::powf(f64::from(1.7f32), y));
}
