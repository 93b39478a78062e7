//! The change of measure of several points sampled together.

use std::ops::Range;

use super::{Part, Problem, Target};
use crate::expr::{Deps, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::jacobian::{self, Source};
use crate::matrix::{dot, is_frame};
use crate::rational::Q;

/// How many equal forms of a product are kept.
const FORMS: usize = 3;

/// A point of a result with the unknowns that make it once those before it are known.
pub(crate) struct Block {
    /// Which of the points it is, with the places of its coordinates.
    pub(crate) part: Part,
    pub(crate) place: Range<usize>,
    /// The unknowns that are its own.
    pub(crate) own: Vec<Leaf>,
}

/// The points of a result that can be had one after another: the first from some of the unknowns, the second from others
/// given the first, and so on. `None` for a single point, or if there is no such order.
pub(crate) fn blocks(problem: &Problem) -> Option<Vec<Block>> {
    let mut open = problem.placed();
    if open.len() < 2 {
        return None;
    }
    let mut unknowns: Vec<Leaf> = problem.unknowns.clone();
    let mut blocks = Vec::new();
    while !open.is_empty() {
        let (index, own) = open.iter().enumerate().find_map(|(i, (part, place))| {
            let used = |u: &&Leaf| {
                problem.outputs[place.clone()].iter().any(|o| problem.graph.has(*o, leaf_bit(**u)))
            };
            let own: Vec<Leaf> = unknowns.iter().filter(used).copied().collect();
            (own.len() == part.dimension).then_some((i, own))
        })?;
        let (part, place) = open.remove(index);
        unknowns.retain(|u| !own.contains(u));
        blocks.push(Block { part, place, own });
    }
    Some(blocks)
}

/// The volume of a result of several points that can be had one after another. Then the Jacobian is triangular in
/// blocks, and the volume is the product of those of the points, each with what came before held
/// fixed. `None` for a single point, or if there is no such order.
pub(super) fn volume(problem: &mut Problem) -> Option<Result<Vec<Id>, String>> {
    let blocks = blocks(problem)?;
    let mut product = vec![problem.graph.int(1)];
    for Block { part, place, own } in blocks {
        let outputs = problem.outputs[place].to_vec();
        let g = &mut problem.graph;
        let source = (Source::Free, part.target == Target::Direction);
        let bits = own.iter().fold(0, |bits, &u| bits | leaf_bit(u));
        let outputs = in_a_frame(g, &outputs, bits).unwrap_or(outputs);
        let volumes = match jacobian::volume(g, &outputs, &own, source, &problem.frames) {
            Ok(volumes) => volumes,
            Err(e) => return Some(Err(e)),
        };
        let pairs = product.iter().flat_map(|&p| volumes.iter().map(move |&v| (p, v)));
        product = pairs.take(FORMS).map(|(p, v)| g.mul(p, v)).collect();
    }
    Some(Ok(product))
}

/// The coordinates of a point in a frame that those before it make: a sum of perpendicular vectors of unit length, with
/// coefficients that depend on the `own` unknowns alone, covers what the coefficients do.
fn in_a_frame(g: &mut Graph, point: &[Id], own: Deps) -> Option<Vec<Id>> {
    if point.len() != 3 {
        return None;
    }
    let terms_of = |&x: &Id| match g.node(x).clone() {
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 3 => Some(terms),
        _ => None,
    };
    let (k, terms) = point.iter().enumerate().find_map(|(k, x)| Some((k, terms_of(x)?)))?;
    let is_made = |g: &Graph, v: &[Id; 3]| {
        let made = v.iter().fold(0, |bits, &c| bits | g.deps(c)) & UNKNOWNS;
        made != 0 && made & own == 0
    };
    let vectors: Vec<[Id; 3]> = g.vectors().iter().filter(|v| is_made(g, v)).copied().collect();
    let (mut axes, mut inside) = (Vec::new(), Vec::new());
    for (q, term) in terms {
        let term = g.sum(Q::ZERO, &[(q, term)]);
        let left: Vec<_> = vectors.iter().filter(|v| !axes.contains(*v)).copied().collect();
        let (axis, coefficient) = left.into_iter().find_map(|v| {
            let coefficient = g.div(term, v[k]);
            (g.deps(coefficient) & UNKNOWNS & !own == 0).then_some((v, coefficient))
        })?;
        axes.push(axis);
        inside.push(coefficient);
    }
    let rows = [0, 1, 2].map(|i| axes.iter().map(|axis| axis[i]).collect::<Vec<Id>>());
    let written = rows.iter().zip(point).all(|(row, &x)| dot(g, row, &inside) == x);
    let noted = g.made_frames().iter().any(|frame| frame.iter().all(|v| axes.contains(v)));
    (written && (noted || is_frame(g, &rows))).then_some(inside)
}

#[cfg(test)]
mod tests {
    use crate::expr::{Leaf, leaf_bit};
    use crate::interpret::Item;

    /// The second direction has the density of the lobe in the frame, whether that is asked for or written out.
    #[test]
    fn in_the_frame_of_an_earlier_direction_only_the_lobe_matters() {
        let made = "let turned = Frame::around(first).to_world(local);";
        let written = "let k = 1.0 / (1.0 + z);
            let right = Vec3::new(1.0 - x * x * k, -x * y * k, -x);
            let up = Vec3::new(-x * y * k, 1.0 - y * y * k, -y);
            let turned = local.x * right + local.y * up + local.z * Vec3::new(x, y, z);";
        for frame in [made, written] {
            let text = format!(
                "fn chain(u: [Uniform; 4]) -> (Direction, Direction) {{
                    let (r, phi) = (u[0].sqrt(), TAU * u[1]);
                    let (x, y, z) = (r * phi.cos(), r * phi.sin(), (1.0 - u[0]).sqrt());
                    let (s, psi) = (u[2].sqrt(), TAU * u[3]);
                    let local = Vec3::new(s * psi.cos(), s * psi.sin(), (1.0 - u[2]).sqrt());
                    let first = Direction::new(x, y, z);
                    {frame}
                    (first, Direction::from_vec(turned))
                }}"
            );
            let item = Item::new("".parse().unwrap(), text.parse().unwrap(), true).unwrap();
            assert_eq!(item.derived.len(), 1);
            let g = &item.parsed.pieces[0].problem.graph;
            let azimuths = [1, 3].map(|i| leaf_bit(Leaf::Unknown(i)));
            assert!(!g.has(item.derived[0].volume, azimuths[0] | azimuths[1]), "{frame}");
            let u = [0.3, 0.6, 0.2, 0.9];
            let x = item.forward(&[], &u).unwrap();
            let cosine: f64 = (0..3).map(|k| x[k] * x[k + 3]).sum();
            let expected = x[2] * cosine / std::f64::consts::PI.powi(2);
            assert!((item.pdf(&[], &x) / expected - 1.0).abs() < 1e-14);
        }
    }
}
