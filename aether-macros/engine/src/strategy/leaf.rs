//! How each vertex is distributed: made from which random point, or an atom of which kind.

use std::collections::BTreeSet;

use proc_macro2::Span;
use quote::{ToTokens, format_ident};
use syn::{Expr, ExprUnary, Ident, Macro, UnOp, parse_quote};

use super::analyse::{Analysis, confused};
use super::names::{each_ident, mentioned, variable};
use super::scope::{Facts, Scope};
use super::tree::{Action, End, Kind, Leaf};
use crate::walk::{self, Look};

impl Analysis<'_> {
    /// A vertex, with the maps of random points in it bound to names before.
    pub fn leaf(
        &mut self,
        mut vertex: Expr,
        mut scope: Scope,
        steps: &mut Vec<Action>,
    ) -> End<Action, Leaf> {
        let mut applications = Applications { analysis: self, scope: &mut scope, steps };
        walk::change(&mut |expr| applications.bind(expr), &mut vertex);
        let names = mentioned(&vertex);
        let facts = scope.of(&names);
        // The vertices of a joint run may have been found by rays in whatever directions.
        let visible = self.connected.unwrap_or(facts.ray && self.count == 1);
        let kind = match scope.drawn.clone() {
            Some(drawn) => {
                let point = self.point(&vertex, &drawn, &names, &scope);
                if scope.atom {
                    self.one_atom(&vertex, facts, true, &scope);
                }
                point.map(
                    |p| if scope.atom { Kind::AtomDirection(Some(p)) } else { Kind::Density(p) },
                )
            }
            None => self.atom(&vertex, facts, &scope),
        };
        let kind = kind.filter(|kind| self.count == 1 || self.run(&vertex, kind, &scope));
        let number = self.leaves;
        self.leaves += 1;
        kind.map_or(End::Stop, |kind| End::Vertex(Leaf { vertex, kind, visible, number }))
    }

    /// The random point that a vertex is made from.
    fn point(
        &mut self,
        vertex: &Expr,
        drawn: &Ident,
        names: &BTreeSet<String>,
        scope: &Scope,
    ) -> Option<Ident> {
        let used: Vec<_> = scope.points.iter().filter(|(name, _)| names.contains(*name)).collect();
        let furthest = used.iter().max_by_key(|(_, ancestors)| ancestors.len());
        let Some((point, ancestors)) = furthest else {
            self.diagnostics.error(
                vertex,
                format!(
                    "`{drawn}` is drawn but this vertex is not made from it, so its probability \
                     would have to be integrated: use `{drawn}` or a map of it, \
                     `map.apply(&{drawn})`, in the vertex, or draw only in the branches that use \
                     it"
                ),
            );
            return None;
        };
        if let Some((other, _)) = used.iter().find(|(n, _)| n != point && !ancestors.contains(*n)) {
            self.diagnostics.error(
                vertex,
                format!(
                    "this vertex is made from two points, `{point}` and `{other}`, neither a map \
                     of the other: a vertex has one random point"
                ),
            );
        }
        if !is_kept(vertex, point) {
            self.diagnostics.error(
                vertex,
                format!(
                    "no part of this vertex is `{drawn}` itself or a map of it, and what is computed \
                     with it has another density: make the computation a `#[map]` function and use \
                     `map.apply(&{drawn})`, or draw from `sampler.then(map)`"
                ),
            );
            return None;
        }
        // The name as it is written in the source, or as hoisted: both resolve by their text.
        find_ident(vertex.to_token_stream(), point)
    }

    fn atom(&mut self, vertex: &Expr, facts: Facts, scope: &Scope) -> Option<Kind> {
        if self.count > 1 {
            self.diagnostics.error(
                vertex,
                "nothing is drawn for these vertices: they would be atoms, and several vertices of \
                 one draw have a density together. Draw a tuple of as many points, or yield the \
                 atoms one by one, each by a strategy of its own",
            );
            return None;
        }
        if !facts.constant {
            self.diagnostics.error(
                vertex,
                "nothing is drawn for this vertex: it is an atom, and whether another vertex is the \
                 same atom is never found by comparing coordinates. Bind what identifies it with \
                 `constant(Some(..))`, and implement `Recall` for the vertex type",
            );
            return None;
        }
        let direction = facts.ray && self.connected != Some(false);
        self.one_atom(vertex, facts, direction, scope);
        Some(if direction { Kind::AtomDirection(None) } else { Kind::AtomPosition })
    }

    /// Makes sure that an atom is not confused with others.
    fn one_atom(&mut self, vertex: &Expr, facts: Facts, direction: bool, scope: &Scope) {
        let mut same = self.atoms.iter().filter(|(_, other)| *other == direction);
        let confused = same.any(|(turns, _)| confused(turns, &scope.turns));
        if facts.choice || confused {
            self.diagnostics.error(
                vertex,
                "several outcomes of a choice lead to atoms, and which of them it was cannot be \
                 told by comparing coordinates: add `.identified_by(|vertex| ..)` to the \
                 `choose(..)`",
            );
        }
        self.atoms.push((scope.turns.clone(), direction));
    }
}

