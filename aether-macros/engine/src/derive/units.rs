//! Coordinates that are together a unit vector, and 1 - x² of one of them as the squares of the others.
//!
//! Next to one, x says little of how far it is from there; the others say it to full precision. Next to zero the others
//! say little of how far the sum of their squares is from one.

use crate::expr::{Graph, Id, Leaf, Node, UNKNOWNS};
use crate::hash::Map;
use crate::jacobian::simplify;
use crate::poly::Expander;
use crate::rational::Q;
use crate::sorted;

use super::parts::one_sign;
use super::{Problem, Target};

/// Coordinates that are together a unit vector, where each is measured along a length of its own.
pub(super) struct Stretched {
    places: Vec<u8>,
    /// The length for each of them, which depends on parameters alone.
    lengths: Vec<Id>,
}

impl Stretched {
    /// The places, if the coordinates are a unit vector as they are.
    pub fn unit(&self, g: &mut Graph) -> Option<Vec<u8>> {
        let one = g.int(1);
        self.lengths.iter().all(|length| *length == one).then(|| self.places.clone())
    }

    /// [`by_the_others`] of the coordinates over their lengths.
    pub fn by_the_others(&self, g: &mut Graph, written: Id) -> Option<Id> {
        let leaves: Vec<Id> = self.places.iter().map(|&i| g.get_leaf(Leaf::Out(i))).collect();
        let places = leaves.iter().zip(&self.lengths);
        let longer =
            sorted::map(places.clone().map(|(&leaf, &length)| (leaf, g.mul(leaf, length))));
        let shorter = sorted::map(places.map(|(&leaf, &length)| (leaf, g.div(leaf, length))));
        let of_unit = g.substitute(written, &longer);
        let short = by_the_others(g, of_unit, std::slice::from_ref(&self.places))?;
        Some(g.substitute(short, &shorter))
    }
}

/// Coordinates that are together a unit vector: those of a direction, also of one among several points, and the
/// smallest sets of coordinates of a manifold whose squares, over those of known lengths, add up to one.
pub(super) fn units(problem: &mut Problem) -> Vec<Stretched> {
    if problem.argument.is_some() {
        return vec![];
    }
    if problem.is_direction() {
        let one = problem.graph.int(1);
        return vec![Stretched { places: vec![0, 1, 2], lengths: vec![one; 3] }];
    }
    let n = problem.outputs.len();
    if problem.parts.len() > 1 {
        let mut placed = problem.placed();
        placed.retain(|(part, _)| part.target == Target::Direction);
        let one = problem.graph.int(1);
        let places = placed.into_iter().map(|(_, place)| place.map(|i| i as u8).collect());
        return places.map(|places| Stretched { places, lengths: vec![one; 3] }).collect();
    }
    let embedded = problem.parts.iter().all(|part| part.target == Target::Embedded);
    if !embedded || n > MOST {
        return vec![];
    }
    let mut sets: Vec<u32> = (0..1 << n).filter(|set: &u32| set.count_ones() > 1).collect();
    sorted::sort_by_key(&mut sets, |set| set.count_ones());
    let mut taken: Vec<u32> = vec![];
    let mut found = vec![];
    for set in sets {
        if taken.iter().any(|smaller| set & smaller == *smaller) {
            continue;
        }
        if let Some(stretched) = stretched(problem, set) {
            taken.push(set);
            found.push(stretched);
        }
    }
    found
}

/// Of more coordinates there are too many sets.
const MOST: usize = 8;

fn members(set: u32) -> Vec<u8> {
    (0..MOST as u8).filter(|i| set >> i & 1 == 1).collect()
}

