//! How far a coordinate is from -1 or 1 (a direction from a pole), by what its inverse says of the uniform.
//!
//! Where u = F(z) with F rational and F(-1) = 0, F has the factor 1 + z, and 1 + z = u (1 + z) / F(z). The sum
//! on the left has lost its digits next to the pole, where z is next to -1; the product has not. A multiple
//! zero needs a root.

use crate::expr::{Graph, Id, Leaf, OUTS};
use crate::hash::Map;
use crate::poly::{Expander, Poly, RatFun};
use crate::rational::Q;
use crate::solve::Solution;

use super::Problem;

/// Sums of the uniforms, each with an equal product: 1 - z and 1 + z for coordinates z of a direction.
pub(super) fn gaps(problem: &mut Problem, solutions: &[Solution]) -> Map<Id, Id> {
    let mut told = Map::default();
    let [solution] = solutions else { return told };
    if problem.argument.is_some() || problem.outputs.len() > 3 {
        return told;
    }
    let g = &mut problem.graph;
    for leaf in &problem.unknowns {
        let Some(&value) = solution.unknowns.get(leaf) else { continue };
        let outs = g.deps(value) & OUTS;
        let Some(k) = (0..3u8).find(|k| outs == crate::expr::leaf_bit(Leaf::Out(*k))) else {
            continue;
        };
        let z = (g.get_leaf(Leaf::Out(k)), problem.outputs[k as usize]);
        let u = g.get_leaf(*leaf);
        let one = g.int(1);
        let (rest, rest_value) = (g.sub(one, u), g.sub(one, value));
        for (u, value) in [(u, value), (rest, rest_value)] {
            for side in [Q::ONE, Q::int(-1)] {
                if let Some(product) = gap(g, (u, value), z, side) {
                    let sum = g.sum(Q::ONE, &[(side.neg(), z.1)]);
                    told.insert(sum, product);
                }
            }
        }
    }
    told
}

/// 1 - side·z in terms of u = F(z) and z.
fn gap(g: &mut Graph, (u, value): (Id, Id), (z, written): (Id, Id), side: Q) -> Option<Id> {
    let function = Expander::new(g).expand(value)?;
    let pole = Poly::constant(Q::ONE).add(&Poly::atom(z).scale(side.neg())?)?;
    let (mut num, mut times) = (function.num, 0);
    while let Some(rest) = num.exact_div(&pole) {
        (num, times) = (rest, times + 1);
    }
    let root = Q::ONE.mul(Q::int(times).recip()?)?;
    let rest = Expander::new(g).to_expr(&RatFun { num, den: function.den });
    let rest = g.substitute(rest, &[(z, written)].into());
    let product = g.div(u, rest);
    let root = g.number(root);
    Some(g.pow(product, root))
}
