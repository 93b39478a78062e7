//! Symbolic derivatives.

use crate::expr::{Fun, Graph, Id, Leaf, Node, leaf_bit};
use crate::hash::Map;
use crate::rational::Q;

/// ∂ id / ∂ x.
pub fn derivative(g: &mut Graph, id: Id, x: Leaf) -> Id {
    derive(g, id, x, &mut Map::default())
}

fn derive(g: &mut Graph, id: Id, x: Leaf, memo: &mut Map<Id, Id>) -> Id {
    if !g.has(id, leaf_bit(x)) {
        return g.int(0);
    }
    if let Some(&d) = memo.get(&id) {
        return d;
    }
    let d = match g.node(id).clone() {
        Node::Leaf(_) => g.int(1),
        Node::Sum(_, terms) => {
            let t: Vec<_> = terms.iter().map(|&(q, t)| (q, derive(g, t, x, memo))).collect();
            g.sum(Q::ZERO, &t)
        }
        Node::Product(factors) => {
            if let Some(slope) = slope_of_quotient(g, id, &factors, x) {
                memo.insert(id, slope);
                return slope;
            }
            let mut terms = Vec::new();
            for (b, e) in factors {
                let db = derive(g, b, x, memo);
                let slope = g.div(db, b);
                let part = g.mul(e, slope);
                let whole = g.mul(id, part);
                terms.push((Q::ONE, whole));
                let de = derive(g, e, x, memo);
                let log = g.call(Fun::Ln, &[b]);
                let part = g.mul(de, log);
                let whole = g.mul(id, part);
                terms.push((Q::ONE, whole));
            }
            g.sum(Q::ZERO, &terms)
        }
        Node::Call(Fun::Atan2, args) => {
            let dy = derive(g, args[0], x, memo);
            let dx = derive(g, args[1], x, memo);
            let a = g.mul(args[1], dy);
            let b = g.mul(args[0], dx);
            let top = g.sub(a, b);
            let y2 = g.powi(args[0], 2);
            let x2 = g.powi(args[1], 2);
            let r2 = g.add(x2, y2);
            g.div(top, r2)
        }
        Node::Call(Fun::Pow1p, args) => {
            let one = g.int(1);
            let base = g.add(one, args[0]);
            let power = g.pow(base, args[1]);
            derive(g, power, x, memo)
        }
        Node::Call(f @ (Fun::BetaInc | Fun::BetaIncInv), args) => {
            // Of the inverse 1 / the slope, at its value.
            let at = if f == Fun::BetaInc {
                [args[0], args[3]]
            } else {
                let one = g.int(1);
                [id, g.sub(one, id)]
            };
            let slope = beta_slope(g, at, [args[1], args[2]]);
            let inner = derive(g, args[0], x, memo);
            if f == Fun::BetaInc { g.mul(inner, slope) } else { g.div(inner, slope) }
        }
        Node::Call(f, args) => {
            let inner = derive(g, args[0], x, memo);
            let slope = slope(g, f, args[0], id);
            g.mul(slope, inner)
        }
        Node::If(test, yes, no) => {
            let (yes, no) = (derive(g, yes, x, memo), derive(g, no, x, memo));
            g.if_positive(test, yes, no)
        }
        Node::Root(r) => g.derivative_of_root(id, &r, x),
        Node::Number(_) | Node::Float(_) | Node::Pi => g.int(0),
    };
    memo.insert(id, d);
    d
}

/// The slope of a quotient of two expressions that are linear in x, times factors without x: N' D - N D' is that at
/// zero, and what would cancel in it is not there.
fn slope_of_quotient(g: &mut Graph, id: Id, factors: &[(Id, Id)], x: Leaf) -> Option<Id> {
    let open = |g: &Graph, id: Id| g.has(id, leaf_bit(x));
    let open_factors: Vec<(Id, Id)> =
        factors.iter().filter(|(b, e)| open(g, *b) || open(g, *e)).copied().collect();
    let with = |power| open_factors.iter().find(|(_, e)| g.as_number(*e) == Some(Q::int(power)));
    let (&(top, _), &(bottom, _)) = (with(1)?, with(-1)?);
    if open_factors.len() != 2 {
        return None;
    }
    let [rise, fall] = [top, bottom].map(|part| derivative(g, part, x));
    if open(g, rise) || open(g, fall) {
        return None;
    }
    let (zero, leaf) = (g.int(0), g.get_leaf(x));
    let [above, below] = [top, bottom].map(|part| g.substitute(part, &[(leaf, zero)].into()));
    if above == zero || below == zero {
        // Nothing cancels, and the rule for products makes shorter forms.
        return None;
    }
    let (gain, loss) = (g.mul(rise, below), g.mul(above, fall));
    let change = g.sub(gain, loss);
    let quotient = g.div(top, bottom);
    let rest = g.div(id, quotient);
    let squared = g.powi(bottom, -2);
    let scale = g.mul(rest, squared);
    Some(g.mul(scale, change))
}

