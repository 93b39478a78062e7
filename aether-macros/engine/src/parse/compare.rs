//! Comparisons and logical operators as they are written.

use syn::{BinOp, Expr, ExprBinary, Ident};

use super::body::Body;
use super::order::{assume_nonnegative, assume_order};
use super::{Test, Value};
use crate::expr::{Id, UNKNOWNS};
use crate::walk::{self, Look};

impl Body<'_> {
    /// The value of a comparison or of a logical operator; `None` if the operator is neither.
    pub(super) fn logic(&mut self, b: &ExprBinary) -> Option<Option<Value>> {
        let strict = match b.op {
            BinOp::Lt(_) | BinOp::Gt(_) => true,
            BinOp::Le(_) | BinOp::Ge(_) => false,
            BinOp::And(_) | BinOp::Or(_) => return Some(self.short_circuit(b)),
            BinOp::Eq(_) | BinOp::Ne(_) => {
                let values = self.expr(&b.left).zip(self.expr(&b.right));
                let (left, right) = match values {
                    Some(values) => values,
                    None => return Some(None),
                };
                if let Some(equal) = self.equal(&left, &right) {
                    return Some(Some(Value::Bool(equal == matches!(b.op, BinOp::Eq(_)))));
                }
                return Some(self.error(b, "whether these are equal is not told: numbers that parameters alone make are compared with `<`, `<=`, `>` or `>=`"));
            }
            _ => return None,
        };
        Some(self.comparison(b, strict))
    }

    /// What a declared relation between parameters says, made known to the graph.
    pub(super) fn relate(&mut self, b: &ExprBinary) -> Option<Test> {
        let strict = matches!(b.op, BinOp::Lt(_) | BinOp::Gt(_));
        let mut unknown = UnknownNames { known: &self.names, found: vec![], sampled: vec![] };
        [&b.left, &b.right].into_iter().for_each(|side| walk::expr(&mut unknown, side));
        if let Some(name) = unknown.sampled.first().cloned() {
            return self.error(&name, format!("a relation is between parameters, and `{name}` is what is sampled: write it as a branch of the body"));
        }
        if let Some(name) = unknown.found.first().cloned() {
            return self.error(&name, format!("`{name}` is no parameter, and a relation is between the parameters of the function: add it to them, or write its value"));
        }
        let (larger, smaller, _) = self.operands(b)?;
        let difference = self.graph.sub(larger, smaller);
        if self.graph.has(difference, UNKNOWNS) {
            return self.error(b, "a relation is between parameters: this one depends on what is sampled; write it as a branch of the body");
        }
        assume_nonnegative(&mut self.graph, difference);
        self.declared.push(Test { difference, strict });
        Some(Test { difference, strict })
    }

    fn comparison(&mut self, b: &ExprBinary, strict: bool) -> Option<Value> {
        let (larger, smaller, whole) = self.operands(b)?;
        Some(Value::Bool(match whole {
            true => self.whole_exceeds(larger, smaller, strict),
            false => self.exceeds(larger, smaller, strict),
        }))
    }

    /// Whether one number is larger than another on this way, or as large if not strict.
    pub(super) fn exceeds(&mut self, larger: Id, smaller: Id, strict: bool) -> bool {
        let difference = self.graph.sub(larger, smaller);
        let holds = self.decide(difference, strict);
        // The difference may no longer show what was compared.
        let (larger, smaller) = if holds { (larger, smaller) } else { (smaller, larger) };
        assume_order(&mut self.graph, larger, smaller);
        holds
    }

    /// What is larger and what is smaller if the comparison holds, and whether both are integers.
    fn operands(&mut self, b: &ExprBinary) -> Option<(Id, Id, bool)> {
        // Inside a comparison the size of a number is a number like any other.
        let outer = std::mem::replace(&mut self.comparing, true);
        let (left, right) = (self.expr(&b.left), self.expr(&b.right));
        self.comparing = outer;
        let (left, right) = (left?, right?);
        let whole = matches!((&left, &right), (Value::Integer(_), Value::Integer(_)));
        let (left, right) = match (left.real(), right.real()) {
            (Value::Scalar(left), Value::Scalar(right)) => (left, right),
            (Value::Vector(_) | Value::Point(..), _) | (_, Value::Vector(_) | Value::Point(..)) => {
                return self.error(b, "vectors have no order: compare coordinates, `a.x < b.x`, or lengths, `a.length() < b.length()`");
            }
            (left, right) => {
                let (left, right) = (left.describe(), right.describe());
                return self.error(
                    b,
                    format!("numbers are compared, and this compares {left} with {right}"),
                );
            }
        };
        Some(match b.op {
            BinOp::Lt(_) | BinOp::Le(_) => (right, left, whole),
            _ => (left, right, whole),
        })
    }

    fn short_circuit(&mut self, b: &ExprBinary) -> Option<Value> {
        let left = self.truth(&b.left)?;
        if left == matches!(b.op, BinOp::Or(_)) {
            return Some(Value::Bool(left));
        }
        self.truth(&b.right).map(Value::Bool)
    }

    /// The value of an expression that must be a truth value.
    pub(super) fn truth(&mut self, e: &Expr) -> Option<bool> {
        if let Expr::Let(test) = e {
            let value = self.expr(&test.expr)?;
            return self.fits(&test.pat, &value);
        }
        match self.expr(e)? {
            Value::Bool(b) => Some(b),
            Value::Unit if self.left() => Some(false),
            other => {
                let what = other.describe();
                self.error(e, format!("a comparison is needed here, and this is {what}"))
            }
        }
    }
}

/// Finds names that nothing is known of (those in capitals are constants), and uniforms.
struct UnknownNames<'n> {
    known: &'n std::collections::HashMap<String, Value>,
    found: Vec<Ident>,
    /// Names of arrays of uniforms.
    sampled: Vec<Ident>,
}

impl Look for UnknownNames<'_> {
    fn path(&mut self, path: &syn::ExprPath) -> bool {
        if let Some(name) = path.path.get_ident() {
            let text = name.to_string();
            if let Some(Value::Uniforms(_)) = self.known.get(&text) {
                self.sampled.push(name.clone());
            }
            if !self.known.contains_key(&text) && text.chars().any(char::is_lowercase) {
                self.found.push(name.clone());
            }
        }
        false
    }

    // The name of a function is none of a parameter.
    fn expr(&mut self, expr: &Expr) -> bool {
        let Expr::Call(call) = expr else { return true };
        call.args.iter().for_each(|argument| walk::expr(self, argument));
        false
    }
}
