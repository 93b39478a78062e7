//! The parts that a body mentions more than once, by names of their own.
//!
//! Where names are written out, a body says the same, but has no names that could be a step of an inverse. They are
//! found again by what is written twice.

use std::collections::BTreeMap;

use quote::{ToTokens, format_ident};
use syn::{Expr, ItemFn, Pat, Stmt, parse_quote};

/// A part of the body: an expression whose operands are names of parts, and how often others mention it.
struct Part {
    expression: Expr,
    uses: usize,
    simple: bool,
}

/// All parts, each once, operands first; names of the body are no parts, they are what they stand for.
#[derive(Default)]
struct Parts {
    all: Vec<Part>,
    places: BTreeMap<String, usize>,
    names: BTreeMap<String, usize>,
}

/// The item with a name for all that its body mentions more than once, and for nothing else; `None` if it is more than
/// bindings and an expression, or mentions nothing twice.
pub fn shared(item: &ItemFn) -> Option<ItemFn> {
    let mut parts = Parts::default();
    let (last, bindings) = item.block.stmts.split_last()?;
    let mut statements: Vec<Stmt> = Vec::new();
    for statement in bindings {
        if let Stmt::Item(_) = statement {
            statements.push(statement.clone());
            continue;
        }
        let Stmt::Local(local) = statement else { return None };
        let value = &local.init.as_ref().filter(|init| init.diverge.is_none())?.expr;
        parts.bind(&local.pat, value)?;
    }
    let Stmt::Expr(result, None) = last else { return None };
    let result = parts.place(result)?;
    let named = |part: &Part| part.uses > 1 && !part.simple;
    if !parts.all.iter().any(named) {
        return None;
    }
    // Operands come first, so that each is spelled out by the time it is needed.
    let mut spelled: BTreeMap<String, Expr> = BTreeMap::new();
    for (place, part) in parts.all.iter().enumerate() {
        let name = name(place);
        let mut expression = part.expression.clone();
        for operand in operands(&mut expression)? {
            if let Some(value) = spelled.get(&operand.to_token_stream().to_string()) {
                *operand = value.clone();
            }
        }
        let value = if named(part) {
            statements.push(parse_quote!(let #name = #expression;));
            parse_quote!(#name)
        } else if matches!(expression, Expr::Binary(_) | Expr::Unary(_)) && place != result {
            parse_quote!((#expression))
        } else {
            expression
        };
        spelled.insert(name.to_string(), value);
    }
    let result = &spelled[&name(result).to_string()];
    statements.push(Stmt::Expr(result.clone(), None));
    let mut item = item.clone();
    item.block.stmts = statements;
    Some(item)
}

fn name(place: usize) -> syn::Ident {
    format_ident!("__part{place}")
}

impl Parts {
    fn bind(&mut self, pat: &Pat, value: &Expr) -> Option<()> {
        match (pat, value) {
            (Pat::Type(typed), _) => self.bind(&typed.pat, value),
            (Pat::Tuple(tuple), Expr::Tuple(values)) => {
                // All values first: a name may be bound again.
                let places: Option<Vec<usize>> =
                    values.elems.iter().map(|value| self.place(value)).collect();
                for (pat, place) in tuple.elems.iter().zip(places?) {
                    let Pat::Ident(one) = pat else { return None };
                    self.names.insert(one.ident.to_string(), place);
                }
                Some(())
            }
            (Pat::Ident(one), _) => {
                let place = self.place(value)?;
                self.names.insert(one.ident.to_string(), place);
                Some(())
            }
            _ => None,
        }
    }

    /// Where the part is that an expression says; `None` if it has a form that is not taken apart.
    fn place(&mut self, expression: &Expr) -> Option<usize> {
        if let Expr::Paren(inner) = expression {
            return self.place(&inner.expr);
        }
        if let Expr::Path(path) = expression
            && let Some(name) = path.path.get_ident()
            && let Some(&place) = self.names.get(&name.to_string())
        {
            return Some(place);
        }
        let mut expression = expression.clone();
        let mut mentioned = Vec::new();
        for operand in operands(&mut expression)? {
            let place = self.place(operand)?;
            mentioned.push(place);
            let name = name(place);
            *operand = parse_quote!(#name);
        }
        let key = expression.to_token_stream().to_string();
        if let Some(&place) = self.places.get(&key) {
            return Some(place);
        }
        for &place in &mentioned {
            self.all[place].uses += 1;
        }
        let simple = mentioned.is_empty()
            || matches!(expression, Expr::Field(_) | Expr::Index(_) | Expr::Unary(_))
                && mentioned.iter().all(|&place| self.all[place].simple);
        self.all.push(Part { expression, uses: 0, simple });
        self.places.insert(key, self.all.len() - 1);
        Some(self.all.len() - 1)
    }
}

/// What an expression is made of; `None` if it has a form that is not taken apart.
fn operands(expression: &mut Expr) -> Option<Vec<&mut Expr>> {
    Some(match expression {
        Expr::Lit(_) | Expr::Path(_) => vec![],
        Expr::Paren(e) => vec![&mut *e.expr],
        Expr::Unary(e) => vec![&mut *e.expr],
        Expr::Binary(e) => vec![&mut *e.left, &mut *e.right],
        Expr::Field(e) => vec![&mut *e.base],
        Expr::Index(e) => vec![&mut *e.expr],
        Expr::MethodCall(e) => core::iter::once(&mut *e.receiver).chain(&mut e.args).collect(),
        Expr::Call(e) => e.args.iter_mut().collect(),
        Expr::Tuple(e) => e.elems.iter_mut().collect(),
        _ => return None,
    })
}
