//! Tests that an unknown lies in [0, 1), without its outermost functions: of 1 - exp(-s x) only the sign of s x
//! matters.

use std::collections::HashMap;

use proc_macro2::TokenStream;
use quote::quote;

use super::code::{Code, number};
use super::numeric;
use super::quotient::within_unit;
use crate::eval::evaluate;
use crate::expr::{Deps, Fun, Graph, Id, Node, leaf_bit};
use crate::rational::Q;
use crate::sorted;

/// How far outside of [0, 1) an unknown is surely no rounding error.
const FAR: f64 = 0.125;

/// A monotone function of an expression, as what it does to bounds.
#[derive(Clone)]
struct Peeled {
    /// The expression.
    inner: Id,
    /// Whether the function falls.
    falling: bool,
    /// Bounds of the inner expression at which the function has the values -1/8, 0, 1, 9/8: infinite where it
    /// never gets there, `None` where that depends on parameters.
    bounds: [Option<f64>; 4],
}

/// What is left when all monotone functions have been undone, where what is `asked` is not negative but for rounding.
fn peel(g: &Graph, id: Id, asked: &[Id]) -> Peeled {
    let bounds = [-FAR, 0.0, 1.0, 1.0 + FAR].map(Some);
    let mut peeled = Peeled { inner: id, falling: false, bounds };
    while let Some(next) = step(g, &peeled, asked) {
        peeled = next;
    }
    peeled
}

/// Undoes the outermost function.
fn step(g: &Graph, peeled: &Peeled, asked: &[Id]) -> Option<Peeled> {
    let through = |inner: Id, falls: bool, undo: &dyn Fn(f64) -> f64| Peeled {
        inner,
        falling: peeled.falling != falls,
        bounds: peeled.bounds.map(|bound| bound.map(undo)),
    };
    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
    match g.node(peeled.inner) {
        Node::Sum(c, terms) => {
            let [(q, term)] = terms[..] else { return None };
            let (c, q) = (c.to_f64(), q.to_f64());
            Some(through(term, q < 0.0, &|b| (b - c) / q))
        }
        Node::Product(factors) => {
            let is_number = |f: &&(Id, Id)| g.deps(f.0) == 0 && g.deps(f.1) == 0;
            let numbers: Vec<(Id, Id)> = factors.iter().filter(is_number).copied().collect();
            let mut rest = factors.iter().filter(|f| !is_number(f));
            let (Some(&(base, exponent)), None) = (rest.next(), rest.next()) else { return None };
            let scale = numbers.iter().try_fold(1.0, |scale, (b, e)| {
                let b = evaluate::<f64>(g, *b, &|_| f64::NAN);
                Some(scale * libm::pow(b, g.as_number(*e)?.to_f64()))
            })?;
            if scale <= 0.0 {
                return None;
            }
            let bounds = peeled.bounds.map(|bound| bound.map(|b| b / scale));
            power(g, (base, exponent), asked, (peeled.falling, bounds))
        }
        Node::Call(f, args) if args.len() == 1 => {
            let a = args[0];
            let half_turn = std::f64::consts::FRAC_PI_2;
            let within = |limit: f64, b: f64, inside: f64| {
                if b >= limit {
                    high
                } else if b <= -limit {
                    low
                } else {
                    inside
                }
            };
            match f {
                Fun::Exp => Some(through(a, false, &|b| if b <= 0.0 { low } else { libm::log(b) })),
                Fun::ExpM1 => {
                    Some(through(a, false, &|b| if b <= -1.0 { low } else { libm::log1p(b) }))
                }
                Fun::Ln if g.range(a).nonnegative() => Some(through(a, false, &libm::exp)),
                Fun::Ln1p if g.range(a).lo >= -1.0 => Some(through(a, false, &libm::expm1)),
                Fun::Tanh => Some(through(a, false, &|b| within(1.0, b, libm::atanh(b)))),
                Fun::Atan => Some(through(a, false, &|b| within(half_turn, b, libm::tan(b)))),
                Fun::Cbrt => Some(through(a, false, &|b| b * b * b)),
                _ => None,
            }
        }
        _ => None,
    }
}

