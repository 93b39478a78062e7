//! What names of a body stand for.

use proc_macro2::TokenStream;
use syn::{Expr, Pat};

use super::Value;
use super::body::Body;
use crate::expr::{Id, Leaf, UNKNOWNS};
use crate::interval::Interval;
use crate::walk;
use crate::walk::Bound;

impl Body<'_> {
    pub(super) fn local(&mut self, local: &syn::Local) -> Option<()> {
        let Some(init) = &local.init else {
            // A value comes later, on each way before it is used.
            return self.bind(&local.pat, Value::Unit);
        };
        if let Some((_, otherwise)) = &init.diverge {
            return self.bind_or_leave(local, &init.expr, otherwise);
        }
        self.name_constant(local, &init.expr);
        let mut value = self.expr(&init.expr);
        if self.left() && value.is_some() {
            return Some(());
        }
        if let Some(Value::Unit) = &value {
            self.errors.error(&init.expr, "this has no value on one way through it: an `if` needs an `else`, and a block ends with its value, without a semicolon");
            value = None;
        }
        let found = value.is_some();
        if let Pat::Ident(name) = &local.pat {
            let name = name.ident.to_string();
            match &mut value {
                Some(Value::Scalar(id)) => *id = self.named_number(&name, *id),
                Some(Value::Vector(v)) => *v = self.named_vector(&name, v),
                _ => {}
            }
        }
        // Names are bound in any case, so that one mistake is reported once.
        self.bind(&local.pat, value.unwrap_or(Value::Unknown))?;
        found.then_some(())
    }

    /// The value that a named number is read with.
    fn named_number(&mut self, name: &str, value: Id) -> Id {
        if !self.graph.has(value, UNKNOWNS) {
            return value;
        }
        self.scalars.push(name.to_owned());
        if !self.cut.numbers.iter().any(|c| c == name) {
            return value;
        }
        let leaf = Leaf::Unknown(self.cut.first + self.cuts.len() as u8);
        self.cuts.push((leaf, value));
        self.graph.leaf(leaf, name, self.graph.range(value))
    }

    /// The coordinates that a named vector is read with.
    fn named_vector(&mut self, name: &str, value: &[Id]) -> Vec<Id> {
        let &[x, y, z] = value else { return value.to_vec() };
        if value.iter().any(|id| self.graph.has(*id, UNKNOWNS)) {
            return value.to_vec();
        }
        self.vectors.push((name.to_owned(), [x, y, z]));
        if !self.cut.frame.iter().any(|c| c == name) {
            return value.to_vec();
        }
        let axes = ["x", "y", "z"].iter().zip(value);
        axes.map(|(axis, &id)| {
            let leaf = Leaf::Param(super::stages::FIRST_CONSTANT + self.constants_cut.len() as u8);
            self.constants_cut.push((leaf, id));
            self.graph.leaf(leaf, &format!("{name}.{axis}"), Interval::new(-1.0, 1.0))
        })
        .collect()
    }

    /// `let pattern = value else { … };`
    fn bind_or_leave(&mut self, local: &syn::Local, value: &Expr, otherwise: &Expr) -> Option<()> {
        let pat = match &local.pat {
            Pat::Type(typed) => &*typed.pat,
            pat => pat,
        };
        let fits = self.expr(value).and_then(|value| self.fits(pat, &value));
        if fits == Some(false) {
            return self.expr(otherwise).map(|_| ());
        }
        if fits.is_none() {
            // The names are known in any case, so that one mistake is reported once.
            let mut bound = Bound::default();
            walk::pat(&mut bound, pat);
            bound.0.iter().for_each(|name| self.declare(name, Value::Unknown));
        }
        fits.map(|_| ())
    }

    pub(super) fn bind(&mut self, pat: &Pat, value: Value) -> Option<()> {
        match (pat, value) {
            (Pat::Ident(p), value) => {
                self.declare(&p.ident.to_string(), value);
                if p.subpat.is_some() || p.by_ref.is_some() {
                    return self
                        .error(p, "a name is bound to a value here: leave `ref` and `@` away");
                }
                Some(())
            }
            (Pat::Type(p), value) => self.bind(&p.pat, value),
            (Pat::Paren(p), value) => self.bind(&p.pat, value),
            (Pat::Reference(p), value) => self.bind(&p.pat, value),
            (Pat::Wild(_), _) => Some(()),
            (Pat::Tuple(p), value @ (Value::Unknown | Value::Unit)) => {
                let values = vec![value; p.elems.len()];
                self.bind_each(&p.elems, values)
            }
            (Pat::Tuple(p), Value::Tuple(values)) if p.elems.len() == values.len() => {
                self.bind_each(&p.elems, values)
            }
            (Pat::Slice(p), value) if value.elements().is_some() => {
                let mut values = value.elements().unwrap_or_default();
                // What a `..` passes over.
                if let Some(rest) = p.elems.iter().position(|p| matches!(p, Pat::Rest(_))) {
                    let after = p.elems.len() - 1 - rest;
                    if rest + after <= values.len() {
                        values.splice(rest..values.len() - after, [Value::Unit]);
                    }
                }
                if p.elems.len() != values.len() {
                    let count = values.len();
                    return self.error(p, format!("this array has {count} elements"));
                }
                self.bind_each(&p.elems, values)
            }
            (Pat::Rest(_), _) => Some(()),
            (Pat::Struct(p), Value::Vector(v)) => {
                let mut bound = Some(());
                for field in &p.fields {
                    let syn::Member::Named(name) = &field.member else { continue };
                    let Some(i) =
                        ["x", "y", "z"].iter().take(v.len()).position(|axis| name == axis)
                    else {
                        return self.error(name, format!("a vector has no `{name}`"));
                    };
                    bound = self.bind(&field.pat, Value::Scalar(v[i])).and(bound);
                }
                bound
            }
            (pat, value) => {
                let what = value.describe();
                self.error(pat, format!("{what} does not fit this pattern"))
            }
        }
    }

    /// Binds all parts of a pattern, also those after one that is wrong.
    fn bind_each(
        &mut self,
        parts: &syn::punctuated::Punctuated<Pat, syn::Token![,]>,
        values: Vec<Value>,
    ) -> Option<()> {
        let mut bound = Some(());
        for (part, value) in parts.iter().zip(values) {
            bound = self.bind(part, value).and(bound);
        }
        bound
    }
}

/// Visits every identifier of some tokens.
pub(super) fn each_name(tokens: TokenStream, visit: &mut impl FnMut(String)) {
    for tree in tokens {
        match tree {
            proc_macro2::TokenTree::Ident(i) => visit(i.to_string()),
            proc_macro2::TokenTree::Group(g) => each_name(g.stream(), visit),
            _ => {}
        }
    }
}
