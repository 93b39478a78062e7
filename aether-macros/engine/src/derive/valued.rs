//! Sums of a density that tests of the point have computed in another form: what a determinant is, or the square of an
//! area, is told by its values, which are the same number times those of the other form wherever both are tried. Sums of
//! products of inputs that have the same values at so many points are the same everywhere.

use super::cases::Case;
use super::one_root::over_its_root;
use super::{Limit, Preimage};
use crate::eval::Evaluator;
use crate::expr::{Fun, Graph, Id, Node};
use crate::jacobian::{cost, cost_together};
use crate::measure::Measure;
use crate::number::{Dd, Number};
use crate::rational::Q;
use crate::sorted;

/// How far quotients of values of one form by those of another may differ: there are 31 digits, but for what cancels.
const SAME: f64 = 1e-22;
/// At how many points both forms must have had a value.
const FEWEST: usize = 8;
/// The largest numerator and denominator of how many times the one is the other.
const LARGEST: i64 = 24;

/// Has the density of a point be made of sums that its tests compute, where that costs less and is as accurate.
pub(super) fn share_values(g: &mut Graph, preimage: &mut Preimage, measure: &mut Measure) {
    if let Some(shorter) = over_its_root(g, preimage.density) {
        let truth = measure.truths(g, preimage.density);
        if is_as_good(g, [shorter, preimage.density], &truth, measure) {
            preimage.density = shorter;
        }
    }
    let tests = computed(preimage);
    let (known, mut own) = (sums(g, &tests), sums(g, &[preimage.density]));
    own.retain(|sum| !known.contains(sum));
    if known.is_empty() || own.is_empty() {
        return;
    }
    let truth = measure.truths(g, preimage.density);
    let cost = |g: &Graph, density: Id| cost_together(g, &[&tests[..], &[density]].concat());
    // The largest first, as what they are made of may go with them.
    for sum in own {
        let density = preimage.density;
        let shared = known.iter().filter_map(|&other| {
            let times = times(g, [sum, other], measure)?;
            let form = with_multiple(g, density, sum, (times, other));
            (cost(g, form) < cost(g, density)).then_some(form)
        });
        let shared: Vec<Id> = shared.collect();
        if let Some(form) =
            shared.into_iter().find(|f| is_as_good(g, [*f, density], &truth, measure))
        {
            preimage.density = form;
        }
    }
}

/// A density with sums in place of others that have the same values or the opposite ones at all points of a manifold,
/// where that costs less: of a plane the height of a point above another one's is that of its foot.
pub(super) fn merged(g: &mut Graph, density: Id, cases: &[Case]) -> Option<Id> {
    let value = |g: &Graph, id: Id, case: &Case| {
        let at = |leaf| case.point.input(leaf, &case.exact_outs);
        Evaluator::<Dd>::new(g, &at).value(id)
    };
    let all = sums(g, &[density]);
    let values =
        |id: &Id| cases.iter().filter(|c| c.is_plain()).map(|case| value(g, *id, case)).collect();
    let values: Vec<Vec<Dd>> = all.iter().map(values).collect();
    let mut best = density;
    for (i, &one) in all.iter().enumerate() {
        for (j, &other) in all.iter().enumerate() {
            let times = if i == j { None } else { multiple([&values[j], &values[i]]) };
            if let Some(times) = times.filter(|times| times.abs() == Q::ONE) {
                let form = with_multiple(g, density, other, (times, one));
                let form = sizes_together(g, form, one);
                if cost(g, form) < cost(g, best) {
                    best = form;
                }
            }
        }
    }
    (best != density).then_some(best)
}

/// An expression with even powers of a number as such of its size, where that is a factor too: |x|³ / x² is |x|.
fn sizes_together(g: &mut Graph, id: Id, x: Id) -> Id {
    let size = g.call(Fun::Abs, &[x]);
    let together = g.with_products(id, |g, factors| {
        let exponent = |of: Id| factors.iter().find(|(base, _)| *base == of).map(|(_, e)| *e);
        let (of_size, of_x) = (exponent(size)?, exponent(x)?);
        let is_even = g.as_number(of_x).is_some_and(Q::is_even);
        let others = factors.iter().filter(|(base, _)| ![x, size].contains(base)).copied();
        let all: Vec<(Id, Id)> = others.chain([(size, g.add(of_size, of_x))]).collect();
        is_even.then(|| g.product(&all))
    });
    together.unwrap_or(id)
}

