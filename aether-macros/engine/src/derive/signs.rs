//! Tests of unknowns as signs of shorter expressions: a / b < 1 is b - a > 0 where b is known to be positive, and
//! neither the quotient nor a power of it need be computed. What follows from the other tests is not asked.

use crate::expr::{Fun, Graph, Id, Node, OUTS, children, shed};
use crate::hash::Set;
use crate::jacobian::cost_together;
use crate::rational::Q;

/// By which signs it is told that an unknown lies in [0, 1).
#[derive(Clone, Debug, Default)]
pub struct Signs {
    /// What must not be negative.
    pub at_least_zero: Vec<Id>,
    /// What must be positive.
    pub positive: Vec<Id>,
    /// What is a finite number then, if they tell so.
    pub bounded: Option<Id>,
}

impl Signs {
    /// All that is computed to tell.
    pub(super) fn expressions(&mut self) -> impl Iterator<Item = &mut Id> {
        let Signs { at_least_zero, positive, bounded } = self;
        at_least_zero.iter_mut().chain(positive).chain(bounded)
    }
}

/// The signs that tell of each of some unknowns whether it lies in [0, 1), where they are shorter than it, and those of
/// the conditions that do not follow from them; a side that is not asked for need not be tested.
pub(super) fn find_signs(
    g: &mut Graph,
    unknowns: &[(Id, [bool; 2])],
    conditions: &[Id],
) -> (Vec<Option<Signs>>, Vec<Id>) {
    let known: Vec<Id> = conditions.iter().flat_map(|&c| [c, only_base(g, c)]).collect();
    let mut found: Vec<Option<Signs>> = unknowns
        .iter()
        .map(|&(u, sides)| {
            let signs = signs(g, u, sides, &known);
            let all: Vec<Id> = signs.at_least_zero.iter().chain(&signs.positive).copied().collect();
            // An unknown that is told to lie between two numbers is told to be finite.
            let finite = signs.bounded.is_some() || all.is_empty() || sides != [true, true];
            let coordinates = (g.deps(u) & OUTS).count_ones() as usize;
            let cost = cost_together(g, &all) + if finite { 0 } else { coordinates };
            (cost < cost_together(g, &[u])).then_some(signs)
        })
        .collect();
    // What is asked more than once is asked once, and what others add up or multiply to not at all.
    let mut open: Vec<Id> = conditions.to_vec();
    let mut asked: Vec<Id> = Vec::new();
    for signs in found.iter_mut().flatten() {
        signs.positive.retain(|id| !asked.contains(id));
        asked.extend(&signs.positive);
        signs.at_least_zero.retain(|id| !asked.contains(id) && !open.contains(id));
        asked.extend(&signs.at_least_zero);
    }
    for condition in conditions {
        let others: Vec<Id> =
            open.iter().filter(|c| *c != condition).chain(&asked).copied().collect();
        if asked.contains(condition) || follows(g, *condition, &others) {
            open.retain(|c| c != condition);
        }
    }
    (found, open)
}

fn signs(g: &mut Graph, u: Id, [low, high]: [bool; 2], known: &[Id]) -> Signs {
    let mut signs = Signs::default();
    if low {
        let short = without_divisors(g, u, known);
        let sign = sign(g, short, known);
        if !follows(g, sign, known) {
            signs.at_least_zero.push(sign);
        }
    }
    let base = root_of(g, u, known);
    let (one, told) = (g.int(1), follows(g, base, known) || !signs.at_least_zero.is_empty());
    let rest = g.sub(one, base);
    let short = without_divisors(g, rest, known);
    if high && !follows(g, short, known) {
        let is_whole = told && short == rest;
        signs.bounded = if is_whole { Some(base) } else { held_below(g, short) };
        signs.positive.push(sign(g, short, known));
    }
    signs
}

/// What must be finite for an expression to be positive: the difference of numbers that no coordinate decides about and of
/// it, which is not negative.
fn held_below(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Sum(_, terms) = g.node(id).clone() else { return None };
    let held: Vec<(Q, Id)> =
        terms.into_iter().filter(|(_, t)| g.has(*t, OUTS)).map(|(q, t)| (q.neg(), t)).collect();
    let is_held = held.iter().all(|&(q, t)| !q.is_negative() && g.range(t).nonnegative());
    (is_held && !held.is_empty()).then(|| g.sum(Q::ZERO, &held))
}

