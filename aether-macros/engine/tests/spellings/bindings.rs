//! Spellings with more names and with fewer.

use std::collections::HashMap;

use quote::ToTokens;
use syn::visit_mut::{VisitMut, visit_expr_closure_mut, visit_expr_mut, visit_stmt_mut};
use syn::{BinOp, Block, Expr, ExprCall, ItemFn, Pat, Stmt, UnOp, parse_quote};

use crate::operands::bracketed;

/// Every `let` written out where its name was used.
pub fn inlined(mut function: ItemFn) -> ItemFn {
    Inline::default().visit_block_mut(&mut function.block);
    function
}

/// What names stand for, in terms of uniforms and parameters.
#[derive(Default)]
struct Inline(HashMap<String, Expr>);

impl Inline {
    fn bind(&mut self, pat: &Pat, value: &Expr) {
        match pat {
            Pat::Ident(p) => {
                self.0.insert(p.ident.to_string(), bracketed(value));
            }
            Pat::Type(p) => self.bind(&p.pat, value),
            Pat::Tuple(p) => {
                for (i, part) in p.elems.iter().enumerate() {
                    let index = syn::Index::from(i);
                    let whole = bracketed(value);
                    let value = match value {
                        Expr::Tuple(t) => t.elems[i].clone(),
                        _ => parse_quote!(#whole.#index),
                    };
                    self.bind(part, &value);
                }
            }
            other => panic!("no rule for the pattern {}", other.to_token_stream()),
        }
    }
}

impl VisitMut for Inline {
    fn visit_block_mut(&mut self, block: &mut Block) {
        let outer = self.0.clone();
        let mut rest = Vec::new();
        for mut stmt in std::mem::take(&mut block.stmts) {
            visit_stmt_mut(self, &mut stmt);
            match &stmt {
                Stmt::Local(local) => {
                    let value = &local.init.as_ref().expect("a value").expr;
                    self.bind(&local.pat, value);
                }
                _ => rest.push(stmt),
            }
        }
        block.stmts = rest;
        self.0 = outer;
    }

    fn visit_expr_mut(&mut self, e: &mut Expr) {
        if let Expr::Path(p) = e
            && let Some(name) = p.path.get_ident()
            && let Some(value) = self.0.get(&name.to_string())
        {
            *e = value.clone();
        } else {
            visit_expr_mut(self, e);
        }
    }

    fn visit_expr_closure_mut(&mut self, closure: &mut syn::ExprClosure) {
        let outer = self.0.clone();
        for input in &closure.inputs {
            if let Pat::Ident(p) = input {
                self.0.remove(&p.ident.to_string());
            }
        }
        visit_expr_closure_mut(self, closure);
        self.0 = outer;
    }
}

/// A `let` for every operation.
pub fn named(mut function: ItemFn) -> ItemFn {
    let block = Names::default().block(&function.block);
    function.block = Box::new(block);
    function
}

/// Takes expressions apart, and counts the names it gave.
#[derive(Default)]
struct Names(usize);

impl Names {
    fn block(&mut self, block: &Block) -> Block {
        let mut out = Vec::new();
        for stmt in &block.stmts {
            let stmt = match stmt {
                Stmt::Local(local) => {
                    let mut local = local.clone();
                    let init = local.init.as_mut().expect("a value");
                    *init.expr = self.operation(&init.expr, &mut out);
                    Stmt::Local(local)
                }
                Stmt::Expr(e, end) => Stmt::Expr(self.operation(e, &mut out), *end),
                other => panic!("no rule for the statement {}", other.to_token_stream()),
            };
            out.push(stmt);
        }
        Block { brace_token: block.brace_token, stmts: out }
    }

    /// A name for an expression, whose operations go before.
    fn name(&mut self, e: &Expr, out: &mut Vec<Stmt>) -> Expr {
        match e {
            Expr::Lit(_) | Expr::Path(_) => e.clone(),
            Expr::Paren(p) => self.name(&p.expr, out),
            Expr::Unary(u) if matches!(*u.expr, Expr::Lit(_)) => parse_quote!((#e)),
            e => {
                let value = self.operation(e, out);
                self.0 += 1;
                let name = quote::format_ident!("name{}", self.0);
                out.push(parse_quote!(let #name = #value;));
                parse_quote!(#name)
            }
        }
    }

    /// An expression with names for its operands.
    fn operation(&mut self, e: &Expr, out: &mut Vec<Stmt>) -> Expr {
        let mut e = e.clone();
        match &mut e {
            Expr::Paren(p) => return self.operation(&p.expr, out),
            Expr::Binary(b) if matches!(b.op, BinOp::And(_) | BinOp::Or(_)) => {
                for side in [&mut b.left, &mut b.right] {
                    **side = bracketed(&self.operation(side, out));
                }
            }
            Expr::Binary(b) => {
                for side in [&mut b.left, &mut b.right] {
                    **side = self.name(side, out);
                }
            }
            Expr::Unary(u) if matches!(u.op, UnOp::Not(_)) => {
                *u.expr = bracketed(&self.operation(&u.expr, out));
            }
            Expr::Unary(u) => *u.expr = self.name(&u.expr, out),
            Expr::Field(f) => *f.base = self.name(&f.base, out),
            Expr::MethodCall(m) => {
                *m.receiver = self.name(&m.receiver, out);
                m.args.iter_mut().for_each(|a| *a = self.name(a, out));
            }
            Expr::Call(c) => self.call(c, out),
            Expr::Tuple(t) => t.elems.iter_mut().for_each(|e| *e = self.name(e, out)),
            Expr::Array(a) => a.elems.iter_mut().for_each(|e| *e = self.name(e, out)),
            Expr::If(i) => {
                *i.cond = self.operation(&i.cond, out);
                i.then_branch = self.block(&i.then_branch);
                if let Some((_, other)) = &mut i.else_branch {
                    let block = self.block(&parse_quote!({ #other }));
                    **other = parse_quote!(#block);
                }
            }
            Expr::Match(m) => {
                *m.expr = self.operation(&m.expr, out);
                for arm in &mut m.arms {
                    let body = &arm.body;
                    let block = self.block(&parse_quote!({ #body }));
                    *arm.body = parse_quote!(#block);
                }
            }
            Expr::Block(b) => b.block = self.block(&b.block),
            Expr::Return(r) => {
                r.expr.iter_mut().for_each(|e| **e = self.operation(e, out));
            }
            _ => {}
        }
        e
    }

    /// The function that is solved has names of its own, and its range is part of the call.
    fn call(&mut self, call: &mut ExprCall, out: &mut Vec<Stmt>) {
        let solved = matches!(call.args.first(), Some(Expr::Closure(_)));
        let required = matches!(&*call.func, Expr::Path(p) if p.path.is_ident("require"));
        for (i, argument) in call.args.iter_mut().enumerate() {
            match argument {
                Expr::Closure(closure) => {
                    let body = &closure.body;
                    let block = self.block(&parse_quote!({ #body }));
                    *closure.body = parse_quote!(#block);
                }
                _ if solved && i == 1 => {}
                // What is required are comparisons, as in the head of an `if`.
                argument if required => *argument = self.operation(argument, out),
                argument => *argument = self.name(argument, out),
            }
        }
    }
}
