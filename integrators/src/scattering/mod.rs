//! How surfaces scatter light: which lobes a material has, and the value of the scattering function.
//!
//! Sampling needs the lobes only, and its densities are derived ([`crate::strategies`]); values are
//! needed by the integrand. What is here is written for radiance, with light that arrives from `w` and
//! leaves to the viewer.

mod bump;
pub mod facets;
pub mod fresnel;
mod lobe;
mod material;
mod rough_plastic;
#[cfg(test)]
mod tests;
mod value;

use aether_core::prelude::{Direction, Frame};
use glam::{Vec2, Vec3};

pub use lobe::{Lobe, Lobes, Weighted};
pub use material::{Material, Model, Opacity, Side};
pub use rough_plastic::Coat;

use crate::kind::{
    Either, Facetted, Interface, Oriented, Part, PhongOf, PlasticOf, Presence, Refraction,
    RoughPlasticOf, SceneKind,
};
use crate::scene::bsdf::{Facets, Metal, Roughness};
use crate::scene::texture::{Colour, Grey, Texture};
use crate::vertex::Surface;
use bump::Bumped;

/// A material at a point, as it is seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Scattering<'w, K: SceneKind> {
    side: &'w Side<K>,
    /// The frame about the shading normal on the side of the viewer.
    pub frame: Frame<f32>,
    /// Where the viewer is, in the frame: above.
    pub view: Direction<f32>,
    /// Whether the viewer is behind the surface.
    behind: bool,
    textures: &'w [Texture],
    uv: Vec2,
    bumped: <K::Bumps as Presence>::Field<Option<Bumped>>,
    shares: <Mixtures<K> as Presence>::Field<Shares>,
}

/// Whether the kind has materials of several parts.
type Mixtures<K> = Either<<K as SceneKind>::Mask, <K as SceneKind>::Blend>;

/// The least roughness that a texture can give.
const LEAST_ROUGHNESS: f32 = 1e-4;

/// What a metal reflects at a cosine; everything without an index of refraction.
fn metal(metal: Option<Metal>, cosine: f32) -> Vec3 {
    metal.map_or(Vec3::ONE, |Metal { eta, k }| fresnel::conductor(cosine, eta, k))
}

impl<'w, K: SceneKind> Scattering<'w, K> {
    /// How a material scatters light to a viewer in direction `towards`; `None` from within the surface
    /// or if it is black on that side.
    #[inline(always)]
    pub fn new(
        material: &'w Material<K>,
        textures: &'w [Texture],
        surface: &Surface<K>,
        towards: Vec3,
    ) -> Option<Self> {
        let behind = surface.shading.dot(towards) <= 0.0;
        let (side, n) = if behind {
            (&material.back, -surface.shading)
        } else {
            (&material.front, surface.shading)
        };
        if side.is_black() {
            return None;
        }
        let uv = K::Textures::value(surface.uv);
        let tangent = || Oriented::<K>::value(surface.tangents).du;
        let (frame, bumped) = match &side.bump {
            Some((_, map, front)) => {
                let (normal, bumped) =
                    bump::turned(*map, textures, uv, surface, towards, *front && behind);
                (bump::frame_along(normal, tangent()), Some(bumped))
            }
            None if Oriented::<K>::VALUE.is_some() && side.oriented => {
                (bump::frame_along(n, tangent()), None)
            }
            None => (Frame::around(Direction::new(n.x, n.y, n.z)), None),
        };
        let view = Direction::from_vec(frame.to_local(towards));
        let above = view.z > 0.0;
        if !above {
            return None;
        }
        let bumped = K::Bumps::field(|| bumped);
        let shares = Default::default();
        let plain = Scattering { side, frame, view, behind, textures, uv, bumped, shares };
        Some(Scattering { shares: Mixtures::<K>::field(|| plain.shares_here()), ..plain })
    }

