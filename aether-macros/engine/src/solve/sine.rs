//! One equation α cos t + β sin t = γ for an angle t: the two angles around that of (α, β).

use super::rational::clear;
use super::{Equation, State};
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};
use crate::poly::Poly;
use crate::rational::Q;

/// Solves an equation that is linear in the sine and cosine of one angle, once it has no denominators.
pub(super) fn single_angle(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for (i, eq) in state.equations.iter().enumerate() {
        let single = (g.deps(eq.rhs) & UNKNOWNS).count_ones() == 1;
        if eq.modulo_turn || !single {
            continue;
        }
        let Some(polynomial) = clear(g, eq.known, eq.rhs, UNKNOWNS) else { continue };
        let Some((angle, [alpha, beta, gamma])) = linear(g, &polynomial) else { continue };
        let (a2, b2) = (g.powi(alpha, 2), g.powi(beta, 2));
        let sum = g.add(a2, b2);
        let radius = g.sqrt(sum);
        let ratio = g.div(gamma, radius);
        let apart = g.call(Fun::Acos, &[ratio]);
        let middle = g.call(Fun::Atan2, &[beta, alpha]);
        let next = [1, -1].into_iter().map(|sign| {
            let known = g.sum(Q::ZERO, &[(Q::ONE, middle), (Q::int(sign), apart)]);
            let mut s = state.clone();
            s.equations[i] = Equation { known, rhs: angle, modulo_turn: true };
            let (angle, known) = (show(g, angle), show(g, known));
            s.solution.steps.push(format!("sine and cosine: {angle} = {known} (mod 2π)"));
            s
        });
        return Some(next.collect());
    }
    None
}

/// The angle and α, β, γ of α cos t + β sin t - γ.
fn linear(g: &mut Graph, p: &Poly) -> Option<(Id, [Id; 3])> {
    let open: Vec<Id> = p.atoms().into_iter().filter(|a| g.has(*a, UNKNOWNS)).collect();
    let &[first, second] = &open[..] else { return None };
    let argument = |g: &Graph, id: Id, f: Fun| match g.node(id) {
        Node::Call(h, args) if *h == f => Some(args[0]),
        _ => None,
    };
    let (cos, sin) =
        if argument(g, first, Fun::Cos).is_some() { (first, second) } else { (second, first) };
    let angle = argument(g, cos, Fun::Cos)?;
    if argument(g, sin, Fun::Sin)? != angle {
        return None;
    }
    let in_cos = p.by_powers_of(cos)?;
    let [rest, alpha] = &in_cos[..] else { return None };
    let in_sin = rest.by_powers_of(sin)?;
    let [constant, beta] = &in_sin[..] else { return None };
    let [alpha, beta, constant] = [alpha, beta, constant].map(|c| c.to_expr(g));
    let gamma = g.neg(constant);
    let known = [alpha, beta, gamma].iter().all(|c| !g.has(*c, UNKNOWNS));
    known.then_some((angle, [alpha, beta, gamma]))
}
