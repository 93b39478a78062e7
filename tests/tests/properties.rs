//! Densities for random parameters, against differences of the forward map.
//!
//! The seed is fixed, so that a right build passes always; tolerances leave a factor of a hundred
//! to the errors that the difference quotients have.

use aether_core::battery::Space;
use aether_core::prelude::*;
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use tests::catalogue::*;
use tests::mutation::OnePercentOff;
use tests::points::uniforms;

fn settings() -> ProptestConfig {
    ProptestConfig {
        cases: 200,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(20_170_730),
        ..ProptestConfig::default()
    }
}

fn coordinates<S: Sampler<f64>>(sampler: &S, u: &[f64]) -> Vec<f64> {
    let x = sampler.sample(uniforms(u)).value();
    x.coordinates().as_ref().to_vec()
}

/// The derivative along one uniform, by central differences with Richardson's extrapolation.
fn derivative<S: Sampler<f64>>(sampler: &S, u: &[f64], axis: usize) -> Vec<f64> {
    let difference = |h: f64| -> Vec<f64> {
        let moved = |by: f64| {
            let mut v = u.to_vec();
            v[axis] += by;
            coordinates(sampler, &v)
        };
        moved(h).iter().zip(moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
    };
    let first = 0.125 * u[axis].min(1.0 - u[axis]);
    let mut table: Vec<Vec<f64>> = (0..5).map(|k| difference(first / f64::from(1 << k))).collect();
    for order in 1..5 {
        let weight = 4.0_f64.powi(order);
        let better = |pair: &[Vec<f64>]| -> Vec<f64> {
            pair[1].iter().zip(&pair[0]).map(|(f, c)| (weight * f - c) / (weight - 1.0)).collect()
        };
        table = table.windows(2).map(better).collect();
    }
    table.swap_remove(0)
}

/// √det(JᵀJ) by orthogonalising the columns.
fn stretch<S: Sampler<f64>>(sampler: &S, u: &[f64]) -> f64 {
    let mut product = 1.0;
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for axis in 0..u.len() {
        let mut column = derivative(sampler, u, axis);
        for q in &basis {
            let along: f64 = q.iter().zip(&column).map(|(q, c)| q * c).sum();
            column.iter_mut().zip(q).for_each(|(c, q)| *c -= along * q);
        }
        let length = column.iter().map(|c| c * c).sum::<f64>().sqrt();
        product *= length;
        basis.push(column.iter().map(|c| c / length).collect());
    }
    product
}

/// What is wrong with an injective sampler at `u`, if anything.
fn flaw<S: Sampler<f64>>(sampler: &S, u: &[f64]) -> Result<(), TestCaseError> {
    let sample = sampler.sample(uniforms(u));
    let (own, found) = (sample.pdf().value(), sampler.pdf(&sample).value());
    let expected = 1.0 / stretch(sampler, u);
    let near = |p: f64, tolerance: f64| (p - expected).abs() <= tolerance * expected;
    prop_assert!(near(own, 1e-6), "sample.pdf() {own:e}, by differences {expected:e} at {u:?}");
    prop_assert!(near(found, 1e-6), "pdf(x) {found:e}, by differences {expected:e} at {u:?}");
    let back = sampler.invert(&sample);
    let same = |v: &S::Uniforms| v.as_ref().iter().zip(u).all(|(v, u)| (v - u).abs() <= 1e-7);
    prop_assert_eq!(back.iter().filter(same).count(), 1, "preimages {:?} of {:?}", back, u);
    Ok(())
}

/// The mass between two quantiles is the difference of their uniforms.
fn mass_is_right<S: Sampler<f64, Uniforms = [f64; 1], Point = f64>>(
    sampler: &S,
) -> Result<(), TestCaseError> {
    let (a, b) = (*sampler.sample([0.05]), *sampler.sample([0.95]));
    let panels = 2000;
    let h = (b - a) / f64::from(panels);
    let p = |x: f64| sampler.pdf(&x).value();
    let mass: f64 = (0..panels)
        .map(|k| a + f64::from(k) * h)
        .map(|x| (p(x) + 4.0 * p(x + 0.5 * h) + p(x + h)) / 6.0 * h.abs())
        .sum();
    prop_assert!((mass - 0.9).abs() < 1e-6, "mass {mass} between the quantiles 0.05 and 0.95");
    Ok(())
}

fn uniform() -> impl Strategy<Value = f64> {
    0.01..0.99
}
fn size() -> impl Strategy<Value = f64> {
    (-3.0..3.0_f64).prop_map(f64::exp)
}
fn number() -> impl Strategy<Value = f64> {
    -5.0..5.0
}
fn vector() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from_array)
}
/// A matrix far from singular: the identity and a perturbation, scaled.
fn matrix() -> impl Strategy<Value = Mat3> {
    let e = || -0.3..0.3;
    ([e(), e(), e(), e(), e(), e(), e(), e(), e()], size(), any::<bool>()).prop_map(
        |(e, k, flip)| {
            let k = if flip { -k } else { k };
            Mat3::from_cols(
                k * Vec3::new(1.0 + e[0], e[1], e[2]),
                k * Vec3::new(e[3], 1.0 + e[4], e[5]),
                k * Vec3::new(e[6], e[7], 1.0 + e[8]),
            )
        },
    )
}
fn frame() -> impl Strategy<Value = Frame> {
    [uniform(), uniform()].prop_map(|u| Frame::around(uniform_sphere().sample(u).value()))
}

