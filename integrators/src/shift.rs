//! The shift of gradient-domain path tracing (Kettunen, Manzi, Aittala, Lehtinen, Durand and Zwicker 2015): a
//! function from a path to a similar one through another point of the film.
//!
//! The film point moves; at a mirror or a pane the shifted path follows the lobe of the base path, elsewhere it
//! copies the half vector, until both can see the same rest of the base path: from the first two vertices in
//! succession that are rough, the rest is kept. Each new vertex is drawn by a strategy about what is copied, by
//! the middle of its uniforms. Forwards and backwards these strategies have the same density in terms of
//! what they draw, so that the change of measure is the ratio of their conditional densities (Aether 2017,
//! Eq. 7), which are derived; of what is kept it is one.
//!
//! A shift is undone by the shift back. Where that is not so, because the way back would keep another vertex
//! or meet something else, there is no shifted path.

use aether_core::combine::Shifted;
use aether_core::prelude::Vec2;
use aether_core::strategy::Dirac;
use aether_core::{Arena, RandomSequence, strategies};

use crate::half_vectors::{HalfVector, SampleHalfVector, sample_half_vector};
use crate::kind::{Everything, SceneKind};
use crate::strategies::{
    Aim, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf,
    sample_camera_direction,
};
use crate::vertex::{Place, SceneVertex};
use crate::world::World;

strategies! {
    /// How paths are made and shifted.
    #[derive(Clone)]
    pub enum ShiftStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
        /// The eye.
        Camera(SampleCamera<'a, 'a, K>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a, K>),
        /// Scattering.
        Bsdf(SampleBsdf<'a, 'a, K>),
        /// Next-event estimation.
        Light(SampleLight<'a, 'a, K>),
        /// Scattering by a given half vector.
        HalfVector(SampleHalfVector<'a, 'a, K>),
    }
}

/// A path, with the strategies of shifts.
pub type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, ShiftStrategies<'a, K>>;
/// Where they are.
pub type PathArena<'a, K> = Arena<SceneVertex<K>, ShiftStrategies<'a, K>>;

/// Moves paths on the film.
#[derive(Clone, Copy)]
pub struct Shift<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// By how many pixels, to the right and down.
    pub by: (f32, f32),
    /// Where the roughness of a surface is at least this, shifted paths may meet base paths.
    pub rough: f32,
}

/// The beginning of a shifted path, up to where it meets the base path.
#[derive(Clone, Copy)]
pub struct Beginning<'r, 'a, K: SceneKind> {
    /// The vertices that are not those of the base path, and the eye.
    new: Path<'r, 'a, K>,
    jacobian: f32,
    /// Whether all that follows is that of the base path.
    joined: bool,
}

/// How wide half vectors are drawn about the one that is copied. It cancels; to invert them within rounding it must
/// be large against that.
const WIDTH: f32 = 0.125;

impl<K: SceneKind> Beginning<'_, '_, K> {
    /// Whether it has met the base path, all further vertices of which are kept.
    pub fn is_joined(&self) -> bool {
        self.joined
    }
}

