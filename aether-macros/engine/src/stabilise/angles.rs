//! Angles that are told by their tangent, and others that are added to them: next to a quarter turn, and where two
//! nearly equal ones are subtracted, an angle has fewer digits than its tangent.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// The sine and cosine of an arc tangent, up to a positive factor; its cosine is positive where `forwards` is asked for.
fn sides(g: &mut Graph, arc: Id, forwards: bool) -> Option<(Id, Id)> {
    match *g.node(arc) {
        Node::Call(Fun::Atan, ref args) => {
            let y = args[0];
            Some((y, g.int(1)))
        }
        Node::Call(Fun::Atan2, ref args) => {
            let (y, x) = (args[0], args[1]);
            (!forwards || g.range(x).lo > 0.0).then_some((y, x))
        }
        _ => None,
    }
}

/// The sine, cosine or tangent of a sum, one term of which is an arc tangent, by what that one is made of.
pub(super) fn of_sum(g: &mut Graph, f: Fun, sum: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(sum).clone() else { return None };
    let is_arc = |g: &mut Graph, q: Q, t: Id| q.abs() == Q::ONE && sides(g, t, false).is_some();
    let place = (0..terms.len()).find(|&i| is_arc(g, terms[i].0, terms[i].1))?;
    let (sign, arc) = terms[place];
    let (y, x) = sides(g, arc, false)?;
    let y = g.sum(Q::ZERO, &[(sign, y)]);
    let mut others = terms;
    others.remove(place);
    let rest = g.sum(c, &others);
    if g.as_number(rest).is_some() {
        return None;
    }
    let turned = |g: &mut Graph, (p, q): (Id, Id), (r, s): (Id, Id), minus: bool| {
        let (a, b) = (g.mul(p, q), g.mul(r, s));
        if minus { g.sub(a, b) } else { g.add(a, b) }
    };
    if f == Fun::Tan {
        let (one, t) = (g.int(1), g.call(Fun::Tan, &[rest]));
        let top = turned(g, (y, one), (x, t), false);
        let bottom = turned(g, (x, one), (y, t), true);
        return Some(g.div(top, bottom));
    }
    let (sine, cosine) = (g.call(Fun::Sin, &[rest]), g.call(Fun::Cos, &[rest]));
    let top = match f {
        Fun::Sin => turned(g, (y, cosine), (x, sine), false),
        Fun::Cos => turned(g, (x, cosine), (y, sine), true),
        _ => return None,
    };
    let squares = turned(g, (x, x), (y, y), false);
    let length = g.sqrt(squares);
    Some(g.div(top, length))
}

/// The difference of two arc tangents within a quarter turn of zero as one.
pub(super) fn difference(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(p, a), (q, b)] = *terms else { return None };
    if !c.is_zero() || p != q.neg() {
        return None;
    }
    let (y, x) = sides(g, a, true)?;
    let (v, w) = sides(g, b, true)?;
    let (yw, xv) = (g.mul(y, w), g.mul(x, v));
    let (xw, yv) = (g.mul(x, w), g.mul(y, v));
    let (sine, cosine) = (g.sub(yw, xv), g.add(xw, yv));
    let arc = g.call(Fun::Atan2, &[sine, cosine]);
    Some(g.sum(Q::ZERO, &[(p, arc)]))
}
