//! An experiment: the path tracer breadth first. A wave of paths goes through one stage after the other, and vertices
//! wait in a queue for each way to scatter. Those of matte surfaces go on eight at a time, by the samplers and maps of the
//! renderer with [`Lanes`](aether_core::Lanes) for numbers; all else is done one by one, as rays are.
//!
//! Paths draw the numbers that those of [`PathByHand`](crate::twins::path::PathByHand) draw, so that both make the same
//! images but for rounding. The binary `wavefront` times the stages and says how full the lanes are.

mod lanes;

use std::time::Instant;

use aether_core::discrete::Discrete;
use aether_core::prelude::Direction;
use aether_core::uniform::{UniformSource, draw_uniforms};
use glam::Vec3;
use integrators::kind::{Oriented, Presence, SceneKind};
use integrators::lights::{AreaLight, Form, Light};
use integrators::path::PathSettings;
use integrators::scattering::{Lobe, Scattering};
use integrators::scene::{SamplerKind, Scene};
use integrators::strategies::Pixel;
use integrators::uniforms::Uniforms;
use integrators::vertex::{SceneVertex, Seen};
use integrators::world::World;

use crate::twins::path::{BLOCKS, Lit, TO_LIGHT};
use crate::twins::path::{direct_from, light_density, sample_point, scatter};

pub use lanes::Wide;

/// What a wave goes through, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Directions of the camera.
    Camera,
    /// Rays to the next surface.
    Rays,
    /// What surfaces emit that were hit, with its weight.
    Emission,
    /// Materials, and the queues that they put vertices into.
    Sorting,
    /// The choice of a light, and directions to lights that fill much of the view.
    Lights,
    /// Points of lights that do not, what they carry to matte surfaces, and its weight.
    Connections,
    /// Shadow rays of matte surfaces.
    Shadows,
    /// Directions that matte surfaces scatter into.
    Scattering,
    /// All that vertices of other surfaces need.
    Others,
}

impl Stage {
    /// All of them.
    pub const ALL: [Stage; 9] = [
        Stage::Camera,
        Stage::Rays,
        Stage::Emission,
        Stage::Sorting,
        Stage::Lights,
        Stage::Connections,
        Stage::Shadows,
        Stage::Scattering,
        Stage::Others,
    ];
}

/// What a stage has done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Seconds.
    pub seconds: f64,
    /// How many vertices or rays there were.
    pub items: u64,
    /// How many would have had a lane; of stages without lanes, zero.
    pub slots: u64,
}

/// A path under way.
struct Walk<K: SceneKind> {
    index: usize,
    pixel: Pixel,
    uniforms: Uniforms,
    before: SceneVertex<K>,
    here: SceneVertex<K>,
    /// Where it goes on.
    w: Direction<f32>,
    /// Density of that direction in solid angle, with the chance to go on; none of an atom.
    density: Option<f32>,
    throughput: Vec3,
    radiance: Vec3,
}

/// A vertex of a matte surface.
#[derive(Clone, Copy)]
struct Matte {
    walk: u32,
    /// The unit normal on the side of the viewer.
    normal: Vec3,
    reflectance: Vec3,
    survival: f32,
}

/// A matte vertex, and a light that is sampled by area.
struct Far<'w> {
    matte: Matte,
    light: &'w AreaLight,
    /// The probability of the light.
    probability: f32,
    uniforms: [f32; 2],
}

/// A matte vertex, and a point of a light.
struct Near<K: SceneKind> {
    matte: Matte,
    to: Lit<K>,
}

/// What a connection carries if nothing is in between.
struct Shadow<K: SceneKind> {
    walk: u32,
    to: SceneVertex<K>,
    carries: Vec3,
}

/// The path tracer in waves.
pub struct Wavefront<'w, 's, K: SceneKind> {
    world: &'w World<'s, K>,
    settings: PathSettings,
    walks: Vec<Walk<K>>,
    alive: Vec<u32>,
    matte: Vec<Matte>,
    others: Vec<u32>,
    far: Vec<Far<'w>>,
    near: Vec<Near<K>>,
    shadows: Vec<Shadow<K>>,
    /// What each stage has done.
    pub tallies: [Tally; Stage::ALL.len()],
}