    /// A colour here.
    #[inline]
    fn colour(&self, colour: &Colour) -> Vec3 {
        match (K::Textures::VALUE, colour.texture) {
            (Some(_), Some(texture)) => self.textures[texture as usize].at(self.uv),
            _ => colour.value,
        }
    }

    /// A number here.
    #[inline]
    fn grey(&self, grey: &Grey) -> f32 {
        match (K::Textures::VALUE, grey.texture) {
            (Some(_), Some(texture)) => self.textures[texture as usize].number(self.uv),
            _ => grey.value,
        }
    }

    /// Microfacets here.
    #[inline]
    fn roughness(&self, facets: &Facets) -> Roughness {
        let Facets { distribution, sample_visible, .. } = *facets;
        let alpha = facets.alpha.map(|alpha| {
            let least = if alpha.texture.is_some() { LEAST_ROUGHNESS } else { 0.0 };
            self.grey(&alpha).max(least)
        });
        Roughness { distribution, alpha, sample_visible }
    }

    /// What is left of light from `w` (in world coordinates) because the normals are turned.
    #[inline]
    fn unhidden(&self, w: Vec3) -> f32 {
        K::Bumps::value(self.bumped).map_or(1.0, |bumped| bumped.unhidden(w, self.frame))
    }

    /// How many lobes there are.
    #[inline]
    pub fn count(&self) -> usize {
        let second = self.side.blend.as_ref().map_or(0, |(_, model, _)| count(model));
        count(&self.side.base) + second + usize::from(self.side.mask.is_some())
    }

    /// Whether the lobe is that of the holes in the surface, the last one.
    #[inline]
    fn is_hole(&self, index: usize) -> bool {
        self.side.mask.is_some() && index + 1 == self.count()
    }

    /// A lobe, if there are so many. Chances add up to one.
    #[inline]
    pub fn lobe(&self, index: usize) -> Option<Weighted<K>> {
        let Shares { base, second, holes } = self.shares();
        let first = count(&self.side.base);
        if index < first {
            return Some(self.model_lobe(&self.side.base, index)?.scaled(base));
        }
        if let Some((_, model, _)) = &self.side.blend
            && index - first < count(model)
        {
            return Some(self.model_lobe(model, index - first)?.scaled(second));
        }
        let lobe = Lobe::Passage(Presence::VALUE?);
        Some(Weighted { lobe, coefficient: Vec3::ONE, chance: 1.0 }.scaled(holes))
    }

    /// What each part of the material has of the light, and how often sampling chooses it: never where
    /// it is black.
    #[inline]
    fn shares(&self) -> Shares {
        Mixtures::<K>::value(self.shares)
    }

    /// The same, computed once.
    fn shares_here(&self) -> Shares {
        let weight = self.side.blend.as_ref().map_or(0.0, |(_, _, share)| self.grey(share));
        let mut light = [1.0 - weight, weight];
        let mut holes = 0.0;
        if let Some((_, Opacity { whole, parts })) = &self.side.mask {
            let whole = self.grey(whole);
            light = [0, 1].map(|part| light[part] * self.grey(&parts[part]) * whole);
            holes = (1.0 - (light[0] + light[1])).max(0.0);
        }
        let first = if self.side.base.is_black() { 0.0 } else { light[0] };
        let second = match &self.side.blend {
            Some((_, model, _)) if !model.is_black() => light[1],
            _ => 0.0,
        };
        let all = first + second + holes;
        // Where a texture leaves only what is black, nothing is chosen.
        let share =
            |light, chance| Share { light, chance: if all > 0.0 { chance / all } else { 0.0 } };
        Shares {
            base: share(light[0], first),
            second: share(light[1], second),
            holes: share(holes, holes),
        }
    }

    /// A quantity of the materials, each by its share of the light.
    #[inline]
    fn mixed(&self, of: impl Fn(&Model<K>) -> Vec3) -> Vec3 {
        let Shares { base, second, .. } = self.shares();
        let first = of(&self.side.base) * base.light;
        self.side.blend.as_ref().map_or(first, |(_, model, _)| first + of(model) * second.light)
    }

