//! How light paths are extended, one vertex at a time: the strategies of the surface renderer.
//!
//! Each is written for all kinds of scenes. What a kind leaves out has no values, so that the branches
//! for it are never taken and are not compiled into a program for that kind.

use aether_core::prelude::*;
use aether_core::{PathView, coin, strategies};

use crate::eye::LENS;
use crate::film_filter::ImagePoints;
use crate::kind::{Everything, Facetted, Interface, PhongOf, Presence, SceneKind};
use crate::lights::{Form, Light};
use crate::samplers::*;
use crate::scattering::Lobe;
use crate::scattering::facets::{HalfVectors, reflect, refract_in, refract_out};
use crate::scattering::fresnel;
use crate::scene::{Filter, Primitive, Rectangle};
use crate::seen::{cone_of, triangle_of};
use crate::vertex::{Eye, Lamp, SceneVertex, Seen, Surface, light_id};
use crate::world::World;

/// A pixel of the image: column and row.
pub type Pixel = (u32, u32);

/// By how many pixels film points are moved at least.
///
/// Veach (1997, section 11.4.3) begins with a tenth, but what stays in its pixel makes the image no better: of Mitsuba's Cornell
/// box with 16 mutations a pixel (`aether render --integrator mlt --spp 16`) the relMSE is 2.5e-2 with a tenth, 2.2e-2 with one.
const NEAR: f32 = 1.0;

/// How a point of the film is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    /// About a pixel, distributed like its reconstruction filter.
    Pixel(Pixel),
    /// About a pixel as well, with the density of the points of all pixels of the image, one of each: for samples that count for
    /// every pixel that sees them ([`ImagePoints`]).
    Image(Pixel),
    /// Anywhere that the filter of some pixel reaches.
    Film,
    /// Between a pixel and a distance away from a point; near ones are likelier.
    Near(Vec2<f32>, f32),
    /// Within half a pixel along each axis of a point; the middle of all uniforms is the point itself.
    About(Vec2<f32>),
}

impl Aim {
    /// The centre of the pixel.
    fn centre(&self) -> (f32, f32) {
        match self {
            Aim::Pixel(pixel) => (pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5),
            Aim::About(point) => (point.x, point.y),
            Aim::Film | Aim::Image(_) | Aim::Near(..) => (0.0, 0.0),
        }
    }
}

impl From<Pixel> for Aim {
    fn from(pixel: Pixel) -> Self {
        Aim::Pixel(pixel)
    }
}

/// The camera's eye: an atom for a pinhole and for a parallel projection, otherwise a point of the lens.
#[strategy]
pub fn sample_camera<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
) -> SceneVertex<K> {
    if let Some(lens) = world.lens() {
        let (centre, a, b) = (lens.centre.into(), lens.across.into(), lens.down.into());
        let point = draw(uniform_disk(centre, a, b, LENS));
        return SceneVertex::on_lens(point);
    }
    let eye: Eye<K> = constant(Some(world.eye()));
    SceneVertex::eye(eye)
}

