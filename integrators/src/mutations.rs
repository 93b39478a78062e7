//! The mutations of Metropolis light transport in path space (Veach and Guibas 1997), each a function from a path
//! to a path. No densities of mutations are written here or anywhere.
//!
//! Perturbations follow chains of smooth surfaces: at mirrors and panes each new vertex scatters by the lobe by
//! which the old one did, at rough ones of small roughness by nearly the same half vector, reflected or refracted
//! as it was.

use std::ops::RangeInclusive;

use aether_core::mutation::{Decisions, Draft, Mutation};
use aether_core::prelude::*;
use aether_core::strategy::Dirac;
use aether_core::{PathView, RandomSequence, strategies};
use glam::Vec3 as Vector;

use crate::emission::{SampleEmission, SampleEmitter};
use crate::half_vectors::{HalfVector, SampleHalfVector, sample_half_vector};
use crate::kind::{Everything, Presence, SceneKind, Specular};
use crate::samplers::{cone_near, rotate};
use crate::strategies::{
    Aim, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf,
    sample_camera_direction, sample_light,
};
use crate::subpaths::{camera_step, is_atom, light_step};
use crate::vertex::{SceneVertex, Surface};
use crate::world::World;

/// What a ray from the last vertex meets first, at an angle between a ten-thousandth and a tenth to a
/// direction; near ones are likelier.
#[strategy]
pub fn sample_near<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    towards: Vector,
) -> SceneVertex<K> {
    let here = given(path.last());
    let cone = given(cone_near(1e-4, 0.1).ok());
    let local = draw(cone);
    let w = rotate(Frame::around(Direction::from_unit(towards.into()))).apply(&local);
    let seen: Surface<K> = constant(world.hit(&here, &w));
    let point = seen.seen_from(here.position).apply(&w);
    SceneVertex::hit(seen, point)
}

strategies! {
    /// How paths are made and mutated.
    #[derive(Clone)]
    pub enum MutationStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
        /// The eye.
        Camera(SampleCamera<'a, 'a, K>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a, K>),
        /// Scattering.
        Bsdf(SampleBsdf<'a, 'a, K>),
        /// Next-event estimation.
        Light(SampleLight<'a, 'a, K>),
        /// The start of a path at a light.
        Emitter(SampleEmitter<'a, 'a, K>),
        /// The first surface lit.
        Emission(SampleEmission<'a, 'a, K>),
        /// Next to an old direction.
        Near(SampleNear<'a, 'a, K>),
        /// Scattering by nearly an old half vector.
        HalfVector(SampleHalfVector<'a, 'a, K>),
    }
}

type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, MutationStrategies<'a, K>>;
type Proposal<'r, 'a, K> = Draft<'r, SceneVertex<K>, MutationStrategies<'a, K>>;

/// Replaces some vertices of a path by new ones, from the camera and from the light: the only mutation that
/// reaches every path.
pub struct BidirectionalMutation<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// The fewest and the most vertices of a path.
    pub lengths: RangeInclusive<usize>,
}

impl<'a, K: SceneKind> Mutation<SceneVertex<K>, MutationStrategies<'a, K>>
    for BidirectionalMutation<'a, K>
{
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, K>,
        decide: &mut Decisions<'_, f32>,
    ) -> Option<Proposal<'r, 'a, K>> {
        let (n, world) = (path.len(), self.world);
        let purpose = decide.purpose();
        // An eye that is always the same stays, which saves proposals that change nothing.
        let begin = usize::from(path.view().carries(0, Dirac::Position));
        let most = n - begin;
        let replaced = |i: usize| if i + 1 == most { ALL } else { halved(i) };
        let old = decide.weighted_among(most, replaced, |i| purpose.replaces_so_many(i + 1))? + 1;
        let is_replaced = |i: usize| purpose.replaces(begin + i..begin + i + old);
        let first = begin + decide.weighted_among(most - old + 1, |_| 1.0, is_replaced)?;
        let size = |new: usize| n - old + new;
        let added = |new: usize| {
            let fits = self.lengths.contains(&size(new));
            if fits { halved(new.abs_diff(old)) } else { 0.0 }
        };
        let new = decide.weighted_among(old + 3, added, |new| purpose.wants(size(new)))?;
        // No light path hits the eye.
        let least = usize::from(first == 0);
        let from_camera = least + decide.index((new + 1).saturating_sub(least))?;

        let mut camera = path.slice(0..first).keep();
        for _ in 0..from_camera {
            let step = camera_step::<K, MutationStrategies<'a, K>>;
            camera.append(step(world, camera.size(), Aim::Film, u32::MAX));
        }
        let mut light = path.slice(first + old..n).reverse().keep();
        if light.size() == 0 && new - from_camera == 1 && camera.size() >= 2 {
            camera.append(sample_light(world));
            return Some(camera);
        }
        for _ in from_camera..new {
            let step = light_step::<K, MutationStrategies<'a, K>>(world, light.size(), u32::MAX);
            light.append(step);
        }
        Some(camera.concat(&light.reverse()))
    }
}

