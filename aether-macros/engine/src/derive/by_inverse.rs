//! The density by the derivatives of the inverse instead of those of the map.

use super::{Problem, Target};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node, OUTS, children};
use crate::jacobian::simplify;
use crate::matrix::determinant;
use crate::solve::Solution;

/// The density as the determinant of the derivatives of the inverse; on a sphere, the volume that their
/// gradients span with the normal.
pub(super) fn by_the_inverse(problem: &mut Problem, s: &Solution) -> Option<Id> {
    let n = problem.unknowns.len();
    let direction = problem.is_direction() && n == 2;
    let free = matches!(problem.parts[..], [part] if part.target == Target::Free);
    if problem.argument.is_some() || !(direction || free && problem.outputs.len() == n && n < 4) {
        return None;
    }
    let g = &mut problem.graph;
    let outs: Vec<Leaf> = (0..problem.outputs.len() as u8).map(Leaf::Out).collect();
    let mut rows = Vec::new();
    for unknown in &problem.unknowns {
        let value = *s.unknowns.get(unknown)?;
        rows.push(outs.iter().map(|&x| derivative(g, value, x)).collect::<Vec<Id>>());
    }
    let unit = if direction { Some([0, 1, 2].map(|k| g.get_leaf(outs[k]))) } else { None };
    rows.extend(unit.map(|w| w.to_vec()));
    let spanned = determinant(g, &rows);
    let spanned = simplify(g, spanned, unit);
    let widths: Vec<Id> = problem.segments.iter().flatten().map(|s| s.width).collect();
    let density = widths.into_iter().fold(spanned, |product, w| g.mul(product, w));
    (!divides_by_zero(g, density)).then(|| g.call(Fun::Abs, &[density]))
}

/// Whether a divisor depends on the point and may vanish.
fn divides_by_zero(g: &Graph, id: Id) -> bool {
    let divisor = |&(b, e): &(Id, Id)| {
        let range = g.range(b);
        let vanishes = range.lo <= 0.0 && range.hi >= 0.0;
        vanishes && g.has(b, OUTS) && g.as_number(e).is_none_or(|q| q.is_negative())
    };
    match g.node(id) {
        Node::Product(f) if f.iter().any(divisor) => true,
        node => children(node).into_iter().any(|c| divides_by_zero(g, c)),
    }
}
