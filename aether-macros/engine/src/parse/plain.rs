//! Bodies whose names change, as bodies whose names are bound again: `x += k;` is `let x = x + (k);`.
//!
//! That holds for statements of the body itself. What is told by names (`rebound.rs`, `stages.rs`) sees bindings alone then;
//! statements within blocks are read as they are (`assign.rs`).

use quote::ToTokens;
use syn::{Expr, ItemFn, Pat, Stmt, parse_quote};

use super::assign::operator;
use super::macros::is_only_checked;

/// The item with bindings in the place of assignments, and without what is checked only.
pub fn plain(item: &ItemFn) -> ItemFn {
    let mut item = item.clone();
    item.block.stmts.retain(|stmt| !matches!(stmt, Stmt::Macro(m) if is_only_checked(&m.mac)));
    for stmt in &mut item.block.stmts {
        if let Stmt::Expr(e, Some(_)) = stmt
            && let Some(binding) = binding(e)
        {
            *stmt = binding;
        }
    }
    item
}

/// The binding that says what an assignment to names says.
fn binding(e: &Expr) -> Option<Stmt> {
    let (target, value): (&Expr, Expr) = match e {
        Expr::Assign(a) => (&a.left, (*a.right).clone()),
        Expr::Binary(b) => {
            let (op, left, right) = (operator(&b.op)?, &b.left, &b.right);
            (&b.left, parse_quote!(#left #op (#right)))
        }
        _ => return None,
    };
    is_names(target).then_some(())?;
    let pattern = syn::parse::Parser::parse2(Pat::parse_single, target.to_token_stream()).ok()?;
    Some(parse_quote!(let #pattern = #value;))
}

/// Whether this is a name, or a tuple of names.
fn is_names(target: &Expr) -> bool {
    match target {
        Expr::Path(p) => p.path.get_ident().is_some(),
        Expr::Tuple(t) => t.elems.iter().all(is_names),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assignments_of_the_body_are_bindings() {
        let item: ItemFn = parse_quote! {
            fn f(u: [Uniform; 2], a: f64) -> f64 {
                debug_assert!(a > 0.0);
                let (mut x, mut y) = (u[0], a);
                x *= a + y;
                (x, y) = (y, x);
                if a > 1.0 { x = 2.0; }
                x + y
            }
        };
        let expected: ItemFn = parse_quote! {
            fn f(u: [Uniform; 2], a: f64) -> f64 {
                let (mut x, mut y) = (u[0], a);
                let x = x * (a + y);
                let (x, y) = (y, x);
                if a > 1.0 { x = 2.0; }
                x + y
            }
        };
        let text = |item: &ItemFn| item.to_token_stream().to_string();
        assert_eq!(text(&plain(&item)), text(&expected));
    }
}
