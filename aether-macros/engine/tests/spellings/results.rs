//! Spellings whose points are others: scaled and sheared, coordinates in another order.

use aether_engine::parse::Space;
use quote::ToTokens;
use syn::visit_mut::{VisitMut, visit_expr_return_mut};
use syn::{Block, Expr, ItemFn, Stmt, parse_quote};

use crate::operands::bracketed;
use crate::samplers::Affine;

/// The result under an affine map. `None` if the space has none but the identity.
pub fn scaled(function: ItemFn, space: &Space) -> Option<(ItemFn, Affine)> {
    transformed(function, space, affine)
}

/// The coordinates of the result in cyclic order. `None` if there is but one.
pub fn permuted(function: ItemFn, space: &Space) -> Option<(ItemFn, Affine)> {
    transformed(function, space, |space| {
        let (_, n) = space.dimensions();
        (n > 1).then(|| Affine::cycle(n))
    })
}

/// An affine map of the points of a space whose effect on the measure is known: any of a space of full
/// dimension, a similarity else.
fn affine(space: &Space) -> Option<Affine> {
    let map = |rows: &[&[f64]], shift: &[f64], stretch| Affine {
        rows: rows.iter().map(|r| r.to_vec()).collect(),
        shift: shift.to_vec(),
        stretch,
    };
    Some(match space {
        Space::Line => map(&[&[-2.5]], &[0.75], 2.5),
        Space::Plane => map(&[&[2.0, 0.5], &[-1.5, 3.0]], &[0.25, -1.0], 6.75),
        Space::Volume => {
            let rows: [&[f64]; 3] = [&[2.0, 0.0, 0.5], &[-1.0, 3.0, 0.0], &[0.0, 0.5, 1.5]];
            map(&rows, &[0.25, -1.0, 0.5], 8.75)
        }
        Space::Embedded { k, n } => {
            let similar = Affine::scaling(*n, 2.5, 0.75);
            Affine { stretch: 2.5f64.powi(*k as i32), ..similar }
        }
        Space::SurfacePoint => Affine { stretch: 6.25, ..Affine::scaling(3, 2.5, 0.75) },
        Space::Direction | Space::Joint(_) => return None,
    })
}

fn transformed(
    mut function: ItemFn,
    space: &Space,
    map: impl Fn(&Space) -> Option<Affine>,
) -> Option<(ItemFn, Affine)> {
    let parts = space.parts();
    let maps: Vec<Option<Affine>> = parts.iter().map(map).collect();
    if maps.iter().all(Option::is_none) {
        return None;
    }
    let maps: Vec<Affine> = maps
        .into_iter()
        .zip(&parts)
        .map(|(m, s)| m.unwrap_or_else(|| Affine::identity(s)))
        .collect();
    let point = |e: &Expr| match e {
        Expr::Tuple(t) => {
            let part = |((e, s), m): ((&Expr, &Space), &Affine)| moved(e, s, m);
            let parts = t.elems.iter().zip(&parts).zip(&maps).map(part);
            parse_quote!((#(#parts),*))
        }
        e => moved(e, &parts[0], &maps[0]),
    };
    let mut results = Results(point);
    results.visit_block_mut(&mut function.block);
    results.block(&mut function.block);
    Some((function, maps.into_iter().reduce(Affine::beside)?))
}

/// The expression of a point under an affine map.
fn moved(e: &Expr, space: &Space, map: &Affine) -> Expr {
    if let Space::Embedded { .. } = space
        && let Expr::Call(call) = e
        && let Expr::Array(array) = &call.args[0]
    {
        let coordinates: Vec<Expr> = array.elems.iter().map(bracketed).collect();
        let rows = rows(&coordinates, map);
        return parse_quote!(Embedded([#(#rows),*]));
    }
    if let (Space::SurfacePoint, Expr::Call(call)) = (space, e) {
        let (position, identity) = (moved(&call.args[0], &Space::Volume, map), &call.args[1]);
        return parse_quote!(SurfacePoint::new(#position, #identity));
    }
    let coordinates: Vec<Expr> = match space {
        Space::Line => vec![parse_quote!(place)],
        Space::Plane => vec![parse_quote!(place.x), parse_quote!(place.y)],
        _ => vec![parse_quote!(place.x), parse_quote!(place.y), parse_quote!(place.z)],
    };
    let rows = rows(&coordinates, map);
    let result: Expr = match space {
        Space::Line => parse_quote!(#(#rows)*),
        Space::Plane => parse_quote!(Vec2::new(#(#rows),*)),
        Space::Direction => parse_quote!(Direction::new(#(#rows),*)),
        Space::Embedded { k: 1, .. } => parse_quote!(Curve::new(#(#rows),*)),
        Space::Embedded { .. } => parse_quote!(Surface::new(#(#rows),*)),
        _ => parse_quote!(Vec3::new(#(#rows),*)),
    };
    parse_quote!({ let place = #e; #result })
}

/// The rows of matrix · coordinates + shift.
fn rows(coordinates: &[Expr], map: &Affine) -> Vec<Expr> {
    let row = |row: &Vec<f64>| {
        let terms = row.iter().zip(coordinates).filter(|(a, _)| **a != 0.0);
        let terms: Vec<Expr> = terms
            .map(|(&a, x)| {
                let size = a.abs();
                match a {
                    1.0 => x.clone(),
                    0.0.. => parse_quote!(#size * #x),
                    _ => parse_quote!(-#size * #x),
                }
            })
            .collect();
        parse_quote!(#(#terms)+*)
    };
    let shifted = |(sum, &shift): (Expr, &f64)| -> Expr {
        let size = shift.abs();
        match shift {
            0.0 => sum,
            0.0.. => parse_quote!(#sum + #size),
            _ => parse_quote!(#sum - #size),
        }
    };
    map.rows.iter().map(row).zip(&map.shift).map(shifted).collect()
}

/// Rewrites the expressions of the result, at the end and in early returns.
struct Results<F>(F);

impl<F: Fn(&Expr) -> Expr> Results<F> {
    fn block(&self, block: &mut Block) {
        if let Some(Stmt::Expr(e, None)) = block.stmts.last_mut() {
            self.result(e);
        }
    }

    fn result(&self, e: &mut Expr) {
        match e {
            Expr::Paren(p) => self.result(&mut p.expr),
            Expr::Block(b) => self.block(&mut b.block),
            Expr::If(i) => {
                self.block(&mut i.then_branch);
                if let Some((_, other)) = &mut i.else_branch {
                    self.result(other);
                }
            }
            Expr::Match(m) => m.arms.iter_mut().for_each(|arm| self.result(&mut arm.body)),
            Expr::Call(c) if c.func.to_token_stream().to_string() == "Some" => {
                self.result(&mut c.args[0])
            }
            Expr::Path(p) if p.path.is_ident("None") => {}
            Expr::Return(_) => {}
            e => *e = (self.0)(e),
        }
    }
}

impl<F: Fn(&Expr) -> Expr> VisitMut for Results<F> {
    fn visit_expr_return_mut(&mut self, r: &mut syn::ExprReturn) {
        visit_expr_return_mut(self, r);
        r.expr.iter_mut().for_each(|e| self.result(e));
    }
}
