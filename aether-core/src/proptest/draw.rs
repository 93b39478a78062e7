//! One random parameter.

use ::proptest::prelude::RngExt;
use ::proptest::test_runner::TestRng;

use crate::legal::{Domain, Parameter, ParameterKind};
use crate::real::Scalar;
use crate::vec::Vec3;

/// A domain is drawn by logarithm if it spans more than this factor.
const WIDE: f64 = 100.0;
/// Where a domain has no end, numbers are drawn up to this size, and down to its inverse.
const LARGE: f64 = 1e6;

/// The numbers of a parameter, within its domain.
pub fn parameter<R: Scalar>(p: &Parameter, rng: &mut TestRng) -> Vec<R> {
    match (p.kind, &p.domain) {
        (ParameterKind::Number, Some(domain)) => vec![within(domain, rng)],
        (ParameterKind::Whole, Some(domain)) => vec![whole(domain, rng)],
        (ParameterKind::Direction, _) => direction(rng).to_vec(),
        (ParameterKind::Frame, _) => frame(rng).concat(),
        (ParameterKind::SurfaceId, _) => vec![R::of(f64::from(rng.random_range(0..16u32)))],
        (kind, _) => (0..kind.numbers()).map(|_| moderate(rng)).collect(),
    }
}

/// A number in [0, 1).
fn uniform(rng: &mut TestRng) -> f64 {
    rng.random::<f64>()
}

/// A number of either sign between 1/8 and 8, its logarithm uniform.
fn moderate<R: Scalar>(rng: &mut TestRng) -> R {
    let size = (6.0 * uniform(rng) - 3.0).exp2();
    R::of(if rng.random::<bool>() { size } else { -size })
}

/// A number of a domain, now and then an extreme one.
fn within<R: Scalar>(domain: &Domain, rng: &mut TestRng) -> R {
    let extremes = extremes::<R>(domain);
    if !extremes.is_empty() && rng.random_range(0..4) == 0 {
        return extremes[rng.random_range(0..extremes.len())];
    }
    inside(domain, R::of(ordinary(domain, rng)))
}

/// A whole number of a domain.
fn whole<R: Scalar>(domain: &Domain, rng: &mut TestRng) -> R {
    R::of(ordinary(domain, rng).round())
}

/// A number between the ends, on the scale that suits them.
fn ordinary(domain: &Domain, rng: &mut TestRng) -> f64 {
    // A domain that begins beyond what is large is drawn from there on.
    let (low, high) = (domain.low.max(-LARGE), domain.high.min(LARGE));
    let (low, high) = if low < high {
        (low, high)
    } else if domain.low > 0.0 {
        (domain.low, domain.low * LARGE)
    } else {
        (domain.high * LARGE, domain.high)
    };
    let (u, v) = (uniform(rng), uniform(rng));
    let by_logarithm = |from: f64, to: f64| from * (to / from).powf(u);
    if low >= 0.0 {
        let from = low.max(high / (LARGE * LARGE));
        let wide = if low > 0.0 { high / low > WIDE } else { high > WIDE || v < 0.25 };
        if wide { by_logarithm(from, high) } else { low + (high - low) * u }
    } else if high <= 0.0 {
        let mirrored = Domain { low: -high, high: -low, closed: true };
        -ordinary(&mirrored, rng)
    } else if high - low > WIDE {
        let end = if v * (high - low) < high { high } else { low };
        by_logarithm(end / (LARGE * LARGE), end)
    } else {
        low + (high - low) * u
    }
}

/// The number above.
fn next_above<R: Scalar>(x: R) -> R {
    -(-x).next_below()
}

/// The ends of a domain, the numbers next to them, and zero and one if they lie inside.
pub fn extremes<R: Scalar>(domain: &Domain) -> Vec<R> {
    let finite = |x: f64| R::of(if x.is_finite() { x } else { 0.0 });
    let (low, high) = (finite(domain.low), finite(domain.high));
    let ends = [low, next_above(low), next_above(next_above(low))].into_iter().chain([
        high,
        high.next_below(),
        high.next_below().next_below(),
    ]);
    let all: Vec<R> = ends.chain([R::ZERO, R::ONE]).collect();
    let legal = all.into_iter().filter(|x| domain.contains(x.to_f64()));
    legal.collect()
}

/// `x`, rounded to the other side if rounding has taken it out of the domain.
pub fn inside<R: Scalar>(domain: &Domain, x: R) -> R {
    let mut x = x;
    for _ in 0..2 {
        if x.to_f64() < domain.low {
            x = next_above(x);
        } else if !domain.contains(x.to_f64()) {
            x = x.next_below();
        }
    }
    x
}

/// An axis or a uniform unit vector.
fn direction<R: Scalar>(rng: &mut TestRng) -> [R; 3] {
    if rng.random_range(0..4) == 0 {
        let mut axis = [R::ZERO; 3];
        axis[rng.random_range(0..3)] = if rng.random::<bool>() { R::ONE } else { -R::ONE };
        return axis;
    }
    let z = 2.0 * uniform(rng) - 1.0;
    let (r, phi) = ((1.0 - z * z).sqrt(), core::f64::consts::TAU * uniform(rng));
    Vec3::new(R::of(r * phi.cos()), R::of(r * phi.sin()), R::of(z)).normalize().to_array()
}

/// The axes of a frame around a direction, turned about it by a multiple of a quarter or by any angle.
fn frame<R: Scalar>(rng: &mut TestRng) -> [[R; 3]; 3] {
    let axis = direction::<f64>(rng);
    let frame = crate::vec::Frame::around(crate::point::Direction::new(axis[0], axis[1], axis[2]));
    let turn =
        if rng.random::<bool>() { f64::from(rng.random_range(0..4)) / 4.0 } else { uniform(rng) };
    let (s, c) = (core::f64::consts::TAU * turn).sin_cos();
    let columns = [frame.x * c + frame.y * s, frame.y * c - frame.x * s, frame.z];
    columns.map(|v| v.to_array().map(R::of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_and_their_neighbours_are_extremes() {
        let closed = Domain { low: 1e-4, high: 2.0, closed: true };
        let found = extremes::<f64>(&closed);
        for x in [1e-4, 1e-4f64.next_up(), 2.0, 2.0f64.next_down(), 1.0] {
            assert!(found.contains(&x), "{x:e}");
        }
        assert!(!found.contains(&0.0));
        let open = Domain { low: 0.0, high: 1.0, closed: false };
        let found = extremes::<f64>(&open);
        assert!(
            found.contains(&0.0) && found.contains(&1.0f64.next_down()) && !found.contains(&1.0)
        );
        // In single precision 1e-4 is rounded down, out of the domain.
        let found = extremes::<f32>(&closed);
        assert!(found.iter().all(|x| closed.contains(f64::from(*x))) && found.contains(&2.0));
        assert!(!found.is_empty());
        // An end that does not exist is no extreme.
        let half = Domain { low: 3.0, high: f64::INFINITY, closed: false };
        assert!(extremes::<f64>(&half).iter().all(|x| *x >= 3.0 && *x < 3.1));
    }
}
