//! Bounds that keep rounding from leaving where a function is defined: `(1.0 - c * c).max(0.0).sqrt()`.
//!
//! Such a bound is no branch where the number is seen to be beyond it nowhere. There need be no proof, as there is for
//! other comparisons: without it the function has no value there, so that there is no sample, instead of a wrong density.

use syn::{Expr, ExprMethodCall};

use super::Value;
use super::body::Body;
use super::order::assume_nonnegative;
use crate::expr::Id;
use crate::monotone::sign_at;
use crate::rational::Q;

/// At how many points it is looked whether a bound is passed.
const POINTS: u32 = 512;

/// The argument of a function that is not defined everywhere.
pub(super) struct Bounded<'e> {
    call: &'e ExprMethodCall,
    /// The ends of where it is defined.
    least: i64,
    most: Option<i64>,
}

/// What a root or an arc is taken of, if that is a number kept within bounds.
pub(super) fn bounded_argument<'e>(function: &str, argument: &'e Expr) -> Option<Bounded<'e>> {
    let (least, most) = match function {
        "sqrt" => (0, None),
        "asin" | "acos" => (-1, Some(1)),
        _ => return None,
    };
    match argument {
        Expr::Paren(inner) => bounded_argument(function, &inner.expr),
        Expr::MethodCall(call) => {
            let name = call.method.to_string();
            let known =
                matches!((name.as_str(), call.args.len()), ("max" | "min", 1) | ("clamp", 2));
            known.then_some(Bounded { call, least, most })
        }
        _ => None,
    }
}

impl Bounded<'_> {
    /// The number, without the bounds that are ends of where the function is defined and are passed nowhere.
    pub(super) fn value(self, body: &mut Body) -> Option<Id> {
        // A vector or a point has no such methods, which the method itself says.
        let Value::Scalar(x) = body.expr(&self.call.receiver)? else {
            return body.scalar(&Expr::MethodCall(self.call.clone()));
        };
        let bounds: Vec<Id> =
            self.call.args.iter().map(|a| body.scalar(a)).collect::<Option<_>>()?;
        match (self.call.method == "min", &bounds[..]) {
            (true, &[bound]) => Some(self.at_most(body, x, bound)),
            (_, &[bound]) => Some(self.at_least(body, x, bound)),
            (_, &[low, high]) => {
                let above = self.at_least(body, x, low);
                Some(self.at_most(body, above, high))
            }
            _ => None,
        }
    }

    fn at_least(&self, body: &mut Body, x: Id, bound: Id) -> Id {
        // Zero may be written first.
        let (x, bound) = if is(body, x, self.least) { (bound, x) } else { (x, bound) };
        let within = body.graph.sub(x, bound);
        match is(body, bound, self.least) && never_negative(body, within) {
            true => x,
            false => body.extremum(x, bound, false),
        }
    }

    fn at_most(&self, body: &mut Body, x: Id, bound: Id) -> Id {
        let Some(most) = self.most else { return body.extremum(x, bound, true) };
        let (x, bound) = if is(body, x, most) { (bound, x) } else { (x, bound) };
        let within = body.graph.sub(bound, x);
        match is(body, bound, most) && never_negative(body, within) {
            true => x,
            false => body.extremum(x, bound, true),
        }
    }
}

fn is(body: &Body, id: Id, number: i64) -> bool {
    body.graph.as_number(id) == Some(Q::int(number))
}

/// Whether a number is seen to be negative nowhere, which is known from then on.
fn never_negative(body: &mut Body, id: Id) -> bool {
    let seen = sign_at(&body.graph, id, POINTS) == Some(1);
    if seen {
        assume_nonnegative(&mut body.graph, id);
    }
    seen
}
