//! Angles by how far they are from a pole or from whole turns.

use crate::expr::{Deps, Fun, Graph, Id, Node, UNKNOWNS};
use crate::rational::Q;

/// Of three coordinates the two that have more unknowns than the third.
pub(super) fn around_a_pole(g: &Graph, coordinates: &[Id]) -> Option<[usize; 2]> {
    let [x, y, z] = *coordinates else { return None };
    let [x, y, z] = [x, y, z].map(|c| g.deps(c) & UNKNOWNS);
    let fewer = |a: Deps, b: Deps, c: Deps| b == c && a != b && a & b == a;
    if fewer(z, x, y) {
        Some([0, 1])
    } else if fewer(x, y, z) {
        Some([1, 2])
    } else {
        fewer(y, z, x).then_some([0, 2])
    }
}

/// A product with sines and cosines of fractions of a turn for those of the angle.
pub(super) fn by_turns(g: &mut Graph, id: Id) -> Id {
    let (q, body) = g.split(id);
    let factors = g.factors(body);
    let turned =
        factors.into_iter().map(|(b, e)| (of_turn(g, b).unwrap_or(b), e)).collect::<Vec<_>>();
    let body = g.product(&turned);
    g.sum(Q::ZERO, &[(q, body)])
}

/// The sine, cosine or tangent of a fraction of a turn.
pub(crate) fn of_turn(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Call(f @ (Fun::Sin | Fun::Cos | Fun::Tan), args) = g.node(id).clone() else {
        return None;
    };
    let pi = g.pi();
    let fraction = g.div(args[0], pi);
    if crate::expr::children(g.node(fraction)).contains(&pi) {
        return None;
    }
    let of_turn = match f {
        Fun::Sin => Fun::SinPi,
        Fun::Cos => Fun::CosPi,
        _ => {
            let (s, c) = (g.call(Fun::SinPi, &[fraction]), g.call(Fun::CosPi, &[fraction]));
            return Some(g.div(s, c));
        }
    };
    Some(g.call(of_turn, &[fraction]))
}
