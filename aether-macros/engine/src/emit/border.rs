//! Tests that an unknown lies in [0, 1) by the coordinate that goes from one end to another with it.

use quote::quote;

use super::code::Code;
use super::peeled::UnitTest;
use crate::derive::{Border, Limit};

/// The tests of an unknown with a border, as far as the range of the coordinate leaves them open.
pub(super) fn border_test(code: &mut Code, border: &Border) -> UnitTest {
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
    let (low, high) = if border.rising {
        let low = end(zero, true).map(|a| quote!(.and(#x.ge(#a))));
        (low, end(one, false).map(|b| quote!(.and(#x.lt(#b)))))
    } else {
        let low = end(one, true).map(|b| quote!(.and(#x.gt(#b))));
        (low, end(zero, false).map(|a| quote!(.and(#x.le(#a)))))
    };
    let bounded = (low.is_some() && high.is_some()).then_some(border.coordinate);
    let near = match if border.rising { [zero, one] } else { [one, zero] } {
        [Limit::At(low), Limit::At(high)] => {
            let (low, high) = (code.value(low), code.value(high));
            Some(quote!(.and(::aether_core::support::far_from::<R>(#x, #low, #high).not())))
        }
        _ => None,
    };
    UnitTest { inside: quote!(#low #high), near, bounded }
}