/// How often all vertices are replaced, as one is once, two are half as often, and so on: a path that hardly anything else
/// changes is left by this.
///
/// With a quarter the relMSE of `aether render --integrator mlt --spp 16` of Mitsuba's Cornell box is 1.9e-2, with one 1.76e-2,
/// with four 1.77e-2 (before a perturbation moved two vertices).
const ALL: f32 = 1.0;

/// How often the lens or multi-chain perturbation that fits a path is used, as the bidirectional mutation is once, and the caustic
/// perturbation where there is one.
///
/// Veach (1997, section 11.5) uses all alike. Of the same image with 64 mutations a pixel the relMSE is 5.3e-3 with one lens
/// perturbation for each bidirectional mutation, 3.9e-3 with 2.5, 3.4e-3 with five and 3.5e-3 with ten.
const PERTURBED: f32 = 5.0;

/// The area about the old film point, over that of the image, in which film points are moved.
///
/// Veach (1997, section 11.4.3) has a twentieth. Of the same image with 64 mutations a pixel the relMSE is 3.8e-3 then, with a
/// hundredth 3.4e-3, and with two thousandths 3.3e-3; of others it is hardly different (those of textured halls are better with more).
const MOVED_FILM: f32 = 0.01;

/// One half, so often multiplied with itself, and hardly less than 1e-19.
fn halved(times: usize) -> f32 {
    1.0 / (1_u64 << times.min(63)) as f32
}

/// Moves the film point a little, follows smooth surfaces to the first vertex that is rough, and goes on where the
/// old path went; or goes on in nearly the old direction, to the next vertex that is rough, and only then where the old path
/// went. With `chains`, for paths that meet further smooth surfaces: the direction into each chain of them is moved a little as well.
///
/// That the second vertex is moved, too, is not in Veach's list. Where two vertices lie close together in a corner, the path is
/// as bright as they are close, and almost no path that keeps one of them is as bright; moved along together they stay so.
pub struct LensPerturbation<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// Whether chains of smooth surfaces beyond the first are perturbed: the multi-chain perturbation.
    pub chains: bool,
}

impl<K: SceneKind> LensPerturbation<'_, K> {
    /// Which may be the first vertex that stays, behind the eye; `None` if the path is for the other of the two.
    fn ends(&self, path: &Path<'_, '_, K>) -> Option<[Option<usize>; 2]> {
        let smooth = |i: usize| is_smooth(self.world, path, i);
        // Behind a chain, and the rough surface that it leads to.
        let behind = |from: usize| (from..path.len()).find(|i| !smooth(*i)).map(|i| i + 1);
        let first = behind(1)?;
        let mut further = behind(first);
        while let Some(end) = further.filter(|end| smooth(*end)) {
            further = behind(end);
        }
        (smooth(first) == self.chains).then_some([Some(first).filter(|_| !self.chains), further])
    }
}

impl<'a, K: SceneKind> Mutation<SceneVertex<K>, MutationStrategies<'a, K>>
    for LensPerturbation<'a, K>
{
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, K>,
        decide: &mut Decisions<'_, f32>,
    ) -> Option<Proposal<'r, 'a, K>> {
        let (n, world) = (path.len(), self.world);
        decide.wants(n).then_some(())?;
        let (ends, purpose) = (self.ends(path)?, decide.purpose());
        let fits = |which: usize| f32::from(ends[which].is_some());
        let is_replaced = |which: usize| ends[which].is_some_and(|end| purpose.replaces(1..end));
        let end = ends[decide.weighted_among(2, fits, is_replaced)?]?;
        let film = world.film_point(&path.vertex(0)?, &path.vertex(1)?)?;
        // More than the pixel by which it moves at least.
        let far = (MOVED_FILM * world.pixels() as f32 / std::f32::consts::PI).sqrt().max(2.0);
        let mut draft = path.slice(0..1).keep();
        draft.append(sample_camera_direction(world, Aim::Near(film, far)));
        follow(world, path, &mut draft);
        while draft.size() < end {
            let (here, next) = (path.vertex(draft.size() - 1)?, path.vertex(draft.size())?);
            draft.append(sample_near(world, next.direction_from(here.position)));
            follow(world, path, &mut draft);
        }
        Some(draft.concat(&path.slice(end..n).keep()))
    }

    fn weight(&self, path: &Path<'_, 'a, K>) -> f32 {
        PERTURBED * f32::from(self.ends(path).is_some())
    }
}

