//! Undoing the outermost function of an equation.

mod joint;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::{Condition, Equation, Numerical, State};
use crate::expr::{Fun, Graph, Id, Leaf, Node, UNKNOWNS};
use crate::interval::Interval;
use crate::jacobian::cost;
use crate::monotone::{inputs_of, sign_at};
use crate::rational::Q;
use crate::sorted;
use joint::{
    join_logarithms, lambert, ratio_of_sine_and_cosine, undo_atan2, undo_cotangent, undo_lambert,
    undo_powers,
};

/// One way to undo a function: the new known side, and tests that it must pass.
pub(super) struct Inverse {
    pub(super) known: Id,
    conditions: Vec<Condition>,
}

/// Undoes the outermost function of some equation, if that has a single answer.
pub(super) fn unique(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    peel(g, state, 1)
}

/// Undoes the outermost function of some equation, with as many branches as it has answers.
pub(super) fn branching(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    peel(g, state, 16)
}

fn peel(g: &mut Graph, state: &State, most: usize) -> Option<Vec<State>> {
    // Prefer equations in a single unknown, and among several for one unknown the simplest.
    let mut order: Vec<usize> = (0..state.equations.len()).collect();
    sorted::sort_by_key(&mut order, |&i| {
        let rhs = state.equations[i].rhs;
        ((g.deps(rhs) & UNKNOWNS).count_ones(), cost(g, rhs), cost(g, state.equations[i].known))
    });
    for i in order {
        let eq = state.equations[i].clone();
        let Some((argument, inverses)) = undo(g, &eq, state.numerical > Numerical::No) else {
            continue;
        };
        if inverses.len() > most {
            continue;
        }
        let next = inverses.into_iter().map(|inverse| {
            let mut s = state.clone();
            if !eq.modulo_turn && matches!(g.node(eq.rhs), Node::Call(..)) {
                // What the function comes to is as good to know as what its argument is. Not so for
                // powers: x^k / x for x^(k - 1) would be 0/0 at zero.
                s.solution.known.entry(eq.rhs).or_insert(eq.known);
            }
            s.equations[i].known = inverse.known;
            s.equations[i].rhs = argument;
            s.equations[i].modulo_turn = false;
            for c in inverse.conditions {
                if !g.range(c.0).nonnegative() && !s.solution.conditions.contains(&c) {
                    s.solution.conditions.push(c);
                }
            }
            s.solution.known.entry(argument).or_insert(inverse.known);
            s
        });
        return Some(next.collect());
    }
    None
}

