//! Ordinary statements, and maps of random points: which names they bind, and what waits for inversion.

use proc_macro2::Span;
use quote::format_ident;
use syn::{Expr, Ident, Pat, Stmt};

use super::Analysis;
use crate::strategy::names::{bare, bound, mentioned_by, pattern, referenced};
use crate::strategy::scope::{Facts, Scope};
use crate::strategy::tree::Action;

impl Analysis<'_> {
    /// Binds the names of a pattern, none of which may hide what is still needed.
    pub(super) fn bind(&mut self, pat: &Pat, facts: Facts, scope: &mut Scope) {
        crate::strategy::misuse::check_pattern(pat, self.diagnostics);
        for name in bound(pat) {
            let text = name.to_string();
            if scope.needed.contains(&text) || scope.points.contains_key(&text) {
                self.diagnostics.error(
                    &name,
                    format!(
                        "`{name}` hides a value that the density needs later: give this another \
                         name"
                    ),
                );
            }
            scope.facts.insert(text, facts);
        }
    }

    pub(super) fn plain(&mut self, statement: Stmt, scope: &mut Scope, steps: &mut Vec<Action>) {
        if let Stmt::Local(local) = &statement
            && let Some(init) = &local.init
            && let Some((map, of)) = self.map_of(&init.expr, scope, steps)
            && let Some(name) = plain_name(&local.pat)
        {
            self.mapped(name, map, of, scope, steps);
            return;
        }
        let names = mentioned_by(&statement);
        let facts = scope.of(&names);
        match &statement {
            Stmt::Local(local) => self.bind(&local.pat, facts, scope),
            // It may change what it mentions.
            _ => {
                for name in &names {
                    if let Some(known) = scope.facts.get_mut(name) {
                        *known = known.and(facts);
                    }
                }
            }
        }
        if !facts.random {
            steps.push(Action::Plain(statement));
            return;
        }
        scope.needed.extend(names);
        if let Stmt::Local(local) = &statement {
            scope.needed.extend(bound(&local.pat).iter().map(Ident::to_string));
        } else if !matches!(statement, Stmt::Macro(_)) {
            self.diagnostics.error(
                &statement,
                "this statement depends on what was drawn, which a density knows only after \
                 inversion: write it as a `let` without changing other variables",
            );
        }
        steps.push(Action::Late(statement));
    }

    /// If `expr` is a map applied to a random point: the map, and the point's name, after binding
    /// the points within it.
    pub(crate) fn map_of(
        &mut self,
        expr: &Expr,
        scope: &mut Scope,
        steps: &mut Vec<Action>,
    ) -> Option<(Expr, Ident)> {
        let Expr::MethodCall(call) = bare(expr) else { return None };
        if call.method != "apply" || call.args.len() != 1 {
            return None;
        }
        let argument = &call.args[0];
        if let Some(name) = referenced(argument) {
            let known = scope.points.contains_key(&name.to_string());
            return known.then(|| ((*call.receiver).clone(), name.clone()));
        }
        let inner = match bare(argument) {
            Expr::Reference(reference) => &reference.expr,
            other => other,
        };
        let (map, of) = self.map_of(inner, scope, steps)?;
        self.hoisted += 1;
        let name = format_ident!("__point_{}", self.hoisted, span = Span::mixed_site());
        self.mapped(name.clone(), map, of, scope, steps);
        Some(((*call.receiver).clone(), name))
    }

    /// `let name = map.apply(&of);`
    pub(crate) fn mapped(
        &mut self,
        name: Ident,
        map: Expr,
        of: Ident,
        scope: &mut Scope,
        steps: &mut Vec<Action>,
    ) {
        let facts = scope.of_expr(&map);
        if facts.random {
            self.diagnostics.error(
                &map,
                "this map depends on the drawn point that it is applied to, in more ways than \
                 through its argument: make one #[map] of both",
            );
        }
        let origin = of.to_string();
        let facts = facts.and(scope.facts.get(&origin).copied().unwrap_or_default());
        // The image is drawn, it is not what a call found.
        let facts = Facts { calls: 0, ..facts };
        let mut ancestors = scope.points.get(&origin).cloned().unwrap_or_default();
        ancestors.insert(origin);
        self.bind(&pattern(&name), Facts { random: true, path: false, ..facts }, scope);
        scope.points.insert(name.to_string(), ancestors);
        steps.push(Action::Map { name, map, of });
    }
}

/// The name that a pattern binds, if it is nothing else.
pub(super) fn plain_name(pat: &Pat) -> Option<Ident> {
    match pat {
        Pat::Ident(pat) if pat.by_ref.is_none() && pat.subpat.is_none() => Some(pat.ident.clone()),
        Pat::Type(typed) => plain_name(&typed.pat),
        _ => None,
    }
}
