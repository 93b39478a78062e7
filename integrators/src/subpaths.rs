//! Pieces of paths, from the camera and from the lights, that several integrators begin with.

use aether_core::estimator::{Estimator, Factors};
use aether_core::strategy::Dirac;
use aether_core::{Arena, RandomSequence, Snapshot, Strategy, UniformSource};
use glam::Vec3;

use crate::emission::{
    LightStrategies, SampleEmission, SampleEmitter, sample_emission, sample_emitter,
};
use crate::integrand::Radiance;
use crate::kind::SceneKind;
use crate::render::{Cancelled, Technique};
use crate::strategies::{
    Aim, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf, sample_camera,
    sample_camera_direction, sample_light,
};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::world::World;

/// A path of a scene's vertices.
pub type Path<'r, K, S> = RandomSequence<'r, SceneVertex<K>, S>;

/// What one thread reuses from sample to sample: the paths, and what is known of the light that they carry.
pub struct Scratch<'a, K: SceneKind, S> {
    /// The paths of one sample.
    pub arena: Arena<SceneVertex<K>, S>,
    /// The estimator of radiance.
    pub estimator: Estimator<Radiance<'a, 'a, K>, Factors<Vec3>>,
}

impl<'a, K: SceneKind, S: Strategy<SceneVertex<K>>> Scratch<'a, K, S> {
    /// Without anything.
    pub fn new(world: &'a World<'a, K>) -> Self {
        Self::with(Radiance::new(world))
    }

    /// With some integrand.
    pub fn with(integrand: Radiance<'a, 'a, K>) -> Self {
        Scratch { arena: Arena::new(), estimator: Estimator::paths(integrand) }
    }
}

/// A set of strategies with those of paths from the camera.
pub trait FromCamera<'a, K: SceneKind>:
    Strategy<SceneVertex<K>>
    + From<SampleCamera<'a, 'a, K>>
    + From<SampleCameraDirection<'a, 'a, K>>
    + From<SampleBsdf<'a, 'a, K>>
{
}

impl<'a, K: SceneKind, S> FromCamera<'a, K> for S where
    S: Strategy<SceneVertex<K>>
        + From<SampleCamera<'a, 'a, K>>
        + From<SampleCameraDirection<'a, 'a, K>>
        + From<SampleBsdf<'a, 'a, K>>
{
}

/// A set of strategies with those of paths from lights too, and of next-event estimation.
pub trait FromBothEnds<'a, K: SceneKind>:
    FromCamera<'a, K>
    + From<SampleEmitter<'a, 'a, K>>
    + From<SampleEmission<'a, 'a, K>>
    + From<SampleLight<'a, 'a, K>>
{
}

impl<'a, K: SceneKind, S> FromBothEnds<'a, K> for S where
    S: FromCamera<'a, K>
        + From<SampleEmitter<'a, 'a, K>>
        + From<SampleEmission<'a, 'a, K>>
        + From<SampleLight<'a, 'a, K>>
{
}

/// A path from the camera, of at most `longest` vertices. Russian roulette may end it from
/// the vertex number `rr_depth` on.
pub fn camera_path<'r, 'a, K: SceneKind, S: FromCamera<'a, K>>(
    world: &'a World<'a, K>,
    arena: &'r Arena<SceneVertex<K>, S>,
    uniforms: &mut impl UniformSource<f32>,
    aim: impl Into<Aim>,
    (longest, rr_depth): (usize, u32),
) -> Path<'r, K, S> {
    let mut path = arena.sequence();
    path.append(sample_camera(world));
    path.append(sample_camera_direction(world, aim.into())).sample(uniforms);
    *path.go_on(longest, sample_bsdf(world, rr_depth, None), uniforms)
}

/// A path from a light, of at most `longest` vertices.
pub fn light_path<'r, 'a, K: SceneKind, S: FromBothEnds<'a, K>>(
    world: &'a World<'a, K>,
    arena: &'r Arena<SceneVertex<K>, S>,
    uniforms: &mut impl UniformSource<f32>,
    (longest, rr_depth): (usize, u32),
) -> Path<'r, K, S> {
    let mut path = arena.sequence();
    for number in 0..2 {
        path.go_on(number + 1, light_step::<K, S>(world, number, rr_depth), uniforms);
    }
    *path.go_on(longest, light_step::<K, S>(world, 2, rr_depth), uniforms)
}

