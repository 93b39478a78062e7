//! Tests by which a point plainly has a preimage, and by which it plainly has none.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::border::border_test;
use super::code::{Code, multiple_of};
use super::item::Emitter;
use super::paired::calls;
use super::passed::exceeds;
use super::peeled::{UnitTest, sign_of, unit_test};
use super::pieces::{Place, input};
use super::tame::Tame;
use crate::derive::{Preimage, Signs, Target};
use crate::expr::{Graph, Id, Leaf, Node, OUTS};
use crate::interval::Interval;
use crate::rational::Q;
use crate::sorted;

/// The tests of the unknowns that have to be tested; those that are told by a coordinate come first.
pub(super) fn unit_tests(place: Place, code: &mut Code) -> Vec<UnitTest> {
    let [borders, others] = units(place);
    borders.into_iter().chain(others).map(|i| test(place, i, code)).collect()
}

/// The unknowns that have to be tested: those that are told by a coordinate, and the others.
fn units(place: Place) -> [Vec<usize>; 2] {
    let has_border = |i: &usize| place.preimage.borders[*i].is_some();
    let (borders, others) = place.checked().into_iter().partition(has_border);
    [borders, others]
}

fn test(place: Place, i: usize, code: &mut Code) -> UnitTest {
    match (&place.preimage.borders[i], &place.preimage.signs[i]) {
        (Some(border), _) => border_test(code, border, place.preimage.tested[i]),
        (None, Some(signs)) => sign_test(code, signs),
        (None, None) => {
            let asked = deciding(place, &place.preimage.asked);
            let asked: Vec<Id> = asked.into_iter().map(|(id, _)| id).collect();
            unit_test(code, place.preimage.tested[i], is_computed(place, i), &asked)
        }
    }
}

/// Whether what tells of an unknown is computed for something else as well.
fn is_computed(place: Place, i: usize) -> bool {
    let Preimage { tested, requirements, asked, density, .. } = place.preimage;
    let others = place.checked().into_iter().filter(|&j| j != i).map(|j| tested[j]);
    let conditions = requirements.iter().chain(asked).copied();
    let all: Vec<Id> = others.chain(conditions).chain([*density]).collect();
    place.problem.graph.within(&all).contains(&tested[i])
}

/// What a test asks of an expression.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition {
    /// It is positive.
    Positive,
    /// It is not negative.
    NotNegative,
    /// It is not negative, but for rounding.
    HardlyNegative,
    /// It is a finite number, as it lies between two.
    Finite,
}

/// What the tests ask by which a point plainly has a preimage, as far as that is known.
pub(super) fn conditions(place: Place) -> Vec<(Id, Condition)> {
    let Preimage { requirements, asked, signs, .. } = place.preimage;
    let mut code = Code::new(&place.problem.graph, &|_| TokenStream::new());
    let mut all: Vec<(Id, Condition)> =
        requirements.iter().map(|&id| (id, Condition::Positive)).collect();
    all.extend(deciding(place, asked).into_iter().map(|(id, below)| match below {
        true => (id, Condition::Positive),
        false => (id, Condition::HardlyNegative),
    }));
    for i in units(place).concat() {
        let UnitTest { inside, bounded, .. } = test(place, i, &mut code);
        if inside.is_empty() {
            continue;
        }
        all.extend(bounded.map(|id| (id, Condition::Finite)));
        if let (None, Some(Signs { at_least_zero, positive, .. })) =
            (&place.preimage.borders[i], &signs[i])
        {
            all.extend(at_least_zero.iter().map(|&id| (id, Condition::NotNegative)));
            all.extend(positive.iter().map(|&id| (id, Condition::Positive)));
        }
    }
    let bounded = between(place).into_iter().filter(|(_, range)| range.width().is_finite());
    all.extend(bounded.map(|(id, _)| (id, Condition::Finite)));
    all
}

/// The coordinates that the density is a formula of and that tests keep between two numbers, with these.
pub(super) fn between(place: Place) -> Vec<(Id, Interval)> {
    let g = &place.problem.graph;
    let within = g.within(&[place.preimage.density]);
    let coordinate = |i: usize| within.iter().find(|id| g.is_leaf(**id, Leaf::Out(i as u8)));
    let kept = kept_between(place, 0.0).into_iter();
    kept.filter_map(|(i, range)| Some((*coordinate(i)?, range))).collect()
}

