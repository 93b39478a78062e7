//! What is integrated: the light transport along a path, apart from how it was sampled.

use std::cell::Cell;

use aether_core::prelude::*;
use aether_core::strategy::{Dirac, Strategy};
use aether_core::{Includes, PathIntegrand, PathView, RandomSequence, Vertex};
use glam::Vec3;

use crate::film_filter::FilmProfile;
use crate::kind::{Everything, SceneKind};
use crate::scene::vectors::is_finite;
use crate::scene::{Bounds, MARGIN};
use crate::strategies::{Aim, Pixel};
use crate::vertex::{Place, SceneVertex};
use crate::world::World;

/// The measurement of light as an integral over paths with area measure (Veach 1997, Eq. 8.7):
/// importance of the camera, geometry terms with visibility, scattering, emission. Vertices that are
/// infinitely far away have the measure of solid angle. A path that begins on a surface measures the radiance
/// that arrives there, per area of where it comes from.
///
/// The importance is that of a filter which is one everywhere, unless a pixel is aimed at ([`Radiance::aim`]): a pixel's
/// share of it is its [`Radiance::response`], so that what a path carries is computed once for all pixels that see it.
pub struct Radiance<'w, 's, K: SceneKind = Everything> {
    world: &'w World<'s, K>,
    /// What the geometry term of connected vertices is at most.
    most_geometry: f32,
    /// Whether paths end with what their last vertex emits.
    emission: bool,
    /// What film points are drawn for, if paths are estimated for that alone.
    aim: Option<Aim>,
    /// Where the path that is drawn for a pixel of an image is seen.
    drawn: Cell<Option<Vec2<f32>>>,
    /// What was seen last, each at a place that follows from its position.
    sights: [Cell<Option<Seen>>; SIGHTS],
}

/// How many sights are remembered: so many more than a path from a light mostly has that few have the same place.
const SIGHTS: usize = 64;

/// A vertex that was looked for from an eye, and where it is seen if it is.
type Seen = (Look, Option<Sight>);

/// Who looks at what: the bits of both positions, and the place of what is seen. What an eye sees of a vertex depends
/// on nothing else, as the position on a primitive tells the rest of a surface.
type Look = [u32; 7];

#[inline(always)]
fn look<K: SceneKind>(eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> Look {
    let place = match &seen.place {
        Place::Surface(surface) => surface.primitive.0,
        // Primitives have smaller numbers.
        Place::Camera => u32::MAX,
        Place::Parallel(_) => u32::MAX - 1,
        Place::Backdrop(_) => u32::MAX - 2,
        Place::Sky(_) => u32::MAX - 3,
        Place::Bulb(_) => u32::MAX - 4,
        Place::Distant(_) => u32::MAX - 5,
    };
    let (from, to) = (eye.position, seen.position);
    let [a, b, c] = [from.x.to_bits(), from.y.to_bits(), from.z.to_bits()];
    [a, b, c, to.x.to_bits(), to.y.to_bits(), to.z.to_bits(), place]
}

/// Where an eye sees a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// The point of the film, in pixels of the image.
    pub film: Vec2<f32>,
    /// The density at the vertex, in its measure, of what has the density one per film area.
    density: f32,
}

impl<'w, 's, K: SceneKind> Radiance<'w, 's, K> {
    /// The integrand of a scene.
    pub fn new(world: &'w World<'s, K>) -> Self {
        let sights = [const { Cell::new(None) }; SIGHTS];
        let (most_geometry, emission, drawn) = (f32::INFINITY, true, Cell::new(None));
        Radiance { world, most_geometry, emission, aim: None, drawn, sights }
    }

    /// The integrand with the geometry terms of edges that no ray has found cut off: biased, but without the
    /// spikes of connections across short distances.
    pub fn clamped(world: &'w World<'s, K>, most_geometry: f32) -> Self {
        Radiance { most_geometry, ..Radiance::new(world) }
    }

    /// What paths from the camera would carry of any radiance that their last vertices send back: the same
    /// without emission.
    pub fn throughput(world: &'w World<'s, K>) -> Self {
        Radiance { emission: false, ..Radiance::new(world) }
    }

    /// Has the importance be that of what film points are drawn for from now on, of paths that are estimated for that alone:
    /// [`Aim::Pixel`] for the filter of a pixel; [`Aim::Image`] for one, but for points that are not drawn for that pixel
    /// ([`FilmProfile::radius`]). With `None` it is one again.
    pub fn aim(&mut self, aim: Option<Aim>) {
        self.aim = aim;
        self.drawn.set(None);
    }

    /// The film point of what was seen last since [`Radiance::aim`] for [`Aim::Image`], if it is one that is drawn for the
    /// pixel.
    pub fn drawn_film_point(&self) -> Option<Vec2<f32>> {
        self.drawn.get()
    }

