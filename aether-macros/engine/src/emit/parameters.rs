//! The numbers that parameters are, as emitted functions have them.

use proc_macro2::{Ident, Span, TokenStream};
use quote::quote;

use super::item::Emitter;
use crate::parse::{Param, ParamKind};
use crate::sorted;

impl Emitter<'_> {
    /// The parameters at whose zero a formula has only a limit.
    fn limits(&self) -> Vec<u8> {
        let mut limits: Vec<u8> = self.derived.iter().flat_map(|d| d.limits.clone()).collect();
        limits.extend(self.atoms.iter().flat_map(|atom| &atom.limits));
        sorted::sort(&mut limits);
        limits.dedup();
        limits
    }

    /// The numbers among the parameters that the constructor moves beside zero, once for all that is asked afterwards: those
    /// at whose zero a formula has only a limit, unless zero has a way of its own.
    pub(super) fn moved(&self) -> Vec<(u8, &Ident)> {
        let limits = self.limits();
        let named = self.signature().params.iter().scan(0, |next, param| {
            let first = *next;
            *next += param.kind.numbers() as u8;
            Some((first, param))
        });
        let is_moved = |&(i, param): &(u8, &Param)| {
            matches!(param.kind, ParamKind::Scalar)
                && limits.contains(&i)
                && self.parsed.vanishing_with(i).next().is_none()
        };
        named.filter(is_moved).map(|(i, param)| (i, &param.name)).collect()
    }

    /// The parameters that each method moves for itself.
    fn left_at_zero(&self) -> Vec<u8> {
        let (mut limits, moved) = (self.limits(), self.moved());
        limits.retain(|i| moved.iter().all(|(j, _)| i != j));
        limits
    }

    /// The parameters and coordinates once more, as they stand in memory, if they are what is there.
    pub(super) fn read_again(&self) -> TokenStream {
        let parameters = self.left_at_zero().is_empty().then(|| self.parameters());
        let coordinates = self.coordinates();
        quote!(#parameters let x = #coordinates;)
    }

    /// `let p = [...]`: the scalar parameters in order.
    pub(super) fn parameters(&self) -> TokenStream {
        let mut list = Vec::new();
        for param in &self.signature().params {
            let name = &param.name;
            match param.kind {
                ParamKind::Scalar => list.push(quote!(self.#name)),
                ParamKind::Integer(_) | ParamKind::Flag => list.push(quote!(R::of(self.#name))),
                ParamKind::Array(n) => list.extend((0..n).map(|i| {
                    let i = proc_macro2::Literal::usize_unsuffixed(i);
                    quote!(self.#name[#i])
                })),
                ParamKind::Vec2 => list.extend([quote!(self.#name.x), quote!(self.#name.y)]),
                ParamKind::Vec3 | ParamKind::Direction => {
                    list.extend([quote!(self.#name.x), quote!(self.#name.y), quote!(self.#name.z)]);
                }
                ParamKind::Mat3 | ParamKind::Frame => {
                    for c in ["x", "y", "z"].map(|c| Ident::new(c, Span::call_site())) {
                        list.extend([
                            quote!(self.#name.#c.x),
                            quote!(self.#name.#c.y),
                            quote!(self.#name.#c.z),
                        ]);
                    }
                }
                ParamKind::Identity => {}
            }
        }
        for constant in &self.parsed.constants.all {
            list.extend(constant.fields.iter().map(|field| quote!(self.#field)));
            if constant.fields.is_empty() {
                list.extend(vec![quote!(R::ZERO); constant.kind.scalars()]);
            }
        }
        let p = self.scalars();
        let plain = list.clone();
        for i in self.left_at_zero() {
            let parameter = &plain[i as usize];
            let beside = quote!(::aether_core::support::beside_zero(#parameter));
            // Where all that vanish with it are zero, zero has a way of its own.
            let ways = self.parsed.vanishing_with(i).map(|others| {
                let others = others.into_iter().map(|j| &plain[usize::from(j)]);
                quote!(.and(<R::Mask as Mask>::FALSE #(.or(#others.abs().gt(R::ZERO)))*))
            });
            let ways: TokenStream = ways.collect();
            list[i as usize] = match ways.is_empty() {
                true => beside,
                false => quote!(R::select(<R::Mask as Mask>::TRUE #ways, #beside, #parameter)),
            };
        }
        quote!(let p: [R; #p] = [#(#list),*];)
    }
}

#[cfg(test)]
mod tests {
    use proc_macro2::TokenStream;

    #[test]
    fn parameters_are_moved_beside_zero_once() {
        let text = |function: &str| {
            let text = crate::sampler(TokenStream::new(), function.parse().unwrap()).to_string();
            (
                text.contains("let s = :: aether_core :: support :: beside_zero (s)"),
                text.matches("beside_zero").count(),
            )
        };
        let number = "fn f(u: [Uniform; 1], s: f64) -> f64 { -(u[0] * (-s).exp_m1()).ln_1p() / s }";
        assert_eq!(text(number), (true, 1));
        // Of several numbers with one name each method moves its own.
        let (moved, times) = text(
            &number
                .replace("s: f64", "a: [f64; 1]")
                .replace("(-s)", "(-a[0])")
                .replace("/ s", "/ a[0]"),
        );
        assert!(!moved && times > 1);
    }
}
