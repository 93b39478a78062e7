//! Choosing among equal forms of an expression by measured error.
//!
//! Every sum and logarithm is rewritten in the ways that experts use (expm1, ln_1p, conjugates,
//! multiplying out and factoring, half angles); each form is evaluated in double precision on the
//! test points and compared with double-double; a form is taken if it is clearly more accurate.
//! The graph bounds the number of forms, so the outcome is the same on every machine.

mod angles;
mod collect;
mod exponential;
mod hyperbolic;

pub(crate) use exponential::by_size;

use std::rc::Rc;

use crate::expr::{Deps, Fun, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::hash::Map;
use crate::jacobian::{cost, factor_out};
use crate::measure::{Errors, Loss, Measure};
use crate::multiples::of_multiple;
use crate::poly::Expander;
use crate::rational::Q;
use crate::sorted;

/// Errors up to this many units in the last place are not worth a rewrite.
pub(crate) const GOOD: f64 = 64.0 * f64::EPSILON;

/// How much larger the worst error of a form may be that is as good as another on average.
const FAR: f64 = 256.0;

/// The most forms that are tried for an expression and its parts: what is so long that more would help takes
/// seconds to compile.
const MOST_FORMS: usize = 400;

/// The expression with every part in its most accurate form.
pub fn stabilise(g: &mut Graph, id: Id, measure: &mut Measure) -> Id {
    stabilise_to(g, id, measure, GOOD)
}

/// The same, where only errors up to `good` are not worth a rewrite.
pub fn stabilise_to(g: &mut Graph, id: Id, measure: &mut Measure, good: f64) -> Id {
    // Most expressions are fine as they are: measure once before taking them apart.
    let truth = measure.truths(g, id);
    if measure.errors(g, id, &truth).worst() <= good {
        return id;
    }
    stabilise_knowing(g, id, measure, good, &Map::default())
}

/// The same, where `told` are forms of single parts that no rule finds.
pub fn stabilise_knowing(
    g: &mut Graph,
    id: Id,
    measure: &mut Measure,
    good: f64,
    told: &Map<Id, Id>,
) -> Id {
    Search { measure, good, turns: true, told, left: MOST_FORMS, memo: Map::default() }
        .rebuild(g, id, 3)
}

/// The coordinates of a point, each with every part in its most accurate form, if the point as a
/// whole needs it: an error counts relative to the length of the vector, and where one of a direction has fewer
/// unknowns than the two others, as its height, theirs relative to their own: next to a pole
/// they tell where the point is.
///
/// On a line a coordinate's zeros are the point's, and no point that is tried may be one: sines and
/// cosines of fractions of a turn are taken as such. `told` are forms of single parts that no rule finds.
pub fn stabilise_point(
    g: &mut Graph,
    coordinates: &[Id],
    measure: &mut Measure,
    told: &Map<Id, Id>,
) -> Vec<Id> {
    let by_turns = match *coordinates {
        [single] => vec![by_turns(g, single)],
        _ => coordinates.to_vec(),
    };
    let coordinates = &by_turns[..];
    let truth: Vec<Vec<f64>> = coordinates.iter().map(|&c| measure.truths(g, c)).collect();
    let values: Vec<_> = coordinates.iter().map(|&c| measure.values(g, c)).collect();
    let points = measure.points().len();
    let worst = |members: &[usize]| {
        let error = |k: usize| {
            let norm = members.iter().map(|&i| truth[i][k] * truth[i][k]).sum::<f64>().sqrt();
            let gap = |&i: &usize| (values[i][k] - truth[i][k]).abs();
            let error = measure.scaled(k, members.iter().map(gap).fold(0.0, nan_max));
            if error == 0.0 || !norm.is_finite() { 0.0 } else { error / norm }
        };
        (0..points).map(error).fold(0.0, nan_max)
    };
    let all: Vec<usize> = (0..coordinates.len()).collect();
    let length = |k: usize| truth.iter().map(|t| t[k] * t[k]).sum::<f64>();
    let unit = (0..points).all(|k| !length(k).is_finite() || (length(k) - 1.0).abs() < 1e-9);
    let around = if unit { around_a_pole(g, coordinates) } else { None };
    let at_poles = around.filter(|pair| worst(pair) > GOOD).map_or(vec![], |pair| pair.to_vec());
    let concerned = if worst(&all) <= GOOD { at_poles } else { all };
    let left = MOST_FORMS;
    let mut search = Search { measure, good: GOOD, turns: false, told, left, memo: Map::default() };
    let mut stable = coordinates.to_vec();
    for &k in &concerned {
        stable[k] = search.rebuild(g, stable[k], 3);
    }
    // A height may be what is left of one at a pole.
    let height = (0..3).find(|k| around.is_some_and(|pair| !pair.contains(k)));
    if let Some(k) = height.filter(|k| concerned.contains(k)) {
        let forms = [Q::ONE, Q::int(-1)].map(|side| {
            let gap = g.sum(side, &[(Q::int(-1), coordinates[k])]);
            let gap = search.rebuild(g, gap, 3);
            g.sum(side, &[(Q::int(-1), gap)])
        });
        stable[k] =
            nearest(g, &[stable[k], coordinates[k], forms[0], forms[1]], &truth[k], measure);
    }
    stable
}

/// The cheapest of the forms with the least error at any point, in double and then in single precision.
fn nearest(g: &Graph, forms: &[Id], truth: &[f64], measure: &mut Measure) -> Id {
    let doubles = measure.doubles();
    let mut scored: Vec<(Id, [f64; 2])> = Vec::new();
    for &form in forms {
        let values = measure.values(g, form);
        let mut worst = [f64::EPSILON; 2];
        for (k, (v, t)) in values.iter().zip(truth).enumerate().filter(|(_, (_, t))| t.is_finite())
        {
            let part = &mut worst[usize::from(k >= doubles)];
            *part = nan_max(*part, measure.scaled(k, (v - t).abs()));
        }
        scored.push((form, worst));
    }
    for part in 0..2 {
        let least = scored.iter().map(|s| s.1[part]).fold(f64::INFINITY, f64::min);
        scored.retain(|s| s.1[part] <= 4.0 * least);
    }
    scored.iter().min_by_key(|s| cost(g, s.0)).map_or(forms[0], |s| s.0)
}

/// Of three coordinates the two that have more unknowns than the third.
fn around_a_pole(g: &Graph, coordinates: &[Id]) -> Option<[usize; 2]> {
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
fn by_turns(g: &mut Graph, id: Id) -> Id {
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

/// The larger of two errors; not a number is the largest of all.
fn nan_max(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// A search for better forms.
struct Search<'a> {
    measure: &'a mut Measure,
    good: f64,
    /// Whether sines and cosines of fractions of a turn may be taken as such.
    turns: bool,
    /// Forms of single parts that no rule finds.
    told: &'a Map<Id, Id>,
    /// How many forms may still be tried.
    left: usize,
    /// What was found already, by expression and depth: forms share most of their parts.
    memo: Map<(Id, u8), Id>,
}

impl Search<'_> {
    fn rebuild(&mut self, g: &mut Graph, id: Id, depth: u8) -> Id {
        if let Some(&r) = self.memo.get(&(id, depth)) {
            return r;
        }
        let rebuilt = match g.node(id).clone() {
            Node::Sum(c, terms) => {
                let t: Vec<_> =
                    terms.iter().map(|&(q, t)| (q, self.rebuild(g, t, depth))).collect();
                g.sum(c, &t)
            }
            Node::Product(f) => {
                let f: Vec<_> = f.iter().map(|&(b, e)| (self.rebuild(g, b, depth), e)).collect();
                g.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.rebuild(g, a, depth)).collect();
                g.call(f, &a)
            }
            _ => id,
        };
        let best = self.best_form(g, id, rebuilt, depth);
        self.memo.insert((id, depth), best);
        best
    }

    /// The cheapest among the most accurate forms; a form must be clearly better to be taken.
    fn best_form(&mut self, g: &mut Graph, original: Id, rebuilt: Id, depth: u8) -> Id {
        let mut forms = vec![(original, self.measure.errors_of(g, original, original))];
        if rebuilt != original {
            forms.push((rebuilt, self.measure.errors_of(g, rebuilt, original)));
        }
        let worst = |forms: &[(Id, Rc<Errors>)]| {
            forms.iter().map(|f| f.1.worst()).fold(f64::INFINITY, f64::min)
        };
        if worst(&forms) > self.good && depth > 0 {
            let mut others = other_forms(g, original, self.turns);
            others.extend(self.told.get(&original));
            for form in others {
                let Some(left) = self.left.checked_sub(1) else { break };
                self.left = left;
                // The parts of a new form deserve a look of their own.
                let form = self.children_of(g, form, depth - 1);
                forms.push((form, self.measure.errors_of(g, form, original)));
            }
            if worst(&forms) > self.good
                && let Some(form) = self.by_sign(g, &forms)
            {
                forms.push((form, self.measure.errors_of(g, form, original)));
            }
        }
        if let [(only, _)] = forms[..] {
            return only;
        }
        let ids: Vec<Id> = forms.iter().map(|f| f.0).collect();
        let choice = (ids, self.good.to_bits());
        if let Some(&best) = self.measure.chosen.get(&choice) {
            return best;
        }
        let best = self.cheapest_of_the_best(g, forms);
        self.measure.chosen.insert(choice, best);
        best
    }

    /// The cheapest among the most accurate of equal forms, of which the first is the original.
    fn cheapest_of_the_best(&mut self, g: &Graph, forms: Vec<(Id, Rc<Errors>)>) -> Id {
        let truth = self.measure.truths(g, forms[0].0);
        let ids: Vec<Id> = forms.iter().map(|f| f.0).collect();
        let mut scored: Vec<(Id, Loss)> = match self.measure.mended(g, &truth, &ids) {
            Some(truth) => ids.iter().map(|&f| (f, self.measure.loss(g, f, &truth))).collect(),
            None => forms.iter().map(|f| (f.0, f.1.loss())).collect(),
        };
        // What counts first is double precision; single tells those apart that are as good in it.
        for part in 0..2 {
            let least = scored.iter().map(|s| s.1.parts()[part].bits).fold(f64::INFINITY, f64::min);
            scored.retain(|s| s.1.parts()[part].bits <= least + 0.4);
            let worst =
                scored.iter().map(|s| s.1.parts()[part].worst).fold(f64::INFINITY, f64::min);
            // What is good at every point goes before what is only good on average.
            let limit = if worst <= self.good { self.good } else { FAR * worst };
            scored.retain(|s| s.1.parts()[part].worst <= limit);
        }
        scored.iter().min_by_key(|s| cost(g, s.0)).map_or(ids[0], |s| s.0)
    }

    /// If no form is good everywhere: the one that is best for positive, and the one that is best for
    /// other values of an input, chosen by its sign.
    fn by_sign(&mut self, g: &mut Graph, forms: &[(Id, Rc<Errors>)]) -> Option<Id> {
        // At every point one of them has to be good (where single precision does what it can).
        let hopeless = |k: usize| forms.iter().all(|f| f.1.at(k) > self.good);
        if (0..self.measure.doubles()).any(hopeless) {
            return None;
        }
        let mut inputs: Vec<Leaf> = self.measure.points().first()?.keys().copied().collect();
        sorted::sort(&mut inputs);
        for leaf in inputs {
            let range = g.leaf_range(leaf);
            let varies = g.has(forms[0].0, crate::expr::leaf_bit(leaf));
            if !varies || range.lo >= 0.0 || range.hi <= 0.0 {
                continue;
            }
            let points = self.measure.points().iter();
            let above: Vec<bool> = points.map(|p| p.get(&leaf).is_some_and(|x| *x > 0.0)).collect();
            let yes = best_where(forms, &above, true)?;
            let no = best_where(forms, &above, false)?;
            if yes.0 != no.0 && yes.1.double.worst.max(no.1.double.worst) <= self.good {
                let test = g.get_leaf(leaf);
                return Some(g.if_positive(test, yes.0, no.0));
            }
        }
        None
    }

    fn children_of(&mut self, g: &mut Graph, form: Id, depth: u8) -> Id {
        match g.node(form).clone() {
            Node::Product(f) => {
                let f: Vec<_> = f.iter().map(|&(b, e)| (self.rebuild(g, b, depth), e)).collect();
                g.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.rebuild(g, a, depth)).collect();
                g.call(f, &a)
            }
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
                let t = self.children_of(g, terms[0].1, depth);
                g.sum(c, &[(terms[0].0, t)])
            }
            _ => form,
        }
    }
}

