//! Bounds of a uniform on the way to an atom, and what is left between them.

use super::atoms::value;
use super::shares::Tried;
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::hash::Map;
use crate::measure::Measure;
use crate::monotone;
use crate::number::{Dd, Number};
use crate::parse::AtomWay;
use crate::points::Point;
use crate::rational::Q;
use crate::solve::{Numerical, System, solve};
use crate::stabilise::{GOOD, stabilise_knowing};

/// Sets of parameters at which solutions of an equation are told apart; all count in the end.
const TRIED: usize = 10;

/// What a test says of a uniform.
pub(super) struct Bound {
    /// Whether the uniform is larger.
    is_low: bool,
    /// Than this, if that lies in [0, 1].
    end: Id,
    /// Where it need not: what is positive where all uniforms pass, and where none does.
    beyond: Option<[Id; 2]>,
}

/// What tests of a way say of a uniform, of which those are left away that follow from others.
pub(super) fn bounds(
    g: &mut Graph,
    (way, written): (&AtomWay, &[Id]),
    u: Leaf,
    points: &[Point],
) -> Result<Vec<Bound>, String> {
    let mut tests: Vec<(Id, Id)> =
        written.iter().map(|&test| (test, g.import(&way.graph, test))).collect();
    let mut k = 0;
    while k < tests.len() {
        let mut others = tests.iter().enumerate().filter(|(j, _)| *j != k);
        let implied = others.any(|(_, other)| {
            let more = g.sub(tests[k].1, other.1);
            g.range(more).nonnegative()
        });
        if implied {
            tests.remove(k);
        } else {
            k += 1;
        }
    }
    tests.into_iter().map(|test| bound(g, (way, test), u, points)).collect()
}

fn bound(
    g: &mut Graph,
    (way, (written, difference)): (&AtomWay, (Id, Id)),
    u: Leaf,
    points: &[Point],
) -> Result<Bound, String> {
    let why = |rest: String| {
        format!(
            "the probability of this atom is the measure of the uniforms that lead here, {rest}"
        )
    };
    let (shown, name) = (show(&way.graph, written), way.graph.name(u));
    if way.graph.is_numerical(written) {
        return Err(why(format!(
            "and where `{shown}` is positive is known only numerically: compare the uniform with a number"
        )));
    }
    let is_low = increases(g, difference, u).map_err(|place| why(format!("between bounds that follow from comparisons which are monotone in a uniform; `{shown}` is not known to be so in {name}{place}")))?;
    let points: Vec<&Point> = points.iter().filter(|p| !p.stress).take(TRIED).collect();
    let is_it = |g: &Graph, end: Id| {
        points.iter().all(|point| {
            let tried = Tried { graph: &way.graph, tests: &[written], uniform: u, point };
            let near = |border: &Dd| (value(g, end, point) - *border).to_f64().abs() <= 1e-12;
            tried.borders(written).iter().all(near)
        })
    };
    let (end, certain) = root(g, difference, u, &is_it).ok_or_else(|| why(format!("and `{shown} = 0` cannot be solved for {name}: compare the uniform itself with a number, or let a `#[strategy]` choose between the point and the rest")))?;
    let range = g.range(end);
    if certain && range.within_one() {
        return Ok(Bound { is_low, end, beyond: None });
    }
    let leaf = g.get_leaf(u);
    let [first, last] = [0, 1].map(|at| {
        let at = g.int(at);
        g.substitute(difference, &[(leaf, at)].into())
    });
    let (least, most) = if is_low { (first, last) } else { (last, first) };
    // What is infinite there is so whatever the parameters are.
    let beyond = [least, g.neg(most)].map(|test| {
        let never = points.iter().all(|p| value(g, test, p).to_f64() == f64::NEG_INFINITY);
        if never { g.int(-1) } else { test }
    });
    Ok(Bound { is_low, end, beyond: Some(beyond) })
}

/// Whether an expression increases with a uniform; where that is not known.
fn increases(g: &mut Graph, difference: Id, u: Leaf) -> Result<bool, String> {
    let slope = derivative(g, difference, u);
    let range = g.range(slope);
    if range.nonnegative() || range.nonpositive() {
        return Ok(range.nonnegative());
    }
    monotone::direction(g, difference, u).map(|sign| sign > 0).map_err(|why| {
        let declare = why.unbounded.map_or(String::new(), |name| {
            format!(". If that depends on `{name}`, declare its domain, as in `#[sampler({name} in 0.1..=10.0)]`")
        });
        format!(" ({}){declare}", why.place)
    })
}

/// The value of a uniform at which an expression is zero, and whether there is one at all parameters.
fn root(
    g: &mut Graph,
    difference: Id,
    u: Leaf,
    is_it: &dyn Fn(&Graph, Id) -> bool,
) -> Option<(Id, bool)> {
    crate::poly::start_budget();
    let zero = g.int(0);
    let found =
        solve(g, &System::new(&[zero], &[difference]), &[u], &[], &[], Numerical::No).ok()?;
    found.into_iter().find_map(|solution| {
        let end = solution.spell_out(g, *solution.unknowns.get(&u)?);
        let certain = solution.conditions.iter().all(|c| g.range(c.0).nonnegative());
        is_it(g, end).then_some((end, certain))
    })
}

