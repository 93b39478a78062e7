//! Which names a piece of syntax mentions and binds, and which special forms it contains.

use std::collections::BTreeSet;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};
use syn::{Expr, ExprCall, Ident, Macro, Pat, PatIdent, Stmt};

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
    impl Visit<'_> for Bound {
        fn visit_pat_ident(&mut self, pat: &PatIdent) {
            // `None` and constants look like bindings.
            if !pat.ident.to_string().starts_with(char::is_uppercase) {
                self.0.push(pat.ident.clone());
            }
            visit::visit_pat_ident(self, pat);
        }
        fn visit_expr(&mut self, _: &Expr) {}
    }
    let mut names = Bound(Vec::new());
    names.visit_pat(pat);
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

impl Visit<'_> for Mentions {
    fn visit_expr_path(&mut self, path: &syn::ExprPath) {
        if let Some(name) = path.path.get_ident() {
            self.0.insert(name.to_string());
        }
    }
    fn visit_macro(&mut self, call: &Macro) {
        let names = &mut self.0;
        each_ident(call.tokens.clone(), &mut |name| {
            names.insert(name.to_string());
        });
    }
    fn visit_item(&mut self, _: &syn::Item) {}
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
    names.visit_expr(expr);
    names.0
}

/// [`mentioned`], for a statement.
pub fn mentioned_by(statement: &Stmt) -> BTreeSet<String> {
    let mut names = Mentions::default();
    names.visit_stmt(statement);
    names.0
}

/// [`mentioned`], for the guard of a pattern.
pub fn mentioned_in_guard(pat: &Pat) -> BTreeSet<String> {
    let mut names = Mentions::default();
    if let Pat::Guard(guard) = pat {
        names.visit_expr(&guard.guard);
    }
    names.0
}

/// Whether evaluating the expression may meet a special form, a `return` of this function, or the
/// application of a map (perhaps to a random point), so that its branches must be told apart.
pub fn has_control(expr: &Expr) -> bool {
    struct Control(bool);
    impl Visit<'_> for Control {
        fn visit_expr(&mut self, expr: &Expr) {
            match expr {
                Expr::Closure(_) => {}
                Expr::Return(_) => self.0 = true,
                _ if form(expr).is_some() => self.0 = true,
                Expr::MethodCall(call) if call.method == "apply" && call.args.len() == 1 => {
                    self.0 = true;
                }
                _ => visit::visit_expr(self, expr),
            }
        }
        fn visit_item(&mut self, _: &syn::Item) {}
    }
    let mut control = Control(false);
    control.visit_expr(expr);
    control.0
}