impl<'a, K: SceneKind> Shift<'a, K> {
    /// The eye of a path, which stays.
    pub fn begin<'r>(&self, base: &Path<'r, 'a, K>) -> Beginning<'r, 'a, K> {
        Beginning { new: base.slice(0..1), jacobian: 1.0, joined: false }
    }

    /// The beginning with one vertex more, if it has not met the base path, whose vertex at this place is not
    /// the last one. It depends on the base path up to there, and on whether that leaves from there by an atom.
    pub fn extend<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Beginning<'r, 'a, K>> {
        let i = beginning.new.len();
        let meets = |other: &Path<'r, 'a, K>| {
            self.may_join(beginning, base) && self.is_rough(other, i) && !is_atom(base, i)
        };
        if beginning.joined || meets(base) {
            return Some(Beginning { joined: true, ..*beginning });
        }
        let longer = self.copy(beginning, base)?;
        // There the way back would have met it.
        if meets(&longer.new) { None } else { Some(longer) }
    }

    /// The shift of a path from a beginning of it with one vertex less, at least.
    pub fn finish<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>> {
        let n = beginning.new.len();
        let is_lamp = matches!(base.last()?.place, Place::Bulb(_) | Place::Distant(_));
        if beginning.joined || is_lamp || self.may_join(beginning, base) {
            let path = beginning.new.concat(&base.slice(n..base.len()));
            return Some(Shifted { path, jacobian: beginning.jacobian });
        }
        let Beginning { new: path, jacobian, .. } = self.copy(beginning, base)?;
        Some(Shifted { path, jacobian })
    }

    /// The shift of a whole path.
    pub fn apply<'r>(
        &self,
        base: &Path<'r, 'a, K>,
    ) -> Option<Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>> {
        let inner = base.len().checked_sub(2)?;
        let beginning = (0..inner).try_fold(self.begin(base), |b, _| self.extend(&b, base))?;
        self.finish(&beginning, base)
    }

    /// The beginning with a new vertex that does what that of the base path does.
    fn copy<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Beginning<'r, 'a, K>> {
        let i = beginning.new.len();
        let [there, back] = self.strategies(base, i)?;
        let (mut new, mut way_back) = (beginning.new, base.slice(0..i));
        new.append(there).sample(&mut || 0.5);
        way_back.append(back);
        if !new.is_complete() || is_atom(&new, i - 1) != is_atom(base, i - 1) {
            return None;
        }
        let density_back = way_back.pdf_of(&base.slice(0..=i)) / base.slice(0..i).pdf();
        let jacobian = beginning.jacobian * density_back.value() / new.conditional(i)?;
        let regular = jacobian > 0.0 && jacobian < f32::INFINITY;
        regular.then_some(Beginning { new, jacobian, joined: false })
    }

    /// What makes vertex `i` of the shifted path, and what makes that of the base path on the way back.
    fn strategies(&self, base: &Path<'_, 'a, K>, i: usize) -> Option<[ShiftStrategies<'a, K>; 2]> {
        let (world, [here, next]) = (self.world, [base.vertex(i - 1)?, base.vertex(i)?]);
        if i == 1 {
            let film = world.film_point(&here, &next)?;
            let moved = Vec2::new(film.x + self.by.0, film.y + self.by.1);
            return Some(
                [moved, film].map(|p| sample_camera_direction(world, Aim::About(p)).into()),
            );
        }
        let before = base.vertex(i - 2)?;
        if is_atom(base, i - 1) {
            let lobe = world.mirror_between(&before, &here, &next)?;
            let same = sample_bsdf(world, u32::MAX, Some(lobe));
            return Some([same.clone().into(), same.into()]);
        }
        // On the way back, a ray would have to find it.
        if !base.view().visible(i) && !world.visible(&here, &next) {
            return None;
        }
        let half = HalfVector::between(world, [&before, &here, &next], WIDTH)?;
        let same = sample_half_vector(world, half);
        Some([same.clone().into(), same.into()])
    }

    /// Whether the shifted path can go on to the next vertex of the base path from where it is: both are rough.
    fn may_join(&self, beginning: &Beginning<'_, 'a, K>, base: &Path<'_, 'a, K>) -> bool {
        let last = beginning.new.len() - 1;
        let rough = |path| self.is_rough(path, last);
        last > 0 && !is_atom(base, last) && rough(base) && rough(&beginning.new)
    }

    fn is_rough(&self, path: &Path<'_, 'a, K>, i: usize) -> bool {
        path.vertex(i).is_some_and(|vertex| self.world.roughness(&vertex) >= self.rough)
    }
}

/// Whether a path leaves vertex `i` in a single direction.
fn is_atom<K: SceneKind>(path: &Path<'_, '_, K>, i: usize) -> bool {
    path.view().carries(i, Dirac::Direction)
}
