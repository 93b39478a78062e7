//! What a body reads of the path: declared to the sequence, which remembers densities by it.

use syn::visit::{self, Visit};
use syn::{Block, Expr, ExprMethodCall, Ident, Macro};

use super::names::{each_ident, variable};
use crate::diagnostics::Diagnostics;

/// What a body reads of the path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reads {
    /// How many of the last vertices; `usize::MAX` for all.
    pub vertices: usize,
    /// Whether the number of vertices.
    pub length: bool,
}

/// Derives what the body reads of the path `path`; other uses of the path are errors.
pub fn reads(body: &Block, path: &Ident, diagnostics: &mut Diagnostics) -> Reads {
    let mut uses = Uses { path, reads: Reads::default(), diagnostics };
    uses.visit_block(body);
    uses.reads
}

struct Uses<'a> {
    path: &'a Ident,
    reads: Reads,
    diagnostics: &'a mut Diagnostics,
}

impl Uses<'_> {
    fn method(&mut self, call: &ExprMethodCall) {
        match (call.method.to_string().as_str(), call.args.first()) {
            ("last", None) => self.reads.vertices = self.reads.vertices.max(1),
            ("back", Some(Expr::Lit(literal))) => {
                if let syn::Lit::Int(places) = &literal.lit
                    && let Ok(places) = places.base10_parse::<usize>()
                {
                    self.reads.vertices = self.reads.vertices.max(places.saturating_add(1));
                }
            }
            ("back", _) => self.diagnostics.error(
                &call.args,
                "how far a strategy looks back must be a literal, `path.back(1)`, because densities \
                 are remembered by what they read; `path.vertex(i)` reads any vertex",
            ),
            ("len" | "is_empty", _) => self.reads.length = true,
            ("vertex", _) => self.reads = Reads { vertices: usize::MAX, length: true },
            _ => self.diagnostics.error(
                &call.method,
                "a strategy reads its path through `last()`, `back(1)`, `len()`, `is_empty()` and \
                 `vertex(i)`",
            ),
        }
    }
}

impl Visit<'_> for Uses<'_> {
    fn visit_expr_method_call(&mut self, call: &ExprMethodCall) {
        if variable(&call.receiver) == Some(self.path) {
            self.method(call);
            call.args.iter().for_each(|argument| self.visit_expr(argument));
        } else {
            visit::visit_expr_method_call(self, call);
        }
    }

    fn visit_expr_path(&mut self, path: &syn::ExprPath) {
        if path.path.is_ident(self.path) {
            self.diagnostics.error(
                path,
                "what a strategy reads of the path must be seen here: pass the vertices that are \
                 needed (`path.last()`, `path.back(1)`), not the path",
            );
        }
    }

    fn visit_macro(&mut self, call: &Macro) {
        each_ident(call.tokens.clone(), &mut |name| {
            if name == self.path {
                let message = "the path cannot be read within a macro: bind what is needed with \
                               `let` first";
                self.diagnostics.error(name, message);
            }
        });
    }

    fn visit_item(&mut self, _: &syn::Item) {}
}
