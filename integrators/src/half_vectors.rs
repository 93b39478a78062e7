//! Scattering by a half vector that is close to a given one: what shifts copy and perturbations change.

use aether_core::PathView;
use aether_core::prelude::*;

use crate::kind::SceneKind;
use crate::samplers::{rotate, square_of_directions};
use crate::scattering::facets::{reflect, refract_in, refract_out};
use crate::vertex::{SceneVertex, Seen};
use crate::world::World;

/// Half vectors about one, in the frame of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfVector {
    /// The middle one.
    pub about: Direction<f32>,
    /// Whether light is refracted there, and not reflected.
    pub refracts: bool,
    /// How far along two axes others are away from the middle one, as the tangent of an angle.
    pub width: f32,
}

impl HalfVector {
    /// The half vector by which a path scatters at `here`; `None` if there is none, because it passes straight
    /// through the surface.
    pub fn between<K: SceneKind>(
        world: &World<'_, K>,
        [before, here, next]: [&SceneVertex<K>; 3],
        width: f32,
    ) -> Option<Self> {
        let scattering = world.scattering(here, before)?;
        let (view, along) = (scattering.pose.view(), next.direction_from(here.position));
        let w = Direction::from_vec(scattering.pose.frame().to_local(along));
        let refracts = w.z < 0.0;
        let mut middle = None;
        let found = |h: Direction<f32>, exists: bool| {
            if exists {
                middle = Some(h);
            }
        };
        if !refracts {
            reflect(view).preimages(&w, found);
        } else {
            let eta = scattering.refracting_facets()?;
            if eta >= 1.0 {
                refract_in(view, 1.0 / eta).ok()?.preimages(&w, found);
            } else {
                refract_out(view, 1.0 / eta).ok()?.preimages(&w, found);
            }
        }
        middle.map(|about| HalfVector { about, refracts, width })
    }
}

/// Scatters by one of some half vectors, whatever the material makes of it, and finds what the ray meets. The
/// middle of all uniforms is the middle half vector.
#[strategy]
pub fn sample_half_vector<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    half: HalfVector,
) -> SceneVertex<K> {
    let here = given(path.last());
    let before = given(path.back(1));
    let scattering = given(world.scattering(&here, &before));
    let (frame, view) = (scattering.pose.frame(), scattering.pose.view());
    let square = given(square_of_directions(half.width).ok());
    let local = draw(square);
    let m = rotate(Frame::around(half.about)).apply(&local);
    let w = if !half.refracts {
        rotate(frame).apply(&reflect(view).apply(&m))
    } else {
        let eta = given(scattering.refracting_facets());
        if eta >= 1.0 {
            let refraction = given(refract_in(view, 1.0 / eta).ok());
            rotate(frame).apply(&refraction.apply(&m))
        } else {
            let refraction = given(refract_out(view, 1.0 / eta).ok());
            rotate(frame).apply(&refraction.apply(&m))
        }
    };
    let seen: Seen<K> = constant(world.cast(&here, &w));
    match seen {
        Seen::Surface(hit) => {
            let point = hit.seen_from(here.position).apply(&w);
            SceneVertex::hit(hit, point)
        }
        Seen::Sky(sky) => SceneVertex::sky(sky, w),
    }
}
