//! Expressions as flat `let` statements with shared subexpressions.

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use crate::eval::evaluate;
use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::number::{Dd, Number};
use crate::rational::Q;

/// Writes expressions over the type `R`, with inputs named by `input`.
pub struct Code<'a> {
    graph: &'a Graph,
    input: &'a dyn Fn(Leaf) -> TokenStream,
    lets: TokenStream,
    names: HashMap<Id, Ident>,
}

impl<'a> Code<'a> {
    /// A writer with no statement yet.
    pub fn new(graph: &'a Graph, input: &'a dyn Fn(Leaf) -> TokenStream) -> Self {
        Code { graph, input, lets: TokenStream::new(), names: HashMap::new() }
    }

    /// The statements written so far.
    pub fn statements(&self) -> TokenStream {
        self.lets.clone()
    }

    /// A name for the value of an expression; its statements are written if they are not yet.
    pub fn value(&mut self, id: Id) -> TokenStream {
        // An explicit stack: expressions may be deep, and the macro runs unoptimised.
        let mut open = vec![(id, false)];
        while let Some((id, ready)) = open.pop() {
            if self.names.contains_key(&id) || self.atom(id).is_some() {
                continue;
            }
            if ready {
                let e = self.expression(id);
                let name = format_ident!("t{}", self.names.len(), span = Span::call_site());
                self.lets.extend(quote!(let #name = #e;));
                self.names.insert(id, name);
                continue;
            }
            open.push((id, true));
            for c in children(self.graph.node(id)) {
                open.push((c, false));
            }
        }
        self.reference(id)
    }

    fn reference(&self, id: Id) -> TokenStream {
        match (self.names.get(&id), self.atom(id)) {
            (Some(name), _) => quote!(#name),
            (None, Some(atom)) => atom,
            (None, None) => unreachable!("children are written before their parents"),
        }
    }

    /// Inputs and numbers need no statement.
    fn atom(&self, id: Id) -> Option<TokenStream> {
        if let Node::Leaf(l) = self.graph.node(id) {
            return Some((self.input)(*l));
        }
        (self.graph.deps(id) == 0)
            .then(|| number(evaluate::<Dd>(self.graph, id, &|_| Dd::from_f64(f64::NAN)).to_f64()))
    }

    fn expression(&self, id: Id) -> TokenStream {
        match self.graph.node(id) {
            Node::Sum(c, terms) => self.sum(*c, terms),
            Node::Product(factors) => self.product(factors),
            Node::Call(f, args) => {
                let a = self.reference(args[0]);
                match f {
                    Fun::Atan2 => {
                        let b = self.reference(args[1]);
                        quote!(#a.atan2(#b))
                    }
                    Fun::Turn => quote!(::aether_core::support::turn(#a)),
                    Fun::SinPi => quote!(::aether_core::support::sin_pi(#a)),
                    Fun::CosPi => quote!(::aether_core::support::cos_pi(#a)),
                    Fun::Sign => quote!(R::ONE.copysign(#a)),
                    _ => match special(*f) {
                        Some(name) => {
                            let name = Ident::new(name, Span::call_site());
                            quote!(::aether_core::special::#name(#a))
                        }
                        None => {
                            let method = Ident::new(method(*f), Span::call_site());
                            quote!(#a.#method())
                        }
                    },
                }
            }
            _ => self.reference(id),
        }
    }

    fn sum(&self, c: Q, terms: &[(Q, Id)]) -> TokenStream {
        let mut ordered: Vec<&(Q, Id)> = terms.iter().collect();
        ordered.sort_by_key(|(q, _)| q.is_negative());
        let mut out: Option<TokenStream> = (!c.is_zero()).then(|| rational(c));
        for (q, t) in ordered {
            let t = self.reference(*t);
            let size = q.abs();
            let term = if size == Q::ONE { t } else { times(size, &t) };
            out = Some(match (out, q.is_negative()) {
                (None, false) => term,
                (None, true) => quote!(-(#term)),
                (Some(o), false) => quote!(#o + #term),
                (Some(o), true) => quote!(#o - #term),
            });
        }
        out.unwrap_or_else(|| quote!(R::ZERO))
    }

    fn product(&self, factors: &[(Id, Id)]) -> TokenStream {
        let mut parts = Parts::default();
        for (b, e) in factors {
            let base = self.reference(*b);
            match self.graph.as_number(*e) {
                Some(q) => parts.push(&base, q),
                None => {
                    let e = self.reference(*e);
                    parts.top.push(quote!(#base.powf(#e)));
                }
            }
        }
        parts.finish()
    }
}

/// Factors above and below the line; square roots are taken together.
#[derive(Default)]
struct Parts {
    top: Vec<TokenStream>,
    bottom: Vec<TokenStream>,
    root_top: Vec<TokenStream>,
    root_bottom: Vec<TokenStream>,
}

impl Parts {
    fn push(&mut self, base: &TokenStream, q: Q) {
        let (whole, rest, root) = if q.is_negative() {
            (&mut self.bottom, q.neg(), &mut self.root_bottom)
        } else {
            (&mut self.top, q, &mut self.root_top)
        };
        match (rest.num(), rest.den()) {
            (n, 1) => whole.push(integer_power(base, n)),
            (1, 2) => root.push(base.clone()),
            (n, 2) => {
                whole.push(integer_power(base, n / 2));
                root.push(base.clone());
            }
            (1, 3) => whole.push(quote!(#base.cbrt())),
            _ => {
                let e = rational(rest);
                whole.push(quote!(#base.powf(#e)));
            }
        }
    }

    fn finish(mut self) -> TokenStream {
        for (roots, whole) in [(self.root_top, &mut self.top), (self.root_bottom, &mut self.bottom)]
        {
            match &roots[..] {
                [] => {}
                [one] => whole.push(quote!(#one.sqrt())),
                many => {
                    let product = joined(many);
                    whole.push(quote!((#product).sqrt()));
                }
            }
        }
        let (top, bottom) = (self.top, self.bottom);
        let above = joined(&top);
        let below = joined(&bottom);
        match bottom.len() {
            0 => above,
            1 => quote!(#above / #below),
            _ => quote!(#above / (#below)),
        }
    }
}

/// The factors with `*` between them.
fn joined(factors: &[TokenStream]) -> TokenStream {
    let mut factors = factors.iter();
    let Some(first) = factors.next() else { return quote!(R::ONE) };
    factors.fold(first.clone(), |product, f| quote!(#product * #f))
}

fn integer_power(base: &TokenStream, n: i128) -> TokenStream {
    match n {
        1 => quote!(#base),
        2 => quote!((#base * #base)),
        3 => quote!((#base * #base * #base)),
        _ => {
            let n = Literal::i32_unsuffixed(i32::try_from(n).unwrap_or(i32::MAX));
            quote!(#base.powi(#n))
        }
    }
}

/// q · t with the fewest roundings.
fn times(q: Q, t: &TokenStream) -> TokenStream {
    if q.num() == 1 && q.den().count_ones() != 1 {
        let d = rational(Q::new(q.den(), 1).unwrap_or(Q::ONE));
        return quote!(#t / #d);
    }
    let k = rational(q);
    quote!(#k * #t)
}

fn rational(q: Q) -> TokenStream {
    number(<f64 as Number>::from_ratio(q.num(), q.den()))
}

fn number(x: f64) -> TokenStream {
    if x == 0.0 {
        return quote!(R::ZERO);
    }
    if x == 1.0 {
        return quote!(R::ONE);
    }
    if !x.is_finite() {
        return quote!(R::of(f64::NAN));
    }
    let l = Literal::f64_unsuffixed(x.abs());
    if x < 0.0 { quote!(R::of(-#l)) } else { quote!(R::of(#l)) }
}

/// The name of a function of `aether_core::special`.
fn special(f: Fun) -> Option<&'static str> {
    Some(match f {
        Fun::Erf => "erf",
        Fun::Erfc => "erfc",
        Fun::ErfInv => "erf_inv",
        Fun::ErfcInv => "erfc_inv",
        Fun::LambertW => "lambert_w",
        Fun::LnGamma => "ln_gamma",
        _ => return None,
    })
}

fn method(f: Fun) -> &'static str {
    match f {
        Fun::Exp => "exp",
        Fun::ExpM1 => "exp_m1",
        Fun::Ln => "ln",
        Fun::Ln1p => "ln_1p",
        Fun::Sin => "sin",
        Fun::Cos => "cos",
        Fun::Tan => "tan",
        Fun::Asin => "asin",
        Fun::Acos => "acos",
        Fun::Atan | Fun::Atan2 => "atan",
        Fun::Sinh => "sinh",
        Fun::Cosh => "cosh",
        Fun::Tanh => "tanh",
        Fun::Asinh => "asinh",
        Fun::Acosh => "acosh",
        Fun::Atanh => "atanh",
        Fun::Cbrt => "cbrt",
        // All others are written by `expression`.
        _ => "abs",
    }
}
