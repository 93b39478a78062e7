//! From the statements of a body to a tree: what follows a branch moves into its arms.

use proc_macro2::Span;
use quote::{format_ident, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, ExprCall, Ident, Local, Pat, Stmt, parse_quote};

use super::misuse;
use super::names::{
    bare, bound, bound_by, delegate, form, has_control, is_stop, mentioned_by, pattern,
};
use super::tree::{Block, Body, End, Form, Step};
use crate::diagnostics::Diagnostics;

/// The most vertices that a body may end in, counting each as often as it is reached by different
/// branches: what follows a branch is emitted once for each arm.
pub const MOST_ENDS: usize = 64;

/// Reads the body of a strategy; errors go to `diagnostics`.
pub fn body(statements: &[Stmt], diagnostics: &mut Diagnostics) -> Body {
    let mut parser = Parser { diagnostics, ends: 0, hoisted: 0 };
    parser.block(statements, None)
}

/// What is executed after the end of an arm.
#[derive(Clone, Copy)]
struct Then<'a> {
    /// What the value of the arm is bound to.
    bind: Option<&'a Pat>,
    rest: &'a [Stmt],
    outer: Option<&'a Then<'a>>,
}

impl Then<'_> {
    fn mentions(&self, name: &str) -> bool {
        self.rest.iter().any(|statement| mentioned_by(statement).contains(name))
            || self.outer.is_some_and(|outer| outer.mentions(name))
    }
}

struct Parser<'d> {
    diagnostics: &'d mut Diagnostics,
    ends: usize,
    hoisted: usize,
}

