//! Functions of one argument that are computed together: sines and cosines, exponentials and what they are more than one.

use std::collections::BTreeMap;

use crate::expr::{Fun, Graph, Id, Node, children};
use crate::hash::Set;

/// The sines and cosines of one angle in expressions, and exponentials before what they are more than one, outside of sides of
/// choices.
pub(super) fn pairs(g: &Graph, ids: &[Id]) -> Vec<[Id; 2]> {
    let (mut open, mut seen) = (ids.to_vec(), Set::default());
    let mut found: BTreeMap<(Id, u8), [Option<Id>; 2]> = BTreeMap::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        match g.node(id) {
            Node::If(test, ..) => open.push(*test),
            Node::Root(_) => {}
            node => open.extend(children(node)),
        }
        if let Node::Call(f, args) = g.node(id)
            && let Some((kind, place)) = place(*f)
        {
            found.entry((args[0], kind)).or_default()[place] = Some(id);
        }
    }
    found.into_values().filter_map(|[first, second]| Some([first?, second?])).collect()
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
}
