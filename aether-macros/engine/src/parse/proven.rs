//! Comparisons that come out alike everywhere although the ranges of what is compared overlap.
//!
//! `(1.0 - c * c).max(0.0)` keeps rounding from the root of a negative number, and is 1 - c² for all uniforms. The ranges of
//! inputs do not say so where c is more than a uniform; the factors of the difference do.

use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf, Node};
use crate::interval::Interval;
use crate::monotone::{any_input, seen_sign, sign_of};
use crate::number::{Dd, Number};
use crate::poly::{Expander, Poly, start_budget};
use crate::rational::Q;

/// Polynomials in more inputs are not looked at in the corners.
const MOST_INPUTS: usize = 6;

/// The sign of an expression that is proven never to have the other one, over the declared domains of all inputs; it may
/// be zero here and there.
pub(super) fn sign(g: &Graph, difference: Id) -> Option<i64> {
    let seen = seen_sign(g, difference)?;
    // Of what is tried nothing is to be left in the graph, as the order of sums follows that in which parts came.
    let mut g = g.clone();
    start_budget();
    let proven = one_sign(&mut g, difference);
    start_budget();
    // Which it is, the points tell.
    proven.map(|()| seen)
}

/// Proves that every factor of an expression has one sign.
fn one_sign(g: &mut Graph, id: Id) -> Option<()> {
    let range = g.range(id);
    if range.nonnegative() || range.nonpositive() {
        return Some(());
    }
    let whole = Expander::new(g).expand(id)?;
    let (rest, ends) = without_ends(g, whole.num)?;
    let factors = ends.into_iter().chain(rest.split()).chain(whole.den);
    let odd: Vec<Poly> = factors.filter(|(_, e)| e % 2 == 1).map(|(factor, _)| factor).collect();
    odd.iter().try_for_each(|factor| has_one_sign(g, factor).then_some(()))
}

/// A polynomial without the factors 1 - a and 1 + a for inputs a, which are zero at ends of ranges, and these with their
/// exponents.
fn without_ends(g: &Graph, whole: Poly) -> Option<(Poly, Vec<(Poly, u32)>)> {
    let (mut rest, mut found) = (whole, vec![]);
    for atom in rest.atoms().into_iter().filter(|a| matches!(g.node(*a), Node::Leaf(_))) {
        for sign in [-1, 1] {
            let end = Poly::atom(atom).scale(Q::int(sign))?.add(&Poly::constant(Q::ONE))?;
            let mut times = 0;
            while let Some(quotient) = rest.exact_div(&end) {
                (rest, times) = (quotient, times + 1);
            }
            found.push((end, times));
        }
    }
    Some((rest, found))
}

fn has_one_sign(g: &mut Graph, factor: &Poly) -> bool {
    let id = factor.to_expr(g);
    let range = g.range(id);
    if range.nonnegative() || range.nonpositive() || at_corners(g, factor, id) {
        return true;
    }
    any_input(g, id).is_some_and(|input| sign_of(g, id, input).is_ok())
}

/// Whether a polynomial that is linear in each of a few inputs has one sign at all corners of their ranges, and with that
/// inside.
fn at_corners(g: &Graph, factor: &Poly, id: Id) -> bool {
    let input = |atom: Id| {
        let Node::Leaf(leaf) = g.node(atom) else { return None };
        let linear = factor.by_powers_of(atom)?.len() <= 2;
        let range = g.range(atom);
        (linear && range.width().is_finite()).then_some((*leaf, range))
    };
    let inputs: Option<Vec<(Leaf, Interval)>> = factor.atoms().into_iter().map(input).collect();
    let Some(inputs) = inputs.filter(|inputs| inputs.len() <= MOST_INPUTS) else { return false };
    let values = (0..1 << inputs.len()).map(|corner: usize| {
        let value = |leaf: Leaf| {
            let place = inputs.iter().position(|input| input.0 == leaf);
            place.map_or(f64::NAN, |k| {
                let range = inputs[k].1;
                if corner >> k & 1 == 0 { range.lo } else { range.hi }
            })
        };
        evaluate::<Dd>(g, id, &|leaf| Dd::from_f64(value(leaf))).to_f64()
    });
    let values: Vec<f64> = values.collect();
    values.iter().all(|v| *v >= 0.0) || values.iter().all(|v| *v <= 0.0)
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    fn item(domain: &str, source: &str) -> Result<Item, String> {
        Item::new(domain.parse().unwrap(), source.parse().unwrap(), true)
    }

    /// A direction by its height, as renderers write it.
    fn direction(domain: &str, height: &str) -> Result<Item, String> {
        let body = "let s = (1.0 - c * c).max(0.0).sqrt(); let phi = TAU * u[1];
            Direction::new(s * phi.cos(), s * phi.sin(), c)";
        let text =
            format!("fn f(u: [Uniform; 2], p: f64) -> Direction {{ let c = {height}; {body} }}");
        item(domain, &text)
    }

    #[test]
    fn what_keeps_rounding_away_is_no_branch() {
        let heights = [
            ("p in -1.0..=0.99", "1.0 - u[0] + u[0] * p"),
            ("p in -1.0..=0.99", "u[0] + (1.0 - u[0]) * p"),
            ("p in 0.001..=1.0", "((1.0 - u[0]) / (1.0 + (p * p - 1.0) * u[0])).sqrt()"),
            ("p in 0.0..=1e4", "u[0].powf(1.0 / (p + 1.0))"),
            (
                "p in -0.99..=0.99",
                "{ let s = (1.0 - p * p) / (1.0 - p + 2.0 * p * u[0]); (1.0 + p * p - s * s) / (2.0 * p) }",
            ),
        ];
        for (domain, height) in heights {
            let item = direction(domain, height).unwrap_or_else(|e| panic!("{height}: {e}"));
            assert_eq!(item.derived.len(), 1, "{height}");
        }
    }

    #[test]
    fn what_is_never_exceeded_is_no_branch_either() {
        let text =
            "fn f(u: [Uniform; 1], p: f64) -> f64 { (u[0] + p * u[0] * (1.0 - u[0])).min(1.0) }";
        assert_eq!(item("p in 0.0..=1.0", text).unwrap().derived.len(), 1);
        // It may be.
        assert!(item("p in 0.0..=2.0", text).is_err());
    }

    #[test]
    fn a_comparison_that_comes_out_both_ways_forks() {
        let text = "fn f(u: [Uniform; 1], p: f64) -> f64 { let x = u[0] - p * (1.0 - u[0]); if x < 0.0 { x } else { 2.0 * x } }";
        assert_eq!(item("p in 0.5..=2.0", text).unwrap().derived.len(), 2);
    }
}
