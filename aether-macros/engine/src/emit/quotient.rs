//! Tests that a quotient lies in [0, 1) by what stands above and below its line. N / D is rounded to less than one
//! exactly where N is less than D: then N is at most D times the largest number below one. Dividing takes several
//! times as long as comparing.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Code;
use crate::expr::{Fun, Graph, Id, Node};
use crate::rational::Q;

/// The test of a quotient below one, and not below zero where that has to be tested too (`lower`); `None` where it is no
/// plain quotient, or its sign would not be told. What is `asked` is not negative but for rounding.
pub(super) fn within_unit(
    code: &mut Code,
    id: Id,
    lower: bool,
    asked: &[Id],
) -> Option<TokenStream> {
    let g = code.graph();
    let Node::Product(factors) = g.node(id) else { return None };
    let powers: Vec<(Id, Q)> = factors
        .iter()
        .map(|&(base, e)| Some((base, g.as_number(e).filter(|q| q.is_int())?)))
        .collect::<Option<_>>()?;
    let (below, above): (Vec<_>, Vec<_>) = powers.into_iter().partition(|(_, q)| q.is_negative());
    // Rounding may make both sides negative: where the lower end is not tested, the divisor itself must tell.
    let is_positive = |&(base, q): &(Id, Q)| {
        let told = || g.range(base).nonnegative() || asked.contains(&base);
        q.is_even() || if lower { told() } else { never_negative(g, base) }
    };
    if above.is_empty() || below.is_empty() || !below.iter().all(is_positive) {
        return None;
    }
    let [above, below] = [above, below].map(|powers| code.powers(&powers));
    let at_least_zero = lower.then(|| quote!(.and((#above).ge(R::ZERO))));
    Some(quote!(#at_least_zero .and((#above).lt(#below))))
}

/// Whether an expression is never negative however it is rounded.
fn never_negative(g: &Graph, id: Id) -> bool {
    match g.node(id) {
        Node::Sum(c, terms) => {
            let all = |(q, term): &(Q, Id)| !q.is_negative() && never_negative(g, *term);
            !c.is_negative() && terms.iter().all(all)
        }
        Node::Product(factors) => factors
            .iter()
            .all(|&(base, e)| g.as_number(e).is_some_and(Q::is_even) || never_negative(g, base)),
        Node::Call(Fun::Abs | Fun::Exp, _) => true,
        node => (matches!(node, Node::Leaf(_)) || g.deps(id) == 0) && g.range(id).nonnegative(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is emitted for a sampler of three uniforms.
    fn text(domains: &str, body: &str) -> String {
        let function = format!("fn f(u: [Uniform; 3], r: f64) -> Vec3 {{ {body} }}");
        crate::sampler(domains.parse().unwrap(), function.parse().unwrap()).to_string()
    }

    const DISK: &str =
        "let (l, t) = (r * u[0].sqrt(), TAU * u[1]); let (x, y) = (l * t.cos(), l * t.sin());";
    const COMPARED: &str = ". lt ((p [0] * p [0]))";

    #[test]
    fn squares_are_compared_with_what_they_are_divided_by() {
        let cylinder = format!("{DISK} Vec3::new(x, y, u[2])");
        assert!(text("", &cylinder).contains(COMPARED));
    }

    #[test]
    fn what_the_density_has_is_divided() {
        let growing = format!("{DISK} Vec3::new(x, y, u[2] * u[0].exp())");
        assert!(!text("", &growing).contains(COMPARED));
    }

    #[test]
    fn divisors_must_have_a_known_sign() {
        let sheared = "Vec3::new(r * u[0] + u[1], u[1], u[2])";
        assert!(!text("", sheared).contains(". lt (p [0])"));
        assert!(text("r in 0.5..=2.0", sheared).contains(". lt (p [0])"));
    }

    #[test]
    fn divisors_that_are_asked_for_have_a_sign() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| {
            let all = crate::interval::Interval::ALL;
            g.leaf(crate::expr::Leaf::Out(i), &format!("x{i}"), all)
        });
        let share = g.div(x, y);
        let mut code = Code::new(&g, &|leaf| format!("{leaf:?}").parse().unwrap());
        assert!(within_unit(&mut code, share, true, &[]).is_none());
        let test = within_unit(&mut code, share, true, &[y]).unwrap().to_string();
        assert!(test.contains(". lt (Out (1))") || test.contains(". lt (Out(1))"), "{test}");
    }

    #[test]
    fn what_is_never_negative_stays_so_when_rounded() {
        let mut g = Graph::new();
        let x = g.leaf(crate::expr::Leaf::Out(0), "x", crate::interval::Interval::new(-1.0, 1.0));
        let square = g.powi(x, 2);
        let (one, minus) = (g.int(1), g.int(-1));
        let (more, negative) = (g.add(one, square), g.mul(minus, square));
        let less = g.add(one, negative);
        assert!(g.range(less).nonnegative() && !never_negative(&g, less));
        assert!(never_negative(&g, more) && never_negative(&g, square) && !never_negative(&g, x));
    }

    #[test]
    fn a_quotient_rounds_to_less_than_one_where_its_sides_tell() {
        for below in [1.0f32, 1.5, 3.0, f32::MIN_POSITIVE, 1e-45, 7e-45, f32::MAX, 0.1] {
            for above in [below.next_down(), below, below.next_up()] {
                assert_eq!(above / below < 1.0, above < below, "{above:e} {below:e}");
            }
        }
    }
}
