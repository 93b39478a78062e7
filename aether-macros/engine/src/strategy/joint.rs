//! Several vertices of one draw: which point each is made from, and which of them keeps what a
//! locally constant call returned, so that a density can read it back.

use syn::{Expr, ExprArray, Ident, Member};

use super::analyse::Analysis;
use super::names::{bare, mentioned, variable};
use super::scope::Scope;
use super::tree::Kind;
use crate::sorted;
use crate::walk::{self, Look};

impl Analysis<'_> {
    /// Checks the end of a strategy that yields several vertices; whether it is right.
    pub fn run(&mut self, vertices: &Expr, kind: &Kind, scope: &Scope) -> bool {
        let Kind::Density(point) = kind else { return false };
        let Some(array) = elements(vertices).filter(|array| array.elems.len() == self.count) else {
            self.diagnostics.error(
                vertices,
                format!(
                    "write the {} vertices of this draw out as an array here, so that it can be seen \
                     which point each is made from",
                    self.count
                ),
            );
            return false;
        };
        let mut right = true;
        for (k, vertex) in array.elems.iter().enumerate() {
            if parts(vertex, point) != [k] {
                right = false;
                self.diagnostics.error(
                    vertex,
                    format!(
                        "vertex {k} of a draw is made from point {k} of what is drawn: from \
                         `{point}.{k}` and from no other part of `{point}`"
                    ),
                );
            }
        }
        self.keep(array, scope);
        right
    }

    /// Finds the vertex that keeps each locally constant value: the one that has the fewest others.
    fn keep(&mut self, array: &ExprArray, scope: &Scope) {
        let made_of: Vec<u128> =
            array.elems.iter().map(|vertex| scope.of(&mentioned(vertex)).calls).collect();
        let keepers = |number: usize| {
            let bit = 1_u128.checked_shl(number as u32).unwrap_or(0);
            made_of.iter().map(|calls| calls & bit != 0).collect::<Vec<_>>()
        };
        for number in 0..self.calls.len() {
            let having = keepers(number);
            let several = having.iter().filter(|has| **has).count() > 1;
            let confused = several && (0..number).any(|other| keepers(other) == having);
            let fewest =
                (0..made_of.len()).filter(|k| having[*k]).min_by_key(|k| made_of[*k].count_ones());
            let (call, known) = &mut self.calls[number];
            let differs = known.is_some() && fewest.is_some() && *known != fewest;
            if confused || differs {
                self.diagnostics.error(
                    &*call,
                    "the density reads this value back from the vertex that it goes into, which is \
                     not always the same one: let each value go into one vertex",
                );
            }
            *known = known.or(fewest);
        }
    }

    /// Which vertex keeps the value of each locally constant call.
    pub fn keepers(&mut self) -> Vec<usize> {
        let mut keepers = Vec::new();
        for (call, keeper) in &self.calls {
            if self.count > 1 && keeper.is_none() && self.diagnostics.is_empty() {
                self.diagnostics.error(
                    call,
                    "the density reads this value back from one of the vertices, but it goes into \
                     none of them: make one from it",
                );
            }
            keepers.push(keeper.unwrap_or(0));
        }
        keepers
    }
}

fn elements(expr: &Expr) -> Option<&ExprArray> {
    if let Expr::Array(array) = bare(expr) { Some(array) } else { None }
}

/// Which parts of a point an expression mentions; all of it counts as no part.
fn parts(expr: &Expr, point: &Ident) -> Vec<usize> {
    struct Parts<'a> {
        point: &'a Ident,
        found: Vec<usize>,
    }
    impl Look for Parts<'_> {
        fn expr(&mut self, expr: &Expr) -> bool {
            if let Expr::Field(field) = expr
                && let Member::Unnamed(index) = &field.member
                && variable(&field.base) == Some(self.point)
            {
                self.found.push(index.index as usize);
                return false;
            }
            true
        }
        fn path(&mut self, path: &syn::ExprPath) -> bool {
            if path.path.is_ident(self.point) {
                self.found.push(usize::MAX);
            }
            false
        }
    }
    let mut parts = Parts { point, found: Vec::new() };
    walk::expr(&mut parts, expr);
    sorted::sort(&mut parts.found);
    parts.found.dedup();
    parts.found
}