/// A point of the film, and what the camera sees there.
#[strategy]
pub fn sample_camera_direction<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    aim: Aim,
) -> SceneVertex<K> {
    let eye = given(path.last());
    let (x, y) = aim.centre();
    let film = match (aim, world.scene.film.filter) {
        (Aim::Film, _) => {
            let (corner, size) = world.reachable_film();
            draw(film_rectangle(corner, size))
        }
        (Aim::Near(from, far), _) => {
            let around = given(film_near(from, NEAR, far).ok());
            draw(around)
        }
        (Aim::Image(pixel), _) => draw(ImagePoints::new(world.film_profile(), pixel)),
        (Aim::About(_), _) | (Aim::Pixel(_), Filter::Box) => draw(film_box(x, y)),
        (Aim::Pixel(_), Filter::Tent { radius }) => {
            let right = choose(coin(0.5f32));
            let below = choose(coin(0.5f32));
            let (rx, ry) =
                (if right { radius } else { -radius }, if below { radius } else { -radius });
            draw(film_tent(x, y, rx, ry))
        }
        (Aim::Pixel(_), Filter::Gaussian { stddev }) => {
            // The corner of the filter's square lies at √2 · 4 standard deviations.
            let mass = 1.0 - (-16.0f32).exp();
            draw(film_gaussian(x, y, stddev, mass))
        }
        (Aim::Pixel(_), Filter::Cubic { .. } | Filter::Lanczos { .. }) => {
            let table = given(world.filter_table());
            draw(table.about(x, y))
        }
    };
    if let Some(parallel) = world.parallel() {
        let in_front: Seen<K> = constant(world.seen_from_film(&film));
        return match in_front {
            Seen::Surface(met) => {
                let at = met.seen_by(&parallel).apply(&film);
                SceneVertex::hit(met, at)
            }
            Seen::Sky(behind) => {
                let at = parallel.backdrop().apply(&film);
                SceneVertex::backdrop(behind, at)
            }
        };
    }
    let direction = pinhole(world.film_centre(&eye), world.film_scale()).apply(&film);
    let w = rotate(world.camera_frame).apply(&direction);
    let seen: Seen<K> = constant(world.cast(&eye, &w));
    match seen {
        Seen::Surface(hit) => {
            let point = hit.seen_from(eye.position).apply(&w);
            SceneVertex::hit(hit, point)
        }
        Seen::Sky(sky) => SceneVertex::sky(sky, w),
    }
}

