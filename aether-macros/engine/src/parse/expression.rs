//! The expressions of a body.

use syn::{Expr, Lit, Member, UnOp};

use super::Value;
use super::assign::operator;
use super::body::Body;
use super::repeat::Leaving;
use super::special::{limit, number};
use super::{functions, methods, operators};
use super::{vectors, whole};
use crate::expr::Id;
use crate::rational::Q;

/// What paths of constants are made of.
const CONSTANTS: [&str; 7] = ["std", "core", "f64", "f32", "consts", "aether_core", "prelude"];

impl Body<'_> {
    /// The value of an expression that must be a number.
    pub fn scalar(&mut self, e: &Expr) -> Option<Id> {
        match self.expr(e)? {
            Value::Scalar(id) | Value::Integer(id) => Some(id),
            // Nothing of what follows on this way is looked at.
            Value::Unit if self.left() => Some(self.graph.int(0)),
            Value::Uniforms(_) => {
                self.error(e, "this is the array of all uniforms; take one of them: `u[0]`")
            }
            other => {
                let what = other.describe();
                self.error(e, format!("a number is needed here, and this is {what}"))
            }
        }
    }

    /// The value of an expression.
    pub fn expr(&mut self, e: &Expr) -> Option<Value> {
        if self.is_made(e) { self.made(e) } else { self.read(e) }
    }

    /// The value of an expression as it is written.
    pub(super) fn read(&mut self, e: &Expr) -> Option<Value> {
        match e {
            Expr::Lit(l) => self.literal(&l.lit),
            Expr::Paren(p) => self.expr(&p.expr),
            Expr::Group(p) => self.expr(&p.expr),
            Expr::Reference(r) if r.mutability.is_some() => {
                self.error(r, "names change here by assignment alone, not through a reference: write `x = f(x);` for `f(&mut x);`")
            }
            Expr::Reference(r) => self.expr(&r.expr),
            Expr::Block(b) if b.label.is_none() => self.block(&b.block),
            Expr::Path(p) => self.path(p),
            Expr::Unary(u) => self.unary(u),
            Expr::Binary(b) => self.binary(b),
            Expr::Index(i) => self.index(i),
            Expr::Field(f) => self.field(f),
            Expr::Tuple(t) => Some(Value::Tuple(t.elems.iter().map(|e| self.expr(e)).collect::<Option<_>>()?)),
            Expr::Array(a) => Some(Value::List(a.elems.iter().map(|e| self.expr(e)).collect::<Option<_>>()?)),
            Expr::Repeat(r) => {
                let (value, count) = (self.expr(&r.expr)?, self.known_index(&r.len)?);
                Some(Value::List(vec![value; count]))
            }
            Expr::MethodCall(m) => methods::method(self, m),
            Expr::Call(c) => functions::call(self, c),
            Expr::Struct(s) => vectors::literal(self, s),
            Expr::Cast(c) => self.cast(c),
            Expr::Range(r) => self.range_of_integers(r),
            Expr::If(e) => self.branch(e),
            Expr::Match(e) => self.choice(e),
            Expr::Try(e) => self.tried(e),
            Expr::Let(_) => self.truth(e).map(Value::Bool),
            Expr::Closure(f) => self.closure(f),
            Expr::ForLoop(e) => self.repeat(e),
            Expr::Assign(_) => self.assignment(e)?.map(|()| Value::Unit),
            Expr::Break(b) if b.label.is_none() && b.expr.is_none() => self.leave_turn(Leaving::Loop),
            Expr::Continue(c) if c.label.is_none() => self.leave_turn(Leaving::Turn),
            Expr::Return(r) => {
                let value = r.expr.as_ref().and_then(|e| self.expr(e))?;
                self.leave(value);
                Some(Value::Unit)
            }
            Expr::While(_) | Expr::Loop(_) => {
                self.error(e, "a loop that goes on until something holds has no formula: with a known number of steps write `for i in 0..8`; what is accepted or rejected at random has a density that nobody knows in general")
            }
            Expr::Macro(m) => self.of_macro(&m.mac),
            other => self.error(other, "this expression has no meaning in a sampler or map; use numbers, vectors, `let` and the functions of the language"),
        }
    }

    fn literal(&mut self, lit: &Lit) -> Option<Value> {
        let suffix = match lit {
            Lit::Float(f) => f.suffix(),
            Lit::Int(i) => i.suffix(),
            _ => "",
        };
        let whole = matches!(lit, Lit::Int(_)) && suffix != "f64";
        if !matches!(suffix, "" | "f64") && !whole::is_type(suffix) {
            return self.error(lit, "all numbers of a body are of one precision, which whoever samples chooses: leave the suffix of this literal away");
        }
        let text = match lit {
            Lit::Float(f) => f.base10_digits().to_owned(),
            Lit::Int(i) => i.base10_digits().to_owned(),
            Lit::Bool(b) => return Some(Value::Bool(b.value)),
            other => return self.error(other, "only numbers can be used here"),
        };
        let id = match Q::decimal(&text) {
            Some(q) => self.graph.number(q),
            None => match text.parse::<f64>() {
                Ok(x) if x.is_finite() => self.graph.float(x),
                _ => return self.error(lit, "this number is out of range"),
            },
        };
        Some(if whole { Value::Integer(id) } else { Value::Scalar(id) })
    }

    fn path(&mut self, p: &syn::ExprPath) -> Option<Value> {
        let name = p.path.segments.last().map(|s| s.ident.to_string())?;
        if name == "None" {
            return Some(Value::Nothing);
        }
        if p.path.segments.len() == 1
            && let Some(v) = self.names.get(&name)
        {
            return match v.clone() {
                Value::Unknown => None,
                Value::Flag(id) => {
                    // Which of the two it is, a way through the body tells.
                    let margin = self.graph.sum(Q::HALF.neg(), &[(Q::ONE, id)]);
                    Some(Value::Bool(self.decide(margin, true)))
                }
                value => Some(value),
            };
        }
        if let [.., owner, _] = &p.path.segments.iter().collect::<Vec<_>>()[..]
            && let Some(v) = axis(&owner.ident.to_string(), &name)
        {
            return Some(Value::Vector(v.iter().map(|&c| self.graph.int(c)).collect()));
        }
        let before = p.path.segments.iter().rev().skip(1);
        let mut modules = before.map(|segment| segment.ident.to_string());
        if let Some(module) = modules.find(|name| !CONSTANTS.contains(&name.as_str())) {
            return self.error(
                p,
                format!("`{name}` of `{module}` is not known here: a body sees its parameters, its own `let`s and the constants of `std::f64::consts`; pass anything else as a parameter"),
            );
        }
        let of_type = p.path.segments.iter().rev().nth(1).is_some_and(|s| s.ident == "f64");
        if of_type && matches!(name.as_str(), "INFINITY" | "NEG_INFINITY" | "NAN") {
            return self.error(p, format!("`{name}` is no number to compute with, and a point is never compared with it: leave the bound away, `x.max(0.0)` for `x.clamp(0.0, f64::INFINITY)`"));
        }
        if let Some(id) = limit(&mut self.graph, &name).filter(|_| of_type) {
            return Some(Value::Scalar(id));
        }
        let Some(id) = number(&mut self.graph, &name) else {
            return self.error(
                p,
                format!("`{name}` is not known here: a body sees its parameters, its own `let`s and the constants of `std::f64::consts`; pass anything else as a parameter"),
            );
        };
        Some(Value::Scalar(id))
    }

    fn unary(&mut self, u: &syn::ExprUnary) -> Option<Value> {
        match u.op {
            UnOp::Neg(_) => {
                let minus = self.graph.int(-1);
                let v = self.expr(&u.expr)?;
                if let Value::Integer(n) = v {
                    return Some(Value::Integer(self.graph.neg(n)));
                }
                operators::scale(self, &u.expr, v, minus)
            }
            UnOp::Deref(_) => self.expr(&u.expr),
            _ => self.truth(&u.expr).map(|b| Value::Bool(!b)),
        }
    }

    fn binary(&mut self, b: &syn::ExprBinary) -> Option<Value> {
        if let Some(value) = self.logic(b) {
            return value;
        }
        if operator(&b.op).is_some() {
            return self.assignment(&Expr::Binary(b.clone()))?.map(|()| Value::Unit);
        }
        let left = self.expr(&b.left);
        let right = self.expr(&b.right);
        let (left, right) = (left?, right?);
        operators::binary(self, b, left, right)
    }

    fn index(&mut self, i: &syn::ExprIndex) -> Option<Value> {
        let base = self.expr(&i.expr)?;
        let n = self.known_index(&i.index)?;
        if let Value::List(values) = &base {
            return match values.get(n) {
                Some(value) => Some(value.clone()),
                None => {
                    let len = values.len();
                    self.error(&i.index, format!("there are only {len} of these, counted from 0"))
                }
            };
        }
        let list = match &base {
            Value::Uniforms(v) | Value::Vector(v) => v,
            other => {
                let what = other.describe();
                return self.error(i, format!("{what} cannot be indexed"));
            }
        };
        match list.get(n) {
            Some(id) => Some(Value::Scalar(*id)),
            None => {
                let len = list.len();
                self.error(&i.index, format!("there are only {len} of these, counted from 0"))
            }
        }
    }

    fn field(&mut self, f: &syn::ExprField) -> Option<Value> {
        let base = self.expr(&f.base)?;
        let name = match &f.member {
            Member::Named(n) => n.to_string(),
            Member::Unnamed(n) => n.index.to_string(),
        };
        let place = ["x", "y", "z"].iter().position(|c| *c == name);
        match (&base, place) {
            (Value::Matrix(columns), Some(i)) => Some(Value::Vector(columns[i].clone())),
            (Value::Tuple(v), None) if name.parse::<usize>().is_ok_and(|i| i < v.len()) => {
                Some(v[name.parse::<usize>().ok()?].clone())
            }
            (base, Some(i)) if base.vector().is_some_and(|v| i < v.len()) => {
                base.vector().map(|v| Value::Scalar(v[i]))
            }
            (base, _) => {
                let what = base.describe();
                self.error(&f.member, format!("{what} has no `{name}`"))
            }
        }
    }
}

/// A constant of a type of vectors.
fn axis(owner: &str, name: &str) -> Option<Vec<i64>> {
    let count = match owner {
        "Vec2" => 2,
        "Vec3" => 3,
        _ => return None,
    };
    if name == "ZERO" {
        return Some(vec![0; count]);
    }
    let place = ["X", "Y", "Z"].iter().take(count).position(|axis| *axis == name)?;
    Some((0..count).map(|i| i64::from(i == place)).collect())
}
