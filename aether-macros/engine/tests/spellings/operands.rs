//! Spellings that keep the shape of a body: other uniforms, operands in another order.

use aether_engine::parse::{ParamKind, Signature, Source};
use quote::ToTokens;
use syn::visit_mut::{VisitMut, visit_expr_mut};
use syn::{BinOp, Expr, ItemFn, parse_quote};

/// Brackets around everything that is more than a name.
pub fn bracketed(e: &Expr) -> Expr {
    match e {
        Expr::Path(_) | Expr::Paren(_) | Expr::Index(_) | Expr::Call(_) => e.clone(),
        e => parse_quote!((#e)),
    }
}

/// Every `u[i]` as `(1.0 - u[i])`.
pub fn mirrored(mut function: ItemFn, signature: &Signature) -> ItemFn {
    each_uniform(&mut function, signature, |u, i| parse_quote!((1.0 - #u[#i])));
    function
}

/// The uniforms in the opposite order.
pub fn exchanged(mut function: ItemFn, signature: &Signature) -> ItemFn {
    let Source::Uniforms { count, .. } = signature.source else { return function };
    each_uniform(&mut function, signature, |u, i| {
        let i = syn::Index::from(count - 1 - i.index as usize);
        parse_quote!(#u[#i])
    });
    function
}

fn each_uniform(
    function: &mut ItemFn,
    signature: &Signature,
    write: impl Fn(&Expr, syn::Index) -> Expr,
) {
    struct Uniforms<'a, F>(&'a str, F);
    impl<F: Fn(&Expr, syn::Index) -> Expr> VisitMut for Uniforms<'_, F> {
        fn visit_expr_mut(&mut self, e: &mut Expr) {
            if let Expr::Index(index) = e
                && let Expr::Path(path) = &*index.expr
                && path.path.is_ident(self.0)
                && let Expr::Lit(syn::ExprLit { lit: syn::Lit::Int(i), .. }) = &*index.index
            {
                let i = syn::Index::from(i.base10_parse::<usize>().expect("an index"));
                *e = (self.1)(&index.expr, i);
            } else {
                visit_expr_mut(self, e);
            }
        }
    }
    if let Source::Uniforms { name, .. } = &signature.source {
        Uniforms(name, write).visit_block_mut(&mut function.block);
    }
}

/// Operands of sums, products, comparisons and inner products swapped; `a - b` as `-b + a`.
pub fn reordered(mut function: ItemFn, signature: &Signature) -> ItemFn {
    let matrix = |kind: &ParamKind| matches!(kind, ParamKind::Mat3 | ParamKind::Frame);
    let matrices = signature.params.iter().filter(|p| matrix(&p.kind));
    let mut order = Order { matrices: matrices.map(|p| p.name.to_string()).collect() };
    order.visit_block_mut(&mut function.block);
    function
}

struct Order {
    /// A matrix stands to the left of its vector.
    matrices: Vec<String>,
}

impl VisitMut for Order {
    fn visit_expr_mut(&mut self, e: &mut Expr) {
        visit_expr_mut(self, e);
        if let Expr::MethodCall(m) = e
            && m.method == "dot"
        {
            let (a, b) = (bracketed(&m.receiver), bracketed(&m.args[0]));
            *e = parse_quote!(#b.dot(#a));
            return;
        }
        let Expr::Binary(binary) = e else { return };
        let (a, b) = (bracketed(&binary.left), bracketed(&binary.right));
        let matrix = |e: &Expr| matches!(e, Expr::Path(p) if self.matrices.iter().any(|m| p.path.is_ident(m)));
        *e = match binary.op {
            BinOp::Add(_) => parse_quote!(#b + #a),
            BinOp::Sub(_) => parse_quote!(-#b + #a),
            BinOp::Mul(_) if !matrix(&a) => parse_quote!(#b * #a),
            BinOp::Lt(_) => parse_quote!(#b > #a),
            BinOp::Le(_) => parse_quote!(#b >= #a),
            BinOp::Gt(_) => parse_quote!(#b < #a),
            BinOp::Ge(_) => parse_quote!(#b <= #a),
            BinOp::And(_) => parse_quote!(#b && #a),
            BinOp::Or(_) => parse_quote!(#b || #a),
            _ => return,
        };
    }
}

/// The functions of the language by other names: quotients as products, roots and squares as powers.
pub fn renamed(mut function: ItemFn) -> ItemFn {
    struct Names;
    impl VisitMut for Names {
        fn visit_expr_mut(&mut self, e: &mut Expr) {
            visit_expr_mut(self, e);
            *e = match e {
                Expr::Binary(b) if matches!(b.op, BinOp::Div(_)) => {
                    let (a, b) = (bracketed(&b.left), bracketed(&b.right));
                    parse_quote!(#a * (1.0 / #b))
                }
                Expr::MethodCall(m) => {
                    let x = bracketed(&m.receiver);
                    match m.method.to_string().as_str() {
                        "sqrt" => parse_quote!(#x.powf(0.5)),
                        "powi" if m.args[0].to_token_stream().to_string() == "2" => {
                            parse_quote!((#x * #x))
                        }
                        "exp_m1" => parse_quote!((#x.exp() - 1.0)),
                        "ln_1p" => parse_quote!((1.0 + #x).ln()),
                        "tan" => parse_quote!((#x.sin() / #x.cos())),
                        _ => return,
                    }
                }
                Expr::Unary(u) if matches!(u.op, syn::UnOp::Neg(_)) => {
                    let x = bracketed(&u.expr);
                    parse_quote!((-1.0 * #x))
                }
                _ => return,
            };
        }
    }
    Names.visit_block_mut(&mut function.block);
    function
}
