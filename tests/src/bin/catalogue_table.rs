//! Prints how accurate and how fast each sampler of the catalogue is, as a Markdown table:
//! `cargo run --release -p tests --bin catalogue_table`.
//!
//! Errors are the worst over the reference data, for samples normwise; behind each stands the worst
//! multiple of the rounding unit times the condition number (at least one). Times are nanoseconds
//! per call of `pdf`, next to one written by hand for the same contract: zero outside the support,
//! for NaN and infinity, and off the manifold.

use std::hint::black_box;
use std::time::Instant;

use aether_core::prelude::*;
use aether_core::{Pcg32, Scalar, draw_uniforms};
use tests::catalogue::*;
use tests::errors::errors;
use tests::reference::{PointEntry, Reference};

fn main() {
    let reference = Reference::load();
    println!(
        "| row | sampler | f64 sample | f64 pdf | f32 sample | f32 pdf | pdf | by hand | ratio |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (row, (derived, by_hand)) in speeds() {
        let of_row = |p: &&PointEntry| p.inputs.row == row;
        let name = reference.points.iter().find(of_row).map_or("?", |p| p.inputs.name.as_str());
        let [sample, pdf] = accuracy::<f64>(reference.points.iter().filter(of_row));
        let [sample32, pdf32] = accuracy::<f32>(reference.points32.iter().filter(of_row));
        println!(
            "| {row} | {name} | {sample} | {pdf} | {sample32} | {pdf32} | {derived:.2} ns | \
             {by_hand:.2} ns | {:.2} |",
            derived / by_hand
        );
    }
}

/// The worst errors of samples and of densities (by either way), as text.
fn accuracy<'a, R: Scalar>(entries: impl Iterator<Item = &'a PointEntry>) -> [String; 2] {
    let mut worst = [(0.0_f64, 0.0_f64); 2];
    for entry in entries {
        let e = errors::<R>(entry);
        let values = [(e.sample, entry.condition_sample), (e.pdf.max(e.own), entry.condition_pdf)];
        for (worst, (error, condition)) in worst.iter_mut().zip(values) {
            worst.0 = worst.0.max(error);
            // An error of zero against an unbounded condition is no error.
            let multiple = error / (R::EPSILON.to_f64() * condition.max(1.0));
            worst.1 = worst.1.max(if error == 0.0 { 0.0 } else { multiple });
        }
    }
    worst.map(|(error, multiple)| format!("{error:.0e} ({multiple:.1})"))
}

