//! The statements and expressions of a body.

use std::collections::HashMap;

use quote::ToTokens;
use syn::{Block, Expr, Stmt};

use super::assign::{Scope, operator};
use super::calls::Items;
use super::defined::Partial;
use super::made::Making;
use super::repeat::Leaving;
use super::stages::Cut;
use super::way::Way;
use super::{Domain, Test, Value};
use crate::diagnostics::Diagnostics;
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use crate::points::Kind;
use crate::walk::{self, Look};

/// Reads a body into a graph.
pub struct Body<'a> {
    /// The expressions.
    pub graph: Graph,
    /// Conditions `require(…)`: expressions that must be positive.
    pub requirements: Vec<Id>,
    /// What functions that are not defined everywhere were taken of.
    pub(super) partial: Vec<Partial>,
    /// The way through the comparisons.
    pub way: Way,
    /// What the item computes once.
    pub(super) making: Making,
    /// What is declared of names of the body.
    pub(super) of_names: Vec<Domain>,
    /// How many blocks deep the statement is that is being read.
    pub(super) depth: usize,
    /// What is declared of the parameters together.
    pub(super) declared: Vec<Test>,
    pub(super) names: HashMap<String, Value>,
    /// What belongs to the blocks that are being read.
    pub(super) scopes: Vec<Scope>,
    /// The constants and functions of these.
    pub(super) items: Items,
    /// How deep calls of functions of the body are within each other.
    pub(super) calls: usize,
    /// How many turns of loops there were.
    pub(super) turns: usize,
    /// A `break` or a `continue` that was met.
    pub(super) leaving: Option<Leaving>,
    /// The names of parameters, and whether they have come to stand for something else.
    pub(super) parameters: HashMap<String, bool>,
    /// Whether the operands of a comparison are being read.
    pub(super) comparing: bool,
    /// What an early `return` gave.
    pub(super) returned: Option<Value>,
    /// Numbers with a name that depend on the first parameter, in their order.
    pub(super) scalars: Vec<String>,
    /// Vectors with a name that depend on parameters alone.
    pub(super) vectors: Vec<(String, [Id; 3])>,
    /// Parameters that are whole numbers.
    pub(super) whole: Vec<Id>,
    /// What is read as inputs of their own.
    pub(super) cut: Cut,
    /// Such an unknown and what it stands for.
    pub(super) cuts: Vec<(Leaf, Id)>,
    /// Such a parameter and what it stands for.
    pub(super) constants_cut: Vec<(Leaf, Id)>,
    /// The name of the function that is read.
    pub(super) own_name: String,
    pub(super) bound: u8,
    pub(super) next_param: u8,
    pub(super) errors: &'a mut Diagnostics,
}

impl<'a> Body<'a> {
    /// A reader that knows the first parameter and takes a way through the comparisons.
    pub fn new(
        graph: Graph,
        names: HashMap<String, Value>,
        way: Way,
        errors: &'a mut Diagnostics,
    ) -> Self {
        Body {
            graph,
            requirements: vec![],
            partial: vec![],
            way,
            making: Making::default(),
            of_names: vec![],
            depth: 0,
            declared: vec![],
            names,
            scopes: vec![],
            items: Items::default(),
            calls: 0,
            turns: 0,
            leaving: None,
            parameters: HashMap::new(),
            comparing: false,
            returned: None,
            scalars: vec![],
            vectors: vec![],
            whole: vec![],
            cut: Cut::default(),
            cuts: vec![],
            constants_cut: vec![],
            own_name: String::new(),
            bound: 0,
            next_param: 0,
            errors,
        }
    }

    /// The value of a body, by its last expression or by a `return` before it.
    pub fn result(&mut self, block: &Block) -> Option<Value> {
        let value = self.block(block);
        self.returned.take().or(value)
    }

    /// Records what an early `return` gives.
    pub(super) fn leave(&mut self, value: Value) {
        self.returned.get_or_insert(value);
    }

    /// Reports an error on tokens; nothing if they are not reached, as there was a `return` before.
    pub fn error<T>(
        &mut self,
        tokens: impl ToTokens,
        message: impl core::fmt::Display,
    ) -> Option<T> {
        if !self.left() {
            self.errors.error(tokens, message);
        }
        None
    }

    /// The value of a block.
    pub fn block(&mut self, block: &Block) -> Option<Value> {
        self.depth += 1;
        let result = self.scoped(|body| body.statements(block));
        self.depth -= 1;
        result
    }