fn sign_test(code: &mut Code, signs: &Signs) -> UnitTest {
    let (mut not_negative, mut inside) = (signs.at_least_zero.clone(), TokenStream::new());
    for &id in &signs.positive {
        // Only what lies right at the end, which nobody calls plain then, is told by two comparisons.
        let opposite =
            not_negative.iter().position(|other| within_size(code.graph(), id, *other).is_some());
        let test = match opposite {
            Some(i) => smaller(code, id, not_negative.remove(i)),
            None => exceeds(code, id, true),
        };
        inside.extend(test);
    }
    let first: TokenStream = not_negative.iter().map(|&id| exceeds(code, id, false)).collect();
    UnitTest { inside: quote!(#first #inside), near: None, bounded: signs.bounded }
}

/// Of a - x and a + x that are to be positive, x and a, where x is a coordinate: its size must be smaller.
fn within_size(g: &Graph, difference: Id, sum: Id) -> Option<(Id, (Q, Id))> {
    let two = |id: Id| match g.node(id) {
        Node::Sum(c, terms) if c.is_zero() => <[(Q, Id); 2]>::try_from(terms.clone()).ok(),
        _ => None,
    };
    let (less, more) = (two(difference)?, two(sum)?);
    let is_coordinate = |id: Id| matches!(g.node(id), Node::Leaf(Leaf::Out(_)));
    let minus = Q::int(-1);
    let &(_, x) = less.iter().find(|(q, id)| *q == minus && is_coordinate(*id))?;
    let &bound = less.iter().find(|(_, id)| *id != x)?;
    (more.contains(&(Q::ONE, x)) && more.contains(&bound)).then_some((x, bound))
}

/// That the size of a coordinate is smaller, of the difference and the sum that are to be positive.
fn smaller(code: &mut Code, difference: Id, sum: Id) -> TokenStream {
    let Some((x, (q, bound))) = within_size(code.graph(), difference, sum) else {
        return TokenStream::new();
    };
    let [x, bound] = [x, bound].map(|id| code.value(id));
    let bound = multiple_of(q, bound);
    quote!(.and(#bound.gt(#x.abs())))
}

/// What decides about the signs of conditions, and whether it stands below a line.
fn deciding(place: Place, conditions: &[Id]) -> Vec<(Id, bool)> {
    let g = &place.problem.graph;
    let mut signs: Vec<(Id, bool)> = conditions.iter().map(|&c| sign_of(g, c)).collect();
    sorted::sort(&mut signs);
    signs.dedup();
    signs
}

/// Two functions of a point: whether it plainly has the preimage, and whether it may have it. Conditions must be at
/// `least` this.
pub(super) fn plainly(e: &Emitter, place: Place, least: &TokenStream) -> TokenStream {
    let (_, m, p) = e.sizes();
    let [plainly, possibly] =
        ["plainly", "possibly"].map(|name| format_ident!("{name}_{}", place.number));
    let (strict, possible) = (strict_tests(place, least), possible_tests(place));
    quote! {
        /// Whether the preimage plainly exists.
        #[inline(always)]
        fn #plainly<R: Real>(p: &[R; #p], x: &[R; #m]) -> R::Mask { #strict }
        /// Whether it may exist where it does not plainly.
        #[inline(always)]
        fn #possibly<R: Real>(p: &[R; #p], x: &[R; #m]) -> R::Mask { #possible }
    }
}

fn strict_tests(place: Place, least: &TokenStream) -> TokenStream {
    let at = |l: Leaf| input(l, "x");
    let mut code = Code::new(&place.problem.graph, &at);
    let required: Vec<TokenStream> =
        place.preimage.requirements.iter().map(|&c| code.value(c)).collect();
    let conditions = deciding(place, &place.preimage.asked).into_iter().map(|(c, below)| {
        match (code.value(c), below) {
            (c, true) => quote!(.and(#c.gt(R::ZERO))),
            (c, false) => quote!(.and(#c.ge(#least))),
        }
    });
    let conditions: Vec<TokenStream> = conditions.collect();
    // What calls functions comes last.
    let [borders, others] = units(place);
    let g = &place.problem.graph;
    let (longer, shorter) = others.into_iter().partition(|&i| calls(g, place.preimage.tested[i]));
    let reached = reached(place, 0.0);
    let [borders, shorter, longer] = [borders, shorter, longer].map(|units: Vec<usize>| {
        let inside = units.into_iter().map(|i| test(place, i, &mut code).inside);
        let inside: TokenStream = inside.collect();
        (code.take_statements(), inside)
    });
    let (first_lets, borders) = borders;
    let others = [shorter, longer].into_iter().filter(|(_, tests)| !tests.is_empty());
    let others = others.map(|(lets, tests)| {
        quote! {
            if !exists.any() {
                return exists;
            }
            #lets
            let exists = exists #tests;
        }
    });
    quote! {
        #first_lets
        let exists =
            <R::Mask as Mask>::TRUE #(.and(#required.gt(R::ZERO)))* #(#conditions)* #borders #reached;
        #(#others)*
        exists
    }
}

/// That each coordinate lies where the map stays, as [`kept_between`] says.
fn reached(place: Place, share: f64) -> TokenStream {
    let within = kept_between(place, share).into_iter().map(|(i, Interval { lo, hi })| {
        let i = Literal::usize_unsuffixed(i);
        let low = lo.is_finite().then(|| quote!(.and(x[#i].ge(R::of(#lo)))));
        let high = hi.is_finite().then(|| quote!(.and(x[#i].le(R::of(#hi)))));
        quote!(#low #high)
    });
    within.collect()
}

/// The numbers between which a plain point has some coordinates, each by its number: those that the map stays between, or
/// beyond by no more than a share of what lies between them. Only where nothing else is tested, and the density might be
/// no number beyond.
pub(super) fn kept_between(place: Place, share: f64) -> Vec<(usize, Interval)> {
    let (g, Preimage { requirements, asked, density, .. }) = (&place.problem.graph, place.preimage);
    let tested = !requirements.is_empty() || !asked.is_empty() || !place.checked().is_empty();
    let is_direction = place.problem.parts.iter().any(|part| part.target == Target::Direction);
    if tested || is_direction || Tame::new(g, false, false).all(&[*density]) {
        return Vec::new();
    }
    let ranges = place.derived.forward.iter().map(|&coordinate| g.range(coordinate));
    let wider = ranges.map(|Interval { lo, hi }| {
        let beyond = share * (hi - lo);
        Interval { lo: lo - beyond, hi: hi + beyond }
    });
    wider.enumerate().collect()
}

fn possible_tests(place: Place) -> TokenStream {
    let at = |l: Leaf| input(l, "x");
    let mut code = Code::new(&place.problem.graph, &at);
    let required: Vec<TokenStream> =
        place.preimage.requirements.iter().map(|&c| code.value(c)).collect();
    // What is divided by may have been rounded to zero, or beyond it, as what is not.
    let conditions = deciding(place, &place.preimage.open).into_iter().map(|(c, _)| {
        let c = code.value(c);
        quote!(.and(#c.lt(slack).not()))
    });
    let conditions: Vec<TokenStream> = conditions.collect();
    // Of several unknowns, one at an end leaves those undetermined that no border tells.
    let [borders, others] = units(place);
    let (alone, others) =
        if borders.is_empty() && others.len() == 1 { (others, vec![]) } else { (vec![], others) };
    let g = &place.problem.graph;
    let Preimage { tested, unknowns, .. } = place.preimage;
    let determined =
        others.iter().filter(|&&i| tested[i] == unknowns[i] && is_determined(g, tested[i]));
    let determined: Vec<TokenStream> = determined.map(|&i| code.value(tested[i])).collect();
    let near = borders.into_iter().chain(alone);
    let near: Vec<TokenStream> = near.filter_map(|i| test(place, i, &mut code).near).collect();
    let (lets, reached) = (code.statements(), reached(place, 1.0 / 256.0));
    quote! {
        #lets
        let slack = R::of(-1.0 / 256.0);
        <R::Mask as Mask>::TRUE #(.and(#required.gt(R::ZERO)))* #(#conditions)* #(#near)* #reached
            #(.and(::aether_core::support::about_unit::<R, 1>(&[#determined])))*
    }
}

/// Whether an expression has a value at every point, whatever other unknowns are, if the parameters leave it one.
fn is_determined(g: &Graph, id: Id) -> bool {
    if !g.has(id, OUTS) {
        return true;
    }
    match g.node(id) {
        Node::Leaf(_) => true,
        Node::Sum(_, terms) => terms.iter().all(|(_, term)| is_determined(g, *term)),
        Node::Product(factors) => factors.iter().all(|&(base, exponent)| {
            let grows = g.as_number(exponent).is_some_and(|q| q.is_int() && !q.is_negative());
            !g.has(base, OUTS) && !g.has(exponent, OUTS) || grows && is_determined(g, base)
        }),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Fun;

    #[test]
    fn a_divisor_that_the_point_has_leaves_an_unknown_undetermined() {
        let mut g = Graph::new();
        let [x, y] = [0, 1].map(|i| g.leaf(Leaf::Out(i), &format!("x{i}"), Interval::ALL));
        let p = g.leaf(Leaf::Param(0), "p", Interval::ALL);
        let square = g.powi(x, 2);
        let both = g.add(square, y);
        let share = g.div(both, p);
        assert!(is_determined(&g, share));
        let (quotient, angle) = (g.div(x, y), g.call(Fun::Atan2, &[y, x]));
        assert!(!is_determined(&g, quotient) && !is_determined(&g, angle));
    }

    #[test]
    fn what_nothing_else_tests_lies_where_the_map_does() {
        let text = |body: &str| {
            let function = format!("fn f(u: [Uniform; 1]) -> f64 {{ {body} }}");
            crate::sampler(TokenStream::new(), function.parse().unwrap()).to_string()
        };
        let upper = "x [0] . le (R :: of (1f64))";
        assert!(text("(TAU * u[0]).cos()").contains(upper));
        // Here an end of the unknown is tested, and there is no end.
        assert!(!text("u[0].sqrt()").contains(upper));
        assert!(!text("(PI * (u[0] - 0.5)).tan()").contains("x [0] . le"));
    }
}