/// All solutions y of known = f(y), where rhs = f(y) and y is the only part with unknowns.
fn undo(g: &mut Graph, eq: &Equation, numerical: bool) -> Option<(Id, Vec<Inverse>)> {
    let (known, rhs, modulo_turn) = (eq.known, eq.rhs, eq.modulo_turn);
    if modulo_turn {
        return unwind_turns(g, known, rhs);
    }
    match g.node(rhs).clone() {
        Node::Product(f) if f.len() == 1 => {
            let (base, exp) = f[0];
            if let Some(answer) = undo_cotangent(g, known, base, exp) {
                return Some(answer);
            }
            match (g.has(base, UNKNOWNS), g.has(exp, UNKNOWNS)) {
                (true, false) => Some((base, undo_power(g, known, base, exp))),
                (false, true) => {
                    let top = g.call(Fun::Ln, &[known]);
                    let bottom = g.call(Fun::Ln, &[base]);
                    let known = g.div(top, bottom);
                    Some((exp, vec![Inverse { known, conditions: vec![] }]))
                }
                _ => None,
            }
        }
        Node::Product(f) if ratio_of_sine_and_cosine(g, &f).is_some() => {
            let (top, angle) = ratio_of_sine_and_cosine(g, &f)?;
            let tangent = g.call(Fun::Tan, &[angle]);
            let e = g.int(if top == Fun::Sin { 1 } else { -1 });
            let rhs = g.pow(tangent, e);
            undo(g, &Equation { known, rhs, modulo_turn: false }, numerical)
        }
        Node::Product(f) if f.iter().all(|(b, _)| !g.has(*b, UNKNOWNS)) => {
            undo_powers(g, known, &f)
        }
        Node::Sum(c, terms) if c.is_zero() => join_logarithms(g, known, &terms),
        // Lambert's function of a power overflows where a root can still be found.
        Node::Product(f) if !numerical && lambert(g, &f).is_some() => undo_lambert(g, known, &f),
        Node::Product(f) if f.iter().all(|(_, e)| g.as_number(*e).is_some_and(Q::is_even)) => {
            let half = g.number(Q::HALF);
            let halved: Vec<(Id, Id)> = f.iter().map(|&(b, e)| (b, g.mul(e, half))).collect();
            let (base, two) = (g.product(&halved), g.int(2));
            Some((base, undo_power(g, known, base, two)))
        }
        Node::Product(f) => {
            // √(a/b) is kept as √a/√b: square both sides.
            let halves = f.iter().all(|(b, e)| {
                g.as_number(*e).is_some_and(|q| q.den() == 2) && g.range(*b).nonnegative()
            });
            if !halves {
                return undo_common_power(g, known, &f);
            }
            let squared = g.powi(rhs, 2);
            let inverse = Inverse { known: g.powi(known, 2), conditions: vec![Condition(known)] };
            Some((squared, vec![inverse]))
        }
        Node::Call(Fun::Atan2, args) => undo_atan2(g, known, args[0], args[1]),
        Node::Call(f @ (Fun::BetaInc | Fun::BetaIncInv), args) => {
            let back = if f == Fun::BetaInc { Fun::BetaIncInv } else { Fun::BetaInc };
            let known = g.call(back, &[known, args[1], args[2]]);
            Some((args[0], vec![Inverse { known, conditions: vec![] }]))
        }
        Node::Call(f, args) if args.len() == 1 => Some((args[0], undo_call(g, f, known, args[0])?)),
        _ => None,
    }
}

/// An angle that is known up to whole turns, brought into the range that its expression can have. That is a window
/// which is cut open in the middle of its complement, where no rounding error leads.
pub(super) fn unwind_turns(g: &mut Graph, known: Id, rhs: Id) -> Option<(Id, Vec<Inverse>)> {
    let range = g.range(rhs);
    let single = |known| vec![Inverse { known, conditions: vec![] }];
    if range.lo >= -PI && range.hi <= PI + 1e-12 {
        return Some((rhs, single(known)));
    }
    // Where the window is a parameter, it is cut open opposite to its own middle: factor · rest with rest in [0, 1] and a
    // factor of known sign.
    let (constant, factor, rest) = super::affine_parts(g, rhs);
    let (f, r) = (g.range(factor), g.range(rest));
    let from_zero = constant.is_none() && r.nonnegative() && f.nonnegative();
    if from_zero && g.as_number(factor).is_none() && r.hi * f.hi <= TAU + 1e-9 {
        let half = g.float(0.5 * r.hi);
        let middle = g.mul(half, factor);
        let turned = g.call(Fun::TurnTo, &[known, middle]);
        return Some((rhs, single(turned)));
    }
    if range.width().is_finite() && range.width() <= 64.0 * TAU {
        let middle = range.lo + 0.5 * range.width().min(TAU);
        let base = if (middle - PI).abs() < 1e-12 {
            g.call(Fun::Turn, &[known])
        } else {
            let middle = g.float(middle);
            g.call(Fun::TurnTo, &[known, middle])
        };
        let turns = ((range.width() / TAU) - 1e-12).ceil().max(1.0) as i64;
        let pi = g.pi();
        let inverses = (0..turns).map(|k| {
            let turn = g.sum(Q::ZERO, &[(Q::int(2 * k), pi)]);
            Inverse { known: g.add(base, turn), conditions: vec![] }
        });
        return Some((rhs, inverses.collect()));
    }
    if is_seen_within_half_a_turn(g, rhs) {
        return Some((rhs, single(known)));
    }
    let (middle, width) = seen_window(g, rhs)?;
    let (pi, known) = (g.pi(), g.call(Fun::TurnTo, &[known, middle]));
    let left = g.sum(Q::ZERO, &[(Q::int(2), pi), (Q::int(-1), width)]);
    let slack = g.float(1e-12);
    let conditions = vec![Condition(g.add(left, slack))];
    Some((rhs, vec![Inverse { known, conditions }]))
}

