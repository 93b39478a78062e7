//! The vertices of light paths, and what external code tells about them.

use aether_core::prelude::*;
use aether_core::{Includes, Recall, Vertex};
use glam::{Vec2, Vec3 as Vector};

use crate::eye::{BACKDROP, LENS, ParallelFilm};
use crate::kind::{Either, Everything, Oriented, Presence, SceneKind, With};
use crate::samplers::{HitPlane, ParallelHit, hit_plane};
use crate::scene::vectors::try_unit;
use crate::scene::{PrimitiveId, Tangents};

/// A piece of surface, as a ray cast found it: constant near the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface<K: SceneKind = Everything> {
    /// Where the ray met it.
    pub position: Vector,
    /// Unit normal of the surface.
    pub normal: Vector,
    /// Unit normal for shading.
    pub shading: Vector,
    /// Which primitive of the scene it is.
    pub primitive: PrimitiveId,
    /// Which emitter of the scene it is, if it is one.
    pub emitter: Option<u32>,
    /// Texture coordinates, if the kind of scene has textures.
    pub uv: <K::Textures as Presence>::Field<Vec2>,
    /// How texture coordinates run over it, if the kind of scene has materials that depend on this.
    pub tangents: <Oriented<K> as Presence>::Field<Tangents>,
}

impl<K: SceneKind> Surface<K> {
    /// Where rays from `origin` meet this piece of surface: the map from directions to its points.
    pub fn seen_from(&self, origin: Vector) -> HitPlane<f32> {
        let normal = Direction::from_unit(self.normal.into());
        hit_plane(origin.into(), self.position.into(), normal, self.id())
    }

    /// Where the parallel rays of a film meet this piece of surface: the map from points of the film.
    pub fn seen_by(&self, film: &ParallelFilm) -> ParallelHit<f32> {
        film.onto(self.position, self.normal, self.id())
    }

    /// Its identity in the language: that of the light, if it is one.
    pub fn id(&self) -> SurfaceId {
        self.emitter.map_or(SurfaceId(self.primitive.0), light_id)
    }
}

/// Whether a kind of scene has light from all around.
pub type SkyOf<K> = Either<<K as SceneKind>::Constant, <K as SceneKind>::Envmap>;

/// Whether a kind of scene has light from infinitely far away.
type Infinity<K> = Either<SkyOf<K>, <K as SceneKind>::Directional>;

/// What lies in some direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seen<K: SceneKind = Everything> {
    /// A surface.
    Surface(Surface<K>),
    /// Nothing but the sky.
    Sky(SkyOf<K>),
}

impl<K: SceneKind> Seen<K> {
    /// The surface, if it is one.
    #[inline]
    pub fn surface(self) -> Option<Surface<K>> {
        match self {
            Seen::Surface(surface) => Some(surface),
            Seen::Sky(_) => None,
        }
    }
}

/// The eye of a camera that is an atom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye<K: SceneKind = Everything> {
    /// A pinhole, at a position.
    Pinhole(Vector),
    /// Infinitely far away, in a direction of unit length: a parallel projection.
    Parallel(With<K::Orthographic, Vector>),
}

/// A light that is an atom: which of the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lamp<K: SceneKind = Everything> {
    /// A point, at a position.
    Bulb(With<K::Point, (u32, Vector)>),
    /// Infinitely far away, in a direction of unit length.
    Distant(With<K::Directional, (u32, Vector)>),
}

/// What kind of place a vertex is at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place<K: SceneKind = Everything> {
    /// The pinhole, or a point of the lens.
    Camera,
    /// The eye of a parallel projection, infinitely far away: the position is the direction there.
    Parallel(K::Orthographic),
    /// The sky behind everything in a parallel projection, where each point of the film looks in the same
    /// direction: the position is that of the film point, in a plane across the direction.
    Backdrop(With<K::Orthographic, SkyOf<K>>),
    /// A point of a surface.
    Surface(Surface<K>),
    /// Infinitely far away: the position is a direction.
    Sky(SkyOf<K>),
    /// A point light, by its number.
    Bulb(With<K::Point, u32>),
    /// A light infinitely far away, by its number: the position is a direction.
    Distant(With<K::Directional, u32>),
}

