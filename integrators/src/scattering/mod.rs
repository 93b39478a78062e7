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
mod pose;
mod rough_plastic;
#[cfg(test)]
mod tests;
mod value;

use glam::Vec3;

pub use lobe::{Lobe, Lobes, Weighted};
pub use material::{Factor, Layer, Material, Model, Side};
pub use pose::Pose;
pub use rough_plastic::Coat;

use crate::kind::{
    Either, Facetted, Interface, Part, PhongOf, PlasticOf, Presence, Refraction, RoughPlasticOf,
    SceneKind,
};
use crate::scene::bsdf::{Facets, Metal, Roughness};
use crate::scene::texture::{Colour, Grey, Spot, Texture};
use crate::vertex::Surface;
use bump::Ground;

/// A material at a point, as it is seen from one side.
#[derive(Clone, Copy, Debug)]
pub struct Scattering<'w, K: SceneKind> {
    side: &'w Side<K>,
    /// How the first part of the material lies, and mostly all of it.
    pub pose: Pose<K>,
    /// Whether the viewer is behind the surface.
    behind: bool,
    textures: &'w [Texture],
    spot: <K::Textures as Presence>::Field<Spot>,
    shares: <Mixtures<K> as Presence>::Field<Shares>,
    /// What the other parts' poses follow from, where they have normals of their own.
    ground: <K::Blend as Presence>::Field<Option<Ground>>,
}

/// The number of a part of a material, if the kind has materials of several parts.
pub type PartIndex<K> = <<K as SceneKind>::Blend as Presence>::Field<u8>;

/// Whether the kind has materials of several parts.
type Mixtures<K> = Either<<K as SceneKind>::Mask, <K as SceneKind>::Blend>;

/// The least roughness that a texture can give.
const LEAST_ROUGHNESS: f32 = 1e-4;

/// What a metal reflects at a cosine; everything without an index of refraction.
fn metal(metal: Option<Metal>, cosine: f32) -> Vec3 {
    metal.map_or(Vec3::ONE, |Metal { eta, k }| fresnel::conductor(cosine, eta, k))
}

impl<'w, K: SceneKind> Scattering<'w, K> {
    /// How a material scatters light to a viewer at some offset, whose direction is `towards`; `None` from within the
    /// surface or if it is black on that side. Where nothing but the side matters, the direction is not computed.
    #[inline(always)]
    pub fn new(
        material: &'w Material<K>,
        textures: &'w [Texture],
        surface: &Surface<K>,
        [offset, towards]: [Vec3; 2],
    ) -> Option<Self> {
        let behind = surface.shading.dot(offset) <= 0.0;
        let (side, n) = if behind {
            (&material.back, -surface.shading)
        } else {
            (&material.front, surface.shading)
        };
        if side.is_black() {
            return None;
        }
        let ground = Ground::new(surface, [offset, towards]);
        let pose = Pose::new(&side.base, side.oriented, &ground, n, textures);
        if !pose.is_seen() && !side.is_mixture() {
            return None;
        }
        let spot = K::Textures::field(|| ground.spot);
        let mut scattering = Scattering {
            side,
            pose,
            behind,
            textures,
            spot,
            shares: Default::default(),
            ground: K::Blend::field(|| side.varied.then_some(ground)),
        };
        // In place, because there is much in it.
        if side.is_mixture() {
            scattering.shares = Mixtures::<K>::field(|| scattering.shares_here());
        }
        Some(scattering)
    }

    /// How a part of the material lies.
    #[inline(always)]
    pub fn pose_of(&self, part: PartIndex<K>) -> Pose<K> {
        let others = self.side.others();
        match (K::Blend::value(self.ground), usize::from(K::Blend::value(part)).checked_sub(1)) {
            (Some(ground), Some(index)) if index < others.len() => {
                let n = if self.behind { -ground.shading } else { ground.shading };
                Pose::new(&others[index], self.side.oriented, &ground, n, self.textures)
            }
            _ => self.pose,
        }
    }

