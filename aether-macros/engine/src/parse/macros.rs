//! Macros in a body: `matches!` is a condition, `debug_assert!` says nothing, `unreachable!` is a way without a point.

use syn::{Expr, Pat};

use super::Value;
use super::body::Body;

/// Whether tokens call a macro that says nothing of a point.
pub(super) fn is_only_checked(call: &syn::Macro) -> bool {
    let name = call.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
    name.starts_with("debug_assert")
}

impl Body<'_> {
    /// The value of a macro: `matches!(x, pattern)` and `unreachable!()` have one.
    pub(super) fn of_macro(&mut self, call: &syn::Macro) -> Option<Value> {
        let name = call.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
        match name.as_str() {
            "matches" => {
                let Ok(Matches { value, pattern, guard }) = call.parse_body() else {
                    return self.error(call, "`matches!` takes a value and a pattern: `matches!(x, 0.25..0.5)`");
                };
                let value = self.expr(&value)?;
                let fits = self.scoped(|body| {
                    let fits = body.fits(&pattern, &value)?;
                    match &guard {
                        Some(guard) if fits => body.truth(guard),
                        _ => Some(fits),
                    }
                });
                fits.map(Value::Bool)
            }
            "unreachable" => {
                self.leave(Value::Nothing);
                Some(Value::Unit)
            }
            _ if is_only_checked(call) => Some(Value::Unit),
            "assert" | "assert_eq" | "assert_ne" => self.error(call, format!("a sampler does not panic, so `{name}!` has no place in a body: what has to hold of parameters is declared, `#[sampler(k in 0.0..=1.0, where a < b)]`, and there is no point where `require(…)` does not hold. What you want to be read, and not to be tested, is `debug_{name}!`")),
            _ => self.error(call, "a body is read as mathematics and evaluated in other forms, so a macro has no place in it but `matches!`, `debug_assert!` and `unreachable!`: write the formula out, and print where the sample is used"),
        }
    }
}

/// The arguments of `matches!`.
struct Matches {
    value: Expr,
    pattern: Pat,
    guard: Option<Expr>,
}

impl syn::parse::Parse for Matches {
    fn parse(input: syn::parse::ParseStream) -> syn::Result<Self> {
        let value = input.parse()?;
        input.parse::<syn::Token![,]>()?;
        let pattern = Pat::parse_multi_with_leading_vert(input)?;
        let guard = match input.parse::<Option<syn::Token![if]>>()? {
            Some(_) => Some(input.parse()?),
            None => None,
        };
        let _ = input.parse::<Option<syn::Token![,]>>()?;
        Ok(Matches { value, pattern, guard })
    }
}
