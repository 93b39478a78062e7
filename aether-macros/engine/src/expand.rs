//! `#[sampler]` and `#[map]` from tokens to tokens.

use proc_macro2::TokenStream;
use quote::quote;
use syn::ItemFn;

use crate::diagnostics::Diagnostics;
use crate::emit::{Emitter, Texts, compose};
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
    let Ok(function) = syn::parse2::<ItemFn>(item.clone()) else {
        // rustc reports the syntax error itself, on the tokens as they are.
        return item;
    };
    let options = errors.ok(syn::parse2::<Options>(attr)).unwrap_or_default();
    let expanded = signature(&function, sampler, &mut errors).and_then(|signature| {
        for d in &options.domains {
            if !signature.params.iter().any(|p| p.name == d.name) {
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
            return compose::emit(&function, &signature, &options, &mut errors);
        }
        let Item { mut parsed, derived } =
            Item::compile(&function, signature, &options, &mut errors)?;
        let texts = Texts::new(&mut parsed.pieces, &derived);
        let emitter = Emitter {
            item: &function,
            parsed: &parsed,
            derived: &derived,
            texts: &texts,
            options: &options,
        };
        if options.explain || explained(&parsed.signature.name.to_string()) {
            emitter.explain();
        }
        Some(emitter.emit(sampler))
    });
    match expanded {
        Some(tokens) if errors.is_empty() => tokens,
        _ => {
            let rendered = errors.render();
            let fallback = compose::fallback(&function, sampler);
            quote!(#rendered #fallback)
        }
    }
}

/// `AETHER_EXPLAIN=name` asks for the derivation of one item from outside.
fn explained(name: &str) -> bool {
    std::env::var("AETHER_EXPLAIN").is_ok_and(|v| v == name || v == "all")
}