/// The form that is most accurate over those of the points for which `kept` is `side`.
fn best_where(forms: &[(Id, Rc<Errors>)], kept: &[bool], side: bool) -> Option<(Id, Loss)> {
    let scored = forms.iter().map(|(f, errors)| (*f, errors.loss_where(kept, side)));
    scored.min_by(|a, b| a.1.double.bits.total_cmp(&b.1.double.bits))
}

/// Other forms of a node that are equal in exact arithmetic.
fn other_forms(g: &mut Graph, id: Id, turns: bool) -> Vec<Id> {
    let mut out = Vec::new();
    match g.node(id).clone() {
        Node::Sum(c, terms) => {
            out.extend(one_minus(g, c, &terms));
            out.extend(other_tail(g, c, &terms));
            let between = between_ends(g, id);
            out.extend(between);
            out.extend(between.and_then(|form| over_ends(g, form)));
            out.extend(exponential::weighted_mean(g, c, &terms));
            out.extend(exponential::other_end(g, c, &terms));
            out.extend(half_angle(g, c, &terms));
            out.extend(squares(g, c, &terms));
            out.extend(conjugate(g, c, &terms));
            out.extend(over_sum(g, c, &terms));
            out.extend(angles::difference(g, c, &terms));
            out.extend(angles::as_product(g, c, &terms));
            out.extend(collect::by_coordinate(g, c, &terms));
            let f = factor_out(g, id);
            out.push(f);
            for open in [crate::expr::UNKNOWNS | crate::expr::OUTS, crate::expr::Deps::MAX] {
                out.extend(Expander::new(g).only(open).normal_form(id));
            }
        }
        Node::Call(Fun::Ln, args) => {
            if let Node::Sum(c, terms) = g.node(args[0]).clone()
                && c == Q::ONE
            {
                let rest = g.sum(Q::ZERO, &terms);
                out.push(g.call(Fun::Ln1p, &[rest]));
            }
        }
        Node::Call(f @ (Fun::Asin | Fun::Acos), args) => out.push(by_halves(g, f, args[0])),
        Node::Call(Fun::Ln1p, args) => out.extend(exponential::by_size(g, id, args[0])),
        Node::Call(Fun::BetaInc | Fun::BetaIncInv, _) => {
            out.extend(flipped(g, id).map(|f| g.sum(Q::ONE, &[(Q::int(-1), f)])));
        }
        Node::Product(factors) => {
            out.extend(both_sides_of_one(g, &factors));
            out.extend(exponential::over_largest(g, &factors));
            for (k, &(b, e)) in factors.iter().enumerate() {
                let Node::Sum(c, terms) = g.node(b).clone() else { continue };
                if c == Q::ONE && g.as_number(e).is_none_or(|e| !e.is_int() && e.den() > 3) {
                    let rest = g.sum(Q::ZERO, &terms);
                    let mut factors = factors.clone();
                    factors[k] = (g.call(Fun::Pow1p, &[rest, e]), g.int(1));
                    out.push(g.product(&factors));
                }
            }
        }
        Node::Call(Fun::Acosh, args) => out.extend(hyperbolic::beside_one(g, args[0])),
        Node::Call(f @ (Fun::Sinh | Fun::Cosh | Fun::Tanh), args) => {
            out.extend(of_multiple(g, f, args[0]));
        }
        Node::Call(f @ (Fun::Sin | Fun::Cos | Fun::Tan), args) => {
            out.extend(of_multiple(g, f, args[0]));
            out.extend(angles::of_sum(g, f, args[0]));
            if turns {
                out.extend(of_turn(g, id));
            }
        }
        _ => {}
    }
    out.retain(|f| *f != id);
    out
}

