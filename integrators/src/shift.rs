//! The shift of gradient-domain path tracing (Kettunen, Manzi, Aittala, Lehtinen, Durand and Zwicker 2015): a
//! function from a path to a similar one through another point of the film.
//!
//! The film point moves; at a mirror or a pane the shifted path follows the lobe of the base path, elsewhere it
//! copies the half vector, until both can see the same rest of the base path: from the first two vertices in
//! succession that are rough, the rest is kept. Each new vertex is drawn by a strategy about what is copied, by
//! the middle of its uniforms. Forwards and backwards these strategies have the same density in terms of
//! what they draw, so that the change of measure is the ratio of their conditional densities (Aether 2017,
//! Eq. 7), which are derived; of what is kept it is one.
//!
//! A shift is undone by the shift back. Where that is not so, because the way back would keep another vertex
//! or meet something else, there is no shifted path. Nor is there one whose first vertices do not see the rest,
//! unless that is only a point of a light: next-event estimation would make such a path, though a black one.

use aether_core::combine::Shifted;
use aether_core::prelude::Vec2;
use aether_core::{Arena, RandomSequence, strategies};

use crate::half_vectors::{HalfVector, SampleHalfVector, sample_half_vector};
use crate::kind::{Everything, SceneKind};
use crate::strategies::{
    Aim, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf,
    sample_camera_direction,
};
use crate::subpaths::is_atom;
use crate::vertex::{Place, SceneVertex};
use crate::world::World;

strategies! {
    /// How paths are made and shifted.
    #[derive(Clone)]
    pub enum ShiftStrategies<'a, K: SceneKind = Everything> for SceneVertex<K> {
        /// The eye.
        Camera(SampleCamera<'a, 'a, K>),
        /// What the camera sees.
        CameraDirection(SampleCameraDirection<'a, 'a, K>),
        /// Scattering.
        Bsdf(SampleBsdf<'a, 'a, K>),
        /// Next-event estimation.
        Light(SampleLight<'a, 'a, K>),
        /// Scattering by a given half vector.
        HalfVector(SampleHalfVector<'a, 'a, K>),
    }
}

/// A path, with the strategies of shifts.
pub type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, ShiftStrategies<'a, K>>;
/// Where they are.
pub type PathArena<'a, K> = Arena<SceneVertex<K>, ShiftStrategies<'a, K>>;

/// Moves paths on the film.
#[derive(Clone, Copy)]
pub struct Shift<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// By how many pixels, to the right and down.
    pub by: (f32, f32),
    /// Where the roughness of a surface is at least this, shifted paths may meet base paths.
    pub rough: f32,
}

/// The beginning of a shifted path, up to where it meets the base path.
#[derive(Clone, Copy)]
pub struct Beginning<'r, 'a, K: SceneKind> {
    /// The vertices that are not those of the base path, and the eye.
    new: Path<'r, 'a, K>,
    jacobian: f32,
    /// Whether all that follows is that of the base path.
    joined: bool,
}

/// How wide half vectors are drawn about the one that is copied. It cancels; to invert them within rounding it must
/// be large against that.
const WIDTH: f32 = 0.125;

impl<K: SceneKind> Beginning<'_, '_, K> {
    /// Whether it has met the base path, all further vertices of which are kept.
    pub fn is_joined(&self) -> bool {
        self.joined
    }
}

