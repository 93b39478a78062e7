//! `#[sampler]` and `#[map]` from tokens to tokens.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use syn::ItemFn;

use crate::derive::derive;
use crate::diagnostics::Diagnostics;
use crate::emit::text::source;
use crate::emit::{Emitter, Texts, compose};
use crate::parse::{Options, parse, signature};

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
        let mut parsed = parse(&function, signature, &options, &mut errors)?;
        let mut derived = Vec::new();
        for piece in &mut parsed.pieces {
            match derive(&mut piece.problem) {
                Ok(d) => derived.push(d),
                Err(message) => {
                    errors.error(&function.sig.ident, message);
                    return None;
                }
            }
        }
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
    let tokens = match expanded {
        Some(tokens) if errors.is_empty() => tokens,
        _ => {
            let rendered = errors.render();
            let fallback = compose::fallback(&function, sampler);
            quote!(#rendered #fallback)
        }
    };
    show_expansion(&function.sig.ident, &tokens);
    tokens
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
}
