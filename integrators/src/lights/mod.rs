//! The lights of a scene as light sampling sees them.

use std::f32::consts::PI;

use aether_core::discrete::{Choice, Choices, Discrete, TreeView, discrete_weighted};
use aether_core::prelude::Frame;
use glam::Vec3;

use crate::envmap::EnvironmentTable;
use crate::kind::{NotCovered, Presence, SceneKind, With};
use crate::samplers::SphericalRectangle;
use crate::scene::hit::Plane;
use crate::scene::{Bounds, Emitter, Primitive, PrimitiveId, Rectangle, Scene, Sky};
use crate::seen::{Pane, rectangle_of};
use crate::vertex::{Place, SceneVertex, SkyOf};

mod bounds;
pub mod hierarchy;
#[cfg(test)]
mod tests;

use bounds::Extent;
use hierarchy::{Group, Hierarchy, Lit};

/// The geometry of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// Two triangles that make a rectangle.
    Rectangle(Rectangle),
    /// One primitive.
    Single(Primitive),
}

impl Form {
    /// That of an emitter of a scene.
    pub fn of(scene: &Scene, emitter: &Emitter) -> Form {
        let primitives = &scene.primitives[emitter.primitives().start as usize..];
        match primitives {
            [first, second, ..] if emitter.count == 2 => {
                Rectangle::of(first, second).map_or(Form::Single(*first), Form::Rectangle)
            }
            _ => Form::Single(primitives[0]),
        }
    }
}

/// An emissive surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaLight {
    /// Its place in the list of emitters.
    pub index: u32,
    /// The emitter.
    pub emitter: Emitter,
    /// Its geometry.
    pub shape: Form,
    /// The plane that it lies in, if it is flat.
    pub flat: Option<Flat>,
    /// What is the same from wherever it is seen, if it is a rectangle.
    pub pane: Option<Pane>,
}

impl AreaLight {
    /// The directions in which it is seen from a point as a rectangle, by [`rectangle_of`]; none of another form.
    #[inline]
    pub fn seen_as_rectangle(&self, from: Vec3) -> Option<(Frame<f32>, SphericalRectangle<f32>)> {
        rectangle_of(from, self.pane.as_ref()?)
    }
}

/// What is the same all over a flat light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// A point of it.
    pub on: Vec3,
    /// The unit normals of its primitives; of a single one twice.
    pub normals: [Vec3; 2],
    /// Its plane.
    pub plane: Plane,
}

impl Flat {
    /// That of an emitter of this form in a scene; none of a round one.
    fn of(scene: &Scene, emitter: &Emitter, shape: &Form) -> Option<Flat> {
        let first = PrimitiveId(emitter.primitive);
        let (corners, second) = match *shape {
            Form::Rectangle(Rectangle { corner, a, b }) => {
                ([corner, corner + a, corner + b], PrimitiveId(first.0 + 1))
            }
            Form::Single(Primitive::Triangle { v0, v1, v2 }) => ([v0, v1, v2], first),
            Form::Single(Primitive::Disk { center, u_axis, v_axis, .. }) => {
                ([center, center + u_axis, center + v_axis], first)
            }
            Form::Single(Primitive::Sphere { .. } | Primitive::Cylinder { .. }) => return None,
        };
        let on = corners[0];
        let normals = [first, second].map(|primitive| scene.normal(primitive, on));
        Some(Flat { on, normals, plane: Plane::through(corners) })
    }

