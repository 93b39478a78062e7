//! Integers of a body: literals, constants, counters of loops, and numbers that are cast. They divide without a rest, are equal
//! or not, and say which element of an array is meant.

use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, ExprMethodCall, Type};

use super::Value;
use super::body::Body;
use crate::expr::{Graph, Id, UNKNOWNS};
use crate::interval::Interval;
use crate::rational::Q;

/// The types of integers.
const TYPES: [&str; 12] =
    ["usize", "isize", "u8", "u16", "u32", "u64", "u128", "i8", "i16", "i32", "i64", "i128"];

/// How many values of a parameter are told apart.
const MOST_VALUES: f64 = 16.0;

/// Whether a name is that of a type of integers.
pub(super) fn is_type(name: &str) -> bool {
    integer_type(name).is_some()
}

/// The type of integers that has a name.
pub(super) fn integer_type(name: &str) -> Option<&'static str> {
    TYPES.into_iter().find(|ty| *ty == name)
}

/// Where the numbers of a type of integers lie, as far as `f64` has them.
pub(super) fn range_of(ty: &str) -> Interval {
    if ty.starts_with('u') { Interval::new(0.0, f64::INFINITY) } else { Interval::ALL }
}

/// An integer that is known.
pub(super) fn known(g: &Graph, id: Id) -> Option<i64> {
    let q = g.as_number(id).filter(|q| q.is_int())?;
    i64::try_from(q.num()).ok()
}

