//! Expressions that may have another value at zero of an unknown than next to it.

use crate::expr::{Fun, Graph, Id, Leaf, Node, children, leaf_bit};
use crate::hash::Set;

/// Whether an expression may have a value at zero of an unknown that is not its limit. Sums, products with powers, and
/// continuous functions have their limit there, or they are infinite or undetermined, which shows.
pub(super) fn jumps(g: &Graph, id: Id, unknown: Leaf) -> bool {
    let bit = leaf_bit(unknown);
    let (mut open, mut seen) = (vec![id], Set::default());
    while let Some(id) = open.pop() {
        if !g.has(id, bit) || !seen.insert(id) {
            continue;
        }
        let continuous = match g.node(id) {
            Node::Product(factors) => !factors.iter().any(|&(_, exponent)| g.has(exponent, bit)),
            Node::Call(f, _) => is_continuous(*f),
            Node::If(..) | Node::Root(_) => false,
            _ => true,
        };
        if !continuous {
            return true;
        }
        open.extend(children(g.node(id)));
    }
    false
}

/// Whether a function that has a value has it also as its limit, from either side.
fn is_continuous(f: Fun) -> bool {
    use Fun::*;
    matches!(f, Sin | Cos | SinPi | CosPi | Abs | Exp | ExpM1 | Ln | Ln1p | Cbrt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn angles_and_powers_with_variable_exponents_may_jump() {
        let mut g = Graph::new();
        let [u, v] =
            [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::new(0.0, 1.0)));
        let root = g.sqrt(u);
        let (inverse, power) = (g.powi(root, -1), g.pow(u, v));
        let angle = g.call(Fun::Atan2, &[u, v]);
        let product = g.mul(inverse, angle);
        let [first, second] = [0, 1].map(Leaf::Unknown);
        assert!(!jumps(&g, inverse, first) && !jumps(&g, power, first) && jumps(&g, power, second));
        assert!(jumps(&g, product, first) && !jumps(&g, inverse, second));
    }
}
