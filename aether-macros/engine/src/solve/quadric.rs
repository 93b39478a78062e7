//! A vector that is normalised and would, if it were not, lie on a quadric: a unit vector that was
//! moved or stretched, and normalised again.
//!
//! X_i = T_i / |T| and Q(T) = 0 with a polynomial Q of degree two: T = λ X, so that λ = |T| is a root of
//! the quadratic equation Q(λ X) = 0, and all T_i are known.

use super::normalise::{common_lengths, common_multiple};
use super::scale::named;
use super::{Condition, Equation, State, affine_parts};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, UNKNOWNS, leaf_bit};
use crate::jacobian::{cost, factor_out, simplify, simplify_with};
use crate::poly::{Expander, RatFun, relation};
use crate::rational::Q;
use crate::sorted;

/// Pairs of coordinates whose products are the terms of degree two.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Σ squares r_i r_j + Σ linear r_i + constant = 0.
struct Quadric {
    squares: [Q; 6],
    linear: [Q; 3],
    constant: Id,
}

/// One coordinate of T: constant + factor · rest, where only the rest is unknown.
struct Coordinate {
    equation: usize,
    constant: Id,
    factor: Id,
    rest: Id,
}

/// Finds |T| if T lies on a quadric: one or two answers.
pub(super) fn normalised(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let mut lengths = common_lengths(g, state);
    // The outermost first: the others are parts of it.
    sorted::sort_by_key(&mut lengths, |(length, _)| std::cmp::Reverse(cost(g, *length)));
    lengths.into_iter().find_map(|(length, members)| divided(g, state, length, &members, false))
}

/// The same for a multiple of T, which tells as much as T / |T| where the quadric leads through the origin, so that there is
/// one answer.
pub(super) fn multiplied(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let (multiple, members) = common_multiple(g, state)?;
    // What is tried in vain must leave nothing in the graph, as the order of sums follows that in which parts came.
    let mut trial = g.clone();
    let divisor = trial.powi(multiple, -1);
    let next = divided(&mut trial, state, divisor, &members, true)?;
    *g = trial;
    Some(next)
}

/// The same for outputs that are divided by this length, or by another number if the quadric leads through the origin.
fn divided(
    g: &mut Graph,
    state: &State,
    length: Id,
    members: &[usize],
    through_origin: bool,
) -> Option<Vec<State>> {
    let mut coordinates = Vec::new();
    let mut plain = None;
    for &equation in members {
        let e = &state.equations[equation];
        let t = g.mul(e.rhs, length);
        if !g.has(t, UNKNOWNS) {
            if !state.lengths_first {
                return None;
            }
            // This coordinate alone gives the length.
            plain = plain.or_else(|| Some((equation, g.div(t, e.known))));
            continue;
        }
        let (constant, mut factor, mut rest) = affine_parts(g, t);
        let mut constant = constant.unwrap_or_else(|| g.int(0));
        // A stretched sum is a product, whose summands lie below the factor.
        if let (Some(inner), scale, below) = affine_parts(g, rest) {
            let stretched = g.mul(factor, inner);
            (constant, factor) = (g.add(constant, stretched), g.mul(factor, scale));
            rest = below;
        }
        coordinates.push(Coordinate { equation, constant, factor, rest });
    }
    let lengths = match plain {
        Some((_, value)) => vec![value],
        None => {
            let quadric = quadric(g, &mut coordinates)?;
            let [a, b, c] = equation(g, state, &quadric, &coordinates);
            if through_origin && (c != g.int(0) || b == c) {
                return None;
            }
            quadratic(g, a, b, c)
        }
    };
    let next = lengths.into_iter().map(|value| {
        let mut s = state.clone();
        s.solution.steps.push(format!("on a quadric: {} = {}", show(g, length), show(g, value)));
        if g.range(length).nonnegative() && !g.range(value).nonnegative() {
            s.solution.conditions.push(Condition(value));
        }
        let value = named(g, &mut s, value);
        s.solution.known.insert(length, value);
        let inverse = (g.powi(length, -1), g.powi(value, -1));
        s.solution.known.insert(inverse.0, inverse.1);
        if let Some((used, _)) = plain {
            s.equations[used].rhs = s.equations[used].known;
        }
        for c in &coordinates {
            let e = &mut s.equations[c.equation];
            let t = g.mul(value, e.known);
            let open = g.sub(t, c.constant);
            let known = g.div(open, c.factor);
            *e = Equation { known, rhs: c.rest, modulo_turn: false };
            s.solution.known.entry(c.rest).or_insert(known);
        }
        s
    });
    Some(next.collect())
}

