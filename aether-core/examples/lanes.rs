//! What lanes gain: time for a sample and its density, eight at once and one at a time.
//!
//! ```sh
//! cargo run --release -p aether-core --features wide --example lanes
//! ```

use std::hint::black_box;
use std::time::Instant;

use aether_core::prelude::*;
use aether_core::{Lanes, Pcg32, draw_uniforms};

/// Directions about +z, distributed as cos(theta) / pi.
#[sampler]
fn cosine_hemisphere(u: [Uniform; 2]) -> Direction {
    let r = u[0].sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt())
}

/// Directions about +z, distributed as a power of the cosine.
#[sampler]
fn power_cosine(u: [Uniform; 2], n: f64) -> Direction {
    let z = u[0].powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    Direction::new(r * phi.cos(), r * phi.sin(), z)
}

/// The concentric map of Shirley and Chiu (1997).
#[sampler]
fn concentric_disk(u: [Uniform; 2]) -> Vec2 {
    let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    let (r, theta) = if a.abs() > b.abs() {
        (a, PI / 4.0 * (b / a))
    } else {
        (b, PI / 2.0 - PI / 4.0 * (a / b))
    };
    Vec2::new(r * theta.cos(), r * theta.sin())
}

/// A normal variable in the plane, by quantiles.
#[sampler]
fn normal_pair(u: [Uniform; 2]) -> Vec2 {
    Vec2::new(normal_quantile(u[0]), normal_quantile(u[1]))
}

const COUNT: usize = 1 << 13;

/// Nanoseconds a sample: the best of several runs.
fn time<R: Real, S: Sampler<R, Uniforms = [R; 2]>>(sampler: &S, uniforms: &[[R; 2]]) -> f64 {
    let run = || {
        let start = Instant::now();
        let mut sum = R::ZERO;
        for u in uniforms {
            let x = sampler.sample(black_box(*u)).value();
            sum += sampler.pdf(&x).value();
        }
        black_box(sum);
        start.elapsed().as_secs_f64()
    };
    let best = (0..50).map(|_| run()).fold(f64::INFINITY, f64::min);
    best * 1e9 / COUNT as f64
}

fn main() {
    let mut source = Pcg32::new(1, 0, 0);
    let single: Vec<[f32; 2]> = (0..COUNT).map(|_| draw_uniforms(&mut source)).collect();
    let eight = |u: &[[f32; 2]; 8]| core::array::from_fn(|k| Lanes::new(u.map(|u| u[k])));
    let wide: Vec<[Lanes; 2]> = single.as_chunks::<8>().0.iter().map(eight).collect();
    println!("sample and density, ns       f32   lanes   ratio");
    macro_rules! rows {
        ($($name:literal $one:expr, $eight:expr;)*) => {
            $(let (a, b) = (time(&$one, &single), time(&$eight, &wide));
            println!("{:24} {a:7.2} {b:7.2} {:7.2}", $name, a / b);)*
        };
    }
    rows! {
        "cosine_hemisphere" cosine_hemisphere(), cosine_hemisphere();
        "power_cosine" power_cosine(10.0f32), power_cosine(Lanes::splat(10.0));
        "concentric_disk" concentric_disk(), concentric_disk();
        "normal_pair" normal_pair(), normal_pair();
    }
}
