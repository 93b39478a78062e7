//! What a pixel sees, apart from light: albedo, normal and depth of the first surface, for denoisers and for
//! looking at.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::image::RgbImage;
use crate::kind::{Everything, NotCovered};
use crate::render::{AnyKernel, Budget, Observer, RenderSettings, Worker, render};
use crate::scene::Scene;
use crate::strategies::PathStrategies;
use crate::subpaths::{Scratch, camera_path};
use crate::uniforms::Uniforms;
use crate::vertex::SceneVertex;
use crate::world::World;

/// A property of the first surface that a pixel sees, averaged over the pixel like its light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// The share of light that is scattered, of each channel.
    Albedo,
    /// The unit normal for shading, in world space.
    Normal,
    /// The distance from the camera, or from the film of a parallel projection, in all channels.
    Depth,
}

impl Aov {
    /// Each with the name of its channels.
    pub const ALL: [(&str, Aov); 3] =
        [("albedo", Aov::Albedo), ("normal", Aov::Normal), ("depth", Aov::Depth)];

    /// The value at a vertex that is seen from another; zero where there is no surface.
    fn of(self, world: &World<'_, Everything>, seen: &SceneVertex, eye: &SceneVertex) -> Vec3 {
        let Some(surface) = seen.surface() else { return Vec3::ZERO };
        match self {
            Aov::Albedo => world.scattering(seen, eye).map_or(Vec3::ZERO, |s| s.albedo()),
            Aov::Normal => surface.shading,
            Aov::Depth => Vec3::splat(match world.parallel() {
                Some(film) => (seen.position - film.origin).dot(film.forward),
                None => seen.position.distance(eye.position),
            }),
        }
    }
}

struct AovKernel<'w, 's> {
    world: &'w World<'s>,
    aov: Aov,
    seed: u64,
}

impl AnyKernel for AovKernel<'_, '_> {
    fn worker(&self) -> Worker<'_> {
        let world = self.world;
        let width = u64::from(world.scene.film.width);
        let mut scratch = Scratch::<Everything, PathStrategies<'_>>::new(world);
        Box::new(move |pixel, sample, _| {
            scratch.arena.clear();
            let stream = u64::from(pixel.1) * width + u64::from(pixel.0);
            let uniforms = &mut Uniforms::independent(self.seed, stream, u64::from(sample));
            let path = camera_path(world, &scratch.arena, uniforms, pixel, (2, 0));
            let (Some(eye), Some(seen)) = (path.vertex(0), path.vertex(1)) else { return [0.0; 3] };
            let value = self.aov.of(world, &seen, &eye);
            if value.is_finite() { value.to_array() } else { [0.0; 3] }
        })
    }
}

/// The images of all properties, by the names of their channels, from so many samples of each pixel.
///
/// # Errors
/// If the scene needs what no kind has.
pub fn aovs(
    scene: &Scene,
    settings: RenderSettings,
    samples: u32,
    seed: u64,
    observer: &dyn Observer,
) -> Result<BTreeMap<String, RgbImage>, NotCovered> {
    let settings = RenderSettings { budget: Budget::Samples(samples), layered: 0, ..settings };
    let world = &World::new(scene)?;
    let image = |(name, aov): (&str, Aov)| {
        let kernel = AovKernel { world, aov, seed };
        (name.to_owned(), render(&kernel, &settings, observer).film.image())
    };
    Ok(Aov::ALL.into_iter().map(image).collect())
}