impl Parser<'_> {
    fn block(&mut self, statements: &[Stmt], then: Option<&Then>) -> Body {
        let mut steps = Vec::new();
        for (i, statement) in statements.iter().enumerate() {
            let rest = &statements[i + 1..];
            let end = match statement {
                Stmt::Local(local) => self.local(local, rest, then, &mut steps),
                Stmt::Expr(expr, semi) => {
                    let last = rest.is_empty() && semi.is_none();
                    if matches!(bare(expr), Expr::Return(_)) || is_stop(expr) {
                        Some(self.end(expr, None))
                    } else if last {
                        Some(self.end(expr, then))
                    } else if branches(expr) && has_control(expr) {
                        Some(self.end(expr, Some(&Then { bind: None, rest, outer: then })))
                    } else {
                        self.plain(statement, &mut steps);
                        None
                    }
                }
                _ => {
                    self.plain(statement, &mut steps);
                    None
                }
            };
            if let Some(mut end) = end {
                steps.append(&mut end.steps);
                return Block { steps, end: end.end };
            }
        }
        self.fall_through(statements, steps, then)
    }

    /// A block whose last statement has no value.
    fn fall_through(
        &mut self,
        statements: &[Stmt],
        mut steps: Vec<Step>,
        then: Option<&Then>,
    ) -> Body {
        let end = match then {
            Some(Then { bind: None, rest, outer }) => {
                let mut after = self.block(rest, *outer);
                steps.append(&mut after.steps);
                after.end
            }
            _ => {
                let message = "the strategy ends here without a vertex: end with an expression of \
                               the vertex type, or with `return stop();`";
                match statements.last() {
                    Some(last) => self.diagnostics.error(last, message),
                    None => self.diagnostics.push(syn::Error::new(Span::call_site(), message)),
                }
                End::Stop
            }
        };
        Block { steps, end }
    }

    fn local(
        &mut self,
        local: &Local,
        rest: &[Stmt],
        then: Option<&Then>,
        steps: &mut Vec<Step>,
    ) -> Option<Body> {
        let Some(init) = &local.init else {
            self.plain(&Stmt::Local(local.clone()), steps);
            return None;
        };
        if let Some((_, otherwise)) = &init.diverge {
            if !only_stops(otherwise) {
                self.diagnostics.error(
                    otherwise,
                    "what comes after `let .. else` must be `{ return stop(); }`: to do something \
                     else there, write a `match`",
                );
            }
            misuse::check_expr(&init.expr, self.diagnostics);
            steps.push(Step::LetElse { pat: local.pat.clone(), value: (*init.expr).clone() });
            return None;
        }
        if branches(&init.expr) && has_control(&init.expr) {
            let then = Then { bind: Some(&local.pat), rest, outer: then };
            return Some(self.end(&init.expr, Some(&then)));
        }
        steps.push(self.bind(&local.pat, &init.expr));
        None
    }

    /// An expression in whose value the body ends, or that `then` goes on with.
    fn end(&mut self, expr: &Expr, then: Option<&Then>) -> Body {
        if is_stop(expr) {
            return Block { steps: Vec::new(), end: End::Stop };
        }
        match bare(expr) {
            // Nothing in it ends the path or draws: it is one value however it branches.
            value if then.is_some() && !has_control(value) => self.value(value, then),
            Expr::Return(ret) => match &ret.expr {
                Some(value) => self.end(value, None),
                None => self.fall_through(&[Stmt::Expr(expr.clone(), None)], Vec::new(), None),
            },
            Expr::Block(block) if block.label.is_none() => {
                self.arm(&bound_by(&block.block.stmts), &block.block.stmts, then)
            }
            Expr::If(branch) => {
                let mut steps = Vec::new();
                let condition = self.hoist(&branch.cond, &mut steps);
                let mut names = condition_names(&condition);
                names.extend(bound_by(&branch.then_branch.stmts));
                let positive = self.arm(&names, &branch.then_branch.stmts, then);
                let otherwise = match &branch.else_branch {
                    Some((_, otherwise)) => self.end(otherwise, then),
                    None => self.fall_through(&[Stmt::Expr(expr.clone(), None)], Vec::new(), then),
                };
                let (then, otherwise) = (Box::new(positive), Box::new(otherwise));
                Block { steps, end: End::If { condition, late: false, then, otherwise } }
            }
            Expr::Match(branch) => {
                let mut steps = Vec::new();
                let value = self.hoist(&branch.expr, &mut steps);
                let mut arms = Vec::new();
                for arm in &branch.arms {
                    if let Pat::Guard(guard) = &arm.pat {
                        misuse::check_expr(&guard.guard, self.diagnostics);
                    }
                    let body = [Stmt::Expr((*arm.body).clone(), None)];
                    arms.push((arm.pat.clone(), self.arm(&bound(&arm.pat), &body, then)));
                }
                Block { steps, end: End::Match { value, arms } }
            }
            value => self.value(value, then),
        }
    }

    /// A value without branches.
    fn value(&mut self, value: &Expr, then: Option<&Then>) -> Body {
        let Some(then) = then else {
            let delegated = delegate(value);
            if delegated.is_none() {
                misuse::check_expr(value, self.diagnostics);
            }
            self.ends += 1;
            if self.ends == MOST_ENDS + 1 {
                self.diagnostics.error(
                    value,
                    format!(
                        "more than {MOST_ENDS} ways through this strategy: each branch repeats what \
                         follows it, so put branches without special forms into functions of \
                         their own"
                    ),
                );
            }
            let end = match delegated {
                _ if self.ends > MOST_ENDS => End::Stop,
                Some(call) => self.delegate(call),
                None => End::Vertex(value.clone()),
            };
            return Block { steps: Vec::new(), end };
        };
        let step = match then.bind {
            Some(pat) => self.bind(pat, value),
            None => {
                misuse::check_expr(value, self.diagnostics);
                Step::Plain(Stmt::Expr(value.clone(), Some(Default::default())))
            }
        };
        let mut after = self.block(then.rest, then.outer);
        after.steps.insert(0, step);
        after
    }

    fn delegate(&mut self, call: &ExprCall) -> End<Step, Expr> {
        let name = Ident::new("delegate", call.func.span());
        self.argument(&name, &call.args)
            .map_or(End::Stop, |strategy| End::Delegate { strategy, number: 0 })
    }

    /// An arm of a branch, whose names must not be confused with those of what follows it.
    fn arm(&mut self, names: &[Ident], statements: &[Stmt], then: Option<&Then>) -> Body {
        for name in names {
            if then.is_some_and(|then| then.mentions(&name.to_string())) {
                self.diagnostics.error(
                    name,
                    format!(
                        "`{name}` is also a name in what follows this branch: give it another name \
                         here"
                    ),
                );
            }
        }
        self.block(statements, then)
    }

    fn plain(&mut self, statement: &Stmt, steps: &mut Vec<Step>) {
        misuse::check_statement(statement, self.diagnostics);
        steps.push(Step::Plain(statement.clone()));
    }

    /// `let pat = expr;`
    fn bind(&mut self, pat: &Pat, expr: &Expr) -> Step {
        match self.form(expr) {
            Some(form) => Step::Bind { pat: pat.clone(), form },
            None => {
                misuse::check_expr(expr, self.diagnostics);
                Step::Plain(parse_quote!(let #pat = #expr;))
            }
        }
    }

    /// The special form that `expr` is, apart from `stop`.
    fn form(&mut self, expr: &Expr) -> Option<Form> {
        if let Expr::MethodCall(call) = bare(expr)
            && call.method == "identified_by"
            && let Some((name, choice)) = form(&call.receiver)
            && name == "choose"
        {
            let distribution = self.argument(name, &choice.args)?;
            let rule = self.argument(&call.method, &call.args)?;
            return Some(Form::Choose { distribution, rule: Some(rule) });
        }
        let (name, call) = form(expr)?;
        if name == "stop" || name == "delegate" {
            return None;
        }
        if name == "atom" {
            return self.atom(name, call);
        }
        let argument = self.argument(name, &call.args)?;
        Some(match name.to_string().as_str() {
            "choose" => Form::Choose { distribution: argument, rule: None },
            "draw" => Form::Draw(argument),
            "constant" => Form::Constant(argument),
            _ => Form::Given(argument),
        })
    }

    fn atom(&mut self, name: &Ident, call: &ExprCall) -> Option<Form> {
        let [direction, measure] = [call.args.first()?, call.args.last()?];
        if call.args.len() != 2 {
            let message = format!(
                "`{name}` takes a direction, and the measure in which atoms are stated there per \
                 solid angle"
            );
            self.diagnostics.error(name, message);
        }
        call.args.iter().for_each(|argument| misuse::check_expr(argument, self.diagnostics));
        let sampler = quote_spanned!(Span::mixed_site()=> ::aether_core::strategy::Atom::new);
        Some(Form::Atom(parse_quote!(#sampler(#direction, #measure))))
    }

    fn argument(
        &mut self,
        name: &Ident,
        arguments: &syn::punctuated::Punctuated<Expr, syn::Token![,]>,
    ) -> Option<Expr> {
        if arguments.len() != 1 {
            let message = format!("`{name}` takes one argument, not {}", arguments.len());
            self.diagnostics.error(name, message);
        }
        let argument = arguments.first()?;
        misuse::check_expr(argument, self.diagnostics);
        Some(argument.clone())
    }

    /// `if choose(..)`, `if !choose(..)`, `match *choose(..)`: binds the form to a name first.
    fn hoist(&mut self, expr: &Expr, steps: &mut Vec<Step>) -> Expr {
        let expr = bare(expr);
        if let Expr::Unary(unary) = expr {
            let (operator, operand) = (&unary.op, self.hoist(&unary.expr, steps));
            return parse_quote!(#operator #operand);
        }
        let Some(form) = self.form(expr) else {
            misuse::check_expr(expr, self.diagnostics);
            return expr.clone();
        };
        self.hoisted += 1;
        let name = format_ident!("__chosen_{}", self.hoisted, span = Span::mixed_site());
        steps.push(Step::Bind { pat: pattern(&name), form });
        parse_quote!(#name)
    }
}

/// Whether execution may take different ways through the expression.
fn branches(expr: &Expr) -> bool {
    matches!(bare(expr), Expr::If(_) | Expr::Match(_) | Expr::Block(_))
}

/// Whether the expression does nothing but end the path.
fn only_stops(expr: &Expr) -> bool {
    match bare(expr) {
        Expr::Block(block) => match block.block.stmts.as_slice() {
            [Stmt::Expr(only, _)] => only_stops(only),
            _ => false,
        },
        other => is_stop(other),
    }
}

/// The names that the `let`s of a condition bind.
fn condition_names(condition: &Expr) -> Vec<Ident> {
    match bare(condition) {
        Expr::Let(binding) => bound(&binding.pat),
        Expr::Binary(both) => {
            let mut names = condition_names(&both.left);
            names.extend(condition_names(&both.right));
            names
        }
        _ => Vec::new(),
    }
}
