//! What lights look like from a point: the directions in which a sphere, a triangle or a rectangle is seen.
//!
//! All answers are functions of the point and the light alone, so that a density finds the same one as the
//! sample that it belongs to.

use aether_core::prelude::{Direction, Frame};
use glam::Vec3;

use crate::samplers::{
    SphericalRectangle, SphericalTriangle, spherical_rectangle, spherical_triangle,
};
use crate::scene::Rectangle;
use crate::scene::vectors::try_unit;

/// Triangles and rectangles that fill less than this, area over squared distance, are sampled by area: what that loses is
/// little there, and it is cheaper and keeps all digits.
const LEAST_FILLED: f32 = 0.15;

/// The directions in which a sphere is seen from a point outside: the axis of a cone, and by how much the
/// cosine at its rim is below one. `None` from inside, and from where the sphere is tiny.
pub fn cone_of(from: Vec3, center: Vec3, radius: f32) -> Option<(Direction<f32>, f32)> {
    let axis = center - from;
    let sine2 = (radius * radius) / axis.length_squared();
    // Directions in single precision are known to about 1e-7.
    if !(1e-6..1.0).contains(&sine2) {
        return None;
    }
    let depth = sine2 / (1.0 + (1.0 - sine2).sqrt());
    Some((Direction::from_vec(axis.into()), depth))
}

/// The directions in which a triangle of some area is seen from a point, and the frame that they are given
/// in. `None` if it fills little of the view or nearly half of it, is seen as a needle, or if the point is
/// next to its plane.
pub fn triangle_of(
    from: Vec3,
    corners: [Vec3; 3],
    area: f32,
) -> Option<(Frame<f32>, SphericalTriangle<f32>)> {
    let [b, a, c] = corners.map(|corner| corner - from);
    if area < LEAST_FILLED * (a + b + c).length_squared() / 9.0 {
        return None;
    }
    let [b, a, c] = [b, a, c].map(Vec3::normalize_or_zero);
    // The pole is opposite to the longest side.
    let (ab, bc, ca) = (a.dot(b), b.dot(c), c.dot(a));
    let [b, a, c] = if ca <= ab && ca <= bc {
        [b, a, c]
    } else if ab <= bc {
        [c, b, a]
    } else {
        [a, c, b]
    };
    // The great circle through a and c, and its point that is nearest to b.
    let n = a.cross(c).try_normalize()?;
    let sine = n.dot(b);
    let (n, sine) = if sine < 0.0 { (-n, -sine) } else { (n, sine) };
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    // In the plane of the triangle, or b is about as far from all of the circle.
    if !(sine > 0.05 && cosine > 0.02) {
        return None;
    }
    let (foot, along) = ((b - sine * n) / cosine, n.cross(b) / cosine);
    let tau = sine / (1.0 + cosine);
    let half_arc = |p: Vec3| {
        let toward = 1.0 + p.dot(foot);
        // Near the far side of the circle the way round is not known.
        (toward > 0.01).then(|| p.dot(along) / toward)
    };
    let (w_a, w_c) = (half_arc(a)?, half_arc(c)?);
    // The side from a to c passes that point on its far side.
    if 1.0 + w_a * w_c < 0.0 {
        return None;
    }
    let (t_a, t_c) = (tau * w_a, tau * w_c);
    let (t_a, t_c) = if t_a < t_c { (t_a, t_c) } else { (t_c, t_a) };
    let half = (t_c - t_a).atan2(1.0 + t_a * t_c);
    let directions = spherical_triangle(tau, t_a.atan(), half).ok()?;
    let x = (sine * b - n) / cosine;
    let frame = Frame::try_from_axes(x.into(), along.into(), b.into())?;
    (half < 2.5).then_some((frame, directions))
}

/// A rectangle with all that [`rectangle_of`] needs to know of it and that is the same from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pane {
    corner: Vec3,
    a: Vec3,
    /// From the corner to the middle.
    middle: Vec3,
    /// Unit vectors along the sides.
    x: Vec3,
    y: Vec3,
    width: f32,
    height: f32,
    area: f32,
    /// The normals that belong to `y` and to its opposite.
    normals: [Vec3; 2],
    /// The frames of each of those normals and of its opposite.
    frames: [[Frame<f32>; 2]; 2],
}