/// An expression with a sum replaced by a multiple of another one, which stays a part of its own.
fn with_multiple(g: &mut Graph, id: Id, sum: Id, (times, other): (Q, Id)) -> Id {
    let number = g.number(times);
    let powers = |g: &Graph, e: Id| {
        let whole = g.as_number(e).is_some_and(|e| e.is_int() || !times.is_negative());
        if whole { vec![(number, e), (other, e)] } else { vec![(sum, e)] }
    };
    let replaced = g.with_products(id, |g, factors| {
        factors.iter().any(|(base, _)| *base == sum).then(|| {
            let all = factors.iter().flat_map(|&(base, e)| match base == sum {
                true => powers(g, e),
                false => vec![(base, e)],
            });
            let all: Vec<(Id, Id)> = all.collect();
            g.product(&all)
        })
    });
    let [size, other_size] = [sum, other].map(|id| g.call(Fun::Abs, &[id]));
    let [value, value_of_size] =
        [(times, other), (times.abs(), other_size)].map(|term| g.sum(Q::ZERO, &[term]));
    g.substitute(replaced.unwrap_or(id), &[(sum, value), (size, value_of_size)].into())
}

/// Whether a form is about as accurate as another one, or accurate.
fn is_as_good(g: &Graph, forms: [Id; 2], truth: &[f64], measure: &mut Measure) -> bool {
    let [form, other] = forms.map(|form| measure.loss(g, form, truth));
    (0..2).all(|part| {
        let [a, b] = [form, other].map(|loss| loss.parts()[part]);
        a.bits <= b.bits + 0.5 && a.worst <= (2.0 * b.worst).max(16.0 * f64::EPSILON)
    })
}

/// What is computed of a point to see whether it plainly has a preimage.
fn computed(preimage: &Preimage) -> Vec<Id> {
    let mut found: Vec<Id> = [&preimage.asked[..], &preimage.requirements].concat();
    for (i, &unknown) in preimage.tested.iter().enumerate() {
        match (&preimage.borders[i], &preimage.signs[i]) {
            (Some(border), _) => {
                found.extend(border.ends.iter().filter_map(|end| match end {
                    Limit::At(id) => Some(*id),
                    Limit::Below | Limit::Above => None,
                }));
            }
            (None, Some(signs)) => found.extend(signs.at_least_zero.iter().chain(&signs.positive)),
            (None, None) => found.push(unknown),
        }
    }
    if let Some(image) = &preimage.back {
        match &image.scaled {
            Some(scaled) => found.extend([scaled.excess, scaled.below, scaled.sizes]),
            None => found.extend(&image.coordinates),
        }
    }
    found
}

/// The sums of several products of inputs in some expressions, those first that cost most.
fn sums(g: &Graph, ids: &[Id]) -> Vec<Id> {
    let composed = |(_, term): &(Q, Id)| !matches!(g.node(*term), Node::Leaf(_));
    let is_sum =
        |id: Id| matches!(g.node(id), Node::Sum(_, t) if t.len() > 1 && t.iter().any(composed));
    let mut found = g.within(ids);
    found.retain(|&id| is_sum(id) && is_polynomial(g, id));
    sorted::sort_by_key(&mut found, |id| std::cmp::Reverse(cost(g, *id)));
    found
}

/// Whether an expression is made of inputs by sums and products alone.
fn is_polynomial(g: &Graph, id: Id) -> bool {
    match g.node(id) {
        Node::Leaf(_) | Node::Number(_) => true,
        Node::Sum(_, terms) => terms.iter().all(|(_, term)| is_polynomial(g, *term)),
        Node::Product(factors) => factors.iter().all(|(base, e)| {
            let whole = g.as_number(*e).is_some_and(|e| e.is_int() && !e.is_negative());
            whole && is_polynomial(g, *base)
        }),
        _ => false,
    }
}

/// How many times the values of one form are those of the other at all points, if it is a number of few digits.
fn times(g: &Graph, forms: [Id; 2], measure: &mut Measure) -> Option<Q> {
    if g.deps(forms[0]) != g.deps(forms[1]) {
        return None;
    }
    let [a, b] = forms.map(|id| measure.precisely(g, id));
    multiple([&a, &b])
}

/// The same of values.
fn multiple([a, b]: [&[Dd]; 2]) -> Option<Q> {
    let told = |x: &Dd| x.to_f64().is_finite() && x.to_f64() != 0.0;
    let mut ratios = a.iter().zip(b).filter(|(a, b)| told(a) || told(b)).map(|(a, b)| *a / *b);
    let first = ratios.next()?;
    let number = short(first.to_f64())?;
    let exact = <Dd as Number>::from_ratio(number.num(), number.den());
    let is_same = |ratio: &Dd| (*ratio - exact).abs().to_f64() <= SAME * exact.abs().to_f64();
    let mut count = usize::from(is_same(&first));
    let same = count == 1 && ratios.inspect(|_| count += 1).all(|ratio| is_same(&ratio));
    (same && count >= FEWEST).then_some(number)
}

