//! Scattering functions are reciprocal and not negative, and their lobes cover them.

use glam::{Vec2, Vec3};

use super::{Lobe, Material, Scattering};
use crate::kind::Everything;
use crate::scene::bsdf::*;
use crate::scene::texture::Colour;

fn rough(distribution: Distribution) -> Roughness {
    Roughness { distribution, alpha: [0.3; 2], sample_visible: true }
}

fn materials() -> Vec<Bsdf> {
    let metal = Some(Metal { eta: Vec3::new(0.2, 0.9, 1.1), k: Vec3::new(3.9, 2.5, 2.1) });
    let (white, grey) = (Colour::from(Vec3::ONE), Colour::from(Vec3::splat(0.5)));
    let mut all = vec![
        Bsdf::Diffuse(Diffuse { reflectance: grey }),
        Bsdf::Plastic(Plastic { eta: 1.5, diffuse: grey, reflectance: white, nonlinear: true }),
    ];
    for roughness in [Distribution::Beckmann, Distribution::Ggx].map(rough) {
        all.push(Bsdf::RoughConductor(RoughConductor { roughness, metal, reflectance: white }));
        all.push(Bsdf::RoughPlastic(RoughPlastic {
            roughness,
            eta: 1.5,
            diffuse: grey,
            reflectance: white,
            nonlinear: false,
        }));
        all.push(Bsdf::RoughDielectric(RoughDielectric {
            roughness,
            eta: 1.5,
            reflectance: white,
            transmittance: white,
        }));
    }
    let pair = [all[0].clone(), all[2].clone()];
    all.push(Bsdf::Blend { weight: 0.3, nested: Box::new(pair) });
    all
}

fn direction(k: u32) -> Vec3 {
    let z = 2.0 * ((k as f32 * 0.618_034 + 0.17) % 1.0) - 1.0;
    let phi = 2.4 * k as f32;
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Scattering at a surface without textures that faces +z.
fn scattering(material: &Material<Everything>, v: Vec3) -> Option<Scattering<'_, Everything>> {
    Scattering::new(material, &[], Vec2::ZERO, Vec3::Z, v)
}

/// The value for light from `w` to `v`, without the cosine; zero where the material is black.
fn value(material: &Material<Everything>, v: Vec3, w: Vec3) -> Vec3 {
    scattering(material, v).map_or(Vec3::ZERO, |s| s.value(w) / w.z.abs())
}

#[test]
fn scattering_is_reciprocal() {
    for bsdf in materials() {
        let eta = if let Bsdf::RoughDielectric(glass) = &bsdf { glass.eta } else { 1.0 };
        let material = Material::new(&bsdf).unwrap();
        let mut positive = 0;
        for k in 0..400 {
            let (v, w) = (direction(k), direction(7 * k + 3));
            let (there, back) = (value(&material, v, w), value(&material, w, v));
            // f(v, w) / n² is symmetric, where n is the index of refraction where the light arrives.
            let scale = |to: Vec3| if to.z < 0.0 { eta * eta } else { 1.0 };
            let (a, b) = (there / scale(v), back / scale(w));
            assert!(a.min_element() >= 0.0, "{a} at {v} {w}");
            assert!(
                (a - b).abs().max_element() <= 2e-4 * a.max_element() + 1e-7,
                "{a} {b} {v} {w} {bsdf:?}"
            );
            positive += u32::from(a.max_element() > 0.0);
        }
        assert!(positive > 60, "{positive}: {bsdf:?}");
    }
}

#[test]
fn chances_add_up_to_one() {
    let mut all = materials();
    let glass =
        Dielectric { eta: 1.5, reflectance: Vec3::ONE.into(), transmittance: Vec3::ONE.into() };
    let pane =
        ThinDielectric { eta: 1.5, reflectance: Vec3::ONE.into(), transmittance: Vec3::ONE.into() };
    all.extend([Bsdf::Dielectric(glass), Bsdf::ThinDielectric(pane)]);
    let masked =
        all.iter().cloned().map(|nested| Bsdf::Mask { opacity: 0.3, nested: nested.into() });
    for bsdf in all.clone().into_iter().chain(masked) {
        let material = Material::<Everything>::new(&bsdf).unwrap();
        for k in 0..50 {
            let Some(s) = scattering(&material, direction(k)) else { continue };
            let lobes = (0..s.count()).map(|i| s.lobe(i).expect("there are so many"));
            let sum: f32 = lobes.clone().map(|lobe| lobe.chance).sum();
            assert!((sum - 1.0).abs() < 1e-6, "{sum} {bsdf:?}");
            // Light that passes unchanged, or in one direction, is found by that direction.
            for lobe in lobes.filter(|lobe| lobe.lobe.is_atom()) {
                let w = s.direction(&lobe.lobe).expect("an atom has a direction");
                let atoms = s.atoms(s.frame.to_world(w).into());
                let expected = lobe.coefficient * s.measure(&lobe.lobe, w);
                assert!(
                    (atoms - expected).abs().max_element() < 1e-6
                        || matches!(lobe.lobe, Lobe::Passage(_))
                );
            }
        }
    }
}
