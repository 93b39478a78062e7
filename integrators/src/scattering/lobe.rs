//! The lobes of a material: the ways in which it scatters, of which sampling chooses one.

use aether_core::discrete::{Choice, Discrete};
use aether_core::prelude::Direction;
use glam::Vec3;

use super::{Model, PartIndex, Pose, Scattering, count};
use crate::kind::{
    Facetted, Interface, Matte, Part, Passage, PhongOf, Presence, Refraction, SceneKind, Several,
    Specular, With,
};
use crate::scene::bsdf::Roughness;

/// One way in which a surface scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lobe<K: SceneKind> {
    /// Not at all.
    Nothing,
    /// Into all directions alike.
    Matte(Matte<K>),
    /// About the normal, as a mirror: an atom.
    Mirror(Specular<K>),
    /// Through the surface, bent by its relative index of refraction: an atom.
    Refraction(With<Refraction<K>, f32>),
    /// Through the surface unchanged: an atom.
    Passage(Passage<K>),
    /// About the normals of microfacets.
    Facets(With<Facetted<K>, Roughness>),
    /// About the mirror direction, with the exponent of the cosine.
    Glossy(With<PhongOf<K>, f32>),
    /// About the normals of microfacets or through them, as Fresnel's equations say for each; the
    /// relative index of refraction.
    Interface(With<Interface<K>, (Roughness, f32)>),
}

impl<K: SceneKind> Lobe<K> {
    /// Whether it scatters into a single direction.
    pub fn is_atom(&self) -> bool {
        matches!(self, Lobe::Mirror(_) | Lobe::Refraction(_) | Lobe::Passage(_))
    }

    /// How widely it scatters, as the root mean square slope of facets: zero of an atom, infinite of a matte lobe.
    pub fn roughness(&self) -> f32 {
        let largest = |roughness: Roughness| roughness.alpha[0].max(roughness.alpha[1]);
        match *self {
            Lobe::Nothing | Lobe::Mirror(_) | Lobe::Refraction(_) | Lobe::Passage(_) => 0.0,
            Lobe::Matte(_) => f32::INFINITY,
            Lobe::Facets(facets) => largest(Facetted::<K>::get(facets)),
            // As of [`crate::scene::bsdf::Bsdf::roughness`].
            Lobe::Glossy(exponent) => (2.0 / (PhongOf::<K>::get(exponent) + 2.0)).sqrt(),
            Lobe::Interface(interface) => largest(Interface::<K>::get(interface).0),
        }
    }
}

/// A lobe, what it scatters, and how often sampling chooses it.
#[derive(Clone, Copy, Debug)]
pub struct Weighted<K: SceneKind> {
    /// The lobe.
    pub lobe: Lobe<K>,
    /// For an atom, its coefficient. Otherwise unused.
    pub coefficient: Vec3,
    /// The probability to choose it.
    pub chance: f32,
    /// The part of the material that it belongs to.
    pub part: PartIndex<K>,
}

/// Directions that differ by less (squared) are one: those of parts whose normals agree but for rounding.
const SAME_DIRECTION: f32 = 1e-12;

/// The choice of a lobe, or of the `only` one that may be chosen.
#[derive(Clone, Copy, Debug)]
pub struct Lobes<'l, 'w, K: SceneKind>(&'l Scattering<'w, K>, Option<u32>);

impl<K: SceneKind> Lobes<'_, '_, K> {
    /// A lobe and its probability.
    #[inline]
    fn at(&self, index: usize) -> Option<Choice<Weighted<K>, f32>> {
        let lobe = self.0.lobe(index)?;
        let probability = match self.1 {
            Some(only) => f32::from(only as usize == index),
            None => lobe.chance,
        };
        Some(Choice { index, item: lobe, probability })
    }

    /// The lobe that the uniform `u` selects, by inversion, and what is left of `u`.
    #[inline(always)]
    fn selected(&self, u: f32) -> (Choice<Weighted<K>, f32>, f32) {
        let mut start = 0.0;
        let mut last = None;
        for index in 0..self.0.count() {
            let Some(choice) = self.at(index) else { continue };
            if choice.probability > 0.0 {
                let rest = ((u - start) / choice.probability).clamp(0.0, 1.0 - 0.5 * f32::EPSILON);
                let end = start + choice.probability;
                last = Some((choice, rest));
                if u < end {
                    break;
                }
                start = end;
            }
        }
        // Rounding leaves no gap behind the last lobe. There is no scattering without any.
        let nothing = Weighted::new(Lobe::Nothing, Vec3::ZERO, 0.0);
        last.unwrap_or((Choice { index: 0, item: nothing, probability: 0.0 }, u))
    }

    /// [`Lobes::selected`], not in line.
    #[inline(never)]
    fn selected_among(&self, u: f32) -> (Choice<Weighted<K>, f32>, f32) {
        self.selected(u)
    }
}

impl<K: SceneKind> Discrete<f32> for Lobes<'_, '_, K> {
    type Item<'a>
        = Weighted<K>
    where
        Self: 'a;

    #[inline]
    fn len(&self) -> usize {
        self.0.count()
    }

    #[inline(always)]
    fn sample_reuse(&self, u: f32) -> (Choice<Weighted<K>, f32>, f32) {
        // Where each material has one lobe, there is less to do than a call takes.
        if Several::<K>::VALUE.is_some() { self.selected_among(u) } else { self.selected(u) }
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<Weighted<K>, f32>> {
        self.at(index)
    }
}

impl<'w, K: SceneKind> Scattering<'w, K> {
    /// The largest roughness of the lobes.
    pub fn roughest(&self) -> f32 {
        let lobes = (0..self.count()).filter_map(|index| self.lobe(index));
        lobes.map(|lobe| lobe.lobe.roughness()).fold(0.0, f32::max)
    }