/// (1 + a)^e (1 - a)^e in a product as (1 - a²)^e, where e is no whole number.
fn both_sides_of_one(g: &mut Graph, factors: &[(Id, Id)]) -> Option<Id> {
    let beside_one = |g: &Graph, b: Id| match g.node(b) {
        Node::Sum(c, terms) if *c == Q::ONE => Some(terms.clone()),
        _ => None,
    };
    let power = |&(_, e): &&(Id, Id)| g.as_number(*e).is_none_or(|e| !e.is_int() && e.den() > 3);
    let (first, second, rest, e) = factors.iter().filter(power).find_map(|&(b, e)| {
        let rest = beside_one(g, b)?;
        let negated: Vec<(Q, Id)> = rest.iter().map(|&(q, t)| (q.neg(), t)).collect();
        let other = factors
            .iter()
            .position(|&(d, f)| f == e && beside_one(g, d).is_some_and(|terms| terms == negated))?;
        Some((factors.iter().position(|&f| f == (b, e))?, other, rest, e))
    })?;
    let rest = g.sum(Q::ZERO, &rest);
    let square = g.powi(rest, 2);
    let minus = g.neg(square);
    let mut factors = factors.to_vec();
    factors[first] = (g.call(Fun::Pow1p, &[minus, e]), g.int(1));
    factors.remove(second);
    Some(g.product(&factors))
}

