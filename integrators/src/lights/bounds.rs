//! Bounds of where lights are and of what they send where, for one light and for many.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Quat, Vec3};

use crate::scene::{Bounds, Bulb, Primitive};

/// All that a group of lights at finite distances can do: a box around them, a cone around the normals, and
/// how far from a normal there is light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The box.
    pub bounds: Bounds,
    /// The axis of the cone of normals, of unit length.
    pub axis: Vec3,
    /// The half angle of that cone.
    pub normals: f32,
    /// The largest angle to a normal at which there is light.
    pub emission: f32,
    /// The sum of radiance times area, or of intensity, over lights and channels.
    pub weight: f32,
}

impl Extent {
    /// The extent of a primitive that emits.
    pub fn of_primitive(shape: &Primitive, normal: Vec3, weight: f32) -> Self {
        let normals = if matches!(shape, Primitive::Sphere { .. } | Primitive::Cylinder { .. }) {
            PI
        } else {
            0.0
        };
        let bounds = shape.bounds();
        Extent { bounds, axis: normal, normals, emission: FRAC_PI_2, weight }
    }

    /// The extent of a point light.
    pub fn of_bulb(bulb: &Bulb) -> Self {
        let (axis, normals) = bulb.cone.map_or((Vec3::Z, PI), |cone| (cone.axis, cone.cutoff));
        let bounds = Bounds { min: bulb.position, max: bulb.position };
        // Within the cone it does not fade like a surface.
        Extent { bounds, axis, normals, emission: 0.0, weight: bulb.intensity.element_sum() }
    }

    /// The extent of both.
    #[must_use]
    pub fn union(&self, other: &Extent) -> Extent {
        let (axis, normals) = cone_around((self.axis, self.normals), (other.axis, other.normals));
        Extent {
            bounds: self.bounds.union(other.bounds),
            axis,
            normals,
            emission: self.emission.max(other.emission),
            weight: self.weight + other.weight,
        }
    }

    /// The middle of the box.
    pub fn middle(&self) -> Vec3 {
        0.5 * self.bounds.min + 0.5 * self.bounds.max
    }

    /// What it costs to have these lights in one group: weight, times the surface of the box, times a
    /// measure of the directions that they shine in (Conty Estevez and Kulla, "Importance Sampling of Many
    /// Lights with Adaptive Tree Splitting", 2018, section 4.4).
    pub fn cost(&self) -> f32 {
        let size = self.bounds.max - self.bounds.min;
        let surface = size.x * size.y + size.y * size.z + size.z * size.x;
        let o = self.normals;
        let w = (o + self.emission).min(PI);
        let beyond = 2.0 * w * o.sin() - (o - 2.0 * w).cos() - 2.0 * o * o.sin() + o.cos();
        self.weight * surface * (2.0 * PI * (1.0 - o.cos()) + FRAC_PI_2 * beyond)
    }
}

/// The least cone around two cones, each an axis and a half angle.
fn cone_around(a: (Vec3, f32), b: (Vec3, f32)) -> (Vec3, f32) {
    let ((axis, half), (other, least)) = if a.1 >= b.1 { (a, b) } else { (b, a) };
    if half >= PI {
        return (axis, PI);
    }
    // By the half chord, which keeps its digits for small angles.
    let between = 2.0 * (0.5 * (other - axis).length()).min(1.0).asin();
    if (between + least).min(PI) <= half {
        return (axis, half);
    }
    let widened = 0.5 * (half + between + least);
    let turn = axis.cross(other).try_normalize();
    match turn {
        Some(turn) if widened < PI => {
            ((Quat::from_axis_angle(turn, widened - half) * axis).normalize(), widened)
        }
        _ => (axis, PI),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cones_hold_what_they_are_made_of() {
        let axes = [Vec3::X, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, -0.6, 0.8), Vec3::NEG_X];
        for a in axes {
            for b in axes {
                for (half, other) in [(0.0, 0.0), (0.1, 0.4), (1.0, 0.2), (3.0, 0.5)] {
                    let (axis, widened) = cone_around((a, half), (b, other));
                    for (inner, angle) in [(a, half), (b, other)] {
                        let reach = axis.angle_between(inner) + angle;
                        assert!(reach.min(PI) <= widened + 1e-3, "{a} {half}, {b} {other}");
                    }
                }
            }
        }
    }
}
