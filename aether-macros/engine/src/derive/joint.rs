//! The change of measure of several points sampled together.

use super::{Problem, Target};
use crate::expr::{Id, Leaf, leaf_bit};
use crate::jacobian::{self, Source};

/// How many equal forms of a product are kept.
const FORMS: usize = 3;

/// The volume of a result of several points that can be had one after another: the first from some of
/// the unknowns, the second from others given the first, and so on. Then the Jacobian is triangular in
/// blocks, and the volume is the product of those of the points, each with what came before held
/// fixed. `None` for a single point, or if there is no such order.
pub(super) fn volume(problem: &mut Problem) -> Option<Result<Vec<Id>, String>> {
    let mut open = problem.placed();
    if open.len() < 2 {
        return None;
    }
    let mut unknowns: Vec<Leaf> = problem.unknowns.clone();
    let mut product = vec![problem.graph.int(1)];
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
        let outputs = problem.outputs[place].to_vec();
        let g = &mut problem.graph;
        let source = (Source::Free, part.target == Target::Direction);
        let volumes = match jacobian::volume(g, &outputs, &own, source, &problem.frames) {
            Ok(volumes) => volumes,
            Err(e) => return Some(Err(e)),
        };
        let pairs = product.iter().flat_map(|&p| volumes.iter().map(move |&v| (p, v)));
        product = pairs.take(FORMS).map(|(p, v)| g.mul(p, v)).collect();
    }
    Some(Ok(product))
}
