//! Expressions without functions of twice or half an angle that is told by one of its functions. The solver has its own use for
//! such angles, as pairs of a cosine and a sine; of densities and samples these are forms.

use super::factored::factored;
use crate::expr::{Graph, Id, Node};
use crate::hash::Map;
use crate::jacobian::simplify;
use crate::multiples::of_multiple;

/// An expression without functions of twice or half an angle that is told by a function; `None` if it has none.
pub(super) fn opened(g: &mut Graph, id: Id) -> Option<Id> {
    let form = rebuilt(g, id, &mut Map::default());
    (form != id).then(|| factored(g, &[form])[0])
}

fn rebuilt(g: &mut Graph, id: Id, memo: &mut Map<Id, Id>) -> Id {
    if let Some(&known) = memo.get(&id) {
        return known;
    }
    let made = match g.node(id).clone() {
        Node::Sum(c, terms) => {
            let open: Vec<_> = terms.iter().map(|&(q, t)| (q, rebuilt(g, t, memo))).collect();
            let sum = g.sum(c, &open);
            // What has become a quotient takes the rest of the sum above its line.
            if open == terms { sum } else { simplify(g, sum, None) }
        }
        Node::Product(factors) => {
            let factors: Vec<_> = factors.iter().map(|&(b, e)| (rebuilt(g, b, memo), e)).collect();
            g.product(&factors)
        }
        Node::Call(f, args) => {
            let args: Vec<_> = args.iter().map(|&a| rebuilt(g, a, memo)).collect();
            let by_its_functions = if let [x] = args[..] { of_multiple(g, f, x) } else { None };
            by_its_functions.unwrap_or_else(|| g.call(f, &args))
        }
        _ => id,
    };
    memo.insert(id, made);
    made
}