    /// The choice of a lobe, or of the `only` one that may be chosen.
    #[inline]
    pub fn lobes<'l>(&'l self, only: Option<u32>) -> Lobes<'l, 'w, K> {
        Lobes(self, only)
    }

    /// The indices of the lobes that may have led in direction `w`: all that scatter into many
    /// directions, and of the atoms those that point nearest to it.
    #[inline(always)]
    pub fn leading_to(&self, w: Option<Vec3>) -> impl Iterator<Item = usize> + use<K> {
        // A bit for each lobe; there are few. Most surfaces have no atoms.
        let leading = if self.side.is_specular() { self.bits_leading_to(w) } else { !0 };
        (0..self.count()).filter(move |index| leading >> index & 1 == 1)
    }

    fn bits_leading_to(&self, w: Option<Vec3>) -> u32 {
        let w = w.map(|w| Vec3::from(self.pose.frame().to_local(w)));
        let (mut wide, mut nearest) = (0, 0);
        let mut least: Option<(f32, Vec3)> = None;
        for index in 0..self.count() {
            let (bit, direction) = (1 << index, self.direction_of_atom(index));
            let Some(direction) = direction else {
                wide |= bit;
                continue;
            };
            let Some(w) = w else { continue };
            let distance = direction.distance_squared(w);
            // Atoms that lead in the same direction are one.
            match least {
                Some((_, same)) if same.distance_squared(direction) <= SAME_DIRECTION => {
                    nearest |= bit;
                }
                Some((least, _)) if distance >= least => {}
                _ => {
                    least = Some((distance, direction));
                    nearest = bit;
                }
            }
        }
        wide | nearest
    }

    /// The relative index of refraction of the facets that refract, if there are any.
    pub fn refracting_facets(&self) -> Option<f32> {
        (0..self.count()).find_map(|index| match self.lobe(index)?.lobe {
            Lobe::Interface(interface) => Some(Interface::<K>::get(interface).1),
            _ => None,
        })
    }

    /// Where an atom scatters to, in the frame of its part; `None` for the other lobes.
    pub fn direction(&self, lobe: &Weighted<K>) -> Option<Direction<f32>> {
        let pose = self.pose_of(lobe.part);
        match lobe.lobe {
            Lobe::Mirror(_) => Some(pose.mirrored()),
            Lobe::Passage(_) => Some(pose.passed()),
            Lobe::Refraction(eta) => Some(pose.bent(Refraction::<K>::get(eta))),
            Lobe::Nothing
            | Lobe::Matte(_)
            | Lobe::Glossy(_)
            | Lobe::Facets(_)
            | Lobe::Interface(_) => None,
        }
    }

    /// The direction of the lobe with this index if it is an atom, in the frame of the first part and without its
    /// coefficient and chance.
    #[inline]
    fn direction_of_atom(&self, index: usize) -> Option<Vec3> {
        let (mut left, first) = (index, &self.side.base.model);
        if left < count(first) {
            let direction = self.direction_in(first, &self.pose, left)?;
            return Some(Vec3::from(direction.vec()));
        }
        left -= count(first);
        for (part, layer) in self.others() {
            if left < count(&layer.model) {
                let pose = self.pose_of(part);
                let direction = self.direction_in(&layer.model, &pose, left)?;
                let direction = Vec3::from(direction.vec());
                if !self.side.varied {
                    return Some(direction);
                }
                let world = pose.frame().to_world(direction);
                return Some(self.pose.frame().to_local(world).into());
            }
            left -= count(&layer.model);
        }
        Some(Vec3::from(self.pose.passed().vec()))
    }

    #[inline]
    fn direction_in(
        &self,
        model: &Model<K>,
        pose: &Pose<K>,
        index: usize,
    ) -> Option<Direction<f32>> {
        match (model, index) {
            _ if !pose.is_seen() => None,
            (Model::Conductor(_), _)
            | (Model::Dielectric(_) | Model::ThinDielectric(_) | Model::Plastic(_), 0) => {
                Some(pose.mirrored())
            }
            (Model::Dielectric(glass), _) => Some(pose.bent(self.relative(glass.get().eta))),
            (Model::ThinDielectric(_), _) => Some(pose.passed()),
            _ => None,
        }
    }

    /// The measure in which atoms are stated, per solid angle in the direction `w` of the frame that a
    /// lobe scatters to: the cosine, and where light is bent the square of the index of refraction on
    /// that side. What refracts keeps this measure, so that paths from either side agree on an atom
    /// (Veach 1997, section 5.2).
    pub fn measure(&self, lobe: &Lobe<K>, w: Direction<f32>) -> f32 {
        match lobe {
            // Light that passes unchanged knows no normal.
            Lobe::Passage(_) => 1.0,
            Lobe::Refraction(eta) if !self.behind => w.z.abs() * Refraction::<K>::get(*eta).powi(2),
            _ => w.z.abs(),
        }
    }

    /// The sum of the coefficients of the atoms that lead in direction `w`, in their measure.
    pub fn atoms(&self, w: Vec3) -> Vec3 {
        let mut sum = Vec3::ZERO;
        for index in self.leading_to(Some(w)) {
            let Some(lobe) = self.lobe(index) else { continue };
            let Some(direction) = self.direction(&lobe) else { continue };
            // Holes have no normals.
            let pose = self.pose_of(lobe.part);
            let unhidden = if self.is_hole(index) { 1.0 } else { pose.unhidden(w) };
            sum += lobe.coefficient * (unhidden * self.measure(&lobe.lobe, direction));
        }
        sum
    }
}
