//! How parameters and coordinates are handed on to what is seldom called.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::item::Emitter;

/// Whether parameters and coordinates are handed on one by one to what is seldom called, and not as arrays. These are put into
/// memory for it, which makes compilers load two numbers at once on the usual way, and take them apart again; but of many
/// numbers, or where there is one parameter, that costs less than to keep them.
fn are_few(e: &Emitter) -> bool {
    let (_, m, s) = e.sizes();
    s != 1 && m + s <= 5
}

/// The parameters and coordinates, to be handed on.
pub(super) fn numbers(e: &Emitter) -> TokenStream {
    let (_, m, s) = e.sizes();
    if !are_few(e) {
        return quote!(p, x,);
    }
    let (p, x) = (0..s, 0..m);
    quote!(#(p[#p],)* #(x[#x],)*)
}

/// As what a function takes [`numbers`], and the arrays of them.
pub(super) fn taken_numbers(e: &Emitter) -> (TokenStream, TokenStream) {
    let (_, m, s) = e.sizes();
    if !are_few(e) {
        return (quote!(p: [R; #s], x: [R; #m],), quote!());
    }
    let [p, x] = [("p", s), ("x", m)]
        .map(|(name, n)| (0..n).map(|i| format_ident!("{name}_{i}")).collect::<Vec<Ident>>());
    let arrays = quote!(let (p, x): ([R; #s], [R; #m]) = ([#(#p),*], [#(#x),*]););
    (quote!(#(#p: R,)* #(#x: R,)*), arrays)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_numbers_are_handed_on_one_by_one() {
        let calls = |text: &str| {
            let code = crate::sampler(TokenStream::new(), text.parse().unwrap()).to_string();
            let (_, call) = code.split_once("'quick pdf_anywhere :: < R > (").unwrap();
            call.split_once(')').unwrap().0.to_owned()
        };
        let line = calls("fn f(u: [Uniform; 1], a: f64, b: f64) -> f64 { a + (b - a) * u[0] }");
        assert!(line.starts_with("p [0usize] , p [1usize] , x [0usize] ,"), "{line}");
        let one = calls("fn f(u: [Uniform; 1], a: f64) -> f64 { a * u[0].sqrt() }");
        assert!(one.starts_with("p , x ,"), "{one}");
    }
}
