//! Factors above and below the line, and the quotient that they are written as.

use proc_macro2::TokenStream;
use quote::quote;

use super::literal::{integer_power, joined, rational};
use crate::rational::Q;

/// Factors above and below the line; square roots are taken together.
#[derive(Default)]
pub(super) struct Parts {
    /// What is divided before anything is multiplied with it.
    pub(super) first: Option<TokenStream>,
    /// A root that divides what stands above before anything else does.
    pub(super) soon: Option<TokenStream>,
    pub(super) top: Vec<TokenStream>,
    pub(super) bottom: Vec<TokenStream>,
    pub(super) root_top: Vec<TokenStream>,
    pub(super) root_bottom: Vec<TokenStream>,
    /// Whether what has a root is too large in single precision to be multiplied before the root is taken.
    pub(super) apart: bool,
}

impl Parts {
    pub(super) fn push_whole(&mut self, factor: TokenStream, below: bool) {
        if below { self.bottom.push(factor) } else { self.top.push(factor) }
    }

    pub(super) fn push(&mut self, base: &TokenStream, q: Q) {
        let (whole, rest, root) = if q.is_negative() {
            (&mut self.bottom, q.neg(), &mut self.root_bottom)
        } else {
            (&mut self.top, q, &mut self.root_top)
        };
        match (rest.num(), rest.den()) {
            (0, _) => {}
            (n, 1) => whole.push(integer_power(base, n)),
            (1, 2) => root.push(base.clone()),
            (n, 2) => {
                whole.push(integer_power(base, n / 2));
                root.push(base.clone());
            }
            (1, 3) => whole.push(quote!(#base.cbrt())),
            _ => {
                let e = rational(rest);
                whole.push(quote!(#base.powf(#e)));
            }
        }
    }

    pub(super) fn finish(mut self) -> TokenStream {
        for (roots, whole) in [(self.root_top, &mut self.top), (self.root_bottom, &mut self.bottom)]
        {
            match &roots[..] {
                [] => {}
                [one] => whole.push(quote!(#one.sqrt())),
                many if self.apart => whole.extend(many.iter().map(|one| quote!(#one.sqrt()))),
                many => {
                    let product = joined(many);
                    whole.push(quote!((#product).sqrt()));
                }
            }
        }
        let (top, bottom) = (self.top, self.bottom);
        let above = joined(&top);
        let below = joined(&bottom);
        let above = match self.soon {
            Some(root) => quote!(#above / #root.sqrt()),
            None => above,
        };
        match (self.first, bottom.len()) {
            (Some(first), 1) => quote!(#above * (#first / #below)),
            (Some(first), _) => quote!(#above * (#first / (#below))),
            (None, 0) => above,
            (None, 1) => quote!(#above / #below),
            (None, _) => quote!(#above / (#below)),
        }
    }
}