/// Whether an angle is seen to be in [-π, π] at many points of domains that are declared: of others points tell nothing.
fn is_seen_within_half_a_turn(g: &mut Graph, angle: Id) -> bool {
    if bounded_inputs(g, angle).is_none() {
        return false;
    }
    let pi = g.float(PI + 1e-9);
    let sides = [g.add(pi, angle), g.sub(pi, angle)];
    sides.into_iter().all(|side| sign_at(g, side, WINDOW_POINTS, &[]) == Some(1))
}

/// The middle and the width of what an angle of one uniform runs over, where at many points it lies between its ends, and
/// these within a turn. Of other parameters that is asked.
fn seen_window(g: &mut Graph, rhs: Id) -> Option<(Id, Id)> {
    let inputs = bounded_inputs(g, rhs)?.into_iter();
    let mut unknowns = inputs.filter(|leaf| matches!(leaf, Leaf::Unknown(_)));
    let (Some(uniform), None) = (unknowns.next(), unknowns.next()) else { return None };
    let uniform = g.get_leaf(uniform);
    if g.range(uniform) != Interval::new(0.0, 1.0) {
        return None;
    }
    let ends = [0, 1].map(|end| {
        let end = g.int(end);
        g.substitute(rhs, &[(uniform, end)].into())
    });
    let [beyond_low, beyond_high, width] =
        [(rhs, ends[0]), (ends[1], rhs), (ends[1], ends[0])].map(|(a, b)| g.sub(a, b));
    let sign = sign_at(g, width, WINDOW_POINTS, &[])?;
    let same = [beyond_low, beyond_high]
        .iter()
        .all(|id| sign_at(g, *id, WINDOW_POINTS, &[]) == Some(sign));
    let width = if sign > 0 { width } else { g.neg(width) };
    let pi = g.pi();
    let left = g.sum(Q::decimal("1e-9")?, &[(Q::int(2), pi), (Q::int(-1), width)]);
    if !same || sign_at(g, left, WINDOW_POINTS, &[]) != Some(1) {
        return None;
    }
    let middle = g.sum(Q::ZERO, &[(Q::HALF, ends[0]), (Q::HALF, ends[1])]);
    Some((middle, width))
}

/// The inputs of an expression, if each of them has bounds.
fn bounded_inputs(g: &Graph, id: Id) -> Option<Vec<Leaf>> {
    let bounded = |leaf: &Leaf| g.leaf_range(*leaf).width().is_finite();
    inputs_of(g, id).filter(|leaves| leaves.iter().all(bounded))
}

/// At how many points it is looked what an angle runs over.
const WINDOW_POINTS: u32 = 4096;

/// Factors that are never negative, all to powers of one broken or symbolic exponent: (u / (1 - u))^(1 / b), kept as u^(1 / b)
/// (1 - u)^(-1 / b), is a power of u / (1 - u).
fn undo_common_power(g: &mut Graph, known: Id, f: &[(Id, Id)]) -> Option<(Id, Vec<Inverse>)> {
    let &(_, first) = f.first()?;
    if !f.iter().all(|(base, e)| g.range(*base).nonnegative() && !g.has(*e, UNKNOWNS)) {
        return None;
    }
    let mut ratios = Vec::new();
    for (_, e) in f {
        let ratio = g.div(*e, first);
        ratios.push(g.as_number(ratio).filter(|q| q.abs() == Q::ONE)?);
    }
    if g.as_number(first).is_some_and(|e| e.is_int()) {
        return None;
    }
    let factors: Vec<(Id, Id)> =
        f.iter().zip(ratios).map(|((base, _), ratio)| (*base, g.number(ratio))).collect();
    let base = g.product(&factors);
    Some((base, undo_power(g, known, base, first)))
}