/// A sum that is linear in a uniform u by its values at both ends, A (1 - u) + B u, where these have one sign.
pub(crate) fn between_ends(g: &mut Graph, id: Id) -> Option<Id> {
    let leaf = (0..8).map(Leaf::Unknown).find(|&l| g.deps(id) & UNKNOWNS == leaf_bit(l))?;
    let (u, zero, one) = (g.get_leaf(leaf), g.int(0), g.int(1));
    let [low, high] = [zero, one].map(|end| g.substitute(id, &[(u, end)].into()));
    let (a, b) = (g.range(low), g.range(high));
    if !(a.nonnegative() && b.nonnegative() || a.nonpositive() && b.nonpositive()) {
        return None;
    }
    let rest = g.sub(one, u);
    let terms = [g.mul(low, rest), g.mul(high, u)].map(|t| (Q::ONE, t));
    let form = g.sum(Q::ZERO, &terms);
    let gap = g.sub(id, form);
    let gap = Expander::new(g).normal_form(gap)?;
    (form != id && g.as_number(gap).is_some_and(Q::is_zero)).then_some(form)
}

/// A sum whose factors are sums that others divide, each over what divides it: in (1 - 1 / (1 + a)) (1 - u) + …, a / (1 + a).
fn over_ends(g: &mut Graph, form: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(form).clone() else { return None };
    let mut over = |(q, term): (Q, Id)| {
        let factors = g.factors(term).into_iter().map(|(b, e)| match g.node(b).clone() {
            Node::Sum(c, inner) => (over_sum(g, c, &inner).unwrap_or(b), e),
            _ => (b, e),
        });
        let factors: Vec<(Id, Id)> = factors.collect();
        (q, g.product(&factors))
    };
    let terms: Vec<(Q, Id)> = terms.into_iter().map(&mut over).collect();
    let found = g.sum(c, &terms);
    (found != form).then_some(found)
}

