//! What names of a body stand for.

use proc_macro2::TokenStream;
use syn::Pat;

use super::Value;
use super::body::Body;
use crate::expr::{Id, Leaf, UNKNOWNS};
use crate::interval::Interval;
use crate::walk;
use crate::walk::Bound;

impl Body<'_> {
    pub(super) fn local(&mut self, local: &syn::Local) -> Option<()> {
        let Some(init) = &local.init else {
            let _ = self.bind(&local.pat, Value::Unknown);
            return self.error(local, "give this name its value at once, so that it stands for one formula: `let r = …;`, also `let r = if … { … } else { … };`");
        };
        if init.diverge.is_some() {
            self.bind_names(&local.pat);
            return self.error(local, "`let … else` has no meaning here, because every value of a body exists: write `let x = …;`. Where there is no sample, `return None;` from a function that returns an `Option`");
        }
        self.name_constant(local, &init.expr);
        let mut value = self.expr(&init.expr);
        if let (Some(Value::Unit), None) = (&value, &self.returned) {
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

    /// Makes the names of a pattern known without values, so that one mistake is reported once.
    fn bind_names(&mut self, pat: &Pat) {
        let mut bound = Bound::default();
        walk::pat(&mut bound, pat);
        self.names.extend(bound.0.into_iter().map(|name| (name, Value::Unknown)));
    }

    pub(super) fn bind(&mut self, pat: &Pat, value: Value) -> Option<()> {
        match (pat, value) {
            (Pat::Ident(p), value) => {
                self.parameters.entry(p.ident.to_string()).and_modify(|shadowed| *shadowed = true);
                if p.subpat.is_some() || p.by_ref.is_some() || p.mutability.is_some() {
                    self.names.insert(p.ident.to_string(), value);
                    return self
                        .error(p, "values do not change here, so that every name stands for one formula: use a new `let` with a new name");
                }
                self.names.insert(p.ident.to_string(), value);
                Some(())
            }
            (Pat::Type(p), value) => self.bind(&p.pat, value),
            (Pat::Paren(p), value) => self.bind(&p.pat, value),
            (Pat::Wild(_), _) => Some(()),
            (Pat::Tuple(p), Value::Unknown) => {
                let values = vec![Value::Unknown; p.elems.len()];
                self.bind_each(&p.elems, values)
            }
            (Pat::Tuple(p), Value::Tuple(values)) if p.elems.len() == values.len() => {
                self.bind_each(&p.elems, values)
            }
            (Pat::Slice(p), Value::Uniforms(ids)) if p.elems.len() == ids.len() => {
                self.bind_each(&p.elems, ids.into_iter().map(Value::Scalar).collect())
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
