//! Sines and cosines that are computed together.

use std::collections::BTreeMap;

use crate::expr::{Fun, Graph, Id, Node, children};
use crate::hash::Set;

/// The sines and cosines of one angle in expressions, outside of sides of choices.
pub(super) fn circular_pairs(g: &Graph, ids: &[Id]) -> Vec<[Id; 2]> {
    let (mut open, mut seen) = (ids.to_vec(), Set::default());
    let mut found: BTreeMap<(Id, bool), [Option<Id>; 2]> = BTreeMap::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match g.node(id) {
            Node::If(test, ..) => open.push(*test),
            Node::Root(_) => {}
            node => open.extend(children(node)),
        }
        if let Node::Call(f @ (Fun::Sin | Fun::Cos | Fun::SinPi | Fun::CosPi), args) = g.node(id) {
            let turned = matches!(f, Fun::SinPi | Fun::CosPi);
            let cosine = matches!(f, Fun::Cos | Fun::CosPi);
            found.entry((args[0], turned)).or_default()[usize::from(cosine)] = Some(id);
        }
    }
    found.into_values().filter_map(|[sine, cosine]| Some([sine?, cosine?])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn both_functions_of_an_angle_are_a_pair() {
        let mut g = Graph::new();
        let [u, v] =
            [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)));
        let (sine, cosine) = (g.call(Fun::Sin, &[u]), g.call(Fun::Cos, &[u]));
        let alone = g.call(Fun::Sin, &[v]);
        let product = g.mul(cosine, alone);
        assert_eq!(circular_pairs(&g, &[product, sine]), [[sine, cosine]]);
        assert!(circular_pairs(&g, &[product]).is_empty());
        // Those of π times a number are another pair.
        let [sine_pi, cosine_pi] = [Fun::SinPi, Fun::CosPi].map(|f| g.call(f, &[u]));
        assert_eq!(circular_pairs(&g, &[sine_pi, cosine_pi, sine]), [[sine_pi, cosine_pi]]);
        // What is computed only on one side is not computed in advance.
        let minus = g.int(-1);
        let test = g.sum(crate::rational::Q::HALF, &[(crate::rational::Q::int(-1), v)]);
        let either = g.if_positive(test, sine, minus);
        assert!(circular_pairs(&g, &[cosine, either]).is_empty());
    }
}
