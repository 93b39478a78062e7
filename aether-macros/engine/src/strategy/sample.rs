//! Emits the sampling code.

use proc_macro2::{Span, TokenStream};
use quote::quote_spanned;
use syn::spanned::Spanned;

use super::tree::{Action, End, Kind, Leaf, Plan};

/// The body of `sample`: every path of execution returns.
pub fn sample(plan: &Plan, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    let steps = plan.steps.iter().map(|action| step(action, real));
    let end = match &plan.end {
        End::Stop => quote_spanned!(site=> return ::core::option::Option::None;),
        End::Delegate(strategy) => quote_spanned! {site=>
            return ::aether_core::forms::emitted::delegated(&#strategy, view, uniforms);
        },
        End::Vertex(leaf) => vertex(leaf),
        End::If { condition, then, otherwise, .. } => {
            let (then, otherwise) = (sample(then, real), sample(otherwise, real));
            quote_spanned!(site=> if #condition { #then } else { #otherwise })
        }
        End::Match { value, arms } => {
            let arms = arms.iter().map(|(pat, arm)| {
                let arm = sample(arm, real);
                quote_spanned!(site=> #pat => { #arm })
            });
            quote_spanned!(site=> match #value { #(#arms)* })
        }
    };
    quote_spanned!(site=> #(#steps)* #end)
}

fn vertex(leaf: &Leaf) -> TokenStream {
    let site = Span::mixed_site();
    let vertex = &leaf.vertex;
    let drawn = quote_spanned!(site=> ::aether_core::strategy::Drawn);
    let dirac = quote_spanned!(site=> ::aether_core::strategy::Dirac);
    let made = match leaf.kind {
        Kind::Density(_) => quote_spanned!(site=> #drawn::new(#vertex)),
        Kind::AtomPosition => quote_spanned!(site=> #drawn::atom(#vertex, #dirac::Position)),
        Kind::AtomDirection => quote_spanned!(site=> #drawn::atom(#vertex, #dirac::Direction)),
    };
    let visible = leaf.visible.then(|| quote_spanned!(site=> .visible()));
    quote_spanned!(site=> return ::core::option::Option::Some(#made #visible);)
}

fn step(action: &Action, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
    match action {
        Action::Plain(statement) | Action::Late(statement) => quote_spanned!(site=> #statement),
        Action::LetElse { pat, value } => quote_spanned! {site=>
            let #pat = #value else { return ::core::option::Option::None; };
        },
        Action::Given { pat, value: option } | Action::Constant { pat, call: option } => {
            unwrap(quote_spanned!(site=> #pat), quote_spanned!(site=> #option))
        }
        Action::Choose { pat, distribution, .. } => quote_spanned! {site=>
            let distribution = #distribution;
            let #pat = ::aether_core::Discrete::<#real>::sample(
                &distribution,
                ::aether_core::UniformSource::<#real>::next(&mut *uniforms),
            ).item;
        },
        Action::LateChoose { pat, distribution, .. } => {
            let outcome = quote_spanned! {distribution.span().resolved_at(site)=>
                #emitted::outcome::<#real, _>
            };
            quote_spanned! {site=>
                let #pat = #outcome(
                    &#distribution,
                    ::aether_core::UniformSource::<#real>::next(&mut *uniforms),
                );
            }
        }
        Action::Draw { name, ty, sampler } => {
            let ty = ty.as_ref().map(|ty| quote_spanned!(site=> : #ty));
            let draw = quote_spanned! {site=>
                #emitted::draw::<#real, _, _>(&#sampler, &mut *uniforms)
            };
            unwrap(quote_spanned!(site=> #name #ty), draw)
        }
        Action::Map { name, map, of } => unwrap(
            quote_spanned!(site=> #name),
            quote_spanned!(site=> #emitted::mapped::<#real, _>(&#map, &#of)),
        ),
    }
}

/// `let pat = option?;`
fn unwrap(pat: TokenStream, option: TokenStream) -> TokenStream {
    quote_spanned! {Span::mixed_site()=>
        let #pat = match #option {
            ::core::option::Option::Some(value) => value,
            ::core::option::Option::None => return ::core::option::Option::None,
        };
    }
}
