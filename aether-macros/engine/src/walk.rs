//! Walks through syntax, for what looks at expressions, names and patterns.
//!
//! The visitors of `syn` are compiled anew for each type that visits, all of their two hundred functions: for a dozen
//! types that was a tenth of this crate. Here what looks is behind a pointer, and each walk is compiled once.

use syn::visit::{self, Visit};
use syn::visit_mut::{self, VisitMut};
use syn::{Block, Expr, ExprPath, Ident, Item, Macro, Pat, PatIdent, Stmt};

/// What looks at syntax. Items within functions are not looked at: their names are their own.
pub trait Look {
    /// Looks at an expression, before its parts; returns whether these are looked at as well.
    fn expr(&mut self, _: &Expr) -> bool {
        true
    }
    /// Looks at a path that is an expression or a pattern; returns whether its parts are looked at as well.
    fn path(&mut self, _: &ExprPath) -> bool {
        true
    }
    /// Looks at a name that a pattern binds, before what is bound beside it.
    fn binding(&mut self, _: &PatIdent) {}
    /// Looks at any identifier that is seen.
    fn name(&mut self, _: &Ident) {}
    /// Looks at a call of a macro.
    fn call_of_macro(&mut self, _: &Macro) {}
}

/// Collects the names that patterns bind.
#[derive(Default)]
pub struct Bound(pub Vec<String>);

impl Look for Bound {
    fn binding(&mut self, name: &PatIdent) {
        self.0.push(name.ident.to_string());
    }
}

/// Looks at an expression and its parts.
pub fn expr(look: &mut dyn Look, expr: &Expr) {
    Walk(look).visit_expr(expr);
}

/// Looks at the parts of an expression.
pub fn within(look: &mut dyn Look, expr: &Expr) {
    visit::visit_expr(&mut Walk(look), expr);
}

/// Looks at a statement.
pub fn stmt(look: &mut dyn Look, stmt: &Stmt) {
    Walk(look).visit_stmt(stmt);
}

/// Looks at a block.
pub fn block(look: &mut dyn Look, block: &Block) {
    Walk(look).visit_block(block);
}

/// Looks at a pattern.
pub fn pat(look: &mut dyn Look, pat: &Pat) {
    Walk(look).visit_pat(pat);
}

struct Walk<'l>(&'l mut dyn Look);

impl Visit<'_> for Walk<'_> {
    fn visit_expr(&mut self, expr: &Expr) {
        if self.0.expr(expr) {
            visit::visit_expr(self, expr);
        }
    }
    fn visit_expr_path(&mut self, path: &ExprPath) {
        if self.0.path(path) {
            visit::visit_expr_path(self, path);
        }
    }
    fn visit_pat_ident(&mut self, binding: &PatIdent) {
        self.0.binding(binding);
        visit::visit_pat_ident(self, binding);
    }
    fn visit_ident(&mut self, name: &Ident) {
        self.0.name(name);
    }
    fn visit_macro(&mut self, call: &Macro) {
        self.0.call_of_macro(call);
        visit::visit_macro(self, call);
    }
    fn visit_item(&mut self, _: &Item) {}
}

/// What changes expressions: it returns whether the parts of what it leaves there are changed as well.
pub type Change<'c> = dyn FnMut(&mut Expr) -> bool + 'c;

/// Changes an expression and its parts, but for those of items.
pub fn change(change: &mut Change<'_>, expr: &mut Expr) {
    Changed(change).visit_expr_mut(expr);
}

/// The same of a block.
pub fn change_block(change: &mut Change<'_>, block: &mut Block) {
    Changed(change).visit_block_mut(block);
}

struct Changed<'c, 'f>(&'c mut Change<'f>);

impl VisitMut for Changed<'_, '_> {
    fn visit_expr_mut(&mut self, expr: &mut Expr) {
        if (self.0)(expr) {
            visit_mut::visit_expr_mut(self, expr);
        }
    }
    fn visit_item_mut(&mut self, _: &mut Item) {}
}