/// f'(a), given the node `y` = f(a).
fn slope(g: &mut Graph, f: Fun, a: Id, y: Id) -> Id {
    let one = g.int(1);
    match f {
        Fun::Exp => y,
        Fun::ExpM1 => g.call(Fun::Exp, &[a]),
        Fun::Ln => g.powi(a, -1),
        Fun::Ln1p => {
            let s = g.add(one, a);
            g.powi(s, -1)
        }
        Fun::Sin => g.call(Fun::Cos, &[a]),
        Fun::Cos => {
            let s = g.call(Fun::Sin, &[a]);
            g.neg(s)
        }
        Fun::SinPi | Fun::CosPi => {
            let other = g.call(if f == Fun::SinPi { Fun::CosPi } else { Fun::SinPi }, &[a]);
            let pi = g.pi();
            let d = g.mul(pi, other);
            if f == Fun::SinPi { d } else { g.neg(d) }
        }
        Fun::Tan => {
            let c = g.call(Fun::Cos, &[a]);
            g.powi(c, -2)
        }
        Fun::Asin | Fun::Acos => {
            let m = g.sub(one, a);
            let p = g.add(one, a);
            let s = g.mul(m, p);
            let e = g.number(Q::HALF.neg());
            let d = g.pow(s, e);
            if f == Fun::Asin { d } else { g.neg(d) }
        }
        Fun::Atan => {
            let s = g.powi(a, 2);
            let s = g.add(one, s);
            g.powi(s, -1)
        }
        Fun::Sinh => g.call(Fun::Cosh, &[a]),
        Fun::Cosh => g.call(Fun::Sinh, &[a]),
        Fun::Tanh => {
            let c = g.call(Fun::Cosh, &[a]);
            g.powi(c, -2)
        }
        Fun::Asinh => {
            let s = g.powi(a, 2);
            let s = g.add(one, s);
            let e = g.number(Q::HALF.neg());
            g.pow(s, e)
        }
        Fun::Acosh => {
            let m = g.sub(a, one);
            let p = g.add(a, one);
            let s = g.mul(m, p);
            let e = g.number(Q::HALF.neg());
            g.pow(s, e)
        }
        Fun::Atanh => {
            let m = g.sub(one, a);
            let p = g.add(one, a);
            let s = g.mul(m, p);
            g.powi(s, -1)
        }
        Fun::Cbrt => {
            let s = g.powi(y, -2);
            g.sum(Q::ZERO, &[(Q::new(1, 3).unwrap_or(Q::ONE), s)])
        }
        // erf' = 2/√π exp(-a²), and of the inverse 1 / erf' at y.
        Fun::Erf => error_slope(g, a, 1),
        Fun::Erfc => {
            let d = error_slope(g, a, 1);
            g.neg(d)
        }
        Fun::ErfInv => error_slope(g, y, -1),
        Fun::ErfcInv => {
            let d = error_slope(g, y, -1);
            g.neg(d)
        }
        // (ln erfc)' = -2/√π exp(-a² - ln erfc a), and of the inverse one over that, where a is the value.
        Fun::LnErfc => {
            let slope = error_slope(g, a, 1);
            let (slope, size) = (g.neg(slope), g.neg(y));
            let size = g.call(Fun::Exp, &[size]);
            g.mul(slope, size)
        }
        Fun::ErfcInvExp => {
            let slope = error_slope(g, y, -1);
            let (slope, size) = (g.neg(slope), g.call(Fun::Exp, &[a]));
            g.mul(slope, size)
        }
        // W' = exp(-W) / (1 + W), which has no 0/0 at zero.
        Fun::LambertW => {
            let minus = g.neg(y);
            let e = g.call(Fun::Exp, &[minus]);
            let s = g.add(one, y);
            g.div(e, s)
        }
        // The parser refuses these of anything but parameters.
        Fun::LnGamma | Fun::LnBeta => g.float(f64::NAN),
        Fun::Abs => g.call(Fun::Sign, &[a]),
        Fun::Sign => g.int(0),
        Fun::Turn | Fun::TurnTo | Fun::Atan2 | Fun::Pow1p | Fun::BetaInc | Fun::BetaIncInv => one,
    }
}