    fn statements(&mut self, block: &Block) -> Option<Value> {
        let mut result = None;
        let mut failed = self.declare_items(block).is_none();
        let last = block.stmts.len().saturating_sub(1);
        for (i, stmt) in block.stmts.iter().enumerate() {
            if self.left() {
                break;
            }
            match stmt {
                Stmt::Local(local) => failed |= self.local(local).is_none(),
                Stmt::Expr(Expr::Call(call), Some(_)) if is_call(call, "require") => {
                    failed |= self.require(call).is_none();
                }
                Stmt::Expr(e, None) if i == last => result = self.expr(e),
                Stmt::Expr(Expr::Return(r), _) => {
                    let value = r.expr.as_ref().and_then(|e| self.expr(e));
                    failed |= value.is_none();
                    self.returned = self.returned.take().or(value);
                }
                Stmt::Expr(e, _) if is_statement(e) => failed |= self.expr(e).is_none(),
                Stmt::Expr(e @ Expr::Call(call), Some(_)) if self.is_own(call) => {
                    match self.expr(e) {
                        Some(Value::Unit) => {}
                        Some(_) => {
                            failed = true;
                            self.statement(e, i == last);
                        }
                        None => failed = true,
                    }
                }
                Stmt::Item(item) => failed |= self.item(item).is_none(),
                Stmt::Macro(m) => {
                    let value = self.of_macro(&m.mac);
                    failed |= value.is_none();
                    result = value.filter(|_| i == last && m.semi_token.is_none());
                }
                Stmt::Expr(e, semicolon) if self.errors.is_empty() || i < last => {
                    failed = true;
                    self.statement(e, semicolon.is_some() && i == last);
                }
                Stmt::Expr(..) => failed = true,
            }
        }
        // What was not reached is not read.
        if self.left() && self.errors.is_empty() {
            return Some(Value::Unit);
        }
        if failed {
            return None;
        }
        if self.left() {
            return Some(Value::Unit);
        }
        let open = matches!(
            block.stmts.last(),
            Some(Stmt::Expr(_, Some(_)) | Stmt::Macro(_) | Stmt::Item(_)) | None
        );
        let open = open || self.depth > 1 && matches!(block.stmts.last(), Some(Stmt::Local(_)));
        if result.is_none() && open {
            return Some(Value::Unit);
        }
        if result.is_none() && self.errors.is_empty() {
            self.errors.error(
                block,
                "this block has no result: end it with the point, without a semicolon",
            );
        }
        result
    }

    /// Whether a call is of a closure or a function of the body.
    fn is_own(&self, call: &syn::ExprCall) -> bool {
        let Expr::Path(p) = &*call.func else { return false };
        let own = p.path.get_ident().and_then(|name| self.names.get(&name.to_string()));
        matches!(own, Some(Value::Callable(_)))
    }

    /// What is wrong with an expression as a statement.
    fn statement(&mut self, e: &Expr, last: bool) {
        let message = if last {
            "the result of the function is its last expression: leave the semicolon after it away"
        } else {
            "a value that is not used has no place in a body: give it a name with `let`, or leave it away"
        };
        self.errors.error(e, message);
    }

    /// A value computed once by plain Rust code from the parameters.
    pub fn precomputed(&mut self, code: &Expr) -> Option<Value> {
        struct Shadowed<'n>(&'n HashMap<String, bool>, Option<String>);
        impl Look for Shadowed<'_> {
            fn name(&mut self, name: &proc_macro2::Ident) {
                let name = name.to_string();
                if self.0.get(&name) == Some(&true) {
                    self.1 = Some(name);
                }
            }
        }
        let mut shadowed = Shadowed(&self.parameters, None);
        walk::expr(&mut shadowed, code);
        if let Some(name) = shadowed.1 {
            return self.error(
                code,
                format!("`{name}` is no longer the parameter here, and `precomputed` reads parameters alone: give what the body makes another name"),
            );
        }
        let name = self.making.name.take();
        let domain = name.as_ref().and_then(|name| self.domain_of_name(name));
        let range = domain.as_ref().map_or(Interval::ALL, |d| d.interval);
        let kind = Kind::Scalar(domain.as_ref().map(|d| d.interval));
        let constant = (name, kind, code.to_token_stream(), None);
        match self.constant(constant, domain, range) {
            Some(ids) => Some(Value::Scalar(ids[0])),
            None => self.error(
                code,
                "this is one number more than an item can keep: give it fewer parameters",
            ),
        }
    }
}

/// Whether an expression does something as a statement: chooses, repeats, assigns, or leaves.
fn is_statement(e: &Expr) -> bool {
    match e {
        Expr::If(_) | Expr::Match(_) | Expr::Block(_) | Expr::ForLoop(_) | Expr::While(_) => true,
        Expr::Loop(_) | Expr::Break(_) | Expr::Continue(_) | Expr::Assign(_) => true,
        Expr::Binary(b) => operator(&b.op).is_some(),
        _ => false,
    }
}

/// Whether a call is to a function of this name.
pub fn is_call(call: &syn::ExprCall, name: &str) -> bool {
    matches!(&*call.func, Expr::Path(p) if p.path.segments.last().is_some_and(|s| s.ident == name))
}
