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

use aether_core::combine::Shifted;
use aether_core::{Estimator, PowerHeuristic, UniformSource};
use glam::Vec3;

use crate::image::RgbImage;
use crate::integrand::Radiance;
use crate::integrator::{Integrator, Received};
use crate::kind::SceneKind;
use crate::path::PathSettings;
use crate::poisson::{ALPHA, Reconstruction, reconstruct};
use crate::render::{Layer, Rendered, Splats, Technique};
use crate::shift::{Beginning, Path, Shift, ShiftStrategies};
use crate::strategies::{Pixel, sample_light};
use crate::subpaths::{Scratch, camera_path, through};
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

/// A pixel next to that of a sample, and the path there.
struct Neighbour<'r, 'a, K: SceneKind> {
    pixel: Pixel,
    /// Which gradient the difference to this pixel is, of which pixel, with which sign.
    gradient: (Layer, Pixel, f32),
    shift: Shift<'a, K>,
    /// The camera path's strategies, through this pixel.
    camera: Path<'r, 'a, K>,
    /// The shifted path, as far as it is another one.
    beginning: Option<Beginning<'r, 'a, K>>,
    /// The sum of differences.
    difference: Vec3,
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
        let limits = (self.path.most_vertices(), self.path.rr_depth);
        let camera = camera_path(world, arena, uniforms, pixel, limits);
        let mut neighbours = self.neighbours(world, pixel, &camera);

        let response = estimator.integrand().response(pixel, &camera);
        let mut seen = Vec3::ZERO;
        let sees = self.path.techniques.has(Technique::edge(2, 0));
        if sees && !self.path.hide_emitters && limits.0 > 1 {
            seen = estimator.of(&camera.slice(0..2)) * response;
            splats.add_to(Layer::Direct, pixel, seen.to_array());
        }
        let mut received = Received::new(pixel, splats);
        received.add_by(Technique::edge(2, 0), pixel, seen, seen);
        for n in 2..camera.size() {
            let mut own = self.techniques(world, &camera, n);
            own[1].sample(uniforms);
            // The camera path goes on from what scattering found, which therefore comes last.
            let samples = own.iter().enumerate().filter(|(_, base)| base.is_complete());
            for (i, base) in samples.rev() {
                let value = estimator.of(base) * response;
                if value != Vec3::ZERO {
                    let weighted = value * base.weight_with(&PowerHeuristic, (&own, i), None);
                    received.add_by(Technique::edge(n + 1 - i, i), pixel, weighted, value);
                }
                for side in neighbours.iter_mut().flatten() {
                    let shifted = side.shifted(base, i == 0);
                    let there =
                        shifted.map_or(Vec3::ZERO, |shifted| side.value(estimator, &shifted, base));
                    if value != Vec3::ZERO || there != Vec3::ZERO {
                        let theirs = self.techniques(world, &side.camera, n);
                        let shifted = shifted
                            .as_ref()
                            .map(|shifted| (shifted, able(world, &theirs, &shifted.path, there)));
                        let ours = if i == 0 { &own[..] } else { able(world, &own, base, value) };
                        let position = i + ours.len() - own.len();
                        let weight = base.weight_with(&PowerHeuristic, (ours, position), shifted);
                        side.difference += (there - value) * weight;
                    }
                }
            }
        }
        let radiance = received.own;
        for Neighbour { gradient: (layer, of, sign), difference, .. } in
            neighbours.into_iter().flatten()
        {
            splats.add_to(layer, of, (sign * difference).to_array());
        }
        radiance
    }
}

/// Those of the two techniques that can make a path which carries `value`. The density of scattering says nothing
/// of what lies in between, because what is hidden carries nothing; but the other path of a pair may be
/// visible.
fn able<'t, 'r, 'a, K: SceneKind>(
    world: &World<'_, K>,
    techniques: &'t [Path<'r, 'a, K>; 2],
    path: &Path<'r, 'a, K>,
    value: Vec3,
) -> &'t [Path<'r, 'a, K>] {
    let last = path.len() - 1;
    let sees = || match (path.vertex(last - 1), path.vertex(last)) {
        (Some(here), Some(light)) => world.visible(&here, &light),
        _ => false,
    };
    if value != Vec3::ZERO || path.view().visible(last) || sees() {
        techniques
    } else {
        &techniques[1..]
    }
}