/// Binds the maps of random points within a vertex expression to names.
struct Applications<'a, 'd> {
    analysis: &'a mut Analysis<'d>,
    scope: &'a mut Scope,
    steps: &'a mut Vec<Action>,
}

impl Applications<'_, '_> {
    fn bind(&mut self, expr: &mut Expr) -> bool {
        match expr {
            // What is evaluated conditionally or later stays where it is.
            Expr::Closure(_) | Expr::If(_) | Expr::Match(_) | Expr::Block(_) => return false,
            _ => {}
        }
        if let Some((map, of)) = self.analysis.map_of(expr, self.scope, self.steps) {
            self.analysis.hoisted += 1;
            let count = self.analysis.hoisted;
            let name = format_ident!("__point_{}", count, span = Span::mixed_site());
            self.analysis.mapped(name.clone(), map, of, self.scope, self.steps);
            *expr = parse_quote!(#name);
            return false;
        }
        true
    }
}

/// Whether a point is a part of the vertex somewhere as it is, and not only what arithmetic or methods make of it. What is
/// passed to functions counts as a part, as they may be constructors.
fn is_kept(vertex: &Expr, point: &str) -> bool {
    struct Kept<'p> {
        point: &'p str,
        found: bool,
    }
    impl Look for Kept<'_> {
        fn expr(&mut self, expr: &Expr) -> bool {
            match expr {
                Expr::Binary(_) | Expr::Unary(ExprUnary { op: UnOp::Neg(_), .. }) => false,
                Expr::MethodCall(call) if !is_conversion(&call.method) => {
                    let own = variable(&call.receiver).is_some_and(|name| name == self.point);
                    if !own {
                        walk::expr(self, &call.receiver);
                    }
                    call.args.iter().for_each(|argument| walk::expr(self, argument));
                    false
                }
                _ => true,
            }
        }
        fn path(&mut self, path: &syn::ExprPath) -> bool {
            self.found |= path.path.is_ident(self.point);
            false
        }
        fn call_of_macro(&mut self, call: &Macro) {
            each_ident(call.tokens.clone(), &mut |name| self.found |= name == self.point);
        }
    }
    let mut kept = Kept { point, found: false };
    walk::expr(&mut kept, vertex);
    kept.found
}

/// Whether a method gives the same point as another type, by the conventions for names.
fn is_conversion(method: &Ident) -> bool {
    let name = method.to_string();
    name == "clone" || ["into", "to_", "as_"].iter().any(|start| name.starts_with(start))
}

fn find_ident(tokens: proc_macro2::TokenStream, text: &str) -> Option<Ident> {
    let mut found = None;
    each_ident(tokens, &mut |name| {
        if name == text {
            found = Some(name.clone());
        }
    });
    found
}