proptest! {
    #![proptest_config(settings())]

    #[test]
    fn line_samplers_have_the_density_of_their_map(u in uniform(), a in number(), w in size(), k in size(), s in size()) {
        flaw(&affine(a, a + w), &[u])?;
        flaw(&affine(a + w, a), &[u])?;
        flaw(&power(k), &[u])?;
        flaw(&exponential(s), &[u])?;
        flaw(&truncated_exponential(s, w.min(10.0 / s)), &[u])?;
        flaw(&linear(k, s).expect("positive"), &[u])?;
        flaw(&weibull(w, k), &[u])?;
        flaw(&gumbel(a, w), &[u])?;
        flaw(&softplus_logistic(), &[u])?;
    }

    #[test]
    fn line_samplers_have_the_mass_between_their_quantiles(a in number(), w in size(), k in 1.0..8.0, s in size()) {
        mass_is_right(&affine(a, a + w))?;
        mass_is_right(&power(k))?;
        mass_is_right(&exponential(s))?;
        mass_is_right(&truncated_exponential(s, w.min(10.0 / s)))?;
        mass_is_right(&linear(k, s).expect("positive"))?;
        mass_is_right(&weibull(w, k))?;
        mass_is_right(&gumbel(a, w))?;
    }

    #[test]
    fn samplers_of_the_plane_have_the_density_of_their_map(u in uniform(), v in uniform(), r in size(), m in matrix(), t in vector()) {
        flaw(&polar_disk(r), &[u, v])?;
        flaw(&affine_logistics(m.x.x, m.y.x, m.x.y, m.y.y, t.x, t.y), &[u, v])?;
    }

    #[test]
    fn directions_have_the_density_of_their_map(u in uniform(), v in uniform(), n in size()) {
        flaw(&uniform_sphere(), &[u, v])?;
        flaw(&equirectangular(), &[u, v])?;
        flaw(&uniform_hemisphere(), &[u, v])?;
        flaw(&cosine_hemisphere(), &[u, v])?;
        flaw(&power_cosine(n), &[u, v])?;
    }

    #[test]
    fn surfaces_have_the_density_of_their_map(u in uniform(), v in uniform(), c in vector(), r in size(), h in number()) {
        flaw(&sphere_surface(c, r), &[u, v])?;
        flaw(&height_field(h), &[u, v])?;
    }
}

// Random affine and polar compositions, written as one sampler.

#[sampler]
fn placed_disk(u: [Uniform; 2], m: Mat3, t: Vec3) -> Surface {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Surface::from_vec(t + m * Vec3::new(r * phi.cos(), r * phi.sin(), 0.0))
}

#[sampler]
fn placed_sphere(u: [Uniform; 2], m: Mat3, t: Vec3) -> Surface {
    let z = 1.0 - 2.0 * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Surface::from_vec(t + m * Vec3::new(r * phi.cos(), r * phi.sin(), z))
}

#[sampler]
fn placed_square(u: [Uniform; 2], m: Mat3, t: Vec3) -> Surface {
    Surface::from_vec(t + m * Vec3::new(u[0], u[1], 0.5))
}

