//! Images that are multiples of points: of a point, from where it is measured, the image is its place times a factor
//! whose square is a quotient of sums, as of a sphere from its centre. The point then lies on the manifold where the two
//! sums are the same, which takes neither roots nor quotients to see.

use crate::expr::{Graph, Id, Leaf, Node};
use crate::rational::Q;

/// The image of a point as its multiple: each coordinate is the point's own, or it is an offset away from where that
/// has its offset times √(above / below), which is not negative.
#[derive(Clone, Debug)]
pub struct Scaled {
    /// The offsets of the point, of the coordinates that are not its own.
    pub offsets: Vec<Id>,
    /// above - below.
    pub excess: Id,
    /// The sum below, which is positive or zero.
    pub below: Id,
    /// The sum of the sizes of all terms of both.
    pub sizes: Id,
}

/// How an image is a multiple of the point, if it is one, with sums of squares of differences of coordinates and
/// parameters: of these it is known how far rounding leads.
pub(super) fn scaled(g: &mut Graph, image: &[Id]) -> Option<Scaled> {
    let (mut offsets, mut factor) = (vec![], None);
    for (i, &coordinate) in image.iter().enumerate() {
        let x = g.get_leaf(Leaf::Out(i as u8));
        if coordinate == x {
            continue;
        }
        let (offset, roots) = multiple(g, coordinate, x)?;
        if factor.get_or_insert_with(|| roots.clone()) != &roots {
            return None;
        }
        offsets.push(offset);
    }
    let [above, below] = [false, true].map(|is_below| {
        let side = factor.iter().flatten().filter(|(_, e)| e.is_negative() == is_below);
        side.map(|(base, _)| *base).collect::<Vec<Id>>()
    });
    let ([above], [below]) = (&above[..], &below[..]) else { return None };
    let [above, below] = without_divisors(g, [*above, *below])?;
    let sizes = |terms: &[(Q, Id)]| terms.iter().map(|(q, t)| (q.abs(), *t)).collect::<Vec<_>>();
    let less = below.iter().map(|&(q, t)| (q.neg(), t));
    let excess: Vec<_> = above.iter().copied().chain(less).collect();
    let all = [sizes(&above), sizes(&below)].concat();
    // What is below the line of a real factor is no negative number.
    below.iter().all(|(q, _)| !q.is_negative()).then(|| Scaled {
        offsets,
        excess: g.sum(Q::ZERO, &excess),
        below: g.sum(Q::ZERO, &below),
        sizes: g.sum(Q::ZERO, &all),
    })
}

/// The offset that a coordinate of an image has times roots where the point's own, x, has it alone; and the roots.
fn multiple(g: &mut Graph, coordinate: Id, x: Id) -> Option<(Id, Vec<(Id, Q)>)> {
    let terms = match g.node(coordinate) {
        Node::Sum(_, terms) => terms.clone(),
        _ => vec![(Q::ONE, coordinate)],
    };
    let mut found = None;
    for (q, term) in terms {
        let powers = g.factors(term).into_iter();
        let is_root = |g: &Graph, e: Id| g.as_number(e).filter(|e| e.abs() == Q::HALF);
        let (roots, others): (Vec<_>, Vec<_>) = powers.partition(|(_, e)| is_root(g, *e).is_some());
        if roots.is_empty() {
            continue;
        }
        let roots = roots.into_iter().filter_map(|(b, e)| Some((b, is_root(g, e)?))).collect();
        if found.replace((q, term, roots, others)).is_some() {
            return None;
        }
    }
    let (q, term, roots, others) = found?;
    let offset = g.product(&others);
    let offset = g.sum(Q::ZERO, &[(q, offset)]);
    let rest = g.sum(Q::ZERO, &[(Q::ONE, coordinate), (q.neg(), term)]);
    let own = g.sub(x, rest);
    (own == offset).then_some((offset, roots))
}

/// The terms of two sums, both multiplied by what their terms divide by; `None` if they are not made of even powers of
/// leaves and of differences of two.
fn without_divisors(g: &mut Graph, sums: [Id; 2]) -> Option<[Vec<(Q, Id)>; 2]> {
    let one = g.int(1);
    let terms = sums.map(|id| match g.node(id) {
        Node::Sum(c, terms) => {
            let constant = (!c.is_zero()).then_some((*c, one));
            constant.into_iter().chain(terms.iter().copied()).collect()
        }
        _ => vec![(Q::ONE, id)],
    });
    let mut divisors: Vec<(Id, Q)> = vec![];
    for (_, term) in terms.iter().flatten() {
        for (base, exponent) in g.factors(*term) {
            let exponent = g.as_number(exponent).filter(|e| e.is_even())?;
            if !is_short(g, base) {
                return None;
            }
            if exponent.is_negative() {
                match divisors.iter_mut().find(|(known, _)| *known == base) {
                    Some((_, most)) if *most <= exponent => {}
                    Some((_, most)) => *most = exponent,
                    None => divisors.push((base, exponent)),
                }
            }
        }
    }
    let factors: Vec<(Id, Id)> =
        divisors.into_iter().map(|(base, e)| (base, g.number(e.neg()))).collect();
    let whole = g.product(&factors);
    Some(terms.map(|terms| terms.into_iter().map(|(q, t)| (q, g.mul(t, whole))).collect()))
}