/// 1 - I(x; a, b) as I(1 - x; b, a), for the incomplete beta function or its inverse.
fn other_tail(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    let minus = q == Q::int(-1) && c == Q::ONE;
    minus.then(|| flipped(g, t)).flatten()
}

/// The angle with a given sine or cosine by the sine and cosine of half of it (from the quarter turn), which
/// tell it also where the given one is next to -1 or 1.
fn by_halves(g: &mut Graph, f: Fun, a: Id) -> Id {
    let [less, more] = [Q::HALF.neg(), Q::HALF].map(|half| {
        let square = g.sum(Q::HALF, &[(half, a)]);
        g.sqrt(square)
    });
    match f {
        Fun::Acos => {
            let half = g.call(Fun::Atan2, &[less, more]);
            g.sum(Q::ZERO, &[(Q::int(2), half)])
        }
        _ => {
            let (half, pi) = (g.call(Fun::Atan2, &[more, less]), g.pi());
            g.sum(Q::ZERO, &[(Q::int(2), half), (Q::HALF.neg(), pi)])
        }
    }
}

/// What the incomplete beta function or its inverse leaves of one.
fn flipped(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Call(f @ (Fun::BetaInc | Fun::BetaIncInv), args) = g.node(id).clone() else {
        return None;
    };
    Some(g.call(f, &[args[3], args[2], args[1], args[0]]))
}