/// Whether an expression is not negative where what is known is not.
fn follows(g: &mut Graph, id: Id, known: &[Id]) -> bool {
    if g.range(id).nonnegative() || known.contains(&id) {
        return true;
    }
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            !c.is_negative() && terms.iter().all(|&(q, t)| !q.is_negative() && follows(g, t, known))
        }
        Node::Product(_) => {
            let sign = sign(g, id, known);
            g.as_number(sign).is_some_and(|q| !q.is_negative())
                || sign != id && known.contains(&sign)
        }
        _ => false,
    }
}

/// A factor of an expression that has its sign where what is known is not negative.
fn sign(g: &mut Graph, id: Id, known: &[Id]) -> Id {
    let (q, body) = g.split(id);
    if q.is_negative() {
        return id;
    }
    let Node::Product(factors) = g.node(body).clone() else { return body };
    let open: Vec<(Id, Id)> = factors
        .into_iter()
        .filter(|&(base, e)| {
            let even = g.as_number(e).is_some_and(Q::is_even);
            !even && !follows(g, base, known)
        })
        .collect();
    g.product(&open)
}

/// What alone decides about the sign of an expression, if that is one factor.
fn only_base(g: &mut Graph, id: Id) -> Id {
    let sign = sign(g, id, &[]);
    match g.node(sign) {
        Node::Product(factors) if factors.len() == 1 => {
            let (base, e) = factors[0];
            if g.as_number(e).is_some_and(Q::is_int) { base } else { id }
        }
        _ => sign,
    }
}

/// The base of a power that is below one where the power is: all factors are known not to be negative.
fn root_of(g: &mut Graph, id: Id, known: &[Id]) -> Id {
    let Node::Product(factors) = g.node(id).clone() else { return id };
    let exponents: Option<Vec<Q>> = factors.iter().map(|f| g.as_number(f.1)).collect();
    let Some(exponents) = exponents else { return id };
    let least = exponents.iter().map(|e| e.num().abs()).min().unwrap_or(1);
    let whole = exponents.iter().all(|e| e.is_int() && e.num() % least == 0);
    if !whole || least == 1 || !factors.iter().all(|f| follows(g, f.0, known)) {
        return id;
    }
    let factors: Vec<(Id, Id)> = factors
        .iter()
        .zip(exponents)
        .map(|(f, e)| (f.0, g.number(Q::int((e.num() / least) as i64))))
        .collect();
    g.product(&factors)
}

/// c + q a / b as c b + q a, where b is known not to be negative: first where b is a sum, of which a may be a part.
fn without_divisors(g: &mut Graph, id: Id, known: &[Id]) -> Id {
    let is_sum =
        |g: &Graph, (base, e): (Id, Q)| e == Q::int(-1) && matches!(g.node(base), Node::Sum(..));
    let id = without_some(g, id, known, is_sum);
    let id = without_some(g, id, known, |_, _| true);
    // c b may be most of a with the other sign.
    shed(g, id)
}

fn without_some(
    g: &mut Graph,
    id: Id,
    known: &[Id],
    wanted: impl Fn(&Graph, (Id, Q)) -> bool,
) -> Id {
    let Node::Sum(c, terms) = g.node(id).clone() else { return id };
    let [(q, term)] = terms[..] else { return id };
    let mut divisors = g.factors(term);
    divisors.retain(|&(base, e)| {
        let whole = g.as_number(e).filter(|e| e.is_int() && e.is_negative());
        // What overflows divides to no number, which the quotient tells.
        let tame = !overflows(g, base);
        tame && whole
            .is_some_and(|e| wanted(g, (base, e)) && (e.is_even() || follows(g, base, known)))
    });
    if divisors.is_empty() {
        return id;
    }
    let inverse = g.product(&divisors);
    let divisor = g.powi(inverse, -1);
    let top = g.div(term, inverse);
    // Its size does not matter.
    let size = if q.is_negative() { q.neg() } else { q };
    let scaled = |q: Q| size.recip().and_then(|scale| q.mul(scale));
    match (scaled(c), scaled(q)) {
        (Some(c), Some(q)) => g.sum(Q::ZERO, &[(c, divisor), (q, top)]),
        _ => id,
    }
}