    /// Whether it shines to the side on which a point lies.
    #[inline(always)]
    pub fn faces(&self, point: Vec3) -> bool {
        self.normals[0].dot(point - self.on) > 0.0
    }
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light<K: SceneKind> {
    /// A surface.
    Area(With<K::Area, AreaLight>),
    /// A sky that is the same in all directions.
    Sky(With<K::Constant, SkyOf<K>>),
    /// A sky as a picture shows it.
    Picture(With<K::Envmap, SkyOf<K>>),
    /// A point.
    Bulb(With<K::Point, (u32, Vec3)>),
    /// Parallel light, by the direction towards it.
    Distant(With<K::Directional, (u32, Vec3)>),
}

/// More lights than this are chosen by a hierarchy: it pays when lights differ in what they do at a place,
/// and costs a walk down a tree.
const FEW: usize = 2;

/// Up to this many lights are also chosen all alike, half of the time: the hierarchy does not know in which directions
/// a surface reflects, and a small lamp may be all that is seen in one.
const SEVERAL: usize = 16;

/// A choice of lights in proportion to their power.
pub type PowerChoice<K> = Choices<Vec<Light<K>>, Light<K>, f32>;

/// All lights of a scene: a few are chosen in proportion to their power, many by a [`hierarchy`].
#[derive(Clone, Debug)]
pub struct Lights<K: SceneKind> {
    /// The choice in proportion to power; none if nothing emits.
    pub choice: Option<PowerChoice<K>>,
    /// Which of many lights is worth sampling from where; none for few.
    hierarchy: Option<Hierarchy>,
    /// Centre and radius of a sphere around the scene.
    pub bounds: (Vec3, f32),
    /// How to choose directions of a sky that a picture shows; none without such a picture, or if it is black.
    pub picture: Option<EnvironmentTable>,
    /// Where the sky is among them.
    sky: usize,
    /// Where the points begin.
    bulbs: usize,
    /// Where parallel lights begin.
    distant: usize,
}

impl<K: SceneKind> Lights<K> {
    /// The lights of a scene.
    ///
    /// # Errors
    /// If there is one of a sort that the kind leaves out.
    pub fn new(scene: &Scene) -> Result<Self, NotCovered> {
        let missing = |feature| NotCovered { kind: K::NAME, feature };
        let (mut lights, mut powers) = (Vec::new(), Vec::new());
        for (index, emitter) in (0..).zip(&scene.emitters) {
            let shape = Form::of(scene, emitter);
            let flat = Flat::of(scene, emitter, &shape);
            let pane = match &shape {
                Form::Rectangle(rectangle) => Pane::of(rectangle, emitter.area),
                Form::Single(_) => None,
            };
            let light = AreaLight { index, emitter: *emitter, shape, flat, pane };
            let light = K::Area::with(|| light);
            lights.push(Light::Area(light.ok_or_else(|| missing("Area"))?));
            powers.push(emitter.power().element_sum());
        }
        // Light from afar falls on the disk that the scene shows to it.
        let bounds @ (_, radius) = scene.bounding_sphere();
        let cross_section = PI * radius * radius;
        let sky = lights.len();
        let mut picture = None;
        if let Some(from) = &scene.sky {
            let any = SkyOf::<K>::VALUE.ok_or_else(|| missing(from.feature()))?;
            let light = match from {
                Sky::Constant(_) => K::Constant::with(|| any).map(Light::Sky),
                Sky::Picture(map) => {
                    picture = K::Envmap::VALUE.and_then(|_| EnvironmentTable::new(map));
                    K::Envmap::with(|| any).map(Light::Picture)
                }
            };
            lights.push(light.ok_or_else(|| missing(from.feature()))?);
            powers.push(4.0 * PI * cross_section * from.mean().element_sum());
        }
        let bulbs = lights.len();
        for (index, bulb) in (0..).zip(&scene.bulbs) {
            let light = K::Point::with(|| (index, bulb.position));
            lights.push(Light::Bulb(light.ok_or_else(|| missing("Point"))?));
            powers.push(bulb.power().element_sum());
        }
        let distant = lights.len();
        for (index, light) in (0..).zip(&scene.distant) {
            powers.push(cross_section * light.irradiance.element_sum());
            let light = K::Directional::with(|| (index, light.towards));
            lights.push(Light::Distant(light.ok_or_else(|| missing("Directional"))?));
        }
        // No light, or only black ones: there is nothing to choose from.
        let hierarchy = if lights.len() > FEW { hierarchy_of(scene) } else { None };
        let choice = discrete_weighted(lights, powers).ok();
        Ok(Lights { choice, hierarchy, bounds, picture, sky, bulbs, distant })
    }

    /// The choice of a light that is to shine on a vertex.
    #[inline]
    pub fn seen_from(&self, here: &SceneVertex<K>) -> Option<Selection<'_, K>> {
        let by_power = self.choice.as_ref()?;
        let Some(hierarchy) = &self.hierarchy else { return Some(Selection::ByPower(by_power)) };
        let normal = here.surface().map(|surface| surface.shading);
        let view = hierarchy.seen_by(Lit { position: here.position, normal });
        let lights = by_power.items();
        let alike = if lights.len() <= SEVERAL { 0.5 } else { 0.0 };
        Some(Selection::ByPlace { lights, view, alike })
    }

