//! Directions that are another direction times a number, and moved: reflections and refractions of a vector `w`
//! about a direction `h`, which are a(h) h + b w.

use std::collections::BTreeMap;

use super::{factor_out, simplify_with};
use crate::derivative::derivative;
use crate::expr::{Deps, Fun, Graph, Id, Leaf, Node, UNKNOWNS, leaf_bit};
use crate::rational::Q;

/// The area of an image x = a h + b on the unit sphere, of directions `h`, where b is known. The derivative is
/// a I + h ∇aᵀ, a multiple of the identity and a matrix of rank one; its cofactors applied to h, along x, are
///
/// a (a² + a b·h + (∇a·h) (b·h) - ∇a·b).
pub(super) fn area(
    g: &mut Graph,
    outputs: &[Id],
    unknowns: &[Leaf],
    h: [Id; 3],
    units: &[[Id; 3]],
) -> Option<Vec<Id>> {
    let (a, b) = taken_apart(g, outputs, h)?;
    let slope: Vec<Id> = unknowns
        .iter()
        .map(|&u| {
            let slope = derivative(g, a, u);
            factor_out(g, slope)
        })
        .collect();
    let products = [(&b[..], &h[..]), (&slope[..], &h[..]), (&slope[..], &b[..])];
    let [along, turned, across] = products.map(|(v, w)| dot(g, v, w, units));
    let squared = g.powi(a, 2);
    let (moved, both) = (g.mul(a, along), g.mul(turned, along));
    let minus = g.neg(across);
    let terms = [squared, moved, both, minus].map(|t| (Q::ONE, t));
    let stretched = g.sum(Q::ZERO, &terms);
    let product = g.mul(a, stretched);
    let tidy = simplify_with(g, product, units);
    Some([tidy, product].map(|d| g.call(Fun::Abs, &[d])).to_vec())
}

/// The a and b of a vector a h + b, with a known b.
pub fn taken_apart(g: &mut Graph, vector: &[Id], h: [Id; 3]) -> Option<(Id, [Id; 3])> {
    let &[x, y, z] = vector else { return None };
    let (a, b_x) = scaled(g, x, h[0], UNKNOWNS)?;
    let [(a_y, b_y), (a_z, b_z)] = [scaled(g, y, h[1], UNKNOWNS)?, scaled(g, z, h[2], UNKNOWNS)?];
    ([a_y, a_z] == [a; 2]).then_some((a, [b_x, b_y, b_z]))
}

/// The a and b of a vector a h + b, with a b in which the coordinates of h, which are these inputs, do not occur. In some
/// coordinate a h may be free of h.
pub fn along(g: &mut Graph, vector: &[Id], h: [Id; 3], inputs: [Leaf; 3]) -> Option<(Id, [Id; 3])> {
    let bits = inputs.iter().fold(0, |bits, &l| bits | leaf_bit(l));
    (0..3).find_map(|k| {
        let (a, _) = scaled(g, vector[k], h[k], bits)?;
        let b = [0, 1, 2].map(|i| match scaled(g, vector[i], h[i], bits) {
            Some((same, b)) if same == a => b,
            _ => {
                let moved = g.mul(a, h[i]);
                g.sub(vector[i], moved)
            }
        });
        b.iter().all(|&c| !g.has(c, bits)).then_some((a, b))
    })
}

/// The a and b of `x` as a · `h` + b, with a b without these inputs.
fn scaled(g: &mut Graph, x: Id, h: Id, inputs: Deps) -> Option<(Id, Id)> {
    let (q, body) = g.split(x);
    let (open, known): (Vec<_>, Vec<_>) =
        g.factors(body).into_iter().partition(|&(b, e)| g.has(b, inputs) || g.has(e, inputs));
    if let [(base, exponent)] = open[..]
        && g.as_number(exponent) == Some(Q::ONE)
        && let Node::Sum(c, terms) = g.node(base).clone()
    {
        let outside = g.product(&known);
        let outside = g.sum(Q::ZERO, &[(q, outside)]);
        let (open, known): (Vec<_>, Vec<_>) =
            terms.into_iter().partition(|(_, t)| g.has(*t, inputs));
        let a: Option<Vec<(Q, Id)>> =
            open.into_iter().map(|(q, term)| Some((q, over(g, term, h)?))).collect();
        let [a, b] = [(Q::ZERO, a?), (c, known)].map(|(c, terms)| {
            let sum = g.sum(c, &terms);
            g.mul(outside, sum)
        });
        return Some((a, b));
    }
    let a = over(g, body, h)?;
    Some((g.sum(Q::ZERO, &[(q, a)]), g.int(0)))
}

/// A product without one of its factors.
fn over(g: &mut Graph, product: Id, factor: Id) -> Option<Id> {
    let one = g.int(1);
    g.factors(product).contains(&(factor, one)).then(|| g.div(product, factor))
}

/// The product of two vectors, with what its terms have in common in front of the sum, and that with the sign of
/// its first term: so that sums that are equal but for a factor are seen to be one. The squares of the vectors of
/// unit length add up to one.
fn dot(g: &mut Graph, v: &[Id], w: &[Id], units: &[[Id; 3]]) -> Id {
    let one = g.int(1);
    let lengths: BTreeMap<Id, Id> =
        units.iter().map(|u| (crate::matrix::dot(g, u, u), one)).collect();
    let sum = crate::matrix::dot(g, v, w);
    let sum = factor_out(g, sum);
    let (q, body) = g.split(sum);
    let (mut outside, mut product) = (q, g.int(1));
    for (base, exponent) in g.factors(body) {
        let is_plain = g.as_number(exponent) == Some(Q::ONE);
        let part = match primitive(g, base).filter(|_| is_plain) {
            Some((q, base)) if outside.mul(q).is_some() => {
                outside = outside.mul(q).unwrap_or(outside);
                base
            }
            _ => g.pow(base, exponent),
        };
        let part = lengths.get(&part).copied().unwrap_or(part);
        product = g.mul(product, part);
    }
    g.sum(Q::ZERO, &[(outside, product)])
}

/// The coefficient of the first term of a sum, and the sum over it.
fn primitive(g: &mut Graph, id: Id) -> Option<(Q, Id)> {
    let Node::Sum(c, terms) = g.node(id).clone() else { return None };
    let (first, _) = *terms.first().filter(|_| c.is_zero())?;
    let over = first.recip()?;
    let scaled = terms.iter().map(|&(q, t)| Some((q.mul(over)?, t))).collect::<Option<Vec<_>>>()?;
    Some((first, g.sum(Q::ZERO, &scaled)))
}
