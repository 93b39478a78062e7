//! Intersection of one ray with one primitive.

use glam::{DVec3, Vec3};

use super::mesh::double_area_normal;

/// The first hit of a sphere with `0 < t`, for a ray with a unit direction. In f64, because f32
/// loses the small differences of large squares.
pub fn sphere(origin: Vec3, direction: Vec3, center: Vec3, radius: f32) -> Option<f32> {
    let o = origin.as_dvec3() - center.as_dvec3();
    let d = direction.as_dvec3().normalize();
    let radius = f64::from(radius);
    let middle = -o.dot(d);
    // The distance of the line from the centre, without cancellation.
    let off = (o + middle * d).length();
    if off > radius {
        return None;
    }
    let half_chord = ((radius - off) * (radius + off)).sqrt();
    let far = middle + if middle >= 0.0 { half_chord } else { -half_chord };
    // The product of both roots is |o|² - r²; this is their stable form.
    let product = (o.length() - radius) * (o.length() + radius);
    let other = if far == 0.0 { 0.0 } else { product / far };
    let (near, far) = (far.min(other), far.max(other));
    let t = if near > 0.0 { near } else { far };
    (t > 0.0).then_some(t as f32)
}

/// The point of a sphere that a ray from outside meets first, or for a ray that misses it by rounding the
/// point that it comes nearest to.
pub fn nearest_on_sphere(origin: Vec3, direction: Vec3, center: Vec3, radius: f32) -> Vec3 {
    let (o, c) = (origin.as_dvec3() - center.as_dvec3(), center.as_dvec3());
    let (d, radius) = (direction.as_dvec3().normalize_or_zero(), f64::from(radius));
    let middle = -o.dot(d);
    let off = (o + middle * d).length();
    let half_chord = ((radius - off) * (radius + off)).max(0.0).sqrt();
    let outwards = o + (middle - half_chord) * d;
    (c + radius * outwards.normalize_or_zero()).as_vec3()
}

/// How far a ray that starts *on* a sphere runs inside it before it leaves; none if it does not
/// enter it. No test against an epsilon is needed.
pub fn chord(point: Vec3, direction: Vec3, center: Vec3) -> Option<f32> {
    let inwards = -2.0 * (point.as_dvec3() - center.as_dvec3()).dot(direction.as_dvec3());
    (inwards > 0.0).then_some(inwards as f32)
}

/// A point and a direction of unit length split into their parts along and across the axis of a
/// cylinder.
struct AlongAxis {
    /// Coordinate of the point along the axis, 0 at the base and 1 at the top, and how it changes.
    height: [f64; 2],
    /// The point across the axis, and how it changes.
    across: [DVec3; 2],
}

impl AlongAxis {
    fn new(point: Vec3, direction: Vec3, base: Vec3, axis: Vec3) -> Self {
        let axis = axis.as_dvec3();
        let (p, d) = (point.as_dvec3() - base.as_dvec3(), direction.as_dvec3().normalize());
        let [a, b] = [p, d].map(|v| v.dot(axis) / axis.length_squared());
        AlongAxis { height: [a, b], across: [p - a * axis, d - b * axis] }
    }

    /// Whether the point at a distance lies between the ends.
    fn is_between(&self, t: f64) -> bool {
        (0.0..=1.0).contains(&(self.height[0] + t * self.height[1]))
    }
}

/// The first hit of the side of a cylinder with `0 < t`, for a ray with a unit direction. In f64, as for
/// spheres.
pub fn cylinder(origin: Vec3, direction: Vec3, base: Vec3, axis: Vec3, radius: f32) -> Option<f32> {
    let line = AlongAxis::new(origin, direction, base, axis);
    let ([o, d], radius) = (line.across, f64::from(radius));
    let speed2 = d.length_squared();
    // A ray along the axis meets nothing.
    if speed2 < 1e-30 {
        return None;
    }
    let middle = -o.dot(d) / speed2;
    let off = (o + middle * d).length();
    if off > radius {
        return None;
    }
    let half_chord = ((radius - off) * (radius + off) / speed2).sqrt();
    let far = middle + half_chord.copysign(middle);
    let product = (o.length() - radius) * (o.length() + radius) / speed2;
    let other = if far == 0.0 { 0.0 } else { product / far };
    let (near, far) = (far.min(other), far.max(other));
    let t = [near, far].into_iter().find(|t| *t > 0.0 && line.is_between(*t))?;
    Some(t as f32)
}

