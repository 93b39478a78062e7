//! A direction in a frame: what is written in the coordinates of a frame is derived in these.
//!
//! A frame by its type keeps lengths, angles and measures, so that the inverse, the density and the choice of the
//! coordinates that tell an unknown best (next to the axis of a frame, those across it) are those of the direction in
//! the frame. In terms of the point itself the axes of the frame would be poles like any others, of which nobody knows.

use super::{Derived, Problem};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, TurnedVector, UNKNOWNS};
use crate::interval::Interval;
use crate::matrix::dot;
use crate::sorted;

/// The axes of a frame, and a direction as it is written and by its coordinates along them.
pub(super) struct Turned {
    axes: [[Id; 3]; 3],
    written: Vec<Id>,
    inside: Vec<Id>,
}

/// The frame that a sampler turns its direction by, if it does so last.
pub(super) fn turned(problem: &mut Problem) -> Option<Turned> {
    let plain = problem.argument.is_none() && problem.stages.is_empty();
    if !problem.is_direction() || !plain {
        return None;
    }
    let g = &mut problem.graph;
    let written = &problem.outputs;
    let by_parameter = problem.frames.iter().find_map(|&axes| {
        let inside = along(g, axes, written)?;
        Some(Turned { axes, written: written.clone(), inside })
    });
    // A frame about a direction that is sampled turns with the point.
    let fixed = |axes: &[[Id; 3]; 3]| axes.iter().flatten().all(|id| !g.has(*id, UNKNOWNS));
    let made = || g.turned().iter().find(|t| t.written[..] == written[..] && fixed(&t.axes));
    by_parameter.or_else(|| {
        let TurnedVector { axes, inside, .. } = made()?;
        Some(Turned { axes: *axes, written: written.clone(), inside: inside.to_vec() })
    })
}

/// The coordinates of a point along three axes, if it is written as the sum of these with coefficients that do not
/// depend on them.
fn along(g: &mut Graph, axes: [[Id; 3]; 3], written: &[Id]) -> Option<Vec<Id>> {
    let leaves = axes.map(|axis| axis.map(|id| leaf(g, id)));
    let of_frame = axes.iter().flatten().fold(0, |bits, id| bits | g.deps(*id));
    let coefficient = |g: &mut Graph, k: usize| {
        let c = derivative(g, written[0], leaves[k][0]?);
        (!g.has(c, of_frame)).then_some(c)
    };
    let inside = [0, 1, 2].map(|k| coefficient(g, k));
    let inside = inside.into_iter().collect::<Option<Vec<Id>>>()?;
    let is_sum = |(i, &id): (usize, &Id)| dot(g, &axes.map(|axis| axis[i]), &inside) == id;
    written.iter().enumerate().all(is_sum).then_some(inside)
}

fn leaf(g: &Graph, id: Id) -> Option<Leaf> {
    match g.node(id) {
        Node::Leaf(leaf) => Some(*leaf),
        _ => None,
    }
}

impl Turned {
    /// What is found for the direction in the frame, in terms of the direction itself.
    pub(super) fn derive(
        &self,
        problem: &mut Problem,
        derive: impl Fn(&mut Problem) -> Result<Derived, String>,
    ) -> Result<Derived, String> {
        problem.outputs.clone_from(&self.inside);
        let found = derive(problem);
        problem.outputs.clone_from(&self.written);
        found.map(|derived| self.outside(&mut problem.graph, derived))
    }

    fn outside(&self, g: &mut Graph, mut derived: Derived) -> Derived {
        let x = [0, 1, 2].map(|k| g.get_leaf(Leaf::Out(k)));
        let inside = self.axes.map(|axis| dot(g, &axis, &x));
        for coordinate in inside {
            g.assume(coordinate, Interval::new(-1.0, 1.0));
        }
        let names = [0, 1, 2].map(|k| format!("{} = {}", show(g, x[k]), show(g, inside[k])));
        derived.steps.insert(0, format!("in the frame: {}", names.join(", ")));
        let values = sorted::map(x.into_iter().zip(inside));
        for preimage in &mut derived.preimages {
            for id in preimage.expressions() {
                let range = g.range(*id);
                *id = g.substitute(*id, &values);
                // What was known of it is known of no sum.
                g.assume(*id, range);
            }
            if let Some(image) = &mut preimage.back {
                for id in image.expressions() {
                    *id = g.substitute(*id, &values);
                }
                image.coordinates = self.sum(g, &image.coordinates);
                image.scaled = None;
            }
        }
        derived.forward = self.sum(g, &derived.forward);
        derived
    }

