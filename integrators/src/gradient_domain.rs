//! Gradient-domain path tracing (Kettunen et al. 2015; Aether 2017, section 7.5): beside each path, similar ones
//! through the four pixels next to its own. Their differences are the gradients of the image, with much less
//! noise than the image has, and [`crate::poisson`] makes an image of both.
//!
//! A pair of paths can be made from either of its pixels, by scattering and by next-event estimation: its weight
//! is that of multiple importance sampling over all of these. A filter moves with its pixel, so that the shift by
//! a whole pixel keeps its value and any filter serves; the gradients are differences of neighbouring pixels as
//! that filter sees them. They are written to layers of their own, [`Layer::Dx`] and [`Layer::Dy`]: the
//! right, and the lower, neighbour minus the pixel. Light that the camera sees at its source is left out of them: it
//! has little noise, but edges that would spread. It is a layer too, [`Layer::Direct`].

use aether_core::estimator::Shifts;
use aether_core::{PowerHeuristic, UniformSource};
use glam::Vec3;

use crate::image::RgbImage;
use crate::integrator::{Integrator, Received};
use crate::kind::SceneKind;
use crate::path::{PathSettings, ended};
use crate::poisson::{ALPHA, Reconstruction, reconstruct};
use crate::render::{Layer, Layers, Rendered, Splats};
use crate::shift::{FilmShift, ShiftStrategies};
use crate::strategies::{Pixel, sample_bsdf, sample_camera, sample_camera_direction, sample_light};
use crate::subpaths::Scratch;
use crate::vertex::SceneVertex;
use crate::world::World;

/// Settings of gradient-domain path tracing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientDomain {
    /// Lengths of paths, Russian roulette.
    pub path: PathSettings,
    /// The least roughness of surfaces between which a shifted path may meet its base path.
    pub rough: f32,
}

impl GradientDomain {
    /// With the usual threshold.
    pub fn new(path: PathSettings) -> Self {
        GradientDomain { path, rough: 0.02 }
    }
}

impl Integrator for GradientDomain {
    type Scratch<'a, K: SceneKind> = Scratch<'a, K, ShiftStrategies<'a, K>>;
    const SPLATS: bool = true;

    fn scratch<'a, K: SceneKind>(&'a self, world: &'a World<'a, K>) -> Self::Scratch<'a, K> {
        Scratch::new(world)
    }

    fn sample<'a, K: SceneKind>(
        &'a self,
        world: &'a World<'a, K>,
        Scratch { arena, estimator }: &mut Self::Scratch<'a, K>,
        uniforms: &mut impl UniformSource<f32>,
        pixel: Pixel,
        splats: &mut Splats,
    ) -> Vec3 {
        arena.clear();
        let mut camera = arena.sequence();
        camera.append(sample_camera(world));
        camera.append(sample_camera_direction(world, pixel.into())).sample(uniforms);
        // A filter moves with its pixel, so that shifted paths are seen as their base paths are.
        let response = estimator.integrand().response(pixel, &camera);

        let light = [sample_light(world).into()];
        let ways: [&[_]; 2] = [&[], &light];
        let endings = self.path.endings(&ways);
        let shifts = NEIGHBOURS.map(|by| self.shift(world, pixel, by));
        let sees = |from: &SceneVertex<K>, to: &SceneVertex<K>| world.visible(from, to);
        let shifts = Shifts { shifts, shortest: SEEN + 1, sees };
        let scatter = sample_bsdf(world, self.path.rr_depth, None).into();
        let mut received = Received::new(pixel, splats);
        let differences = estimator.differences(
            &camera,
            &scatter,
            &endings,
            &shifts,
            &PowerHeuristic,
            uniforms,
            |path| {
                let [value, alone] = [path.value, path.alone].map(|value| value * response);
                received.add_by(ended(path.length, path.steps), pixel, value, alone);
                if path.length == SEEN {
                    received.add_to(Layer::Direct, value);
                }
            },
        );
        let radiance = received.own;
        for (shift, difference) in shifts.shifts.into_iter().zip(differences) {
            if let Some(shift) = shift {
                let (layer, of, sign) = gradient(pixel, &shift);
                splats.add_to(layer, of, (sign * response * difference).to_array());
            }
        }
        radiance
    }
}

/// The pixels to the right and left of one, below and above.
const NEIGHBOURS: [(i32, i32); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// How many vertices a path has on which the camera sees a light at its source.
const SEEN: usize = 2;

/// Which gradient the difference that a shift makes is, of which pixel, with which sign.
fn gradient<K: SceneKind>(pixel: Pixel, shift: &FilmShift<'_, K>) -> (Layer, Pixel, f32) {
    let (dx, dy) = shift.by;
    let layer = if dx == 0 { Layer::Dy } else { Layer::Dx };
    if dx + dy > 0 { (layer, pixel, 1.0) } else { (layer, shift.moved(), -1.0) }
}

impl GradientDomain {
    /// The shift to the pixel next to one, if the image has it.
    fn shift<'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        pixel: Pixel,
        by: (i32, i32),
    ) -> Option<FilmShift<'a, K>> {
        let film = world.scene.film;
        let x = pixel.0.checked_add_signed(by.0).filter(|x| *x < film.width);
        let y = pixel.1.checked_add_signed(by.1).filter(|y| *y < film.height);
        x.and(y).map(|_| FilmShift { world, pixel, by, rough: self.rough })
    }
}

/// The image that fits what was rendered and its gradients. Of other integrators, what was rendered.
pub fn reconstructed(rendered: &Rendered, reconstruction: Reconstruction) -> RgbImage {
    with_gradients(rendered.film.image(), &rendered.layers, reconstruction)
}

/// [`reconstructed`], of an image and those beside it.
pub fn with_gradients(
    image: RgbImage,
    layers: &Layers,
    reconstruction: Reconstruction,
) -> RgbImage {
    let layer = |layer: Layer| layers.get(&layer).map(|[image, _]| image.clone());
    let gradients = [Layer::Dx, Layer::Dy].map(layer);
    if reconstruction == Reconstruction::None || gradients.iter().all(Option::is_none) {
        return image;
    }
    let black = || RgbImage::filled(image.width(), image.height(), [0.0; 3]);
    let [dx, dy] = gradients.map(|gradient| gradient.unwrap_or_else(black));
    let direct = layer(Layer::Direct).unwrap_or_else(black);
    let plus = |a: &RgbImage, sign: f32| {
        RgbImage::from_fn(a.width(), a.height(), |x, y| {
            let (a, b) = (a.pixel(x, y), direct.pixel(x, y));
            std::array::from_fn(|c| a[c] + sign * b[c])
        })
    };
    plus(&reconstruct(&plus(&image, -1.0), [&dx, &dy], ALPHA, reconstruction), 1.0)
}