/// Scatters at the last vertex by one of the lobes of its material, and finds what the ray meets. From
/// the vertex number `rr_depth` on, the path may end: Russian roulette with the albedo as the
/// probability to go on. With `only`, by the lobe with that number.
#[strategy]
pub fn sample_bsdf<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    rr_depth: u32,
    only: Option<u32>,
) -> SceneVertex<K> {
    let here = given(path.last());
    let before = given(path.back(1));
    let scattering = given(world.scattering(&here, &before));
    let survival = if path.len() > rr_depth as usize {
        scattering.albedo().max_element().min(0.95)
    } else {
        1.0
    };
    let survives = choose(coin(survival));
    if !survives {
        return stop();
    }
    let lobe = choose(scattering.lobes(only)).identified_by(|v: &SceneVertex<K>| {
        scattering.leading_to(Some(v.direction_from(here.position)))
    });
    let pose = scattering.pose_of(lobe.part);
    let w = match lobe.lobe {
        Lobe::Nothing => return stop(),
        Lobe::Mirror(_) | Lobe::Refraction(_) | Lobe::Passage(_) => {
            let fixed = given(scattering.direction(&lobe));
            let local = atom(fixed, scattering.measure(&lobe.lobe, fixed));
            rotate(pose.frame()).apply(&local)
        }
        Lobe::Matte(_) => {
            let local = draw(cosine_hemisphere());
            rotate(pose.frame()).apply(&local)
        }
        Lobe::Glossy(exponent) => {
            let lobe = given(power_lobe(PhongOf::<K>::get(exponent)).ok());
            let local = draw(lobe);
            let about = Frame::around(pose.mirrored());
            rotate(pose.frame()).apply(&rotate(about).apply(&local))
        }
        Lobe::Facets(facets) => {
            let (roughness, view) = (Facetted::<K>::get(facets), pose.view());
            let normals = given(HalfVectors::new(&roughness, view));
            let m = draw(normals);
            rotate(pose.frame()).apply(&reflect(view).apply(&m))
        }
        Lobe::Interface(interface) => {
            let (roughness, eta) = Interface::<K>::get(interface);
            let view = pose.view();
            let normals = given(HalfVectors::new(&roughness, view));
            let m = draw(normals);
            let reflects = choose(coin(fresnel::dielectric(m.dot(view).clamp(0.0, 1.0), eta).0));
            if reflects {
                rotate(pose.frame()).apply(&reflect(view).apply(&m))
            } else if eta >= 1.0 {
                let refraction = given(refract_in(view, 1.0 / eta).ok());
                rotate(pose.frame()).apply(&refraction.apply(&m))
            } else {
                let refraction = given(refract_out(view, 1.0 / eta).ok());
                rotate(pose.frame()).apply(&refraction.apply(&m))
            }
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

/// A light, chosen by its power or by what it does here, and a point on it: of a sphere only what can be seen, by the cone of
/// directions that it fills, unless it is so far away that single precision could not tell them apart; of a
/// rectangle or triangle that fills much of the view a direction, all alike ([`crate::seen::rectangle_of`], [`triangle_of`]).
#[strategy(connected = false)]
pub fn sample_light<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
) -> SceneVertex<K> {
    let here = given(path.last());
    let lights = given(world.lights.seen_from(&here));
    let light = choose(lights).identified_by(|v: &SceneVertex<K>| world.lights.index_of(v));
    match light {
        Light::Area(light) => {
            let light = K::Area::get_ref(light);
            let id = light_id(light.index);
            let point = match light.shape {
                Form::Rectangle(Rectangle { corner, a, b }) => {
                    if !world.faces(light, here.position) {
                        return stop();
                    }
                    let seen = light.seen_as_rectangle(here.position);
                    if let Some((frame, directions)) = seen {
                        let local = draw(directions);
                        let w = rotate(frame).apply(&local);
                        let lit: Surface<K> = constant(world.lit(light, &here, &w));
                        let at = lit.seen_from(here.position).apply(&w);
                        return SceneVertex::hit(lit, at);
                    }
                    draw(uniform_rectangle(corner.into(), a.into(), b.into(), id))
                }
                Form::Single(Primitive::Triangle { v0, v1, v2 }) => {
                    if !world.faces(light, here.position) {
                        return stop();
                    }
                    let seen = triangle_of(here.position, [v0, v1, v2], light.emitter.area);
                    if let Some((frame, directions)) = seen {
                        let local = draw(directions);
                        let w = rotate(frame).apply(&local);
                        let lit: Surface<K> = constant(world.lit(light, &here, &w));
                        let at = lit.seen_from(here.position).apply(&w);
                        return SceneVertex::hit(lit, at);
                    }
                    draw(uniform_triangle(v0.into(), v1.into(), v2.into(), id))
                }
                Form::Single(Primitive::Sphere { center, radius, .. }) => {
                    // Its own points do not see it as a cone, on which side of it rounding may put them.
                    let elsewhere =
                        here.primitive().is_none_or(|on| on.0 != light.emitter.primitive);
                    let cone =
                        if elsewhere { cone_of(here.position, center, radius) } else { None };
                    if let Some((axis, depth)) = cone {
                        let directions = given(uniform_cone(depth).ok());
                        let local = draw(directions);
                        let w = rotate(Frame::around(axis)).apply(&local);
                        let lit: Surface<K> = constant(world.lit(light, &here, &w));
                        let at = lit.seen_from(here.position).apply(&w);
                        return SceneVertex::hit(lit, at);
                    }
                    draw(uniform_sphere_surface(center.into(), radius, id))
                }
                Form::Single(Primitive::Cylinder { base, axis, radius, .. }) => {
                    let frame = Frame::around(Direction::from_vec(axis.into()));
                    draw(uniform_cylinder(base.into(), frame, axis.length(), radius, id))
                }
                Form::Single(Primitive::Disk { center, u_axis, v_axis, .. }) => {
                    if !world.faces(light, here.position) {
                        return stop();
                    }
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

strategies! {
    /// How the integrators make their paths.
    #[derive(Clone)]
    pub enum PathStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
        /// The eye.
        Camera(SampleCamera<'a, 'a, K>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a, K>),
        /// Scattering.
        Bsdf(SampleBsdf<'a, 'a, K>),
        /// Next-event estimation.
        Light(SampleLight<'a, 'a, K>),
    }
}
