//! A hierarchy of lights: which one is worth sampling from where.

use aether_core::discrete::{Importance, NodeId, Tree, TreeBuilder};
use glam::Vec3;

use super::bounds::Extent;

/// Groups of lights are split between this many equal parts of their box.
const PARTS: usize = 12;
/// Groups of no more than this are halved.
const SMALL: usize = 8;
/// Below this depth groups are halved, so that no tree is deeper than this and the logarithm of its size.
const DEEPEST: usize = 40;
/// What remains of a cosine that bounds say is zero, within their rounding errors.
const LEAST_COSINE: f32 = 1e-3;

/// What a node of the hierarchy knows of its lights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Group {
    /// Lights at finite distances: a sphere around them, a cone around their normals by its axis and the
    /// cosine of its half angle, and the cosine of the largest angle to a normal at which there is light.
    Near {
        /// The centre of the sphere.
        center: Vec3,
        /// Its radius.
        radius: f32,
        /// The axis of the normals.
        axis: Vec3,
        /// The cosine of the half angle of the normals.
        normals: f32,
        /// The cosine of the angle between normals and light.
        emission: f32,
    },
    /// Lights that are infinitely far away.
    Far,
}

impl Group {
    fn of(extent: &Extent) -> Self {
        let center = extent.middle();
        Group::Near {
            center,
            radius: (extent.bounds.max - center).length(),
            axis: extent.axis,
            normals: extent.normals.cos(),
            emission: extent.emission.cos(),
        }
    }
}

/// A hierarchy over lights, numbered as they were given.
pub type Hierarchy = Tree<u32, Group>;

/// The hierarchy of lights: near ones with their extents, far ones with the irradiance that they cause at
/// most, both by their numbers, which together are 0, 1, 2, … `None` if there is no light in them.
pub fn build(near: &[(u32, Extent)], far: &[(u32, f32)]) -> Option<Hierarchy> {
    let mut builder = TreeBuilder::new();
    let mut all: Vec<(u32, f32, Group)> = Vec::with_capacity(near.len() + far.len());
    all.extend(near.iter().map(|(number, extent)| (*number, extent.weight, Group::of(extent))));
    all.extend(far.iter().map(|(number, irradiance)| (*number, *irradiance, Group::Far)));
    all.sort_by_key(|(number, ..)| *number);
    let leaf = |(number, weight, group)| builder.leaf(number, f64::from(weight), group);
    let leaves: Vec<NodeId> = all.into_iter().map(leaf).collect();
    let item =
        |(number, extent): &(u32, Extent)| Item { node: leaves[*number as usize], extent: *extent };
    let mut items: Vec<Item> = near.iter().map(item).collect();
    let near = split(&mut builder, &mut items, 0).map(|(root, _)| root);
    let far = far.iter().map(|(number, _)| leaves[*number as usize]);
    let far = far.reduce(|a, b| builder.join(a, b, Group::Far).unwrap_or(a));
    if let (Some(near), Some(far)) = (near, far) {
        // Nobody asks for the importance of the root.
        builder.join(near, far, Group::Far).ok()?;
    }
    builder.build().ok()
}

#[derive(Clone, Copy)]
struct Item {
    node: NodeId,
    extent: Extent,
}

type Builder = TreeBuilder<u32, Group>;

/// Joins lights until one node is left, which has their extent. `None` for no lights.
fn split(builder: &mut Builder, items: &mut [Item], depth: usize) -> Option<(NodeId, Extent)> {
    if let [item] = items {
        return Some((item.node, item.extent));
    }
    let (axis, low, high) = longest_side(items)?;
    let large = items.len() > SMALL && depth < DEEPEST && low < high && (high - low).is_finite();
    let middle = if large {
        cheapest(items, axis, (low, high))
    } else {
        let at = |item: &Item| item.extent.middle()[axis];
        items.sort_by(|a, b| at(a).total_cmp(&at(b)));
        items.len() / 2
    };
    let (left, right) = items.split_at_mut_checked(middle)?;
    let (left, a) = split(builder, left, depth + 1)?;
    let (right, b) = split(builder, right, depth + 1)?;
    let extent = a.union(&b);
    Some((builder.join(left, right, Group::of(&extent)).ok()?, extent))
}

/// The longest side of the box around the middles of lights: its axis and where it begins and ends.
fn longest_side(items: &[Item]) -> Option<(usize, f32, f32)> {
    let first = items.first()?.extent.middle();
    let (min, max) = items.iter().fold((first, first), |(min, max), item| {
        let middle = item.extent.middle();
        (min.min(middle), max.max(middle))
    });
    let axis = (max - min).max_position();
    Some((axis, min[axis], max[axis]))
}

/// Orders lights along an axis in equal parts, and tells where to cut between two parts so that both groups
/// together cost least. There are lights in the first and in the last part.
fn cheapest(items: &mut [Item], axis: usize, (low, high): (f32, f32)) -> usize {
    let part = |item: &Item| {
        let at = (item.extent.middle()[axis] - low) / (high - low) * PARTS as f32;
        (at as usize).min(PARTS - 1)
    };
    let mut parts: [Option<Extent>; PARTS] = [None; PARTS];
    for item in items.iter() {
        let sum = &mut parts[part(item)];
        *sum = Some(sum.map_or(item.extent, |sum| sum.union(&item.extent)));
    }
    // What the first k + 1 parts cost, and the last k + 1.
    let running = |parts: &mut dyn Iterator<Item = &Option<Extent>>| {
        let mut sum: Option<Extent> = None;
        parts
            .map(|part| {
                sum = match (sum, part) {
                    (Some(a), Some(b)) => Some(a.union(b)),
                    (a, b) => a.or(*b),
                };
                sum.map_or(0.0, |sum| sum.cost())
            })
            .collect::<Vec<f32>>()
    };
    let (left, right) = (running(&mut parts.iter()), running(&mut parts.iter().rev()));
    let cost = |cut: &usize| left[cut - 1] + right[PARTS - 1 - cut];
    let cut = (1..PARTS).min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(1);
    let (mut ordered, rest): (Vec<Item>, Vec<Item>) = items.iter().partition(|i| part(i) < cut);
    let middle = ordered.len();
    ordered.extend(rest);
    items.copy_from_slice(&ordered);
    middle
}