/// Nanoseconds per call of two densities on samples of the first, the median of many interleaved
/// repetitions. Parameters are hidden from the optimiser on both sides, once for each batch.
fn race<S: Sampler<f64>, P: Copy>(
    sampler: S,
    parameters: P,
    by_hand: impl Fn(&S::Point, P) -> f64,
) -> (f64, f64) {
    let mut source = Pcg32::new(7, 0, 0);
    let mut draw = || sampler.sample(draw_uniforms::<f64, S::Uniforms>(&mut source)).value();
    let points: Vec<S::Point> = (0..1024).map(|_| draw()).collect();
    let time = |density: &dyn Fn(&[S::Point]) -> f64| {
        let start = Instant::now();
        for _ in 0..16 {
            black_box(density(black_box(&points)));
        }
        start.elapsed().as_nanos() as f64 / (16.0 * points.len() as f64)
    };
    let derived = |points: &[S::Point]| {
        let s = black_box(sampler);
        points.iter().map(|x| black_box(s.pdf(x).value())).sum()
    };
    let written = |points: &[S::Point]| {
        let p = black_box(parameters);
        points.iter().map(|x| black_box(by_hand(x, p))).sum()
    };
    let (mut a, mut b) = (Vec::new(), Vec::new());
    for _ in 0..201 {
        a.push(time(&derived));
        b.push(time(&written));
    }
    (median(a), median(b))
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Each row's times, derived and by hand.
fn speeds() -> Vec<(u64, (f64, f64))> {
    let centre = Vec3::new(1.0, 2.0, 3.0);
    let (a, b, c, d, t0, t1) = (1.0, 0.5, -0.3, 2.0, 0.1, -0.2);
    let logistics = affine_logistics(a, b, c, d, t0, t1);
    let line = linear(1.0, 4.0).expect("the ends are not negative");
    let part = truncated_exponential(1.7, 2.0);
    vec![
        (1, race(affine(-2.0, 3.0), (-2.0, 3.0), |x, (a, b)| by_hand::affine(*x, a, b))),
        (2, race(power(2.5), 2.5, |x, k| by_hand::power(*x, k))),
        (3, race(exponential(1.7), 1.7, |x, s| by_hand::exponential(*x, s))),
        (4, race(part, (1.7, 2.0), |x, (s, d)| by_hand::truncated_exponential(*x, s, d))),
        (5, race(line, (1.0, 4.0), |x, (a, b)| by_hand::linear(*x, a, b))),
        (18, race(weibull(2.0, 1.6), (2.0, 1.6), |x, (l, k)| by_hand::weibull(*x, l, k))),
        (19, race(gumbel(0.0, 1.0), (0.0, 1.0), |x, (m, b)| by_hand::gumbel(*x, m, b))),
        (23, race(softplus_logistic(), (), |x, ()| by_hand::exponential(*x, 1.0))),
        (42, race(polar_disk(2.0), 2.0, by_hand::disk)),
        (57, race(logistics, [a, b, c, d, t0, t1], by_hand::affine_logistics)),
        (60, race(uniform_sphere(), (), |w, ()| by_hand::sphere(w))),
        (61, race(equirectangular(), (), |w, ()| by_hand::equirectangular(w))),
        (62, race(uniform_hemisphere(), (), |w, ()| by_hand::hemisphere(w))),
        (63, race(cosine_hemisphere(), (), |w, ()| by_hand::cosine_hemisphere(w))),
        (64, race(power_cosine(20.0), 20.0, by_hand::power_cosine)),
        (93, race(sphere_surface(centre, 2.5), (centre, 2.5), by_hand::sphere_surface)),
        (107, race(height_field(0.8), 0.8, by_hand::height_field)),
    ]
}

/// The densities as an expert writes them.
mod by_hand {
    use aether_core::prelude::*;

    #[inline]
    fn inside(condition: bool, density: f64) -> f64 {
        if condition { density } else { 0.0 }
    }

    #[inline]
    pub fn affine(x: f64, a: f64, b: f64) -> f64 {
        let (lo, hi) = if a < b { (a, b) } else { (b, a) };
        inside(lo <= x && x <= hi, 1.0 / (hi - lo))
    }
    #[inline]
    pub fn power(x: f64, k: f64) -> f64 {
        inside((0.0..1.0).contains(&x), k * x.powf(k - 1.0))
    }
    #[inline]
    pub fn exponential(x: f64, s: f64) -> f64 {
        inside(x >= 0.0, s * (-s * x).exp())
    }
    #[inline]
    pub fn truncated_exponential(x: f64, s: f64, d: f64) -> f64 {
        inside((0.0..d).contains(&x), -s * (-s * x).exp() / (-s * d).exp_m1())
    }
    #[inline]
    pub fn linear(x: f64, a: f64, b: f64) -> f64 {
        inside((0.0..1.0).contains(&x), 2.0 * (a + (b - a) * x) / (a + b))
    }
    #[inline]
    pub fn weibull(x: f64, l: f64, k: f64) -> f64 {
        if x < 0.0 || !x.is_finite() {
            return 0.0;
        }
        let t = (x / l).powf(k - 1.0);
        k / l * t * (-t * (x / l)).exp()
    }
    #[inline]
    pub fn gumbel(x: f64, m: f64, b: f64) -> f64 {
        let z = (x - m) / b;
        inside(z.is_finite(), (-z - (-z).exp()).exp() / b)
    }
    #[inline]
    pub fn disk(x: &Vec2, radius: f64) -> f64 {
        let r2 = radius * radius;
        inside(x.length_squared() < r2, FRAC_1_PI / r2)
    }
    #[inline]
    fn logistic(x: f64) -> f64 {
        let e = (-x.abs()).exp();
        e / ((1.0 + e) * (1.0 + e))
    }
    #[inline]
    pub fn affine_logistics(x: &Vec2, p: [f64; 6]) -> f64 {
        let [a, b, c, d, t0, t1] = p;
        let (x, y) = (x.x - t0, x.y - t1);
        let det = a * d - b * c;
        let density = logistic((d * x - b * y) / det) * logistic((a * y - c * x) / det) / det.abs();
        inside(x.is_finite() && y.is_finite(), density)
    }
    #[inline]
    fn finite(w: &Direction) -> bool {
        (w.x + w.y + w.z).is_finite()
    }
    #[inline]
    pub fn sphere(w: &Direction) -> f64 {
        inside(finite(w), 0.25 * FRAC_1_PI)
    }
    #[inline]
    pub fn equirectangular(w: &Direction) -> f64 {
        inside(finite(w), 0.5 * FRAC_1_PI * FRAC_1_PI / (w.x * w.x + w.y * w.y).sqrt())
    }
    #[inline]
    pub fn hemisphere(w: &Direction) -> f64 {
        inside(finite(w) && w.z >= 0.0, 0.5 * FRAC_1_PI)
    }
    #[inline]
    pub fn cosine_hemisphere(w: &Direction) -> f64 {
        inside(finite(w) && w.z > 0.0, w.z * FRAC_1_PI)
    }
    #[inline]
    pub fn power_cosine(w: &Direction, n: f64) -> f64 {
        inside(finite(w) && w.z >= 0.0, (n + 1.0) * 0.5 * FRAC_1_PI * w.z.powf(n))
    }
    #[inline]
    pub fn sphere_surface(x: &Surface, (centre, radius): (Vec3, f64)) -> f64 {
        let d = x.vec() - centre;
        let size = centre.x.abs().max(centre.y.abs()).max(centre.z.abs()) + radius;
        let off = (d.length() - radius).abs();
        inside(off <= 16.0 * f64::EPSILON * size, 0.25 * FRAC_1_PI / (radius * radius))
    }
    #[inline]
    pub fn height_field(x: &Surface, h: f64) -> f64 {
        let p = x.vec();
        if !((0.0..1.0).contains(&p.x) && (0.0..1.0).contains(&p.y)) {
            return 0.0;
        }
        let ((sx, cx), (sy, cy)) = ((PI * p.x).sin_cos(), (PI * p.y).sin_cos());
        let on = (p.z - h * sx * sy).abs() <= 16.0 * f64::EPSILON * h.abs();
        let (dx, dy) = (PI * h * cx * sy, PI * h * sx * cy);
        inside(on, 1.0 / (1.0 + dx * dx + dy * dy).sqrt())
    }
}