/// What is left of a uniform between bounds: the least of the distances between a lower and an upper one.
pub(super) fn width(g: &mut Graph, bounds: &[Bound], measure: &mut Measure) -> Id {
    let (low, high): (Vec<&Bound>, Vec<&Bound>) = bounds.iter().partition(|b| b.is_low);
    let widths: Vec<Id> = if low.is_empty() || high.is_empty() {
        bounds.iter().map(|b| beside(g, b, measure)).collect()
    } else {
        let pairs = low.iter().flat_map(|low| high.iter().map(move |high| [*low, *high]));
        pairs.map(|pair| between(g, pair, measure)).collect()
    };
    widths.into_iter().reduce(|a, b| smaller(g, a, b)).unwrap_or_else(|| g.int(1))
}

/// What one bound leaves of a uniform.
fn beside(g: &mut Graph, bound: &Bound, measure: &mut Measure) -> Id {
    let (zero, one) = (g.int(0), g.int(1));
    let inside = if bound.is_low {
        let rest = g.sub(one, bound.end);
        accurate(g, rest, measure)
    } else {
        accurate(g, bound.end, measure)
    };
    match bound.beyond {
        None => inside,
        Some([all, none]) => {
            let some = g.if_positive(none, zero, inside);
            g.if_positive(all, one, some)
        }
    }
}

/// What a lower and an upper bound leave of a uniform.
fn between(g: &mut Graph, [low, high]: [&Bound; 2], measure: &mut Measure) -> Id {
    let zero = g.int(0);
    let gap = g.sub(high.end, low.end);
    let gap = accurate(g, gap, measure);
    let mut left = if g.range(gap).nonnegative() { gap } else { g.if_positive(gap, gap, zero) };
    for (bound, other) in [(low, high), (high, low)] {
        if let Some([all, none]) = bound.beyond {
            let alone = beside(g, other, measure);
            left = g.if_positive(none, zero, left);
            left = g.if_positive(all, alone, left);
        }
    }
    left
}

/// The most accurate form of what is left of a uniform.
fn accurate(g: &mut Graph, id: Id, measure: &mut Measure) -> Id {
    let told: Map<Id, Id> = other_tail(g, id)
        .or_else(|| of_exponentials(g, id))
        .map(|form| (id, form))
        .into_iter()
        .collect();
    stabilise_knowing(g, id, measure, GOOD, &told)
}

/// exp(a) - exp(b) as -exp(a) expm1(b - a), also where one is taken from both.
fn of_exponentials(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(id).clone() else { return None };
    let [(p, s), (q, t)] = terms[..] else { return None };
    if !c.is_zero() || p != q.neg() {
        return None;
    }
    let exponent = |g: &Graph, id: Id| match g.node(id) {
        Node::Call(f @ (Fun::Exp | Fun::ExpM1), a) => Some((*f, a[0])),
        _ => None,
    };
    let ((f, a), (h, b)) = (exponent(g, s)?, exponent(g, t)?);
    if f != h {
        return None;
    }
    let gap = g.sub(b, a);
    let (first, rest) = (g.call(Fun::Exp, &[a]), g.call(Fun::ExpM1, &[gap]));
    let product = g.mul(first, rest);
    Some(g.sum(Q::ZERO, &[(q, product)]))
}

/// 2 - erfc(x) as erfc(-x), and π / 2 + atan(x) as the angle atan2(1, -x), times a number.
fn other_tail(g: &mut Graph, id: Id) -> Option<Id> {
    let Node::Sum(c, terms) = g.node(id).clone() else { return None };
    let [(q, t)] = terms[..] else { return None };
    let (function, turns) = match g.node(t).clone() {
        Node::Product(factors) => match factors[..] {
            [(a, e), (b, f)] if [e, f].iter().any(|e| g.as_number(*e) == Some(Q::int(-1))) => {
                let pi = g.pi();
                let turned = if a == pi { b } else { a };
                (turned, g.div(turned, pi) == t)
            }
            _ => return None,
        },
        _ => (t, false),
    };
    let Node::Call(f, arguments) = g.node(function).clone() else { return None };
    let opposite = g.neg(arguments[0]);
    let twice = Q::int(2).mul(c)?;
    match f {
        Fun::Erfc if !turns && c == Q::int(-2).mul(q)? => {
            let tail = g.call(Fun::Erfc, &[opposite]);
            Some(g.sum(Q::ZERO, &[(q.neg(), tail)]))
        }
        Fun::Atan if turns && (twice == q || twice == q.neg()) => {
            let (one, pi) = (g.int(1), g.pi());
            let along = if twice == q { opposite } else { arguments[0] };
            let angle = g.call(Fun::Atan2, &[one, along]);
            let angle = g.div(angle, pi);
            Some(g.sum(Q::ZERO, &[(twice, angle)]))
        }
        _ => None,
    }
}

/// The smaller of two expressions.
fn smaller(g: &mut Graph, a: Id, b: Id) -> Id {
    let gap = g.sub(b, a);
    let range = g.range(gap);
    if range.nonnegative() {
        a
    } else if range.nonpositive() {
        b
    } else {
        g.if_positive(gap, a, b)
    }
}
