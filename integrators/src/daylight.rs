//! Light from infinitely far away that comes through openings: the sky seen through a window, and where it shines.
//!
//! Paths that know nothing of a window find it by chance, from either side. Here both the light that is sampled at
//! a vertex and the first surface that a light path meets are drawn by way of a point of an opening, half of the time,
//! and otherwise as elsewhere: a mixture has the density of both, so that nothing else has to know of it.

use aether_core::prelude::*;
use aether_core::{PathView, coin};
use glam::Vec3 as Vector;

use crate::emission::sample_emission;
use crate::eye::ParallelFilm;
use crate::kind::SceneKind;
use crate::portals::Portals;
use crate::strategies::sample_light;
use crate::vertex::{SceneVertex, Surface};
use crate::world::World;

/// How often light from infinitely far away is sampled by way of openings, where there is such light.
const SHARE: f32 = 0.5;

/// A triangle that light may pass: a corner, and the sides from it to the others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// The corner.
    pub corner: Vector,
    /// The sides.
    pub sides: [Vector; 2],
}

impl Opening {
    /// The triangle as a window for parallel light from a direction of unit length: its points have the coordinates
    /// of [`unit_triangle`].
    fn window(&self, towards: Vector) -> ParallelFilm {
        ParallelFilm {
            origin: self.corner,
            centre: Vec2::new(0.0, 0.0),
            across: self.sides[0],
            down: self.sides[1],
            forward: -towards,
        }
    }

    /// The directions from a point through the points of the triangle.
    fn seen_from(&self, from: Vector) -> Through<f32> {
        let [a, b] = self.sides.map(Into::into);
        through((self.corner - from).into(), a, b)
    }
}

/// Uniform on the triangle of all (x, y) with x ≥ 0, y ≥ 0 and x + y ≤ 1.
#[sampler]
pub fn unit_triangle(u: [Uniform; 2]) -> Vec2 {
    let s = u[0].sqrt();
    Vec2::new(s * (1.0 - u[1]), s * u[1])
}

/// From points of a triangle, in multiples of the sides `a` and `b`, to the directions in which they are seen from
/// the origin: `corner` is where the sides begin.
#[map]
pub fn through(p: Vec2, corner: Vec3, a: Vec3, b: Vec3) -> Direction {
    Direction::from_vec((corner + p.x * a + p.y * b).normalize())
}

/// A light and a point on it as [`sample_light`] chooses them, or the sky in the direction of a point of an opening.
#[strategy(connected = false)]
pub fn sample_light_and_openings<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    portals: &Portals,
) -> SceneVertex<K> {
    let here = given(path.last());
    let by_opening = choose(coin(if world.sky().is_some() { SHARE } else { 0.0 }));
    if !by_opening {
        return delegate(sample_light(world));
    }
    let sky = given(world.sky());
    let opening = choose(&portals.openings);
    let p = draw(unit_triangle());
    let w = opening.seen_from(here.position).apply(&p);
    SceneVertex::sky(sky, w)
}

/// The first surface that a light shines on, as [`sample_emission`] finds it, or from infinitely far away through an
/// opening.
#[strategy]
pub fn sample_emission_and_openings<K: SceneKind>(
    path: &PathView<SceneVertex<K>>,
    world: &World<'_, K>,
    portals: &Portals,
) -> SceneVertex<K> {
    let here = given(path.last());
    let by_opening = choose(coin(if here.is_infinite() { SHARE } else { 0.0 }));
    if !by_opening {
        return delegate(sample_emission(world));
    }
    let opening = choose(&portals.openings);
    let window = opening.window(here.position);
    let p = draw(unit_triangle());
    let lit: Surface<K> = constant(world.shone_on_inside(&window, &p));
    let at = lit.seen_by(&window).apply(&p);
    SceneVertex::hit(lit, at)
}

#[cfg(test)]
mod tests {
    use aether_core::battery;
    use aether_core::{Sampler, prelude::*};

    use super::*;

    #[test]
    fn directions_through_a_triangle_have_densities_of_its_solid_angle() {
        battery::check(&unit_triangle()).assert_ok();
        let opening =
            Opening { corner: Vector::new(0.2, -0.3, 1.0), sides: [Vector::X, Vector::Y] };
        let seen = unit_triangle().then(opening.seen_from(Vector::ZERO));
        for u in [[0.1, 0.2], [0.5, 0.5], [0.9, 0.3]] {
            let w = seen.sample(u);
            let w: Vector = w.value().vec().into();
            // Area 1/2, at height one: squared distance over cosine is 1 / z³.
            let expected = 2.0 / w.z.powi(3);
            let p = seen.pdf(&Direction::from_unit(w.into())).value();
            assert!((p / expected - 1.0).abs() < 1e-5, "{p}, not {expected}");
        }
        let beside = Direction::from_vec(Vector::new(-0.2, 0.3, 1.0).into());
        assert_eq!(seen.pdf(&beside).value(), 0.0);
    }
}
