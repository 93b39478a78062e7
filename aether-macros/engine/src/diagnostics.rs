//! Errors on the user's tokens, collected so that one build reports all of them.

use proc_macro2::{Ident, TokenStream};
use quote::{ToTokens, quote};
use syn::{Attribute, Error};

/// The errors found so far in one item, in the order of discovery.
///
/// Each message says what is wrong, why, and the way out.
#[derive(Debug, Default)]
pub struct Diagnostics {
    errors: Vec<Error>,
}

impl Diagnostics {
    /// No error yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an error that underlines `tokens`.
    pub fn error(&mut self, tokens: impl ToTokens, message: impl core::fmt::Display) {
        self.errors.push(Error::new_spanned(tokens, message));
    }

    /// Adds an error that somebody else made, such as the parser.
    pub fn push(&mut self, error: Error) {
        self.errors.push(error);
    }

    /// The value of a result; its error is kept here.
    pub fn ok<T>(&mut self, result: syn::Result<T>) -> Option<T> {
        result.map_err(|error| self.errors.push(error)).ok()
    }

    /// Whether nothing was wrong.
    pub fn is_empty(&self) -> bool {
        self.errors.is_empty()
    }

    /// How many errors there are.
    pub fn len(&self) -> usize {
        self.errors.len()
    }

    /// The messages, one for each error.
    pub fn messages(&self) -> Vec<String> {
        let parts = self.errors.iter().flat_map(|error| error.clone().into_iter());
        parts.map(|error| error.to_string()).collect()
    }

    /// One `compile_error!` item for each error.
    pub fn render(&self) -> TokenStream {
        self.errors.iter().map(Error::to_compile_error).collect()
    }

    /// All errors as one, or `value` if there are none.
    pub fn finish<T>(self, value: T) -> syn::Result<T> {
        let combined = self.errors.into_iter().reduce(|mut all, error| {
            all.combine(error);
            all
        });
        combined.map_or(Ok(value), Err)
    }
}

/// Whether an attribute sets the level of lints.
pub fn is_lint(attribute: &Attribute) -> bool {
    ["allow", "expect", "warn", "deny", "forbid"].iter().any(|l| attribute.path().is_ident(l))
}

/// A warning of rustc at a name, where the lints that attributes set do not forbid it. There is no other lint for macros
/// than that of deprecated items.
pub fn warning(at: &Ident, attributes: &[Attribute], message: &str) -> TokenStream {
    let lints = attributes.iter().filter(|attribute| is_lint(attribute));
    let used = Ident::new("warning", at.span());
    quote! {
        #(#lints)*
        const _: () = {
            #[deprecated(note = #message)]
            #[allow(non_upper_case_globals)]
            const warning: () = ();
            #used
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_error_is_rendered() {
        let mut diagnostics = Diagnostics::new();
        assert!(diagnostics.is_empty());
        diagnostics.error(quote!(a + b), "first");
        assert_eq!(diagnostics.ok::<u8>(Err(Error::new_spanned(quote!(c), "second"))), None);
        assert_eq!(diagnostics.messages(), ["first", "second"]);
        let text = diagnostics.render().to_string();
        assert_eq!(text.matches("compile_error").count(), 2);
        assert!(diagnostics.finish(()).is_err());
    }
}