/// Undoes a power, which has these bounds.
fn power(
    g: &Graph,
    (base, exponent): (Id, Id),
    asked: &[Id],
    (falling, bounds): (bool, [Option<f64>; 4]),
) -> Option<Peeled> {
    let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
    let through = |falls: bool, undo: &dyn Fn(f64) -> f64| Peeled {
        inner: base,
        falling: falling != falls,
        bounds: bounds.map(|bound| bound.map(undo)),
    };
    // An even power is not told by what rounding leaves of the sign.
    let is_even = g.as_number(exponent).is_some_and(Q::is_even);
    let positive = g.range(base).nonnegative() || is_even && asked.contains(&base);
    let Some(q) = g.as_number(exponent) else {
        // Zero and one stay where they are.
        let plain = !falling && bounds == [-FAR, 0.0, 1.0, 1.0 + FAR].map(Some);
        let grows = positive && plain && g.range(exponent).lo > 0.0;
        let kept = [Some(low), Some(0.0), Some(1.0), None];
        return grows.then_some(Peeled { inner: base, falling, bounds: kept });
    };
    if q == Q::ONE {
        return Some(through(false, &|b| b));
    }
    let e = q.to_f64();
    let root = |b: f64| if b < 0.0 { low } else { libm::pow(b, 1.0 / e) };
    let pole = |b: f64| if b <= 0.0 { high } else { libm::pow(b, 1.0 / e) };
    let odd = |b: f64| libm::copysign(libm::pow(b.abs(), 1.0 / e), b);
    match (positive, q.is_negative()) {
        (true, false) => Some(through(false, &root)),
        (true, true) => Some(through(true, &pole)),
        (false, false) if q.is_int() && q.num() % 2 != 0 => Some(through(false, &odd)),
        _ => None,
    }
}

/// Tests of an unknown, as tokens to be joined to a mask.
pub(super) struct UnitTest {
    /// That it lies in [0, 1).
    pub inside: TokenStream,
    /// That it does not lie far outside, if that is told by less than the unknown itself.
    pub near: Option<TokenStream>,
    /// What is compared, if it passes on neither side when it is infinite.
    pub bounded: Option<Id>,
}

/// Base and exponent of a power of which only the parameters know whether it grows.
fn unknown_power(g: &Graph, id: Id) -> Option<(Id, Id)> {
    let Node::Product(factors) = g.node(id) else { return None };
    let [(base, exponent)] = factors[..] else { return None };
    (g.as_number(exponent).is_none() && g.range(exponent).lo <= 0.0).then_some((base, exponent))
}