/// Whether there are exponentials in an expression.
fn overflows(g: &Graph, id: Id) -> bool {
    let (mut open, mut seen) = (vec![id], Set::default());
    while let Some(id) = open.pop() {
        if matches!(g.node(id), Node::Call(Fun::Exp | Fun::ExpM1 | Fun::Sinh | Fun::Cosh, _)) {
            return true;
        }
        if seen.insert(id) {
            open.extend(children(g.node(id)));
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn shares_of_a_sum_are_told_by_its_parts() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        let (two, three) = (g.add(a, b), g.plain_sum(&[a, b, c].map(|x| (Q::ONE, x))));
        // Of a tetrahedron: the cube of the sum, the square of what two are of it, what one is of two.
        let (cube, part, share) = (g.powi(three, 3), g.div(two, three), g.div(a, two));
        let part = g.powi(part, 2);
        let both = [true, true];
        let unknowns = [(cube, both), (part, both), (share, both)];
        let other = g.div(two, three);
        let (found, open) = find_signs(&mut g, &unknowns, &[a, two, three, other]);
        let found: Vec<Signs> = found.into_iter().flatten().collect();
        assert!(found.iter().all(|signs| signs.at_least_zero.is_empty()));
        assert_eq!(found.iter().flat_map(|s| &s.positive).collect::<Vec<_>>(), [&c, &b]);
        assert_eq!(open, [a]);
    }

    #[test]
    fn a_share_of_one_and_more_is_below_one() {
        let mut g = Graph::new();
        let [x, z] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        // q / (1 + q) for the square q of x / z.
        let ratio = g.div(x, z);
        let square = g.powi(ratio, 2);
        let one = g.int(1);
        let more = g.add(one, square);
        let share = g.div(square, more);
        let (found, _) = find_signs(&mut g, &[(share, [true, true])], &[]);
        let none = found[0].as_ref().expect("no test at all");
        assert!(none.positive.is_empty() && none.at_least_zero.is_empty());
        // Half of one and x / z, where z is positive.
        let half = Q::HALF;
        let place = g.sum(half, &[(half, ratio)]);
        let told = signs(&mut g, place, [true, true], &[z]);
        let [low, high] = [g.add(z, x), g.sub(z, x)];
        assert_eq!((&told.at_least_zero[..], &told.positive[..]), (&[low][..], &[high][..]));
        assert_eq!(told.bounded, None);
    }

    #[test]
    fn what_is_taken_from_numbers_must_be_finite() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        let p = g.leaf(Leaf::Param(0), "p", Interval::ALL);
        let (square, cube) = (g.powi(x, 2), g.powi(x, 3));
        let [less, odd, more] = [square, cube, y].map(|taken| g.sub(p, taken));
        assert_eq!(held_below(&mut g, less), Some(square));
        // What may be as far below zero.
        assert_eq!([held_below(&mut g, odd), held_below(&mut g, more)], [None; 2]);
        let both = g.sub(less, y);
        assert_eq!([held_below(&mut g, both), held_below(&mut g, p)], [None; 2]);
    }

    #[test]
    fn an_exponential_that_may_overflow_stays_a_divisor() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let (one, e) = (g.int(1), g.call(Fun::Exp, &[x]));
        let more = g.add(one, e);
        let logistic = g.div(e, more);
        let told = signs(&mut g, logistic, [true, true], &[]);
        assert_eq!(told.positive, [g.sub(one, logistic)]);
    }

    #[test]
    fn a_divisor_of_unknown_sign_stays() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::ALL));
        let ratio = g.div(x, y);
        let (found, open) = find_signs(&mut g, &[(ratio, [true, true])], &[]);
        assert!(found[0].is_none() && open.is_empty());
    }
}