/// c - c·T: through expm1 for powers and exponentials, through the half angle for cosines.
fn one_minus(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    if c.is_zero() || q != c.neg() {
        return None;
    }
    // 1 - cos(a) = 2 sin²(a / 2), and 1 - cosh(a) = -2 sinh²(a / 2).
    if let Node::Call(f @ (Fun::Cos | Fun::Cosh), a) = g.node(t).clone() {
        let (sine, twice) = if f == Fun::Cos { (Fun::Sin, 2) } else { (Fun::Sinh, -2) };
        let half = g.sum(Q::ZERO, &[(Q::HALF, a[0])]);
        let s = g.call(sine, &[half]);
        let s2 = g.powi(s, 2);
        return Some(g.sum(Q::ZERO, &[(c.mul(Q::int(twice))?, s2)]));
    }
    let mut logs = Vec::new();
    for (b, e) in g.factors(t) {
        if let Node::Call(Fun::Exp, a) = g.node(b).clone() {
            logs.push((Q::ONE, g.mul(e, a[0])));
            continue;
        }
        if !g.range(b).nonnegative() {
            return None;
        }
        let l = g.call(Fun::Ln, &[b]);
        logs.push((Q::ONE, g.mul(e, l)));
    }
    let log = g.sum(Q::ZERO, &logs);
    let m = g.call(Fun::ExpM1, &[log]);
    Some(g.sum(Q::ZERO, &[(c.neg(), m)]))
}

/// c + k cos a as (c + k) - 2 k sin²(a/2), for a sum of two terms, where k may contain parameters.
fn half_angle(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let [(q, t)] = *terms else { return None };
    let one = g.int(1);
    let factors = g.factors(t);
    let (cosine, a) = factors.iter().find_map(|&(b, e)| match g.node(b) {
        Node::Call(Fun::Cos, a) if e == one => Some((b, a[0])),
        _ => None,
    })?;
    let k = g.div(t, cosine);
    let half = g.sum(Q::ZERO, &[(Q::HALF, a)]);
    let s = g.call(Fun::Sin, &[half]);
    let s2 = g.powi(s, 2);
    let second = g.mul(k, s2);
    let first = g.sum(c, &[(q, k)]);
    Some(g.sum(Q::ZERO, &[(Q::ONE, first), (q.mul(Q::int(-2))?, second)]))
}

/// a² - b² as (a - b)(a + b).
fn squares(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let mut pair: Vec<(Q, Id)> = terms.to_vec();
    if !c.is_zero() {
        pair.push((c, g.int(1)));
    }
    let [(p, s), (q, t)] = pair[..] else { return None };
    if p.is_negative() == q.is_negative() {
        return None;
    }
    let (pos, neg) = if p.is_negative() { ((q, t), (p.neg(), s)) } else { ((p, s), (q.neg(), t)) };
    let mut root = |(q, t): (Q, Id)| {
        let k = g.number(q.sqrt()?);
        let t = root_of_square(g, t)?;
        Some(g.mul(k, t))
    };
    let (a, b) = (root(pos)?, root(neg)?);
    let d = g.sub(a, b);
    let s = g.add(a, b);
    Some(g.mul(d, s))
}

