//! Powers of the cosine of half vectors: a lobe about +z about whose directions another one is reflected.

use aether_core::battery;
use aether_core::prelude::*;

/// A power of the cosine about +z, about which a direction is reflected.
#[sampler(n in 0.0..=1e4)]
fn reflected_lobe(u: [Uniform; 2], n: f64, w: Direction) -> Direction {
    let z = u[0].powf(1.0 / (n + 1.0));
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * u[1];
    let h = Vec3::new(r * phi.cos(), r * phi.sin(), z);
    Direction::from_vec(2.0 * h.dot(w) * h - w)
}

/// Blinn's lobe: the half vector's density over the 4 |w · h| of a reflection.
#[test]
fn a_power_of_the_cosine_of_half_vectors() {
    let views = [[0.48, 0.64, 0.6], [0.6, 0.0, -0.8], [0.0, 0.0, 1.0], [0.28, -0.96, 1e-3]];
    for [x, y, z] in views {
        let w = Direction::from_vec(Vec3::new(x, y, z).normalize());
        for n in [0.0, 1.0, 7.5, 300.0, 1e4] {
            let lobe = reflected_lobe(n, w).unwrap();
            for u in [[0.3, 0.6], [0.9, 0.1], [0.01, 0.95], [1.0 - 1e-9, 0.5]] {
                let v = lobe.sample(u).value();
                let h: f64 = u[0].powf(1.0 / (n + 1.0));
                let (r, phi) = ((-(2.0 * u[0].ln() / (n + 1.0)).exp_m1()).sqrt(), TAU * u[1]);
                let cosine = w.x * r * phi.cos() + w.y * r * phi.sin() + w.z * h;
                let expected = (n + 1.0) / TAU * u[0].powf(n / (n + 1.0)) / (4.0 * cosine.abs());
                for p in [lobe.pdf(&v).value(), lobe.sample(u).pdf().value()] {
                    let limit = 1e-13 / cosine.abs().powi(2);
                    assert!(
                        (p / expected - 1.0).abs() < limit,
                        "{n} {w:?} {u:?}: {p:e}, not {expected:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn narrow_and_wide_lobes_pass_the_battery() {
    for n in [1.0, 50.0, 5000.0] {
        let w = Direction::new(0.28, 0.0, 0.96);
        battery::check(&reflected_lobe(n, w).unwrap()).assert_ok();
    }
    for n in [1.0, 20.0] {
        let w = Direction::new(0.48f32, 0.64, 0.6);
        battery::check_f32(&reflected_lobe(n, w).unwrap()).assert_ok();
    }
}