impl Pane {
    /// That of a rectangle of some area; none if a side has no length.
    pub fn of(rectangle: &Rectangle, area: f32) -> Option<Pane> {
        let Rectangle { corner, a, b } = *rectangle;
        let x = try_unit(a)?;
        let y = try_unit(b - x.dot(b) * x)?;
        let normals = [x.cross(y), x.cross(-y)];
        let frame = |x: Vec3, y: Vec3, z: Vec3| Frame::try_from_axes(x.into(), y.into(), z.into());
        let pair = |y: Vec3, z: Vec3| Some([frame(x, y, z)?, frame(-x, y, -z)?]);
        let frames = [pair(y, normals[0])?, pair(-y, normals[1])?];
        let (middle, width, height) = (0.5 * (a + b), a.length(), y.dot(b));
        Some(Pane { corner, a, middle, x, y, width, height, area, normals, frames })
    }
}

/// The directions in which a rectangle is seen from a point, and the frame that they are given in. `None` if
/// it fills little of the view or nearly half of it, or if the point is next to its plane.
pub fn rectangle_of(from: Vec3, pane: &Pane) -> Option<(Frame<f32>, SphericalRectangle<f32>)> {
    let offset = pane.corner - from;
    if pane.area < LEAST_FILLED * (offset + pane.middle).length_squared() {
        return None;
    }
    // Axes along the sides, and towards the plane; the middle lies above.
    let bottom = pane.y.dot(offset);
    let is_below = bottom + 0.5 * pane.height < 0.0;
    let bottom = if is_below { -(bottom + pane.height) } else { bottom };
    let depth = pane.normals[usize::from(is_below)].dot(offset);
    let is_behind = depth < 0.0;
    let (x, depth) = if is_behind { (-pane.x, -depth) } else { (pane.x, depth) };
    let frame = pane.frames[usize::from(is_below)][usize::from(is_behind)];
    let left = x.dot(offset).min(x.dot(offset + pane.a));
    let [left, bottom, width, height] =
        [left, bottom, pane.width, pane.height].map(|l| f64::from(l) / f64::from(depth));
    let (right, top) = (left + width, bottom + height);
    // Tangents of half the difference of the elevations of both sides, and of their mean.
    let r = ((1.0 + bottom * bottom) * (1.0 + top * top)).sqrt();
    let (d, m) = (height / (r + 1.0 + bottom * top), (top + bottom) / (r + 1.0 - bottom * top));
    let n2 = (1.0 + m * m) * (1.0 + d * d);
    // The tangent of half the solid angle from the plane x = 0 on.
    let tangent = |x: f64| {
        let leg = |k: f64| (n2 + (k * x) * (k * x)).sqrt();
        2.0 * d * x / (leg(1.0 + d * m) + leg(1.0 - d * m))
    };
    let (t, u) = (tangent(left), tangent(right));
    let half = (u - t).atan2(1.0 + t * u);
    let directions = spherical_rectangle(d as f32, m as f32, t.atan() as f32, half as f32).ok()?;
    Some((frame, directions))
}

#[cfg(test)]
mod tests {
    use aether_core::battery::Battery;
    use aether_core::{Pcg32, Sampler, UniformSource};
    use glam::Vec3;

    use super::*;
    use crate::samplers::rotate;
    use crate::scene::Primitive;

    #[test]
    fn spherical_triangles_pass_the_battery() {
        for (tau, from, half) in [(0.6, -0.6, 1.2), (0.9, -0.7, 1.6)] {
            let triangle = spherical_triangle(tau, from, half).unwrap();
            Battery::new(&triangle).evaluations(4_000_000).run().assert_ok();
        }
    }

    #[test]
    fn spherical_rectangles_pass_the_battery() {
        for (d, m, from, half) in
            [(0.57, 0.17, -0.27, 0.65), (0.2, 0.9, -0.1, 0.15), (3.0, 0.1, -1.2, 2.4)]
        {
            let rectangle = spherical_rectangle(d, m, from, half).unwrap();
            Battery::new(&rectangle).evaluations(4_000_000).run().assert_ok();
        }
    }