/// Whether an expression is a leaf, or a sum or difference of two.
fn is_short(g: &Graph, id: Id) -> bool {
    let is_leaf = |id: Id| matches!(g.node(id), Node::Leaf(_));
    match g.node(id) {
        Node::Sum(c, terms) => {
            let plain = |(q, t): &(Q, Id)| q.abs() == Q::ONE && is_leaf(*t);
            c.is_zero() && terms.len() <= 2 && terms.iter().all(plain)
        }
        _ => is_leaf(id),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Evaluator;
    use crate::interpret::Item;

    /// The offsets, the excess, what is below, and the sizes, of a point.
    fn found(text: &str, p: &[f64], x: [f64; 3]) -> Option<Vec<f64>> {
        let item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        let g = &item.parsed.pieces[0].problem.graph;
        let scaled = item.derived[0].preimages[0].back.as_ref()?.scaled.as_ref()?;
        let at = |leaf| match leaf {
            Leaf::Param(i) => p[usize::from(i)],
            Leaf::Out(i) => x[usize::from(i)],
            _ => f64::NAN,
        };
        let mut e = Evaluator::<f64>::new(g, &at);
        let all = scaled.offsets.iter().chain([&scaled.excess, &scaled.below, &scaled.sizes]);
        Some(all.map(|id| e.value(*id)).collect())
    }

    #[test]
    fn a_point_of_a_sphere_is_scaled_at_its_height() {
        let sphere = "fn sphere(u: [Uniform; 2], c: Vec3, r: f64) -> Surface {
            let z = 1.0 - 2.0 * u[0];
            let s = (1.0 - z * z).sqrt();
            let phi = TAU * u[1];
            Surface::from_vec(c + r * Vec3::new(s * phi.cos(), s * phi.sin(), z))
        }";
        let p = [1.0, 2.0, 3.0, 2.0];
        let outside = found(sphere, &p, [2.0, 4.0, 3.5]);
        assert_eq!(outside, Some(vec![1.0, 2.0, 4.0 - 5.25, 5.0, 4.0 + 5.25]));
        let on = found(sphere, &p, [1.0 + 2.0 * 0.6, 2.0 - 2.0 * 0.8, 3.0]).unwrap();
        assert!(on[2].abs() < 1e-14);
    }

    #[test]
    fn axes_of_their_own_lengths_divide_each_its_square() {
        let ellipsoid = "fn ellipsoid(u: [Uniform; 2], a: f64, b: f64, c: f64) -> Surface {
            let z = 1.0 - 2.0 * u[0];
            let s = (1.0 - z * z).sqrt();
            let phi = TAU * u[1];
            Surface::new(a * s * phi.cos(), b * s * phi.sin(), c * z)
        }";
        let [a, b, c] = [2.0, 3.0, 5.0];
        let [x, y, z] = [1.0, 1.5, -2.0];
        let found = found(ellipsoid, &[a, b, c], [x, y, z]).unwrap();
        let whole = (a * b * c).powi(2);
        let [x2, y2, z2] = [x / a, y / b, z / c].map(|q| q * q);
        let expected =
            [x, y, whole * (1.0 - x2 - y2 - z2), whole * (x2 + y2), whole * (1.0 + x2 + y2 + z2)];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12 * whole, "{found} {expected}");
        }
    }

    #[test]
    fn other_surfaces_are_no_multiples_of_sums_of_squares() {
        // The factor has no root above the line; and the edges of a triangle are no factors.
        let cylinder = "fn cylinder(u: [Uniform; 2], r: f64) -> Surface {
            let phi = TAU * u[1];
            Surface::new(r * phi.cos(), r * phi.sin(), u[0])
        }";
        let triangle = "fn triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
            let s = (1.0 - u[0]).sqrt();
            Surface::from_vec(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a))
        }";
        assert_eq!(found(cylinder, &[1.0], [1.0, 0.0, 0.5]), None);
        assert_eq!(found(triangle, &[0.0; 9], [0.0; 3]), None);
    }
}