    /// About what the surface scatters of the light that arrives: the probability to go on after
    /// Russian roulette.
    pub fn albedo(&self) -> Vec3 {
        self.mixed(|model| self.model_albedo(model)) + Vec3::splat(self.shares().holes.light)
    }

    /// The index of refraction on the other side over that on the viewer's.
    fn relative(&self, eta: f32) -> f32 {
        if self.behind { 1.0 / eta } else { eta }
    }

    #[inline]
    fn model_albedo(&self, model: &Model<K>) -> Vec3 {
        match model {
            Model::Black => Vec3::ZERO,
            Model::Diffuse(matte) => self.colour(&matte.get().reflectance),
            Model::Conductor(m) => {
                self.colour(&m.get().reflectance) * metal(m.get().metal, self.view.z)
            }
            Model::RoughConductor(m) => {
                self.colour(&m.get().reflectance) * metal(m.get().metal, self.view.z)
            }
            Model::Dielectric(glass) => {
                self.colour(&glass.get().reflectance).max(self.colour(&glass.get().transmittance))
            }
            Model::ThinDielectric(pane) => {
                self.colour(&pane.get().reflectance).max(self.colour(&pane.get().transmittance))
            }
            Model::RoughDielectric(glass) => {
                self.colour(&glass.get().reflectance).max(self.colour(&glass.get().transmittance))
            }
            Model::Plastic(plastic) => {
                let (plastic, _) = PlasticOf::<K>::get_ref(plastic);
                let (share, _) = fresnel::dielectric(self.view.z, plastic.eta);
                self.colour(&plastic.diffuse).lerp(self.colour(&plastic.reflectance), share)
            }
            Model::RoughPlastic(plastic) => {
                let (plastic, coat) = RoughPlasticOf::<K>::get_ref(plastic);
                let share = 1.0 - coat.transmitted(self.view.z);
                self.colour(&plastic.diffuse).lerp(self.colour(&plastic.reflectance), share)
            }
            Model::Phong(phong) => {
                let phong = phong.get();
                phong.scale * (self.colour(&phong.diffuse) + self.colour(&phong.specular))
            }
        }
    }

    #[inline]
    fn model_lobe(&self, model: &Model<K>, index: usize) -> Option<Weighted<K>> {
        match model {
            Model::Black => None,
            Model::Diffuse(_) => matte(1.0),
            Model::Conductor(m) => {
                let reflected =
                    self.colour(&m.get().reflectance) * metal(m.get().metal, self.view.z);
                mirror(reflected, 1.0)
            }
            Model::Dielectric(glass) => {
                let eta = self.relative(glass.get().eta);
                let (reflected, _) = fresnel::dielectric(self.view.z, eta);
                if index == 0 {
                    let colour = self.colour(&glass.get().reflectance) * reflected;
                    return mirror(colour, reflected);
                }
                let passed = 1.0 - reflected;
                Some(Weighted {
                    lobe: Lobe::Refraction(Refraction::<K>::with(|| eta)?),
                    // Radiance is compressed into a smaller solid angle.
                    coefficient: self.colour(&glass.get().transmittance) * (passed / (eta * eta)),
                    chance: passed,
                })
            }
            Model::ThinDielectric(pane) => {
                let (once, _) = fresnel::dielectric(self.view.z, pane.get().eta);
                // The sum over all reflections within the pane.
                let reflected = 2.0 * once / (1.0 + once);
                if index == 0 {
                    let colour = self.colour(&pane.get().reflectance) * reflected;
                    return mirror(colour, reflected);
                }
                Some(Weighted {
                    lobe: Lobe::Passage(Presence::VALUE?),
                    coefficient: self.colour(&pane.get().transmittance) * (1.0 - reflected),
                    chance: 1.0 - reflected,
                })
            }
            Model::Plastic(plastic) => {
                let (plastic, _) = PlasticOf::<K>::get_ref(plastic);
                let (reflected, _) = fresnel::dielectric(self.view.z, plastic.eta);
                let chance =
                    coat_chance(reflected, plastic.reflectance.value, plastic.diffuse.value);
                if index == 0 {
                    mirror(self.colour(&plastic.reflectance) * reflected, chance)
                } else {
                    matte(1.0 - chance)
                }
            }
            Model::RoughConductor(m) => facets(self.roughness(&m.get().facets), 1.0),
            Model::RoughDielectric(glass) => {
                let glass = glass.get();
                let eta = self.relative(glass.eta);
                let roughness = self.roughness(&glass.facets);
                let lobe = Lobe::Interface(Interface::<K>::with(|| (roughness, eta))?);
                Some(Weighted { lobe, coefficient: Vec3::ZERO, chance: 1.0 })
            }
            Model::RoughPlastic(plastic) => {
                let (plastic, coat) = RoughPlasticOf::<K>::get_ref(plastic);
                let reflected = 1.0 - coat.transmitted(self.view.z);
                let chance =
                    coat_chance(reflected, plastic.reflectance.value, plastic.diffuse.value);
                if index == 0 { facets(plastic.roughness, chance) } else { matte(1.0 - chance) }
            }
            Model::Phong(phong) => {
                let phong = phong.get();
                let chance = coat_chance(0.5, phong.specular.value, phong.diffuse.value);
                if index == 1 {
                    return matte(1.0 - chance);
                }
                let lobe = Lobe::Glossy(PhongOf::<K>::with(|| phong.exponent)?);
                Some(Weighted { lobe, coefficient: Vec3::ZERO, chance })
            }
        }
    }
}