/// These coordinates, if the squares of what is not known of them add up to one.
fn stretched(problem: &mut Problem, set: u32) -> Option<Stretched> {
    let g = &mut problem.graph;
    let places = members(set);
    let (mut lengths, mut squares) = (vec![], vec![]);
    for &i in &places {
        let (q, body) = g.split(problem.outputs[usize::from(i)]);
        let (open, known): (Vec<_>, Vec<_>) = g
            .factors(body)
            .into_iter()
            .partition(|&(b, e)| g.has(b, UNKNOWNS) || g.has(e, UNKNOWNS));
        let known = g.product(&known);
        lengths.push(g.sum(Q::ZERO, &[(q.abs(), known)]));
        let open = g.product(&open);
        squares.push((Q::ONE, g.powi(open, 2)));
    }
    let sum = g.sum(Q::ZERO, &squares);
    let sum = simplify(g, sum, None);
    (g.as_number(sum) == Some(Q::ONE)).then_some(Stretched { places, lengths })
}

/// An expression of a point with the squares of the others for one minus the square of a coordinate of a unit
/// vector, wherever something depends on this coordinate in no other way; `None` where nothing does.
pub(super) fn by_the_others(g: &mut Graph, written: Id, units: &[Vec<u8>]) -> Option<Id> {
    let mut id = written;
    for unit in units {
        let leaves: Vec<Id> = unit.iter().map(|&i| g.get_leaf(Leaf::Out(i))).collect();
        for &coordinate in &leaves {
            let others = leaves.iter().copied().filter(|&leaf| leaf != coordinate).collect();
            let told = Told::Others(others);
            id = Replacing { coordinate, told, memo: Map::default() }.put_into(g, id);
        }
    }
    (id != written).then_some(id)
}

/// An expression of a point with 1 - x² for the sum of the squares of the other coordinates of a unit vector, where `x`
/// is one of its places; `None` where it depends on no such sum.
pub(super) fn by_one(g: &mut Graph, written: Id, unit: &[u8], x: u8) -> Option<Id> {
    let mut others: Vec<Id> =
        unit.iter().filter(|&&i| i != x).map(|&i| g.get_leaf(Leaf::Out(i))).collect();
    let coordinate = others.pop()?;
    let told = Told::One { one: g.get_leaf(Leaf::Out(x)), others };
    let id = Replacing { coordinate, told, memo: Map::default() }.put_into(g, written);
    (id != written).then_some(id)
}

/// An expression of a point with 1 / (1 + z) for (1 - z) / (x² + y²), which says nothing at the pole, and the same on the
/// other side; `None` where it has no such quotient.
pub(super) fn by_the_other_side(g: &mut Graph, written: Id, units: &[Vec<u8>]) -> Option<Id> {
    g.with_products(written, |g, factors| {
        let mut sides = units.iter().flat_map(|unit| unit.iter().map(move |&z| (unit, z)));
        sides.find_map(|(unit, z)| quotient_of_sides(g, factors, unit, z))
    })
}

/// A product with (c - c z)ⁿ (x² + y²)⁻ⁿ as cⁿ (1 + z)⁻ⁿ, where it has these factors.
fn quotient_of_sides(g: &mut Graph, factors: &[(Id, Id)], unit: &[u8], z: u8) -> Option<Id> {
    let rest: Vec<(Q, Id)> = unit
        .iter()
        .filter(|&&i| i != z)
        .map(|&i| {
            let x = g.get_leaf(Leaf::Out(i));
            (Q::ONE, g.powi(x, 2))
        })
        .collect();
    let squares = g.sum(Q::ZERO, &rest);
    let z = g.get_leaf(Leaf::Out(z));
    let &bottom = factors.iter().find(|(base, _)| *base == squares)?;
    let (top, c, k) = factors.iter().find_map(|&(base, e)| {
        let Node::Sum(c, terms) = g.node(base).clone() else { return None };
        let sum = g.add(e, bottom.1);
        let is_side = matches!(terms[..], [(k, x)] if x == z && k.abs() == c.abs());
        let same = g.as_number(sum).is_some_and(Q::is_zero);
        (is_side && same).then(|| ((base, e), c, terms[0].0))
    })?;
    let side = g.sum(Q::ONE, &[(k.neg().mul(c.recip()?)?, z)]);
    let scale = g.number(c);
    let mut all: Vec<(Id, Id)> =
        factors.iter().copied().filter(|factor| ![top, bottom].contains(factor)).collect();
    all.extend([(scale, top.1), (side, bottom.1)]);
    Some(g.product(&all))
}

