//! The point that a body ends with, and what it asks of it.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{BinOp, Block, Expr};

use super::bindings::each_name;
use super::body::Body;
use super::{Space, Value};
use crate::expr::{Id, UNKNOWNS};

impl Body<'_> {
    /// `require(a > b)`: the point exists only where it holds.
    pub(super) fn require(&mut self, call: &syn::ExprCall) -> Option<()> {
        let [condition] = &call.args.iter().collect::<Vec<_>>()[..] else {
            return self.error(call, "`require` takes one condition: `require(t > 0.0)`");
        };
        self.require_all(condition)
    }

    /// One comparison, or several with `&&` between them.
    fn require_all(&mut self, condition: &Expr) -> Option<()> {
        let b = match condition {
            Expr::Paren(inner) => return self.require_all(&inner.expr),
            Expr::Binary(b) if matches!(b.op, BinOp::And(_)) => {
                let (left, right) = (self.require_all(&b.left), self.require_all(&b.right));
                return left.and(right);
            }
            Expr::Binary(b) if !matches!(b.op, BinOp::Or(_)) => b,
            _ => return self.error(condition, "`require` takes comparisons of numbers, with `&&` between them: `require(t > 0.0 && t < 1.0)`. For anything else return an `Option`, and `None` where there is no point"),
        };
        let (left, right) = (self.scalar(&b.left)?, self.scalar(&b.right)?);
        let difference = match b.op {
            BinOp::Gt(_) => self.graph.sub(left, right),
            BinOp::Lt(_) => self.graph.sub(right, left),
            _ => return self.error(b.op, "`require` takes `>` or `<`"),
        };
        self.requirements.push(difference);
        Some(())
    }

    /// Whether tokens mention a name that depends on the first parameter.
    pub fn depends(&self, tokens: &impl ToTokens) -> bool {
        let mut found = false;
        each_name(tokens.to_token_stream(), &mut |name| {
            found |= self.names.get(&name).is_some_and(|v| self.is_sampled(v));
        });
        found
    }

    /// Whether a value depends on the first parameter.
    fn is_sampled(&self, value: &Value) -> bool {
        let open = |id: &Id| self.graph.has(*id, UNKNOWNS);
        match value {
            Value::Scalar(id) | Value::Integer(id) => open(id),
            Value::Uniforms(_) => true,
            Value::Matrix(columns) => columns.iter().flatten().any(open),
            Value::Tuple(all) | Value::List(all) => all.iter().any(|v| self.is_sampled(v)),
            Value::Callable(f) => f.depends,
            Value::Mixed(_, point) => self.is_sampled(point),
            v => v.vector().is_some_and(|v| v.iter().any(open)),
        }
    }

    /// The coordinates of the result, for the space that the signature promises, and the identities of
    /// its points on surfaces.
    pub(super) fn outputs(
        &mut self,
        value: &Value,
        space: &Space,
        block: &Block,
    ) -> Option<(Vec<Id>, Vec<TokenStream>)> {
        let found = self.coordinates(value, space, block)?;
        if found.0.iter().all(|o| !self.graph.has(*o, UNKNOWNS)) {
            let at = block.stmts.last().map(ToTokens::to_token_stream).unwrap_or_default();
            return self.error(at, "on one way through the body the result does not depend on the first parameter: it is a single point (an atom), with a probability and no density. Of a sampler return `Mixed`, with `Mixed::Atom(0, point)` there and `Mixed::Continuous(x)` elsewhere. Or return `None` there, from a function that returns an `Option`, and let a `#[strategy]` choose between the point and the rest");
        }
        Some(found)
    }

    /// The same of a point that may be a single one.
    pub(super) fn coordinates(
        &mut self,
        value: &Value,
        space: &Space,
        block: &Block,
    ) -> Option<(Vec<Id>, Vec<TokenStream>)> {
        let at = block.stmts.last().map(ToTokens::to_token_stream).unwrap_or_default();
        let (mut outputs, mut identities) = (Vec::new(), Vec::new());
        let joint = match (space, value) {
            (Space::Joint(parts), Value::Tuple(values)) if parts.len() == values.len() => {
                Some(parts.iter().zip(values).map(|(s, v)| part(s, v)).collect())
            }
            (Space::Joint(_), _) => None,
            _ => Some(vec![part(space, value).or_else(|| self.direction(space, value))]),
        };
        let found: Option<Vec<_>> = joint.and_then(|parts: Vec<_>| parts.into_iter().collect());
        let Some(found) = found else {
            let what = value.describe();
            if let Space::Joint(parts) = space {
                let count = parts.len();
                let found = match value {
                    Value::Tuple(values) if values.len() != count => {
                        format!("a tuple of {}", values.len())
                    }
                    Value::Tuple(_) => "a tuple of others".to_owned(),
                    _ => what.to_owned(),
                };
                return self.error(at, format!("the signature promises {count} points, and the result is {found}: return a tuple with a point for each space of the signature, in its order"));
            }
            return self.error(at, format!("the result is {what}, and the signature promises a different space; construct it, as in `Direction::new(x, y, z)`"));
        };
        for (coordinates, identity) in found {
            outputs.extend(coordinates);
            identities.extend(identity);
        }
        Some((outputs, identities))
    }

    /// The coordinates of a parameter that is a direction, or of the opposite one.
    fn direction(
        &mut self,
        space: &Space,
        value: &Value,
    ) -> Option<(Vec<Id>, Option<TokenStream>)> {
        let v = <[Id; 3]>::try_from(value.vector()?).ok()?;
        let opposite = v.map(|c| self.graph.neg(c));
        let is_unit = |v: &[Id; 3]| self.graph.units().contains(v);
        let is_one = *space == Space::Direction && (is_unit(&v) || is_unit(&opposite));
        is_one.then(|| (v.to_vec(), None))
    }
}

/// The coordinates of one point, and its identity if it has one.
fn part(space: &Space, value: &Value) -> Option<(Vec<Id>, Option<TokenStream>)> {
    match (space, value) {
        (Space::Line, Value::Scalar(id) | Value::Integer(id)) => Some((vec![*id], None)),
        (Space::Plane, Value::Vector(v)) if v.len() == 2 => Some((v.clone(), None)),
        (Space::Volume, Value::Vector(v)) if v.len() == 3 => Some((v.clone(), None)),
        (s, Value::Point(t, v, identity)) if s == t => Some((v.clone(), identity.clone())),
        (Space::Embedded { n, .. }, Value::Point(Space::Embedded { .. }, v, _))
            if v.len() == *n =>
        {
            Some((v.clone(), None))
        }
        _ => None,
    }
}
