//! How each vertex is distributed: made from which random point, or an atom of which kind.

use std::collections::BTreeSet;

use proc_macro2::Span;
use quote::{ToTokens, format_ident};
use syn::{Expr, Ident, parse_quote};

use super::analyse::{Analysis, confused};
use super::names::{each_ident, mentioned};
use super::scope::{Facts, Scope};
use super::tree::{Action, End, Kind, Leaf};
use crate::walk;

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

fn find_ident(tokens: proc_macro2::TokenStream, text: &str) -> Option<Ident> {
    let mut found = None;
    each_ident(tokens, &mut |name| {
        if name == text {
            found = Some(name.clone());
        }
    });
    found
}