impl<'a, K: SceneKind> Shift<'a, K> {
    /// The eye of a path, which stays.
    pub fn begin<'r>(&self, base: &Path<'r, 'a, K>) -> Beginning<'r, 'a, K> {
        Beginning { new: base.slice(0..1), jacobian: 1.0, joined: false }
    }

    /// The beginning with one vertex more, if it has not met the base path, whose vertex at this place is not
    /// the last one. It depends on the base path up to there, and on whether that leaves from there by an atom.
    pub fn extend<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Beginning<'r, 'a, K>> {
        let i = beginning.new.len();
        let meets = |other: &Path<'r, 'a, K>| {
            self.may_join(beginning, base) && self.is_rough(other, i) && !is_atom(base, i)
        };
        if beginning.joined {
            return Some(*beginning);
        }
        if meets(base) {
            // Scattering finds only what it sees: no other way leads to such a path.
            let sees = self.world.visible(&beginning.new.last()?, &base.vertex(i)?);
            return sees.then_some(Beginning { joined: true, ..*beginning });
        }
        let longer = self.copy(beginning, base)?;
        // There the way back would have met it.
        if meets(&longer.new) { None } else { Some(longer) }
    }

    /// The shift of a path from a beginning of it with one vertex less, at least.
    pub fn finish<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>> {
        let n = beginning.new.len();
        let is_lamp = matches!(base.last()?.place, Place::Bulb(_) | Place::Distant(_));
        if beginning.joined || is_lamp || self.may_join(beginning, base) {
            let path = beginning.new.concat(&base.slice(n..base.len()));
            return Some(Shifted { path, jacobian: beginning.jacobian });
        }
        let Beginning { new: path, jacobian, .. } = self.copy(beginning, base)?;
        Some(Shifted { path, jacobian })
    }

    /// The shift of a whole path.
    pub fn apply<'r>(
        &self,
        base: &Path<'r, 'a, K>,
    ) -> Option<Shifted<'r, SceneVertex<K>, ShiftStrategies<'a, K>>> {
        let inner = base.len().checked_sub(2)?;
        let beginning = (0..inner).try_fold(self.begin(base), |b, _| self.extend(&b, base))?;
        self.finish(&beginning, base)
    }

    /// The beginning with a new vertex that does what that of the base path does.
    fn copy<'r>(
        &self,
        beginning: &Beginning<'r, 'a, K>,
        base: &Path<'r, 'a, K>,
    ) -> Option<Beginning<'r, 'a, K>> {
        let i = beginning.new.len();
        let [there, back] = self.strategies(base, i)?;
        let (mut new, mut way_back) = (beginning.new, base.slice(0..i));
        new.append(there).sample(&mut || 0.5);
        way_back.append(back);
        if !new.is_complete() || is_atom(&new, i - 1) != is_atom(base, i - 1) {
            return None;
        }
        let density_back = way_back.pdf_of(&base.slice(0..=i)) / base.slice(0..i).pdf();
        let jacobian = beginning.jacobian * density_back.value() / new.conditional(i)?;
        let regular = jacobian > 0.0 && jacobian < f32::INFINITY;
        regular.then_some(Beginning { new, jacobian, joined: false })
    }

    /// What makes vertex `i` of the shifted path, and what makes that of the base path on the way back.
    fn strategies(&self, base: &Path<'_, 'a, K>, i: usize) -> Option<[ShiftStrategies<'a, K>; 2]> {
        let (world, [here, next]) = (self.world, [base.vertex(i - 1)?, base.vertex(i)?]);
        if i == 1 {
            let film = world.film_point(&here, &next)?;
            let moved = Vec2::new(film.x + self.by.0, film.y + self.by.1);
            return Some(
                [moved, film].map(|p| sample_camera_direction(world, Aim::About(p)).into()),
            );
        }
        let before = base.vertex(i - 2)?;
        if is_atom(base, i - 1) {
            let lobe = world.mirror_between(&before, &here, &next)?;
            let same = sample_bsdf(world, u32::MAX, Some(lobe));
            return Some([same.clone().into(), same.into()]);
        }
        // On the way back, a ray would have to find it.
        if !base.view().visible(i) && !world.visible(&here, &next) {
            return None;
        }
        let half = HalfVector::between(world, [&before, &here, &next], WIDTH)?;
        let same = sample_half_vector(world, half);
        Some([same.clone().into(), same.into()])
    }

    /// Whether the shifted path can go on to the next vertex of the base path from where it is: both are rough.
    fn may_join(&self, beginning: &Beginning<'_, 'a, K>, base: &Path<'_, 'a, K>) -> bool {
        let last = beginning.new.len() - 1;
        let rough = |path| self.is_rough(path, last);
        last > 0 && !is_atom(base, last) && rough(base) && rough(&beginning.new)
    }

    fn is_rough(&self, path: &Path<'_, 'a, K>, i: usize) -> bool {
        path.vertex(i).is_some_and(|vertex| self.world.roughness(&vertex) >= self.rough)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samplers::{hit_plane, pinhole, rotate};
    use crate::scattering::facets::{reflect, refract_in, refract_out};
    use crate::scene::Scene;
    use crate::strategies::sample_light;
    use crate::subpaths::camera_path;
    use aether_core::Pcg32;
    use aether_core::prelude::*;

    /// The surface coordinates, about a point, of what a map makes of the point with these surface coordinates.
    fn chart(origin: Vec3, axes: [Vec3; 2], p: [f64; 2]) -> Vec3 {
        origin + p[0] * axes[0] + p[1] * axes[1]
    }

    /// The change of measure of a map between planes by differences, at a point: forth and back.
    fn assert_jacobian(
        what: &str,
        (origin, axes): (Vec3, [Vec3; 2]),
        forth: impl Fn(Vec3) -> (Vec3, f64),
        back: impl Fn(Vec3) -> (Vec3, f64),
    ) {
        let (image, jacobian) = forth(origin);
        let (again, inverse) = back(image);
        assert!((again - origin).length() < 1e-12, "{what}: {again:?} is not {origin:?}");
        assert!((jacobian * inverse - 1.0).abs() < 1e-12, "{what}: {jacobian} {inverse}");
        let h = 1e-4;
        let slope = |axis: usize| {
            let at = |k: f64| {
                let mut p = [0.0; 2];
                p[axis] = k * h;
                forth(chart(origin, axes, p)).0
            };
            // Of fourth order.
            (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
        };
        let expected = slope(0).cross(slope(1)).length();
        assert!((jacobian / expected - 1.0).abs() < 1e-9, "{what}: {jacobian} {expected}");
    }

    /// From the point that one map meets to the point that the other meets, of the same half vector or film point
    /// moved by `by`, with the change of measure as the ratio of the derived ones.
    fn through<A, M>(from: &M, to: &M, moved: impl Fn(A) -> A, x: Vec3) -> (Vec3, f64)
    where
        A: Point<f64>,
        M: Map<f64, Source = A, Target = SurfacePoint>,
    {
        let mut result = None;
        from.preimages(&SurfacePoint::new(x, SurfaceId(1)), |h, exists| {
            if exists {
                let image = moved(h);
                let ratio = to.jacobian(&image) / from.jacobian(&h);
                result = Some((to.apply(&image).position, ratio));
            }
        });
        result.expect("a preimage")
    }

    /// The maps by which base path and shifted path meet a plane, each from a place and with a view of its own.
    #[test]
    fn half_vector_copies_and_film_shifts_have_the_jacobian_of_differences() {
        let unit = |x: f64, y: f64, z: f64| Direction::from_vec(Vec3::new(x, y, z).normalize());
        let frames = [unit(0.1, 0.2, 1.0), unit(-0.3, 0.1, 0.9)].map(Frame::around);
        let views = [unit(0.3, -0.2, 0.8), unit(0.42, -0.1, 0.7)];
        let places = [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.2, 0.1, 0.05)];
        let m = unit(0.15, 0.1, 1.0);
        macro_rules! check {
            ($what:expr, $maps:expr, $source:expr, $moved:expr, $unmoved:expr) => {{
                let [from, to] = $maps;
                let x = from.apply(&$source).position;
                let to_axes = {
                    let n = from.then_normal();
                    let frame = Frame::around(Direction::from_vec(n));
                    [
                        frame.to_world(Vec3::new(1.0, 0.0, 0.0)),
                        frame.to_world(Vec3::new(0.0, 1.0, 0.0)),
                    ]
                };
                assert_jacobian(
                    $what,
                    (x, to_axes),
                    |x| through(&from.map, &to.map, $moved, x),
                    |y| through(&to.map, &from.map, $unmoved, y),
                );
            }};
        }
        /// A map onto a plane, and the plane's normal.
        struct Onto<M> {
            map: M,
            normal: Vec3,
        }
        impl<M: Map<f64, Target = SurfacePoint>> Onto<M> {
            fn apply(&self, x: &M::Source) -> SurfacePoint {
                self.map.apply(x)
            }
            fn then_normal(&self) -> Vec3 {
                self.normal
            }
        }
        let onto = |i: usize, down: bool| {
            let z = if down { -1.0 } else { 1.0 };
            let normal = Vec3::new(0.2, -0.1, -z).normalize();
            let point = Vec3::new(0.1, 0.3, 2.0 * z) + i as f64 * Vec3::new(0.05, 0.0, 0.3);
            let plane = hit_plane(places[i], point, normal, SurfaceId(1));
            (rotate(frames[i]).then(plane), normal)
        };
        let half = [0, 1].map(|i| {
            let (plane, normal) = onto(i, false);
            Onto { map: reflect(views[i]).then(plane), normal }
        });
        check!("reflection", half, m, |h| h, |h| h);
        let into = [0, 1].map(|i| {
            let (plane, normal) = onto(i, true);
            Onto { map: refract_in(views[i], 1.0 / 1.5).unwrap().then(plane), normal }
        });
        check!("refraction into glass", into, m, |h| h, |h| h);
        let out = [0, 1].map(|i| {
            let (plane, normal) = onto(i, true);
            Onto { map: refract_out(views[i], 1.3).unwrap().then(plane), normal }
        });
        check!("refraction out of glass", out, m, |h| h, |h| h);
        let film = [0, 1].map(|i| {
            let (plane, normal) = onto(i, false);
            let eye = pinhole(Vec2::new(32.0, 24.0), Vec2::new(0.02, 0.02));
            Onto { map: eye.then(plane), normal }
        });
        let by = |p: Vec2, x: f64| Vec2::new(p.x + x, p.y);
        check!("film", film, Vec2::new(20.0, 30.5), |p| by(p, 1.0), |p| by(p, -1.0));
    }

    /// Paths of a scene from some pixels and next-event estimation, each of at most `longest` vertices.
    fn for_paths(
        scene: &str,
        longest: usize,
        mut visit: impl for<'r, 'a> FnMut(&'a World<'a, Everything>, &Path<'r, 'a, Everything>),
    ) {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes");
        let scene = Scene::load(&file.join(scene), &[]).unwrap();
        let world = World::new(&scene).unwrap();
        let mut arena = PathArena::new();
        for sample in 0..400 {
            arena.clear();
            let pixel = (8 + sample % 48, 8 + (sample * 7) % 48);
            let mut uniforms = Pcg32::new(5, u64::from(sample), 0);
            let camera = camera_path(&world, &arena, &mut uniforms, pixel, (longest, u32::MAX));
            for n in 2..=camera.len() {
                visit(&world, &camera.slice(0..n));
                let mut direct = camera.slice(0..n);
                direct.append(sample_light(&world)).sample(&mut uniforms);
                if direct.is_complete() && direct.len() <= longest {
                    visit(&world, &direct);
                }
            }
        }
    }

    /// Shifts of paths through all that a shift can meet are undone by the shift back.
    #[test]
    fn a_shift_is_undone_by_the_shift_back() {
        for (scene, expected) in [
            ("cornell-box.xml", [300, 0, 0]),
            ("models/dielectric.xml", [300, 100, 20]),
            ("models/roughdielectric-ggx.xml", [300, 0, 100]),
        ] {
            // How often a path was kept from the third vertex on, a mirror followed, a half vector copied.
            let mut met = [0; 3];
            let (mut worst, mut all, mut failed) = (0.0_f32, 0, 0);
            for_paths(scene, 5, |world, base| {
                // Rough glass is not rough enough.
                let shift = |x| Shift { world, by: (x, 0.0), rough: 0.5 };
                let Some(there) = shift(1.0).apply(base) else { return };
                all += 1;
                let Some(back) = shift(-1.0).apply(&there.path) else {
                    failed += 1;
                    return;
                };
                met[0] += usize::from(base.len() > 2 && there.path.position_of(base, 2) == Some(2));
                met[1] += usize::from(base.len() > 2 && is_atom(&there.path, 1));
                met[2] += usize::from(
                    base.len() > 2
                        && !is_atom(base, 1)
                        && there.path.position_of(base, 2).is_none(),
                );
                let mut error = (there.jacobian * back.jacobian - 1.0).abs();
                for (a, b) in base.vertices().zip(back.path.vertices()) {
                    error = error.max((a.position - b.position).length());
                }
                if error > 0.01 {
                    failed += 1;
                    return;
                }
                worst = worst.max(error);
                for i in 0..base.len() {
                    assert_eq!(is_atom(base, i), is_atom(&there.path, i), "{scene}");
                    let kept = there.path.position_of(base, i);
                    assert_eq!(kept, back.path.position_of(&there.path, i), "{scene}");
                }
            });
            println!(
                "{scene}: {all} paths, {failed} without a way back, worst {worst:.1e}, {met:?}"
            );
            assert!(met.iter().zip(expected).all(|(met, least)| *met >= least), "{scene}: {met:?}");
            // Rounding sends few rays past an edge.
            assert!(failed * 200 <= all && worst < 0.01, "{scene}: {failed} of {all}, {worst}");
        }
    }
}
