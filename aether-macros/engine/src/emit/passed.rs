//! Tests that a difference is positive or not negative, by its two sides: rounding keeps the order of two numbers, so that
//! they need not be subtracted.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::{Code, integer_power, multiple_of, rational};
use crate::expr::{Id, Node};
use crate::parse::Test;
use crate::rational::Q;
use crate::sorted;

/// The conjunction of some tests.
pub(super) fn passed(code: &mut Code, tests: &[Test]) -> TokenStream {
    let tests = tests.iter().map(|test| exceeds(code, test.difference, test.strict));
    let tests: TokenStream = tests.collect();
    quote!(<R::Mask as Mask>::TRUE #tests)
}

/// The test that a difference is positive if `strict`, and otherwise that it is not negative, to be joined to a mask.
pub(super) fn exceeds(code: &mut Code, difference: Id, strict: bool) -> TokenStream {
    let [above, below] =
        sides(code, difference).unwrap_or_else(|| [code.value(difference), quote!(R::ZERO)]);
    if strict { quote!(.and(#above.gt(#below))) } else { quote!(.and(#above.ge(#below))) }
}

/// What a difference of two is of, as it would be rounded there.
fn sides(code: &mut Code, difference: Id) -> Option<[TokenStream; 2]> {
    let Node::Sum(c, terms) = code.graph().node(difference) else { return None };
    let constant = (!c.is_zero()).then_some((*c, None));
    let terms = terms.iter().map(|&(q, term)| (q, Some(term)));
    let mut both: Vec<(Q, Option<Id>)> = constant.into_iter().chain(terms).collect();
    sorted::sort_by_key(&mut both, |(q, _)| q.is_negative());
    let [(above, first), (below, second)] = both[..] else { return None };
    if above.is_negative() || !below.is_negative() {
        return None;
    }
    if let (Some(first), Some(second)) = (first, second)
        && above == Q::ONE
        && below == Q::int(-1)
        && let Some(lower) = lower_powers(code, first, second)
    {
        return Some(lower);
    }
    let mut side = |q: Q, term: Option<Id>| match term {
        Some(term) => multiple_of(q, code.value(term)),
        None => rational(q),
    };
    Some([side(above, first), side(below.abs(), second)])
}

/// Two powers of numbers that are not negative in the order of lower ones, where these are whole: of r³, with r² = s a sum of
/// squares, and a³ that of s and a².
fn lower_powers(code: &mut Code, first: Id, second: Id) -> Option<[TokenStream; 2]> {
    let g = code.graph();
    let power = |id: Id| match g.node(id) {
        Node::Product(factors) => match factors[..] {
            [(base, e)] if g.range(base).nonnegative() => Some((base, g.as_number(e)?)),
            _ => None,
        },
        _ => None,
    };
    let ((x, a), (y, b)) = (power(first)?, power(second)?);
    if a.is_negative() || b.is_negative() || a.is_int() && b.is_int() {
        return None;
    }
    // In lowest terms, the ratio of the exponents is that of the lower ones.
    let ratio = a.mul(b.recip()?)?;
    let lower = [(x, ratio.num()), (y, ratio.den())];
    Some(lower.map(|(base, n)| {
        let base = code.value(base);
        integer_power(&base, n)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Graph, Leaf};
    use crate::interval::Interval;

    #[test]
    fn two_sides_are_compared_and_other_sums_with_zero() {
        let mut g = Graph::new();
        let [u, v] = [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::ALL));
        let [one, third, minus] =
            [(1, 1), (1, 3), (-2, 1)].map(|(n, d)| g.number(Q::new(n, d).unwrap()));
        let (share, twice) = (g.mul(third, v), g.mul(minus, u));
        let (less, between, sum) = (g.add(one, twice), g.sub(u, share), g.add(u, v));
        let more = g.add(between, one);
        let text = |difference, strict| {
            let mut code = Code::new(&g, &|leaf| match leaf {
                Leaf::Unknown(0) => quote!(u),
                _ => quote!(v),
            });
            let test = passed(&mut code, &[Test { difference, strict }]);
            let lets = code.statements();
            quote!(#lets #test).to_string().replace("< R :: Mask as Mask > :: TRUE . and ", "")
        };
        assert_eq!(text(less, true), "(R :: ONE . gt ((R :: of (2.0) * u)))");
        assert_eq!(text(between, false), "(u . ge ((v / R :: of (3.0))))");
        assert!(text(sum, true).contains(". gt (R :: ZERO)"));
        assert!(text(more, true).contains(". gt (R :: ZERO)"));
    }

    #[test]
    fn roots_are_compared_by_what_they_are_roots_of() {
        let mut g = Graph::new();
        let [s, a] = [0, 1].map(|i| g.leaf(Leaf::Unknown(i), &format!("u{i}"), Interval::POSITIVE));
        let exponent = g.number(Q::new(3, 2).unwrap());
        let (cubed, other) = (g.pow(s, exponent), g.powi(a, 3));
        let difference = g.sub(cubed, other);
        let mut code = Code::new(&g, &|leaf| match leaf {
            Leaf::Unknown(0) => quote!(s),
            _ => quote!(a),
        });
        let [above, below] = sides(&mut code, difference).unwrap();
        assert_eq!((above.to_string(), below.to_string()), ("s".into(), "(a * a)".into()));
    }

    #[test]
    fn a_difference_has_the_sign_of_the_order_of_its_sides() {
        for a in [0.0f32, 1e-45, 1.1754942e-38, 1.0, 0.1, f32::MAX] {
            for b in [a.next_down(), a, a.next_up()] {
                assert_eq!((a - b > 0.0, a - b >= 0.0), (a > b, a >= b), "{a:e} {b:e}");
            }
        }
    }
}