/// What a product is the square of. Beside other squares an exponential is one too: a² e^(2t) is (a e^t)².
fn root_of_square(g: &mut Graph, t: Id) -> Option<Id> {
    let factors = g.factors(t);
    let alone = factors.len() == 1;
    let mut halves = Vec::new();
    for (b, e) in factors {
        let h = g.as_number(e)?.mul(Q::HALF)?;
        match g.node(b).clone() {
            Node::Call(Fun::Exp, args) if !alone => {
                let half = g.sum(Q::ZERO, &[(h, args[0])]);
                halves.push((g.call(Fun::Exp, &[half]), g.int(1)));
            }
            _ if h.is_int() => halves.push((b, g.number(h))),
            _ => return None,
        }
    }
    Some(g.product(&halves))
}

/// A - √b as (A² - b) / (A + √b), where A may be a root or a sum without one. Only where both have the same sign:
/// elsewhere the sum below would cancel, next to a zero that no point that is tried may show.
fn conjugate(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let mut all: Vec<(Q, Id)> = terms.to_vec();
    if !c.is_zero() {
        all.push((c, g.int(1)));
    }
    let last = all.iter().rposition(|&(_, t)| is_root(g, t))?;
    let (q, root) = all.remove(last);
    if all.len() > 1 && all.iter().any(|&(_, t)| is_root(g, t)) {
        return None;
    }
    let rest = g.sum(Q::ZERO, &all);
    let a2 = g.powi(rest, 2);
    let b2 = g.powi(root, 2);
    let top = g.sum(Q::ZERO, &[(Q::ONE, a2), (q.mul(q)?.neg(), b2)]);
    let top = Expander::new(g).normal_form(top).unwrap_or(top);
    let bottom = g.sum(Q::ZERO, &[(Q::ONE, rest), (q.neg(), root)]);
    let plain = g.sum(c, terms);
    // What is long has terms that cancel in other places, which no point that is tried may show.
    if cost(g, top) > LONGER * cost(g, plain) {
        return None;
    }
    let form = g.div(top, bottom);
    let other = g.sum(Q::ZERO, &[(q, root)]);
    let opposed = g.mul(rest, other);
    if g.range(opposed).nonpositive() {
        return Some(form);
    }
    if g.range(opposed).nonnegative() {
        return None;
    }
    Some(g.if_positive(opposed, plain, form))
}

/// How many times as long as a difference that of its squares may be.
const LONGER: usize = 3;

/// 1 - a / (1 + a) as 1 / (1 + a): over a sum that divides one of the terms, without multiplying anything out.
pub(crate) fn over_sum(g: &mut Graph, c: Q, terms: &[(Q, Id)]) -> Option<Id> {
    let minus = g.int(-1);
    let bottom = terms.iter().find_map(|&(_, t)| {
        let factors = g.factors(t);
        let is_sum = |&(b, e): &(Id, Id)| e == minus && matches!(g.node(b), Node::Sum(..));
        factors.into_iter().find(is_sum).map(|(b, _)| b)
    })?;
    let mut tops = vec![(c, bottom)];
    for &(q, t) in terms {
        tops.push((q, g.mul(t, bottom)));
    }
    let top = g.sum(Q::ZERO, &tops);
    Some(g.div(top, bottom))
}

fn is_root(g: &mut Graph, id: Id) -> bool {
    g.factors(id).iter().any(|(_, e)| g.as_number(*e).is_some_and(|e| e.den() == 2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn powers_of_both_sides_of_one_are_one_power() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::new(-1.0, 1.0));
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(0.0, 1e3));
        let [up, down] = [1, -1].map(|s| g.sum(Q::ONE, &[(Q::int(s), x)]));
        let factors = [(up, k), (x, g.int(1)), (down, k)];
        let square = g.powi(x, 2);
        let minus = g.neg(square);
        let power = g.call(Fun::Pow1p, &[minus, k]);
        let expected = g.mul(x, power);
        assert_eq!(both_sides_of_one(&mut g, &factors), Some(expected));
        // Different powers stay apart.
        let other = [(up, k), (down, x)];
        assert_eq!(both_sides_of_one(&mut g, &other), None);
    }
}
