//! Coordinates that are together a unit vector, and 1 - x² of one of them as the squares of the others.
//!
//! Next to one, x says little of how far it is from there; the others say it to full precision.

use crate::expr::{Graph, Id, Leaf, Node};
use crate::hash::Map;
use crate::jacobian::simplify;
use crate::poly::Expander;
use crate::rational::Q;

use super::parts::one_sign;
use super::{Problem, Target};

/// The places of coordinates that are together a unit vector: those of a direction, and the smallest sets of
/// coordinates of a manifold whose squares add up to one.
pub(super) fn units(problem: &mut Problem) -> Vec<Vec<u8>> {
    if problem.argument.is_some() {
        return vec![];
    }
    if problem.is_direction() {
        return vec![vec![0, 1, 2]];
    }
    let embedded = matches!(problem.parts[..], [part] if part.target == Target::Embedded);
    let n = problem.outputs.len();
    if !embedded || n > MOST {
        return vec![];
    }
    let mut sets: Vec<u32> = (0..1 << n).filter(|set: &u32| set.count_ones() > 1).collect();
    sets.sort_by_key(|set| set.count_ones());
    let mut found: Vec<u32> = vec![];
    for set in sets {
        if !found.iter().any(|smaller| set & smaller == *smaller) && is_unit(problem, set) {
            found.push(set);
        }
    }
    found.iter().map(|&set| members(set)).collect()
}

/// Of more coordinates there are too many sets.
const MOST: usize = 8;

fn members(set: u32) -> Vec<u8> {
    (0..MOST as u8).filter(|i| set >> i & 1 == 1).collect()
}

/// Whether the squares of these coordinates add up to one.
fn is_unit(problem: &mut Problem, set: u32) -> bool {
    let g = &mut problem.graph;
    let outputs = &problem.outputs;
    let squares: Vec<(Q, Id)> =
        members(set).iter().map(|&i| (Q::ONE, g.powi(outputs[usize::from(i)], 2))).collect();
    let sum = g.sum(Q::ZERO, &squares);
    let sum = simplify(g, sum, None);
    g.as_number(sum) == Some(Q::ONE)
}

/// An expression of a point with the squares of the others for one minus the square of a coordinate of a unit
/// vector, wherever something depends on this coordinate in no other way; `None` where nothing does.
pub(super) fn by_the_others(g: &mut Graph, written: Id, units: &[Vec<u8>]) -> Option<Id> {
    let mut id = written;
    for unit in units {
        let leaves: Vec<Id> = unit.iter().map(|&i| g.get_leaf(Leaf::Out(i))).collect();
        for &coordinate in &leaves {
            let others = leaves.iter().copied().filter(|&leaf| leaf != coordinate).collect();
            let mut replacing = Others { coordinate, others, memo: Map::default() };
            id = replacing.put_into(g, id);
        }
    }
    (id != written).then_some(id)
}

struct Others {
    coordinate: Id,
    others: Vec<Id>,
    memo: Map<Id, Id>,
}

impl Others {
    /// The expression without the coordinate, if it depends on nothing but one minus its square.
    fn without(&self, g: &mut Graph, id: Id) -> Option<Id> {
        let normal = Expander::new(g).unit_with(self.coordinate, &self.others).normal_form(id)?;
        let gone = !g.has(normal, g.deps(self.coordinate));
        (gone && !cancels(g, normal)).then_some(normal)
    }

    fn put_into(&mut self, g: &mut Graph, id: Id) -> Id {
        if id == self.coordinate || !g.has(id, g.deps(self.coordinate)) {
            return id;
        }
        if let Some(&known) = self.memo.get(&id) {
            return known;
        }
        let made = match g.node(id).clone() {
            Node::Sum(c, terms) => self.without(g, id).unwrap_or_else(|| {
                let terms: Vec<_> = terms.iter().map(|&(q, t)| (q, self.put_into(g, t))).collect();
                g.sum(c, &terms)
            }),
            Node::Product(factors) => self.in_product(g, factors),
            Node::Call(f, args) => {
                let args: Vec<Id> = args.into_iter().map(|a| self.put_into(g, a)).collect();
                g.call(f, &args)
            }
            _ => id,
        };
        self.memo.insert(id, made);
        made
    }

    /// Factors with the same exponent may depend on the square only together: (1 - x) (1 + x).
    fn in_product(&mut self, g: &mut Graph, factors: Vec<(Id, Id)>) -> Id {
        let mut groups: Vec<(Id, Vec<Id>)> = Vec::new();
        let mut product = g.int(1);
        for (base, exponent) in factors {
            if !g.has(base, g.deps(self.coordinate)) {
                let factor = g.pow(base, exponent);
                product = g.mul(product, factor);
            } else if let Some(group) = groups.iter_mut().find(|group| group.0 == exponent) {
                group.1.push(base);
            } else {
                groups.push((exponent, vec![base]));
            }
        }
        for (exponent, bases) in groups {
            let one = g.int(1);
            let together = bases.iter().fold(one, |product, &base| g.mul(product, base));
            let exponent = self.put_into(g, exponent);
            let bases = match self.without(g, together) {
                Some(short) => vec![short],
                None => bases.into_iter().map(|base| self.put_into(g, base)).collect(),
            };
            for base in bases {
                let factor = g.pow(base, exponent);
                product = g.mul(product, factor);
            }
        }
        product
    }
}

/// Whether something in a quotient of polynomials is a sum of terms of both signs.
fn cancels(g: &Graph, id: Id) -> bool {
    let both = |id: Id| matches!(g.node(id), Node::Sum(..)) && !one_sign(g, id);
    match g.node(id) {
        Node::Product(factors) => factors.iter().any(|&(base, _)| both(base)),
        _ => both(id),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn what_depends_on_one_minus_a_square_is_had_from_the_others() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let [x, y, z] =
            [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], signed));
        let [up, down] = [1, -1].map(|s| g.sum(Q::ONE, &[(Q::int(s), z)]));
        let [root, other] = [up, down].map(|side| g.sqrt(side));
        let length = g.mul(root, other);
        let quotient = g.div(x, length);
        let squares = [x, y].map(|c| (Q::ONE, g.powi(c, 2)));
        let sum = g.sum(Q::ZERO, &squares);
        let hypotenuse = g.sqrt(sum);
        let expected = g.div(x, hypotenuse);
        let units = [vec![0, 1, 2]];
        assert_eq!(by_the_others(&mut g, quotient, &units), Some(expected));
        assert_eq!(by_the_others(&mut g, expected, &units), None);
        // On its own, a factor stays.
        assert_eq!(by_the_others(&mut g, root, &units), None);
    }
}
