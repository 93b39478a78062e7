//! The mutations of Metropolis light transport in path space (Veach and Guibas 1997), each a function from a path
//! to a path. No densities of mutations are written here or anywhere.
//!
//! Perturbations follow chains of smooth surfaces: at mirrors and panes each new vertex scatters by the lobe by
//! which the old one did, at rough ones of small roughness by nearly the same half vector, reflected or refracted
//! as it was.

use std::ops::RangeInclusive;

use aether_core::mutation::{Decisions, Draft, Mutation};
use aether_core::prelude::*;
use aether_core::{PathView, RandomSequence, strategies};
use glam::Vec3 as Vector;

use crate::emission::{SampleEmission, SampleEmitter};
use crate::half_vectors::{HalfVector, SampleHalfVector, sample_half_vector};
use crate::kind::{Everything, SceneKind};
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
        // Few are replaced, or all of them.
        let replaced = |i: usize| if i + 1 == n { 0.25 } else { halved(i) };
        let old = decide.weighted(n, replaced)? + 1;
        let first = decide.index(n - old + 1)?;
        decide.replaces(first..first + old).then_some(())?;
        let new = decide.weighted(old + 3, |new| {
            let fits = self.lengths.contains(&(n - old + new));
            if fits { halved(new.abs_diff(old)) } else { 0.0 }
        })?;
        decide.wants(n - old + new).then_some(())?;
        let from_camera = decide.index(new + 1)?;

        let mut camera = path.slice(0..first).keep();
        for _ in 0..from_camera {
            let step = camera_step::<K, MutationStrategies<'a, K>>;
            camera.append(step(world, camera.size(), Aim::Film, u32::MAX));
        }
        // No light path hits the eye.
        (camera.size() > 0).then_some(())?;
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

/// One half, so often multiplied with itself, and hardly less than 1e-19.
fn halved(times: usize) -> f32 {
    1.0 / (1_u64 << times.min(63)) as f32
}

/// Moves the film point a little, follows smooth surfaces to the first vertex that is rough, and goes on where the
/// old path went. With `chains`, also where that meets further smooth surfaces: the direction into each chain of
/// them is moved a little as well.
pub struct LensPerturbation<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// Whether chains of smooth surfaces beyond the first are perturbed: the multi-chain perturbation.
    pub chains: bool,
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
        let film = world.film_point(&path.vertex(0)?, &path.vertex(1)?)?;
        let far = (0.05 * world.pixels() as f32 / std::f32::consts::PI).sqrt().max(0.2);
        let mut draft = path.slice(0..1).keep();
        draft.append(sample_camera_direction(world, Aim::Near(film, far)));
        follow(world, path, &mut draft);
        while draft.size() < n && is_smooth(world, path, draft.size()) {
            if !self.chains {
                return None;
            }
            let (here, next) = (path.vertex(draft.size() - 1)?, path.vertex(draft.size())?);
            draft.append(sample_near(world, next.direction_from(here.position)));
            follow(world, path, &mut draft);
        }
        Some(draft.concat(&path.slice(draft.size()..n).keep()))
    }

    /// Paths with further chains of smooth surfaces are for one of the two, all others for the other.
    fn weight(&self, path: &Path<'_, 'a, K>) -> f32 {
        let smooth = |i: usize| is_smooth(self.world, path, i);
        let first = (1..path.len()).find(|i| !smooth(*i)).unwrap_or(path.len());
        let further = smooth(first + 1);
        f32::from(further == self.chains)
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
        decide.wants(n).then_some(())?;
        let origin = self.origin(path)?;
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
fn is_smooth<K: SceneKind>(world: &World<'_, K>, path: &Path<'_, '_, K>, i: usize) -> bool {
    let inside = i > 0 && i + 1 < path.len();
    let few = || path.vertex(i).is_some_and(|vertex| world.roughness(&vertex) < ROUGH);
    inside && (is_atom(path, i) || few())
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