/// Moves a little the direction in which light enters a chain of smooth surfaces that leads to the first vertex seen, and
/// connects what it meets to the camera: for caustics.
pub struct CausticPerturbation<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
}

impl<'a, K: SceneKind> CausticPerturbation<'a, K> {
    /// Where the chain that leads to the first vertex seen begins, if there is one.
    fn origin(&self, path: &Path<'_, 'a, K>) -> Option<usize> {
        let (n, smooth) = (path.len(), |i: usize| is_smooth(self.world, path, i));
        if n < 4 || smooth(1) || !smooth(2) {
            return None;
        }
        let origin = (3..n).find(|i| !smooth(*i))?;
        let vertex = path.vertex(origin)?;
        (!vertex.is_infinite()).then_some(origin)
    }
}

impl<'a, K: SceneKind> Mutation<SceneVertex<K>, MutationStrategies<'a, K>>
    for CausticPerturbation<'a, K>
{
    fn propose<'r>(
        &self,
        path: &Path<'r, 'a, K>,
        decide: &mut Decisions<'_, f32>,
    ) -> Option<Proposal<'r, 'a, K>> {
        let (n, world) = (path.len(), self.world);
        let origin = self.origin(path)?;
        (decide.wants(n) && decide.replaces(1..origin)).then_some(())?;
        let (here, next) = (path.vertex(origin)?, path.vertex(origin - 1)?);
        let backwards = path.reverse();
        let mut draft = backwards.slice(0..n - origin).keep();
        draft.append(sample_near(world, next.direction_from(here.position)));
        follow(world, &backwards, &mut draft);
        (draft.size() + 1 == n).then_some(())?;
        Some(path.slice(0..1).keep().concat(&draft.reverse()))
    }

    fn weight(&self, path: &Path<'_, 'a, K>) -> f32 {
        f32::from(self.origin(path).is_some())
    }
}

/// Surfaces with less roughness than this belong to chains.
const ROUGH: f32 = 0.2;
/// How far half vectors are moved, in units of the roughness.
const MOVED: f32 = 0.1;

/// Whether a vertex of a path scatters in a single direction, or in few: none of its ends.
#[inline]
fn is_smooth<K: SceneKind>(world: &World<'_, K>, path: &Path<'_, '_, K>, i: usize) -> bool {
    let inside = || i > 0 && i + 1 < path.len();
    let single = || Specular::<K>::VALUE.is_some() && is_atom(path, i);
    let few = || {
        world.least_roughness() < ROUGH
            && path.vertex(i).is_some_and(|vertex| world.roughness(&vertex) < ROUGH)
    };
    inside() && (single() || few())
}

/// Goes on from the last vertex of a draft as long as the vertices of the path at these places are smooth.
fn follow<'a, K: SceneKind>(
    world: &'a World<'a, K>,
    path: &Path<'_, 'a, K>,
    draft: &mut Proposal<'_, 'a, K>,
) {
    while is_smooth(world, path, draft.size() - 1) {
        let i = draft.size() - 1;
        let [before, here, next] = [i - 1, i, i + 1].map(|i| path.vertex(i));
        let (Some(before), Some(here), Some(next)) = (before, here, next) else { return };
        if is_atom(path, i) {
            let Some(lobe) = world.mirror_between(&before, &here, &next) else { return };
            draft.append(sample_bsdf(world, u32::MAX, Some(lobe)));
        } else {
            let width = (MOVED * world.roughness(&here)).clamp(1e-6, 1.0);
            let nearly = HalfVector::between(world, [&before, &here, &next], width);
            let Some(half) = nearly else { return };
            draft.append(sample_half_vector(world, half));
        }
    }
}
