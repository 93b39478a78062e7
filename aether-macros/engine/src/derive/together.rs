//! Terms of sums that have a coordinate in common, added before they are multiplied by it: a x + b x + c as (a + b) x + c,
//! which takes a multiplication less and is rounded once less.

use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::measure::Measure;
use crate::rational::Q;

/// A density with the terms of its sums taken together by coordinates, unless that is measured to be less accurate. What the
/// form is made of is as much, so that its cost does not tell that it multiplies less.
pub(super) fn multiplied_once(g: &mut Graph, density: Id, measure: &mut Measure) -> Id {
    let shared = together(g, density);
    if shared == density {
        return density;
    }
    let mut worst = |form| measure.errors_of(g, form, density).loss().worst();
    if worst(shared) <= worst(density) { shared } else { density }
}

/// The expression with the terms of its sums taken together by the coordinates that they are multiplied by.
fn together(g: &mut Graph, id: Id) -> Id {
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let terms: Vec<_> = terms.iter().map(|&(q, t)| (q, together(g, t))).collect();
            let terms = by_coordinates(g, terms);
            g.sum(c, &terms)
        }
        Node::Product(factors) => {
            let factors: Vec<_> = factors.iter().map(|&(b, e)| (together(g, b), e)).collect();
            g.product(&factors)
        }
        Node::Call(Fun::Abs, args) => {
            let inner = together(g, args[0]);
            g.call(Fun::Abs, &[inner])
        }
        _ => id,
    }
}

/// Terms, of which those that have a coordinate in common are one; the coordinate of most of them comes first.
fn by_coordinates(g: &mut Graph, mut terms: Vec<(Q, Id)>) -> Vec<(Q, Id)> {
    while let Some(x) = most_common(g, &terms) {
        let (with, mut rest): (Vec<_>, Vec<_>) =
            terms.into_iter().partition(|(_, term)| coordinates(g, *term).contains(&x));
        let over: Vec<_> = with.into_iter().map(|(q, term)| (q, g.div(term, x))).collect();
        let over = by_coordinates(g, over);
        let sum = g.sum(Q::ZERO, &over);
        rest.push((Q::ONE, g.mul(x, sum)));
        terms = rest;
    }
    terms
}

/// The coordinate that several of these terms have as a factor, and no other more of them.
fn most_common(g: &Graph, terms: &[(Q, Id)]) -> Option<Id> {
    let all: Vec<Id> = terms.iter().flat_map(|(_, term)| coordinates(g, *term)).collect();
    let count = |x: &Id| all.iter().filter(|other| *other == x).count();
    all.iter().copied().filter(|x| count(x) > 1).max_by_key(|x| (count(x), *x))
}

/// The coordinates that a product of several factors has once as a factor.
fn coordinates(g: &Graph, term: Id) -> Vec<Id> {
    let Node::Product(factors) = g.node(term) else { return Vec::new() };
    let is_coordinate = |(b, e): &&(Id, Id)| {
        matches!(g.node(*b), Node::Leaf(Leaf::Out(_))) && g.as_number(*e) == Some(Q::ONE)
    };
    factors.iter().filter(is_coordinate).map(|(b, _)| *b).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn ends_of_an_interpolation_are_sums_that_are_multiplied_once() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        let w: Vec<Id> = (0..4).map(|i| g.leaf(Leaf::Param(i), "w", Interval::ALL)).collect();
        let one = g.int(1);
        let [s, t] = [x, y].map(|x| g.sub(one, x));
        let low = [(w[0], t), (w[1], y)].map(|(w, y)| (Q::ONE, g.mul(w, y)));
        let low = g.sum(Q::ZERO, &low);
        let low = g.mul(low, s);
        let high = [(w[2], t), (w[3], y)].map(|(w, y)| {
            let area = g.mul(x, y);
            (Q::ONE, g.mul(w, area))
        });
        let written = g.sum(Q::ZERO, &[(Q::ONE, low), high[0], high[1]]);
        let size = g.call(Fun::Abs, &[written]);
        let found = together(&mut g, size);
        let Node::Call(Fun::Abs, args) = g.node(found) else { panic!("a size") };
        assert!(matches!(g.node(args[0]), Node::Sum(_, terms) if terms.len() == 2));
        // What has nothing in common stays as it is.
        assert_eq!(together(&mut g, low), low);
    }
}
