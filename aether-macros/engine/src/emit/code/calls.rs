//! Functions as text.

use proc_macro2::{Ident, Span, TokenStream};
use quote::quote;

use super::Code;
use crate::emit::paired::are_opposite;
use crate::expr::{Fun, Graph, Id, Leaf, Node};

impl Code<'_> {
    /// The exponential of the opposite of an expression, and that less one, if both have been written.
    fn opposite(&self, x: Id) -> Option<[TokenStream; 2]> {
        let written = |f: Fun| {
            self.names.iter().find_map(|(id, name)| match self.graph.node(*id) {
                Node::Call(g, args) if *g == f && are_opposite(self.graph, args[0], x) => {
                    Some(quote!(#name))
                }
                _ => None,
            })
        };
        Some([written(Fun::Exp)?, written(Fun::ExpM1)?])
    }

    /// A function of what has been written.
    pub(super) fn call(&self, f: Fun, args: &[Id]) -> TokenStream {
        if let (Fun::ExpM1, [x]) = (f, args)
            && self.graph.range(*x).nonnegative()
            && let Some([whole, less]) = self.opposite(*x)
        {
            // eˣ - 1 is (1 - e⁻ˣ) / e⁻ˣ, where that does not overflow.
            return quote!((-(#less) / #whole));
        }
        let a = self.reference(args[0]);
        match f {
            Fun::Atan2 => {
                let b = self.reference(args[1]);
                quote!(#a.atan2(#b))
            }
            Fun::Pow1p => {
                let e = self.reference(args[1]);
                let power = quote!((#e * #a.ln_1p()).exp());
                if is_finite(self.graph, args[1]) {
                    return power;
                }
                // 1 to any power is 1, as for `powf`.
                let one = quote!(#a.ge(R::ZERO).and(#a.le(R::ZERO)));
                quote!(R::select(#one, R::ONE, #power))
            }
            Fun::LnBeta => {
                let b = self.reference(args[1]);
                quote!(::aether_core::special::ln_beta(#a, #b))
            }
            Fun::BetaInc | Fun::BetaIncInv => {
                let inverse = f == Fun::BetaIncInv;
                let name = if inverse { quote!(beta_quantile) } else { quote!(beta_tail) };
                let [b, c, rest] = [1, 2, 3].map(|i| self.reference(args[i]));
                quote!(::aether_core::special::#name(#b, #c, [#a, #rest]))
            }
            Fun::Turn => quote!(::aether_core::support::turn(#a)),
            Fun::TurnTo => {
                let middle = self.reference(args[1]);
                quote!(::aether_core::support::turn_to(#a, #middle))
            }
            Fun::SinPi => quote!(#a.sin_pi()),
            Fun::CosPi => quote!(#a.cos_pi()),
            Fun::Sign => quote!(R::ONE.copysign(#a)),
            _ => match special(f) {
                Some(name) => {
                    let name = Ident::new(name, Span::call_site());
                    quote!(::aether_core::special::#name(#a))
                }
                None => {
                    let method = Ident::new(method(f), Span::call_site());
                    quote!(#a.#method())
                }
            },
        }
    }
}

/// Whether an exponent is finite: what has two finite ends, or a parameter from a declared end on, which is a number.
fn is_finite(g: &Graph, id: Id) -> bool {
    let range = g.range(id);
    let is_parameter = matches!(g.node(id), Node::Leaf(Leaf::Param(_)));
    range.lo.is_finite() && (is_parameter || range.hi.is_finite())
}

/// The name of a function of `aether_core::special`.
fn special(f: Fun) -> Option<&'static str> {
    Some(match f {
        Fun::Erf => "erf",
        Fun::Erfc => "erfc",
        Fun::ErfInv => "erf_inv",
        Fun::ErfcInv => "erfc_inv",
        Fun::LnErfc => "ln_erfc",
        Fun::ErfcInvExp => "erfc_inv_exp",
        Fun::LambertW => "lambert_w",
        Fun::LnGamma => "ln_gamma",
        _ => return None,
    })
}

fn method(f: Fun) -> &'static str {
    match f {
        Fun::Exp => "exp",
        Fun::ExpM1 => "exp_m1",
        Fun::Ln => "ln",
        Fun::Ln1p => "ln_1p",
        Fun::Sin => "sin",
        Fun::Cos => "cos",
        Fun::Tan => "tan",
        Fun::Asin => "asin",
        Fun::Acos => "acos",
        Fun::Atan | Fun::Atan2 => "atan",
        Fun::Sinh => "sinh",
        Fun::Cosh => "cosh",
        Fun::Tanh => "tanh",
        Fun::Asinh => "asinh",
        Fun::Acosh => "acosh",
        Fun::Atanh => "atanh",
        Fun::Cbrt => "cbrt",
        // All others are written by `expression`.
        _ => "abs",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn one_to_any_power_needs_no_choice_where_that_is_finite() {
        let mut g = Graph::new();
        let ends = [(0.0, f64::INFINITY), (f64::NEG_INFINITY, 0.0)];
        let [declared, below] = [0, 1].map(|i| {
            let (lo, hi) = ends[usize::from(i)];
            g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::new(lo, hi))
        });
        let x = g.leaf(Leaf::Out(0), "x", Interval::ALL);
        let inverse = g.div(x, declared);
        let chosen = |exponent: Id| {
            let mut g = g.clone();
            let power = g.call(Fun::Pow1p, &[x, exponent]);
            let mut code = Code::new(&g, &|leaf| {
                format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap()
            });
            code.value(power);
            code.statements().to_string().contains("select")
        };
        assert_eq!([declared, below, inverse].map(chosen), [false, true, true]);
    }
}