/// The quadric of T, or of T without its known factors.
fn quadric(g: &mut Graph, coordinates: &mut [Coordinate]) -> Option<Quadric> {
    let [x, y, z] = &coordinates[..] else { return None };
    let rests = [x.rest, y.rest, z.rest];
    let whole = [x, y, z].map(|c| g.mul(c.factor, c.rest));
    let stretched = |g: &mut Graph| sphere(g, rests).or_else(|| second_degree(g, rests));
    let found = match sphere(g, whole) {
        None => match stretched(g).or_else(|| recentred(g, coordinates, whole)) {
            None => second_degree(g, whole)?,
            found => return found,
        },
        Some(found) => found,
    };
    for (c, open) in coordinates.iter_mut().zip(whole) {
        (c.factor, c.rest) = (g.int(1), open);
    }
    Some(found)
}

/// The coefficients of the quadratic equation for the length.
fn equation(g: &mut Graph, state: &State, quadric: &Quadric, c: &[Coordinate]) -> [Id; 3] {
    // rest = λ p - d.
    let p: Vec<Id> = c.iter().map(|c| g.div(state.equations[c.equation].known, c.factor)).collect();
    let d: Vec<Id> = c.iter().map(|c| g.div(c.constant, c.factor)).collect();
    let (mut first, mut second, mut third) = (Vec::new(), Vec::new(), Vec::new());
    for (&(i, j), &q) in PAIRS.iter().zip(&quadric.squares).filter(|(_, q)| !q.is_zero()) {
        let mut add = |terms: &mut Vec<(Q, Id)>, sign: i64, x: Id, y: Id| {
            let product = g.mul(x, y);
            let k = g.number(q);
            let product = g.mul(k, product);
            terms.push((Q::int(sign), product));
        };
        add(&mut first, 1, p[i], p[j]);
        add(&mut second, -1, p[i], d[j]);
        add(&mut second, -1, p[j], d[i]);
        add(&mut third, 1, d[i], d[j]);
    }
    for (i, &l) in quadric.linear.iter().enumerate().filter(|(_, l)| !l.is_zero()) {
        second.push((l, p[i]));
        third.push((l.neg(), d[i]));
    }
    third.push((Q::ONE, quadric.constant));
    // A length that is one is so but for rounding, which would leave a second root next to zero.
    let units = g.units().to_vec();
    [first, second, third].map(|terms| {
        let sum = g.sum(Q::ZERO, &terms);
        let whole = simplify_with(g, sum, &units);
        if g.as_number(whole).is_some() { whole } else { simplify(g, sum, None) }
    })
}

/// The roots of a x² + b x + c that may be positive.
fn quadratic(g: &mut Graph, a: Id, b: Id, c: Id) -> Vec<Id> {
    let zero = g.int(0);
    let minus_b = g.neg(b);
    if a == zero {
        let c = g.neg(c);
        return vec![g.div(c, b)];
    }
    if c == zero {
        return vec![g.div(minus_b, a)];
    }
    if b == zero {
        let square = g.div(c, a);
        let square = g.neg(square);
        return vec![g.sqrt(square)];
    }
    let (half, ac) = (g.number(Q::HALF), g.mul(a, c));
    let middle = g.mul(half, minus_b);
    let square = g.mul(middle, middle);
    let discriminant = g.sub(square, ac);
    let root = g.sqrt(discriminant);
    let (up, down) = (g.add(middle, root), g.sub(middle, root));
    let (larger, smaller) = (g.div(up, a), g.div(down, a));
    let (ra, rc) = (g.range(a), g.range(c));
    // Of two lengths, whose sum is positive then, the smaller one stays where the other is infinite.
    let smaller = if ra.nonnegative() && rc.lo > 0.0 { g.div(c, up) } else { smaller };
    // Roots of different signs: only one is a length.
    match (ra.nonnegative() && rc.hi < 0.0, ra.nonpositive() && rc.lo > 0.0) {
        (true, _) => vec![larger],
        (_, true) => vec![smaller],
        _ => vec![larger, smaller],
    }
}

