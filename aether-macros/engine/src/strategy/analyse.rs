//! What depends on what: which statements wait for inversion, which random point each vertex is
//! made from, which vertices are atoms and of which kind.

mod forms;
mod statements;

use quote::ToTokens;
use syn::{Expr, Ident, Pat};

use super::names::{bare, mentioned, mentioned_in_guard};
use super::scope::{Facts, Scope, Turn};
use super::tree::{Action, Apart, Block, Body, End, Leaf, Other, Plan, Step};
use crate::diagnostics::Diagnostics;

/// Analyses a body that yields `count` vertices. `connected` is what the attribute says of every
/// vertex: whether the one before sees it.
pub fn plan(
    body: Body,
    path: &Ident,
    connected: Option<bool>,
    count: usize,
    diagnostics: &mut Diagnostics,
) -> Analysed {
    let mut analysis = Analysis {
        diagnostics,
        connected,
        count,
        calls: Vec::new(),
        choices: 0,
        leaves: 0,
        late: false,
        hoisted: 0,
        branches: 0,
        atoms: Vec::new(),
        delegates: Vec::new(),
    };
    let mut scope = Scope::default();
    scope.facts.insert(path.to_string(), Facts { path: true, ..Facts::default() });
    let plan = analysis.block(body, scope);
    let keepers = analysis.keepers();
    let Analysis { choices, late, .. } = analysis;
    Analysed { plan, apart: analysis.apart(), keepers, choices, late }
}

/// What is known of a body.
pub struct Analysed {
    /// Its tree.
    pub plan: Plan,
    /// What has to be told apart.
    pub apart: Vec<Apart>,
    /// Which vertex of a joint run keeps the value of each locally constant call.
    pub keepers: Vec<usize>,
    /// How many choices it has.
    pub choices: usize,
    /// Whether decisions depend on what was drawn.
    pub late: bool,
}

impl Analysed {
    /// Whether a vertex may come about in several ways.
    pub fn has_ways(&self) -> bool {
        self.choices > 0 || self.late
    }
}

/// An analysis under way.
pub struct Analysis<'d> {
    pub(super) diagnostics: &'d mut Diagnostics,
    pub(super) connected: Option<bool>,
    /// How many vertices the body yields at once.
    pub(super) count: usize,
    /// The locally constant calls, and which vertex of a joint run keeps each.
    pub(super) calls: Vec<(Expr, Option<usize>)>,
    /// How many choices there are so far.
    choices: usize,
    /// How many vertices there are so far.
    pub(super) leaves: usize,
    /// Whether decisions depend on what was drawn.
    late: bool,
    /// How many points have been given names.
    pub(super) hoisted: usize,
    /// How many branches there are so far.
    pub(super) branches: usize,
    /// The atoms found: how they are reached, and whether they are directions.
    pub(super) atoms: Vec<(Vec<Turn>, bool)>,
    /// The strategies found, and how they are reached.
    delegates: Vec<(Vec<Turn>, Expr)>,
}

/// Whether which of two places is reached depends on a choice that is not identified.
pub(super) fn confused(a: &[Turn], b: &[Turn]) -> bool {
    a.iter().zip(b).find(|(a, b)| a != b).is_some_and(|(a, _)| a.choice)
}

