//! Products of sines and cosines of one angle as those of twice the angle.

use super::State;
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS, children};
use crate::poly::Expander;
use crate::rational::Q;

/// Rewrites the equations in an angle t whose sine and cosine occur only in products of two:
/// cos² t = (1 + cos 2t) / 2, sin² t = (1 - cos 2t) / 2, sin t cos t = sin(2t) / 2.
pub(super) fn double(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let mut angles = Vec::new();
    for e in &state.equations {
        sines(g, e.rhs, &mut angles);
    }
    for angle in angles {
        let mut s = state.clone();
        for e in &mut s.equations {
            if g.has(e.rhs, UNKNOWNS) {
                e.rhs = doubled(g, e.rhs, angle)?;
            }
        }
        if s.equations.iter().zip(&state.equations).any(|(a, b)| a.rhs != b.rhs) {
            s.solution.steps.push(format!("in terms of twice {}", show(g, angle)));
            return Some(vec![s]);
        }
    }
    None
}

/// The angles whose sine or cosine occurs.
fn sines(g: &Graph, id: Id, found: &mut Vec<Id>) {
    if let Node::Call(Fun::Sin | Fun::Cos, args) = g.node(id)
        && g.has(id, UNKNOWNS)
        && !found.contains(&args[0])
    {
        found.push(args[0]);
    }
    for part in children(g.node(id)) {
        sines(g, part, found);
    }
}

/// The expression without cos t and sin t; `None` if they occur in other powers.
fn doubled(g: &mut Graph, id: Id, angle: Id) -> Option<Id> {
    let [cos, sin] = [Fun::Cos, Fun::Sin].map(|f| g.call(f, &[angle]));
    let r = Expander::new(g).expand(id)?;
    if !r.den.is_empty() {
        return None;
    }
    let twice = g.sum(Q::ZERO, &[(Q::int(2), angle)]);
    let [cos2, sin2] = [Fun::Cos, Fun::Sin].map(|f| g.call(f, &[twice]));
    let mut terms = Vec::new();
    for (q, term) in r.num.terms(g) {
        let power = |f: Id, g: &mut Graph| {
            let factors = g.factors(term);
            factors
                .iter()
                .find(|(b, _)| *b == f)
                .map_or(Some(0), |(_, e)| g.as_number(*e)?.to_i32())
        };
        let (m, n) = (power(cos, g)?, power(sin, g)?);
        let rest: Vec<(Id, Id)> =
            g.factors(term).into_iter().filter(|(b, _)| *b != cos && *b != sin).collect();
        let rest = g.product(&rest);
        let half = q.mul(Q::HALF)?;
        match (m, n) {
            (0, 0) => terms.push((q, rest)),
            (2, 0) | (0, 2) => {
                let turning = g.mul(rest, cos2);
                terms.push((half, rest));
                terms.push((if m == 2 { half } else { half.neg() }, turning));
            }
            (1, 1) => {
                let turning = g.mul(rest, sin2);
                terms.push((half, turning));
            }
            _ => return None,
        }
    }
    let sum = g.sum(Q::ZERO, &terms);
    // What is left of the angle may be in the rests.
    let mut left = Vec::new();
    sines(g, sum, &mut left);
    (!left.contains(&angle)).then_some(sum)
}
