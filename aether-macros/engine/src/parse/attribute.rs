//! The arguments of the attribute: `explain`, and domains of parameters.

use quote::ToTokens;
use syn::parse::{Parse, ParseStream};
use syn::{BinOp, Expr, ExprBinary, ExprRange, Ident, RangeLimits, Token, UnOp};

use crate::interval::Interval;

/// The declared domain of one parameter.
#[derive(Clone, Debug)]
pub struct Domain {
    /// The parameter.
    pub name: Ident,
    /// Its interval.
    pub interval: Interval,
    /// Whether the upper end belongs to the domain.
    pub closed: bool,
    /// Whether only whole numbers do: the ends are written as such, `3..=16`.
    pub whole: bool,
    /// The declaration as written, for error texts.
    pub text: String,
}

/// A relation between parameters: `where a < b`.
#[derive(Clone)]
pub struct Relation {
    /// The comparison.
    pub comparison: ExprBinary,
    /// The declaration as written, for error texts.
    pub text: String,
}

/// The options of an item.
#[derive(Clone, Default)]
pub struct Options {
    /// Print the derivation while compiling.
    pub explain: bool,
    /// Declared domains of parameters.
    pub domains: Vec<Domain>,
    /// Declared domains of what the body makes of them.
    pub of_names: Vec<Domain>,
    /// Declared relations.
    pub relations: Vec<Relation>,
}

impl Options {
    /// The domain of a parameter.
    pub fn domain(&self, name: &str) -> Option<&Domain> {
        self.domains.iter().find(|d| d.name == name)
    }
}

impl Parse for Options {
    fn parse(input: ParseStream) -> syn::Result<Self> {
        let mut options = Options::default();
        while !input.is_empty() {
            if input.peek(Token![where]) {
                input.parse::<Token![where]>()?;
                options.relations.push(relation(input.parse()?)?);
                if !input.is_empty() {
                    input.parse::<Token![,]>()?;
                }
                continue;
            }
            let name: Ident = input.parse()?;
            if name == "explain" && !input.peek(Token![in]) {
                options.explain = true;
            } else if input.peek(Token![in]) {
                input.parse::<Token![in]>()?;
                let range: Expr = input.parse()?;
                if options.domain(&name.to_string()).is_some() {
                    return Err(syn::Error::new(
                        name.span(),
                        format!(
                            "`{name}` has a domain already: declare the numbers that lie in both"
                        ),
                    ));
                }
                options.domains.push(domain(name, &range)?);
            } else if input.peek(Token![<])
                || input.peek(Token![>])
                || input.peek(Token![<=])
                || input.peek(Token![>=])
            {
                return Err(syn::Error::new(
                    name.span(),
                    format!(
                        "a comparison follows `where`, as in `where {name} < b`; the numbers that a parameter may be are a range, as in `{name} in 0.0..=1.0`"
                    ),
                ));
            } else {
                return Err(syn::Error::new(
                    name.span(),
                    "unknown option: write `explain`, a parameter's domain such as `alpha in 1e-4..=1.0`, or a relation such as `where a < b`",
                ));
            }
            if !input.is_empty() {
                input.parse::<Token![,]>()?;
            }
        }
        Ok(options)
    }
}

fn relation(e: Expr) -> syn::Result<Relation> {
    match e {
        Expr::Binary(comparison)
            if matches!(
                comparison.op,
                BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_)
            ) =>
        {
            let text = comparison.to_token_stream().to_string();
            Ok(Relation { comparison, text })
        }
        other => Err(syn::Error::new_spanned(
            other,
            "a relation is one comparison of numbers by `<`, `<=`, `>` or `>=`, so that the compiler knows the sign of a difference: `where a < b`; write another `where` for another",
        )),
    }
}

fn domain(name: Ident, range: &Expr) -> syn::Result<Domain> {
    let Expr::Range(ExprRange { start, end, limits, .. }) = range else {
        return Err(syn::Error::new_spanned(
            range,
            "a domain is a range of numbers, written as in Rust: `0.0..=1.0` with both ends, `0.0..1.0` without the upper one, `0.0..` for all numbers from zero on",
        ));
    };
    let end_of = |e: &Option<Box<Expr>>, open: f64| e.as_ref().map_or(Ok(open), |e| number(e));
    let (lo, hi) = (end_of(start, f64::NEG_INFINITY)?, end_of(end, f64::INFINITY)?);
    if lo.is_nan() || lo >= hi {
        return Err(syn::Error::new_spanned(
            range,
            "this domain is empty: the first end must be below the second",
        ));
    }
    let closed = matches!(limits, RangeLimits::Closed(_));
    let ends = [start, end].into_iter().flatten();
    let whole = (start.is_some() || end.is_some()) && ends.into_iter().all(|e| is_whole(e));
    let mark = if closed { "..=" } else { ".." };
    let show = |x: f64| match x {
        _ if !x.is_finite() => String::new(),
        _ if whole => format!("{x:.0}"),
        _ => format!("{x:?}"),
    };
    let text = format!("{name} in {}{mark}{}", show(lo), show(hi));
    // The last whole number below an end that does not belong to them.
    let hi = if whole && !closed { hi - 1.0 } else { hi };
    Ok(Domain { name, interval: Interval::new(lo, hi), closed: closed || whole, whole, text })
}

/// Whether a number is written without a fraction.
fn is_whole(e: &Expr) -> bool {
    match e {
        Expr::Lit(l) => matches!(l.lit, syn::Lit::Int(_)),
        Expr::Unary(u) => is_whole(&u.expr),
        _ => false,
    }
}

fn number(e: &Expr) -> syn::Result<f64> {
    match e {
        Expr::Lit(l) => match &l.lit {
            syn::Lit::Float(f) => f.base10_parse(),
            syn::Lit::Int(i) => i.base10_parse(),
            other => Err(syn::Error::new_spanned(other, "an end of a domain is a number")),
        },
        Expr::Unary(u) if matches!(u.op, UnOp::Neg(_)) => Ok(-number(&u.expr)?),
        other => Err(syn::Error::new_spanned(
            other,
            "an end of a domain is a literal number, because the compiler of samplers sees names and not their values: write the number here, and a relation, `where alpha < b`, between parameters",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_without_a_fraction_are_those_of_whole_numbers() {
        let domain = |text: &str| {
            let options: Options = syn::parse_str(text).unwrap();
            let [d] = &options.domains[..] else { panic!("one domain") };
            (d.whole, d.interval, d.closed, d.text.clone())
        };
        let to = Interval::new;
        assert_eq!(domain("n in 3..=16"), (true, to(3.0, 16.0), true, "n in 3..=16".into()));
        assert_eq!(domain("n in -2..5"), (true, to(-2.0, 4.0), true, "n in -2..5".into()));
        assert_eq!(domain("n in 1.."), (true, to(1.0, f64::INFINITY), true, "n in 1..".into()));
        assert_eq!(domain("n in 3.0..5.0"), (false, to(3.0, 5.0), false, "n in 3.0..5.0".into()));
    }
}
