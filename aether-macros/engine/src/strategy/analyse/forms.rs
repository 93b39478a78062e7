//! The special forms.

use std::collections::BTreeSet;

use proc_macro2::Span;
use quote::format_ident;
use syn::{Expr, Ident, Pat};

use super::Analysis;
use super::statements::plain_name;
use crate::strategy::names::{bound, mentioned};
use crate::strategy::scope::{Facts, Scope};
use crate::strategy::tree::{Action, Form};

impl Analysis<'_> {
    pub(super) fn form(&mut self, pat: Pat, form: Form, scope: &mut Scope) -> Option<Action> {
        match form {
            Form::Given(value) => {
                let facts = scope.of_expr(&value);
                if facts.random {
                    self.diagnostics.error(
                        &value,
                        "this depends on what was drawn: use `constant(..)`, and implement `Recall` \
                         for the vertex, so that the density can read it back",
                    );
                }
                self.bind(&pat, facts, scope);
                Some(Action::Given { pat, value })
            }
            Form::Constant(call) => {
                let facts = scope.of_expr(&call);
                let ray = facts.path && (facts.random || scope.drawn.is_none());
                let number = self.calls.len();
                self.calls.push((call.clone(), None));
                let facts = Facts {
                    calls: 1_u128.checked_shl(number as u32).unwrap_or(0),
                    random: false,
                    path: false,
                    constant: true,
                    ray: facts.ray || ray,
                    ..facts
                };
                self.bind(&pat, facts, scope);
                Some(Action::Constant { pat, call, number })
            }
            Form::Draw(sampler) => self.draw(&pat, sampler, scope),
            Form::Atom(sampler) => {
                scope.atom = true;
                self.draw(&pat, sampler, scope)
            }
            Form::Choose { distribution, rule } => self.choose(pat, distribution, rule, scope),
        }
    }

    fn draw(&mut self, pat: &Pat, sampler: Expr, scope: &mut Scope) -> Option<Action> {
        let (inner, ty) = match pat {
            Pat::Type(typed) => (&*typed.pat, Some((*typed.ty).clone())),
            other => (other, None),
        };
        let Some(name) = plain_name(inner) else {
            self.diagnostics.error(pat, "what is drawn needs a plain name: `let w = draw(..);`");
            // Goes on as if every name were the point, so as not to report what follows from this.
            for name in bound(pat) {
                scope.points.insert(name.to_string(), BTreeSet::new());
                scope.drawn = Some(name);
            }
            return None;
        };
        if let Some(before) = &scope.drawn {
            self.diagnostics.error(
                &sampler,
                format!(
                    "a second draw: this vertex is already made from `{before}`. Use one sampler of \
                     both, or maps of `{before}`"
                ),
            );
        }
        // What only shapes the distribution does not make a later call a ray from the path.
        self.bind(pat, Facts { random: true, ..Facts::default() }, scope);
        scope.drawn = Some(name.clone());
        scope.points.insert(name.to_string(), BTreeSet::new());
        Some(Action::Draw { name, ty, sampler })
    }

    fn choose(
        &mut self,
        pat: Pat,
        distribution: Expr,
        rule: Option<Expr>,
        scope: &mut Scope,
    ) -> Option<Action> {
        let random = scope.of_expr(&distribution).random;
        if let Some(rule) = &rule
            && scope.of_expr(rule).random
        {
            self.diagnostics.error(
                rule,
                "the rule tells the outcome from the vertex alone: it cannot use what was drawn",
            );
        }
        let facts = Facts { choice: rule.is_none(), ..Facts::default() };
        self.bind(&pat, facts, scope);
        let number = self.choices;
        self.choices += 1;
        if !random {
            return Some(Action::Choose { pat, distribution, rule, number });
        }
        self.late = true;
        scope.needed.extend(mentioned(&distribution));
        scope.needed.extend(bound(&pat).iter().map(Ident::to_string));
        self.hoisted += 1;
        let index = format_ident!("__outcome_{}", self.hoisted, span = Span::mixed_site());
        Some(Action::LateChoose { pat, index, distribution, rule, number })
    }
}