    /// The parts behind the first with their numbers.
    #[inline(always)]
    fn others(&self) -> impl Iterator<Item = (PartIndex<K>, &'w Layer<K>)> + use<'w, K> {
        let others = self.side.others().iter().enumerate();
        others.map(|(index, layer)| (K::Blend::field(|| index as u8 + 1), layer))
    }

    /// A colour here.
    #[inline]
    fn colour(&self, colour: &Colour) -> Vec3 {
        match (K::Textures::VALUE, colour.texture) {
            (Some(_), Some(texture)) => {
                self.textures[texture as usize].on(&K::Textures::value(self.spot))
            }
            _ => colour.value,
        }
    }

    /// A number here.
    #[inline]
    fn grey(&self, grey: &Grey) -> f32 {
        match (K::Textures::VALUE, grey.texture) {
            (Some(_), Some(texture)) => {
                self.textures[texture as usize].number_on(&K::Textures::value(self.spot))
            }
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

    /// How many lobes there are.
    #[inline]
    pub fn count(&self) -> usize {
        let others: usize = self.side.others().iter().map(|layer| count(&layer.model)).sum();
        count(&self.side.base.model) + others + usize::from(self.side.holes.is_some())
    }

    /// Whether the lobe is that of the holes in the surface, the last one.
    #[inline]
    fn is_hole(&self, index: usize) -> bool {
        self.side.holes.is_some() && index + 1 == self.count()
    }

    /// A lobe, if there are so many. Chances add up to one.
    #[inline]
    pub fn lobe(&self, index: usize) -> Option<Weighted<K>> {
        let Shares { base, holes, .. } = self.shares();
        let mut left = index;
        let first = &self.side.base.model;
        if left < count(first) {
            return Some(self.model_lobe(first, &self.pose, left)?.scaled(base));
        }
        left -= count(first);
        for (part, layer) in self.others() {
            if left < count(&layer.model) {
                let (pose, share) = (self.pose_of(part), self.share_of(part, layer));
                let lobe = self.model_lobe(&layer.model, &pose, left)?.scaled(share);
                return Some(Weighted { part, ..lobe });
            }
            left -= count(&layer.model);
        }
        let lobe = Lobe::Passage(Presence::VALUE?);
        Some(Weighted::new(lobe, Vec3::ONE, 1.0).scaled(holes))
    }

    /// What each part of the material has of the light, and how often sampling chooses it: never where
    /// it is black.
    #[inline]
    fn shares(&self) -> Shares {
        Mixtures::<K>::value(self.shares)
    }

    /// The share of a part of the material in the light.
    fn light_of(&self, layer: &Layer<K>) -> f32 {
        let factors = layer.factors.iter().map(|factor| match factor {
            Factor::Of(grey) => self.grey(grey),
            Factor::Rest(grey) => 1.0 - self.grey(grey),
        });
        factors.product()
    }

    /// The share of a part behind the first.
    fn share_of(&self, part: PartIndex<K>, layer: &Layer<K>) -> Share {
        let light = self.light_of(layer);
        let dark = layer.model.is_black() || !self.pose_of(part).is_seen();
        Share { light, chance: if dark { 0.0 } else { light * self.shares().scale } }
    }

    /// The shares of the first part and of the holes of a mixture, computed once.
    #[inline(never)]
    fn shares_here(&self) -> Shares {
        let light = self.light_of(&self.side.base);
        let dark = self.side.base.model.is_black() || !self.pose.is_seen();
        let (mut lit, mut seen) = (light, if dark { 0.0 } else { light });
        // Whatever the chances of the others are divided by, none of them is negative.
        for (part, layer) in self.others() {
            let Share { light, chance } = self.share_of(part, layer);
            (lit, seen) = (lit + light, seen + chance);
        }
        let holes = if self.side.holes.is_some() { (1.0 - lit).max(0.0) } else { 0.0 };
        let all = seen + holes;
        // Where a texture leaves only what is black, nothing is chosen.
        let scale = if all > 0.0 { 1.0 / all } else { 0.0 };
        Shares {
            base: Share { light, chance: if dark { 0.0 } else { light * scale } },
            holes: Share { light: holes, chance: holes * scale },
            scale,
        }
    }

    /// A quantity of the parts of the material that are seen, each by its share of the light.
    #[inline(always)]
    fn mixed(&self, of: impl Fn(&Model<K>, &Pose<K>) -> Vec3) -> Vec3 {
        let seen = |model: &Model<K>, pose: &Pose<K>| {
            if pose.is_seen() { of(model, pose) } else { Vec3::ZERO }
        };
        let first = seen(&self.side.base.model, &self.pose) * self.shares().base.light;
        self.others().fold(first, |sum, (part, layer)| {
            sum + seen(&layer.model, &self.pose_of(part)) * self.light_of(layer)
        })
    }

    /// About what the surface scatters of the light that arrives: the probability to go on after
    /// Russian roulette.
    pub fn albedo(&self) -> Vec3 {
        let parts = self.mixed(|model, pose| self.model_albedo(model, pose.view_cosine()));
        parts + Vec3::splat(self.shares().holes.light)
    }

    /// The index of refraction on the other side over that on the viewer's.
    fn relative(&self, eta: f32) -> f32 {
        if self.behind { 1.0 / eta } else { eta }
    }

    #[inline]
    fn model_albedo(&self, model: &Model<K>, cosine: f32) -> Vec3 {
        match model {
            Model::Black => Vec3::ZERO,
            Model::Diffuse(matte) => self.colour(&matte.get().reflectance),
            Model::Conductor(m) => self.colour(&m.get().reflectance) * metal(m.get().metal, cosine),
            Model::RoughConductor(m) => {
                self.colour(&m.get().reflectance) * metal(m.get().metal, cosine)
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
                let (share, _) = fresnel::dielectric(cosine, plastic.eta);
                self.colour(&plastic.diffuse).lerp(self.colour(&plastic.reflectance), share)
            }
            Model::RoughPlastic(plastic) => {
                let (plastic, coat) = RoughPlasticOf::<K>::get_ref(plastic);
                let share = 1.0 - coat.transmitted(cosine);
                self.colour(&plastic.diffuse).lerp(self.colour(&plastic.reflectance), share)
            }
            Model::Phong(phong) => {
                let phong = phong.get();
                phong.scale * (self.colour(&phong.diffuse) + self.colour(&phong.specular))
            }
        }
    }

    #[inline]
    fn model_lobe(&self, model: &Model<K>, pose: &Pose<K>, index: usize) -> Option<Weighted<K>> {
        if !pose.is_seen() {
            return Some(Weighted::new(Lobe::Nothing, Vec3::ZERO, 0.0));
        }
        let cosine = pose.view_cosine();
        match model {
            Model::Black => None,
            Model::Diffuse(_) => matte(1.0),
            Model::Conductor(m) => {
                let reflected = self.colour(&m.get().reflectance) * metal(m.get().metal, cosine);
                mirror(reflected, 1.0)
            }
            Model::Dielectric(glass) => {
                let eta = self.relative(glass.get().eta);
                let (reflected, _) = fresnel::dielectric(cosine, eta);
                if index == 0 {
                    let colour = self.colour(&glass.get().reflectance) * reflected;
                    return mirror(colour, reflected);
                }
                let passed = 1.0 - reflected;
                Some(Weighted::new(
                    Lobe::Refraction(Refraction::<K>::with(|| eta)?),
                    self.colour(&glass.get().transmittance) * (passed / (eta * eta)),
                    passed,
                ))
            }
            Model::ThinDielectric(pane) => {
                let (once, _) = fresnel::dielectric(cosine, pane.get().eta);
                // The sum over all reflections within the pane.
                let reflected = 2.0 * once / (1.0 + once);
                if index == 0 {
                    let colour = self.colour(&pane.get().reflectance) * reflected;
                    return mirror(colour, reflected);
                }
                Some(Weighted::new(
                    Lobe::Passage(Presence::VALUE?),
                    self.colour(&pane.get().transmittance) * (1.0 - reflected),
                    1.0 - reflected,
                ))
            }
            Model::Plastic(plastic) => {
                let (plastic, _) = PlasticOf::<K>::get_ref(plastic);
                let (reflected, _) = fresnel::dielectric(cosine, plastic.eta);
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
                Some(Weighted::new(lobe, Vec3::ZERO, 1.0))
            }
            Model::RoughPlastic(plastic) => {
                let (plastic, coat) = RoughPlasticOf::<K>::get_ref(plastic);
                let reflected = 1.0 - coat.transmitted(cosine);
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
                Some(Weighted::new(lobe, Vec3::ZERO, chance))
            }
        }
    }
}

impl<K: SceneKind> Weighted<K> {
    /// A lobe of the first part.
    fn new(lobe: Lobe<K>, coefficient: Vec3, chance: f32) -> Self {
        Weighted { lobe, coefficient, chance, part: Default::default() }
    }

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

/// The shares of the first part of a material and of its holes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shares {
    base: Share,
    holes: Share,
    /// What the light that a part has is multiplied by for the chance to choose it; chances add up to one.
    scale: f32,
}

impl Default for Shares {
    /// Those of a material that is no mixture.
    fn default() -> Self {
        let (all, none) = (Share { light: 1.0, chance: 1.0 }, Share { light: 0.0, chance: 0.0 });
        Shares { base: all, holes: none, scale: 1.0 }
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
    Some(Weighted::new(lobe, Vec3::ZERO, chance))
}

fn mirror<K: SceneKind>(coefficient: Vec3, chance: f32) -> Option<Weighted<K>> {
    Some(Weighted::new(Lobe::Mirror(Presence::VALUE?), coefficient, chance))
}

fn facets<K: SceneKind>(roughness: Roughness, chance: f32) -> Option<Weighted<K>> {
    let lobe = Lobe::Facets(Facetted::<K>::with(|| roughness)?);
    Some(Weighted::new(lobe, Vec3::ZERO, chance))
}

/// How often to sample the coat of a plastic rather than its base.
fn coat_chance(reflected: f32, coat: Vec3, base: Vec3) -> f32 {
    let (coat, base) = (reflected * coat.element_sum(), (1.0 - reflected) * base.element_sum());
    if coat + base > 0.0 { coat / (coat + base) } else { 0.5 }
}
