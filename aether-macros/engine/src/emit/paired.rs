//! Functions of one argument that are computed together: sines and cosines, exponentials and what they are more than one.

use std::collections::BTreeMap;

use crate::expr::{Fun, Graph, Id, Node, children};
use crate::hash::Set;
use crate::rational::Q;

/// The sines and cosines of one angle in expressions, and exponentials before what they are more than one, outside of sides of
/// choices.
pub(super) fn pairs(g: &Graph, ids: &[Id]) -> Vec<[Id; 2]> {
    let (mut open, mut seen) = (ids.to_vec(), Set::default());
    let mut sides = Vec::new();
    let mut found: BTreeMap<(Id, u8), [Option<Id>; 2]> = BTreeMap::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match g.node(id) {
            Node::If(test, yes, no) => {
                open.push(*test);
                sides.extend([*yes, *no]);
            }
            Node::Root(_) => {}
            node => open.extend(children(node)),
        }
        if let Node::Call(f, args) = g.node(id)
            && let Some((kind, place)) = place(*f)
        {
            found.entry((args[0], kind)).or_default()[place] = Some(id);
        }
    }
    // Of e⁻ˣ - 1 and eˣ - 1 one is had from the other with e⁻ˣ, even if that is asked for on one side of a choice alone.
    for id in g.within(&sides) {
        let Node::Call(Fun::Exp, args) = g.node(id) else { continue };
        let less = |x: &Id| found.get(&(*x, 2)).is_some_and(|pair| pair[1].is_some());
        let grows = |x: &Id| g.range(*x).nonnegative() && are_opposite(g, *x, args[0]) && less(x);
        let growth: Vec<Id> = found.keys().map(|(x, _)| *x).filter(grows).collect();
        if less(&args[0]) && !growth.is_empty() {
            found.entry((args[0], 2)).or_default()[0] = Some(id);
        }
    }
    found.into_values().filter_map(|[first, second]| Some([first?, second?])).collect()
}

/// Whether one expression is the other with another sign, as they are written.
pub(super) fn are_opposite(g: &Graph, a: Id, b: Id) -> bool {
    let multiple = |id: Id| match g.node(id) {
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0],
        _ => (Q::ONE, id),
    };
    let ((p, a), (q, b)) = (multiple(a), multiple(b));
    (p, a) == (q.neg(), b)
}

/// What calls functions, in the order of who needs whom; a choice is one, not its sides.
pub(super) fn calls_in_order(g: &Graph, ids: &[Id]) -> Vec<Id> {
    let mut open: Vec<(Id, bool)> = ids.iter().rev().map(|id| (*id, false)).collect();
    let (mut seen, mut found) = (Set::default(), Vec::new());
    while let Some((id, ready)) = open.pop() {
        let node = g.node(id);
        let called = match node {
            Node::If(_, yes, no) => calls(g, *yes) || calls(g, *no),
            node => is_called(g, node),
        };
        if ready {
            found.extend(called.then_some(id));
        } else if seen.insert(id) {
            open.push((id, true));
            match node {
                Node::If(test, ..) => open.push((*test, false)),
                node => open.extend(children(node).into_iter().map(|child| (child, false))),
            }
        }
    }
    found
}

/// Whether an expression has a sine or a cosine in it.
pub(super) fn has_angle(g: &Graph, id: Id) -> bool {
    let is_angle = |f: &Fun| matches!(f, Fun::Sin | Fun::Cos | Fun::SinPi | Fun::CosPi);
    g.within(&[id]).iter().any(|id| matches!(g.node(*id), Node::Call(f, _) if is_angle(f)))
}

/// Whether functions other than roots are called for the value of an expression.
pub(super) fn calls(g: &Graph, id: Id) -> bool {
    g.within(&[id]).iter().any(|id| is_called(g, g.node(*id)))
}

/// Whether functions other than roots are called for a node itself.
fn is_called(g: &Graph, node: &Node) -> bool {
    let power = |e: &Id| g.as_number(*e).is_none_or(|q| q.den() > 2);
    match node {
        Node::Call(f, _) => !matches!(f, Fun::Abs | Fun::Sign),
        Node::Product(factors) => factors.iter().any(|(_, exponent)| power(exponent)),
        node => matches!(node, Node::Root(_)),
    }
}

/// Which kind of pair a function is of, and whether it is the second one.
fn place(f: Fun) -> Option<(u8, usize)> {
    Some(match f {
        Fun::Sin => (0, 0),
        Fun::Cos => (0, 1),
        Fun::SinPi => (1, 0),
        Fun::CosPi => (1, 1),
        Fun::Exp => (2, 0),
        Fun::ExpM1 => (2, 1),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn both_functions_of_an_argument_are_a_pair() {
        let mut g = Graph::new();
        let [u, v] =
            [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)));
        let (sine, cosine) = (g.call(Fun::Sin, &[u]), g.call(Fun::Cos, &[u]));
        let alone = g.call(Fun::Sin, &[v]);
        let product = g.mul(cosine, alone);
        assert_eq!(pairs(&g, &[product, sine]), [[sine, cosine]]);
        assert!(pairs(&g, &[product]).is_empty());
        // Those of π times a number are another pair.
        let [sine_pi, cosine_pi] = [Fun::SinPi, Fun::CosPi].map(|f| g.call(f, &[u]));
        assert_eq!(pairs(&g, &[sine_pi, cosine_pi, sine]), [[sine_pi, cosine_pi]]);
        let [exp, less] = [Fun::Exp, Fun::ExpM1].map(|f| g.call(f, &[v]));
        assert_eq!(pairs(&g, &[less, sine, exp]), [[exp, less]]);
        // What is computed only on one side is not computed in advance.
        let minus = g.int(-1);
        let test = g.sum(crate::rational::Q::HALF, &[(crate::rational::Q::int(-1), v)]);
        let either = g.if_positive(test, sine, minus);
        assert!(pairs(&g, &[cosine, either]).is_empty());
    }

    #[test]
    fn an_exponential_on_one_side_tells_growth_by_decay() {
        let mut g = Graph::new();
        let k = g.leaf(Leaf::Param(0), "k", Interval::POSITIVE);
        let minus = g.neg(k);
        let [growth, decay] = [k, minus].map(|x| g.call(Fun::ExpM1, &[x]));
        let (whole, test) = (g.call(Fun::Exp, &[minus]), g.sub(k, decay));
        let rest = g.sub(test, growth);
        let choice = g.if_positive(rest, whole, k);
        assert_eq!(pairs(&g, &[choice]), [[whole, decay]]);
        // Without growth it is asked for where it is needed.
        let other = g.if_positive(decay, whole, k);
        assert!(pairs(&g, &[other, decay]).is_empty());
    }

    #[test]
    fn calls_come_in_the_order_of_who_needs_whom() {
        let mut g = Graph::new();
        let [u, v] =
            [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)));
        let log = g.call(Fun::Ln1p, &[u]);
        let power = g.call(Fun::Erf, &[log]);
        let (root, sine) = (g.sqrt(v), g.call(Fun::SinPi, &[v]));
        let product = g.mul(power, sine);
        let whole = g.mul(product, root);
        let test = g.sub(u, v);
        let choice = g.if_positive(test, log, root);
        let found = calls_in_order(&g, &[choice, whole]);
        let [of_choice, of_log, of_power, of_sine] =
            [choice, log, power, sine].map(|id| found.iter().position(|other| *other == id));
        assert_eq!((found.len(), of_choice), (4, Some(0)));
        assert!(of_log.is_some() && of_log < of_power && of_sine.is_some());
        assert!(has_angle(&g, whole) && !has_angle(&g, power));
    }
}
