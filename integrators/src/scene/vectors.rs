//! Tests of vectors, made of few comparisons.

use glam::Vec3;

/// Whether all coordinates are numbers; zero times anything else is not zero.
#[inline(always)]
pub fn is_finite(v: Vec3) -> bool {
    v.dot(Vec3::ZERO) == 0.0
}

/// The vector of unit length, as by [`Vec3::try_normalize`]: none of one that is zero or not finite.
#[inline(always)]
pub fn try_unit(v: Vec3) -> Option<Vec3> {
    let inverse = v.length_recip();
    if inverse > 0.0 && inverse <= f32::MAX { Some(v * inverse) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_judged_as_by_others() {
        let coordinates = [0.0, -0.0, 1.0, -3e-20, 1e-30, 1e-45, 2e19, f32::MAX];
        let others = [f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        for x in coordinates.into_iter().chain(others) {
            for y in coordinates.into_iter().chain(others) {
                for v in [Vec3::new(x, y, 0.5), Vec3::new(0.0, x, y), Vec3::new(y, 0.0, x)] {
                    assert_eq!(is_finite(v), v.is_finite(), "{v}");
                    let bits = |v: Option<Vec3>| v.map(|v| v.to_array().map(f32::to_bits));
                    assert_eq!(bits(try_unit(v)), bits(v.try_normalize()), "{v}");
                }
            }
        }
    }
}