#[sampler]
fn placed_cube(u: [Uniform; 3], m: Mat3, t: Vec3) -> Vec3 {
    t + m * Vec3::new(u[0], u[1], u[2])
}

// The same by composition.

#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w.vec()))
}

#[map]
fn transform_direction(w: Direction, m: Mat3) -> Direction {
    Direction::from_vec((m * w.vec()).normalize())
}

#[map]
fn place_direction(w: Direction, m: Mat3, t: Vec3) -> Surface {
    Surface::from_vec(t + m * w.vec())
}

#[map]
fn transform_plane(x: Vec2, a: f64, b: f64, c: f64, d: f64) -> Vec2 {
    Vec2::new(a * x.x + b * x.y, c * x.x + d * x.y)
}

#[map]
fn transform_space(x: Vec3, m: Mat3, t: Vec3) -> Vec3 {
    t + m * x
}

#[map]
fn lift(x: Vec2, m: Mat3, t: Vec3) -> Surface {
    Surface::from_vec(t + m * Vec3::new(x.x, x.y, 0.0))
}

proptest! {
    #![proptest_config(settings())]

    #[test]
    fn affine_images_of_polar_maps_have_the_density_of_their_map(u in uniform(), v in uniform(), w in uniform(), m in matrix(), t in vector()) {
        flaw(&placed_disk(m, t), &[u, v])?;
        flaw(&placed_sphere(m, t), &[u, v])?;
        flaw(&placed_square(m, t), &[u, v])?;
        flaw(&placed_cube(m, t), &[u, v, w])?;
    }

    #[test]
    fn chains_of_maps_have_the_density_of_their_map(u in uniform(), v in uniform(), w in uniform(), m in matrix(), k in matrix(), t in vector(), f in frame()) {
        let lobe = cosine_hemisphere().then(rotate(f));
        flaw(&lobe, &[u, v])?;
        flaw(&lobe.then(transform_direction(m)), &[u, v])?;
        flaw(&lobe.then(transform_direction(m).then(transform_direction(k))), &[u, v])?;
        flaw(&uniform_sphere().then(place_direction(m, t)), &[u, v])?;
        flaw(&power_cosine(3.0).then(rotate(f)).then(place_direction(m, t)), &[u, v])?;
        let plane = transform_plane(m.x.x, m.y.x, m.x.y, m.y.y);
        flaw(&polar_disk(2.0).then(plane), &[u, v])?;
        flaw(&polar_disk(2.0).then(plane).then(lift(k, t)), &[u, v])?;
        flaw(&placed_cube(m, t).then(transform_space(k, t)), &[u, v, w])?;
    }

    #[test]
    fn points_beside_a_placed_manifold_have_no_density(u in uniform(), v in uniform(), m in matrix(), t in vector(), off in 1e-6..0.5) {
        let leaves = |n: Vec3, x: Surface| x.moved_to(&(x.vec() + n * off).to_array());
        let disk = placed_disk(m, t);
        let x = disk.sample([u, v]).value();
        let normal = m.x.cross(m.y).normalize() * m.z.length();
        prop_assert!(disk.pdf(&x).value() > 0.0);
        prop_assert_eq!(disk.pdf(&leaves(normal, x)).value(), 0.0);
        let sphere = placed_sphere(m, t);
        let x = sphere.sample([u, v]).value();
        prop_assert!(sphere.pdf(&x).value() > 0.0);
        prop_assert_eq!(sphere.pdf(&leaves(x.vec() - t, x)).value(), 0.0);
    }
}

#[test]
fn one_percent_is_noticed() {
    assert!(flaw(&cosine_hemisphere(), &[0.3, 0.6]).is_ok());
    assert!(flaw(&OnePercentOff(cosine_hemisphere()), &[0.3, 0.6]).is_err());
    assert!(
        flaw(
            &OnePercentOff(placed_disk(Mat3::diagonal(Vec3::new(2.0, 3.0, 1.0)), Vec3::ZERO)),
            &[0.3, 0.6]
        )
        .is_err()
    );
    assert!(mass_is_right(&weibull(2.0, 1.6)).is_ok());
    assert!(mass_is_right(&OnePercentOff(weibull(2.0, 1.6))).is_err());
}