    /// The point with these coordinates along the axes.
    fn sum(&self, g: &mut Graph, coordinates: &[Id]) -> Vec<Id> {
        (0..3).map(|i| dot(g, &self.axes.map(|axis| axis[i]), coordinates)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Fun, OUTS, leaf_bit};
    use crate::interpret::Item;

    #[test]
    fn next_to_the_axis_of_a_frame_the_other_coordinates_tell() {
        let text = "fn cone(u: [Uniform; 2], depth: f64, frame: Frame) -> Direction {
            let h = depth * u[0];
            let r = (h * (2.0 - h)).sqrt();
            let phi = TAU * u[1];
            Direction::from_vec(frame.to_world(Vec3::new(r * phi.cos(), r * phi.sin(), 1.0 - h)))
        }";
        let domain = "depth in 1e-12..=2.0".parse().unwrap();
        let item = Item::new(domain, text.parse().unwrap(), true).unwrap();
        assert!(item.derived[0].steps[0].starts_with("in the frame: x = "));
        let depth = 1e-12;
        let p = [depth, 0.8, 0.0, -0.6, 0.0, 1.0, 0.0, 0.6, 0.0, 0.8];
        let u = [0.3, 0.7];
        let x = item.forward(&p, &u).unwrap();
        let found = item.preimages(&p, &x);
        assert!(found.len() == 1, "{found:?}");
        assert!(found[0].iter().zip(u).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        let expected = 1.0 / (std::f64::consts::TAU * depth);
        assert!((item.pdf(&p, &x) / expected - 1.0).abs() < 1e-12);
        // The same height about another axis is outside.
        assert_eq!(item.pdf(&p, &[x[0], x[2], x[1]]), 0.0);
    }

    #[test]
    fn what_tells_of_a_point_is_told_of_it_in_the_frame() {
        let text = "fn lobe(u: [Uniform; 2], frame: Frame) -> Direction {
            let r = u[0].sqrt();
            let phi = TAU * u[1];
            let local = Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
            Direction::from_vec(frame.to_world(local))
        }";
        let domain = "".parse().unwrap();
        let mut item = Item::new(domain, text.parse().unwrap(), true).unwrap();
        let frame = (0..9).fold(0, |bits, k| bits | leaf_bit(Leaf::Param(k)));
        let preimage = &mut item.derived[0].preimages[0];
        let of_point: Vec<Id> = preimage.expressions().map(|id| *id).collect();
        let g = &item.parsed.pieces[0].problem.graph;
        for id in of_point.into_iter().filter(|id| g.has(*id, OUTS)) {
            assert!(g.has(id, frame), "{}", show(g, id));
        }
    }

    #[test]
    fn coordinates_along_axes_do_not_depend_on_them() {
        let mut g = Graph::new();
        let axes = [0_u8, 1, 2].map(|k| {
            let entry = |i| (Leaf::Param(3 * k + i), format!("f{k}{i}"));
            [0_u8, 1, 2].map(|i| {
                let (leaf, name) = entry(i);
                g.leaf(leaf, &name, Interval::ALL)
            })
        });
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let [sine, cosine] = [Fun::Sin, Fun::Cos].map(|f| g.call(f, &[u]));
        let turned = Turned { axes, written: vec![], inside: vec![] };
        let inside = vec![sine, cosine, u];
        let mut written = turned.sum(&mut g, &inside);
        assert_eq!(along(&mut g, axes, &written), Some(inside));
        written[1] = g.add(written[1], u);
        assert_eq!(along(&mut g, axes, &written), None);
        let bent = turned.sum(&mut g, &[sine, axes[0][0], u]);
        assert_eq!(along(&mut g, axes, &bent), None);
    }
}
