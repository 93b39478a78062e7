//! Loops over arrays and ranges that are known: the body is read once for each element.

use quote::ToTokens;
use syn::{Expr, ExprMethodCall, RangeLimits};

use super::Value;
use super::body::Body;
use crate::rational::Q;

/// How many turns the loops of a body may take together.
const MOST_TURNS: usize = 256;

/// How a turn of a loop ends before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaving {
    /// The turn.
    Turn,
    /// The loop.
    Loop,
}

impl Body<'_> {
    /// Whether what follows on this way is not read, as there was a `return`, `break` or `continue`.
    pub(super) fn left(&self) -> bool {
        self.returned.is_some() || self.leaving.is_some()
    }

    /// `for pattern in array { … }`.
    pub(super) fn repeat(&mut self, e: &syn::ExprForLoop) -> Option<Value> {
        for element in self.elements(&e.expr)? {
            self.turn(&e.expr)?;
            let turn = self.scoped(|body| {
                body.bind(&e.pat, element)?;
                body.block(&e.body)
            });
            let leaving = self.leaving.take();
            if self.returned.is_some() || leaving == Some(Leaving::Loop) {
                break;
            }
            if leaving.is_none() {
                turn?;
            }
        }
        Some(Value::Unit)
    }

    fn turn(&mut self, at: &impl ToTokens) -> Option<()> {
        self.turns += 1;
        if self.turns <= MOST_TURNS {
            return Some(());
        }
        self.error(at, format!("each turn of a loop is read by itself, and up to {MOST_TURNS} are: sample from a table, or with a `#[strategy]`, if there are more"))
    }

    /// `break` and `continue`, of the loop around.
    pub(super) fn leave_turn(&mut self, how: Leaving) -> Option<Value> {
        self.leaving = Some(how);
        Some(Value::Unit)
    }

    /// What a loop goes through.
    fn elements(&mut self, e: &Expr) -> Option<Vec<Value>> {
        let value = self.expr(e)?;
        match value.elements() {
            Some(all) => Some(all),
            None => {
                let what = value.describe();
                self.error(e, format!("a loop goes through an array, or through integers that are known here, as in `for i in 0..4`, and this is {what}"))
            }
        }
    }

    /// `low..high` as the integers between.
    pub(super) fn range_of_integers(&mut self, range: &syn::ExprRange) -> Option<Value> {
        let (Some(low), Some(high)) = (&range.start, &range.end) else {
            return self.error(range, "a range has both of its ends here");
        };
        let ends = (self.expr(low)?, self.expr(high)?);
        let ends = match ends {
            (Value::Integer(low), Value::Integer(high)) => {
                self.settled(low).zip(self.settled(high))
            }
            _ => None,
        };
        let Some((low, high)) = ends else {
            return self.error(range, "the ends of a range have to be integers that are known here, as how many steps there are decides which formula it is: write literals or constants, or declare the domain of a parameter that is an integer, `#[sampler(n in 1..=4)]`");
        };
        let high =
            if let RangeLimits::Closed(_) = range.limits { high.saturating_add(1) } else { high };
        if high.saturating_sub(low) > MOST_TURNS as i64 {
            return self.turn(range).and_then(|()| {
                self.error(range, format!("these are more than {MOST_TURNS} integers"))
            });
        }
        Some(Value::List((low..high).map(|i| Value::Integer(self.graph.int(i))).collect()))
    }

    /// A method of an array, or of what goes through one.
    pub(super) fn list_method(
        &mut self,
        m: &ExprMethodCall,
        all: Vec<Value>,
        args: &[&Expr],
    ) -> Option<Value> {
        let name = m.method.to_string();
        match (name.as_str(), args) {
            ("iter" | "into_iter" | "copied" | "cloned" | "clone" | "by_ref", []) => {
                Some(Value::List(all))
            }
            ("len" | "count", []) => Some(Value::Integer(self.graph.int(all.len() as i64))),
            ("rev", []) => Some(Value::List(all.into_iter().rev().collect())),
            ("enumerate", []) => {
                let pairs = all.into_iter().zip(0..);
                Some(Value::List(
                    pairs
                        .map(|(x, i)| Value::Tuple(vec![Value::Integer(self.graph.int(i)), x]))
                        .collect(),
                ))
            }
            ("zip", [other]) => {
                let other = self.elements(other)?;
                let pairs = all.into_iter().zip(other);
                Some(Value::List(pairs.map(|(x, y)| Value::Tuple(vec![x, y])).collect()))
            }
            ("map", [f]) => {
                let Value::Callable(f) = self.expr(f)? else {
                    return self.error(f, "`map` takes a closure here: `|x| x * x`");
                };
                let all = all.into_iter().map(|x| {
                    self.turn(m)?;
                    self.apply(m, &f, vec![x])
                });
                Some(Value::List(all.collect::<Option<_>>()?))
            }
            ("fold", [start, f]) => {
                let mut value = self.expr(start)?;
                let Value::Callable(f) = self.expr(f)? else {
                    return self.error(f, "`fold` takes a closure here: `|sum, x| sum + x`");
                };
                for x in all {
                    self.turn(m)?;
                    value = self.apply(m, &f, vec![value, x])?;
                }
                Some(value)
            }
            ("sum" | "product", []) => self.gathered(m, all, name == "sum"),
            _ => self.error(&m.method, format!("`{name}` is not a method of arrays in the language: there are len, iter, map, zip, enumerate, rev, sum, product and fold")),
        }
    }

    /// The sum of all, or their product.
    fn gathered(&mut self, m: &ExprMethodCall, all: Vec<Value>, sum: bool) -> Option<Value> {
        let whole = all.iter().all(|x| matches!(x, Value::Integer(_)));
        let ids: Option<Vec<_>> = all
            .into_iter()
            .map(|x| match x.real() {
                Value::Scalar(id) => Some(id),
                _ => None,
            })
            .collect();
        let Some(ids) = ids else {
            return self.error(m, "these are no numbers, which alone have a sum and a product here: add them in a `for`");
        };
        let mut value = self.graph.int(i64::from(!sum));
        for id in ids {
            value = match sum {
                true => self.graph.sum(Q::ZERO, &[(Q::ONE, value), (Q::ONE, id)]),
                false => self.graph.mul(value, id),
            };
        }
        Some(if whole { Value::Integer(value) } else { Value::Scalar(value) })
    }
}
