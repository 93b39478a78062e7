//! What you learn here: how to write a sampler of your own, how to look at what was derived for it,
//! and how to check it in one line.
//!
//! The sampler picks points of a lens that lets less light through towards its rim: its
//! transmission is (1 - r² / R²)^k at the distance r from the axis. The recipe: the mass within r is
//! 1 - (1 - r² / R²)^(k + 1); set it to a uniform and solve for r. Only the result is written down.

use aether_core::{Pcg32, battery, draw_uniforms, prelude::*};

/// A point of an apodised lens: density proportional to (1 - r² / radius²)^k.
//
// The attribute `#[sampler(explain)]` would print the derivation while this file compiles; it is in
// the documentation of the item as well (`cargo doc`, or hover over the name in an editor).
#[sampler(radius in 1e-6..=1e6, k in 0.0..=100.0)]
pub fn apodised_lens(u: [Uniform; 2], radius: f64, k: f64) -> Vec2 {
    let r = radius * (1.0 - (1.0 - u[0]).powf(1.0 / (k + 1.0))).sqrt();
    let phi = TAU * u[1];
    Vec2::new(r * phi.cos(), r * phi.sin())
}

fn main() {
    // Parameters have a declared domain, so the constructor checks them.
    let lens = match apodised_lens(0.5, 3.0) {
        Ok(lens) => lens,
        Err(error) => return eprintln!("{error}"),
    };

    // Draw points; each knows its density, and the density of any other point can be asked for.
    for sample in 0..3 {
        let point = lens.sample(draw_uniforms(&mut Pcg32::new(1, 0, sample)));
        println!("({:+.3}, {:+.3})  density {:.4}", point.x, point.y, point.pdf().value());
    }
    println!("on the axis        density {:.4}", lens.pdf(&Vec2::new(0.0, 0.0)).value());
    println!("outside            density {:.4}", lens.pdf(&Vec2::new(0.5, 0.1)).value());

    // What the compiler derived.
    let derived = ApodisedLens::<f64>::DERIVATION;
    println!("\nmap      {}", derived.forward);
    for line in derived.inverse.lines() {
        println!("inverse  {line}");
    }
    println!("√det JᵀJ {}", derived.jacobian);
    println!("pdf      {}  (per {})", derived.pdf, derived.measure);

    // The battery trusts nothing but the map: round trips, differences, cubature, chi-square.
    println!("\n{}", battery::check(&lens));
}

#[test]
fn the_battery_finds_nothing() {
    for (radius, k) in [(0.5, 3.0), (2.0, 0.5), (1e-3, 20.0)] {
        battery::check(&apodised_lens(radius, k).unwrap()).assert_ok();
        battery::check_f32(&apodised_lens(radius as f32, k as f32).unwrap()).assert_ok();
    }
    assert!(apodised_lens(-1.0, 3.0).is_err());
}

#[test]
fn the_density_is_the_one_in_the_textbook() {
    let (radius, k) = (0.5, 3.0);
    let lens = apodised_lens(radius, k).unwrap();
    for (x, y) in [(0.0, 0.0), (0.1, -0.2), (-0.3, 0.35), (0.4, 0.4)] {
        let inside = (1.0 - (x * x + y * y) / (radius * radius)).max(0.0_f64);
        let expected = (k + 1.0) / (PI * radius * radius) * inside.powf(k);
        let density = lens.pdf(&Vec2::new(x, y)).value();
        assert!((density - expected).abs() <= 1e-12 * expected, "{density}, not {expected}");
    }
}