/// A sphere around the origin.
fn sphere(g: &mut Graph, rests: [Id; 3]) -> Option<Quadric> {
    let squares = rests.map(|r| (Q::ONE, g.powi(r, 2)));
    let sum = g.sum(Q::ZERO, &squares);
    // What was divided by its own length shows without multiplying out.
    let sum = factor_out(g, sum);
    let radius = simplify(g, sum, None);
    let (one, zero) = (Q::ONE, Q::ZERO);
    (!g.has(radius, UNKNOWNS)).then(|| Quadric {
        squares: [one, one, one, zero, zero, zero],
        linear: [zero; 3],
        constant: g.neg(radius),
    })
}

/// A sphere whose centre shows in no summand of one coordinate, as it has become part of a product: the height
/// 1 - u (1 + v) of a cap, moved by v, is (1 - u) (1 + v). That coordinate is measured from the centre from then on.
fn recentred(g: &mut Graph, c: &mut [Coordinate], whole: [Id; 3]) -> Option<Quadric> {
    for moved in 0..3 {
        let along = whole[moved];
        let mut rests: [Id; 3] = std::array::from_fn(|i| c[i].rest);
        rests[moved] = along;
        let squares = rests.map(|r| (Q::ONE, g.powi(r, 2)));
        let sum = g.sum(Q::ZERO, &squares);
        let sum = simplify(g, sum, None);
        // Of (x - m)² what is left beside constants is -2 m x.
        let Some(unknown) = only_unknown(g, along) else { continue };
        let [rise, run] = [sum, along].map(|part| derivative(g, part, unknown));
        let slope = g.div(rise, run);
        let slope = simplify(g, slope, None);
        if g.has(slope, UNKNOWNS) {
            continue;
        }
        let half = g.number(Q::HALF);
        let middle = g.mul(half, slope);
        rests[moved] = g.sub(along, middle);
        if let Some(found) = sphere(g, rests) {
            let one = g.int(1);
            let constant = g.add(c[moved].constant, middle);
            c[moved] = Coordinate { constant, factor: one, rest: rests[moved], ..c[moved] };
            return Some(found);
        }
    }
    None
}

/// The unknown that an expression depends on, if it is one.
fn only_unknown(g: &Graph, id: Id) -> Option<Leaf> {
    let open = g.deps(id) & UNKNOWNS;
    let unknown = Leaf::Unknown(open.trailing_zeros() as _);
    (open == leaf_bit(unknown)).then_some(unknown)
}

/// The one relation of degree two with rational coefficients between three coordinates.
fn second_degree(g: &mut Graph, rests: [Id; 3]) -> Option<Quadric> {
    let mut expander = Expander::new(g).only(UNKNOWNS);
    let [x, y, z] = rests.map(|r| expander.expand(r));
    let first = [x?, y?, z?];
    let mut columns: Vec<RatFun> = Vec::new();
    for (i, j) in PAIRS {
        columns.push(expander.mul(&first[i], &first[j])?);
    }
    columns.extend(first);
    columns.push(RatFun::one());
    let k = relation(&mut expander, &columns)?;
    // Of a sphere that is -½ (x² + y² + z²) + z otherwise.
    let scale = k.iter().find(|k| !k.is_zero())?.recip()?;
    let k: Vec<Q> = k.iter().map(|k| k.mul(scale)).collect::<Option<_>>()?;
    let constant = g.number(k[9]);
    Some(Quadric {
        squares: [k[0], k[1], k[2], k[3], k[4], k[5]],
        linear: [k[6], k[7], k[8]],
        constant,
    })
}
