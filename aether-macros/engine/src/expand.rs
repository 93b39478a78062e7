//! `#[sampler]` and `#[map]` from tokens to tokens.

use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::{ToTokens, quote};
use syn::ItemFn;
use syn::parse::{Parse, ParseStream};

use crate::derive::by_fractions;
use crate::diagnostics::Diagnostics;
use crate::emit::text::source;
use crate::emit::{Emitter, Support, Texts, Ways, compose};
use crate::interpret::Item;
use crate::parse::{Options, signature};

/// Expands `#[sampler]`.
pub fn sampler(attr: TokenStream, item: TokenStream) -> TokenStream {
    expand(attr, item, true)
}

/// Expands `#[map]`.
pub fn map(attr: TokenStream, item: TokenStream) -> TokenStream {
    expand(attr, item, false)
}

fn expand(attr: TokenStream, item: TokenStream, sampler: bool) -> TokenStream {
    let mut errors = Diagnostics::new();
    let function = match syn::parse2::<ItemFn>(item.clone()) {
        Ok(function) => function,
        Err(_) => return unreadable(item, sampler),
    };
    let mut options = errors.ok(syn::parse2::<Options>(attr)).unwrap_or_default();
    let expanded = signature(&function, sampler, &mut errors).and_then(|signature| {
        let (sig, block) = (function.sig.to_token_stream(), function.block.to_token_stream());
        if let Some(cfg) = switch(sig.into_iter().chain(block)) {
            errors.error(
                cfg,
                "`#[cfg]` inside of a body or its parameters is not decided yet where the body is read: put it on the whole function, once for each case",
            );
            return None;
        }
        options.declared_of_names(&function, &signature);
        for d in &options.domains {
            let parameter = signature.params.iter().find(|p| p.name == d.name);
            if parameter.is_some_and(|p| !p.kind.is_number()) {
                errors.error(&d.name, format!("`{0}` is no number, and a domain is a range of numbers: write relations of its parts, such as `where {0}.x > 0.0`", d.name));
            }
            if parameter.is_none() {
                let known: Vec<String> =
                    signature.params.iter().map(|p| format!("`{}`", p.name)).collect();
                let known = if known.is_empty() {
                    "there are none".to_owned()
                } else {
                    format!("there are {}", known.join(", "))
                };
                errors.error(
                    &d.name,
                    format!("there is no parameter `{}` to declare the domain of; {known}", d.name),
                );
            }
        }
        if compose::is_composition(&function) {
            for d in &options.of_names {
                errors.error(&d.name, format!("`{}` is no parameter, and the body of a composition makes no numbers of its own: declare the domain of parameters", d.name));
            }
            if signature.mixed {
                errors.error(&function.sig.output, "a composition has no atoms of its own: write the body that leads to them as one `#[sampler]`, without `sample` and `apply`");
                return None;
            }
            return compose::emit(&function, &signature, &options, &mut errors);
        }
        let item = Item::compile(&function, signature, &options, &mut errors)?;
        let support = Support::of(&item);
        let Item { mut parsed, mut derived, atoms } = item;
        let texts = Texts::new(&mut parsed.pieces, &derived, &atoms);
        for (piece, derived) in parsed.pieces.iter_mut().zip(&mut derived) {
            by_fractions(&mut piece.problem.graph, derived);
        }
        let emitter = Emitter {
            item: &function,
            parsed: &parsed,
            derived: &derived,
            atoms: &atoms,
            texts: &texts,
            options: &options,
            support,
            ways: Ways::of(&parsed),
            meeting: Default::default(),
        };
        if options.explain || explained(&parsed.signature.name.to_string()) {
            emitter.explain();
        }
        Some(emitter.emit(sampler))
    });
    let tokens = match expanded {
        Some(tokens) if errors.is_empty() => tokens,
        _ => {
            let rendered = errors.render();
            let fallback = compose::fallback(&function, &options, sampler);
            quote!(#rendered #fallback)
        }
    };
    show_expansion(&function.sig.ident, &tokens);
    tokens
}

/// An attribute that may leave something out: rustc has not decided it yet.
fn switch(tokens: impl IntoIterator<Item = TokenTree>) -> Option<TokenTree> {
    let mut after_hash = false;
    tokens.into_iter().find_map(|token| {
        let is_attribute = std::mem::replace(&mut after_hash, false);
        match &token {
            TokenTree::Punct(punct) => after_hash = punct.as_char() == '#',
            TokenTree::Group(group) => {
                let first = group.stream().into_iter().next();
                let is_switch = |first: &TokenTree| {
                    matches!(first, TokenTree::Ident(name) if name == "cfg" || name == "cfg_attr")
                };
                if is_attribute {
                    return first.filter(is_switch);
                }
                return switch(group.stream());
            }
            _ => {}
        }
        None
    })
}

/// What is emitted for something that is no function that can be read. rustc reports errors of syntax
/// itself. A function that is being written has a signature already, so its constructor is emitted, and
/// its body as it stands, for the editor to complete in.
fn unreadable(item: TokenStream, sampler: bool) -> TokenStream {
    if let Ok(other) = syn::parse2::<syn::Item>(item.clone()) {
        let name = if sampler { "sampler" } else { "map" };
        let mut errors = Diagnostics::new();
        errors.error(other, format!("`#[{name}]` belongs on a function, `fn name(…) -> … {{ … }}`: it is the function's body that a density is derived from"));
        let rendered = errors.render();
        return quote!(#item #rendered);
    }
    match syn::parse2::<Unfinished>(item.clone()) {
        Ok(Unfinished { function, body }) => {
            compose::fallback_with(&function, &Options::default(), (&body, sampler))
        }
        Err(_) => item,
    }
}

/// A function whose body is no Rust yet.
struct Unfinished {
    /// The function with an empty body.
    function: ItemFn,
    /// The body, in braces.
    body: TokenStream,
}

impl Parse for Unfinished {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let attrs = input.call(syn::Attribute::parse_outer)?;
        let (vis, sig): (syn::Visibility, syn::Signature) = (input.parse()?, input.parse()?);
        let body: TokenStream = input.parse()?;
        let tokens = quote!(#(#attrs)* #vis #sig {});
        Ok(Unfinished { function: syn::parse2(tokens)?, body })
    }
}

/// `AETHER_EXPLAIN=name` asks for the derivation of one item from outside.
fn explained(name: &str) -> bool {
    names(std::env::var("AETHER_EXPLAIN").ok().as_deref(), name)
}

/// `AETHER_EXPAND=name` prints the code that is emitted for one item to the build's output.
pub(crate) fn show_expansion(name: &Ident, tokens: &TokenStream) {
    if names(std::env::var("AETHER_EXPAND").ok().as_deref(), &name.to_string()) {
        eprintln!("// {name}\n{}", source(tokens));
    }
}

/// Whether a variable of the environment names an item: one name, several with commas between them,
/// or `all`.
fn names(variable: Option<&str>, name: &str) -> bool {
    variable.is_some_and(|list| list.split(',').any(|n| n.trim() == name || n.trim() == "all"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_environment_names_items() {
        assert!(names(Some("lobe"), "lobe") && names(Some("disk, lobe"), "lobe"));
        assert!(names(Some("all"), "lobe"));
        assert!(!names(Some("lobes"), "lobe") && !names(Some(""), "lobe") && !names(None, "lobe"));
    }

    #[test]
    fn what_other_items_cost_does_not_matter() {
        let item = quote::quote!(
            fn student(u: [Uniform; 1]) -> f64 {
                solve(
                    |t| {
                        let r = 1.0 + t * t / 4.0;
                        0.5 + 0.375 * t / r.sqrt() * (1.0 - t * t / (12.0 * r))
                    },
                    ..,
                    u[0],
                )
            }
        );
        let alone = crate::sampler(TokenStream::new(), item.clone()).to_string();
        crate::poly::use_up_budget();
        let after_others = crate::sampler(TokenStream::new(), item).to_string();
        assert!(!alone.contains("compile_error"));
        assert_eq!(alone, after_others);
    }
}