/// What the square of a coordinate is told by.
enum Told {
    /// Those of all others, none of which is taken from one.
    Others(Vec<Id>),
    /// That of a single one, where it occurs in a sum with those of the others.
    One { one: Id, others: Vec<Id> },
}

struct Replacing {
    coordinate: Id,
    told: Told,
    memo: Map<Id, Id>,
}

impl Replacing {
    /// The expression without the coordinate, if it depends on nothing but one minus its square.
    fn without(&self, g: &mut Graph, id: Id) -> Option<Id> {
        match &self.told {
            Told::Others(others) => {
                let normal = Expander::new(g).unit_with(self.coordinate, others).normal_form(id)?;
                let gone = !g.has(normal, g.deps(self.coordinate));
                (gone && !cancels(g, normal)).then_some(normal)
            }
            Told::One { one, others } => {
                let rest: Vec<Id> = others.iter().copied().chain([*one]).collect();
                let normal = Expander::new(g).unit_with(self.coordinate, &rest).normal_form(id)?;
                let mut gone = others.iter().chain([&self.coordinate]);
                gone.all(|&leaf| !g.has(normal, g.deps(leaf))).then_some(normal)
            }
        }
    }

    fn put_into(&mut self, g: &mut Graph, id: Id) -> Id {
        if id == self.coordinate || !g.has(id, g.deps(self.coordinate)) {
            return id;
        }
        if let Some(&known) = self.memo.get(&id) {
            return known;
        }
        let made = match g.node(id).clone() {
            Node::Sum(c, terms) => self.without(g, id).unwrap_or_else(|| {
                let terms: Vec<_> = terms.iter().map(|&(q, t)| (q, self.put_into(g, t))).collect();
                g.sum(c, &terms)
            }),
            Node::Product(factors) => self.in_product(g, factors),
            Node::Call(f, args) => {
                let args: Vec<Id> = args.into_iter().map(|a| self.put_into(g, a)).collect();
                g.call(f, &args)
            }
            _ => id,
        };
        self.memo.insert(id, made);
        made
    }

    /// Factors with the same exponent may depend on the square only together: (1 - x) (1 + x).
    fn in_product(&mut self, g: &mut Graph, factors: Vec<(Id, Id)>) -> Id {
        let mut groups: Vec<(Id, Vec<Id>)> = Vec::new();
        let mut product = g.int(1);
        for (base, exponent) in factors {
            if !g.has(base, g.deps(self.coordinate)) {
                let factor = g.pow(base, exponent);
                product = g.mul(product, factor);
            } else if let Some(group) = groups.iter_mut().find(|group| group.0 == exponent) {
                group.1.push(base);
            } else {
                groups.push((exponent, vec![base]));
            }
        }
        for (exponent, bases) in groups {
            let one = g.int(1);
            let together = bases.iter().fold(one, |product, &base| g.mul(product, base));
            let exponent = self.put_into(g, exponent);
            let bases = match self.without(g, together) {
                Some(short) => vec![short],
                None => bases.into_iter().map(|base| self.put_into(g, base)).collect(),
            };
            for base in bases {
                let factor = g.pow(base, exponent);
                product = g.mul(product, factor);
            }
        }
        product
    }
}