/// A place to be lit.
#[derive(Clone, Copy, Debug)]
pub struct Lit {
    /// Where.
    pub position: Vec3,
    /// The normal for shading; none for a place that is lit from all sides alike.
    pub normal: Option<Vec3>,
}

impl Importance<Group, f32> for Lit {
    /// About the largest irradiance that lights of this weight could cause: never zero where they cause
    /// any. After Conty Estevez and Kulla (2018), section 4.2.
    fn importance(&self, group: &Group, weight: f32) -> f32 {
        let Group::Near { center, radius, axis, normals, emission } = *group else {
            return weight;
        };
        let to = center - self.position;
        let squared = to.length_squared();
        if squared <= 1.0001 * radius * radius {
            return weight / (radius * radius);
        }
        let distance = squared.sqrt();
        let to = to / distance;
        let sphere = (1.0 - (radius / distance).powi(2)).max(0.0).sqrt();
        // The least angle between a normal and the way to here.
        let angle = less(less(-to.dot(axis), normals), sphere);
        if angle < emission - LEAST_COSINE {
            return 0.0;
        }
        let surface = self.normal.map_or(1.0, |normal| less(to.dot(normal).abs(), sphere));
        // Points do not fade away from their axis.
        let fade = if emission > 0.5 { 1.0 } else { angle.max(LEAST_COSINE) };
        weight * fade * surface.max(LEAST_COSINE) / squared
    }
}

/// The cosine of the difference of two angles between 0 and π given by their cosines, or one if the second
/// is larger.
fn less(a: f32, b: f32) -> f32 {
    if a >= b {
        return 1.0;
    }
    let sine = |c: f32| (1.0 - c * c).max(0.0).sqrt();
    a * b + sine(a) * sine(b)
}

#[cfg(test)]
mod tests {
    use aether_core::discrete::Discrete;
    use aether_core::{Pcg32, UniformSource};

    use super::*;
    use crate::scene::Primitive;

    type Near = (u32, Extent);

    /// Random small triangles in a box, and two lights from afar.
    fn lights(count: u32) -> (Vec<Near>, [(u32, f32); 2]) {
        let mut random = Pcg32::new(3, 0, 0);
        let mut next = || UniformSource::<f32>::next(&mut random);
        let near = (0..count).map(|number| {
            let v0 = 10.0 * Vec3::new(next(), next(), next());
            let [v1, v2] = [(); 2].map(|()| v0 + 0.3 * Vec3::new(next(), next(), next()));
            let shape = Primitive::Triangle { v0, v1, v2 };
            let weight = if number % 50 == 0 { 1e4 } else { next() };
            (number, Extent::of_primitive(&shape, shape.normal(v0), weight))
        });
        (near.collect(), [(count, 0.5), (count + 1, 2.0)])
    }

    #[test]
    fn probabilities_sum_to_one_and_are_those_of_sampling() {
        let (near, far) = lights(200);
        let tree = build(&near, &far).unwrap();
        for (k, normal) in [None, Some(Vec3::Z), Some(Vec3::X)].into_iter().enumerate() {
            let view =
                tree.seen_by::<f32, _>(Lit { position: Vec3::splat(3.0 * k as f32), normal });
            let sum: f64 = (0..202).map(|leaf| f64::from(view.probability(leaf))).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
            for u in 0..1000 {
                let choice = view.sample((u as f32 + 0.5) / 1000.0);
                let looked_up = view.probability(*choice.item as usize);
                assert!((choice.probability / looked_up - 1.0).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn no_light_that_contributes_is_left_out() {
        let (near, far) = lights(300);
        let tree = build(&near, &far).unwrap();
        let mut random = Pcg32::new(4, 0, 0);
        let mut next = || UniformSource::<f32>::next(&mut random);
        let mut left_out = 0;
        for _ in 0..200 {
            let position = 12.0 * Vec3::new(next(), next(), next()) - 1.0;
            let normal = Vec3::new(next() - 0.5, next() - 0.5, next() - 0.5).normalize();
            let view = tree.seen_by::<f32, _>(Lit { position, normal: Some(normal) });
            for (number, extent) in &near {
                let p = view.probability(*number as usize);
                left_out += u32::from(p == 0.0);
                // Flat triangles: what they send is positive on one side only.
                let sends = extent.axis.dot(position - extent.middle()) > 0.0;
                assert!(p > 0.0 || !sends, "light {number} from {position}");
            }
        }
        // Many of those that turn their backs are left out.
        assert!(left_out > 2000, "{left_out}");
    }

    #[test]
    fn lights_in_one_place_and_none() {
        assert!(build(&[], &[]).is_none());
        let place = Vec3::ONE;
        let shape = Primitive::Sphere { center: place, radius: 0.0, flipped: false };
        let all: Vec<_> =
            (0..100).map(|k| (k, Extent::of_primitive(&shape, Vec3::X, 1.0))).collect();
        let tree = build(&all, &[]).unwrap();
        for position in [place, Vec3::ZERO] {
            let view = tree.seen_by::<f32, _>(Lit { position, normal: None });
            let sum: f32 = (0..100).map(|leaf| view.probability(leaf)).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum}");
        }
    }
}