    /// Uniforms, directions and the density of the rectangle with x from -0.7 to 1.3 and y from -0.4 to 0.9 at a
    /// distance of 1.1: with 40 digits, by the formulas of Ureña, Fajardo and King as they are printed.
    const REFERENCE: [([f32; 2], [f32; 3], f32); 3] = [
        ([0.3, 0.6], [-0.140_604_62, 0.242_104_51, 0.960_008_2], 0.769_302_05),
        ([0.1, 0.9], [-0.351_832_95, 0.507_067_87, 0.786_826_4], 0.769_302_05),
        ([0.75, 0.05], [0.434_188_9, -0.263_899_07, 0.861_299_76], 0.769_302_05),
    ];

    #[test]
    fn a_rectangle_has_the_samples_and_the_density_of_the_reference() {
        let rectangle =
            Rectangle { corner: Vec3::new(-0.7, -0.4, 1.1), a: 2.0 * Vec3::X, b: 1.3 * Vec3::Y };
        let pane = Pane::of(&rectangle, 2.6).unwrap();
        let (frame, local) = rectangle_of(Vec3::ZERO, &pane).unwrap();
        for (u, [x, y, z], pdf) in REFERENCE {
            let sample = local.sample(u);
            let w: Vec3 = frame.to_world(sample.value()).into();
            assert!((w - Vec3::new(x, y, z)).length() < 3e-7, "{u:?}: {w}");
            assert!((sample.pdf().value() / pdf - 1.0).abs() < 1e-6, "{u:?}: {:?}", sample.pdf());
        }
    }

    /// Random rectangles round the origin.
    fn rectangles() -> impl Iterator<Item = Rectangle> {
        (0..600).map(|k| {
            let mut random = Pcg32::new(9, 0, k);
            let mut next = || 2.0 * UniformSource::<f32>::next(&mut random) - 1.0;
            let mut any = || Vec3::new(next(), next(), next());
            let (corner, a, b) = (any(), any(), any());
            Rectangle { corner, a, b: a.cross(b) }
        })
    }

    #[test]
    fn directions_fill_the_rectangle_and_nothing_else() {
        let (mut used, mut refused, mut outsiders) = (0, 0, 0);
        let mut points = Pcg32::new(8, 0, 0);
        let mut next = || UniformSource::<f32>::next(&mut points);
        for rectangle in rectangles() {
            let Rectangle { corner, a, b } = rectangle;
            let area = a.cross(b).length();
            let Some(pane) = Pane::of(&rectangle, area) else { continue };
            let Some((frame, local)) = rectangle_of(Vec3::ZERO, &pane) else { continue };
            used += 1;
            let seen = local.then(rotate(frame));
            let halves =
                [[corner, corner + a, corner + b], [corner + a + b, corner + b, corner + a]];
            let expected = 1.0 / halves.map(solid_angle).iter().sum::<f64>();
            let near = |p: f32| (f64::from(p) / expected - 1.0).abs() < 1e-3;
            for _ in 0..20 {
                let w = seen.sample([next(), next()]);
                assert!(near(w.pdf().value()), "{rectangle:?}: {:?}, not {expected}", w.pdf());
                let w: Vec3 = w.value().vec().into();
                // The point of the plane in that direction, by its coordinates along the sides.
                let n = a.cross(b);
                let p = w * (corner.dot(n) / w.dot(n)) - corner;
                let (p, q) = (p.dot(a) / a.length_squared(), p.dot(b) / b.length_squared());
                let inside = |p: f32| (-1e-3..1.001).contains(&p);
                assert!(inside(p) && inside(q), "{rectangle:?}: {p} {q}");
                let density = |p: f32, q: f32| {
                    let at = (corner + p * a + q * b).normalize();
                    seen.pdf(&Direction::from_vec(at.into())).value()
                };
                let (p, q) = (next(), next());
                let on_rim = p.min(1.0 - p).min(q).min(1.0 - q) < 1e-3;
                assert!(near(density(p, q)) || on_rim, "{rectangle:?} at {p} {q}");
                for (p, q) in [(1.01, q), (-0.01, q), (p, 1.01), (p, -0.01)] {
                    outsiders += 1;
                    refused += usize::from(density(p, q) == 0.0);
                }
            }
        }
        assert!(used > 200, "{used} of 600");
        assert!(refused as f64 > 0.99 * outsiders as f64, "{refused} of {outsiders}");
    }

