//! Several points from one sampler, with shared uniforms and frames made of samples.

use aether_core::battery;
use aether_core::prelude::*;
use aether_core::{Pcg32, UniformSource};
use tests::catalogue::thin_lens;
use tests::checks::{covered, right};

/// Two points of two parallelograms.
#[sampler]
pub fn two_panels(
    u: [Uniform; 4],
    corner: Vec3,
    right: Vec3,
    up: Vec3,
    first: SurfaceId,
    second: SurfaceId,
) -> (SurfacePoint, SurfacePoint) {
    let here = corner + u[0] * right + u[1] * up;
    let there = 2.0 * corner + u[2] * up + 3.0 * u[3] * right;
    (SurfacePoint::new(here, first), SurfacePoint::new(there, second))
}

/// A distance and a direction that is the narrower the farther away.
#[sampler]
pub fn narrowing(u: [Uniform; 3], s: f64) -> (f64, Direction) {
    let t = -(-u[0]).ln_1p() / s;
    let z = u[1].powf(1.0 / (2.0 + t));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[2];
    (t, Direction::new(r * phi.cos(), r * phi.sin(), z))
}

/// Three numbers, each the next one's beginning.
#[sampler]
pub fn ordered(u: [Uniform; 3]) -> (f64, f64, f64) {
    let a = u[0] * u[0];
    let b = a - (-u[1]).ln_1p();
    let c = b - 2.0 * (-u[2]).ln_1p();
    (a, b, c)
}

/// Points of a walk of five steps of any direction, each of a length that is exponentially distributed.
#[sampler]
pub fn five_steps(u: [Uniform; 15], s: f64) -> (Vec3, Vec3, Vec3, Vec3, Vec3) {
    let (z0, phi0) = (1.0 - 2.0 * u[0], TAU * u[1]);
    let r0 = (1.0 - z0 * z0).sqrt();
    let step0 = -s * (1.0 - u[2]).ln() * Vec3::new(r0 * phi0.cos(), r0 * phi0.sin(), z0);
    let x0 = step0;
    let (z1, phi1) = (1.0 - 2.0 * u[3], TAU * u[4]);
    let r1 = (1.0 - z1 * z1).sqrt();
    let step1 = -s * (1.0 - u[5]).ln() * Vec3::new(r1 * phi1.cos(), r1 * phi1.sin(), z1);
    let x1 = x0 + step1;
    let (z2, phi2) = (1.0 - 2.0 * u[6], TAU * u[7]);
    let r2 = (1.0 - z2 * z2).sqrt();
    let step2 = -s * (1.0 - u[8]).ln() * Vec3::new(r2 * phi2.cos(), r2 * phi2.sin(), z2);
    let x2 = x1 + step2;
    let (z3, phi3) = (1.0 - 2.0 * u[9], TAU * u[10]);
    let r3 = (1.0 - z3 * z3).sqrt();
    let step3 = -s * (1.0 - u[11]).ln() * Vec3::new(r3 * phi3.cos(), r3 * phi3.sin(), z3);
    let x3 = x2 + step3;
    let (z4, phi4) = (1.0 - 2.0 * u[12], TAU * u[13]);
    let r4 = (1.0 - z4 * z4).sqrt();
    let step4 = -s * (1.0 - u[14]).ln() * Vec3::new(r4 * phi4.cos(), r4 * phi4.sin(), z4);
    let x4 = x3 + step4;
    (x0, x1, x2, x3, x4)
}

#[test]
fn five_points_of_a_walk_have_the_product_of_the_densities_of_its_steps() {
    let s = 0.7;
    let mut pcg = Pcg32::new(5, 1, 0);
    for _ in 0..100 {
        let u: [f64; 15] = core::array::from_fn(|_| pcg.next());
        let sample = five_steps(s).sample(u);
        let (a, b, c, d, e) = sample.value();
        let step = |x: Vec3, y: Vec3| {
            let l = (y - x).length();
            (-l / s).exp() / (s * 4.0 * PI * l * l)
        };
        let origin = Vec3::new(0.0, 0.0, 0.0);
        let expected = step(origin, a) * step(a, b) * step(b, c) * step(c, d) * step(d, e);
        for found in [sample.pdf(), five_steps(s).pdf(&sample)] {
            let off = found.value() / expected - 1.0;
            // A short step is the difference of two points: an error of some 1e-16 over its length, and over 1 - |z|.
            assert!(off.abs() < 1e-10, "{u:?}: {found:?}, expected {expected:e}");
        }
    }
}

