//! What you learn here: how to estimate an integral with a sampler, and with two samplers combined
//! by multiple importance sampling, without writing a density (Aether 2017, sections 5.1 and 5.4).
//!
//! The integral is the irradiance on level ground under a blue sky with a sun in it,
//! E = ∫ L(ω) cos θ dω over the hemisphere.

use aether_core::prelude::*;
use aether_core::{BalanceHeuristic, Estimator, Pcg32, combine, draw_uniforms};

// Two samplers and a map. Inverses, Jacobians and densities are derived from these lines.

/// Directions about +z, distributed as cos(theta) / pi.
#[sampler]
fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

/// Uniform on the spherical cap about +z whose height is `height`.
#[sampler]
fn uniform_cap(u: [Uniform; 2], height: f64) -> Direction {
    let z = 1.0 - height * u[0];
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// A direction given in a frame, in world coordinates.
#[map]
fn rotate(w: Direction, frame: Frame) -> Direction {
    Direction::from_vec(frame.to_world(w))
}

/// A uniform sky with a uniform disk, the sun, on it.
struct Sky {
    radiance: f64,
    sun: Direction<f64>,
    sun_radiance: f64,
    /// One minus the cosine of the angle between the sun's centre and its rim.
    sun_height: f64,
}

impl Sky {
    /// The radiance from direction `w`.
    fn radiance(&self, w: &Direction<f64>) -> f64 {
        let in_sun = w.vec().dot(self.sun) > 1.0 - self.sun_height;
        self.radiance + if in_sun { self.sun_radiance } else { 0.0 }
    }

    /// The irradiance on level ground: π for the sky, and the projected solid angle of the sun,
    /// π sin² α cos θ, which holds as long as all of it is above the horizon.
    fn exact_irradiance(&self) -> f64 {
        let sin_squared = self.sun_height * (2.0 - self.sun_height);
        PI * (self.radiance + self.sun_radiance * sin_squared * self.sun.z)
    }
}

fn afternoon() -> Sky {
    let (sine, cosine) = 0.9_f64.sin_cos();
    let sun = Direction::new(0.6 * sine, 0.8 * sine, cosine);
    // About 2.5 degrees from centre to rim: a large, hazy sun.
    Sky { radiance: 1.0, sun, sun_radiance: 700.0, sun_height: 0.001 }
}

/// The mean of an estimate over `n` samples, and its standard error.
fn mean_and_error(n: u64, mut estimate: impl FnMut(&mut Pcg32) -> f64) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for sample in 0..n {
        let value = estimate(&mut Pcg32::new(1, 0, sample));
        sum += value;
        squares += value * value;
    }
    let mean = sum / n as f64;
    let variance = squares / n as f64 - mean * mean;
    (mean, (variance / (n - 1) as f64).sqrt())
}

/// The irradiance with cosine-distributed directions alone.
fn by_cosine(sky: &Sky, n: u64) -> (f64, f64) {
    let cosine = cosine_hemisphere();
    let estimator = Estimator::new(|w: &Direction<f64>| sky.radiance(w) * w.z.max(0.0));
    mean_and_error(n, |random| estimator.of(&cosine.sample(draw_uniforms(random))))
}

/// The irradiance with one direction of each kind, combined.
fn combined(sky: &Sky, n: u64) -> (f64, f64) {
    let cosine = cosine_hemisphere();
    // Composition: the density of this sampler follows from those of its parts.
    let towards_sun = uniform_cap(sky.sun_height).then(rotate(Frame::around(sky.sun)));
    let estimator = Estimator::new(|w: &Direction<f64>| sky.radiance(w) * w.z.max(0.0));
    mean_and_error(n, |random| {
        let a = cosine.sample(draw_uniforms(random));
        let b = towards_sun.sample(draw_uniforms(random));
        // Either sampler can tell how likely it would have made the other's direction.
        estimator.sum(combine::<BalanceHeuristic, _>((&a, &b)))
    })
}

fn main() {
    let sky = afternoon();
    println!("exact            {:.4}", sky.exact_irradiance());
    let (mean, error) = by_cosine(&sky, 10_000);
    println!("cosine alone     {mean:.4} ± {error:.4}");
    let (mean, error) = combined(&sky, 10_000);
    println!("with the sun     {mean:.4} ± {error:.4}");
}

#[test]
fn both_estimates_are_right_and_the_combined_one_is_better() {
    let sky = afternoon();
    let exact = sky.exact_irradiance();
    let (cosine, cosine_error) = by_cosine(&sky, 100_000);
    let (combined, combined_error) = combined(&sky, 100_000);
    assert!((cosine - exact).abs() < 5.0 * cosine_error, "{cosine} ± {cosine_error}, not {exact}");
    assert!((combined - exact).abs() < 5.0 * combined_error, "{combined} ± {combined_error}");
    assert!(combined_error < 0.1 * cosine_error);
}