impl<'w, 's, K: SceneKind> Wavefront<'w, 's, K> {
    /// One for a scene that [`supports`](crate::twins::path::supports) knows, with a box filter.
    pub fn new(world: &'w World<'s, K>, settings: PathSettings) -> Self {
        Wavefront {
            world,
            settings,
            walks: Vec::new(),
            alive: Vec::new(),
            matte: Vec::new(),
            others: Vec::new(),
            far: Vec::new(),
            near: Vec::new(),
            shadows: Vec::new(),
            tallies: Default::default(),
        }
    }

    /// One estimate for each pixel with the number of a sample, to be shown to `visit` with its place in the list.
    pub fn run<R: Wide>(
        &mut self,
        (sampler, seed): (SamplerKind, u64),
        wave: &[(Pixel, u32)],
        mut visit: impl FnMut(usize, Vec3),
    ) {
        let (world, film) = (self.world, &self.world.scene.film);
        let eye = SceneVertex::eye(world.eye());
        self.walks.clear();
        self.walks.extend(wave.iter().enumerate().map(|(index, &(pixel, sample))| Walk {
            index,
            pixel,
            uniforms: Uniforms::of_pixel(sampler, seed, pixel, film, sample),
            before: eye,
            here: eye,
            w: Direction::from_unit(Vec3::Z.into()),
            density: None,
            throughput: Vec3::ONE,
            radiance: Vec3::ZERO,
        }));
        self.alive.clear();
        self.alive.extend(0..wave.len() as u32);
        self.stage(Stage::Camera, |it| it.look::<R>());
        let longest = self.settings.most_vertices();
        for length in 2..=longest {
            self.stage(Stage::Rays, |it| it.cast());
            if length > 2 || !self.settings.hide_emitters {
                self.stage(Stage::Emission, |it| it.emit());
            }
            if length == longest || self.alive.is_empty() {
                break;
            }
            self.stage(Stage::Sorting, |it| it.sort(length));
            self.stage(Stage::Lights, |it| it.choose_lights(length));
            self.stage(Stage::Connections, |it| it.connect::<R>());
            self.stage(Stage::Shadows, |it| it.shadow());
            self.stage(Stage::Scattering, |it| it.scatter::<R>(length));
            self.stage(Stage::Others, |it| it.others(length));
        }
        for walk in &self.walks {
            visit(walk.index, walk.radiance);
        }
    }

    /// Runs a stage, which says how many items it had and how many slots they were in.
    fn stage(&mut self, stage: Stage, run: impl FnOnce(&mut Self) -> (usize, usize)) {
        let start = Instant::now();
        let (items, slots) = run(self);
        let tally = &mut self.tallies[stage as usize];
        tally.seconds += start.elapsed().as_secs_f64();
        tally.items += items as u64;
        tally.slots += slots as u64;
    }

    #[inline(never)]
    fn look<R: Wide>(&mut self) -> (usize, usize) {
        for eight in self.walks.chunks_mut(R::LANES) {
            let directions = lanes::camera::<K, R>(self.world, eight.len(), |i| {
                let walk = &mut eight[i];
                walk.uniforms.start(BLOCKS);
                (walk.pixel, draw_uniforms(&mut walk.uniforms))
            });
            for (walk, w) in eight.iter_mut().zip(directions) {
                walk.w = w;
            }
        }
        slots::<R>(self.walks.len())
    }

    #[inline(never)]
    fn cast(&mut self) -> (usize, usize) {
        let (world, walks, rays) = (self.world, &mut self.walks, self.alive.len());
        self.alive.retain(|&number| {
            let walk = &mut walks[number as usize];
            let Some(Seen::Surface(surface)) = world.cast(&walk.here, &walk.w) else {
                return false;
            };
            walk.before = std::mem::replace(&mut walk.here, SceneVertex::on(surface));
            true
        });
        (rays, 0)
    }

