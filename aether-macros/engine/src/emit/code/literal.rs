//! Numbers, powers and products as text.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use crate::number::Number;
use crate::rational::Q;

/// The factors with `*` between them.
pub(in crate::emit) fn joined(factors: &[TokenStream]) -> TokenStream {
    let mut factors = factors.iter();
    let Some(first) = factors.next() else { return quote!(R::ONE) };
    factors.fold(first.clone(), |product, f| quote!(#product * #f))
}

pub(in crate::emit) fn integer_power(base: &TokenStream, n: i128) -> TokenStream {
    match n {
        1 => quote!(#base),
        2 => quote!((#base * #base)),
        3 => quote!((#base * #base * #base)),
        _ => {
            let n = Literal::i32_unsuffixed(i32::try_from(n).unwrap_or(i32::MAX));
            quote!(#base.powi(#n))
        }
    }
}

/// q · t as a factor or a term: in parentheses, unless it is t.
pub(in crate::emit) fn multiple_of(q: Q, t: TokenStream) -> TokenStream {
    if q == Q::ONE {
        return t;
    }
    let multiple = times(q, &t);
    quote!((#multiple))
}

/// q · t with the fewest roundings.
pub(in crate::emit) fn times(q: Q, t: &TokenStream) -> TokenStream {
    if q.num() == 1 && q.den().count_ones() != 1 {
        let d = rational(Q::new(q.den(), 1).unwrap_or(Q::ONE));
        return quote!(#t / #d);
    }
    let k = rational(q);
    quote!(#k * #t)
}

pub(in crate::emit) fn rational(q: Q) -> TokenStream {
    number(<f64 as Number>::from_ratio(q.num(), q.den()))
}

pub(in crate::emit) fn number(x: f64) -> TokenStream {
    if x == 0.0 {
        return quote!(R::ZERO);
    }
    if x == 1.0 {
        return quote!(R::ONE);
    }
    if x.is_nan() {
        return quote!(R::of(f64::NAN));
    }
    if x.is_infinite() {
        return if x > 0.0 { quote!(R::INFINITY) } else { quote!(-R::INFINITY) };
    }
    let l = Literal::f64_unsuffixed(x.abs());
    if x < 0.0 { quote!(R::of(-#l)) } else { quote!(R::of(#l)) }
}
