//! Names that change: `x += k;`, `v.x = 0.0;`, `(a, b) = (b, a);`.
//!
//! On one way through the body each name has one value at each place, so that an assignment is a name for another value.
//! What a block changes of names that are not its own stays changed after it.

use std::collections::{BTreeMap, HashSet};

use quote::ToTokens;
use syn::{BinOp, Expr, ExprBinary, Member};

use super::Value;
use super::body::Body;

/// What belongs to a block.
#[derive(Default)]
pub(super) struct Scope {
    /// Names that are bound in it.
    own: HashSet<String>,
    /// Names of outside that it changes, and what they are after it.
    changed: BTreeMap<String, Value>,
}

impl Body<'_> {
    /// Reads something that has names of its own.
    pub(super) fn scoped<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> T {
        let names = self.names.clone();
        let (read, changed) = self.within(read);
        self.names = names;
        for (name, value) in changed {
            self.change(&name, value);
        }
        read
    }

    /// The same with what it changes of other names, and without putting these back.
    pub(super) fn within<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> T,
    ) -> (T, BTreeMap<String, Value>) {
        let items = self.items.clone();
        self.scopes.push(Scope::default());
        let read = read(self);
        self.items = items;
        (read, self.scopes.pop().unwrap_or_default().changed)
    }

    /// Makes a name known in the block that is being read.
    pub(super) fn declare(&mut self, name: &str, value: Value) {
        self.parameters.entry(name.to_owned()).and_modify(|shadowed| *shadowed = true);
        if let Some(scope) = self.scopes.last_mut() {
            scope.own.insert(name.to_owned());
        }
        self.names.insert(name.to_owned(), value);
    }

    fn change(&mut self, name: &str, value: Value) {
        self.parameters.entry(name.to_owned()).and_modify(|shadowed| *shadowed = true);
        if let Some(scope) = self.scopes.last_mut()
            && !scope.own.contains(name)
        {
            scope.changed.insert(name.to_owned(), value.clone());
        }
        self.names.insert(name.to_owned(), value);
    }

    /// Reads an assignment, `x = …` or `x += …`; `None` if the expression is none.
    pub(super) fn assignment(&mut self, e: &Expr) -> Option<Option<()>> {
        match e {
            Expr::Assign(a) => Some(self.assign(&a.left, &a.right)),
            Expr::Binary(b) => {
                let op = operator(&b.op)?;
                let right = Expr::Paren(syn::ExprParen {
                    attrs: vec![],
                    paren_token: Default::default(),
                    expr: b.right.clone(),
                });
                let value =
                    ExprBinary { attrs: vec![], left: b.left.clone(), op, right: Box::new(right) };
                Some(self.assign(&b.left, &Expr::Binary(value)))
            }
            _ => None,
        }
    }

    fn assign(&mut self, target: &Expr, value: &Expr) -> Option<()> {
        let value = self.expr(value)?;
        if self.left() {
            return Some(());
        }
        if let Value::Unit = value {
            return self.error(target, "what is assigned here has no value on one way through it: an `if` needs an `else`, and a block ends with its value, without a semicolon");
        }
        self.store(target, value)
    }

    fn store(&mut self, target: &Expr, value: Value) -> Option<()> {
        match (target, value) {
            (Expr::Infer(_), _) => Some(()),
            (Expr::Paren(p), value) => self.store(&p.expr, value),
            (Expr::Unary(u), value) if matches!(u.op, syn::UnOp::Deref(_)) => {
                self.store(&u.expr, value)
            }
            (Expr::Path(p), value) => {
                let name = p.path.get_ident().map(ToString::to_string).unwrap_or_default();
                if !self.names.contains_key(&name) {
                    return self.error(
                        p,
                        format!("`{name}` is not known here, and only names of the body change"),
                    );
                }
                self.change(&name, value);
                Some(())
            }
            (Expr::Tuple(t), Value::Tuple(values)) if t.elems.len() == values.len() => {
                t.elems.iter().zip(values).try_for_each(|(t, value)| self.store(t, value))
            }
            (Expr::Array(t), value)
                if value.elements().is_some_and(|v| v.len() == t.elems.len()) =>
            {
                let values = value.elements().unwrap_or_default();
                t.elems.iter().zip(values).try_for_each(|(t, value)| self.store(t, value))
            }
            (Expr::Field(f), value) => {
                let place = match &f.member {
                    Member::Named(name) => ["x", "y", "z"].iter().position(|axis| name == axis),
                    Member::Unnamed(place) => Some(place.index as usize),
                };
                self.store_part(&f.base, place, value, target)
            }
            (Expr::Index(i), value) => {
                let place = self.known_index(&i.index)?;
                self.store_part(&i.expr, Some(place), value, target)
            }
            (target, value) => {
                let what = value.describe();
                self.error(target, format!("{what} cannot be assigned to this: a name changes, or a part of one, `v.x` or `w[0]`"))
            }
        }
    }

    /// Changes a coordinate or an element.
    fn store_part(
        &mut self,
        whole: &Expr,
        place: Option<usize>,
        value: Value,
        at: &impl ToTokens,
    ) -> Option<()> {
        let mut base = self.expr(whole)?;
        if let Value::Uniforms(_) = base {
            base = Value::List(base.elements()?);
        }
        match (&mut base, place, value) {
            (Value::Vector(v), Some(i), Value::Scalar(x)) if i < v.len() => v[i] = x,
            (Value::Matrix(columns), Some(i), Value::Vector(x)) if i < 3 => columns[i] = x,
            (Value::List(all) | Value::Tuple(all), Some(i), x) if i < all.len() => all[i] = x,
            (base, ..) => {
                let what = base.describe();
                return self.error(at, format!("{what} has no such part that changes"));
            }
        }
        self.store(whole, base)
    }
}

/// The operator of `+=` and its like.
pub(super) fn operator(op: &BinOp) -> Option<BinOp> {
    Some(match op {
        BinOp::AddAssign(t) => BinOp::Add(syn::Token![+](t.spans[0])),
        BinOp::SubAssign(t) => BinOp::Sub(syn::Token![-](t.spans[0])),
        BinOp::MulAssign(t) => BinOp::Mul(syn::Token![*](t.spans[0])),
        BinOp::DivAssign(t) => BinOp::Div(syn::Token![/](t.spans[0])),
        BinOp::RemAssign(t) => BinOp::Rem(syn::Token![%](t.spans[0])),
        _ => return None,
    })
}
