//! The shift of gradient-domain path tracing (Kettunen, Manzi, Aittala, Lehtinen, Durand and Zwicker 2015): a
//! function from a path to a similar one through another point of the film.
//!
//! The film point moves; at a mirror or a pane the shifted path follows the lobe of the base path, elsewhere it
//! copies the half vector, until both can see the same rest of the base path: from the first two vertices in
//! succession that are rough, the rest is kept. Each new vertex is drawn by a strategy about what is copied, from
//! which the change of measure is derived ([`aether_core::shift`]).
//!
//! A path whose first vertices do not see the rest has no shifted one, unless the rest is only a point of a light:
//! next-event estimation would make such a path, though a black one.

use aether_core::prelude::Vec2;
use aether_core::shift::{Moved, Shift, Turn};
use aether_core::strategy::Dirac;
use aether_core::{PathView, strategies};

use crate::half_vectors::{HalfVector, SampleHalfVector, sample_half_vector};
use crate::kind::{Everything, SceneKind};
use crate::strategies::{
    Aim, Pixel, SampleBsdf, SampleCamera, SampleCameraDirection, SampleLight, sample_bsdf,
    sample_camera_direction,
};
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

/// Moves paths on the film.
#[derive(Clone, Copy)]
pub struct FilmShift<'a, K: SceneKind> {
    /// The scene.
    pub world: &'a World<'a, K>,
    /// The pixel of base paths.
    pub pixel: Pixel,
    /// By how many pixels, to the right and down.
    pub by: (i32, i32),
    /// Where the roughness of a surface is at least this, shifted paths may meet base paths.
    pub rough: f32,
}

/// How wide half vectors are drawn about the one that is copied. It cancels; to invert them within rounding it must
/// be large against that.
const WIDTH: f32 = 0.125;

impl<'a, K: SceneKind> FilmShift<'a, K> {
    /// The pixel of shifted paths.
    pub fn moved(&self) -> Pixel {
        let ((x, y), (dx, dy)) = (self.pixel, self.by);
        (x.saturating_add_signed(dx), y.saturating_add_signed(dy))
    }

    /// What makes vertex `i` of the shifted path do what that of the base path does.
    fn copied(&self, base: &View<'_, K>, i: usize) -> Option<ShiftStrategies<'a, K>> {
        let (world, here, next) = (self.world, base.back(1)?, base.back(0)?);
        if i == 1 {
            let film = world.film_point(&here, &next)?;
            let (dx, dy) = self.by;
            let moved = Vec2::new(film.x + dx as f32, film.y + dy as f32);
            return Some(sample_camera_direction(world, Aim::About(moved)).into());
        }
        let before = base.back(2)?;
        if base.carries(i - 1, Dirac::Direction) {
            let lobe = world.mirror_between(&before, &here, &next)?;
            return Some(sample_bsdf(world, u32::MAX, Some(lobe)).into());
        }
        let half = HalfVector::between(world, [&before, &here, &next], WIDTH)?;
        Some(sample_half_vector(world, half).into())
    }

    /// Whether the shifted path may meet the base path at its next vertex: both are rough where they are, and
    /// neither goes on in a single direction.
    fn may_meet(&self, Turn { base, shifted, .. }: &Turn<'_, SceneVertex<K>>, i: usize) -> bool {
        let rough = |vertex| self.is_rough(vertex);
        i > 1
            && !base.carries(i - 1, Dirac::Direction)
            && rough(base.back(1))
            && rough(shifted.back(0))
    }

    fn is_rough(&self, vertex: Option<SceneVertex<K>>) -> bool {
        vertex.is_some_and(|vertex| self.world.roughness(&vertex) >= self.rough)
    }
}

type View<'p, K> = PathView<'p, SceneVertex<K>>;

impl<'a, K: SceneKind> Shift<SceneVertex<K>, ShiftStrategies<'a, K>> for FilmShift<'a, K> {
    fn inverse(&self) -> Self {
        let (dx, dy) = self.by;
        FilmShift { pixel: self.moved(), by: (-dx, -dy), ..*self }
    }

    fn vertex(&self, turn: &Turn<'_, SceneVertex<K>>) -> Moved<ShiftStrategies<'a, K>> {
        let (i, last) = (turn.shifted.len(), turn.base.last());
        let is_lamp = |v: &SceneVertex<K>| matches!(v.place, Place::Bulb(_) | Place::Distant(_));
        let kept = match turn.ends {
            // Next-event estimation would make it.
            true => last.as_ref().is_some_and(is_lamp) || self.may_meet(turn, i),
            false => !turn.directed && self.is_rough(last) && self.may_meet(turn, i),
        };
        if i == 0 || kept {
            return Moved::Kept;
        }
        self.copied(&turn.base, i).map_or(Moved::Lost, Moved::Copied)
    }

    fn technique(&self, i: usize) -> Option<ShiftStrategies<'a, K>> {
        (i == 1).then(|| sample_camera_direction(self.world, self.moved().into()).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samplers::{hit_plane, pinhole, rotate};
    use crate::scattering::facets::{reflect, refract_in, refract_out};
    use crate::scene::Scene;
    use crate::strategies::sample_light;
    use crate::subpaths::{camera_path, is_atom};
    use aether_core::prelude::*;
    use aether_core::{Arena, Pcg32, RandomSequence};

    type Path<'r, 'a, K> = RandomSequence<'r, SceneVertex<K>, ShiftStrategies<'a, K>>;

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
            let plane = hit_plane(places[i], point, Direction::from_unit(normal), SurfaceId(1));
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
        let mut arena = Arena::new();
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
                let shift = FilmShift { world, pixel: (0, 0), by: (1, 0), rough: 0.5 };
                let sees = |a: &_, b: &_| world.visible(a, b);
                let Some(there) = base.shifted(&shift, sees) else { return };
                all += 1;
                let Some(back) = there.path.shifted(&shift.inverse(), sees) else {
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
