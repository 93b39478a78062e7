//! Emits the density: choices are enumerated in place, draws bind random variables instead of
//! values, locally constant calls are read back from the vertex.

mod ends;
mod kinds;

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, format_ident, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, Ident, Pat, Stmt, Type};

use super::analyse::Analysed;
use super::sample::alive;
use super::tree::{Action, End, Leaf};
use kinds::Kinds;

/// A block with the density of `target`, a vertex or a run of them: the sum of the terms of the kind that
/// the path asks for. Where there are several ways to make it, the one that is `taken` is left out if
/// `OTHERS`.
pub fn density(analysed: &Analysed, yields: &Type, joint: bool, real: &TokenStream) -> TokenStream {
    let (site, plan) = (Span::mixed_site(), &analysed.plan);
    let keepers = joint.then_some(&*analysed.keepers);
    let emitter = Emitter { vertex: yields, real, keepers, ways: analysed.has_ways() };
    let terms = emitter.rest(&plan.steps, &plan.end, &Pending::default());
    let kinds = Kinds::of_end(&plan.end);
    let terms = (kinds != Kinds::default()).then(|| {
        let asked = kinds.asked();
        quote_spanned!(site=> if #asked { #terms })
    });
    let same = emitter.ways.then(|| quote_spanned!(site=> let same = OTHERS;));
    quote_spanned! {site=>
        let kind = ::aether_core::sequence::PathView::dirac(&view);
        let mut sum = <#real as ::aether_core::Real>::ZERO;
        let probability = <#real as ::aether_core::Real>::ONE;
        #same
        #terms
        sum
    }
}

struct Emitter<'a> {
    vertex: &'a Type,
    real: &'a TokenStream,
    /// Which vertex of a joint run keeps the value of each locally constant call.
    keepers: Option<&'a [usize]>,
    /// Whether the way that was taken is to be recognised.
    ways: bool,
}

/// What waits for the drawn point.
#[derive(Clone, Default)]
struct Pending {
    /// The point that was drawn.
    root: Option<Ident>,
    /// Statements to evaluate once the drawn point is recovered.
    statements: Vec<TokenStream>,
    /// Whether these statements change the probability.
    weighs: bool,
    /// Statements that give the names in a locally constant call their types.
    typed: Vec<TokenStream>,
}

impl Pending {
    fn factor(&self, statement: TokenStream) -> Pending {
        let mut pending = self.clone();
        pending.statements.push(statement);
        pending.weighs = true;
        pending
    }
}

/// The name of something that belongs to a random point.
fn part(point: &Ident, what: &str) -> Ident {
    format_ident!("__{}_{}", point, what, span = Span::mixed_site())
}