    /// The importance that the eye sends to what it sees, for a filter of one or of what is aimed at: per film area (and lens
    /// area), brought to the measure of the vertex by the derived change of measure, so that cosines and distances
    /// are included. Zero for what it does not see, visibility aside.
    fn importance(&self, eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> f32 {
        // What is seen by a path of one sample alone is not asked for again.
        let sight = match self.aim {
            Some(_) => self.found(eye, seen),
            None => self.sight(eye, seen),
        };
        let Some(sight) = sight else { return 0.0 };
        let response = match self.aim {
            Some(Aim::Pixel(pixel)) => self.response_at(pixel, &sight, [eye, seen]),
            Some(Aim::Image(pixel)) => {
                let drawn = self.drawn_for(pixel, &sight, [eye, seen]);
                self.drawn.set(drawn);
                drawn.map_or(0.0, |_| 1.0)
            }
            _ => 1.0,
        };
        response * (self.world.filter_scale * sight.density)
    }

    /// Where an eye sees a vertex, visibility aside: remembered, as the response and the importance of a path and the
    /// pixels that receive it all follow from it.
    pub fn sight(&self, eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> Option<Sight> {
        let look = look(eye, seen);
        // An odd factor; the upper bits of a product depend on all others.
        let mixed =
            (look[3] ^ look[4].rotate_left(11) ^ look[5].rotate_left(22)).wrapping_mul(0x9e37_79b9);
        let place = &self.sights[(mixed >> 26) as usize % SIGHTS];
        if let Some((known, sight)) = place.get()
            && known == look
        {
            return sight;
        }
        let sight = self.found(eye, seen);
        place.set(Some((look, sight)));
        sight
    }

    /// The same, not remembered.
    fn found(&self, eye: &SceneVertex<K>, seen: &SceneVertex<K>) -> Option<Sight> {
        let mut sight = None;
        film_points(self.world, eye, seen, |film, density| {
            sight = Some(Sight { film, density });
        });
        // A surface seen exactly from its edge has no density, and is not seen.
        sight.filter(|sight| sight.density > 0.0 && sight.density < f32::INFINITY)
    }

    /// The scene.
    pub fn world(&self) -> &'w World<'s, K> {
        self.world
    }

    /// The value of a pixel's filter at the film point where a path's second vertex is seen from its
    /// first; zero if it is not.
    pub fn response<S: Strategy<SceneVertex<K>>>(
        &self,
        pixel: Pixel,
        path: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> f32 {
        match (path.vertex(0), path.vertex(1)) {
            (Some(eye), Some(seen)) => self.response_to(pixel, [&eye, &seen]),
            _ => 0.0,
        }
    }

    /// The film point, in pixels of the image, where a path's second vertex is seen from its first.
    pub fn film_point<S: Strategy<SceneVertex<K>>>(
        &self,
        path: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> Option<Vec2<f32>> {
        Some(self.sight(&path.vertex(0)?, &path.vertex(1)?)?.film)
    }

    /// The same, if it is one that is drawn for a pixel ([`FilmProfile::radius`]), as it is to within rounding. Whether the
    /// pixel's own filter reaches so far does not matter: another's may.
    pub fn own_film_point<S: Strategy<SceneVertex<K>>>(
        &self,
        pixel: Pixel,
        path: &RandomSequence<'_, SceneVertex<K>, S>,
    ) -> Option<Vec2<f32>> {
        let (eye, seen) = (path.vertex(0)?, path.vertex(1)?);
        self.drawn_for(pixel, &self.sight(&eye, &seen)?, [&eye, &seen])
    }

    /// [`Radiance::own_film_point`] for an eye and what it sees.
    fn drawn_for(
        &self,
        pixel: Pixel,
        &Sight { film, .. }: &Sight,
        [eye, seen]: [&SceneVertex<K>; 2],
    ) -> Option<Vec2<f32>> {
        let centre = Vec2::new(pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5);
        let reach = self.world.film_profile().map_or(0.5, FilmProfile::radius);
        // A point on the rim may come back on the other side of it.
        let near = |x: f32, centre: f32, error: &dyn Fn() -> f32| {
            let off = (x - centre).abs();
            let is_near = off <= reach || off <= reach + error();
            is_near.then(|| x.clamp(centre - reach, centre + reach))
        };
        let error = || self.film_error(eye, seen, [film, centre]);
        let across = near(film.x, centre.x, &|| error().x)?;
        Some(Vec2::new(across, near(film.y, centre.y, &|| error().y)?))
    }

    /// [`Radiance::response`] for an eye and what it sees.
    fn response_to(&self, pixel: Pixel, [eye, seen]: [&SceneVertex<K>; 2]) -> f32 {
        self.sight(eye, seen).map_or(0.0, |sight| self.response_at(pixel, &sight, [eye, seen]))
    }

    /// The value of a pixel's filter where an eye sees something.
    pub fn response_at(
        &self,
        pixel: Pixel,
        &Sight { film, .. }: &Sight,
        [eye, seen]: [&SceneVertex<K>; 2],
    ) -> f32 {
        let filter = self.world.scene.film.filter;
        let centre = Vec2::new(pixel.0 as f32 + 0.5, pixel.1 as f32 + 0.5);
        let reach = filter.radius();
        // A point that the filter's rim was sampled for may come back on the other side of it.
        let profile = |x: f32, error: &dyn Fn() -> f32| {
            let inside = x.abs() <= reach || x.abs() <= reach + error();
            filter.profile(if inside { x.clamp(-reach, reach) } else { x })
        };
        let across = profile(film.x - centre.x, &|| self.film_error(eye, seen, [film, centre]).x);
        if across == 0.0 {
            return 0.0;
        }
        let response =
            across * profile(film.y - centre.y, &|| self.film_error(eye, seen, [film, centre]).y);
        // What lies too far away for its direction to be known is not seen.
        if response.is_finite() { response } else { 0.0 }
    }

    /// By how much rounding of what is seen and of its direction can move a film point from one of two to the other,
    /// in pixels: much only for long lenses, and far from the axis, as seen from the rim of a lens in focus close by.
    fn film_error(
        &self,
        eye: &SceneVertex<K>,
        seen: &SceneVertex<K>,
        points: [Vec2<f32>; 2],
    ) -> Vec2<f32> {
        let size = eye.position.abs().max_element() + seen.position.abs().max_element();
        // Points of triangles are kept off the edges.
        let moved = seen.surface().map_or(0.0, |surface| {
            let Bounds { min, max } = self.world.scene.primitive(surface.primitive).bounds();
            2.0 * MARGIN as f32 * min.abs().max(max.abs()).max_element()
        });
        if let Some(film) = self.world.parallel() {
            let error = 8.0 * f32::EPSILON * (size + film.origin.abs().max_element()) + moved;
            return Vec2::new(error / film.across.length(), error / film.down.length());
        }
        let distance = if seen.is_infinite() { size } else { seen.position.distance(eye.position) };
        let angle = 8.0 * f32::EPSILON * (1.0 + size / distance) + moved / distance;
        let (centre, scale) = (self.world.film_centre(eye), self.world.film_scale());
        // The derivative of a tangent, along the steepest way, at the point that is nearer to the axis: were it far
        // from the other one, that would move by more than it is off.
        let steepness = points.map(|film| {
            let (x, y) = ((film.x - centre.x) * scale.x, (film.y - centre.y) * scale.y);
            1.0 + x * x + y * y
        });
        let moved = angle * steepness[0].min(steepness[1]);
        Vec2::new(moved / scale.x, moved / scale.y)
    }

    /// Scattering at `here` between its neighbours, times the cosines and inverse square distance of
    /// the edge to `next`; that of an atom is stated as the strategy of scattering states it.
    fn transport(
        &self,
        before: &SceneVertex<K>,
        here: &SceneVertex<K>,
        next: &SceneVertex<K>,
        atom: bool,
        most_geometry: f32,
    ) -> Vec3 {
        let Some(scattering) = self.world.scattering(here, before) else { return Vec3::ZERO };
        let along = next.direction_from(here.position);
        let geometry = geometry(here, next, along);
        let geometry = if geometry < most_geometry { geometry } else { most_geometry };
        let scattered = if atom { scattering.atoms(along) } else { scattering.value(along) };
        let value = scattered * geometry;
        if is_finite(value) { value } else { Vec3::ZERO }
    }
}

/// The cosine at `next`, which is seen in direction `along`, over the squared distance, as far as there is
/// either: solid angle at `here` per measure of `next`.
fn geometry<K: SceneKind>(here: &SceneVertex<K>, next: &SceneVertex<K>, along: Vec3) -> f32 {
    let squared = next.position.distance_squared(here.position);
    match next.place {
        // Seen by the eye: that is the importance.
        Place::Camera | Place::Parallel(_) | Place::Backdrop(_) => 0.0,
        Place::Surface(target) => target.normal.dot(along).abs() / squared,
        Place::Bulb(_) => 1.0 / squared,
        Place::Sky(_) | Place::Distant(_) => 1.0,
    }
}

/// Calls `visit` with the film points, in pixels of the image, from which an eye sees a vertex, and with the density at the
/// vertex, in its measure, of what has the density one per film area. There is one such point or none.
pub fn film_points<K: SceneKind>(
    world: &World<'_, K>,
    eye: &SceneVertex<K>,
    seen: &SceneVertex<K>,
    visit: impl FnMut(Vec2<f32>, f32),
) {
    if let Some(film) = world.parallel() {
        let to_point = match seen.place {
            Place::Surface(surface) => surface.seen_by(&film),
            Place::Backdrop(_) => film.backdrop(),
            _ => return,
        };
        if let Some(point) = seen.point().part() {
            preimages(&to_point, &point, visit);
        }
        return;
    }
    let to_direction = world.film_to_direction(eye);
    if let Some(surface) = seen.surface() {
        if let Some(point) = seen.point().part() {
            preimages(&to_direction.then(surface.seen_from(eye.position)), &point, visit);
        }
    } else if let Some(direction) = seen.point().part() {
        preimages(&to_direction, &direction, visit);
    }
}

fn preimages<M: Map<f32, Source = Vec2<f32>>>(
    map: &M,
    x: &M::Target,
    mut visit: impl FnMut(Vec2<f32>, f32),
) {
    map.preimages_pushed(x, |film: Vec2<f32>, density, exists| {
        if exists {
            visit(film, density);
        }
    });
}

impl<K: SceneKind> PathIntegrand for Radiance<'_, '_, K> {
    type Vertex = SceneVertex<K>;
    type Value = Vec3;

    #[inline(always)]
    fn extend(&self, path: PathView<'_, SceneVertex<K>>) -> Vec3 {
        let copies = &mut [None; 3];
        let [Some(new), Some(here), before] = path.lend(copies) else { return Vec3::ONE };
        let last = path.len() - 1;
        let visible = path.visible(last);
        let most_geometry = if visible { f32::INFINITY } else { self.most_geometry };
        let factor = match before {
            None if here.surface().is_some() => {
                let along = new.direction_from(here.position);
                Vec3::splat(geometry(here, new, along))
            }
            None => Vec3::splat(self.importance(here, new)),
            Some(before) => {
                let atom = path.carries(last - 1, Dirac::Direction);
                self.transport(before, here, new, atom, most_geometry)
            }
        };
        // The shadow ray comes last: most factors that vanish do so without it.
        let sees = || visible || self.world.visible(here, new);
        if factor != Vec3::ZERO && sees() { factor } else { Vec3::ZERO }
    }

    #[inline(always)]
    fn end(&self, path: PathView<'_, SceneVertex<K>>) -> Vec3 {
        if !self.emission {
            return Vec3::ONE;
        }
        match path.lend(&mut [None; 2]) {
            [Some(last), Some(before)] if last.is_light() => self.world.emitted(last, before),
            _ => Vec3::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::PathArena;
    use crate::scene::{Filter, Scene};
    use crate::subpaths::camera_path;

    #[test]
    fn densities_of_film_points_are_one_over_the_change_of_measure() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/scenes/cornell-box.xml");
        let scene = Scene::load(file.as_ref(), &[]).unwrap();
        let world = World::<Everything>::new(&scene).unwrap();
        let (radiance, eye) = (Radiance::new(&world), SceneVertex::eye(world.eye()));
        let (width, height) = (scene.film.width as f32, scene.film.height as f32);
        for (across, down) in [(0.1, 0.2), (0.5, 0.5), (0.4, 0.7), (0.6, 0.9), (0.9, 0.4)] {
            let film = Vec2::new(across * width, down * height);
            let to_direction = world.film_to_direction(&eye);
            let hit = world.hit(&eye, &to_direction.apply(&film)).unwrap();
            let change = to_direction.then(hit.seen_from(eye.position)).jacobian(&film);
            let sight = radiance.sight(&eye, &SceneVertex::on(hit)).unwrap();
            assert!((sight.density * change - 1.0).abs() < 1e-5, "{sight:?} {change}");
            assert!((sight.film.x - film.x).abs().max((sight.film.y - film.y).abs()) < 1e-2);
        }
    }

    #[test]
    fn film_points_beyond_the_filter_of_their_own_pixel_count_for_others() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/scenes/tent-filter.xml");
        let mut scene = Scene::load(file.as_ref(), &[]).unwrap();
        // No whole number of cells of the table that film points are drawn by.
        scene.film.filter = Filter::Tent { radius: 2.3 };
        let world = World::<Everything>::new(&scene).unwrap();
        let (radiance, arena, pixel) = (Radiance::new(&world), PathArena::new(), (30, 33));
        let last = 1.0 - f32::EPSILON / 2.0;
        let path = camera_path(&world, &arena, &mut || last, Aim::Image(pixel), (2, 5));
        let film = radiance.film_point(&path).unwrap();
        assert!(film.x > 30.5 + 2.3 && film.y > 33.5 + 2.3, "{film:?}");
        assert_eq!(radiance.response(pixel, &path), 0.0);
        let own = radiance.own_film_point(pixel, &path);
        assert!(own.is_some_and(|own| (own.x - film.x).abs().max((own.y - film.y).abs()) < 1e-4));
        // What is drawn for another pixel is none.
        assert_eq!(radiance.own_film_point((35, 33), &path), None);
    }
}
