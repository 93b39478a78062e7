//! How paths that start at lights begin: the point of a light, and the first surface that it shines on.

use aether_core::prelude::*;
use aether_core::{PathView, strategies};

use crate::kind::{Everything, Presence, SceneKind};
use crate::lights::{Form, Light};
use crate::samplers::*;
use crate::scene::{Primitive, Rectangle};
use crate::strategies::{SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight};
use crate::vertex::{Lamp, Place, SceneVertex, Surface, light_id};
use crate::world::World;

/// A light, chosen by its power, and a point on it, or a direction of the sky.
#[strategy]
pub fn sample_emitter<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
) -> SceneVertex<K> {
    let lights = given(world.lights.choice.as_ref());
    let light = choose(lights).identified_by(|v: &SceneVertex<K>| world.lights.index_of(v));
    match light {
        Light::Area(light) => {
            let light = K::Area::get_ref(light);
            let id = light_id(light.index);
            let point = match light.shape {
                Form::Rectangle(Rectangle { corner, a, b }) => {
                    draw(uniform_rectangle(corner.into(), a.into(), b.into(), id))
                }
                Form::Single(Primitive::Triangle { v0, v1, v2 }) => {
                    draw(uniform_triangle(v0.into(), v1.into(), v2.into(), id))
                }
                Form::Single(Primitive::Sphere { center, radius, .. }) => {
                    draw(uniform_sphere_surface(center.into(), radius, id))
                }
                Form::Single(Primitive::Cylinder { base, axis, radius, .. }) => {
                    let frame = Frame::around(Direction::from_vec(axis.into()));
                    draw(uniform_cylinder(base.into(), frame, axis.length(), radius, id))
                }
                Form::Single(Primitive::Disk { center, u_axis, v_axis, .. }) => {
                    draw(uniform_disk(center.into(), u_axis.into(), v_axis.into(), id))
                }
            };
            SceneVertex::on(world.light_surface(light, point.position.into()))
        }
        Light::Sky(sky) => {
            let w = draw(uniform_directions());
            SceneVertex::sky(K::Constant::get(*sky), w)
        }
        Light::Picture(sky) => {
            let picture = given(world.lights.picture.as_ref());
            let w = draw(picture.directions());
            SceneVertex::sky(K::Envmap::get(*sky), w)
        }
        Light::Bulb(bulb) => {
            let lamp: Lamp<K> = constant(Some(Lamp::Bulb(*bulb)));
            SceneVertex::lamp(lamp)
        }
        Light::Distant(distant) => {
            let lamp: Lamp<K> = constant(Some(Lamp::Distant(*distant)));
            SceneVertex::lamp(lamp)
        }
    }
}

/// The first surface that a light shines on from the last vertex: by the cosine from a surface, in all
/// directions or within its cone from a point, and from infinitely far away through a disk that the scene
/// lies behind.
#[strategy]
pub fn sample_emission<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
) -> SceneVertex<K> {
    let here = given(path.last());
    let w = match here.place {
        Place::Camera | Place::Parallel(_) | Place::Backdrop(_) => return stop(),
        Place::Sky(_) | Place::Distant(_) => {
            let window = world.window(here.position);
            let p = draw(disk(world.lights.bounds.1));
            let lit: Surface<K> = constant(world.shone_on(&window, &p));
            let through = lit.seen_by(&window).apply(&p);
            return SceneVertex::hit(lit, through);
        }
        Place::Surface(surface) => {
            let local = draw(cosine_hemisphere());
            rotate(Frame::around(Direction::from_unit(surface.normal.into()))).apply(&local)
        }
        Place::Bulb(index) => {
            let bulb = &world.scene.bulbs[K::Point::get(index) as usize];
            match bulb.narrow_cone() {
                Some((axis, depth)) => {
                    let directions = given(uniform_cone(depth).ok());
                    let local = draw(directions);
                    rotate(Frame::around(axis)).apply(&local)
                }
                None => draw(uniform_directions()),
            }
        }
    };
    let seen: Surface<K> = constant(world.hit(&here, &w));
    let point = seen.seen_from(here.position).apply(&w);
    SceneVertex::hit(seen, point)
}

strategies! {
    /// How paths are made from both ends.
    #[derive(Clone)]
    pub enum LightStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
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
    }
}