/// x^(a - 1) (1 - x)^(b - 1) / B(a, b), of x and 1 - x.
fn beta_slope(g: &mut Graph, [x, rest]: [Id; 2], [a, b]: [Id; 2]) -> Id {
    let one = g.int(1);
    let (below, above) = (g.sub(a, one), g.sub(b, one));
    let (below, above) = (g.pow(x, below), g.pow(rest, above));
    let size = g.call(Fun::LnBeta, &[a, b]);
    let size = g.neg(size);
    let constant = g.call(Fun::Exp, &[size]);
    let powers = g.mul(below, above);
    g.mul(constant, powers)
}

/// (2/√π exp(-a²))^power, for a power of ±1.
fn error_slope(g: &mut Graph, a: Id, power: i64) -> Id {
    let square = g.powi(a, 2);
    let exponent = g.sum(Q::ZERO, &[(Q::int(-power), square)]);
    let e = g.call(Fun::Exp, &[exponent]);
    let pi = g.pi();
    let root = g.sqrt(pi);
    let two = g.int(2);
    let factor = g.div(two, root);
    let factor = g.powi(factor, power);
    g.mul(factor, e)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::interval::Interval;

    #[test]
    fn every_function_matches_a_difference_quotient() {
        let mut g = Graph::new();
        let leaf = Leaf::Unknown(0);
        let x = g.leaf(leaf, "x", Interval::new(0.0, 1.0));
        let half = g.number(Q::HALF);
        let shifted = g.add(x, half);
        let funs = [
            Fun::Exp,
            Fun::ExpM1,
            Fun::Ln,
            Fun::Ln1p,
            Fun::Sin,
            Fun::Cos,
            Fun::Tan,
            Fun::Asin,
            Fun::Acos,
            Fun::Atan,
            Fun::Sinh,
            Fun::Cosh,
            Fun::Tanh,
            Fun::Asinh,
            Fun::Atanh,
            Fun::Cbrt,
            Fun::Erf,
            Fun::Erfc,
            Fun::ErfInv,
            Fun::ErfcInv,
            Fun::LnErfc,
            Fun::ErfcInvExp,
            Fun::LambertW,
        ];
        for f in funs {
            let (h, t) = (1e-6, 0.37);
            let y = g.call(f, &[x]);
            let negative = evaluate::<f64>(&g, y, &|_| t) < 0.0;
            let y = if negative { g.neg(y) } else { y };
            let y = g.mul(y, shifted);
            let y = g.pow(y, shifted);
            let d = derivative(&mut g, y, leaf);
            let at = |id, t: f64| evaluate::<f64>(&g, id, &|_| t);
            let quotient = (at(y, t + h) - at(y, t - h)) / (2.0 * h);
            assert!((at(d, t) / quotient - 1.0).abs() < 1e-8, "{f:?}");
        }
    }

    #[test]
    fn in_the_slope_of_a_linear_fraction_nothing_cancels() {
        let mut g = Graph::new();
        let leaf = Leaf::Unknown(0);
        let u = g.leaf(leaf, "u", Interval::new(0.0, 1.0));
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| g.leaf(Leaf::Param(i), "abcd", Interval::ALL));
        let linear = |g: &mut Graph, start: Id, slope: Id| {
            let rest = g.mul(slope, u);
            g.add(start, rest)
        };
        let (top, bottom) = (linear(&mut g, a, b), linear(&mut g, c, d));
        let fraction = g.div(top, bottom);
        let found = derivative(&mut g, fraction, leaf);
        let (gain, loss) = (g.mul(b, c), g.mul(a, d));
        let change = g.sub(gain, loss);
        let squared = g.powi(bottom, 2);
        assert_eq!(found, g.div(change, squared));
        // Where nothing would cancel, the rule for products is as good.
        let ratio = g.div(u, bottom);
        let found = derivative(&mut g, ratio, leaf);
        assert!(matches!(g.node(found), Node::Sum(..)));
    }
}