impl Analysis<'_> {
    fn block(&mut self, body: Body, mut scope: Scope) -> Plan {
        let mut steps = Vec::new();
        for step in body.steps {
            match step {
                Step::Plain(statement) => self.plain(statement, &mut scope, &mut steps),
                Step::LetElse { pat, value } => {
                    let facts = scope.of_expr(&value);
                    self.refuse_random(facts, &value, "`let .. else`");
                    self.bind(&pat, facts, &mut scope);
                    steps.push(Action::LetElse { pat, value });
                }
                Step::Bind { pat, form } => {
                    steps.extend(self.form(pat, form, &mut scope));
                }
            }
        }
        let end = self.end(body.end, scope, &mut steps);
        Block { steps, end }
    }

    fn end(
        &mut self,
        end: End<Step, Expr>,
        scope: Scope,
        steps: &mut Vec<Action>,
    ) -> End<Action, Leaf> {
        match end {
            End::Stop => End::Stop,
            End::Vertex(vertex) => self.leaf(vertex, scope, steps),
            End::Delegate { strategy, .. } => self.delegate(strategy, &scope),
            End::If { condition, then, otherwise, .. } => {
                let facts = scope.of_expr(&condition);
                let mut positive = self.turn(&scope, facts, 0);
                if facts.random
                    && bindings(&condition, &mut |pat| {
                        self.bind(pat, facts, &mut positive);
                    })
                {
                    self.refuse_random(facts, &condition, "`if let`");
                } else {
                    bindings(&condition, &mut |pat| self.bind(pat, facts, &mut positive));
                }
                let mut negative = self.turn(&scope, facts, 1);
                if facts.random {
                    self.late = true;
                    positive.needed.extend(mentioned(&condition));
                    negative.needed.extend(mentioned(&condition));
                }
                self.branches += 1;
                End::If {
                    condition,
                    late: facts.random,
                    then: Box::new(self.block(*then, positive)),
                    otherwise: Box::new(self.block(*otherwise, negative)),
                }
            }
            End::Match { value, arms } => {
                let mut facts = scope.of_expr(&value);
                for (pat, _) in &arms {
                    facts = facts.and(scope.of(&mentioned_in_guard(pat)));
                }
                self.refuse_random(facts, &value, "`match`");
                let branch = self.branches;
                self.branches += 1;
                let mut planned = Vec::new();
                for (arm, (pat, body)) in arms.into_iter().enumerate() {
                    let mut inner = scope.clone();
                    inner.turns.push(Turn { branch, arm, choice: facts.choice });
                    self.bind(&pat, scope.of_expr(&value), &mut inner);
                    planned.push((pat, self.block(body, inner)));
                }
                End::Match { value, arms: planned }
            }
        }
    }

    fn delegate(&mut self, strategy: Expr, scope: &Scope) -> End<Action, Leaf> {
        if self.count > 1 {
            self.diagnostics.error(
                &strategy,
                "the vertices of one draw are made here: only a strategy of one vertex can \
                 delegate to another one",
            );
        }
        if let Some(drawn) = &scope.drawn {
            self.diagnostics.error(
                &strategy,
                format!(
                    "`{drawn}` is drawn but another strategy makes this vertex, so its probability \
                     would have to be integrated: delegate before anything is drawn"
                ),
            );
        }
        let names = mentioned(&strategy);
        if let Some(local) = names.iter().find(|name| scope.facts.contains_key(*name)) {
            self.diagnostics.error(
                &strategy,
                format!(
                    "`{local}` is not a parameter: what another strategy reads of the path is read \
                     here too, and that must be known before the body runs. Make the strategy from \
                     the parameters alone, or take it as a parameter"
                ),
            );
        }
        self.delegates.push((scope.turns.clone(), strategy.clone()));
        let number = self.leaves;
        self.leaves += 1;
        End::Delegate { strategy, number }
    }

    /// The strategies that must not yield the same kinds of atoms as each other or the body.
    fn apart(self) -> Vec<Apart> {
        let mut all = Vec::new();
        for (i, (turns, strategy)) in self.delegates.iter().enumerate() {
            let mut add = |other| all.push(Apart { strategy: strategy.clone(), other });
            let atoms = self.atoms.iter().filter(|(others, _)| confused(turns, others));
            atoms.for_each(|(_, direction)| add(Other::Atom(*direction)));
            let before = self.delegates[..i].iter().filter(|(others, _)| confused(turns, others));
            before.for_each(|(_, other)| add(Other::Strategy(other.clone())));
        }
        all
    }

    fn turn(&self, scope: &Scope, facts: Facts, arm: usize) -> Scope {
        let mut inner = scope.clone();
        inner.turns.push(Turn { branch: self.branches, arm, choice: facts.choice });
        inner
    }

    fn refuse_random(&mut self, facts: Facts, tokens: &impl ToTokens, what: &str) {
        if facts.random {
            self.diagnostics.error(
                tokens,
                format!(
                    "{what} on a value that depends on what was drawn: a density knows the value \
                     only after inversion. Use `if` with a plain condition or \
                     `choose(coin(..))`, or read the value from the vertex, `constant(..)`"
                ),
            );
        }
    }
}

/// Calls `visit` with the patterns of the `let`s of a condition; whether there are any.
fn bindings(condition: &Expr, visit: &mut impl FnMut(&Pat)) -> bool {
    match bare(condition) {
        Expr::Let(binding) => {
            visit(&binding.pat);
            true
        }
        Expr::Binary(both) => {
            let left = bindings(&both.left, visit);
            bindings(&both.right, visit) || left
        }
        _ => false,
    }
}
