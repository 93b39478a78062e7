//! The map of a preimage in terms of the point: by it a point is seen to lie on the manifold of images
//! without the angles that its unknowns are.

use std::collections::BTreeMap;

use super::Problem;
use super::cases::Case;
use super::holding::never_negative;
use super::implied::implied;
use super::pick::pick;
use super::recognised::recognised;
use super::scaled::{Scaled, scaled};
use crate::expr::{Graph, Id, Leaf, Node};
use crate::jacobian::{cost_together, simplify};
use crate::measure::Measure;
use crate::rational::Q;
use crate::solve::Solution;
use crate::sorted;

/// 1 - x, where x is a part of a whole, a / (a + b): the rest of it, b / (a + b).
fn complement(g: &mut Graph, x: Id) -> Option<Id> {
    let Node::Product(factors) = g.node(x).clone() else { return None };
    factors.into_iter().find_map(|(whole, _)| {
        let part = g.mul(x, whole);
        let rest = g.sub(whole, part);
        (terms(g, part) + terms(g, rest) == terms(g, whole)).then(|| g.div(rest, whole))
    })
}

/// How many terms a sum has; anything else is one.
fn terms(g: &Graph, id: Id) -> usize {
    match g.node(id) {
        Node::Sum(c, terms) => terms.len() + usize::from(!c.is_zero()),
        _ => 1,
    }
}

/// The image of the unknowns that a point has.
pub struct Image {
    /// Its coordinates.
    pub coordinates: Vec<Id>,
    /// Quotients that several products among these have as factors.
    pub shared: Vec<Id>,
    /// What must not be negative for these to be it.
    pub conditions: Vec<Id>,
    /// How it is a multiple of the point, if it is one in a simple way.
    pub scaled: Option<Scaled>,
    /// Otherwise, the factor by which each coordinate is that of the point, if it is one for all.
    pub factor: Option<Id>,
}

impl Image {
    /// All that is computed to have it.
    pub(super) fn expressions(&mut self) -> impl Iterator<Item = &mut Id> {
        self.coordinates.iter_mut().chain(&mut self.shared).chain(&mut self.factor)
    }
}

/// The quotients that products among some expressions have in common, the longest first.
fn shared(g: &mut Graph, ids: &[Id]) -> Vec<Id> {
    let mut products: Vec<Vec<(Id, Id)>> = Vec::new();
    for &id in ids {
        let terms = match g.node(id) {
            Node::Sum(_, terms) => terms.iter().map(|(_, term)| *term).collect(),
            _ => vec![id],
        };
        products.extend(terms.into_iter().map(|term| g.factors(term)));
    }
    let mut found: Vec<Vec<(Id, Id)>> = Vec::new();
    for (i, one) in products.iter().enumerate() {
        for other in &products[..i] {
            let common: Vec<(Id, Id)> = one.iter().filter(|f| other.contains(f)).copied().collect();
            let divides = |(_, e): &(Id, Id)| g.as_number(*e).is_some_and(Q::is_negative);
            if common.len() > 1 && common.len() < one.len() && common.iter().any(divides) {
                found.push(common);
            }
        }
    }
    sorted::sort_by_key(&mut found, |common| std::cmp::Reverse(common.len()));
    found.dedup();
    found.iter().map(|common| g.product(common)).collect()
}

/// The factor by which all coordinates of an image are those of the point.
fn factor(g: &mut Graph, image: &[Id]) -> Option<Id> {
    let mut common = None;
    for (i, &coordinate) in image.iter().enumerate() {
        let x = g.get_leaf(Leaf::Out(i as u8));
        let mut others = g.factors(coordinate);
        others.retain(|&(base, _)| base != x);
        let factor = g.product(&others);
        if g.mul(x, factor) != coordinate || *common.get_or_insert(factor) != factor {
            return None;
        }
    }
    common
}