/// A light path without its strategies, which its vertices tell.
pub type LightPath<K> = Snapshot<SceneVertex<K>, ()>;

/// Some of the light paths that all pixels share in a sample, by their numbers, of at most `longest` vertices; fewer if
/// the render is cancelled. Russian roulette may end them from the vertex number `rr_depth` on.
pub fn shared_light_paths<K: SceneKind>(
    world: &World<'_, K>,
    (seed, sample): (u64, u32),
    (longest, rr_depth): (usize, u32),
    paths: std::ops::Range<usize>,
    cancelled: Cancelled<'_>,
) -> Vec<LightPath<K>> {
    let (mut arena, mut known) = (Arena::new(), Snapshot::<_, LightStrategies<K>>::new());
    let shoot = |k: usize| {
        arena.clear();
        let uniforms = &mut Uniforms::independent(seed, u64::MAX - k as u64, u64::from(sample));
        let light = light_path(world, &arena, uniforms, (longest, rr_depth));
        known.store(&light.slice(0..light.len()));
        // In memory of its own size, with nothing between: there may be millions.
        Snapshot::from_steps(known.steps().map(|(vertex, _, code)| (*vertex, (), code)))
    };
    paths.take_while(|_| !cancelled()).map(shoot).collect()
}

/// The strategy of the vertex with this number of a path from a light.
pub fn light_step<'a, K: SceneKind, S: FromBothEnds<'a, K>>(
    world: &'a World<'a, K>,
    number: usize,
    rr_depth: u32,
) -> S {
    match number {
        0 => sample_emitter(world).into(),
        1 => sample_emission(world).into(),
        _ => sample_bsdf(world, rr_depth, None).into(),
    }
}

/// The strategy of the vertex with this number of a path from the camera.
pub fn camera_step<'a, K: SceneKind, S: FromCamera<'a, K>>(
    world: &'a World<'a, K>,
    number: usize,
    aim: Aim,
    rr_depth: u32,
) -> S {
    match number {
        0 => sample_camera(world).into(),
        1 => sample_camera_direction(world, aim).into(),
        _ => sample_bsdf(world, rr_depth, None).into(),
    }
}

/// The first `t` vertices of a path from the camera and the first `s` of one from a light. Where that would be a
/// single vertex it is next-event estimation instead, which is still to be sampled.
pub fn connection<'r, 'a, K: SceneKind, S: FromBothEnds<'a, K>>(
    world: &'a World<'a, K>,
    camera: &Path<'r, K, S>,
    light: &Path<'r, K, S>,
    (s, t): (usize, usize),
) -> Path<'r, K, S> {
    let mut path = camera.slice(0..t);
    if s == 1 && t > 1 {
        return *path.append(sample_light(world));
    }
    path.concat(&light.slice(0..s).reverse())
}

/// The techniques that make paths of `length` vertices by an edge between the two pieces: by the number of vertices
/// from the camera, from one to all.
pub fn splits(length: usize) -> impl Iterator<Item = Technique> + Clone {
    (1..=length).map(move |camera| Technique::edge(camera, length - camera))
}

/// Whether a path leaves vertex `i` in a single direction, as at a mirror.
#[inline]
pub fn is_atom<K: SceneKind, S: Strategy<SceneVertex<K>>>(path: &Path<'_, K, S>, i: usize) -> bool {
    path.view().carries(i, Dirac::Direction)
}

/// Makes a path that has ended a technique for `size` vertices: it might have gone on.
pub fn extend<'a, K: SceneKind, S: FromCamera<'a, K>>(
    path: &mut Path<'_, K, S>,
    world: &'a World<'a, K>,
    (size, rr_depth): (usize, u32),
) {
    path.append_up_to(size, sample_bsdf(world, rr_depth, None));
}

/// The eye and what it sees of a path.
pub fn first_edge<K: SceneKind, S: Strategy<SceneVertex<K>>>(
    path: &Path<'_, K, S>,
) -> Option<[SceneVertex<K>; 2]> {
    let [eye, seen] = [0, 1].map(|i| path.vertex(i));
    if path.is_complete() { Some([eye?, seen?]) } else { None }
}
