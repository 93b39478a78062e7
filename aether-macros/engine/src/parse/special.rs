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

/// The names of numbers, which are those of `std::f64::consts`.
pub const NUMBERS: [&str; 13] = [
    "PI",
    "TAU",
    "E",
    "LN_2",
    "SQRT_2",
    "FRAC_1_SQRT_2",
    "FRAC_1_PI",
    "FRAC_2_PI",
    "FRAC_PI_2",
    "FRAC_PI_3",
    "FRAC_PI_4",
    "FRAC_PI_6",
    "FRAC_PI_8",
];

/// Whether a name that stands alone in a body is that of a number or of a function of the language.
pub fn is_of_the_language(name: &str) -> bool {
    let others = ["solve", "precomputed", "require"];
    NUMBERS.contains(&name) || others.contains(&name) || SPECIAL.split(' ').any(|f| f == name)
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