fn panels<R: Scalar>() -> TwoPanels<R> {
    let v = |x: f64, y: f64, z: f64| Vec3::new(R::of(x), R::of(y), R::of(z));
    let (corner, along, up) = (v(1.0, 2.0, -0.5), v(2.0, 0.5, 0.0), v(0.0, 1.0, 1.5));
    two_panels(corner, along, up, SurfaceId(3), SurfaceId(4))
}

#[test]
fn the_battery_passes_in_single_precision() {
    battery::check_f32(&right(thin_lens(0.5, 2.0, 0.8, 0.6))).assert_ok();
    battery::check_f32(&panels()).assert_ok();
    battery::check_f32(&narrowing(0.7)).assert_ok();
    battery::check_f32(&ordered()).assert_ok();
}

// In double precision with mass and samples; the lens is with the rows of the catalogue.

#[test]
fn two_panels_are_covered() {
    let v = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    let (corner, along, up) = (v(1.0, 2.0, -0.5), v(2.0, 0.5, 0.0), v(0.0, 1.0, 1.5));
    let coordinates = |x: Vec3| [x.x / 2.0, x.z / 1.5];
    covered(
        panels(),
        |t| {
            let here = corner + t[0] * along + t[1] * up;
            let there = 2.0 * corner + 3.0 * t[2] * along + t[3] * up;
            (SurfacePoint::new(here, SurfaceId(3)), SurfacePoint::new(there, SurfaceId(4)))
        },
        |x| {
            let here = coordinates(v(x[0], x[1], x[2]) - corner);
            let there = coordinates(v(x[3], x[4], x[5]) - 2.0 * corner);
            vec![here[0], here[1], there[0] / 3.0, there[1]]
        },
    );
}

#[test]
fn distances_and_directions_are_covered() {
    covered(
        narrowing(0.7),
        |t| {
            let (theta, phi) = (PI * t[1], TAU * t[2]);
            let w = Direction::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            (t[0] / (1.0 - t[0]), w)
        },
        |x| {
            let azimuth = x[2].atan2(x[1]).rem_euclid(TAU) / TAU;
            vec![x[0] / (1.0 + x[0]), x[1].hypot(x[2]).atan2(x[3]) / PI, azimuth]
        },
    );
}

#[test]
fn numbers_in_order_are_covered() {
    let far = |t: f64| t / (1.0 - t);
    let near = |x: f64| x / (1.0 + x);
    covered(
        ordered(),
        |t| {
            let (a, b) = (t[0] * t[0], far(t[1]));
            (a, a + b, a + b + far(t[2]))
        },
        |x| vec![x[0].sqrt(), near(x[1] - x[0]), near(x[2] - x[1])],
    );
}

#[test]
fn the_thin_lens_has_the_density_of_the_textbook() {
    // One over the area of the lens, and over the focal rectangle's solid angle element.
    let (r, f, a, b) = (0.5, 2.0, 0.8, 0.6);
    let lens = right(thin_lens(r, f, a, b));
    for u in [[0.2, 0.7, 0.1, 0.9], [0.0, 0.0, 0.5, 0.5], [0.9, 0.3, 0.01, 0.6]] {
        let x = lens.sample(u);
        let z = x.1.z;
        let expected = f * f / (PI * r * r * 4.0 * a * b * z * z * z);
        let found = lens.pdf(&x).value();
        assert!((found / expected - 1.0).abs() < 1e-13, "{found:e}, not {expected:e}");
    }
    let x = lens.sample([0.2, 0.7, 0.1, 0.9]);
    let off_lens = (Vec2::new(0.6, 0.0), x.1);
    let away = (x.0, Direction::new(-x.1.x, -x.1.y, -x.1.z));
    assert_eq!(lens.pdf(&off_lens).value(), 0.0);
    assert_eq!(lens.pdf(&away).value(), 0.0);
}

#[test]
fn points_of_other_surfaces_have_no_density() {
    let both = panels::<f64>();
    let x = both.sample([0.1, 0.2, 0.3, 0.4]);
    assert!(both.pdf(&x).value() > 0.0);
    let swapped = (x.0, SurfacePoint::new(x.1.position, SurfaceId(3)));
    assert_eq!(both.pdf(&swapped).value(), 0.0);
}
