//! A density at its uniforms by the roots that the sample takes of them: where s is √(a² + u (b² - a²)), u (b² - a²) is
//! s² - a², which may have a factor in common with what it stands over.

use std::collections::BTreeMap;

use crate::derivative::derivative;
use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS, children, leaf_bit};
use crate::hash::{Map, Set};
use crate::interval::Interval;
use crate::jacobian::{cost, simplify};
use crate::rational::Q;

/// The root of something that is linear in an unknown.
struct Root {
    /// The root.
    root: Id,
    /// The unknown.
    unknown: Leaf,
    /// A name for the root.
    name: Id,
    /// The root where the unknown is zero and a name for it, if it has been written as a square.
    start: Option<(Id, Id)>,
    /// The unknown by these names.
    value: Id,
}

/// An expression whose sums have roots of an unknown for the unknown, where they are shorter by it.
pub(super) fn by_its_roots(g: &mut Graph, written: Id) -> Id {
    let mut id = written;
    for root in roots(g, written) {
        id = in_sums(g, id, &root, &mut Map::default());
    }
    id
}

/// The names of a root and of its start: no unknowns of a map, nor such that stand for coordinates.
const NAMES: [Leaf; 2] = [Leaf::Unknown(23), Leaf::Unknown(22)];

fn roots(g: &mut Graph, written: Id) -> Vec<Root> {
    let (mut open, mut found) = (vec![written], vec![]);
    let (mut seen, mut bases) = (Set::default(), Set::default());
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        open.extend(children(g.node(id)));
        let Node::Product(factors) = g.node(id).clone() else { continue };
        for (base, exponent) in factors {
            let is_root = g.as_number(exponent).is_some_and(|q| q.den() == 2);
            if is_root && g.has(base, UNKNOWNS) && bases.insert(base) {
                found.extend(root_of(g, base));
            }
        }
    }
    found
}

/// The root of `base`, if this is linear in an unknown.
fn root_of(g: &mut Graph, base: Id) -> Option<Root> {
    let unknowns = (0..22).map(Leaf::Unknown).filter(|&u| g.has(base, leaf_bit(u)));
    let unknowns: Vec<Leaf> = unknowns.collect();
    unknowns.into_iter().find_map(|unknown| {
        let slope = derivative(g, base, unknown);
        let (leaf, zero) = (g.get_leaf(unknown), g.int(0));
        if g.has(slope, leaf_bit(unknown)) {
            return None;
        }
        let square = g.substitute(base, &BTreeMap::from([(leaf, zero)]));
        let [name, start] = [(NAMES[0], Interval::POSITIVE), (NAMES[1], Interval::ALL)]
            .map(|(leaf, range)| g.leaf(leaf, "root", range));
        let start = match g.node(square) {
            Node::Product(factors) => match factors[..] {
                [(root, two)] if g.as_number(two) == Some(Q::int(2)) => Some((root, start)),
                _ => None,
            },
            _ => None,
        };
        let root = g.sqrt(base);
        let squared = g.powi(name, 2);
        let value = g.sub(squared, square);
        let value = g.div(value, slope);
        let value = start.map_or(value, |(root, name)| g.replace_part(value, root, name));
        Some(Root { root, unknown, name, start, value })
    })
}

fn in_sums(g: &mut Graph, id: Id, root: &Root, memo: &mut Map<Id, Id>) -> Id {
    // What does not depend on the unknown has no root of it.
    if !g.has(id, leaf_bit(root.unknown)) || id == root.root {
        return id;
    }
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let made = match g.node(id).clone() {
        Node::Sum(c, terms) => by_the_root(g, id, root).unwrap_or_else(|| {
            let terms: Vec<_> =
                terms.into_iter().map(|(q, t)| (q, in_sums(g, t, root, memo))).collect();
            g.sum(c, &terms)
        }),
        Node::Product(factors) => {
            let factors: Vec<_> =
                factors.into_iter().map(|(b, e)| (in_sums(g, b, root, memo), e)).collect();
            g.product(&factors)
        }
        Node::Call(f, args) => {
            let args: Vec<Id> = args.into_iter().map(|a| in_sums(g, a, root, memo)).collect();
            g.call(f, &args)
        }
        _ => id,
    };
    memo.insert(id, made);
    made
}

/// A sum with the root for the unknown, if it has both and is shorter so.
fn by_the_root(g: &mut Graph, sum: Id, root: &Root) -> Option<Id> {
    let named = g.replace_powers(sum, root.root, root.name);
    if named == sum || !g.has(named, leaf_bit(root.unknown)) {
        return None;
    }
    let named = root.start.map_or(named, |(start, name)| g.replace_part(named, start, name));
    let leaf = g.get_leaf(root.unknown);
    let told = g.substitute(named, &BTreeMap::from([(leaf, root.value)]));
    let short = simplify(g, told, None);
    let mut names = BTreeMap::from([(root.name, root.root)]);
    names.extend(root.start.map(|(start, name)| (name, start)));
    let short = g.substitute(short, &names);
    (cost(g, short) < cost(g, sum)).then_some(short)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_linear_density_is_its_root() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), "p", Interval::POSITIVE));
        let [aa, bb] = [a, b].map(|x| g.powi(x, 2));
        let more = g.sub(bb, aa);
        let part = g.mul(u, more);
        let base = g.add(aa, part);
        let root = g.sqrt(base);
        // The derivative of u / (a + s), times a + s, is (a + s) / (2 s).
        let below = g.add(a, root);
        let twice = g.mul(root, below);
        let quotient = g.div(part, twice);
        let written = g.sum(Q::ONE, &[(Q::HALF.neg(), quotient)]);
        let over = g.div(below, root);
        let expected = g.sum(Q::ZERO, &[(Q::HALF, over)]);
        let found = by_its_roots(&mut g, written);
        let short = simplify(&mut g, found, None);
        assert!(found == expected || short == simplify(&mut g, expected, None));
        // Without the root there is nothing to tell.
        assert_eq!(by_its_roots(&mut g, part), part);
    }
}
