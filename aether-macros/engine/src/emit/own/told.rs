//! Densities that uniforms tell by themselves.

use proc_macro2::TokenStream;
use quote::quote;

use super::is_alone;
use super::one_piece::{has_parameters, is_tame};
use crate::derive::Derived;
use crate::emit::item::Emitter;
use crate::expr::{Graph, Id, Node, OUTS, UNKNOWNS};
use crate::rational::Q;

/// Parameters that such densities are in proportion to are larger, or smaller than the inverse: in single precision, too, both
/// are numbers.
const SMALLEST: f64 = 1e-30;

/// Whether a sample and its density are drawn once more unless the density is a positive number.
pub(in crate::emit) fn is_looked_at(e: &Emitter) -> bool {
    match e.is_single() {
        true => matches!(Told::of(e), Told::AtUniforms),
        false => is_alone(e) && !is_told_everywhere(e),
    }
}

/// What there is to know of the density `d` at uniforms, where a map has one preimage.
#[derive(Clone, Copy)]
pub(super) enum Told {
    /// It has a value at all uniforms and depends on nothing else.
    Always,
    /// It depends on parameters alone, as the density at any point does: that would not tell more.
    ByParameters,
    /// The uniforms may not tell it. At zero the map may only have a limit (a pole, an axis), and so may the Jacobian; the
    /// density at the point knows it. Parameters may overflow.
    AtUniforms,
}

impl Told {
    /// That of a map of one piece.
    pub fn of(e: &Emitter) -> Self {
        let graph = &e.parsed.pieces[0].problem.graph;
        let Derived { own_density, preimages, .. } = &e.derived[0];
        if is_told(e, 0) {
            Told::Always
        } else if !graph.has(*own_density, UNKNOWNS) && preimages[0].density == *own_density {
            Told::ByParameters
        } else {
            Told::AtUniforms
        }
    }

    /// The density from `d`.
    pub fn value(self) -> TokenStream {
        match self {
            // What parameters make no number is none at the point.
            Told::ByParameters => quote!(d.max(R::ZERO)),
            _ => quote!(d),
        }
    }
}

/// Whether the density of a piece has a value at all uniforms and parameters, and is zero only where the density of the point
/// is: it depends on no parameter, or is a number times or over one that is positive.
fn is_told(e: &Emitter, piece: usize) -> bool {
    is_tame(e, piece)
        && (!has_parameters(e, piece)
            || is_scaled(&e.parsed.pieces[piece].problem.graph, e.derived[piece].own_density))
}

/// Whether all pieces have a density that is told so, and a sample.
pub(super) fn is_told_everywhere(e: &Emitter) -> bool {
    (0..e.parsed.pieces.len()).all(|j| e.forward_is_tame(j) && is_told(e, j))
}

/// Whether a density at uniforms is a function of these that lies in [0, 1], times or over a positive
/// parameter, or one without it: no part of it leaves the range of numbers but the whole.
fn is_scaled(g: &Graph, density: Id) -> bool {
    let (q, product) = match g.node(density) {
        Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0],
        _ => (Q::ONE, density),
    };
    let Node::Product(factors) = g.node(product) else { return false };
    let is_parameter = |id: Id| g.has(id, !(UNKNOWNS | OUTS));
    let (scales, others): (Vec<_>, Vec<_>) =
        factors.iter().copied().partition(|&(base, e)| is_parameter(base) || is_parameter(e));
    let [(scale, exponent)] = scales[..] else { return false };
    let is_share = |&(base, e): &(Id, Id)| {
        let range =
            g.as_number(e).filter(|e| !e.is_negative()).map(|e| g.range(base).pow(e.to_f64()));
        range.is_some_and(|range| range.nonnegative() && range.at_most_one())
    };
    // Zero times infinity would be no number.
    let is_one = match g.as_number(exponent) {
        Some(e) if e == Q::ONE => g.range(scale).hi.is_finite(),
        e => e == Some(Q::int(-1)),
    };
    matches!(g.node(scale), Node::Leaf(_))
        && g.range(scale).lo > SMALLEST
        && is_one
        && !q.is_negative()
        && q.to_f64() <= 1.0
        && others.iter().all(is_share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn a_share_over_a_positive_parameter_is_told() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let declared = g.leaf(Leaf::Param(0), "r", Interval::new(1e-6, f64::INFINITY));
        let any = g.leaf(Leaf::Param(1), "s", Interval::ALL);
        let between = g.leaf(Leaf::Param(2), "t", Interval::new(1e-6, 1e6));
        let root = g.sqrt(u);
        let [over, over_any] = [declared, any].map(|p| g.div(root, p));
        let [times, endless] = [between, declared].map(|p| g.mul(root, p));
        let square = g.powi(declared, -2);
        let (over_square, pole) = (g.mul(root, square), g.div(over, u));
        let twice = g.sum(Q::ZERO, &[(Q::int(2), times)]);
        assert!(is_scaled(&g, over) && is_scaled(&g, times));
        // Of unknown sign, zero times infinity, of two steps, infinite at zero, and of more than the largest number.
        let others = [over_any, endless, over_square, pole, twice];
        assert!(!others.into_iter().any(|id| is_scaled(&g, id)));
    }
}
