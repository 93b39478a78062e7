//! Probabilities of tails that are smaller than any number: erfc(x) by its logarithm.
//!
//! Far out, the quantile of a mean of two tails and the quotients of their differences are ordinary numbers that are
//! made of vanishing ones. With l = ln erfc(x), e^l - e^m is e^m (e^(l - m) - 1), and the powers are put together.
//! The choice is by the square of what may vanish: it is zero while that itself has all of its digits still.

use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;
use crate::stabilise::between_ends;

/// Up to here, erfc and its square are ordinary numbers in single precision, too.
const SAFE: f64 = 6.0;

/// A tail, erfc(x), with a weight.
#[derive(Clone, Copy)]
struct Tail {
    weight: Id,
    x: Id,
}

/// The tails that an expression is the sum of.
fn tails(g: &mut Graph, id: Id) -> Option<Vec<Tail>> {
    let one = g.int(1);
    let terms = match g.node(id) {
        Node::Sum(c, terms) => Some(terms.clone()).filter(|_| c.is_zero())?,
        _ => vec![(Q::ONE, id)],
    };
    let tail = |g: &mut Graph, (q, term): (Q, Id)| {
        let factors = g.factors(term);
        let argument = |&(b, e): &(Id, Id)| match g.node(b) {
            Node::Call(Fun::Erfc, args) if e == one => Some((b, args[0])),
            _ => None,
        };
        let (call, x) = factors.iter().find_map(argument)?;
        let rest = g.div(term, call);
        Some(Tail { weight: g.sum(Q::ZERO, &[(q, rest)]), x })
    };
    let tails: Vec<Tail> = terms.into_iter().map(|t| tail(g, t)).collect::<Option<_>>()?;
    tails.iter().any(|t| g.range(t.x).hi > SAFE).then_some(tails)
}

/// The logarithm of a sum of one tail or two, where none is taken away: that of the larger one, and of what is left then.
fn logarithm(g: &mut Graph, tails: &[Tail]) -> Option<Id> {
    if tails.iter().any(|t| !g.range(t.weight).nonnegative()) {
        return None;
    }
    let log = |g: &mut Graph, t: Tail| g.call(Fun::LnErfc, &[t.x]);
    match *tails {
        [only] => {
            let (tail, weight) = (log(g, only), g.call(Fun::Ln, &[only.weight]));
            Some(g.add(tail, weight))
        }
        [first, second] => {
            let by = |g: &mut Graph, larger: Tail, other: Tail| {
                let [l, m] = [larger, other].map(|t| log(g, t));
                let gap = g.sub(m, l);
                let ratio = g.call(Fun::Exp, &[gap]);
                let added = g.mul(other.weight, ratio);
                let sum = g.add(larger.weight, added);
                let sum = g.call(Fun::Ln, &[sum]);
                (gap, g.add(l, sum))
            };
            let (gap, by_first) = by(g, first, second);
            let (_, by_second) = by(g, second, first);
            Some(g.if_positive(gap, by_second, by_first))
        }
        _ => None,
    }
}

/// What is chosen where the square of what may vanish is not zero, and elsewhere.
pub(super) fn unless_vanishing(g: &mut Graph, small: Id, plain: Id, other: Id) -> Id {
    let square = g.powi(small, 2);
    g.if_positive(square, plain, other)
}

/// erfc⁻¹ of a mean of tails.
pub(super) fn quantile(g: &mut Graph, id: Id, mean: Id) -> Option<Id> {
    let mean = between_ends(g, mean).unwrap_or(mean);
    let tails = tails(g, mean)?;
    let log = logarithm(g, &tails)?;
    let other = g.call(Fun::ErfcInvExp, &[log]);
    let plain = g.call(Fun::ErfcInv, &[mean]);
    Some(unless_vanishing(g, mean, plain, other)).filter(|&form| form != id)
}

/// A factor that is a tail or the difference of two, or its absolute value, as a factor and the logarithm of another:
/// the weight and l, or the weight times (e^(l - m) - 1) and m.
fn scaled(g: &mut Graph, id: Id) -> Option<(Id, Id)> {
    if let Node::Call(Fun::Abs, args) = g.node(id).clone() {
        let (factor, log) = scaled(g, args[0])?;
        return Some((g.call(Fun::Abs, &[factor]), log));
    }
    let tails = tails(g, id)?;
    if let [only] = tails[..] {
        return Some((only.weight, g.call(Fun::LnErfc, &[only.x])));
    }
    let [first, second] = tails[..] else { return None };
    let opposite = g.neg(second.weight);
    if first.weight != opposite {
        return None;
    }
    let [l, m] = [first, second].map(|t| g.call(Fun::LnErfc, &[t.x]));
    let gap = g.sub(l, m);
    let factor = g.call(Fun::ExpM1, &[gap]);
    Some((g.mul(first.weight, factor), m))
}