/// The quotient of small numbers next to a value.
fn short(value: f64) -> Option<Q> {
    (1..=LARGEST).find_map(|den| {
        let num = (value * den as f64).round();
        let near = (num / den as f64 - value).abs() <= 1e-14 * value.abs();
        let fits = num != 0.0 && num.abs() <= LARGEST as f64;
        (near && fits).then(|| Q::new(num as i128, i128::from(den)))?
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interpret::Item;
    use crate::interval::Interval;
    use crate::measure::Inputs;
    use crate::points::Rng;

    /// Leaves a, b, c, d with many values, and the measure of these.
    fn graph() -> (Graph, [Id; 4], Measure) {
        let (mut g, mut rng) = (Graph::new(), Rng::new(7));
        let leaves = [0, 1, 2, 3].map(Leaf::Param);
        let ids = leaves.map(|leaf| g.leaf(leaf, "p", Interval::ALL));
        let mut point = || Inputs::from_iter(leaves.map(|leaf| (leaf, 4.0 * rng.uniform() - 2.0)));
        let points = (0..FEWEST + 4).map(|_| point()).collect();
        (g, ids, Measure::new(points, vec![]))
    }

    #[test]
    fn multiples_are_told_by_their_values() {
        let (mut g, [a, b, c, d], mut measure) = graph();
        let [sum, rest] = [g.add(a, b), g.sub(c, d)];
        let product = g.mul(sum, rest);
        let terms = [(a, c, 1), (a, d, -1), (b, c, 1), (b, d, -1)];
        let terms = terms.map(|(x, y, sign)| (Q::new(3 * sign, 2).unwrap(), g.mul(x, y)));
        let written = g.sum(Q::ZERO, &terms);
        assert_eq!(times(&g, [written, product], &mut measure), Q::new(3, 2));
        assert_eq!(times(&g, [product, written], &mut measure), Q::new(2, 3));
        // Alike but for one part in 2^40, and of other inputs.
        let near = g.sum(Q::ZERO, &[(Q::ONE, written), (Q::new(1, 1 << 40).unwrap(), a)]);
        assert_eq!(times(&g, [near, product], &mut measure), None);
        assert_eq!(times(&g, [sum, product], &mut measure), None);
    }

    #[test]
    fn a_multiple_stays_a_part_of_its_own() {
        let (mut g, [a, b, c, d], _) = graph();
        let [ab, cd] = [g.mul(a, b), g.mul(c, d)];
        let [sum, other] = [g.add(ab, c), g.add(cd, a)];
        let (root, size) = (g.sqrt(sum), g.call(Fun::Abs, &[sum]));
        let quarter = Q::new(1, 4).unwrap();
        let found = with_multiple(&mut g, root, sum, (quarter, other));
        let expected = g.sqrt(other);
        assert_eq!(found, g.sum(Q::ZERO, &[(Q::HALF, expected)]));
        let found = with_multiple(&mut g, size, sum, (quarter.neg(), other));
        let expected = g.call(Fun::Abs, &[other]);
        assert_eq!(found, g.sum(Q::ZERO, &[(quarter, expected)]));
    }

    #[test]
    fn the_size_of_a_number_and_its_even_powers_are_one_power() {
        let (mut g, [a, b, c, _], _) = graph();
        let ab = g.mul(a, b);
        let x = g.add(ab, c);
        let size = g.call(Fun::Abs, &[x]);
        let mut power = |of: Id, e: i64| g.powi(of, e);
        let [cubed, over, over_cube] = [power(size, 3), power(x, -2), power(x, -3)];
        let [even, odd] = [over, over_cube].map(|over| g.mul(cubed, over));
        assert_eq!(sizes_together(&mut g, even, x), size);
        assert_eq!(sizes_together(&mut g, odd, x), odd);
    }

    #[test]
    fn roots_and_functions_are_no_sums_of_products() {
        let (mut g, [a, b, c, _], _) = graph();
        let (ab, root, over) = (g.mul(a, b), g.sqrt(a), g.div(a, b));
        let [plain, rooted, divided] = [ab, root, over].map(|term| g.add(term, c));
        let one = g.int(1);
        let all = g.product(&[plain, rooted, divided].map(|id| (id, one)));
        assert_eq!(sums(&g, &[all]), [plain]);
    }

    #[test]
    fn the_volume_of_a_tetrahedron_is_what_its_tests_divide_by() {
        let text = "fn tetrahedron(u: [Uniform; 3], a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> Vec3 {
            let r = u[0].cbrt();
            let s = u[1].sqrt();
            a + r * (1.0 - s) * (b - a) + r * s * (1.0 - u[2]) * (c - a) + r * s * u[2] * (d - a)
        }";
        let item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        let (g, preimage) = (&item.parsed.pieces[0].problem.graph, &item.derived[0].preimages[0]);
        let tests = computed(preimage);
        let alone = cost_together(g, &tests);
        // A quotient by its size is all that comes to them.
        let more = cost_together(g, &[&tests[..], &[preimage.density]].concat()) - alone;
        assert!(more < 12, "{more}");
        let p = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.3, 1.5, 0.0, 0.1, 0.2, -1.1];
        let density = item.pdf(&p, &[0.4, 0.3, -0.2]);
        assert!((density * 2.0 * 1.5 * 1.1 / 6.0 - 1.0).abs() < 1e-14, "{density}");
    }
}
