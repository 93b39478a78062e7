//! What a body reads of the path: declared to the sequence, which remembers densities by it.

use proc_macro2::Span;
use quote::quote_spanned;
use syn::{
    BinOp, Block, Expr, ExprBinary, ExprMethodCall, ExprUnary, Ident, Macro, PatIdent, UnOp,
};

use super::names::{bare, each_ident, mentioned, variable};
use crate::diagnostics::Diagnostics;
use crate::walk::{self, Look};

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
    walk::block(&mut uses, body);
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

impl Look for Uses<'_> {
    fn expr(&mut self, expr: &Expr) -> bool {
        let Expr::MethodCall(call) = expr else { return true };
        if variable(&call.receiver) != Some(self.path) {
            return true;
        }
        self.method(call);
        call.args.iter().for_each(|argument| walk::expr(self, argument));
        false
    }

    fn path(&mut self, path: &syn::ExprPath) -> bool {
        if path.path.is_ident(self.path) {
            self.diagnostics.error(
                path,
                "what a strategy reads of the path must be seen here: pass the vertices that are \
                 needed (`path.last()`, `path.back(1)`), not the path",
            );
        }
        false
    }

    fn call_of_macro(&mut self, call: &Macro) {
        each_ident(call.tokens.clone(), &mut |name| {
            if name == self.path {
                let message = "the path cannot be read within a macro: bind what is needed with \
                               `let` first";
                self.diagnostics.error(name, message);
            }
        });
    }
}

/// The comparisons of the path's length with parameters, each a condition on the variable `len`, if the body asks
/// for the length in no other way: it then makes no difference as long as none of them changes.
pub fn comparisons(body: &Block, path: &Ident, parameters: &[&Ident]) -> Option<Vec<Expr>> {
    let mut lengths =
        Lengths { path, parameters, comparisons: Vec::new(), bound: Vec::new(), others: false };
    walk::block(&mut lengths, body);
    let Lengths { comparisons, bound, others, .. } = lengths;
    let rebound = |name: &String| bound.contains(name);
    let rebound = comparisons.iter().any(|(_, names)| names.iter().any(rebound));
    let few = 1..=MOST_COMPARISONS;
    let usable = !others && !rebound && few.contains(&comparisons.len());
    usable.then(|| comparisons.into_iter().map(|(condition, _)| condition).collect())
}

/// The most comparisons that are told apart.
const MOST_COMPARISONS: usize = 16;

struct Lengths<'a> {
    path: &'a Ident,
    parameters: &'a [&'a Ident],
    /// With the parameters that they mention.
    comparisons: Vec<(Expr, Vec<String>)>,
    /// Names that the body binds.
    bound: Vec<String>,
    /// Whether the length is read otherwise.
    others: bool,
}

impl Lengths<'_> {
    fn is_length(&self, expr: &Expr) -> bool {
        matches!(bare(expr), Expr::MethodCall(call)
            if variable(&call.receiver) == Some(self.path) && call.method == "len")
    }

    /// The comparison as a condition on `len`, and what else it mentions, if these are parameters only.
    fn comparison(&self, binary: &ExprBinary) -> Option<(Expr, Vec<String>)> {
        let compares = matches!(
            binary.op,
            BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Eq(_) | BinOp::Ne(_)
        );
        let mut condition = binary.clone();
        let len = syn::parse2(quote_spanned!(Span::mixed_site()=> len)).ok()?;
        let other = if self.is_length(&binary.left) {
            *condition.left = len;
            &binary.right
        } else if self.is_length(&binary.right) {
            *condition.right = len;
            &binary.left
        } else {
            return None;
        };
        let names: Vec<String> = mentioned(other).into_iter().collect();
        let known = |name: &String| self.parameters.iter().any(|parameter| *parameter == name);
        let usable = compares && names.iter().all(known) && is_harmless(other);
        usable.then(|| (Expr::Binary(condition), names))
    }
}

/// Whether an expression can be evaluated where the body would not come to it: nothing that may panic, as a quotient or a
/// difference of whole numbers does.
fn is_harmless(expr: &Expr) -> bool {
    match expr {
        Expr::Path(_) | Expr::Lit(_) => true,
        Expr::Field(field) => is_harmless(&field.base),
        Expr::Paren(inner) => is_harmless(&inner.expr),
        Expr::Group(inner) => is_harmless(&inner.expr),
        Expr::Cast(cast) => is_harmless(&cast.expr),
        Expr::Reference(of) => is_harmless(&of.expr),
        Expr::Unary(ExprUnary { op: UnOp::Deref(_), expr, .. }) => is_harmless(expr),
        _ => false,
    }
}

impl Look for Lengths<'_> {
    fn expr(&mut self, expr: &Expr) -> bool {
        match expr {
            Expr::Binary(binary) => {
                let comparison = self.comparison(binary);
                let is_other = comparison.is_none();
                self.comparisons.extend(comparison);
                is_other
            }
            Expr::MethodCall(call) => {
                self.others |= variable(&call.receiver) == Some(self.path)
                    && ["len", "is_empty", "vertex"].iter().any(|name| call.method == name);
                true
            }
            _ => true,
        }
    }

    fn binding(&mut self, pat: &PatIdent) {
        self.bound.push(pat.ident.to_string());
    }
}
