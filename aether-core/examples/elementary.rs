//! What the elementary functions of `f64` cost that are this crate's, beside those of the host's library.
//!
//! ```sh
//! cargo run --release -p aether-core --example elementary
//! ```

use std::hint::black_box;
use std::time::Instant;

use aether_core::Real;

const COUNT: i32 = 1000;
const RUNS: usize = 400;

/// Nanoseconds a call over arguments up to `most` in magnitude: the least of several runs.
fn time(most: f64, function: impl Fn(f64) -> f64) -> f64 {
    let at = |i: i32| (f64::from(i * 7919 % COUNT) / f64::from(COUNT) - 0.4995) * 2.0 * most;
    let arguments: Vec<f64> = (0..COUNT).map(at).collect();
    let run = || {
        let start = Instant::now();
        for x in &arguments {
            black_box(function(black_box(*x)));
        }
        start.elapsed().as_secs_f64() * 1e9 / f64::from(COUNT)
    };
    (0..RUNS).map(|_| run()).fold(f64::INFINITY, f64::min)
}

fn show(name: &str, ours: f64, host: f64) {
    println!("{name:20} {ours:5.1} ns, host {host:5.1} ns, ratio {:.2}", ours / host);
}

fn main() {
    let both = |(sin, cos): (f64, f64)| sin + cos;
    show(
        "sine with cosine",
        time(7.0, |x| both((Real::sin(x), Real::cos(x)))),
        time(7.0, |x| both(x.sin_cos())),
    );
    show("sine", time(7.0, Real::sin), time(7.0, f64::sin));
    show("cosine", time(7.0, Real::cos), time(7.0, f64::cos));
    show("atan2", time(2.0, |y| Real::atan2(y, 0.7)), time(2.0, |y| y.atan2(0.7)));
    show(
        "of fractions of π",
        time(2.0, |x| both(x.sin_cos_pi())),
        time(2.0, |x| both((core::f64::consts::PI * x).sin_cos())),
    );
}