/// The tests of an unknown, as far as its range leaves them open, which is computed for something else too or is not. What is
/// `asked` is not negative but for rounding.
pub(super) fn unit_test(code: &mut Code, id: Id, is_computed: bool, asked: &[Id]) -> UnitTest {
    let g = code.graph();
    let range = g.range(id);
    let sides = [range.lo < 0.0, !range.at_most_one()];
    let mut peeled = peel(g, id, asked);
    if peeled.bounds[1].is_none() || peeled.bounds[2].is_none() {
        peeled = peel_nothing(id);
    }
    let Peeled { inner, falling, bounds } = peeled;
    if let Some((base, exponent)) = unknown_power(g, id) {
        let (base, exponent) = (code.value(base), code.value(exponent));
        // Below one if the base is and the exponent is positive, or if neither is so.
        let beyond = quote!((#base - R::ONE) * #exponent);
        let inside = quote!(.and(#base.ge(R::ZERO)).and((#beyond).lt(R::ZERO)));
        let far = number(FAR);
        let near = quote!(.and(#base.lt(-#far).or((#beyond).gt(#exponent.abs() * #far)).not()));
        return UnitTest { inside, near: Some(near), bounded: None };
    }
    if inner == id
        && sides[1]
        && !is_computed
        && let Some(inside) = within_unit(code, id, sides[0], asked)
    {
        return UnitTest { inside, near: None, bounded: Some(id) };
    }
    let value = place_of_root(code, inner, bounds).unwrap_or_else(|| code.value(inner));
    let above = |bound: f64, equal: bool| match (falling, equal) {
        _ if bound.is_infinite() => quote!(),
        (false, true) => {
            let b = number(bound);
            quote!(.and(#value.ge(#b)))
        }
        (false, false) => {
            let b = number(bound);
            quote!(.and(#value.gt(#b)))
        }
        (true, true) => {
            let b = number(bound);
            quote!(.and(#value.le(#b)))
        }
        (true, false) => {
            let b = number(bound);
            quote!(.and(#value.lt(#b)))
        }
    };
    let below = |bound: f64| match falling {
        _ if bound.is_infinite() => quote!(),
        false => {
            let b = number(bound);
            quote!(.and(#value.lt(#b)))
        }
        true => {
            let b = number(bound);
            quote!(.and(#value.gt(#b)))
        }
    };
    let [far_below, zero, one, far_above] = bounds;
    let mut inside = quote!();
    if sides[0] {
        inside.extend(zero.map(|b| above(b, true)));
    }
    if sides[1] {
        inside.extend(one.map(&below));
    }
    let known = (!sides[0] || far_below.is_some()) && (!sides[1] || far_above.is_some());
    // A number that is undetermined may be anywhere.
    let beyond = |bound: f64, low: bool| {
        let b = number(bound);
        match low != falling {
            _ if bound.is_infinite() => quote!(),
            true => quote!(.and(#value.le(#b).not())),
            false => quote!(.and(#value.ge(#b).not())),
        }
    };
    let near = (known && inner != id).then(|| {
        let low = far_below.filter(|_| sides[0]).map(|b| beyond(b, true));
        let high = far_above.filter(|_| sides[1]).map(|b| beyond(b, false));
        quote!(#low #high)
    });
    let tested = |bound: Option<f64>| bound.is_some_and(f64::is_finite);
    let (lower, upper) = (sides[0] && tested(zero), sides[1] && tested(one));
    let (lower, upper) = if falling { (upper, lower) } else { (lower, upper) };
    let range = g.range(inner);
    let bounded = (lower || range.lo.is_finite()) && (upper || range.hi.is_finite());
    UnitTest { inside, near, bounded: bounded.then_some(inner) }
}

/// Of a root that is compared with the ends of its interval: where its target lies between the values there, which
/// is on the same side of either end and needs no search.
fn place_of_root(code: &mut Code, id: Id, bounds: [Option<f64>; 4]) -> Option<TokenStream> {
    let g = code.graph();
    let Node::Root(root) = g.node(id) else { return None };
    let end = |id: Id| g.as_number(id).map(|q| q.to_f64());
    let mut ends = [end(root.lo)?, end(root.hi)?];
    let mut asked = [bounds[1]?, bounds[2]?];
    sorted::sort_by(&mut asked, f64::total_cmp);
    sorted::sort_by(&mut ends, f64::total_cmp);
    let ends_known = !root.inside && asked == ends && numeric::poles(g, root) == [false; 2];
    ends_known.then(|| numeric::place(code, root))
}

/// The inputs that make an expression infinite or no number if they are so themselves.
pub(super) fn passed_on(g: &Graph, id: Id, known: &mut HashMap<Id, Deps>) -> Deps {
    if let Some(deps) = known.get(&id) {
        return *deps;
    }
    let mut all =
        |ids: &mut dyn Iterator<Item = Id>| ids.fold(0, |deps, id| deps | passed_on(g, id, known));
    let deps = match g.node(id) {
        Node::Leaf(leaf) => leaf_bit(*leaf),
        Node::Sum(_, terms) => all(&mut terms.iter().map(|(_, term)| *term)),
        Node::Product(factors) => {
            let grows = |e: Id| g.as_number(e).is_some_and(|q| q.to_f64() > 0.0);
            all(&mut factors.iter().filter(|(_, e)| grows(*e)).map(|(base, _)| *base))
        }
        Node::Call(Fun::Abs | Fun::Ln | Fun::Cbrt | Fun::Asinh, args) => {
            all(&mut args.iter().copied())
        }
        _ => 0,
    };
    known.insert(id, deps);
    deps
}

/// What decides about the sign of an expression, if it is one factor of it, and whether that stands below a line:
/// then it cannot be zero.
pub(super) fn sign_of(g: &Graph, id: Id) -> (Id, bool) {
    let factors = match g.node(id) {
        Node::Product(factors) => factors.as_slice(),
        Node::Sum(c, terms) => match (c.is_zero(), &terms[..]) {
            (true, [(q, term)]) if !q.is_negative() => return sign_of(g, *term),
            _ => return (id, false),
        },
        _ => return (id, false),
    };
    let odd = |e: Id| g.as_number(e).is_some_and(|q| q.is_int() && q.num() % 2 != 0);
    let mut open = factors.iter().filter(|(b, e)| odd(*e) && !g.range(*b).nonnegative());
    let even_otherwise = |(b, e): &(Id, Id)| {
        odd(*e) || g.range(*b).nonnegative() || { g.as_number(*e).is_some_and(|q| q.is_int()) }
    };
    match (open.next(), open.next()) {
        (Some(&(base, e)), None) if factors.iter().all(even_otherwise) => {
            (base, g.as_number(e).is_some_and(Q::is_negative))
        }
        _ => (id, false),
    }
}

/// The unknown as it is.
fn peel_nothing(id: Id) -> Peeled {
    Peeled { inner: id, falling: false, bounds: [-FAR, 0.0, 1.0, 1.0 + FAR].map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn monotone_functions_are_undone() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        // 1 - exp(x): zero at x = 0, never one.
        let e = g.call(Fun::ExpM1, &[x]);
        let minus = g.int(-1);
        let u = g.mul(minus, e);
        let peeled = peel(&g, u, &[]);
        assert_eq!((peeled.inner, peeled.falling), (x, true));
        assert_eq!(peeled.bounds[1..3], [Some(0.0), Some(f64::NEG_INFINITY)]);
        // x² of both signs is not monotone, x³ is.
        let (square, cube) = (g.powi(x, 2), g.powi(x, 3));
        assert_eq!(peel(&g, square, &[]).inner, square);
        let peeled = peel(&g, cube, &[]);
        assert_eq!((peeled.inner, peeled.bounds[3]), (x, Some(libm::cbrt(1.125))));
        // Of what is known not to be negative, it is x that is at most one.
        let peeled = peel(&g, square, &[x]);
        assert_eq!((peeled.inner, peeled.bounds[2]), (x, Some(1.0)));
    }
}
