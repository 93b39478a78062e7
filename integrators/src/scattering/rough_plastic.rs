//! What the coat of rough plastic reflects, in a table.

use aether_core::prelude::*;

use super::facets::HalfVectors;
use super::fresnel;
use crate::scene::bsdf::{RoughPlastic, Roughness};

/// Entries of the table.
const ENTRIES: usize = 64;
/// Points of the quadrature along each uniform.
const POINTS: usize = 24;

/// The albedo of a coat of microfacets, at equidistant cosines, and what it reflects of diffuse light
/// inside.
///
/// What the facets do not reflect is let through, so that a white base under the coat reflects all light:
/// the light that facets block from each other is not lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    reflected: [f32; ENTRIES],
    /// What is reflected of a diffuse field inside.
    pub inside: f32,
}

impl Coat {
    /// The table of a material.
    pub fn new(plastic: &RoughPlastic) -> Self {
        if !plastic.conserving {
            return Coat::lossy(plastic);
        }
        // The albedo at cosine zero is that of a direction just above the surface.
        let cosine = |i: usize| (i as f32 / (ENTRIES - 1) as f32).max(1e-3);
        let mut reflected = [0.0; ENTRIES];
        for (i, entry) in reflected.iter_mut().enumerate() {
            *entry = albedo(&plastic.roughness, plastic.eta, cosine(i)).clamp(0.0, 1.0);
        }
        let mut coat = Coat { reflected, inside: 0.0 };
        let n = 8 * ENTRIES;
        let average: f32 = (0..n)
            .map(|i| {
                let c = (i as f32 + 0.5) / n as f32;
                2.0 * c * coat.transmitted(c) / n as f32
            })
            .sum();
        coat.inside = 1.0 - average / (plastic.eta * plastic.eta);
        coat
    }

    /// The table as Mitsuba 3 has it: what gets through is only what facets refract, less what other facets
    /// block of it.
    fn lossy(plastic: &RoughPlastic) -> Self {
        let eta = plastic.eta;
        let rough = Roughness { sample_visible: true, ..plastic.roughness };
        let cosine = |i: usize| (i as f32 / (ENTRIES - 1) as f32).max(1e-6);
        let mut coat = Coat { reflected: [0.0; ENTRIES], inside: 0.0 };
        for i in 0..ENTRIES {
            let lost = visible_average(&rough, cosine(i), |v, m| {
                let (reflected, beyond) = fresnel::dielectric(m.dot(v), eta);
                let w = (m.dot(v) / eta - beyond) * m.vec() - v.vec() * (1.0 / eta);
                let w = Direction::from_vec(w);
                if w.z < 0.0 { (1.0 - reflected) * rough.visible(w, m) } else { 0.0 }
            });
            coat.reflected[i] = 1.0 - lost;
            let back = visible_average(&rough, cosine(i), |v, m| {
                let w = Direction::from_vec(2.0 * m.dot(v) * m.vec() - v.vec());
                let (reflected, _) = fresnel::dielectric(m.dot(v), 1.0 / eta);
                if w.z > 0.0 { reflected * rough.visible(w, m) } else { 0.0 }
            });
            coat.inside += 2.0 * cosine(i) * back / ENTRIES as f32;
        }
        coat
    }

    /// What gets through the coat from a direction with this cosine.
    pub fn transmitted(&self, cosine: f32) -> f32 {
        let x = cosine.clamp(0.0, 1.0) * (ENTRIES - 1) as f32;
        let i = (x as usize).min(ENTRIES - 2);
        let t = x - i as f32;
        1.0 - ((1.0 - t) * self.reflected[i] + t * self.reflected[i + 1])
    }
}

/// The average over the facets that are visible from a direction.
fn visible_average(
    roughness: &Roughness,
    cosine: f32,
    of: impl Fn(Direction<f32>, Direction<f32>) -> f32,
) -> f32 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    let v = Direction::new(sine, 0.0, cosine);
    let Some(normals) = HalfVectors::new(roughness, v) else { return 0.0 };
    let mut sum = 0.0;
    for i in 0..POINTS * POINTS {
        let at = |k: usize| (k as f32 + 0.5) / POINTS as f32;
        let (m, _) = normals.forward([at(i % POINTS), at(i / POINTS)]);
        if m.dot(v) > 0.0 {
            sum += of(v, m);
        }
    }
    sum / (POINTS * POINTS) as f32
}

/// The light that facets reflect from one direction, into all directions together.
fn albedo(roughness: &Roughness, eta: f32, cosine: f32) -> f32 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).max(0.0).sqrt();
    let v = Direction::new(sine, 0.0, cosine);
    let Some(normals) = HalfVectors::new(roughness, v) else { return 1.0 };
    let mut sum = 0.0;
    for i in 0..POINTS * POINTS {
        let at = |k: usize| (k as f32 + 0.5) / POINTS as f32;
        let u = [at(i % POINTS), at(i / POINTS)];
        let (m, _) = normals.forward(u);
        let c = m.dot(v);
        if c <= 0.0 {
            continue;
        }
        let w = Direction::from_vec(2.0 * c * m.vec() - v.vec());
        if w.z <= 0.0 {
            continue;
        }
        // The density of w is that of m over 4 c.
        let p = normals.pdf_of_uniforms(u).value();
        let value = fresnel::dielectric(c, eta).0
            * roughness.distribution(m)
            * roughness.unshadowed(v, w, m)
            * c
            / (v.z * p);
        if value.is_finite() {
            sum += value;
        }
    }
    sum / (POINTS * POINTS) as f32
}
