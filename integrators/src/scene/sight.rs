//! What rays meet of a scene: the nearest surface, or whether there is any.

use std::convert::identity;

use glam::Vec3;

use super::Scene;
use super::model::PrimitiveId;
use super::segment::{End, On};
use super::simd::{At, Eight, Task, plainly};
use super::stack::Room;
use super::surface::Hit;
use super::trace::Tracer;
use super::vectors::is_finite;
use crate::work::{count_nearest, count_occlusion};

/// What rays meet of a scene.
#[derive(Clone, Copy)]
pub struct Sight<'s> {
    pub(super) scene: &'s Scene,
    pub(super) tracer: &'s Tracer,
}

impl<'s> Sight<'s> {
    /// [`Scene::intersect`] of these surfaces.
    pub fn intersect(
        self,
        origin: Vec3,
        direction: Vec3,
        skip: Option<PrimitiveId>,
    ) -> Option<Hit> {
        self.intersect_then(origin, direction, skip, identity)
    }

    /// The same with what becomes of the hit or of there being none, which is computed on the way: what is
    /// not asked of a hit costs nothing.
    #[inline(always)]
    pub fn intersect_then<T>(
        self,
        origin: Vec3,
        direction: Vec3,
        skip: Option<PrimitiveId>,
        then: impl FnOnce(Option<Hit>) -> T,
    ) -> T {
        count_nearest();
        let ray = Cast { sight: self, from: End { point: origin, on: skip }, direction, then };
        self.tracer.machine().run(ray)
    }

    /// [`Scene::visible`] among these surfaces.
    #[inline(always)]
    pub fn visible(
        self,
        a: Vec3,
        a_primitive: Option<PrimitiveId>,
        b: Vec3,
        b_primitive: Option<PrimitiveId>,
    ) -> bool {
        if !(is_finite(a) && is_finite(b)) {
            return false;
        }
        count_occlusion();
        let (from, to) = (End { point: a, on: a_primitive }, End { point: b, on: b_primitive });
        self.tracer.machine().run(Between { sight: self, from, to })
    }

    /// [`Scene::is_open`] among these surfaces.
    pub fn is_open(self, from: Vec3, on: Option<PrimitiveId>, direction: Vec3) -> bool {
        count_occlusion();
        let from = End { point: from, on };
        self.tracer.machine().run(Outwards { sight: self, from, direction })
    }
}

/// Finds what a ray meets first, and what becomes of it.
struct Cast<'a, F> {
    sight: Sight<'a>,
    from: End,
    direction: Vec3,
    then: F,
}

impl<T, F: FnOnce(Option<Hit>) -> T> Task for Cast<'_, F> {
    type Output = T;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> T {
        let (Sight { scene, tracer }, direction) = (self.sight, self.direction);
        let start = scene.end(self.from);
        let hit = match tracer.nearest::<E>(at, start, direction) {
            Some(raw) => Some(scene.hit(self.from.point, direction, &raw)),
            None => None,
        };
        (self.then)(hit)
    }

    fn run_plainly(self, room: &Room) -> T {
        let Cast { sight, from, direction, then } = self;
        then(plainly(Cast { sight, from, direction, then: identity::<Option<Hit>> }, room))
    }
}

/// Finds whether nothing lies between two points.
struct Between<'a> {
    sight: Sight<'a>,
    from: End,
    to: End,
}

impl Task for Between<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> bool {
        let Sight { scene, tracer } = self.sight;
        tracer.unoccluded::<E>(at, scene.end(self.from), scene.end(self.to))
    }
}

/// Finds whether a ray meets nothing.
struct Outwards<'a> {
    sight: Sight<'a>,
    from: End,
    direction: Vec3,
}

impl Task for Outwards<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<E: Eight>(self, at: At<'_, E>) -> bool {
        let Sight { scene, tracer } = self.sight;
        tracer.is_open::<E>(at, scene.end(self.from), self.direction)
    }
}

impl Scene {
    /// An end of a ray with the surface that it lies on.
    #[inline(always)]
    fn end(&self, end: End) -> (End, Option<On>) {
        (end, end.on.map(|id| self.on(id, end.point)))
    }

    /// A surface at a point of it.
    #[inline(always)]
    fn on(&self, id: PrimitiveId, point: Vec3) -> On {
        let facts = &self.facts[id.0 as usize];
        if facts.is_round { self.on_round(id, point) } else { facts.plane }
    }

    // Out of the way of the code for planes.
    #[inline(never)]
    fn on_round(&self, id: PrimitiveId, point: Vec3) -> On {
        let round = self.primitive(id);
        On::new(round, round.normal(point))
    }
}
