//! What is integrated: the light transport along a path, apart from how it was sampled.

use aether_core::prelude::*;
use aether_core::{PathIntegrand, PathView, Vertex};
use glam::Vec3;

use crate::samplers::{pinhole, rotate};
use crate::strategies::Pixel;
use crate::vertex::SceneVertex;
use crate::world::World;

/// The measurement of one pixel as an integral over paths with area measure (Veach 1997, Eq. 8.7):
/// importance of the filter, geometry terms with visibility, scattering, emission.
pub struct Radiance<'w, 's> {
    world: &'w World<'s>,
    pixel: Pixel,
}

impl<'w, 's> Radiance<'w, 's> {
    /// The integrand of a pixel.
    pub fn new(world: &'w World<'s>, pixel: Pixel) -> Self {
        Radiance { world, pixel }
    }

    /// Whether the segment between the last two vertices is free.
    fn sees(&self, path: &PathView<'_, SceneVertex>, from: &SceneVertex, to: &SceneVertex) -> bool {
        path.visible(path.len() - 1)
            || self.world.scene.visible(
                from.position,
                from.primitive(),
                to.position,
                to.primitive(),
            )
    }

    /// The importance that the pinhole sends to a surface: the filter at the film point that looks
    /// there, per film area, brought to surface area by the derived change of measure.
    fn importance(&self, eye: &SceneVertex, seen: &SceneVertex) -> f32 {
        let Some(surface) = seen.surface else { return 0.0 };
        let to_surface = pinhole(self.world.film_centre(), self.world.film_scale())
            .then(rotate(self.world.camera_frame))
            .then(surface.seen_from(eye.position));
        let filter = self.world.scene.film.filter;
        let centre = (self.pixel.0 as f32 + 0.5, self.pixel.1 as f32 + 0.5);
        // A point that the filter's rim was sampled for may come back on the other side of it.
        let (reach, error) = (filter.radius(), self.film_error(eye, seen));
        let profile = |x: f32, error: f32| {
            filter.profile(if x.abs() <= reach + error { x.clamp(-reach, reach) } else { x })
        };
        let mut importance = 0.0;
        to_surface.preimages(&seen.point(), |film: Vec2<f32>, exists| {
            let response =
                profile(film.x - centre.0, error.x) * profile(film.y - centre.1, error.y);
            if exists && response > 0.0 {
                importance += response * self.world.filter_scale / to_surface.jacobian(&film);
            }
        });
        importance
    }

    /// By how much rounding of the surface point and of its direction can move a film point, in pixels:
    /// much only for long lenses.
    fn film_error(&self, eye: &SceneVertex, seen: &SceneVertex) -> Vec2<f32> {
        let size = eye.position.abs().max_element() + seen.position.abs().max_element();
        let angle = 8.0 * f32::EPSILON * (1.0 + size / seen.position.distance(eye.position));
        let scale = self.world.film_scale();
        Vec2::new(angle / scale.x, angle / scale.y)
    }

    /// Scattering at `here` between its neighbours, times the cosines and inverse square distance of
    /// the edge to `next`.
    fn transport(&self, before: &SceneVertex, here: &SceneVertex, next: &SceneVertex) -> Vec3 {
        let (Some(surface), Some(target)) = (here.surface, next.surface) else { return Vec3::ZERO };
        let Some(lambert) = self.world.scattering(&surface, before.position) else {
            return Vec3::ZERO;
        };
        let edge = next.position - here.position;
        let (squared, along) = (edge.length_squared(), edge.normalize_or_zero());
        let cosine = lambert.normal.dot(along).max(0.0);
        let geometry = cosine * target.normal.dot(along).abs() / squared;
        if geometry.is_finite() {
            lambert.albedo * (std::f32::consts::FRAC_1_PI * geometry)
        } else {
            Vec3::ZERO
        }
    }
}

impl PathIntegrand for Radiance<'_, '_> {
    type Vertex = SceneVertex;
    type Value = Vec3;

    fn extend(&self, path: PathView<'_, SceneVertex>) -> Vec3 {
        let (Some(new), Some(here)) = (path.back(0), path.back(1)) else { return Vec3::ONE };
        let factor = match path.back(2) {
            None => Vec3::splat(self.importance(&here, &new)),
            Some(before) => self.transport(&before, &here, &new),
        };
        // The shadow ray comes last: most factors that vanish do so without it.
        if factor != Vec3::ZERO && self.sees(&path, &here, &new) { factor } else { Vec3::ZERO }
    }

    fn end(&self, path: PathView<'_, SceneVertex>) -> Vec3 {
        match (path.back(0), path.back(1)) {
            (Some(last), Some(before)) => self.world.emitted(&last, before.position),
            _ => Vec3::ZERO,
        }
    }
}
