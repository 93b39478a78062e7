//! The watertight triangle test, eight triangles at once.
//!
//! After Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): space is sheared so
//! that the ray runs along an axis; the three edge functions of a triangle then depend only on the
//! sheared corners, so that triangles agree exactly about their shared edges.

use glam::Vec3;

use super::model::PrimitiveId;
use super::simd::{Eight, LANES, Points, abs, cross, max, minus};

/// The coordinates in the order in which the third one is the longest of a direction: two rows for each, for directions
/// that go up along it and for those that go down, for which the others change places to keep the handedness.
const TURNS: [[usize; 3]; 6] = [[1, 2, 0], [2, 1, 0], [2, 0, 1], [0, 2, 1], [0, 1, 2], [1, 0, 2]];

/// A ray prepared for the test.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// A unit vector.
    pub direction: Vec3,
    axes: [usize; 3],
    /// The coordinates of the origin along these axes.
    along: [f32; 3],
    shear: Vec3,
}

impl Ray {
    /// A ray from `origin` along the unit vector `direction`.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let size = direction.abs();
        let longest = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let (o, d) = (origin.to_array(), direction.to_array());
        let [x, y, z] = TURNS[2 * longest + usize::from(d[longest] < 0.0)];
        let (along, shear) = ([o[x], o[y], o[z]], Vec3::new(d[x], d[y], 1.0) / d[z]);
        Self { origin, direction, axes: [x, y, z], along, shear }
    }
}

/// Up to eight triangles.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Packet {
    /// By corner, then by coordinate. NaN where there is no triangle.
    corners: [[[f32; LANES]; 3]; 3],
    /// Their places in the list of the scene.
    ids: [u32; LANES],
}

/// Where a ray meets the triangles of a packet; `t` may be negative.
pub struct Meetings<E> {
    /// Which are met: a bit for each.
    pub met: u32,
    /// Which the ray rises through along their normals, among those that are met, by the signs of their edge functions.
    pub rises: u32,
    /// Distances along the ray, finite where they are met.
    pub t: E,
    /// Weights of the corners; their sum is 1.
    pub weights: [E; 3],
    sheared: [[E; 3]; 3],
    inverse_det: E,
}

impl Packet {
    /// Holds at most eight triangles.
    pub fn new(triangles: impl Iterator<Item = (PrimitiveId, [Vec3; 3])>) -> Self {
        let mut packet = Self { corners: [[[f32::NAN; LANES]; 3]; 3], ids: [u32::MAX; LANES] };
        for (lane, (id, triangle)) in triangles.enumerate() {
            packet.ids[lane] = id.0;
            for (corners, v) in packet.corners.iter_mut().zip(triangle) {
                for (axis, numbers) in corners.iter_mut().enumerate() {
                    numbers[lane] = v[axis];
                }
            }
        }
        packet
    }

    /// Which triangle is in a lane.
    #[inline(always)]
    pub fn id(&self, lane: usize) -> PrimitiveId {
        PrimitiveId(self.ids[lane])
    }

    /// Whether a point lies in the box around the triangle in a lane, or no further out than the padding.
    #[cold]
    #[inline(never)]
    pub fn is_next_to(&self, lane: usize, point: Vec3, padding: f32) -> bool {
        let [a, b, c] = self.corners.each_ref().map(|corner| {
            let [x, y, z] = corner.each_ref().map(|numbers| numbers[lane]);
            Vec3::new(x, y, z)
        });
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        point.cmpge(min - padding).all() && point.cmple(max + padding).all()
    }

    /// Where the line along the ray meets the triangles but two of them, from either side, at most at a finite distance
    /// `limit`.
    #[inline(always)]
    pub fn meet<E: Eight>(
        &self,
        machine: E::Machine,
        ray: &Ray,
        but: [u32; 2],
        limit: f32,
    ) -> Option<Meetings<E>> {
        let sheared: [Points<E>; 3] = [
            self.sheared(machine, ray, 0),
            self.sheared(machine, ray, 1),
            self.sheared(machine, ray, 2),
        ];
        let [a, b, c] = &sheared;
        let (mut u, mut v, mut w) = (edge(c, b), edge(a, c), edge(b, a));
        let zero = E::splat(machine, 0.0);
        // A difference that is not zero has the right sign: rounding keeps the order of the two products.
        let (mut least, mut most) = (u.min(v).min(w), u.max(v).max(w));
        let mut inside = zero.at_most(least) | most.at_most(zero);
        if inside == 0 {
            return None;
        }
        inside &= !E::among(machine, &self.ids, but);
        if inside == 0 {
            return None;
        }
        let doubtful = inside & (least.equal(zero) | most.equal(zero));
        if doubtful != 0 {
            let corners = [arrays(a), arrays(b), arrays(c)];
            let exact = exact(doubtful, &corners, arrays(&[u, v, w]));
            u = E::load(machine, &exact[0]);
            v = E::load(machine, &exact[1]);
            w = E::load(machine, &exact[2]);
            // Zeros count on either side, but not all three.
            (least, most) = (u.min(v).min(w), u.max(v).max(w));
            inside &= zero.at_most(least) ^ most.at_most(zero) | !doubtful;
            if inside == 0 {
                return None;
            }
        }
        let rises = most.at_most(zero);
        let inverse_det = E::splat(machine, 1.0) / (u + v + w);
        let weights = [u * inverse_det, v * inverse_det, w * inverse_det];
        let shear_z = E::splat(machine, ray.shear.z);
        let t = weights[0] * (a[2] * shear_z)
            + weights[1] * (b[2] * shear_z)
            + weights[2] * (c[2] * shear_z);
        let met =
            inside & t.at_most(E::splat(machine, limit)) & E::splat(machine, -f32::MAX).at_most(t);
        (met != 0).then_some(Meetings { met, rises, t, weights, sheared, inverse_det })
    }