impl Emitter<'_> {
    fn rest(&self, steps: &[Action], end: &End<Action, Leaf>, pending: &Pending) -> TokenStream {
        let Some((action, steps)) = steps.split_first() else { return self.end(end, pending) };
        let site = Span::mixed_site();
        let some = quote_spanned!(site=> ::core::option::Option::Some);
        let same = || self.rest(steps, end, pending);
        match action {
            Action::Plain(statement) => {
                let rest = same();
                quote_spanned!(site=> #statement #rest)
            }
            Action::LetElse { pat, value } => {
                let rest = same();
                quote_spanned!(site=> if let #pat = #value { #rest })
            }
            Action::Given { pat, value } => {
                let rest = same();
                quote_spanned!(site=> if let #some(value) = #value { let #pat = value; #rest })
            }
            Action::Constant { pat, call, number } => {
                let (rest, typed) = (same(), &pending.typed);
                let keeper = self.keepers.map(|keepers| keepers[*number]);
                let vertex = match keeper {
                    Some(keeper) => quote_spanned!(site=> &target[#keeper]),
                    None => quote_spanned!(site=> target),
                };
                let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
                let is_atom = Kinds::of_end(end) == Kinds { position: true, ..Kinds::default() };
                if is_atom && typed.is_empty() {
                    // Nothing is cast for it, and another atom of this kind may have the same type.
                    return quote_spanned! {site=>
                        if let #some((value, called)) =
                            #emitted::recall_called(#vertex, || { #call })
                            && {
                                #[allow(unused_imports)]
                                use #emitted::{Alike, ByEquality as _, Otherwise as _};
                                (&Alike(&value, &called)).alike() != #some(false)
                            }
                        {
                            let #pat = value;
                            #rest
                        }
                    };
                }
                quote_spanned! {site=>
                    if let #some(value) = #emitted::recall(#vertex, || { #(#typed)* #call }) {
                        let #pat = value;
                        #rest
                    }
                }
            }
            Action::Choose { pat, distribution, rule, number } => {
                let rest = same();
                let pat = pat.to_token_stream();
                let alive = alive(&pat, steps.is_empty().then_some(end));
                self.choice(&pat, (distribution, rule.as_ref(), alive), *number, &rest)
            }
            Action::LateChoose { pat, index, distribution, rule, number } => {
                let rest = self.rest(steps, end, &pending.factor(self.weigh(distribution, index)));
                let rest = quote_spanned! {site=>
                    let same = same && taken[#number] == #index;
                    #rest
                };
                self.late_choice(pat, index, (distribution, rule.as_ref()), &pending.typed, &rest)
            }
            Action::Late(statement) => {
                let mut pending = pending.clone();
                pending.statements.push(statement.to_token_stream());
                if matches!(statement, Stmt::Local(_)) {
                    pending.typed.push(statement.to_token_stream());
                }
                self.rest(steps, end, &pending)
            }
            Action::Draw { name, ty, sampler } => {
                let mut pending = pending.clone();
                pending.root = Some(name.clone());
                let ty = ty.as_ref().map(|ty| quote_spanned!(site=> : #ty));
                pending.typed.push(self.typed(name, ty));
                let variable = part(name, "sampler");
                let rest = self.rest(steps, end, &pending);
                quote_spanned!(site=> let #variable = #sampler; #rest)
            }
            Action::Map { name, map, of } => {
                let (binding, pending) = self.map(name, map, of, pending);
                let rest = self.rest(steps, end, &pending);
                quote_spanned!(site=> #binding #rest)
            }
        }
    }

    fn choice(
        &self,
        pat: &TokenStream,
        (distribution, rule, alive): (&Expr, Option<&Expr>, TokenStream),
        number: usize,
        rest: &TokenStream,
    ) -> TokenStream {
        let (real, vertex, site) = (self.real, self.vertex, Span::mixed_site());
        let some = quote_spanned!(site=> ::core::option::Option::Some);
        match rule {
            None => quote_spanned! {site=>
                let distribution = #distribution;
                for choice in ::aether_core::Discrete::<#real>::possible(&distribution, #alive) {
                    let same = same && taken[#number] == choice.index;
                    let probability = probability * choice.probability;
                    let #pat = choice.item;
                    #rest
                }
            },
            Some(rule) => quote_spanned! {site=>
                let distribution = #distribution;
                for index in ::aether_core::forms::emitted::identify::<#vertex, _>(target, #rule) {
                    if let #some(choice) =
                        ::aether_core::Discrete::<#real>::get(&distribution, index)
                        && choice.probability > <#real as ::aether_core::Real>::ZERO
                    {
                        let same = same && taken[#number] == index;
                        let probability = probability * choice.probability;
                        let #pat = choice.item;
                        #rest
                    }
                }
            },
        }
    }

    /// The outcomes of a choice whose probabilities wait for inversion.
    fn late_choice(
        &self,
        pat: &Pat,
        index: &Ident,
        (distribution, rule): (&Expr, Option<&Expr>),
        typed: &[TokenStream],
        rest: &TokenStream,
    ) -> TokenStream {
        let (real, vertex, site) = (self.real, self.vertex, Span::mixed_site());
        let some = quote_spanned!(site=> ::core::option::Option::Some);
        let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
        let indices = match rule {
            None => quote_spanned!(site=> outcomes.indices()),
            Some(rule) => quote_spanned!(site=> #emitted::identify::<#vertex, _>(target, #rule)),
        };
        let at = distribution.span().resolved_at(site);
        let outcomes_of = quote_spanned!(at=> #emitted::outcomes_of::<#real, _>);
        quote_spanned! {site=>
            let outcomes = #outcomes_of(|| { #(#typed)* #distribution });
            for #index in #indices {
                if let #some(outcome) = outcomes.outcome(#index) {
                    let #pat = outcome;
                    #rest
                }
            }
        }
    }

    /// Multiplies the factor by the probability of an outcome; if that is zero, no more of what
    /// depends on the drawn point is evaluated.
    fn weigh(&self, distribution: &Expr, index: &Ident) -> TokenStream {
        let real = self.real;
        quote_spanned! {Span::mixed_site()=>
            factor = factor
                * ::aether_core::forms::emitted::probability::<#real, _>(&#distribution, #index);
            if !(factor > <#real as ::aether_core::Real>::ZERO) {
                return <#real as ::aether_core::Real>::ZERO;
            }
        }
    }

    /// `let name = map.apply(&of);` as a random variable.
    fn map(
        &self,
        name: &Ident,
        map: &Expr,
        of: &Ident,
        pending: &Pending,
    ) -> (TokenStream, Pending) {
        let (real, site) = (self.real, Span::mixed_site());
        let (this, sampler, maps) = (part(name, "map"), part(name, "sampler"), part(name, "maps"));
        let before = part(of, "sampler");
        let composed = if pending.root.as_ref() == Some(of) {
            quote_spanned!(site=> #this)
        } else {
            let maps_before = part(of, "maps");
            quote_spanned!(site=> ::aether_core::Then::new(#maps_before, #this))
        };
        let mut pending = pending.clone();
        pending.statements.push(quote_spanned! {site=>
            let #name = ::aether_core::Map::<#real>::apply(&#this, &#of);
        });
        pending.typed.push(self.typed(name, None));
        let binding = quote_spanned! {site=>
            let #this = #map;
            let #sampler = ::aether_core::Then::new(#before, #this);
            let #maps = #composed;
        };
        (binding, pending)
    }

    fn typed(&self, name: &Ident, ty: Option<TokenStream>) -> TokenStream {
        let (real, sampler) = (self.real, part(name, "sampler"));
        quote_spanned! {Span::mixed_site()=>
            let #name #ty = ::aether_core::forms::emitted::point_of::<#real, _>(&#sampler);
        }
    }
}