/// The image of the unknowns that a point has; `None` where that costs as much as to compute the unknowns and to map
/// them.
pub(super) fn back(
    problem: &mut Problem,
    (forward, unknowns): (&[Id], &[Id]),
    solution: &Solution,
    cases: &[Case],
    measure: &mut Measure,
) -> Option<Image> {
    let implied = implied(problem, solution, cases);
    let g = &mut problem.graph;
    let of_leaf = |leaf: &Leaf| (g.get_leaf(*leaf), solution.unknowns[leaf]);
    let mut values = sorted::map(problem.unknowns.iter().map(of_leaf));
    // Next to its end, an unknown does not tell how far it is from one.
    for (unknown, value) in values.clone() {
        let rest = g.sum(Q::ONE, &[(Q::int(-1), unknown)]);
        values.extend(complement(g, value).map(|known| (rest, known)));
    }
    let mut ways = vec![(BTreeMap::new(), vec![])];
    // Where nothing is implied there is no second way.
    if !implied.is_empty() {
        let conditions = solution.conditions.iter().map(|c| c.0);
        let conditions = conditions.filter(|&c| !never_negative(g, c)).collect();
        ways.push((implied, conditions));
    }
    let mut images = vec![];
    for (known, conditions) in ways {
        let mut coordinates = Vec::new();
        for (i, (&written, &stable)) in problem.outputs.iter().zip(forward).enumerate() {
            let truth: Vec<f64> = cases.iter().map(|c| c.outs[i]).collect();
            let mut forms = Vec::new();
            let known = [written, stable].map(|form| recognised(g, form, &known));
            for form in known.concat() {
                let image = g.substitute(form, &values);
                let image = solution.spell_out(g, image);
                forms.extend([image, simplify(g, image, None)]);
            }
            sorted::sort(&mut forms);
            forms.dedup();
            coordinates.push(pick(g, &forms, &truth, measure).0);
        }
        let shared = shared(g, &coordinates);
        images.push(Image { coordinates, conditions, shared, scaled: None, factor: None });
    }
    let cost = |g: &Graph, image: &Image| {
        cost_together(g, &[&image.coordinates[..], &image.conditions].concat())
    };
    // What would be the point itself tells nothing of it.
    let point: Vec<Id> = (0..forward.len()).map(|i| g.get_leaf(Leaf::Out(i as u8))).collect();
    images.retain(|image| image.coordinates != point);
    let mut image = images.into_iter().min_by_key(|image| cost(g, image))?;
    image.scaled = scaled(g, &image.coordinates);
    if image.scaled.is_none() {
        image.factor = factor(g, &image.coordinates);
    }
    let otherwise: Vec<Id> = forward.iter().chain(unknowns).copied().collect();
    let shorter = cost(g, &image) < cost_together(g, &otherwise);
    shorter.then_some(image)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Evaluator;
    use crate::interpret::Item;
    use crate::interval::Interval;

    #[test]
    fn what_an_unknown_lacks_to_one() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Out(i), "x", Interval::new(0.0, 9.0)));
        let c = g.div(a, b);
        let whole = g.sum(Q::ONE, &[(Q::ONE, c)]);
        let x = g.div(c, whole);
        let rest = g.powi(whole, -1);
        assert_eq!(complement(&mut g, x), Some(rest));
        let other = g.div(a, whole);
        assert_eq!(complement(&mut g, other), None);
        assert_eq!(complement(&mut g, a), None);
        // A part of a whole of several terms.
        let d = g.leaf(Leaf::Out(2), "z", Interval::new(0.0, 9.0));
        let part = g.add(a, b);
        let whole = g.add(part, d);
        let (x, rest) = (g.div(part, whole), g.div(d, whole));
        assert_eq!(complement(&mut g, x), Some(rest));
    }

    /// The image that a point has, and whether conditions hold.
    fn image(item: &Item, p: &[f64], point: [f64; 3]) -> ([f64; 3], bool) {
        let g = &item.parsed.pieces[0].problem.graph;
        let Some(image) = &item.derived[0].preimages[0].back else { panic!("no image") };
        let at = |leaf| match leaf {
            Leaf::Param(i) => p[usize::from(i)],
            Leaf::Out(i) => point[usize::from(i)],
            _ => f64::NAN,
        };
        let mut e = Evaluator::<f64>::new(g, &at);
        let coordinates = std::array::from_fn(|i| e.value(image.coordinates[i]));
        (coordinates, image.conditions.iter().all(|id| e.value(*id) >= 0.0))
    }

    fn item(text: &str) -> Item {
        Item::new(Default::default(), text.parse().unwrap(), true).unwrap()
    }

    fn close(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15)
    }

    #[test]
    fn the_image_of_a_triangle_is_a_sum_of_edges_where_it_is_no_reflection() {
        let triangle = item(
            "fn triangle(u: [Uniform; 2], a: Vec3, b: Vec3, c: Vec3) -> Surface {
                let s = (1.0 - u[0]).sqrt();
                Surface::from_vec(a + s * (1.0 - u[1]) * (b - a) + s * u[1] * (c - a))
            }",
        );
        let p = [0.1, 0.2, 0.3, 1.1, 0.2, 0.3, 0.1, 2.2, 0.3];
        // Above the triangle, its foot; on the other side of the first corner the uniforms are the same.
        for (x, y, lies) in [(0.3, 0.4, true), (-0.3, -0.4, false)] {
            let (foot, plain) = image(&triangle, &p, [0.1 + x, 0.2 + y, 7.0]);
            assert!(close(foot, [0.1 + x, 0.2 + y, 0.3]) && plain == lies, "{foot:?}, {plain}");
        }
    }

    #[test]
    fn what_holds_on_a_manifold_alone_is_no_part_of_images() {
        let sphere = item(
            "fn sphere(u: [Uniform; 2], r: f64) -> Surface {
                let z = 1.0 - 2.0 * u[0];
                let s = (1.0 - z * z).sqrt();
                let phi = TAU * u[1];
                Surface::new(r * s * phi.cos(), r * s * phi.sin(), r * z)
            }",
        );
        // At this height, in this direction from the axis.
        let (found, _) = image(&sphere, &[2.0], [0.3, 0.4, 1.0]);
        let s = 3.0f64.sqrt();
        assert!(close(found, [0.6 * s, 0.8 * s, 1.0]), "{found:?}");
    }

    #[test]
    fn an_image_is_a_multiple_of_the_point_where_one_factor_is_that_of_all_coordinates() {
        let mut g = Graph::new();
        let [x, y, r] = [Leaf::Out(0), Leaf::Out(1), Leaf::Param(0)]
            .map(|leaf| g.leaf(leaf, "x", Interval::new(0.0, 9.0)));
        let by = g.div(r, y);
        let [of_x, of_y, of_r] = [x, y, r].map(|coordinate| g.mul(coordinate, by));
        // As long as the point's own coordinate is seen in it.
        assert_eq!(of_y, r);
        assert_eq!(factor(&mut g, &[of_x, of_y]), None);
        assert_eq!(factor(&mut g, &[of_x, of_r]), None);
        let by = g.add(by, r);
        let [of_x, of_y] = [x, y].map(|coordinate| g.mul(coordinate, by));
        assert_eq!(factor(&mut g, &[of_x, of_y]), Some(by));
        assert_eq!(factor(&mut g, &[of_y, of_x]), None);
        assert_eq!(factor(&mut g, &[of_x, y]), None);
    }

    #[test]
    fn products_share_their_longest_quotients() {
        let mut g = Graph::new();
        let [a, b, c, d] =
            [0, 1, 2, 3].map(|i| g.leaf(Leaf::Out(i), "x", Interval::new(-9.0, 9.0)));
        let bc = g.div(b, c);
        let [abc, dbc, bbc] = [a, d, b].map(|factor| g.mul(factor, bc));
        let sum = g.add(abc, dbc);
        assert_eq!(shared(&mut g, &[sum, bbc, a]), [bc]);
        assert_eq!(shared(&mut g, &[abc, bc]), []);
    }
}