impl Body<'_> {
    /// The integer that an index or the end of a range is, which has to be known.
    pub(super) fn known_index(&mut self, e: &Expr) -> Option<usize> {
        let found = match self.expr(e)? {
            Value::Integer(id) => self.settled(id),
            _ => None,
        };
        match found.map(usize::try_from) {
            Some(Ok(n)) => Some(n),
            _ => self.error(e, "an index says which number is meant, so it must be known here: write a literal, `u[0]`, a constant, the counter of a `for`, what `as usize` makes of a number with a known range, or declare the domain of a parameter that is an integer, `#[sampler(n in 0..=3)]`"),
        }
    }

    /// The integer that this is on this way: one way for each that a parameter may be, if these are few.
    pub(super) fn settled(&mut self, id: Id) -> Option<i64> {
        if let Some(n) = known(&self.graph, id) {
            return Some(n);
        }
        let range = self.graph.range(id);
        if range.width() > MOST_VALUES {
            return None;
        }
        let (first, last) = (libm::ceil(range.lo) as i64, libm::floor(range.hi) as i64);
        let is_above = |body: &mut Self, k: i64| {
            let k = body.graph.int(k);
            body.whole_exceeds(id, k, true)
        };
        Some((first..last).find(|k| !is_above(self, *k)).unwrap_or(last))
    }

    /// left op right, both integers.
    pub(super) fn of_integers(&mut self, b: &ExprBinary, x: Id, y: Id) -> Option<Value> {
        let g = &mut self.graph;
        let id = match b.op {
            BinOp::Add(_) => g.add(x, y),
            BinOp::Sub(_) => g.sub(x, y),
            BinOp::Mul(_) => g.mul(x, y),
            BinOp::Div(_) | BinOp::Rem(_) => {
                let (Some(x), Some(y)) = (self.settled(x), self.settled(y)) else {
                    return self.error(b, "integers divide without a rest, which needs to be known here: divide numbers, `n as f64 / 2.0`, and take the `floor` of that");
                };
                let quotient =
                    if matches!(b.op, BinOp::Div(_)) { x.checked_div(y) } else { x.checked_rem(y) };
                match quotient {
                    Some(q) => self.graph.int(q),
                    None => return self.error(b, "this divides by zero"),
                }
            }
            _ => {
                return self
                    .error(b.op, "of the operators only + - * / % are functions of integers here");
            }
        };
        Some(Value::Integer(id))
    }

    /// Whether two values are equal; `None` if there is no telling for such values.
    pub(super) fn equal(&mut self, left: &Value, right: &Value) -> Option<bool> {
        match (left, right) {
            (Value::Bool(a), Value::Bool(b)) => Some(a == b),
            (Value::Integer(a), Value::Integer(b)) => {
                let both = self.whole_exceeds(*a, *b, false) && self.whole_exceeds(*b, *a, false);
                Some(both)
            }
            _ => self.equal_coordinates(left.numbers()?, right.numbers()?),
        }
    }

    /// Whether real numbers are equal to others, each to its own. What is sampled is equal to another number with probability
    /// zero: at such uniforms, which are no branch, a sample is what it is next to them.
    fn equal_coordinates(&mut self, left: &[Id], right: &[Id]) -> Option<bool> {
        if left.len() != right.len() {
            return None;
        }
        let differences: Vec<Id> =
            left.iter().zip(right).map(|(&a, &b)| self.graph.sub(a, b)).collect();
        let known = |id: &Id| self.graph.as_number(*id);
        let is_other =
            |id: &Id| self.graph.has(*id, UNKNOWNS) || known(id).is_some_and(|q| !q.is_zero());
        if differences.iter().any(is_other) {
            return Some(false);
        }
        differences.iter().all(|id| known(id).is_some_and(Q::is_zero)).then_some(true)
    }

    /// Whether one integer is larger than another, or as large if not strict. It is asked half way between two integers, so
    /// that comparisons of all kinds tell of each other.
    pub(super) fn whole_exceeds(&mut self, larger: Id, smaller: Id, strict: bool) -> bool {
        let beside = if strict { Q::HALF.neg() } else { Q::HALF };
        let difference = self.graph.sum(beside, &[(Q::ONE, larger), (Q::int(-1), smaller)]);
        self.decide(difference, strict)
    }

    /// `value as ty`.
    pub(super) fn cast(&mut self, cast: &syn::ExprCast) -> Option<Value> {
        let value = self.expr(&cast.expr)?;
        if self.left() {
            return Some(Value::Unit);
        }
        let ty = match &*cast.ty {
            Type::Path(p) => p.path.get_ident().map(ToString::to_string).unwrap_or_default(),
            _ => String::new(),
        };
        self.converted(cast, value, &ty)
    }

    /// A number as one of another type.
    pub(super) fn converted(
        &mut self,
        at: &impl ToTokens,
        value: Value,
        ty: &str,
    ) -> Option<Value> {
        match (value, ty) {
            (Value::Integer(id) | Value::Scalar(id), "f64") => Some(Value::Scalar(id)),
            (Value::Integer(id), _) if is_type(ty) && known(&self.graph, id).is_some_and(|n| n >= 0) => {
                Some(Value::Integer(id))
            }
            (Value::Integer(id), _) if is_type(ty) && ty.starts_with('i') => Some(Value::Integer(id)),
            (Value::Scalar(id), _) if is_type(ty) => {
                // Without a sign there is nothing below zero.
                let unsigned = ty.starts_with('u');
                let whole = match unsigned && !self.graph.range(id).nonnegative() && !self.decide(id, false) {
                    true => self.graph.int(0),
                    false => self.truncated(at, id)?,
                };
                Some(Value::Integer(whole))
            }
            (Value::Bool(b), _) if is_type(ty) => Some(Value::Integer(self.graph.int(i64::from(b)))),
            (_, "f32") => self.error(at, "all numbers of a body are real and of one precision, which whoever samples chooses, so there is nothing to cast: leave it away"),
            (value, _) => {
                let what = value.describe();
                self.error(at, format!("{what} cannot be made a `{ty}` here: numbers become `f64`, or integers"))
            }
        }
    }

    /// A method of an integer.
    pub(super) fn integer_method(
        &mut self,
        m: &ExprMethodCall,
        x: Id,
        args: &[&Expr],
    ) -> Option<Value> {
        let name = m.method.to_string();
        if let ("clone" | "into", []) = (name.as_str(), args) {
            return Some(Value::Integer(x));
        }
        let others: Option<Vec<i64>> = args
            .iter()
            .map(|a| match self.expr(a)? {
                Value::Integer(id) => self.settled(id),
                _ => None,
            })
            .collect();
        let value = self.settled(x).zip(others).and_then(|(x, others)| {
            match (name.as_str(), &others[..]) {
                ("min", [y]) => Some(x.min(*y)),
                ("max", [y]) => Some(x.max(*y)),
                ("clamp", [a, b]) if a <= b => Some(x.clamp(*a, *b)),
                ("abs", []) => x.checked_abs(),
                ("pow", [n]) => x.checked_pow(u32::try_from(*n).ok()?),
                ("rem_euclid", [n]) => x.checked_rem_euclid(*n),
                ("div_euclid", [n]) => x.checked_div_euclid(*n),
                ("saturating_sub", [n]) => Some(x.saturating_sub(*n).max(0)),
                _ => None,
            }
        });
        match value {
            Some(value) => Some(Value::Integer(self.graph.int(value))),
            None => self.error(&m.method, format!("`{name}` is not a method of integers in the language: of those that are known here there are min, max, clamp, abs, pow, rem_euclid and div_euclid; the others are of numbers, `n as f64`")),
        }
    }
}
