//! The values of the scattering functions.

use std::f32::consts::FRAC_1_PI;

use aether_core::prelude::Direction;
use glam::Vec3;

use super::material::base_albedo;
use super::{Model, Scattering, facets, fresnel, metal};
use crate::kind::{Part, PlasticOf, Presence, RoughPlasticOf, SceneKind};
use crate::scene::bsdf::Roughness;

impl<K: SceneKind> Scattering<'_, K> {
    /// The value of the lobes that scatter into many directions, for light from `w` (in world
    /// coordinates, of unit length), times its cosine with the shading normal.
    pub fn value(&self, w: Vec3) -> Vec3 {
        self.mixed(|model, pose| {
            let value = match model {
                // Needs no frame.
                Model::Diffuse(matte) if pose.cosine(w) > 0.0 => {
                    self.colour(&matte.get().reflectance) * (FRAC_1_PI * pose.cosine(w))
                }
                Model::Diffuse(_) => Vec3::ZERO,
                _ => {
                    let local = Direction::from_unit(pose.frame().to_local(w));
                    self.model_value(model, pose.view(), local)
                }
            };
            value * pose.unhidden(w)
        })
    }

    #[inline]
    fn model_value(&self, model: &Model<K>, view: Direction<f32>, w: Direction<f32>) -> Vec3 {
        match model {
            Model::Plastic(plastic) if w.z > 0.0 => {
                let (plastic, inside) = PlasticOf::<K>::get_ref(plastic);
                let passes = |c: f32| 1.0 - fresnel::dielectric(c, plastic.eta).0;
                let albedo = base_albedo(self.colour(&plastic.diffuse), *inside, plastic.nonlinear);
                let through = passes(w.z) * passes(view.z) / (plastic.eta * plastic.eta);
                albedo * (FRAC_1_PI * w.z * through)
            }
            Model::RoughConductor(m) if w.z > 0.0 => {
                let m = m.get();
                let roughness = self.roughness(&m.facets);
                let Some((value, h)) = roughness.mirrored(view, w) else {
                    return Vec3::ZERO;
                };
                self.colour(&m.reflectance) * metal(m.metal, h.dot(view)) * value
            }
            Model::RoughPlastic(plastic) if w.z > 0.0 => {
                let (plastic, coat) = RoughPlasticOf::<K>::get_ref(plastic);
                let specular = plastic.roughness.mirrored(view, w).map_or(0.0, |(value, h)| {
                    value * fresnel::dielectric(h.dot(view), plastic.eta).0
                });
                let albedo =
                    base_albedo(self.colour(&plastic.diffuse), coat.inside, plastic.nonlinear);
                let through =
                    coat.transmitted(w.z) * coat.transmitted(view.z) / (plastic.eta * plastic.eta);
                self.colour(&plastic.reflectance) * specular + albedo * (FRAC_1_PI * w.z * through)
            }
            Model::RoughDielectric(glass) => {
                let glass = glass.get();
                let eta = self.relative(glass.eta);
                let roughness = self.roughness(&glass.facets);
                if w.z > 0.0 {
                    let Some((value, h)) = roughness.mirrored(view, w) else {
                        return Vec3::ZERO;
                    };
                    let (reflected, _) = fresnel::dielectric(h.dot(view), eta);
                    self.colour(&glass.reflectance) * (reflected * value)
                } else {
                    self.colour(&glass.transmittance) * refracted(&roughness, view, w, eta)
                }
            }
            Model::Phong(phong) if w.z > 0.0 => {
                let phong = phong.get();
                let v = view;
                let mirrored = (v.z * w.z - v.x * w.x - v.y * w.y).max(0.0);
                let lobe = mirrored.powf(phong.exponent) * (0.5 * phong.exponent + 1.0);
                (self.colour(&phong.diffuse) + self.colour(&phong.specular) * lobe)
                    * (phong.scale * FRAC_1_PI * w.z)
            }
            _ => Vec3::ZERO,
        }
    }
}

/// What facets refract from `w` to the viewer, times the cosine of `w` (Walter et al. 2007, Eq. 21),
/// for radiance.
fn refracted(roughness: &Roughness, v: Direction<f32>, w: Direction<f32>, eta: f32) -> f32 {
    let Some(m) = facets::half_vector(v, w, eta) else { return 0.0 };
    let (vm, wm) = (v.dot(m), w.dot(m));
    if vm <= 0.0 || wm >= 0.0 {
        return 0.0;
    }
    let (reflected, _) = fresnel::dielectric(vm, eta);
    let root = vm + eta * wm;
    let value = (1.0 - reflected)
        * roughness.distribution(m)
        * roughness.unshadowed(v, w, m)
        * (vm * wm / (v.z * root * root)).abs();
    // η² of the change of measure and 1/η² of compressed radiance cancel.
    if value.is_finite() { value } else { 0.0 }
}