    /// Normals of the triangles, twice as long as their areas.
    #[inline(always)]
    pub fn normals<E: Eight>(&self, machine: E::Machine) -> Points<E> {
        let v0 = self.corner(machine, 0);
        let sides = [minus(&self.corner(machine, 1), &v0), minus(&self.corner(machine, 2), &v0)];
        cross(&sides[0], &sides[1])
    }

    /// Bounds of the coordinates of the corners.
    #[inline(always)]
    pub fn sizes<E: Eight>(&self, machine: E::Machine) -> Points<E> {
        let (v0, v1) = (abs(&self.corner(machine, 0)), abs(&self.corner(machine, 1)));
        max(&max(&v0, &v1), &abs(&self.corner(machine, 2)))
    }

    #[inline(always)]
    fn corner<E: Eight>(&self, machine: E::Machine, i: usize) -> Points<E> {
        let [x, y, z] = &self.corners[i];
        [E::load(machine, x), E::load(machine, y), E::load(machine, z)]
    }

    /// A corner in the space where the ray goes from the origin along the third axis.
    #[inline(always)]
    fn sheared<E: Eight>(&self, machine: E::Machine, ray: &Ray, i: usize) -> Points<E> {
        let [x, y, z] = ray.axes;
        let corner = &self.corners[i];
        let z = E::load(machine, &corner[z]) - E::splat(machine, ray.along[2]);
        let x = E::load(machine, &corner[x]) - E::splat(machine, ray.along[0]);
        let y = E::load(machine, &corner[y]) - E::splat(machine, ray.along[1]);
        let shear = &ray.shear;
        [x - E::splat(machine, shear.x) * z, y - E::splat(machine, shear.y) * z, z]
    }
}

/// Twice the signed area of a triangle with the origin.
#[inline(always)]
fn edge<E: Eight>(p: &Points<E>, q: &Points<E>) -> E {
    p[0] * q[1] - p[1] * q[0]
}

#[inline(always)]
fn arrays<E: Eight>(p: &Points<E>) -> [[f32; LANES]; 3] {
    [p[0].to_array(), p[1].to_array(), p[2].to_array()]
}

/// Edge functions again, in double precision, for the lanes whose bits are set.
#[cold]
#[inline(never)]
fn exact(
    lanes: u32,
    [a, b, c]: &[[[f32; LANES]; 3]; 3],
    mut rough: [[f32; LANES]; 3],
) -> [[f32; LANES]; 3] {
    for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
        let at = |p: &[[f32; LANES]; 3]| [0, 1].map(|axis| f64::from(p[axis][lane]));
        let edge = |p: [f64; 2], q: [f64; 2]| (p[0] * q[1] - p[1] * q[0]) as f32;
        let (a, b, c) = (at(a), at(b), at(c));
        rough[0][lane] = edge(c, b);
        rough[1][lane] = edge(a, c);
        rough[2][lane] = edge(b, a);
    }
    rough
}

/// Bounds of the errors of `t` (Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd
/// edition, section 3.9.6).
#[inline(always)]
pub fn t_errors<E: Eight>(machine: E::Machine, ray: &Ray, meetings: &Meetings<E>) -> E {
    let [a, b, c] = &meetings.sheared;
    let [max_x, max_y, max_z] = max(&max(&abs(a), &abs(b)), &abs(c));
    let max_z = max_z * E::splat(machine, ray.shear.z.abs());
    let [gamma_2, gamma_3, gamma_5] =
        [E::splat(machine, gamma(2)), E::splat(machine, gamma(3)), E::splat(machine, gamma(5))];
    let error_z = gamma_3 * max_z;
    let error_x = gamma_5 * (max_x + max_z);
    let error_y = gamma_5 * (max_y + max_z);
    let two = E::splat(machine, 2.0);
    let error_e = two * (gamma_2 * max_x * max_y + error_y * max_x + error_x * max_y);
    let max_e = two * max_x * max_y;
    let sum = gamma_3 * max_e * max_z + error_e * max_z + error_z * max_e;
    E::splat(machine, 3.0) * sum * meetings.inverse_det.abs()
}

/// The relative error of so many roundings.
const fn gamma(roundings: u32) -> f32 {
    let n = roundings as f32 * 0.5 * f32::EPSILON;
    n / (1.0 - n)
}