fn undo_power(g: &mut Graph, known: Id, base: Id, exp: Id) -> Vec<Inverse> {
    let one = g.int(1);
    let inverse_exponent = g.div(one, exp);
    let range = g.range(base);
    let Some(e) = g.as_number(exp) else {
        // A symbolic power has a nonnegative base and value.
        return vec![Inverse {
            known: g.pow(known, inverse_exponent),
            conditions: vec![Condition(known)],
        }];
    };
    if !e.is_int() {
        return vec![Inverse {
            known: g.pow(known, inverse_exponent),
            conditions: vec![Condition(known)],
        }];
    }
    if e == Q::int(-1) {
        return vec![Inverse { known: g.powi(known, -1), conditions: vec![] }];
    }
    if e.is_even() {
        let root = g.pow(known, inverse_exponent);
        let minus = g.neg(root);
        let mut answers = Vec::new();
        if !range.nonpositive() {
            answers.push(Inverse { known: root, conditions: vec![Condition(known)] });
        }
        if !range.nonnegative() {
            answers.push(Inverse { known: minus, conditions: vec![Condition(known)] });
        }
        return answers;
    }
    if range.nonnegative() {
        return vec![Inverse {
            known: g.pow(known, inverse_exponent),
            conditions: vec![Condition(known)],
        }];
    }
    if e == Q::int(3) {
        return vec![Inverse { known: g.call(Fun::Cbrt, &[known]), conditions: vec![] }];
    }
    let size = g.call(Fun::Abs, &[known]);
    let root = g.pow(size, inverse_exponent);
    let sign = g.call(Fun::Sign, &[known]);
    vec![Inverse { known: g.mul(sign, root), conditions: vec![] }]
}

fn undo_call(g: &mut Graph, f: Fun, known: Id, argument: Id) -> Option<Vec<Inverse>> {
    let plain = |known| Some(vec![Inverse { known, conditions: vec![] }]);
    let back = |g: &mut Graph, h: Fun| g.call(h, &[known]);
    match f {
        // Without the tests a power that the logarithm becomes part of could go on beyond its pole.
        Fun::Exp => {
            let y = back(g, Fun::Ln);
            Some(vec![Inverse { known: y, conditions: vec![Condition(known)] }])
        }
        Fun::ExpM1 => {
            let (y, one) = (back(g, Fun::Ln1p), g.int(1));
            let test = g.add(known, one);
            Some(vec![Inverse { known: y, conditions: vec![Condition(test)] }])
        }
        Fun::Ln => plain(back(g, Fun::Exp)),
        Fun::Ln1p => plain(back(g, Fun::ExpM1)),
        Fun::Sinh => plain(back(g, Fun::Asinh)),
        Fun::Asinh => plain(back(g, Fun::Sinh)),
        Fun::Tanh => plain(back(g, Fun::Atanh)),
        Fun::Atanh => plain(back(g, Fun::Tanh)),
        Fun::Cbrt => {
            let cube = g.powi(known, 3);
            plain(cube)
        }
        Fun::Erf => plain(back(g, Fun::ErfInv)),
        Fun::ErfInv => plain(back(g, Fun::Erf)),
        Fun::Erfc => plain(back(g, Fun::ErfcInv)),
        Fun::ErfcInv => plain(back(g, Fun::Erfc)),
        Fun::LnErfc => plain(back(g, Fun::ErfcInvExp)),
        Fun::ErfcInvExp => plain(back(g, Fun::LnErfc)),
        Fun::LambertW => {
            let e = back(g, Fun::Exp);
            let x = g.mul(known, e);
            let one = g.int(1);
            let test = g.add(known, one);
            Some(vec![Inverse { known: x, conditions: vec![Condition(test)] }])
        }
        Fun::Asin => bounded(g, Fun::Sin, known, -FRAC_PI_2, FRAC_PI_2),
        Fun::Acos => bounded(g, Fun::Cos, known, 0.0, PI),
        Fun::Atan => bounded(g, Fun::Tan, known, -FRAC_PI_2, FRAC_PI_2),
        Fun::Acosh => {
            let y = back(g, Fun::Cosh);
            Some(vec![Inverse { known: y, conditions: vec![Condition(known)] }])
        }
        Fun::Cosh => {
            let y = back(g, Fun::Acosh);
            Some(both_signs(g, y, argument, vec![]))
        }
        Fun::Abs => Some(both_signs(g, known, argument, vec![Condition(known)])),
        Fun::Sin => periodic(g, Fun::Asin, known, argument),
        Fun::Cos => periodic(g, Fun::Acos, known, argument),
        Fun::Tan => periodic(g, Fun::Atan, known, argument),
        Fun::Sign
        | Fun::Turn
        | Fun::TurnTo
        | Fun::Atan2
        | Fun::SinPi
        | Fun::CosPi
        | Fun::Pow1p
        | Fun::LnGamma
        | Fun::LnBeta
        | Fun::BetaInc
        | Fun::BetaIncInv => None,
    }
}