/// Whether something in a quotient of polynomials is a sum of terms of both signs.
fn cancels(g: &Graph, id: Id) -> bool {
    let both = |id: Id| matches!(g.node(id), Node::Sum(..)) && !one_sign(g, id);
    match g.node(id) {
        Node::Product(factors) => factors.iter().any(|&(base, _)| both(base)),
        _ => both(id),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Item;
    use crate::interval::Interval;

    #[test]
    fn what_depends_on_one_minus_a_square_is_had_from_the_others() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let [x, y, z] =
            [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], signed));
        let [up, down] = [1, -1].map(|s| g.sum(Q::ONE, &[(Q::int(s), z)]));
        let [root, other] = [up, down].map(|side| g.sqrt(side));
        let length = g.mul(root, other);
        let quotient = g.div(x, length);
        let squares = [x, y].map(|c| (Q::ONE, g.powi(c, 2)));
        let sum = g.sum(Q::ZERO, &squares);
        let hypotenuse = g.sqrt(sum);
        let expected = g.div(x, hypotenuse);
        let units = [vec![0, 1, 2]];
        assert_eq!(by_the_others(&mut g, quotient, &units), Some(expected));
        assert_eq!(by_the_others(&mut g, expected, &units), None);
        // On its own, a factor stays.
        assert_eq!(by_the_others(&mut g, root, &units), None);
    }

    #[test]
    fn a_quotient_that_says_nothing_at_a_pole_is_had_from_the_other_side() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let [x, y, z] =
            [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], signed));
        let squares = [x, y].map(|c| (Q::ONE, g.powi(c, 2)));
        let squares = g.sum(Q::ZERO, &squares);
        for side in [1, -1].map(Q::int) {
            let below = g.sum(Q::HALF, &[(Q::HALF.mul(side.neg()).unwrap(), z)]);
            let quotient = g.div(below, squares);
            let written = g.mul(x, quotient);
            let written = g.add(y, written);
            let above = g.sum(Q::ONE, &[(side, z)]);
            let expected = g.div(x, above);
            let expected = g.sum(Q::ZERO, &[(Q::ONE, y), (Q::HALF, expected)]);
            assert_eq!(by_the_other_side(&mut g, written, &[vec![0, 1, 2]]), Some(expected));
        }
        let alone = g.div(x, squares);
        assert_eq!(by_the_other_side(&mut g, alone, &[vec![0, 1, 2]]), None);
    }

    #[test]
    fn next_to_the_tip_of_a_needle_the_short_axes_tell() {
        let text = "fn ellipsoid(u: [Uniform; 2], a: f64, b: f64, c: f64) -> Surface {
            let z = 1.0 - 2.0 * u[0];
            let r = (1.0 - z * z).sqrt();
            let phi = TAU * u[1];
            Surface::new(a * r * phi.cos(), b * r * phi.sin(), c * z)
        }";
        let item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        // The area is stretched by the root of (b c x / a)² + (a c y / b)² + (a b z / c)², and z is rounded to c.
        let pdf = item.pdf(&[1.0, 1.0, 1e9], &[1e-9, 0.0, 1e9]);
        let truth = 1.0 / (4.0 * std::f64::consts::PI * 2f64.sqrt());
        assert!((pdf / truth - 1.0).abs() < 1e-14, "{pdf} is not {truth}");
    }

    #[test]
    fn lengths_that_are_not_known_stretch_nothing() {
        let text = "fn spiral(u: [Uniform; 2], a: f64) -> Surface {
            let phi = TAU * u[1];
            Surface::new(a * u[0] * phi.cos(), a * u[0] * phi.sin(), u[1])
        }";
        let mut item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        assert!(units(&mut item.parsed.pieces[0].problem).is_empty());
    }

    #[test]
    fn a_sum_of_squares_is_had_from_the_coordinate_that_is_not_in_it() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let [x, y, z] =
            [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), ["x", "y", "z"][i as usize], signed));
        let squares = [x, y].map(|c| (Q::ONE, g.powi(c, 2)));
        let exponent = g.leaf(Leaf::Param(0), "k", Interval::new(0.0, 1e3));
        let sum = g.sum(Q::ZERO, &squares);
        let written = g.pow(sum, exponent);
        let sides = [1, -1].map(|s| g.sum(Q::ONE, &[(Q::int(s), z)]));
        let [up, down] = sides.map(|side| g.pow(side, exponent));
        let expected = g.mul(up, down);
        assert_eq!(by_one(&mut g, written, &[0, 1, 2], 2), Some(expected));
        assert_eq!(by_one(&mut g, written, &[0, 1, 2], 0), None);
        // One square alone says nothing of the height alone.
        let alone = g.pow(x, exponent);
        assert_eq!(by_one(&mut g, alone, &[0, 1, 2], 2), None);
    }
}
