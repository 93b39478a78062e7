//! Names that a body binds again: `let t2 = r * phi.sin(); let t2 = (1.0 - s) * h + s * t2;`.
//!
//! What is told by a name is told by one of its values; so that each has a name, those after the first get another one.

use std::collections::BTreeMap;

use quote::format_ident;
use syn::{Expr, FnArg, Ident, ItemFn, Local, Pat, PatIdent, Stmt};

use crate::walk::{self, Look};

/// The item with a name of its own for each value that its bindings name.
pub fn bound_once(item: &ItemFn) -> ItemFn {
    let mut named = item.clone();
    let mut names = Names { bound: BTreeMap::new(), inner: inner_names(item) };
    for input in &item.sig.inputs {
        if let FnArg::Typed(input) = input {
            walk::pat(&mut Count(&mut names.bound), &input.pat);
        }
    }
    for statement in &mut named.block.stmts {
        match statement {
            Stmt::Local(Local { pat, init, .. }) => {
                if let Some(init) = init {
                    names.rename(&mut init.expr);
                }
                names.bind(pat);
            }
            Stmt::Expr(value, _) => names.rename(value),
            _ => {}
        }
    }
    named
}

struct Names {
    /// How often names have been bound.
    bound: BTreeMap<String, usize>,
    /// Those that are bound within expressions, which are left alone.
    inner: BTreeMap<String, usize>,
}

impl Names {
    /// The name of a value that is bound for the nth time.
    fn name(&self, name: &Ident) -> Option<Ident> {
        let text = name.to_string();
        let times = self.bound.get(&text).copied().filter(|_| !self.inner.contains_key(&text))?;
        (times > 1).then(|| format_ident!("{text}_{times}", span = name.span()))
    }

    fn rename(&self, expr: &mut Expr) {
        let change = &mut |expr: &mut Expr| {
            if let Expr::Path(path) = expr
                && let Some(name) = path.path.get_ident().and_then(|name| self.name(name))
            {
                path.path = name.into();
            }
            true
        };
        walk::change(change, expr);
    }

    fn bind(&mut self, pat: &mut Pat) {
        match pat {
            Pat::Ident(one) => {
                *self.bound.entry(one.ident.to_string()).or_default() += 1;
                if let Some(name) = self.name(&one.ident) {
                    one.ident = name;
                }
            }
            Pat::Type(typed) => self.bind(&mut typed.pat),
            Pat::Tuple(tuple) => tuple.elems.iter_mut().for_each(|pat| self.bind(pat)),
            _ => {}
        }
    }
}

/// Counts the names that are bound.
struct Count<'n>(&'n mut BTreeMap<String, usize>);

impl Look for Count<'_> {
    fn binding(&mut self, binding: &PatIdent) {
        *self.0.entry(binding.ident.to_string()).or_default() += 1;
    }
}

/// The names that are bound within the expressions of a body, and in other patterns than names and tuples of them.
fn inner_names(item: &ItemFn) -> BTreeMap<String, usize> {
    let mut inner = BTreeMap::new();
    let count = &mut Count(&mut inner);
    for statement in &item.block.stmts {
        match statement {
            Stmt::Local(local) => {
                if let Some(init) = &local.init {
                    walk::expr(count, &init.expr);
                }
                other_patterns(&local.pat, count);
            }
            other => walk::stmt(count, other),
        }
    }
    inner
}

fn other_patterns(pat: &Pat, count: &mut Count) {
    match pat {
        Pat::Ident(_) => {}
        Pat::Type(typed) => other_patterns(&typed.pat, count),
        Pat::Tuple(tuple) => tuple.elems.iter().for_each(|pat| other_patterns(pat, count)),
        other => walk::pat(count, other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quote::ToTokens;
    use syn::parse_quote;

    #[test]
    fn values_after_the_first_get_another_name() {
        let item: ItemFn = parse_quote! {
            fn f(u: [Uniform; 2], a: f64) -> f64 {
                let x = u[0] * a;
                let (x, y): (f64, f64) = (x * x, x + 1.0);
                let a = { let y = 2.0; x * y };
                let y = y - x;
                a + x * y
            }
        };
        let expected: ItemFn = parse_quote! {
            fn f(u: [Uniform; 2], a: f64) -> f64 {
                let x = u[0] * a;
                let (x_2, y): (f64, f64) = (x * x, x + 1.0);
                let a_2 = { let y = 2.0; x_2 * y };
                let y = y - x_2;
                a_2 + x_2 * y
            }
        };
        let text = |item: &ItemFn| item.to_token_stream().to_string();
        assert_eq!(text(&bound_once(&item)), text(&expected));
        assert_eq!(text(&bound_once(&expected)), text(&expected));
    }
}
