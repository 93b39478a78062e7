//! Patterns that tell one value from another: arms of `match`, `if let`, `let … else`, `matches!`.

use syn::{Expr, Pat};

use super::Value;
use super::body::Body;

impl Body<'_> {
    /// `match` over truth values, integers and options, over ranges of numbers, or over anything with guarded arms.
    pub(super) fn choice(&mut self, e: &syn::ExprMatch) -> Option<Value> {
        let value = self.expr(&e.expr)?;
        if self.left() {
            return Some(Value::Unit);
        }
        for arm in &e.arms {
            let result = self.scoped(|body| {
                let fits = body.fits(&arm.pat, &value)?;
                Some(if fits { Some(body.expr(&arm.body)?) } else { None })
            })?;
            if result.is_some() {
                return result;
            }
        }
        self.error(e.match_token, "no arm of this `match` is taken: end it with `_ => …`")
    }

    /// Whether a value has the form of a pattern; its names are bound then.
    pub(super) fn fits(&mut self, pattern: &Pat, value: &Value) -> Option<bool> {
        match (pattern, value) {
            (Pat::Wild(_), _) => Some(true),
            (Pat::Paren(p), _) => self.fits(&p.pat, value),
            (Pat::Reference(p), _) => self.fits(&p.pat, value),
            (Pat::Guard(p), _) => Some(self.fits(&p.pat, value)? && self.truth(&p.guard)?),
            (Pat::Lit(syn::ExprLit { lit: syn::Lit::Bool(l), .. }), Value::Bool(b)) => {
                Some(l.value == *b)
            }
            (Pat::Lit(literal), Value::Integer(_)) => {
                let wanted = self.expr(&Expr::Lit(literal.clone()))?;
                self.equal(value, &wanted)
            }
            (Pat::Range(p), Value::Scalar(_) | Value::Integer(_)) => {
                let ends = (p.start.as_deref(), p.end.as_deref());
                self.lies_between(ends, &p.limits, value)
            }
            (Pat::Or(p), _) => {
                for case in &p.cases {
                    if self.fits(case, value)? {
                        return Some(true);
                    }
                }
                Some(false)
            }
            (Pat::Tuple(p), Value::Tuple(values)) if p.elems.len() == values.len() => {
                self.fits_each(p.elems.iter(), values)
            }
            (Pat::TupleStruct(p), _) if p.path.is_ident("Some") && p.elems.len() == 1 => {
                match value {
                    Value::Nothing => Some(false),
                    _ => self.fits(&p.elems[0], value),
                }
            }
            (Pat::Ident(p), _) if p.ident == "None" => Some(matches!(value, Value::Nothing)),
            (Pat::Ident(p), Value::Integer(_)) if is_constant(&p.ident) => {
                let name = &p.ident;
                let wanted = self.expr(&syn::parse_quote!(#name))?;
                self.equal(value, &wanted)
            }
            (Pat::Ident(p), _) if is_constant(&p.ident) => self.error(
                pattern,
                format!("`{}` looks like a constant, and a number equals that with probability zero: an arm is a range, or a name that is no constant's", p.ident),
            ),
            (Pat::Ident(p), _) if p.by_ref.is_some() => {
                self.error(p, "a name is bound to a value here: leave `ref` away")
            }
            (Pat::Ident(p), _) => {
                if let Some((_, within)) = &p.subpat
                    && !self.fits(within, value)?
                {
                    return Some(false);
                }
                self.declare(&p.ident.to_string(), value.clone());
                Some(true)
            }
            (Pat::Slice(p), _) if value.elements().is_some_and(|v| v.len() == p.elems.len()) => {
                let values = value.elements().unwrap_or_default();
                self.fits_each(p.elems.iter(), &values)
            }
            _ => self.error(pattern, "an arm is `true`, `false`, an integer, a range as in `0.0..0.5`, `Some(x)`, `None`, a tuple of these, or a name with a guard, as in `x if x < 0.5 =>`"),
        }
    }

    fn fits_each<'p>(
        &mut self,
        patterns: impl Iterator<Item = &'p Pat>,
        values: &[Value],
    ) -> Option<bool> {
        let mut all = true;
        for (pattern, value) in patterns.zip(values) {
            all &= self.fits(pattern, value)?;
        }
        Some(all)
    }

    /// Whether a number lies in a range, `low..high` or `low..=high`; either end may be left away.
    fn lies_between(
        &mut self,
        (low, high): (Option<&Expr>, Option<&Expr>),
        limits: &syn::RangeLimits,
        value: &Value,
    ) -> Option<bool> {
        let exceeds = match value {
            Value::Integer(_) => Self::whole_exceeds,
            _ => Self::exceeds,
        };
        let (Value::Scalar(x) | Value::Integer(x)) = *value else { return None };
        if let Some(low) = low {
            let low = self.scalar(low)?;
            if !exceeds(self, x, low, false) {
                return Some(false);
            }
        }
        let Some(high) = high else { return Some(true) };
        let high = self.scalar(high)?;
        Some(exceeds(self, high, x, matches!(limits, syn::RangeLimits::HalfOpen(_))))
    }

    /// `(low..high).contains(&x)`; `None` if it is another method or of something else.
    pub(super) fn contains(&mut self, m: &syn::ExprMethodCall) -> Option<Option<Value>> {
        let mut receiver = &*m.receiver;
        while let Expr::Paren(inner) = receiver {
            receiver = &inner.expr;
        }
        let Expr::Range(range) = receiver else { return None };
        if m.method != "contains" || m.args.len() != 1 {
            return None;
        }
        // The size of a number is a number like any other here, as in a comparison.
        let outer = std::mem::replace(&mut self.comparing, true);
        let x = self.expr(&m.args[0]);
        self.comparing = outer;
        let ends = (range.start.as_deref(), range.end.as_deref());
        Some(match x {
            Some(x @ (Value::Scalar(_) | Value::Integer(_))) => {
                self.lies_between(ends, &range.limits, &x).map(Value::Bool)
            }
            Some(other) => {
                let what = other.describe();
                self.error(m, format!("a range contains numbers, and this is {what}"))
            }
            None => None,
        })
    }

    /// A method of an option, which is what it has, or nothing; `None` if it is no such method.
    pub(super) fn option_method(
        &mut self,
        m: &syn::ExprMethodCall,
        value: &Value,
    ) -> Option<Option<Value>> {
        let nothing = matches!(value, Value::Nothing);
        Some(match (m.method.to_string().as_str(), m.args.first()) {
            ("is_some", None) => Some(Value::Bool(!nothing)),
            ("is_none", None) => Some(Value::Bool(nothing)),
            ("unwrap_or", Some(other)) => {
                if nothing {
                    self.expr(other)
                } else {
                    Some(value.clone())
                }
            }
            ("map" | "and_then", Some(_)) if nothing => Some(Value::Nothing),
            ("map" | "and_then", Some(f)) => match self.expr(f)? {
                Value::Callable(f) => self.apply(m, &f, vec![value.clone()]),
                _ => return None,
            },
            _ => return None,
        })
    }

    /// `value?`: the body ends where there is none.
    pub(super) fn tried(&mut self, e: &syn::ExprTry) -> Option<Value> {
        let value = self.expr(&e.expr)?;
        if let Value::Nothing = value {
            self.leave(Value::Nothing);
            return Some(Value::Unit);
        }
        Some(value)
    }
}

/// Whether a name is written as those of constants are.
fn is_constant(name: &syn::Ident) -> bool {
    let name = name.to_string();
    name.len() > 1 && name.starts_with(|c: char| c.is_uppercase()) && name == name.to_uppercase()
}