    #[inline(never)]
    fn emit(&mut self) -> (usize, usize) {
        let mut lights = 0;
        for &number in &self.alive {
            let walk = &mut self.walks[number as usize];
            if !walk.here.is_light() {
                continue;
            }
            lights += 1;
            let emitted = self.world.emitted(&walk.here, &walk.before);
            if emitted == Vec3::ZERO {
                continue;
            }
            let weight = walk.density.map_or(1.0, |density| {
                let ratio = light_density(self.world, &walk.before, &walk.here) / density;
                1.0 / (1.0 + ratio * ratio)
            });
            walk.radiance += walk.throughput * emitted * weight;
        }
        (lights, 0)
    }

    #[inline(never)]
    fn sort(&mut self, length: usize) -> (usize, usize) {
        self.matte.clear();
        self.others.clear();
        for &number in &self.alive {
            let walk = &self.walks[number as usize];
            let Some(scattering) = self.world.scattering(&walk.here, &walk.before) else {
                continue;
            };
            if !is_matte(&scattering) {
                self.others.push(number);
                continue;
            }
            let Some(surface) = walk.here.surface() else { continue };
            let faces = surface.shading.dot(walk.before.offset_from(walk.here.position)) > 0.0;
            let normal = if faces { surface.shading } else { -surface.shading };
            let reflectance = scattering.albedo();
            let survival = self.survival(reflectance, length);
            self.matte.push(Matte { walk: number, normal, reflectance, survival });
        }
        (self.alive.len(), 0)
    }

    fn survival(&self, albedo: Vec3, length: usize) -> f32 {
        let ends = length > self.settings.rr_depth as usize;
        if ends { albedo.max_element().min(0.95) } else { 1.0 }
    }

    #[inline(never)]
    fn choose_lights(&mut self, length: usize) -> (usize, usize) {
        let world = self.world;
        self.far.clear();
        self.near.clear();
        for &matte in &self.matte {
            let Walk { uniforms, here, .. } = &mut self.walks[matte.walk as usize];
            uniforms.start(BLOCKS * length as u32 + TO_LIGHT);
            let Some(lights) = world.lights.seen_from(here) else { continue };
            let choice = lights.sample(uniforms.next());
            let Light::Area(light) = choice.item else { continue };
            let (light, probability) = (K::Area::get_ref(light), choice.probability);
            let is_far = matches!(light.shape, Form::Rectangle(_))
                && light.seen_as_rectangle(here.position).is_none();
            if !is_far {
                let point = sample_point(world, here, (light, probability), uniforms);
                self.near.extend(point.map(|to| Near { matte, to }));
            } else if world.faces(light, here.position) {
                let uniforms = draw_uniforms(uniforms);
                self.far.push(Far { matte, light, probability, uniforms });
            }
        }
        (self.matte.len(), 0)
    }

    #[inline(never)]
    fn connect<R: Wide>(&mut self) -> (usize, usize) {
        let (world, walks, shadows) = (self.world, &self.walks, &mut self.shadows);
        shadows.clear();
        for eight in self.far.chunks(R::LANES) {
            let position = |i: usize| walks[eight[i].matte.walk as usize].here.position;
            for (far, (point, carried)) in eight.iter().zip(lanes::far::<R>(eight, position)) {
                if carried > 0.0 {
                    let Matte { walk, reflectance, .. } = far.matte;
                    let to = SceneVertex::on(world.light_surface(far.light, point));
                    let emitted = world.emitted(&to, &walks[walk as usize].here);
                    shadows.push(Shadow { walk, to, carries: reflectance * emitted * carried });
                }
            }
        }
        for eight in self.near.chunks(R::LANES) {
            let way = |i: usize| {
                let Near { matte, to } = &eight[i];
                (to.vertex.direction_from(walks[matte.walk as usize].here.position), to.density)
            };
            for (near, carried) in eight.iter().zip(lanes::near::<K, R>(eight, way)) {
                if carried > 0.0 {
                    let (Matte { walk, reflectance, .. }, to) = (near.matte, near.to.vertex);
                    let emitted = world.emitted(&to, &walks[walk as usize].here);
                    shadows.push(Shadow { walk, to, carries: reflectance * emitted * carried });
                }
            }
        }
        let [far, near] = [self.far.len(), self.near.len()].map(slots::<R>);
        (far.0 + near.0, far.1 + near.1)
    }