    #[test]
    fn two_triangles_are_a_rectangle_if_they_make_one() {
        let [a, b, c, d] =
            [[0., 0.], [3., 0.], [3., 2.], [0., 2.]].map(|[x, y]| Vec3::new(x, y, 1.0));
        let triangle = |v0, v1, v2| Primitive::Triangle { v0, v1, v2 };
        let found = Rectangle::of(&triangle(a, b, c), &triangle(c, d, a)).unwrap();
        assert_eq!((found.corner, found.a, found.b), (b, c - b, a - b));
        assert!(found.is_beyond_diagonal(d - 0.1) && !found.is_beyond_diagonal(b + 0.1));
        // The second turned over, askew, or on the other side of a wrong diagonal.
        assert_eq!(Rectangle::of(&triangle(a, b, c), &triangle(d, c, a)), None);
        assert_eq!(Rectangle::of(&triangle(a, b, c), &triangle(a, c, d + 1e-3 * Vec3::X)), None);
        assert_eq!(Rectangle::of(&triangle(a, b, c), &triangle(b, d, a)), None);
    }

    /// Corners of random triangles round the origin, and their areas.
    fn triangles() -> impl Iterator<Item = ([Vec3; 3], f32)> {
        (0..300).map(|k| {
            let mut random = Pcg32::new(7, 0, k);
            let mut next = || 2.0 * UniformSource::<f32>::next(&mut random) - 1.0;
            let corners = [(); 3].map(|()| Vec3::new(next(), next(), next() + 0.8));
            let area = 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
            (corners, area)
        })
    }

    /// The solid angle of a triangle seen from the origin (van Oosterom and Strackee, 1983).
    fn solid_angle(corners: [Vec3; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| corner.as_dvec3().normalize());
        2.0 * a.cross(b).dot(c).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    }

    #[test]
    fn directions_fill_the_triangle_and_nothing_else() {
        let (mut used, mut refused, mut outsiders) = (0, 0, 0);
        let mut points = Pcg32::new(8, 0, 0);
        let mut next = || UniformSource::<f32>::next(&mut points);
        for (corners, area) in triangles() {
            let Some((frame, local)) = triangle_of(Vec3::ZERO, corners, area) else { continue };
            used += 1;
            let seen = local.then(rotate(frame));
            let expected = 1.0 / solid_angle(corners);
            let [a, b, c] = corners;
            for _ in 0..20 {
                // A sample lies inside, by its weights; a point inside has the density.
                let w = seen.sample([next(), next()]);
                let near = |p: f32| (f64::from(p) / expected - 1.0).abs() < 1e-3;
                assert!(near(w.pdf().value()), "{corners:?}: {:?}, not {expected}", w.pdf());
                let w: Vec3 = w.value().vec().into();
                let weights = glam::Mat3::from_cols(a, b, c).inverse() * w;
                assert!(weights.min_element() > -1e-3 * weights.max_element(), "{corners:?}");
                let (u, v) = (next().sqrt(), next());
                let inside = a + u * (1.0 - v) * (b - a) + u * v * (c - a);
                let p = seen.pdf(&Direction::from_vec(inside.normalize().into())).value();
                let on_rim = u > 0.999 || v.min(1.0 - v) < 1e-3;
                assert!(near(p) || on_rim, "{corners:?} at {inside}: {p}, not {expected}");
                // Bounds of rounding errors are wide where a triangle is narrow: some pass.
                let outside = a + 1.01 * (b - a) + u * (c - a);
                let p = seen.pdf(&Direction::from_vec(outside.normalize().into())).value();
                let number = usize::from(p == 0.0);
                (refused, outsiders) = (refused + number, outsiders + 1);
            }
        }
        assert!(used > 200, "{used} of 300");
        assert!(refused as f64 > 0.99 * outsiders as f64, "{refused} of {outsiders}");
    }
}
