//! Photons, and a hash grid that finds those next to a point.

use glam::{IVec3, Vec3};

/// Light that has arrived at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where.
    pub position: Vec3,
    /// The unit normal of the surface, on the side that the light has come to.
    pub normal: Vec3,
    /// The direction, of unit length, that it has come from.
    pub towards: Vec3,
    /// Radiance over the density of the place, in linear Rec. 709: its mean over photons is irradiance times
    /// area, but for the cosine.
    pub power: Vec3,
    /// How many edges its path has.
    pub edges: u32,
}

/// The search radius of a sample over that of the first, where `alpha` says how fast it shrinks (Knaus and
/// Zwicker 2011, Eq. 15).
pub fn shrunk(alpha: f32, sample: u32) -> f32 {
    let step = |i: u32| (f64::from(i) + f64::from(alpha)) / (f64::from(i) + 1.0);
    (1..=sample).map(step).product::<f64>().sqrt() as f32
}

/// Something at a place.
pub trait Placed: Copy {
    /// Where it is.
    fn position(&self) -> Vec3;
}

impl Placed for Photon {
    fn position(&self) -> Vec3 {
        self.position
    }
}

/// Photons, or other things at places, sorted by the cells of a grid.
#[derive(Clone, Debug)]
pub struct PhotonMap<P = Photon> {
    photons: Vec<P>,
    /// Where the photons of each bucket of cells begin.
    starts: Vec<u32>,
    radius: f32,
}

impl<P> Default for PhotonMap<P> {
    fn default() -> Self {
        PhotonMap { photons: Vec::new(), starts: Vec::new(), radius: 0.0 }
    }
}

impl<P: Placed> PhotonMap<P> {
    /// A map for searches within a radius.
    pub fn new(photons: Vec<P>, radius: f32) -> Self {
        let buckets = photons.len().next_power_of_two().max(16);
        let mut map = PhotonMap { photons: Vec::new(), starts: vec![0; buckets + 1], radius };
        let bucket: Vec<usize> =
            photons.iter().map(|photon| map.bucket(map.cell(photon.position()))).collect();
        for bucket in &bucket {
            map.starts[bucket + 1] += 1;
        }
        for k in 0..buckets {
            map.starts[k + 1] += map.starts[k];
        }
        let mut order: Vec<usize> = (0..photons.len()).collect();
        // Stable: the order of photons, and of sums over them, does not depend on anything else.
        order.sort_by_key(|k| bucket[*k]);
        map.photons = order.into_iter().map(|k| photons[k]).collect();
        map
    }

    /// The search radius.
    pub fn radius(&self) -> f32 {
        self.radius
    }

    fn cell(&self, position: Vec3) -> IVec3 {
        (position / (2.0 * self.radius)).floor().as_ivec3()
    }

    fn bucket(&self, cell: IVec3) -> usize {
        let [x, y, z] = cell.to_array().map(|c| c as u32 as u64);
        let mixed = (x.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
            .wrapping_add(z.wrapping_mul(0x1656_67b1_9e37_79f9));
        ((mixed ^ (mixed >> 29)) as usize) & (self.starts.len() - 2)
    }

    /// Calls `visit` with each photon within the radius of a point.
    pub fn near(&self, point: Vec3, mut visit: impl FnMut(&P)) {
        if self.photons.is_empty() {
            return;
        }
        // The ball reaches into at most eight cells, twice as wide as itself.
        let lowest = self.cell(point - self.radius);
        let highest = self.cell(point + self.radius);
        let mut seen = [usize::MAX; 8];
        let mut count = 0;
        for x in lowest.x..=highest.x {
            for y in lowest.y..=highest.y {
                for z in lowest.z..=highest.z {
                    let bucket = self.bucket(IVec3::new(x, y, z));
                    // Two cells may share a bucket.
                    if seen[..count].contains(&bucket) || count == seen.len() {
                        continue;
                    }
                    seen[count] = bucket;
                    count += 1;
                    let [start, end] = [bucket, bucket + 1].map(|b| self.starts[b] as usize);
                    let within = self.radius * self.radius;
                    let inside = |p: &&P| p.position().distance_squared(point) <= within;
                    self.photons[start..end].iter().filter(inside).for_each(&mut visit);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use aether_core::{Pcg32, UniformSource};

    #[test]
    fn the_grid_finds_what_a_search_of_all_finds() {
        let mut random = Pcg32::new(1, 0, 0);
        let mut next = move || {
            let u: f32 = random.next();
            4.0 * u - 2.0
        };
        let mut point = || Vec3::new(next(), next(), next());
        let photon = |position| Photon {
            position,
            normal: Vec3::Z,
            towards: Vec3::Z,
            power: Vec3::ONE,
            edges: 1,
        };
        let photons: Vec<Photon> = (0..3000).map(|_| photon(point())).collect();
        let map = PhotonMap::new(photons.clone(), 0.3);
        for _ in 0..200 {
            let at = point();
            let mut found = Vec::new();
            map.near(at, |photon| found.push(photon.position));
            let mut all: Vec<Vec3> = photons.iter().map(|photon| photon.position).collect();
            all.retain(|p| p.distance_squared(at) <= 0.09);
            let key = |p: &Vec3| p.to_array().map(f32::to_bits);
            found.sort_by_key(key);
            all.sort_by_key(key);
            assert_eq!(found, all);
        }
        assert!(!photons.is_empty());
        PhotonMap::<Photon>::new(Vec::new(), 0.1).near(Vec3::ZERO, |_| panic!("there is none"));
    }
}
