//! Fresnel's equations, averaged over both polarisations.

use glam::Vec3;

/// What is reflected at a boundary of dielectrics, and the cosine under which the rest goes on: zero if
/// nothing does. `cosine` is that of the arriving light with the normal on its side, in [0, 1]; `eta`
/// the index beyond the boundary over that on this side. Pharr, Jakob and Humphreys, section 9.3.5.
pub fn dielectric(cosine: f32, eta: f32) -> (f32, f32) {
    if eta == 1.0 {
        return (0.0, cosine);
    }
    // With c and t the cosines on both sides, η² t² = η² - 1 + c². So nothing cancels in t, nor in the
    // numerators c² - η² t² and η² c² - t², for indices next to one.
    let step = (eta - 1.0) * (eta + 1.0);
    let refracted = step + cosine * cosine;
    if refracted <= 0.0 {
        return (1.0, 0.0);
    }
    let beyond = refracted.sqrt() / eta;
    let perpendicular = step / (cosine + eta * beyond).powi(2);
    let parallel = step * (cosine * cosine * (eta * eta + 1.0) - 1.0)
        / (eta * cosine + beyond).powi(2)
        / (eta * eta);
    (0.5 * (perpendicular * perpendicular + parallel * parallel), beyond)
}

/// What a metal with the index of refraction `eta + i k` reflects, in each channel (Pharr, Jakob and
/// Humphreys, section 9.3.6).
pub fn conductor(cosine: f32, eta: Vec3, k: Vec3) -> Vec3 {
    let c2 = cosine * cosine;
    let s2 = (1.0 - cosine) * (1.0 + cosine);
    let channel = |eta: f32, k: f32| {
        let d = eta * eta - k * k - s2;
        let a2b2 = (d * d + 4.0 * eta * eta * k * k).sqrt();
        let a = (0.5 * (a2b2 + d)).max(0.0).sqrt();
        // What is no metal at all reflects nothing, and rounding must not make that negative.
        let top = ((a2b2 + c2) - 2.0 * a * cosine).max(0.0);
        let s = if top > 0.0 { top / ((a2b2 + c2) + 2.0 * a * cosine) } else { 0.0 };
        let (t1, t2) = (c2 * a2b2 + s2 * s2, 2.0 * a * cosine * s2);
        0.5 * s * (1.0 + (t1 - t2) / (t1 + t2))
    };
    Vec3::new(channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z))
}

/// The average of what a dielectric boundary reflects of light from all directions of a half space
/// alike (the albedo of a diffuse field).
pub fn diffuse_average(eta: f32) -> f32 {
    const N: usize = 4096;
    // A midpoint rule in the cosine: total reflection makes a kink.
    let sum: f64 = (0..N)
        .map(|i| {
            let c = (i as f64 + 0.5) / N as f64;
            2.0 * c * f64::from(dielectric(c as f32, eta).0)
        })
        .sum();
    (sum / N as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_makes_no_metal_absorb_more_than_there_is() {
        for k in 0..=1000u16 {
            let reflected = conductor(f32::from(k) / 1000.0, Vec3::ONE, Vec3::ZERO);
            assert!(reflected.min_element() >= 0.0, "{k}: {reflected}");
        }
    }

    /// As textbooks print them, in double precision.
    fn textbook(c: f64, eta: f64) -> f64 {
        let t2 = 1.0 - (1.0 - c * c) / (eta * eta);
        if t2 <= 0.0 {
            return 1.0;
        }
        let t = t2.sqrt();
        let s = (c - eta * t) / (c + eta * t);
        let p = (eta * c - t) / (eta * c + t);
        0.5 * (s * s + p * p)
    }

    #[test]
    fn dielectrics_keep_their_digits() {
        for eta in [1.5f32, 1.0 / 1.5, 1.33, 2.4, 1.0 + 1e-3, 1.0 - 1e-3] {
            for i in 0..=1000 {
                let c = (i as f32 / 1000.0).max(1e-3);
                let (found, beyond) = dielectric(c, eta);
                let expected = textbook(f64::from(c), f64::from(eta));
                // Near total reflection the derivative is infinite.
                let slack = 3e-6 + 1e-6 / f64::from(beyond).max(1e-4);
                let off = (f64::from(found) - expected).abs();
                assert!(off <= slack * expected + 1e-12, "{found} {expected} at {c} {eta}");
            }
        }
        assert_eq!(dielectric(0.3, 1.0), (0.0, 0.3));
        assert_eq!(dielectric(0.0, 1.5).0, 1.0);
    }

    #[test]
    fn metals_without_absorption_are_dielectrics() {
        for i in 0..=100 {
            let c = i as f32 / 100.0;
            let metal = conductor(c, Vec3::splat(1.5), Vec3::ZERO).x;
            assert!((metal - dielectric(c, 1.5).0).abs() < 2e-6, "{c}");
        }
    }

    #[test]
    fn diffuse_light() {
        // Tables of the internal and external diffuse reflectance for an index of 1.5.
        assert!((diffuse_average(1.5) - 0.0918).abs() < 2e-4, "{}", diffuse_average(1.5));
        assert!(
            (diffuse_average(1.0 / 1.5) - 0.5963).abs() < 2e-4,
            "{}",
            diffuse_average(1.0 / 1.5)
        );
        // Reciprocity: η² (1 - inside) = 1 - outside.
        let balance = (1.0 - diffuse_average(1.0 / 1.5)) * 1.5 * 1.5 - (1.0 - diffuse_average(1.5));
        assert!(balance.abs() < 1e-4, "{balance}");
    }
}