/// … / (erfc x - erfc y) or … / erfc x, with such factors and exponentials in the numerator: what may vanish, and the
/// quotient by logarithms.
pub(super) fn quotient(g: &mut Graph, factors: &[(Id, Id)]) -> Option<(Id, Id)> {
    let (one, minus) = (g.int(1), g.int(-1));
    let (small, _) = *factors.iter().find(|&&(b, e)| e == minus && scaled(g, b).is_some())?;
    let mut exponent = Vec::new();
    let mut rest = Vec::new();
    for &(b, e) in factors {
        let sign = if e == minus { Q::int(-1) } else { Q::ONE };
        match (g.node(b).clone(), scaled(g, b)) {
            (_, Some((factor, log))) if e == one || e == minus => {
                exponent.push((sign, log));
                rest.push((factor, e));
            }
            (Node::Call(Fun::Exp, args), _) if e == one || e == minus => {
                exponent.push((sign, args[0]));
            }
            _ => rest.push((b, e)),
        }
    }
    let exponent = g.sum(Q::ZERO, &exponent);
    rest.push((g.call(Fun::Exp, &[exponent]), one));
    Some((small, g.product(&rest)))
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    fn item(body: &str, parameters: &str) -> Item {
        let text = format!("fn tail(u: [Uniform; 1], {parameters}) -> f64 {{ {body} }}");
        Item::new("".parse().unwrap(), text.parse().unwrap(), true).unwrap()
    }

    #[track_caller]
    fn close(found: f64, expected: f64, tolerance: f64) {
        let error = (found / expected - 1.0).abs();
        assert!(error < tolerance, "{found:e} and {expected:e}, which is {error:e} off");
    }

    /// Values of mpmath with 60 digits; the density is that at the rounded sample.
    #[test]
    fn normal_variables_between_bounds_that_no_number_reaches() {
        let lower = item(
            "normal_quantile((1.0 - u[0]) * normal_cdf(a) + u[0] * normal_cdf(b))",
            "a: f64, b: f64",
        );
        let table = [
            (-40.0, -39.0, 0.5, -39.01775730523235, 19.521676550740793),
            (-60.0, -38.0, 1e-3, -38.1812258590404, 0.03820738093224169),
            (-38.5, -70.0, 0.25, -38.50746650759345, 28.90005044130676),
            (-45.0, -8.0, 0.999, -8.000123192649347, 8.113368050649873),
            (-100.0, -99.0, 0.75, -99.00290554049386, 74.25975314559813),
        ];
        for (a, b, u, x, pdf) in table {
            close(lower.forward(&[a, b], &[u]).unwrap()[0], x, 4.0 * f64::EPSILON);
            // Half a unit in a bound or in the point costs its square.
            close(lower.pdf(&[a, b], &[x]), pdf, 4.0 * a.abs().max(b.abs()).powi(2) * f64::EPSILON);
        }
        let upper = item(
            "-normal_quantile((1.0 - u[0]) * normal_cdf(-a) + u[0] * normal_cdf(-b))",
            "a: f64, b: f64",
        );
        let [(a, b, u, x, pdf), ..] = table;
        close(upper.forward(&[-a, -b], &[u]).unwrap()[0], -x, 4.0 * f64::EPSILON);
        close(upper.pdf(&[-a, -b], &[-x]), pdf, 1e-11);
    }

    #[test]
    fn a_share_of_a_tail() {
        let below = item("normal_quantile(u[0] * normal_cdf(a))", "a: f64");
        let table = [
            (-50.0, 0.25, -50.02770713942175, 12.511920030272739),
            (-39.0, 1e-9, -39.527454999338765, 3.9552721589645877e-8),
            (-1.0, 1e-200, -30.266416184161518, 3.0299384360591567e-199),
        ];
        for (a, u, x, pdf) in table {
            close(below.forward(&[a], &[u]).unwrap()[0], x, 4.0 * f64::EPSILON);
            close(below.pdf(&[a], &[x]), pdf, 1e-11);
        }
    }
}
