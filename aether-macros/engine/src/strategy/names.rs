//! Which names a piece of syntax mentions and binds, and which special forms it contains.

use std::collections::BTreeSet;

use proc_macro2::{TokenStream, TokenTree};
use syn::{Expr, ExprCall, Ident, Macro, Pat, PatIdent, Stmt};

use crate::walk::{self, Look};

/// Names that are reserved in the body of a strategy.
pub const FORMS: [&str; 7] = ["choose", "draw", "atom", "constant", "given", "stop", "delegate"];

/// The expression without parentheses around it.
pub fn bare(mut expr: &Expr) -> &Expr {
    loop {
        expr = match expr {
            Expr::Paren(inner) => &inner.expr,
            Expr::Group(inner) => &inner.expr,
            _ => return expr,
        };
    }
}

/// The variable that an expression consists of.
pub fn variable(expr: &Expr) -> Option<&Ident> {
    match bare(expr) {
        Expr::Path(path) if path.attrs.is_empty() => path.path.get_ident(),
        _ => None,
    }
}

/// The variable in `x` or `&x`.
pub fn referenced(expr: &Expr) -> Option<&Ident> {
    match bare(expr) {
        Expr::Reference(reference) => variable(&reference.expr),
        other => variable(other),
    }
}

/// The pattern that binds a name.
pub fn pattern(name: &Ident) -> Pat {
    Pat::Ident(syn::PatIdent {
        attrs: Vec::new(),
        by_ref: None,
        mutability: None,
        ident: name.clone(),
        subpat: None,
    })
}

/// The name of the special form that is called, and the call.
pub fn form(expr: &Expr) -> Option<(&Ident, &ExprCall)> {
    let Expr::Call(call) = bare(expr) else { return None };
    let name = variable(&call.func)?;
    FORMS.iter().any(|form| name == form).then_some((name, call))
}

/// Whether this is `stop()` or `return stop()`.
pub fn is_stop(expr: &Expr) -> bool {
    match bare(expr) {
        Expr::Return(ret) => ret.expr.as_deref().is_some_and(is_stop),
        other => form(other).is_some_and(|(name, _)| name == "stop"),
    }
}

/// The strategy in `delegate(strategy)`.
pub fn delegate(expr: &Expr) -> Option<&ExprCall> {
    form(expr).filter(|(name, _)| *name == "delegate").map(|(_, call)| call)
}

/// The lower-case names that a pattern binds.
pub fn bound(pat: &Pat) -> Vec<Ident> {
    struct Bound(Vec<Ident>);
    impl Look for Bound {
        fn binding(&mut self, pat: &PatIdent) {
            // `None` and constants look like bindings.
            if !pat.ident.to_string().starts_with(char::is_uppercase) {
                self.0.push(pat.ident.clone());
            }
        }
        fn expr(&mut self, _: &Expr) -> bool {
            false
        }
    }
    let mut names = Bound(Vec::new());
    walk::pat(&mut names, pat);
    names.0
}

/// The names that the statements of a block bind.
pub fn bound_by(statements: &[Stmt]) -> Vec<Ident> {
    let lets = statements.iter().filter_map(|statement| match statement {
        Stmt::Local(local) => Some(bound(&local.pat)),
        _ => None,
    });
    lets.flatten().collect()
}

#[derive(Default)]
struct Mentions(BTreeSet<String>);

impl Look for Mentions {
    fn path(&mut self, path: &syn::ExprPath) -> bool {
        if let Some(name) = path.path.get_ident() {
            self.0.insert(name.to_string());
        }
        false
    }
    fn call_of_macro(&mut self, call: &Macro) {
        let names = &mut self.0;
        each_ident(call.tokens.clone(), &mut |name| {
            names.insert(name.to_string());
        });
    }
}

/// Calls `visit` with each identifier, within groups too.
pub fn each_ident(tokens: TokenStream, visit: &mut impl FnMut(&Ident)) {
    for token in tokens {
        match token {
            TokenTree::Ident(name) => visit(&name),
            TokenTree::Group(group) => each_ident(group.stream(), visit),
            _ => {}
        }
    }
}

/// The variables (and items with a plain name) that an expression mentions.
pub fn mentioned(expr: &Expr) -> BTreeSet<String> {
    let mut names = Mentions::default();
    walk::expr(&mut names, expr);
    names.0
}

/// [`mentioned`], for a statement.
pub fn mentioned_by(statement: &Stmt) -> BTreeSet<String> {
    let mut names = Mentions::default();
    walk::stmt(&mut names, statement);
    names.0
}

/// [`mentioned`], for the guard of a pattern.
pub fn mentioned_in_guard(pat: &Pat) -> BTreeSet<String> {
    let mut names = Mentions::default();
    if let Pat::Guard(guard) = pat {
        walk::expr(&mut names, &guard.guard);
    }
    names.0
}

/// Whether evaluating the expression may meet a special form, a `return` of this function, or the
/// application of a map (perhaps to a random point), so that its branches must be told apart.
pub fn has_control(expr: &Expr) -> bool {
    struct Control(bool);
    impl Look for Control {
        fn expr(&mut self, expr: &Expr) -> bool {
            match expr {
                Expr::Closure(_) => return false,
                Expr::Return(_) => self.0 = true,
                _ if form(expr).is_some() => self.0 = true,
                Expr::MethodCall(call) if call.method == "apply" && call.args.len() == 1 => {
                    self.0 = true;
                }
                _ => return true,
            }
            false
        }
    }
    let mut control = Control(false);
    walk::expr(&mut control, expr);
    control.0
}
