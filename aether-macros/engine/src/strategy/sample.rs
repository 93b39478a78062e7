//! Emits the sampling code, and on the way the density of what is sampled, from what was drawn rather
//! than by inversion: exact where rounding would put the vertex outside of a support. Where a vertex may
//! have come about in other ways too, only inversion can tell, and nothing is said.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, Ident};

use super::tree::{Action, End, Kind, Leaf, Plan};

/// The body of `sample`: every path of execution returns.
pub fn sample(plan: &Plan, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    let body = Emitter { real }.plan(plan, Own { known: true, identified: Vec::new() });
    quote_spanned! {site=>
        let own = ::core::option::Option::Some(<#real as ::aether_core::Real>::ONE);
        #body
    }
}

/// What is known of the choices on the way to a vertex.
#[derive(Clone)]
struct Own {
    /// Whether the density can be told without inversion.
    known: bool,
    /// The names of the indices that were chosen, and the rules that tell them from the vertex.
    identified: Vec<(Ident, Expr)>,
}

struct Emitter<'a> {
    real: &'a TokenStream,
}

/// The name of the density of a random point.
fn density_of(point: &Ident) -> Ident {
    format_ident!("__{}_own", point, span = Span::mixed_site())
}

impl Emitter<'_> {
    fn plan(&self, plan: &Plan, mut own: Own) -> TokenStream {
        let mut steps = TokenStream::new();
        for (k, action) in plan.steps.iter().enumerate() {
            let last = k + 1 == plan.steps.len();
            self.step(action, last.then_some(&plan.end), &mut own).to_tokens(&mut steps);
        }
        let end = self.end(&plan.end, own);
        quote_spanned!(Span::mixed_site()=> #steps #end)
    }

    fn end(&self, end: &End<Action, Leaf>, own: Own) -> TokenStream {
        let site = Span::mixed_site();
        match end {
            End::Stop => quote_spanned!(site=> return ::core::option::Option::None;),
            End::Delegate(strategy) => quote_spanned! {site=>
                return ::aether_core::forms::emitted::delegated(&#strategy, view, uniforms);
            },
            End::Vertex(leaf) => self.vertex(leaf, &own),
            End::If { condition, then, otherwise, .. } => {
                let (then, otherwise) = (self.plan(then, own.clone()), self.plan(otherwise, own));
                quote_spanned!(site=> if #condition { #then } else { #otherwise })
            }
            End::Match { value, arms } => {
                let arms = arms.iter().map(|(pat, arm)| {
                    let arm = self.plan(arm, own.clone());
                    quote_spanned!(site=> #pat => { #arm })
                });
                quote_spanned!(site=> match #value { #(#arms)* })
            }
        }
    }

    fn vertex(&self, leaf: &Leaf, own: &Own) -> TokenStream {
        let site = Span::mixed_site();
        let vertex = &leaf.vertex;
        let drawn = quote_spanned!(site=> ::aether_core::strategy::Drawn);
        let dirac = quote_spanned!(site=> ::aether_core::strategy::Dirac);
        let made = match &leaf.kind {
            Kind::Density(point) if own.known => return self.density(leaf, point, own),
            Kind::Density(_) => quote_spanned!(site=> #drawn::new(#vertex)),
            Kind::AtomPosition => quote_spanned!(site=> #drawn::atom(#vertex, #dirac::Position)),
            Kind::AtomDirection => quote_spanned!(site=> #drawn::atom(#vertex, #dirac::Direction)),
        };
        let visible = leaf.visible.then(|| quote_spanned!(site=> .visible()));
        quote_spanned!(site=> return ::core::option::Option::Some(#made #visible);)
    }

    /// A vertex with its density.
    fn density(&self, leaf: &Leaf, point: &Ident, own: &Own) -> TokenStream {
        let site = Span::mixed_site();
        let (vertex, density) = (&leaf.vertex, density_of(point));
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        let identified = own.identified.iter().map(|(index, rule)| {
            quote_spanned!(site=> let own = #emitted::if_identified(own, &vertex, #rule, #index);)
        });
        let visible = leaf.visible.then(|| quote_spanned!(site=> .visible()));
        // A space that does not fit the vertex is reported there, by the density.
        quote_spanned! {site=>
            let vertex = #vertex;
            let own = #emitted::own_times(own, #density);
            #(#identified)*
            let drawn = ::aether_core::strategy::Drawn::new(vertex);
            return ::core::option::Option::Some(
                ::aether_core::strategy::Drawn { value: own, ..drawn } #visible
            );
        }
    }

    /// A statement; `end` is what follows it, if no other statement does.
    fn step(&self, action: &Action, end: Option<&End<Action, Leaf>>, own: &mut Own) -> TokenStream {
        let (real, site) = (self.real, Span::mixed_site());
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        match action {
            Action::Plain(statement) | Action::Late(statement) => {
                quote_spanned!(site=> #statement)
            }
            Action::LetElse { pat, value } => quote_spanned! {site=>
                let #pat = #value else { return ::core::option::Option::None; };
            },
            Action::Given { pat, value: option } | Action::Constant { pat, call: option } => {
                unwrap(quote_spanned!(site=> #pat), quote_spanned!(site=> #option))
            }
            Action::Choose { pat, distribution, rule } => {
                let probability = match rule {
                    Some(rule) => identified(rule, own),
                    None => {
                        let alive = alive(&pat.to_token_stream(), end);
                        let only = quote_spanned!(site=> #emitted::only::<#real, _>(&distribution, #alive));
                        times(own, only)
                    }
                };
                quote_spanned! {site=>
                    let distribution = #distribution;
                    let choice = ::aether_core::Discrete::<#real>::sample(
                        &distribution,
                        ::aether_core::UniformSource::<#real>::next(&mut *uniforms),
                    );
                    #probability
                    let #pat = choice.item;
                }
            }
            Action::LateChoose { pat, distribution, rule, .. } => {
                let outcome = quote_spanned! {distribution.span().resolved_at(site)=>
                    #emitted::outcome::<#real, _>
                };
                let probability = match rule {
                    Some(rule) => identified(rule, own),
                    None => {
                        own.known = false;
                        TokenStream::new()
                    }
                };
                quote_spanned! {site=>
                    let (choice, outcome) = #outcome(
                        &#distribution,
                        ::aether_core::UniformSource::<#real>::next(&mut *uniforms),
                    );
                    #probability
                    let #pat = outcome;
                }
            }
            Action::Draw { name, ty, sampler } => {
                let ty = ty.as_ref().map(|ty| quote_spanned!(site=> : #ty));
                let density = density_of(name);
                if !own.known {
                    let draw = quote_spanned!(site=>
                        #emitted::draw::<#real, _, _>(&#sampler, &mut *uniforms));
                    return unwrap(quote_spanned!(site=> #name #ty), draw);
                }
                let draw = quote_spanned!(site=>
                    #emitted::draw_with_density::<#real, _, _>(&#sampler, &mut *uniforms));
                let drawn = unwrap(quote_spanned!(site=> drawn), draw);
                quote_spanned!(site=> #drawn let #name #ty = drawn.0; let #density = drawn.1;)
            }
            Action::Map { name, map, of } => {
                let (density, before) = (density_of(name), density_of(of));
                if !own.known {
                    let image = quote_spanned!(site=> #emitted::mapped::<#real, _>(&#map, &#of));
                    return unwrap(quote_spanned!(site=> #name), image);
                }
                let image = quote_spanned!(site=>
                    #emitted::mapped_with_density::<#real, _>(&#map, &#of, #before));
                let image = unwrap(quote_spanned!(site=> image), image);
                quote_spanned!(site=> #image let #name = image.0; let #density = image.1;)
            }
        }
    }
}

/// Multiplies what is known of the density by a probability; no code if nothing is known.
fn times(own: &Own, probability: TokenStream) -> TokenStream {
    if !own.known {
        return TokenStream::new();
    }
    quote_spanned! {Span::mixed_site()=>
        let own = ::aether_core::forms::emitted::own_times(own, #probability);
    }
}

/// Multiplies by the probability of a choice that the vertex tells, if it does; the rule waits for the
/// vertex.
fn identified(rule: &Expr, own: &mut Own) -> TokenStream {
    let site = Span::mixed_site();
    let index = format_ident!("__index_{}", own.identified.len(), span = site);
    own.identified.push((index.clone(), rule.clone()));
    let times = times(own, quote_spanned!(site=> ::core::option::Option::Some(choice.probability)));
    let index = own.known.then(|| quote_spanned!(site=> let #index = choice.index;));
    quote_spanned!(site=> #index #times)
}

/// Which outcomes lead to a vertex, where an `if` that may stop follows at once; otherwise all.
fn alive(pat: &TokenStream, end: Option<&End<Action, Leaf>>) -> TokenStream {
    let site = Span::mixed_site();
    let stops = |plan: &Plan| matches!(plan.end, End::Stop);
    match end {
        Some(End::If { condition, late: false, then, otherwise })
            if stops(then) != stops(otherwise) =>
        {
            let negated = stops(then);
            quote_spanned!(site=> |#pat| (#condition) != #negated)
        }
        _ => quote_spanned!(site=> |_| true),
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