/// A vertex of a light path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneVertex<K: SceneKind = Everything> {
    /// Where it is; for a place infinitely far away the direction there, of unit length.
    pub position: Vector,
    /// What is there.
    pub place: Place<K>,
}

impl<K: SceneKind> SceneVertex<K> {
    /// The vertex at an eye that is an atom.
    pub fn eye(eye: Eye<K>) -> Self {
        match eye {
            Eye::Pinhole(position) => SceneVertex { position, place: Place::Camera },
            Eye::Parallel(towards) => {
                let place = K::Orthographic::VALUE.map_or(Place::Camera, Place::Parallel);
                SceneVertex { position: K::Orthographic::get(towards), place }
            }
        }
    }

    /// A point of the lens.
    pub fn on_lens(point: SurfacePoint<f32>) -> Self {
        SceneVertex { position: point.position.into(), place: Place::Camera }
    }

    /// The sky that a point of the film of a parallel projection sees.
    pub fn backdrop(sky: SkyOf<K>, point: SurfacePoint<f32>) -> Self {
        let place = K::Orthographic::with(|| sky).map_or(Place::Camera, Place::Backdrop);
        SceneVertex { position: point.position.into(), place }
    }

    /// The vertex where a ray met a surface. The ray caster computes the position on the primitive,
    /// more accurately than along the ray: `point`, the same position in the language, gives way.
    pub fn hit(surface: Surface<K>, _point: SurfacePoint<f32>) -> Self {
        Self::on(surface)
    }

    /// A vertex on a surface that was chosen rather than found: a point of a light.
    pub fn on(surface: Surface<K>) -> Self {
        SceneVertex { position: surface.position, place: Place::Surface(surface) }
    }

    /// The sky in some direction.
    pub fn sky(sky: SkyOf<K>, w: Direction<f32>) -> Self {
        SceneVertex { position: w.vec().into(), place: Place::Sky(sky) }
    }

    /// A light that is an atom.
    pub fn lamp(lamp: Lamp<K>) -> Self {
        match lamp {
            Lamp::Bulb(bulb) => Self::bulb(K::Point::get(bulb)),
            Lamp::Distant(light) => Self::distant(K::Directional::get(light)),
        }
    }

    fn bulb((index, position): (u32, Vector)) -> Self {
        let place = K::Point::with(|| index).map_or(Place::Camera, Place::Bulb);
        SceneVertex { position, place }
    }

    fn distant((index, towards): (u32, Vector)) -> Self {
        let place = K::Directional::with(|| index).map_or(Place::Camera, Place::Distant);
        SceneVertex { position: towards, place }
    }

    /// The surface that it lies on, if it does.
    #[inline]
    pub fn surface(&self) -> Option<Surface<K>> {
        match self.place {
            Place::Surface(surface) => Some(surface),
            _ => None,
        }
    }

    /// The primitive that the vertex lies on.
    #[inline]
    pub fn primitive(&self) -> Option<PrimitiveId> {
        match &self.place {
            Place::Surface(surface) => Some(surface.primitive),
            _ => None,
        }
    }

    /// Whether it is an eye, or a point of the lens.
    #[inline]
    pub fn is_eye(&self) -> bool {
        matches!(self.place, Place::Camera | Place::Parallel(_))
    }

    /// Whether it may emit light: a lamp, the sky, or a surface that shines.
    pub fn is_light(&self) -> bool {
        match self.place {
            Place::Camera | Place::Parallel(_) => false,
            Place::Surface(surface) => surface.emitter.is_some(),
            Place::Backdrop(_) | Place::Sky(_) | Place::Bulb(_) | Place::Distant(_) => true,
        }
    }

    /// Whether it is infinitely far away.
    #[inline]
    pub fn is_infinite(&self) -> bool {
        matches!(self.place, Place::Sky(_) | Place::Distant(_) | Place::Parallel(_))
    }

