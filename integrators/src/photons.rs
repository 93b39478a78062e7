//! Photons, a hash grid that finds those next to a point, and how far away that may be.

use aether_core::Arena;
use aether_core::uniform::Middle;
use glam::{IVec3, Vec3};

use crate::emission::LightStrategies;
use crate::kind::SceneKind;
use crate::strategies::Aim;
use crate::subpaths::{camera_path, first_edge};
use crate::world::World;

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

/// Rows and columns of film points by which is judged what the camera sees.
const LOOKS: u32 = 32;

/// Half the diagonal of what the camera sees of the scene, a tenth at either end of each axis aside, and at most the
/// radius of the whole: what first search radii are relative to. The plane on which a house stands should not blur its rooms.
pub fn seen_size<K: SceneKind>(world: &World<'_, K>) -> f32 {
    let mut arena = Arena::<_, LightStrategies<K>>::new();
    let (_, whole) = world.lights.bounds;
    let mut along: [Vec<f32>; 3] = Default::default();
    for k in 0..LOOKS * LOOKS {
        arena.clear();
        let at = |i: u32, size: u32| {
            (u64::from(size) * u64::from(2 * i + 1) / u64::from(2 * LOOKS)) as u32
        };
        let film = &world.scene.film;
        let pixel = (at(k % LOOKS, film.width), at(k / LOOKS, film.height));
        let path = camera_path(world, &arena, &mut Middle, Aim::Pixel(pixel), (2, 0));
        let Some([_, seen]) = first_edge(&path) else { continue };
        if seen.surface().is_some() {
            along.iter_mut().zip(seen.position.to_array()).for_each(|(axis, x)| axis.push(x));
        }
    }
    let extents = along.map(|mut axis| {
        axis.sort_unstable_by(f32::total_cmp);
        let tenth = axis.len() / 10;
        let ends = axis.get(tenth).zip(axis.get(axis.len().wrapping_sub(tenth + 1)));
        // As wide as all of it if that is even.
        ends.map_or(0.0, |(low, high)| (high - low) / 0.8)
    });
    let seen = 0.5 * Vec3::from(extents).length();
    if seen > 0.0 { seen.min(whole) } else { whole }
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
    use crate::kind::Everything;
    use crate::scene::Scene;
    use aether_core::{Pcg32, UniformSource};

    #[test]
    fn what_is_not_seen_does_not_make_a_scene_larger() {
        let size = |around: &str| {
            let text = format!(
                r#"<scene version="3.0.0"><sensor type="perspective"><float name="fov" value="60"/>
                    <transform name="to_world"><lookat origin="0,0,3" target="0,0,0" up="0,1,0"/></transform>
                    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/></film>
                </sensor><shape type="rectangle"><bsdf type="diffuse"/></shape>{around}</scene>"#
            );
            let scene = Scene::from_str(&text, std::path::Path::new("."), &[]).unwrap();
            seen_size(&World::<Everything>::new(&scene).unwrap())
        };
        let alone = size("");
        assert!((alone - 2f32.sqrt()).abs() < 0.05, "{alone}");
        let far = r#"<shape type="rectangle"><transform name="to_world"><scale value="200"/>
            <translate z="9"/></transform></shape>"#;
        assert!((size(far) / alone - 1.0).abs() < 0.2, "{} for {alone}", size(far));
        // Nothing is seen.
        let behind = r#"<shape type="sphere"><point name="center" x="0" y="0" z="9"/></shape>"#;
        assert!(size(behind) > 0.0);
    }

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
