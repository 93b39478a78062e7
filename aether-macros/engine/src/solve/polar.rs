//! Polar pairs: A cos t and A sin t determine A and t together.

use std::collections::HashMap;

use super::{Equation, State};
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Node, UNKNOWNS};

/// Replaces two equations P = A cos t, Q = A sin t by A = √(P² + Q²) and t = atan2(Q, P) mod 2π.
pub(super) fn polar_pair(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let n = state.equations.len();
    for i in 0..n {
        for (angle, rest) in with_factor(g, state.equations[i].rhs, Fun::Cos) {
            for j in (0..n).filter(|j| *j != i) {
                let partner = with_factor(g, state.equations[j].rhs, Fun::Sin)
                    .into_iter()
                    .any(|p| p == (angle, rest));
                if partner && g.has(angle, UNKNOWNS) {
                    return Some(split(g, state, i, j, angle, rest));
                }
            }
        }
    }
    None
}

/// All ways to write an expression as f(angle) · rest.
pub(crate) fn with_factor(g: &mut Graph, id: Id, f: Fun) -> Vec<(Id, Id)> {
    let one = g.int(1);
    let factors = g.factors(id);
    let mut found = Vec::new();
    for (k, &(base, exp)) in factors.iter().enumerate() {
        let Node::Call(h, args) = g.node(base).clone() else { continue };
        if h == f && exp == one {
            let rest: Vec<_> =
                factors.iter().enumerate().filter(|(m, _)| *m != k).map(|(_, x)| *x).collect();
            found.push((args[0], g.product(&rest)));
        }
    }
    found
}

/// √(p² + q²), and p and q without the factors that they share and that are never negative: these change neither
/// the angle of the pair nor what there is to round in its root.
///
/// Lengths of one part in a million are nothing unusual, and the square of a polynomial of the third degree in
/// them is lost in single precision. So the factors stay, as what they were multiplied or divided by for, where
/// more than squares would be left.
pub(super) fn apart(g: &mut Graph, p: Id, q: Id) -> (Id, [Id; 2]) {
    let others = g.factors(q);
    let mut common = g.factors(p);
    common.retain(|factor| others.contains(factor));
    common.retain(|&(base, exponent)| {
        let power = g.pow(base, exponent);
        g.range(power).nonnegative()
    });
    let mut common = g.product(&common);
    let mut rest = [p, q].map(|id| g.div(id, common));
    let mut known = HashMap::new();
    if rest.iter().any(|id| degree(g, *id, &mut known).abs() > 2.0) {
        (common, rest) = (g.int(1), [p, q]);
    }
    let squares = rest.map(|id| g.powi(id, 2));
    let sum = g.add(squares[0], squares[1]);
    let root = g.sqrt(sum);
    (g.mul(common, root), rest)
}

/// The degree of an expression in all its inputs; functions of them count as numbers.
fn degree(g: &Graph, id: Id, known: &mut HashMap<Id, f64>) -> f64 {
    if let Some(&degree) = known.get(&id) {
        return degree;
    }
    let mut of = |id: Id| degree(g, id, known);
    let largest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
    let found = match g.node(id) {
        Node::Leaf(_) => 1.0,
        Node::Sum(_, terms) => terms.iter().map(|(_, t)| of(*t)).fold(0.0, largest),
        Node::Product(factors) => factors
            .iter()
            .map(|&(base, e)| g.as_number(e).map_or(0.0, |e| e.to_f64() * of(base)))
            .sum(),
        Node::If(_, a, b) => largest(of(*a), of(*b)),
        Node::Number(_) | Node::Float(_) | Node::Pi | Node::Call(..) | Node::Root(_) => 0.0,
    };
    known.insert(id, found);
    found
}

fn split(g: &mut Graph, state: &State, i: usize, j: usize, angle: Id, amplitude: Id) -> Vec<State> {
    let (p, q) = (state.equations[i].known, state.equations[j].known);
    let (radius, [along, across]) = apart(g, p, q);
    let range = g.range(amplitude);
    let mut signs = Vec::new();
    if !range.nonpositive() {
        signs.push(1);
    }
    if !range.nonnegative() {
        signs.push(-1);
    }
    signs
        .into_iter()
        .map(|sign| {
            let mut s = state.clone();
            let (y, x) = if sign > 0 { (across, along) } else { (g.neg(across), g.neg(along)) };
            let radius = if sign > 0 { radius } else { g.neg(radius) };
            let t = g.call(Fun::Atan2, &[y, x]);
            s.equations[i] = Equation { known: radius, rhs: amplitude, modulo_turn: false };
            s.equations[j] = Equation { known: t, rhs: angle, modulo_turn: true };
            // A known amplitude can be negative; then the angle turns by half a turn.
            if !g.has(amplitude, UNKNOWNS) && !range.nonnegative() && !range.nonpositive() {
                let sign = g.call(Fun::Sign, &[amplitude]);
                let (y, x) = (g.mul(sign, across), g.mul(sign, along));
                s.equations[j].known = g.call(Fun::Atan2, &[y, x]);
            }
            let cos = g.call(Fun::Cos, &[angle]);
            let sin = g.call(Fun::Sin, &[angle]);
            let c = g.div(p, radius);
            let n = g.div(q, radius);
            s.solution.known.entry(cos).or_insert(c);
            s.solution.known.entry(sin).or_insert(n);
            s.solution.known.entry(amplitude).or_insert(radius);
            s.solution.steps.push(format!(
                "polar pair: {} = {}, {} = {} (mod 2π)",
                show(g, amplitude),
                show(g, radius),
                show(g, angle),
                show(g, s.equations[j].known)
            ));
            s
        })
        .collect()
}