/// How far a ray that starts *on* the side of a cylinder runs inside it before it meets that side again;
/// none if it does not enter it or leaves through an end.
pub fn cylinder_chord(point: Vec3, direction: Vec3, base: Vec3, axis: Vec3) -> Option<f32> {
    let line = AlongAxis::new(point, direction, base, axis);
    let [o, d] = line.across;
    let t = -2.0 * o.dot(d) / d.length_squared();
    (t > 0.0 && t.is_finite() && line.is_between(t)).then_some(t as f32)
}

/// The point of the side of a cylinder next to a point near it.
pub fn onto_cylinder(point: DVec3, base: Vec3, axis: Vec3, radius: f32) -> Vec3 {
    let (b, axis) = (base.as_dvec3(), axis.as_dvec3());
    let height = (point - b).dot(axis) / axis.length_squared();
    let foot = b + height * axis;
    (foot + f64::from(radius) * (point - foot).normalize_or_zero()).as_vec3()
}

/// The plane of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A corner.
    corner: DVec3,
    /// A normal, twice as long as the area.
    normal: DVec3,
}

impl Plane {
    /// The plane through three corners.
    #[inline]
    pub fn through(corners: [Vec3; 3]) -> Self {
        Plane { corner: corners[0].as_dvec3(), normal: double_area_normal(&corners) }
    }

    /// Where a ray meets it, rounded once. `None` where it is ill-defined or parallel to the ray.
    #[inline]
    pub fn met_by(&self, origin: Vec3, direction: Vec3) -> Option<Vec3> {
        let [o, d] = [origin, direction].map(Vec3::as_dvec3);
        let t = self.normal.dot(self.corner - o) / self.normal.dot(d);
        t.is_finite().then(|| (o + t * d).as_vec3())
    }
}

/// Where a ray that meets a triangle meets its plane, inside of the box round it whatever rounding does.
pub fn inside_on_plane(corners: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<Vec3> {
    let [a, b, c] = corners;
    let point = Plane::through(corners).met_by(origin, direction)?;
    Some(point.clamp(a.min(b).min(c), a.max(b).max(c)))
}

/// The coordinates along its two axes of a point of an ellipse.
pub fn disk_coordinates(point: Vec3, center: Vec3, u_axis: Vec3, v_axis: Vec3) -> [f64; 2] {
    let (u, v) = (u_axis.as_dvec3(), v_axis.as_dvec3());
    let (p, normal) = (point.as_dvec3() - center.as_dvec3(), u.cross(v));
    let area2 = normal.length_squared();
    [p.cross(v).dot(normal) / area2, u.cross(p).dot(normal) / area2]
}

/// Where the line along the ray meets an ellipse, and the coordinates along its two axes; `t` may
/// be negative.
pub fn disk(
    origin: Vec3,
    direction: Vec3,
    center: Vec3,
    u_axis: Vec3,
    v_axis: Vec3,
) -> Option<(f32, [f64; 2])> {
    let (u, v, d) = (u_axis.as_dvec3(), v_axis.as_dvec3(), direction.as_dvec3());
    let normal = u.cross(v);
    let o: DVec3 = origin.as_dvec3() - center.as_dvec3();
    let cosine = normal.dot(d);
    if cosine == 0.0 {
        return None;
    }
    let t = -normal.dot(o) / cosine;
    let p = o + t * d;
    let area2 = normal.length_squared();
    let a = p.cross(v).dot(normal) / area2;
    let b = u.cross(p).dot(normal) / area2;
    (t.is_finite() && a * a + b * b <= 1.0).then_some((t as f32, [a, b]))
}
