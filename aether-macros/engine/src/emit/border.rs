//! Tests that an unknown lies in [0, 1) by the coordinate that goes from one end to another with it.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Code;
use super::peeled::UnitTest;
use crate::derive::{Border, Limit};
use crate::expr::Id;

/// The tests of an unknown with a border, as far as the range of the coordinate leaves them open. Where parameters decide
/// which end is the lower one, `place` is where the coordinate lies between them.
pub(super) fn border_test(code: &mut Code, border: &Border, place: Id) -> UnitTest {
    let Some(rising) = border.rising else { return place_test(code, border, place) };
    let g = code.graph();
    let x = code.value(border.coordinate);
    let known = g.range(border.coordinate);
    // An end that the coordinate cannot get beyond is not tested.
    let mut end = |limit: Limit, lower: bool| match limit {
        Limit::At(id) => {
            let range = g.range(id);
            let told = if lower { range.hi <= known.lo } else { range.lo >= known.hi };
            let value = code.value(id);
            (!told).then_some(value)
        }
        _ => None,
    };
    let [zero, one] = border.ends;
    // The end at one is open.
    let (low, high) = if rising {
        let low = end(zero, true).map(|a| quote!(.and(#x.ge(#a))));
        (low, end(one, false).map(|b| quote!(.and(#x.lt(#b)))))
    } else {
        let low = end(one, true).map(|b| quote!(.and(#x.gt(#b))));
        (low, end(zero, false).map(|a| quote!(.and(#x.le(#a)))))
    };
    let bounded = (low.is_some() && high.is_some()).then_some(border.coordinate);
    let order = if rising { [zero, one] } else { [one, zero] };
    let near = near(code, border.coordinate, order, &quote!(far_from));
    UnitTest { inside: quote!(#low #high), near, bounded }
}

/// The tests of a place between two ends.
fn place_test(code: &mut Code, border: &Border, place: Id) -> UnitTest {
    let t = code.value(place);
    let near = near(code, border.coordinate, border.ends, &quote!(far_from_both));
    let inside = quote!(.and(#t.ge(R::ZERO)).and(#t.lt(R::ONE)));
    UnitTest { inside, near, bounded: Some(border.coordinate) }
}

/// That a coordinate does not lie `far` outside of two ends, if there are two.
fn near(
    code: &mut Code,
    coordinate: Id,
    ends: [Limit; 2],
    far: &TokenStream,
) -> Option<TokenStream> {
    let [Limit::At(one), Limit::At(other)] = ends else { return None };
    let [x, one, other] = [coordinate, one, other].map(|id| code.value(id));
    Some(quote!(.and(::aether_core::support::#far::<R>(#x, #one, #other).not())))
}
