//! Special forms, `return` and `?` in places where a strategy cannot have them.

use syn::{Expr, Stmt};

use super::names::{FORMS, bound, form};
use crate::diagnostics::Diagnostics;
use crate::walk::{self, Look};

/// Reports special forms and early exits within a plain expression.
pub fn check_expr(expr: &Expr, diagnostics: &mut Diagnostics) {
    walk::expr(&mut Misuse { diagnostics, place: Place::Value, body: true }, expr);
}

/// Reports special forms and early exits within a plain statement.
pub fn check_statement(statement: &Stmt, diagnostics: &mut Diagnostics) {
    walk::stmt(&mut Misuse { diagnostics, place: Place::Value, body: true }, statement);
}

/// Reports names of special forms that a pattern takes away.
pub fn check_pattern(pat: &syn::Pat, diagnostics: &mut Diagnostics) {
    for name in bound(pat).iter().filter(|name| FORMS.iter().any(|form| *name == form)) {
        diagnostics.error(
            name,
            format!("`{name}` is a special form in a strategy: give this another name"),
        );
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Place {
    Value,
    Loop,
    Closure,
}

struct Misuse<'d> {
    diagnostics: &'d mut Diagnostics,
    place: Place,
    /// Whether `return` and `?` would leave the strategy itself.
    body: bool,
}

impl Misuse<'_> {
    fn within(&mut self, place: Place, body: bool, expr: &Expr) {
        let outer = (self.place, self.body);
        (self.place, self.body) = (place, body);
        walk::within(self, expr);
        (self.place, self.body) = outer;
    }

    fn form(&mut self, name: &syn::Ident) {
        let message = match self.place {
            _ if name == "delegate" => "`delegate(..)` is the end of the path's execution: write \
                                        it alone, as the last expression or as a `return` of \
                                        the body or of an `if` or `match` of it"
                .to_owned(),
            _ if name == "stop" => "`stop()` ends the path: write it alone, as the statement \
                                    `return stop();` of the body or of an `if` or `match` of it"
                .to_owned(),
            Place::Value => format!(
                "`{name}(..)` must be all of the right side of a `let`: write `let x = \
                 {name}(..);` first, then use `x`"
            ),
            Place::Loop => format!(
                "`{name}(..)` in a loop: the number of random variables of a vertex is fixed; draw \
                 one sample with a sampler of more dimensions, or choose among the items that \
                 the loop runs over"
            ),
            Place::Closure => format!(
                "`{name}(..)` in a closure: write it as a `let` statement of the body, outside of \
                 the closure"
            ),
        };
        self.diagnostics.error(name, message);
    }
}

impl Look for Misuse<'_> {
    fn expr(&mut self, expr: &Expr) -> bool {
        if let Some((name, call)) = form(expr) {
            self.form(name);
            call.args.iter().for_each(|argument| walk::expr(self, argument));
            return false;
        }
        match expr {
            Expr::Closure(_) => self.within(Place::Closure, false, expr),
            Expr::Async(_) => self.diagnostics.error(
                expr,
                "a strategy cannot wait: call asynchronous code before, and pass its result",
            ),
            Expr::Loop(_) | Expr::While(_) | Expr::ForLoop(_) if self.place == Place::Value => {
                self.within(Place::Loop, self.body, expr);
            }
            Expr::Return(_) if self.body => self.diagnostics.error(
                expr,
                "this `return` cannot be followed when the density is derived: write it as a \
                 statement of the body or of an `if` or `match` of it",
            ),
            Expr::Try(tried) if self.body => {
                self.diagnostics.error(
                    tried.question_token,
                    "`?` has no meaning in a strategy: write `let x = given(option);` for a value \
                     that may be missing, `let x = constant(option);` for one that depends on \
                     what was drawn",
                );
                return true;
            }
            _ => return true,
        }
        false
    }
}