    /// Which light a vertex lies on.
    #[inline]
    pub fn index_of(&self, vertex: &SceneVertex<K>) -> Option<usize> {
        match vertex.place {
            Place::Camera | Place::Parallel(_) | Place::Backdrop(_) => None,
            Place::Surface(surface) => surface.emitter.map(|index| index as usize),
            Place::Sky(_) => Some(self.sky),
            Place::Bulb(index) => Some(self.bulbs + K::Point::get(index) as usize),
            Place::Distant(index) => Some(self.distant + K::Directional::get(index) as usize),
        }
    }
}

/// The hierarchy of the lights of a scene, in the order of [`Lights::new`].
fn hierarchy_of(scene: &Scene) -> Option<Hierarchy> {
    let mut numbers = 0..;
    let (mut near, mut far) = (Vec::new(), Vec::new());
    for (emitter, number) in scene.emitters.iter().zip(&mut numbers) {
        let (id, [first, others @ ..]) = (
            PrimitiveId(emitter.primitive),
            &scene.primitives
                [emitter.primitives().start as usize..emitter.primitives().end as usize],
        ) else {
            continue;
        };
        let weight = emitter.radiance.element_sum() * emitter.area;
        let mut extent = Extent::of_primitive(first, scene.normal(id, first.bounds().min), weight);
        extent.bounds = others.iter().map(Primitive::bounds).fold(extent.bounds, Bounds::union);
        near.push((number, extent));
    }
    for (sky, number) in scene.sky.iter().zip(&mut numbers) {
        far.push((number, PI * sky.mean().element_sum()));
    }
    for (bulb, number) in scene.bulbs.iter().zip(&mut numbers) {
        near.push((number, Extent::of_bulb(bulb)));
    }
    for (light, number) in scene.distant.iter().zip(&mut numbers) {
        far.push((number, light.irradiance.element_sum()));
    }
    hierarchy::build(&near, &far)
}

/// A choice of a light.
#[derive(Clone, Copy, Debug)]
pub enum Selection<'w, K: SceneKind> {
    /// In proportion to power, the same everywhere.
    ByPower(&'w PowerChoice<K>),
    /// By what the hierarchy says of a place, or all alike.
    ByPlace {
        /// The lights.
        lights: &'w [Light<K>],
        /// What the hierarchy says.
        view: TreeView<'w, u32, Group, Lit, f32>,
        /// How often they are chosen all alike.
        alike: f32,
    },
}

/// The choice of a number below `count` by a uniform, and the rest of that.
fn any(count: usize, u: f32) -> (usize, f32) {
    let scaled = u * count as f32;
    let index = (scaled as usize).min(count - 1);
    (index, (scaled - index as f32).clamp(0.0, 1.0 - 0.5 * f32::EPSILON))
}

impl<'w, K: SceneKind> Discrete<f32> for Selection<'w, K> {
    type Item<'a>
        = &'w Light<K>
    where
        Self: 'a;

    fn len(&self) -> usize {
        match self {
            Selection::ByPower(choice) => choice.len(),
            Selection::ByPlace { lights, .. } => lights.len(),
        }
    }

    #[inline]
    fn sample_reuse(&self, u: f32) -> (Choice<&'w Light<K>, f32>, f32) {
        match self {
            Selection::ByPower(choice) => Discrete::sample_reuse(choice, u),
            Selection::ByPlace { lights, view, alike } => {
                if u < *alike {
                    let (number, rest) = any(lights.len(), u / alike);
                    let by_place = view.probability(number);
                    return (chosen(lights, *alike, number, by_place), rest);
                }
                let (choice, rest) = view.sample_reuse((u - alike) / (1.0 - alike));
                (chosen(lights, *alike, *choice.item as usize, choice.probability), rest)
            }
        }
    }

    #[inline]
    fn get(&self, index: usize) -> Option<Choice<&'w Light<K>, f32>> {
        match self {
            Selection::ByPower(choice) => Discrete::get(choice, index),
            Selection::ByPlace { lights, view, alike } => {
                let by_place = view.get(index)?.probability;
                Some(chosen(lights, *alike, index, by_place))
            }
        }
    }
}

/// The light with a number, which has a probability by place, and that of being chosen like all others.
fn chosen<K: SceneKind>(
    lights: &[Light<K>],
    alike: f32,
    number: usize,
    by_place: f32,
) -> Choice<&Light<K>, f32> {
    let probability = alike / lights.len() as f32 + (1.0 - alike) * by_place;
    Choice { index: number, item: &lights[number], probability }
}
