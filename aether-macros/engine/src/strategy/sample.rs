//! Emits the sampling code, and on the way the density of what is sampled, from what was drawn rather
//! than by inversion: exact where rounding would put the vertex outside of a support. Where a vertex may
//! have come about in other ways too, these are added by inversion.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, Ident};

use super::analyse::Analysed;
use super::tree::{Action, End, Kind, Leaf, Plan};

/// The body of `sample`: every path of execution returns. `own` is the density by the way that is taken,
/// as far as it is known, `several` whether there may be others, and `taken` says which way it is.
pub fn sample(analysed: &Analysed, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    let Analysed { plan, choices, late, .. } = analysed;
    let body = Emitter { real, late: *late, ways: analysed.has_ways() }.plan(plan, &[]);
    quote_spanned! {site=>
        let own = ::core::option::Option::Some(<#real as ::aether_core::Real>::ONE);
        let several = false;
        let mut taken = [0_usize; #choices];
        #body
    }
}

/// The numbers of the choices on the way to a vertex, and the rules that tell their outcomes from it.
type Rules = [(usize, Expr)];

struct Emitter<'a> {
    real: &'a TokenStream,
    /// Whether decisions depend on what was drawn.
    late: bool,
    /// Whether a vertex may come about in several ways.
    ways: bool,
}

/// The name of the density of a random point.
fn density_of(point: &Ident) -> Ident {
    format_ident!("__{}_own", point, span = Span::mixed_site())
}

/// The name of the random variable that a random point is of.
fn sampler_of(point: &Ident) -> Ident {
    format_ident!("__{}_sampler", point, span = Span::mixed_site())
}

impl Emitter<'_> {
    fn plan(&self, plan: &Plan, rules: &Rules) -> TokenStream {
        let mut rules = rules.to_vec();
        let mut steps = TokenStream::new();
        for (k, action) in plan.steps.iter().enumerate() {
            let last = k + 1 == plan.steps.len();
            self.step(action, last.then_some(&plan.end), &mut rules).to_tokens(&mut steps);
        }
        let end = self.end(&plan.end, &rules);
        quote_spanned!(Span::mixed_site()=> #steps #end)
    }

    fn end(&self, end: &End<Action, Leaf>, rules: &Rules) -> TokenStream {
        let site = Span::mixed_site();
        match end {
            End::Stop => quote_spanned!(site=> return ::core::option::Option::None;),
            End::Delegate { strategy, number } => self.delegate(strategy, *number, rules),
            End::Vertex(leaf) => self.vertex(leaf, rules),
            End::If { condition, late, then, otherwise } => {
                // The other side may have led to the same vertex, from another point.
                let both =
                    *late && !matches!(then.end, End::Stop) && !matches!(otherwise.end, End::Stop);
                let several = both.then(|| quote_spanned!(site=> let several = true;));
                let (then, otherwise) = (self.plan(then, rules), self.plan(otherwise, rules));
                quote_spanned!(site=> #several if #condition { #then } else { #otherwise })
            }
            End::Match { value, arms } => {
                let arms = arms.iter().map(|(pat, arm)| {
                    let arm = self.plan(arm, rules);
                    quote_spanned!(site=> #pat => { #arm })
                });
                quote_spanned!(site=> match #value { #(#arms)* })
            }
        }
    }

    fn vertex(&self, leaf: &Leaf, rules: &Rules) -> TokenStream {
        let site = Span::mixed_site();
        let some = |kind: &str| {
            let kind = Ident::new(kind, site);
            quote_spanned! {site=>
                ::core::option::Option::Some(::aether_core::strategy::Dirac::#kind)
            }
        };
        let (point, dirac) = match &leaf.kind {
            Kind::Density(point) => {
                (Some(point), quote_spanned!(site=> ::core::option::Option::None))
            }
            Kind::AtomDirection(point) => (point.as_ref(), some("Direction")),
            Kind::AtomPosition => (None, some("Position")),
        };
        self.drawn(leaf, point, &dirac, rules)
    }

    /// The vertex of another strategy, with the density or probability that this one gives it.
    fn delegate(&self, strategy: &Expr, number: usize, rules: &Rules) -> TokenStream {
        let site = Span::mixed_site();
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        let delegated = unwrap(
            quote_spanned!(site=> drawn),
            quote_spanned! {site=>
                #emitted::delegated(&#strategy, view, uniforms)
            },
        );
        let ways = self.ways(number, rules, &quote_spanned!(site=> drawn.dirac));
        quote_spanned! {site=>
            #delegated
            let vertex = drawn.vertex;
            let own = #emitted::own_times(own, drawn.value);
            #ways
            return ::core::option::Option::Some(
                ::aether_core::strategy::Drawn { value: own, ..drawn }
            );
        }
    }

    /// Adds to the `own` density of `vertex` that of the other ways, if there are any.
    fn ways(&self, number: usize, rules: &Rules, dirac: &TokenStream) -> TokenStream {
        if !self.ways {
            return TokenStream::new();
        }
        let site = Span::mixed_site();
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        let identified = rules.iter().map(|(choice, rule)| {
            quote_spanned! {site=>
                let others = #emitted::several_identified(&vertex, #rule, taken[#choice]);
                let own = if others.is_some() { own } else { ::core::option::Option::None };
                let several = several || others == ::core::option::Option::Some(true);
            }
        });
        quote_spanned! {site=>
            #(#identified)*
            let own = #emitted::with_others(own, several, || {
                let view = ::aether_core::sequence::PathView::asking(view, #dirac);
                self.__density::<true>(&view, &vertex, &taken, #number)
            });
        }
    }

    /// A vertex with its density, that of the point that it was made from, if there is one; or the probability of its
    /// atom.
    fn drawn(
        &self,
        leaf: &Leaf,
        point: Option<&Ident>,
        dirac: &TokenStream,
        rules: &Rules,
    ) -> TokenStream {
        let site = Span::mixed_site();
        let (vertex, number) = (&leaf.vertex, leaf.number);
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        // A space that does not fit the vertex is reported there, by the density.
        let density = point
            .map(density_of)
            .map(|density| quote_spanned!(site=> let own = #emitted::own_times(own, #density);));
        let ways = self.ways(number, rules, dirac);
        let visible = leaf.visible.then(|| quote_spanned!(site=> .visible()));
        quote_spanned! {site=>
            let vertex = #vertex;
            #density
            #ways
            let drawn = ::aether_core::strategy::Drawn::new(vertex);
            return ::core::option::Option::Some(
                ::aether_core::strategy::Drawn { value: own, dirac: #dirac, ..drawn } #visible
            );
        }
    }

    /// A statement; `end` is what follows it, if no other statement does.
    fn step(
        &self,
        action: &Action,
        end: Option<&End<Action, Leaf>>,
        rules: &mut Vec<(usize, Expr)>,
    ) -> TokenStream {
        let (real, site) = (self.real, Span::mixed_site());
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        match action {
            Action::Plain(statement) | Action::Late(statement) => {
                quote_spanned!(site=> #statement)
            }
            Action::LetElse { pat, value } => quote_spanned! {site=>
                let #pat = #value else { return ::core::option::Option::None; };
            },
            Action::Given { pat, value: option } | Action::Constant { pat, call: option, .. } => {
                unwrap(quote_spanned!(site=> #pat), quote_spanned!(site=> #option))
            }
            Action::Choose { pat, distribution, rule, number } => {
                let several = match rule {
                    Some(rule) => {
                        rules.push((*number, rule.clone()));
                        TokenStream::new()
                    }
                    None => {
                        let alive = alive(&pat.to_token_stream(), end);
                        quote_spanned! {site=>
                            let several = several
                                || #emitted::several::<#real, _>(&distribution, #alive);
                        }
                    }
                };
                quote_spanned! {site=>
                    let distribution = #distribution;
                    let choice = ::aether_core::Discrete::<#real>::sample(
                        &distribution,
                        ::aether_core::UniformSource::<#real>::choice(&mut *uniforms),
                    );
                    taken[#number] = choice.index;
                    #several
                    let own = #emitted::own_times(
                        own, ::core::option::Option::Some(choice.probability),
                    );
                    let #pat = choice.item;
                }
            }
            Action::LateChoose { pat, distribution, rule, number, .. } => {
                let outcome = quote_spanned! {distribution.span().resolved_at(site)=>
                    #emitted::outcome::<#real, _>
                };
                let several = match rule {
                    Some(rule) => {
                        rules.push((*number, rule.clone()));
                        TokenStream::new()
                    }
                    None => quote_spanned!(site=> let several = true;),
                };
                quote_spanned! {site=>
                    let (choice, outcome) = #outcome(
                        &#distribution,
                        ::aether_core::UniformSource::<#real>::choice(&mut *uniforms),
                    );
                    taken[#number] = choice.index;
                    #several
                    let own = #emitted::own_times(
                        own, ::core::option::Option::Some(choice.probability),
                    );
                    let #pat = outcome;
                }
            }
            Action::Draw { name, ty, sampler } => {
                let ty = ty.as_ref().map(|ty| quote_spanned!(site=> : #ty));
                let (density, variable) = (density_of(name), sampler_of(name));
                let draw = quote_spanned!(site=>
                    #emitted::draw_with_density::<#real, _, _>(&#variable, &mut *uniforms));
                let drawn = unwrap(quote_spanned!(site=> drawn), draw);
                quote_spanned! {site=>
                    let #variable = #sampler;
                    #drawn
                    let #name #ty = drawn.0;
                    let #density = drawn.1;
                }
            }
            Action::Map { name, map, of } => {
                let ([density, before], weighed) = ([name, of].map(density_of), self.late);
                let [variable, variable_before] = [name, of].map(sampler_of);
                let image = quote_spanned! {site=>
                    #emitted::mapped_with_density::<#real, _, _>(
                        &#variable_before, &map, &#of, #before, #weighed,
                    )
                };
                let image = unwrap(quote_spanned!(site=> image), image);
                quote_spanned! {site=>
                    let map = #map;
                    #image
                    let #variable = ::aether_core::Then::new(#variable_before, map);
                    let #name = image.0;
                    let #density = image.1;
                }
            }
        }
    }
}

/// Which outcomes lead to a vertex, where an `if` that may stop follows at once; otherwise all may.
pub fn alive(pat: &TokenStream, end: Option<&End<Action, Leaf>>) -> TokenStream {
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