/// y = h(known) for an inverse function with a bounded image: known must lie in [lo, hi].
fn bounded(g: &mut Graph, h: Fun, known: Id, lo: f64, hi: f64) -> Option<Vec<Inverse>> {
    let y = g.call(h, &[known]);
    let (lo, hi) = (g.float(lo), g.float(hi));
    let above = g.sub(known, lo);
    let below = g.sub(hi, known);
    Some(vec![Inverse { known: y, conditions: vec![Condition(above), Condition(below)] }])
}

fn both_signs(g: &mut Graph, y: Id, argument: Id, conditions: Vec<Condition>) -> Vec<Inverse> {
    let range = g.range(argument);
    let minus = g.neg(y);
    let mut answers = Vec::new();
    if !range.nonpositive() {
        answers.push(Inverse { known: y, conditions: conditions.clone() });
    }
    if !range.nonnegative() {
        answers.push(Inverse { known: minus, conditions });
    }
    answers
}

/// Every angle of a known sine, cosine or tangent that the argument's range admits.
fn periodic(g: &mut Graph, inverse: Fun, known: Id, argument: Id) -> Option<Vec<Inverse>> {
    let range = g.range(argument);
    if !range.width().is_finite() || range.width() > 32.0 * TAU {
        return None;
    }
    let principal = g.call(inverse, &[known]);
    let pi = g.pi();
    let mut answers = Vec::new();
    // Each family: sign · principal + (start + step · k) · π, with its image for k = 0.
    let families: &[(i64, i64, i64, f64, f64)] = match inverse {
        Fun::Asin => &[(1, 0, 2, -FRAC_PI_2, FRAC_PI_2), (-1, 1, 2, FRAC_PI_2, 3.0 * FRAC_PI_2)],
        Fun::Acos => &[(1, 0, 2, 0.0, PI), (-1, 0, 2, -PI, 0.0)],
        _ => &[(1, 0, 1, -FRAC_PI_2, FRAC_PI_2)],
    };
    for &(sign, start, step, lo, hi) in families {
        let period = step as f64 * PI;
        let first = ((range.lo - hi) / period - 1e-9).floor() as i64;
        let last = ((range.hi - lo) / period + 1e-9).ceil() as i64;
        for k in first..=last {
            let offset = k as f64 * period;
            // Images that only touch the range in a point add nothing but a doubled border.
            if lo + offset < range.hi - 1e-12 && hi + offset > range.lo + 1e-12 {
                let y =
                    g.sum(Q::ZERO, &[(Q::int(sign), principal), (Q::int(start + step * k), pi)]);
                answers.push(Inverse { known: y, conditions: vec![] });
            }
        }
    }
    (!answers.is_empty()).then_some(answers)
}