    #[inline(never)]
    fn shadow(&mut self) -> (usize, usize) {
        for Shadow { walk, to, carries } in &self.shadows {
            let walk = &mut self.walks[*walk as usize];
            if self.world.visible(&walk.here, to) {
                walk.radiance += walk.throughput * *carries;
            }
        }
        (self.shadows.len(), 0)
    }

    #[inline(never)]
    fn scatter<R: Wide>(&mut self, length: usize) -> (usize, usize) {
        let walks = &mut self.walks;
        self.matte.retain(|matte| {
            let uniforms = &mut walks[matte.walk as usize].uniforms;
            uniforms.start(BLOCKS * length as u32);
            uniforms.next() < matte.survival && matte.reflectance != Vec3::ZERO
        });
        self.alive.clear();
        for eight in self.matte.chunks(R::LANES) {
            let numbers = |i: usize| {
                let uniforms = &mut walks[eight[i].walk as usize].uniforms;
                // The only lobe is chosen with a number of its own.
                uniforms.next();
                draw_uniforms(uniforms)
            };
            for (matte, (w, density, gain)) in eight.iter().zip(lanes::scatter::<R>(eight, numbers))
            {
                let walk = &mut walks[matte.walk as usize];
                walk.throughput *= matte.reflectance * (gain / matte.survival);
                (walk.w, walk.density) = (w, Some(density * matte.survival));
                if gain > 0.0 {
                    self.alive.push(matte.walk);
                }
            }
        }
        slots::<R>(self.matte.len())
    }

    #[inline(never)]
    fn others(&mut self, length: usize) -> (usize, usize) {
        let world = self.world;
        for &number in &self.others {
            let walk = &mut self.walks[number as usize];
            let Some(scattering) = world.scattering(&walk.here, &walk.before) else { continue };
            let ends = length > self.settings.rr_depth as usize;
            let survival = if ends { scattering.albedo().max_element().min(0.95) } else { 1.0 };
            let block = BLOCKS * length as u32;
            walk.uniforms.start(block + TO_LIGHT);
            let direct = direct_from(world, &walk.here, &scattering, survival, &mut walk.uniforms);
            walk.radiance += walk.throughput * direct;
            walk.uniforms.start(block);
            if walk.uniforms.next() >= survival {
                continue;
            }
            let Some(scattered) = scatter(&scattering, &mut walk.uniforms) else { continue };
            walk.throughput *= scattered.weight / survival;
            (walk.w, walk.density) = (scattered.w, scattered.density.map(|p| p * survival));
            if walk.throughput != Vec3::ZERO {
                self.alive.push(number);
            }
        }
        (self.others.len(), 0)
    }
}

/// How many items there are, and how many lanes they need.
fn slots<R: Wide>(items: usize) -> (usize, usize) {
    (items, items.next_multiple_of(R::LANES))
}

/// Whether a surface scatters by one matte lobe about its normal.
fn is_matte<K: SceneKind>(scattering: &Scattering<'_, K>) -> bool {
    let matte = |lobe: Lobe<K>| matches!(lobe, Lobe::Matte(_));
    Oriented::<K>::VALUE.is_none()
        && scattering.count() == 1
        && scattering.lobe(0).is_some_and(|weighted| matte(weighted.lobe))
}

/// Whether waves know all that a scene has.
pub fn supports(scene: &Scene) -> bool {
    crate::twins::path::supports(scene) && scene.film.filter == integrators::scene::Filter::Box
}
