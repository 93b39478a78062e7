//! Openings that light has to pass, and segments of paths through them (Aether 2017, section 7.4).

use aether_core::discrete::{Choices, discrete_weighted};
use aether_core::pairs::{on_first, on_second};
use aether_core::prelude::*;
use aether_core::{PathView, strategies};
use glam::Vec3 as Vector;

use crate::daylight::{Opening, SampleEmissionAndOpenings, SampleLightAndOpenings};
use crate::emission::{SampleEmission, SampleEmitter};
use crate::kind::{Everything, SceneKind};
use crate::samplers::rotate;
use crate::scene::Scene;
use crate::strategies::{SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight};
use crate::vertex::{SceneVertex, Surface};
use crate::world::World;

/// A triangle that light passes towards one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Portal {
    /// The corner that its coordinates start from.
    corner: Vector,
    /// Its normal is z.
    frame: Frame<f32>,
    /// The other corners.
    ends: [Vec2<f32>; 2],
}

impl Portal {
    /// A triangle; none without an area.
    fn new(corners: [Vector; 3]) -> Option<(Self, f32)> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        let area = 0.5 * normal.length();
        if area.is_nan() || area <= 0.0 {
            return None;
        }
        let frame = Frame::around(Direction::from_vec(normal.into()));
        let end = |p: Vector| {
            let local = frame.to_local(p - a);
            Vec2::new(local.x, local.y)
        };
        Some((Portal { corner: a, frame, ends: [end(b), end(c)] }, area))
    }

    /// A point of it in space.
    fn point(&self, p: &Vec2<f32>) -> Vector {
        self.corner + Vector::from(self.frame.to_world(aether_core::Vec3::new(p.x, p.y, 0.0)))
    }

    /// A direction in space.
    fn along(&self, w: &Direction<f32>) -> Vector {
        self.frame.to_world(*w).into()
    }

    /// The map from points of the portal to where light from a point `x` through them meets a surface.
    fn behind<K: SceneKind>(&self, x: &SurfacePoint<f32>, surface: &Surface<K>) -> Behind<f32> {
        let corner: aether_core::Vec3<f32> = self.corner.into();
        let from = self.frame.to_local(x.position - corner);
        let point = self.frame.to_local(surface.position - self.corner);
        let normal = self.frame.to_local(surface.normal);
        behind(from, point, normal, self.frame, corner, surface.id())
    }
}

/// The openings of a scene, chosen by their area; each counts for either side.
#[derive(Clone, Debug)]
pub struct Portals {
    choice: Choices<Vec<Portal>, Portal, f32>,
    /// Each once, chosen by area.
    pub(crate) openings: Choices<Vec<Opening>, Opening, f32>,
}

impl Portals {
    /// The triangles of shapes of a scene that were read as portals.
    ///
    /// # Errors
    /// If there is none.
    pub fn new(scene: &Scene) -> Result<Self, String> {
        let (mut portals, mut areas) = (Vec::new(), Vec::new());
        let (mut openings, mut sizes) = (Vec::new(), Vec::new());
        for &[v0, v1, v2] in &scene.portals {
            for corners in [[v0, v1, v2], [v0, v2, v1]] {
                let (portal, area) = Portal::new(corners).unzip();
                portals.extend(portal);
                areas.extend(area);
            }
            openings.push(Opening { corner: v0, sides: [v1 - v0, v2 - v0] });
            sizes.push(0.5 * (v1 - v0).cross(v2 - v0).length());
        }
        let none =
            |_| "the scene has no portal: name the shape of the opening, `--portal ID`".to_owned();
        let choice = discrete_weighted(portals, areas).map_err(none)?;
        let openings = discrete_weighted(openings, sizes).map_err(none)?;
        Ok(Portals { choice, openings })
    }
}

/// A point of the triangle with the corners 0, b and c, and a direction, distributed like its cosine.
#[sampler]
pub fn ray_through(u: [Uniform; 4], b: Vec2, c: Vec2) -> (Vec2, Direction) {
    let s = u[0].sqrt();
    let p = s * (1.0 - u[1]) * b + s * u[1] * c;
    let r = u[2].sqrt();
    let phi = TAU * u[3];
    (p, Direction::new(r * phi.cos(), r * phi.sin(), (1.0 - u[2]).sqrt()))
}

/// Where the line from a point `from` through the point (p, 0) meets a plane beyond it. All of these are
/// given in a frame about the place `at`, and the result in space.
#[map]
pub fn behind(
    p: Vec2,
    from: Vec3,
    point: Vec3,
    normal: Vec3,
    frame: Frame,
    at: Vec3,
    id: SurfaceId,
) -> SurfacePoint {
    let through = Vec3::new(p.x, p.y, 0.0) - from;
    let t = normal.dot(point - from) / normal.dot(through);
    require(t > 0.0);
    SurfacePoint::new(at + frame.to_world(from + t * through), id)
}

/// The ends of a segment through an opening: a ray through a point of it, followed to both sides.
#[strategy(connected = true)]
pub fn sample_portal<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    portals: &Portals,
) -> [SceneVertex<K>; 2] {
    let portal = choose(&portals.choice);
    let ray = draw(ray_through(portal.ends[0], portal.ends[1]));
    let front: Surface<K> = constant(world.trace(portal.point(&ray.0), portal.along(&ray.1), None));
    let back: Surface<K> = constant(world.trace(portal.point(&ray.0), -portal.along(&ray.1), None));
    let to_front = on_second(|p| rotate(portal.frame).then(front.seen_from(portal.point(p))));
    let to_back = on_first(|x: &SurfacePoint<f32>| portal.behind(x, &back));
    let ends = to_back.apply(&to_front.apply(&ray));
    [SceneVertex::hit(back, ends.0), SceneVertex::hit(front, ends.1)]
}

strategies! {
    /// How paths are made from both ends and from openings between them.
    #[derive(Clone)]
    pub enum PortalStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
        /// The pinhole.
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
        /// Next-event estimation, of the sky through openings.
        LightAndOpenings(SampleLightAndOpenings<'a, 'a, 'a, K>),
        /// The first surface lit, from far away through openings.
        EmissionAndOpenings(SampleEmissionAndOpenings<'a, 'a, 'a, K>),
        /// A segment through an opening.
        Portal(SamplePortal<'a, 'a, 'a, K>),
    }
}