impl GradientDomain {
    /// The path that scattering finds, and the one that goes to a light instead, after `n` vertices of a path: of
    /// these, what is not used does not exist.
    fn techniques<'r, 'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        path: &Path<'r, 'a, K>,
        n: usize,
    ) -> [Path<'r, 'a, K>; 2] {
        let mut direct = path.slice(0..n);
        direct.append(sample_light(world));
        let found = [path.slice(0..n + 1), direct];
        let used = [0, 1].map(|s| self.path.techniques.has(Technique::edge(n + 1 - s, s)));
        [0, 1].map(|s| if used[s] { found[s] } else { path.slice(path.size() + 1..) })
    }

    /// The pixels of the image to the right and left of one, below and above.
    fn neighbours<'r, 'a, K: SceneKind>(
        &self,
        world: &'a World<'a, K>,
        pixel: Pixel,
        camera: &Path<'r, 'a, K>,
    ) -> [Option<Neighbour<'r, 'a, K>>; 4] {
        let film = world.scene.film;
        [(1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dy): (i32, i32)| {
            let (x, y) = (pixel.0.checked_add_signed(dx)?, pixel.1.checked_add_signed(dy)?);
            if x >= film.width || y >= film.height || camera.is_empty() {
                return None;
            }
            let other = (x, y);
            let shift = Shift { world, by: (dx as f32, dy as f32), rough: self.rough };
            let forwards = dx + dy > 0;
            let first = if forwards { pixel } else { other };
            let layer = if dx == 0 { Layer::Dy } else { Layer::Dx };
            Some(Neighbour {
                pixel: other,
                gradient: (layer, first, if forwards { 1.0 } else { -1.0 }),
                shift,
                camera: through(world, other, camera),
                beginning: Some(shift.begin(camera)),
                difference: Vec3::ZERO,
            })
        })
    }
}

impl<'r, 'a, K: SceneKind> Neighbour<'r, 'a, K> {
    /// The shift of a path, all but the last two of whose vertices the beginning has been made for; if the camera path
    /// `follows` it, that goes on with it.
    fn shifted(
        &mut self,
        base: &Path<'r, 'a, K>,
        follows: bool,
    ) -> Option<Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>> {
        let before = self.beginning?;
        let beginning = self.shift.extend(&before, base);
        if follows {
            self.beginning = beginning;
        }
        let beginning = beginning?;
        // What is kept and no light contributes to neither pixel.
        let ends = beginning.is_joined() && !base.last()?.is_light();
        if ends { None } else { self.shift.finish(&beginning, base) }
    }

    /// What the shifted path contributes to this pixel, as a sample of the base path.
    fn value(
        &self,
        estimator: &PathEstimator<'a, K>,
        shifted: &Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>,
        base: &Path<'r, 'a, K>,
    ) -> Vec3 {
        if !shifted.path.last().is_some_and(|last| last.is_light()) {
            return Vec3::ZERO;
        }
        let value = estimator.of(&shifted.path);
        if value == Vec3::ZERO {
            return value;
        }
        let response = estimator.integrand().response(self.pixel, &shifted.path);
        value * (response * shifted.rescaling(base))
    }
}

/// The image that fits what was rendered and its gradients. Of other integrators, what was rendered.
pub fn reconstructed(rendered: &Rendered, reconstruction: Reconstruction) -> RgbImage {
    let image = rendered.film.image();
    let layer = |layer: Layer| rendered.layers.get(&layer).map(|[image, _]| image.clone());
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

type PathEstimator<'a, K> = Estimator<Radiance<'a, 'a, K>, aether_core::estimator::Factors<Vec3>>;