impl<K: SceneKind> Weighted<K> {
    fn scaled(self, Share { light, chance }: Share) -> Self {
        Weighted { coefficient: self.coefficient * light, chance: self.chance * chance, ..self }
    }
}

/// What a part of a material has of the light, and how often it is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Share {
    light: f32,
    chance: f32,
}

/// The shares of the parts of a material; the light's add up to one, and the chances do.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shares {
    base: Share,
    second: Share,
    holes: Share,
}

impl Default for Shares {
    /// Those of a material that is no mixture.
    fn default() -> Self {
        let (all, none) = (Share { light: 1.0, chance: 1.0 }, Share { light: 0.0, chance: 0.0 });
        Shares { base: all, second: none, holes: none }
    }
}

#[inline]
fn count<K: SceneKind>(model: &Model<K>) -> usize {
    match model {
        Model::Black => 0,
        Model::Diffuse(_)
        | Model::Conductor(_)
        | Model::RoughConductor(_)
        | Model::RoughDielectric(_) => 1,
        Model::Dielectric(_)
        | Model::ThinDielectric(_)
        | Model::Plastic(_)
        | Model::RoughPlastic(_)
        | Model::Phong(_) => 2,
    }
}

fn matte<K: SceneKind>(chance: f32) -> Option<Weighted<K>> {
    let lobe = Lobe::Matte(Presence::VALUE?);
    Some(Weighted { lobe, coefficient: Vec3::ZERO, chance })
}

fn mirror<K: SceneKind>(coefficient: Vec3, chance: f32) -> Option<Weighted<K>> {
    Some(Weighted { lobe: Lobe::Mirror(Presence::VALUE?), coefficient, chance })
}

fn facets<K: SceneKind>(roughness: Roughness, chance: f32) -> Option<Weighted<K>> {
    let lobe = Lobe::Facets(Facetted::<K>::with(|| roughness)?);
    Some(Weighted { lobe, coefficient: Vec3::ZERO, chance })
}

/// How often to sample the coat of a plastic rather than its base.
fn coat_chance(reflected: f32, coat: Vec3, base: Vec3) -> f32 {
    let (coat, base) = (reflected * coat.element_sum(), (1.0 - reflected) * base.element_sum());
    if coat + base > 0.0 { coat / (coat + base) } else { 0.5 }
}