    /// The way from a point to the vertex: of unit length if it is infinitely far away.
    #[inline]
    pub fn offset_from(&self, origin: Vector) -> Vector {
        if self.is_infinite() { self.position } else { self.position - origin }
    }

    /// The direction, of unit length, in which the vertex is seen from a point; zero from where it is.
    #[inline]
    pub fn direction_from(&self, origin: Vector) -> Vector {
        if self.is_infinite() {
            return self.position;
        }
        try_unit(self.position - origin).unwrap_or(Vector::ZERO)
    }
}

/// The identity in the language of the emitter with this number: one for both halves of a rectangle. Numbers of
/// primitives are smaller.
pub fn light_id(emitter: u32) -> SurfaceId {
    SurfaceId(1 << 31 | emitter)
}

/// The space that vertices live in: surfaces, and the sphere of directions for what is infinitely far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spot<K: SceneKind = Everything> {
    /// A point of a surface.
    Surface(SurfacePoint<f32>),
    /// A direction.
    Infinite(With<Infinity<K>, Direction<f32>>),
}

impl<K: SceneKind> Includes<SurfacePoint<f32>> for Spot<K> {
    #[inline]
    fn part(&self) -> Option<SurfacePoint<f32>> {
        match self {
            Spot::Surface(point) => Some(*point),
            Spot::Infinite(_) => None,
        }
    }
}

impl<K: SceneKind> Includes<Direction<f32>> for Spot<K> {
    #[inline]
    fn part(&self) -> Option<Direction<f32>> {
        match self {
            Spot::Surface(_) => None,
            Spot::Infinite(w) => Some(Infinity::<K>::get(*w)),
        }
    }
}

impl<K: SceneKind> Vertex for SceneVertex<K> {
    type Real = f32;
    type Point = Spot<K>;

    #[inline]
    fn point(&self) -> Spot<K> {
        let direction = || Direction::from_unit(self.position.into());
        if matches!(self.place, Place::Sky(_) | Place::Distant(_))
            && let Some(direction) = Infinity::<K>::with(direction)
        {
            return Spot::Infinite(direction);
        }
        let id = match self.place {
            Place::Surface(surface) => surface.id(),
            Place::Backdrop(_) => BACKDROP,
            _ => LENS,
        };
        Spot::Surface(SurfacePoint::new(self.position.into(), id))
    }
}

impl<K: SceneKind> Recall<Seen<K>> for SceneVertex<K> {
    #[inline]
    fn recall(&self) -> Option<Seen<K>> {
        match self.place {
            Place::Surface(surface) => Some(Seen::Surface(surface)),
            Place::Sky(sky) => Some(Seen::Sky(sky)),
            Place::Backdrop(sky) => Some(Seen::Sky(K::Orthographic::get(sky))),
            _ => None,
        }
    }
}

impl<K: SceneKind> Recall<Surface<K>> for SceneVertex<K> {
    #[inline]
    fn recall(&self) -> Option<Surface<K>> {
        self.surface()
    }
}

impl<K: SceneKind> Recall<Eye<K>> for SceneVertex<K> {
    fn recall(&self) -> Option<Eye<K>> {
        match self.place {
            Place::Camera => Some(Eye::Pinhole(self.position)),
            Place::Parallel(_) => K::Orthographic::with(|| self.position).map(Eye::Parallel),
            _ => None,
        }
    }
}

impl<K: SceneKind> Recall<Lamp<K>> for SceneVertex<K> {
    fn recall(&self) -> Option<Lamp<K>> {
        match self.place {
            Place::Bulb(index) => {
                let index = K::Point::get(index);
                K::Point::with(|| (index, self.position)).map(Lamp::Bulb)
            }
            Place::Distant(index) => {
                let index = K::Directional::get(index);
                K::Directional::with(|| (index, self.position)).map(Lamp::Distant)
            }
            _ => None,
        }
    }
}
