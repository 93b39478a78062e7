//! Bounds that keep rounding from leaving where a function is defined: `(1.0 - c * c).max(0.0).sqrt()`.
//!
//! Such a bound is no branch where the number is seen to be beyond it nowhere. There need be no proof, as there is for
//! other comparisons: without it the function has no value there, so that there is no sample, instead of a wrong density.
//! Where no function is taken, `x.max(0.0)` and `x.clamp(a, b)` are meant so too, and that x is within is asked of a sample.

use syn::{Expr, ExprMethodCall};

use super::Value;
use super::body::Body;
use super::branch::Unproven;
use crate::expr::{Id, UNKNOWNS};
use crate::rational::Q;

/// At how many points it is looked whether a bound is passed beyond which a function is not defined, and any other one.
const POINTS: u32 = 512;
const MANY_POINTS: u32 = 4096;

/// The argument of a function that is not defined everywhere.
pub(super) struct Bounded<'e> {
    function: &'e str,
    call: &'e ExprMethodCall,
    /// The ends of where it is defined.
    least: i64,
    most: Option<i64>,
}

/// What a root or an arc is taken of, if that is a number kept within bounds.
pub(super) fn bounded_argument<'e>(function: &'e str, argument: &'e Expr) -> Option<Bounded<'e>> {
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
            known.then_some(Bounded { function, call, least, most })
        }
        _ => None,
    }
}

impl Bounded<'_> {
    /// The number, without the bounds that are ends of where the function is defined and are passed nowhere.
    pub(super) fn value(self, body: &mut Body) -> Option<Id> {
        // One bound may follow the other.
        let inner = bounded_argument(self.function, &self.call.receiver);
        let x = match inner {
            Some(inner) => inner.value(body)?,
            None => match body.expr(&self.call.receiver)? {
                Value::Scalar(x) => x,
                // A vector or a point has no such methods, which the method itself says.
                _ => return body.scalar(&Expr::MethodCall(self.call.clone())),
            },
        };
        let bounds: Vec<Id> =
            self.call.args.iter().map(|a| body.scalar(a)).collect::<Option<_>>()?;
        match (self.call.method == "min", &bounds[..]) {
            (from_above, &[bound]) => Some(self.bounded(body, (x, bound), from_above)),
            (_, &[low, high]) => {
                let above = self.bounded(body, (x, low), false);
                Some(self.bounded(body, (above, high), true))
            }
            _ => None,
        }
    }

    /// The smaller of two numbers, or the larger, one of which is a bound.
    fn bounded(&self, body: &mut Body, (x, bound): (Id, Id), from_above: bool) -> Id {
        match if from_above { self.most } else { Some(self.least) } {
            Some(end) => within(body, (x, bound), from_above, (Some(end), POINTS, false)),
            None => body.extremum(x, bound, from_above),
        }
    }
}

/// The smaller of two numbers, or the larger. One that parameters alone make keeps rounding from the other one, if that is
/// beyond it nowhere.
pub(super) fn kept(body: &mut Body, (x, y): (Id, Id), smaller: bool) -> Id {
    within(body, (x, y), smaller, (None, MANY_POINTS, true))
}

/// The smaller of two numbers, or the larger. Where one of them is a bound, there is no point beyond it if so many points say so,
/// which may have to be asked of a point. A bound is this number, or any that no uniform decides about.
fn within(
    body: &mut Body,
    (a, b): (Id, Id),
    smaller: bool,
    (end, points, asked): (Option<i64>, u32, bool),
) -> Id {
    let is_bound = |id: Id| match end {
        Some(end) => body.graph.as_number(id) == Some(Q::int(end)),
        None => !body.graph.has(id, UNKNOWNS),
    };
    // The bound may be written first. Of parameters it is known beforehand which is larger.
    let first_is_kept = match [a, b].map(is_bound) {
        [false, true] => true,
        [true, false] => false,
        _ => return body.extremum(a, b, smaller),
    };
    let unproven = Unproven::Bound { holds: first_is_kept == smaller, points, asked };
    body.extremum_or(a, b, smaller, unproven)
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    /// How many pieces a function of what is left of one by a point of a disk has, or why there are none.
    fn pieces(of_rest: &str) -> Result<usize, String> {
        let text = format!(
            "fn f(u: [Uniform; 2], s: f64) -> Surface {{
                let r = u[0].sqrt();
                let phi = TAU * u[1];
                let a = r * phi.cos();
                let b = (1.0 - s) * (1.0 - a * a).sqrt() + s * r * phi.sin();
                let rest = 1.0 - a * a - b * b;
                Surface::new(a, b, {of_rest})
            }}"
        );
        let item = Item::new("s in 0.5..=0.99".parse().unwrap(), text.parse().unwrap(), true)?;
        Ok(item.derived.len())
    }

    #[test]
    fn what_is_never_passed_is_no_branch_of_a_root_or_an_arc() {
        for of_rest in [
            "rest.max(0.0).sqrt()",
            "(0.0).max(rest).sqrt()",
            "rest.clamp(0.0, 1.0).sqrt()",
            "rest.max(-1.0).min(1.0).acos()",
            "(rest.clamp(-1.0, 1.0)).asin()",
        ] {
            assert_eq!(pieces(of_rest), Ok(1), "{of_rest}");
        }
        // Elsewhere a bound is any number; and what is passed is a branch.
        for of_rest in ["rest.max(0.0)", "(rest - 2.0).max(-2.0)", "rest.clamp(s - 1.0, 2.0 - s)"] {
            assert_eq!(pieces(of_rest), Ok(1), "{of_rest}");
        }
        assert!(pieces("rest.min(s)") != Ok(1));
        assert!(pieces("(rest - 0.5).max(0.0).sqrt()") != Ok(1));
        assert!(pieces("(rest - 0.01).max(0.0)") != Ok(1));
    }
}
