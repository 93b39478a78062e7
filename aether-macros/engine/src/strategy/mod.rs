//! `#[strategy]`: from a function that samples the next vertex to its density.
//!
//! `signature` and `parse` read the function, `analyse` (with `scope` and `leaf`) finds what depends
//! on what was drawn, `sample` and `density` emit the two halves of the `Strategy` implementation,
//! `item` the rest.

mod analyse;
mod density;
mod item;
mod joint;
mod leaf;
mod misuse;
mod names;
mod parse;
mod reads;
mod sample;
mod scope;
mod signature;
#[cfg(test)]
mod tests;
mod tree;

use proc_macro2::TokenStream;
use quote::quote;
use syn::{ItemFn, LitBool, Token};

use crate::diagnostics::Diagnostics;

/// Expands `#[strategy]`.
///
/// The only argument is `connected = true` or `connected = false`: whether the vertex before sees
/// each new vertex. By default it is derived: a vertex that a locally constant call finds from the
/// path and the drawn point (or from the path alone, for an atom) was found by a ray cast. Of several
/// vertices of one draw it says whether each sees the next; by default they are not known to.
///
/// After an error the function is emitted nevertheless, hidden, so that editors keep working.
pub fn strategy(attr: TokenStream, item: TokenStream) -> TokenStream {
    let function: ItemFn = match syn::parse2(item.clone()) {
        Ok(function) => function,
        Err(error) => {
            let error = error.to_compile_error();
            return quote!(#item #error);
        }
    };
    let mut diagnostics = Diagnostics::new();
    let connected = diagnostics.ok(connected(attr)).flatten();
    let signature = signature::signature(&function, &mut diagnostics);
    let Some(signature) = signature else {
        let (hidden, errors) = (item::hidden(&function, None), diagnostics.render());
        return quote!(#hidden #errors);
    };
    let reads = reads::reads(&function.block, &signature.path, &mut diagnostics);
    let body = parse::body(&function.block.stmts, &mut diagnostics);
    let documentation = item::documentation(&body);
    // What is missing from a body that could not be read would only cause errors of no interest.
    let plan = diagnostics
        .is_empty()
        .then(|| analyse::plan(body, &signature.path, connected, signature.count, &mut diagnostics))
        .filter(|_| diagnostics.is_empty());
    let emitted = item::item(&function, &signature, &documentation, reads, plan.as_ref());
    let errors = diagnostics.render();
    let tokens = quote!(#emitted #errors);
    crate::expand::show_expansion(&function.sig.ident, &tokens);
    tokens
}

/// Reads the arguments of the attribute.
fn connected(attr: TokenStream) -> syn::Result<Option<bool>> {
    if attr.is_empty() {
        return Ok(None);
    }
    let parse = |input: syn::parse::ParseStream| {
        let name: syn::Ident = input.parse()?;
        if name != "connected" {
            let message = "unknown argument: a strategy takes `connected = true` or `connected = \
                           false`, or none";
            return Err(syn::Error::new(name.span(), message));
        }
        input.parse::<Token![=]>()?;
        input.parse::<LitBool>()
    };
    syn::parse::Parser::parse2(parse, attr).map(|value| Some(value.value))
}
