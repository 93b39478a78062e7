//! The special functions of the prelude, called by name.

use syn::{Expr, ExprCall};

use super::Value;
use super::body::Body;
use crate::expr::{Fun, Graph, Id, UNKNOWNS};
use crate::rational::Q;

/// A special function of the prelude at one argument.
fn function_of(g: &mut Graph, name: &str, x: Id) -> Option<Id> {
    let f = match name {
        "erf" => Fun::Erf,
        "erfc" => Fun::Erfc,
        "erf_inv" => Fun::ErfInv,
        "erfc_inv" => Fun::ErfcInv,
        "lambert_w" => Fun::LambertW,
        "ln_gamma" => Fun::LnGamma,
        // erfc(-x/√2) / 2 and its inverse, -√2 erfc⁻¹(2x).
        "normal_cdf" => {
            let two = g.int(2);
            let root = g.sqrt(two);
            let argument = g.div(x, root);
            let argument = g.neg(argument);
            let tail = g.call(Fun::Erfc, &[argument]);
            return Some(g.sum(Q::ZERO, &[(Q::HALF, tail)]));
        }
        "normal_quantile" => {
            let two = g.int(2);
            let twice = g.mul(two, x);
            let z = g.call(Fun::ErfcInv, &[twice]);
            let root = g.sqrt(two);
            let minus = g.neg(root);
            return Some(g.mul(minus, z));
        }
        _ => return None,
    };
    Some(g.call(f, &[x]))
}

/// A number of `std::f64::consts`, by its name.
pub fn number(g: &mut Graph, name: &str) -> Option<Id> {
    let pi = g.pi();
    let scaled = |g: &mut Graph, q: Q, t: Id| g.sum(Q::ZERO, &[(q, t)]);
    let ratio = |n: i64, d: i64| Q::new(i128::from(n), i128::from(d)).unwrap_or(Q::ONE);
    Some(match name {
        "PI" => pi,
        "TAU" => scaled(g, Q::int(2), pi),
        "FRAC_PI_2" => scaled(g, ratio(1, 2), pi),
        "FRAC_PI_3" => scaled(g, ratio(1, 3), pi),
        "FRAC_PI_4" => scaled(g, ratio(1, 4), pi),
        "FRAC_PI_6" => scaled(g, ratio(1, 6), pi),
        "FRAC_PI_8" => scaled(g, ratio(1, 8), pi),
        "FRAC_1_PI" => g.powi(pi, -1),
        "FRAC_2_PI" => {
            let r = g.powi(pi, -1);
            scaled(g, Q::int(2), r)
        }
        "SQRT_2" => {
            let two = g.int(2);
            g.sqrt(two)
        }
        "FRAC_1_SQRT_2" => {
            let half = g.number(Q::HALF);
            g.sqrt(half)
        }
        "E" => {
            let one = g.int(1);
            g.call(Fun::Exp, &[one])
        }
        "FRAC_2_SQRT_PI" => {
            let half = g.number(Q::HALF.neg());
            let r = g.pow(pi, half);
            scaled(g, Q::int(2), r)
        }
        "LN_2" | "LN_10" => {
            let base = g.int(if name == "LN_2" { 2 } else { 10 });
            g.call(Fun::Ln, &[base])
        }
        "LOG2_E" | "LOG10_E" => {
            let base = g.int(if name == "LOG2_E" { 2 } else { 10 });
            let l = g.call(Fun::Ln, &[base]);
            g.powi(l, -1)
        }
        "LOG2_10" | "LOG10_2" => {
            let (two, ten) = (g.int(2), g.int(10));
            let (two, ten) = (g.call(Fun::Ln, &[two]), g.call(Fun::Ln, &[ten]));
            if name == "LOG2_10" { g.div(ten, two) } else { g.div(two, ten) }
        }
        _ => return None,
    })
}

/// A number of the type `f64` itself, `f64::EPSILON`: the same in whatever precision the item runs.
pub fn limit(g: &mut Graph, name: &str) -> Option<Id> {
    Some(match name {
        "EPSILON" => g.number(Q::new(1, 1 << 52)?),
        "MAX" => g.float(f64::MAX),
        "MIN" => g.float(f64::MIN),
        "MIN_POSITIVE" => g.float(f64::MIN_POSITIVE),
        _ => return None,
    })
}

/// Whether a name is that of a number of the language.
pub fn is_number(name: &str) -> bool {
    number(&mut Graph::new(), name).is_some()
}

/// Whether a name that stands alone in a body is that of a number or of a function of the language.
pub fn is_of_the_language(name: &str) -> bool {
    let others = ["solve", "precomputed", "require"];
    is_number(name) || others.contains(&name) || SPECIAL.split(' ').any(|f| f == name)
}

/// The names that [`special_function`] knows, for messages.
pub const SPECIAL: &str = "erf erfc erf_inv erfc_inv normal_cdf normal_quantile lambert_w ln_gamma ln_beta beta_inc beta_inc_inv";

/// A call of a special function.
pub fn special_function(
    body: &mut Body,
    c: &ExprCall,
    name: &str,
    arguments: &[&Expr],
) -> Option<Value> {
    let wanted = match name {
        "beta_inc" | "beta_inc_inv" => 3,
        "ln_beta" => 2,
        _ => 1,
    };
    if arguments.len() != wanted {
        return body.error(c, format!("`{name}` has {wanted} arguments, not {}", arguments.len()));
    }
    let values: Vec<Id> = arguments.iter().map(|x| body.scalar(x)).collect::<Option<_>>()?;
    // The variable is the last argument; of these two functions all are parameters.
    let (fixed, of) = match name {
        "ln_gamma" | "ln_beta" => (&values[..], "is"),
        _ => (&values[..wanted - 1], "is, in all arguments but the last,"),
    };
    if fixed.iter().any(|&a| body.graph.has(a, UNKNOWNS)) {
        return body.error(
            c,
            format!("`{name}` {of} a function of parameters only: its derivative, which the density needs, is not in the language"),
        );
    }
    let g = &mut body.graph;
    let value = match (name, &values[..]) {
        ("ln_beta", [a, b]) => g.call(Fun::LnBeta, &[*a, *b]),
        ("beta_inc", [a, b, x]) => g.call(Fun::BetaInc, &[*x, *a, *b]),
        ("beta_inc_inv", [a, b, p]) => g.call(Fun::BetaIncInv, &[*p, *a, *b]),
        (name, values) => function_of(g, name, *values.first()?)?,
    };
    Some(Value::Scalar(value))
}
