//! Expressions as flat `let` statements with shared subexpressions.

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::paired::pairs;
use super::powers::{Related, ThreeHalves, related, three_halves};
use crate::eval::evaluate;
use crate::expr::{Deps, Fun, Graph, Id, Leaf, Node, OUTS, UNKNOWNS, children, divided};
use crate::number::{Dd, Number};
use crate::overflow::SAFE;
use crate::rational::Q;

/// Writes expressions over the type `R`, with inputs named by `input`.
pub struct Code<'a> {
    graph: &'a Graph,
    input: &'a dyn Fn(Leaf) -> TokenStream,
    lets: TokenStream,
    names: HashMap<Id, Ident>,
    named: usize,
    /// General powers that have been written: base, exponent, name.
    powers: Vec<(Id, Id, TokenStream)>,
    /// Names of roots that are computed again where their squares underflow.
    rescued: HashMap<Id, TokenStream>,
    /// Of the sine and of the cosine of an angle, the other one, if that is asked for too.
    partners: HashMap<Id, Id>,
    /// Whether roots are those of a map, which exist but for rounding.
    lenient: bool,
    /// Products that others are written by which have all their factors.
    shared: &'a [Id],
}

impl<'a> Code<'a> {
    /// A writer with no statement yet.
    pub fn new(graph: &'a Graph, input: &'a dyn Fn(Leaf) -> TokenStream) -> Self {
        Code {
            graph,
            input,
            lets: TokenStream::new(),
            names: HashMap::new(),
            named: 0,
            powers: Vec::new(),
            rescued: HashMap::new(),
            partners: HashMap::new(),
            lenient: false,
            shared: &[],
        }
    }

    /// The same where products that have all factors of one of some others are written by way of that.
    pub fn sharing(
        graph: &'a Graph,
        input: &'a dyn Fn(Leaf) -> TokenStream,
        shared: &'a [Id],
    ) -> Self {
        Code { shared, ..Code::new(graph, input) }
    }

    /// The same for a map, whose roots exist but for rounding.
    pub fn lenient(graph: &'a Graph, input: &'a dyn Fn(Leaf) -> TokenStream) -> Self {
        Code { lenient: true, ..Code::new(graph, input) }
    }

    /// The statements written so far.
    pub fn statements(&self) -> TokenStream {
        self.lets.clone()
    }

    /// The statements written since they were last taken.
    pub(super) fn take_statements(&mut self) -> TokenStream {
        std::mem::take(&mut self.lets)
    }

    /// The expressions.
    pub(super) fn graph(&self) -> &'a Graph {
        self.graph
    }

    /// Adds a statement for a value that is no expression; its name.
    pub(super) fn named(&mut self, value: &TokenStream) -> TokenStream {
        let name = format_ident!("l{}", self.named, span = Span::call_site());
        self.named += 1;
        self.lets.extend(quote!(let #name = #value;));
        quote!(#name)
    }

    /// Names for the values of expressions. A sine and a cosine of one angle among them are written together, since
    /// functions for both at once are faster, and found where no branch is in between; and first, since other numbers
    /// would have to be kept while they are called.
    pub(super) fn values(&mut self, ids: &[Id]) -> Vec<TokenStream> {
        let pairs = pairs(self.graph, ids);
        self.partners.extend(pairs.iter().flat_map(|&[a, b]| [(a, b), (b, a)]));
        for [first, _] in pairs {
            self.value(first);
        }
        ids.iter().map(|&id| self.value(id)).collect()
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
                self.write_powers(id);
                let partner = self.partners.get(&id).filter(|id| !self.names.contains_key(id));
                match partner.copied() {
                    Some(partner) => self.write_pair(id, partner),
                    None => self.write(id, &self.expression(id)),
                }
                continue;
            }
            open.push((id, true));
            match self.graph.node(id) {
                // The sides of a choice are computed only where they are taken.
                Node::If(test, ..) => open.push((*test, false)),
                Node::Root(r) => {
                    open.extend(
                        super::numeric::outside(self.graph, r).into_iter().map(|c| (c, false)),
                    );
                }
                node => {
                    if let Some(power) = three_halves(self.graph, id) {
                        open.extend(power.factors.into_iter().flatten().map(|b| (b, false)));
                        continue;
                    }
                    let multiple = self.multiple(id).map(|(_, factors)| factors.to_vec());
                    match multiple.or_else(|| self.by_shared(id)) {
                        Some(factors) => {
                            open.extend(
                                factors.into_iter().flat_map(|(b, e)| [(b, false), (e, false)]),
                            );
                        }
                        None => open.extend(children(node).into_iter().map(|c| (c, false))),
                    }
                }
            }
        }
        self.reference(id)
    }

    /// Gives an expression a name for its value.
    fn write(&mut self, id: Id, value: &TokenStream) {
        let name = format_ident!("t{}", self.names.len(), span = Span::call_site());
        self.lets.extend(quote!(let #name = #value;));
        self.names.insert(id, name);
    }

    /// Gives two functions of one argument names for their values: of fractions of a turn and of exponents, one function has
    /// both.
    fn write_pair(&mut self, id: Id, partner: Id) {
        let together = match self.graph.node(id) {
            Node::Call(f @ (Fun::SinPi | Fun::Exp), args) => Some((*f, args[0], [id, partner])),
            Node::Call(Fun::CosPi, args) => Some((Fun::SinPi, args[0], [partner, id])),
            Node::Call(Fun::ExpM1, args) => Some((Fun::Exp, args[0], [partner, id])),
            _ => None,
        };
        let Some((first, argument, pair)) = together else {
            self.write(id, &self.expression(id));
            return self.write(partner, &self.expression(partner));
        };
        let argument = self.reference(argument);
        let both = self.named(&match first {
            Fun::Exp => quote!(::aether_core::support::exp_and_m1(#argument)),
            _ => quote!(#argument.sin_cos_pi()),
        });
        for (i, id) in pair.into_iter().enumerate() {
            let i = Literal::usize_unsuffixed(i);
            self.write(id, &quote!(#both.#i));
        }
    }

    /// Writes the general powers among the factors of a product. One that differs from another power of its base by
    /// a factor of that base is that one times or over it, unless it has left the range of numbers.
    fn write_powers(&mut self, id: Id) {
        let factors = match self.graph.node(id) {
            Node::Product(factors) => factors,
            _ => match self.multiple(id) {
                Some((_, factors)) => factors,
                None => return,
            },
        };
        let together = self.graph.powers_together(factors);
        for &(b, e) in factors {
            if together.as_ref().is_some_and(|t| t.contains(&(b, e))) {
                continue;
            }
            let number = self.graph.as_number(e);
            if number.is_some_and(|q| q.abs() == Q::HALF) && !self.rescued.contains_key(&b) {
                self.write_rescued(b);
            }
            if number.is_some() || self.power(b, e).is_some() {
                continue;
            }
            let (base, exponent) = (self.reference(b), self.reference(e));
            let power = quote!(#base.powf(#exponent));
            let known = self.powers.iter().find_map(|(base, f, name)| {
                let related = (*base == b).then(|| related(self.graph, e, *f)).flatten()?;
                Some((related, name.clone()))
            });
            let value = known.map(|(Related { times, whole }, name)| {
                // What underflows as a square is told by it.
                let name = match times.abs() {
                    1 => name,
                    _ => self.named(&quote!(#name * #name)),
                };
                let value = match (times > 0, whole) {
                    (true, 1) => quote!(#name * #base),
                    (true, 0) => name.clone(),
                    (true, _) => quote!(#name / #base),
                    (false, 1) => quote!(#base / #name),
                    (false, _) => quote!(R::ONE / #name),
                };
                quote!(::aether_core::support::by_power(#name, #value, #base, #exponent))
            });
            let name = self.named(&value.unwrap_or(power));
            self.powers.push((b, e, name));
        }
    }

    /// Writes the root of a sum of squares, which has to be looked after, once for all that it divides.
    fn write_rescued(&mut self, b: Id) {
        if self.scaled_squares(b).is_none() {
            if let Some(scaled) = self.large_squares(b) {
                let base = self.reference(b);
                let root = quote!(::aether_core::support::large_root(#base, move |up: R| #scaled));
                let name = self.named(&root);
                self.rescued.insert(b, name);
            }
            return;
        }
        // What is seldom asked for takes numbers, not places in memory where they had to be for it.
        for leaf in bases(self.graph, b) {
            if let Some(value) = self.atom(leaf).filter(|_| !self.names.contains_key(&leaf)) {
                self.write(leaf, &value);
            }
        }
        let base = self.reference(b);
        if let Some(scaled) = self.scaled_squares(b) {
            let root = quote!(::aether_core::support::root(#base, move |up: R| #scaled));
            let name = self.named(&root);
            self.rescued.insert(b, name);
        }
    }

    /// The name of a general power that has been written.
    fn power(&self, b: Id, e: Id) -> Option<TokenStream> {
        let written = self.powers.iter().find(|(base, exponent, _)| (*base, *exponent) == (b, e));
        written.map(|(.., name)| name.clone())
    }

    /// A multiple of a product with a constant that is rounded anyway, such as 2 π u, one number times the rest; or of one
    /// that is all below the line, the number over the rest.
    fn multiple(&self, id: Id) -> Option<(Q, &'a [(Id, Id)])> {
        let Node::Sum(c, terms) = self.graph.node(id) else { return None };
        let [(q, term)] = terms[..] else { return None };
        let Node::Product(factors) = self.graph.node(term) else { return None };
        let written = self.names.contains_key(&term);
        let is_below = |(_, e): &(Id, Id)| self.graph.as_number(*e).is_some_and(Q::is_negative);
        let is_one = self.constant(factors).is_some() || factors.iter().all(is_below);
        (c.is_zero() && !written && is_one).then_some((q, factors))
    }

    /// The numbers among some factors as one, if one of them has to be rounded.
    fn constant(&self, factors: &[(Id, Id)]) -> Option<Dd> {
        let numbers = factors.iter().filter(|factor| self.is_number(factor));
        let mut rounded = false;
        let value = numbers.fold(Dd::from_f64(1.0), |product, (base, exponent)| {
            rounded |= matches!(self.graph.node(*base), Node::Pi | Node::Float(_));
            let base = evaluate::<Dd>(self.graph, *base, &|_| Dd::from_f64(f64::NAN));
            let power = self.graph.as_number(*exponent).map_or(0, |q| q.num());
            (0..power.abs()).fold(product, |p, _| if power < 0 { p / base } else { p * base })
        });
        (rounded && factors.len() > 1 && value.to_f64().is_finite()).then_some(value)
    }

    /// Whether a factor is a number to a small integer power.
    fn is_number(&self, (base, exponent): &(Id, Id)) -> bool {
        let small = |q: Q| q.is_int() && q.num().abs() < 8;
        self.graph.deps(*base) == 0 && self.graph.as_number(*exponent).is_some_and(small)
    }

    /// The factors of a product with one of the shared products in place of its factors, if it has all of them.
    fn by_shared(&self, id: Id) -> Option<Vec<(Id, Id)>> {
        let Node::Product(factors) = self.graph.node(id) else { return None };
        self.shared.iter().filter(|&&shared| shared != id).find_map(|&shared| {
            let Node::Product(parts) = self.graph.node(shared) else { return None };
            let is_one = |e: &Id| self.graph.as_number(*e) == Some(Q::ONE);
            let one = parts.iter().map(|(_, e)| *e).find(is_one)?;
            let rest = factors.iter().filter(|f| !parts.contains(f)).copied();
            let whole = parts.iter().all(|part| factors.contains(part));
            whole.then(|| rest.chain([(shared, one)]).collect())
        })
    }

    /// A product of integer powers, their signs left away.
    pub(super) fn powers(&mut self, powers: &[(Id, Q)]) -> TokenStream {
        let powers: Vec<TokenStream> =
            powers.iter().map(|&(b, q)| integer_power(&self.value(b), q.num().abs())).collect();
        joined(&powers)
    }

    /// The name or the literal of an expression that has been written.
    pub(super) fn reference(&self, id: Id) -> TokenStream {
        self.known(id).unwrap_or_else(|| unreachable!("children are written before their parents"))
    }

    /// The name or the literal of an expression, if it has been written.
    fn known(&self, id: Id) -> Option<TokenStream> {
        self.names.get(&id).map(|name| quote!(#name)).or_else(|| self.atom(id))
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
        if let Some(power) = three_halves(self.graph, id) {
            return self.three_halves(&power);
        }
        match self.graph.node(id) {
            Node::Sum(c, terms) => match self.multiple(id) {
                Some((q, factors)) => self.product(q, factors),
                None => self.sum(*c, terms),
            },
            Node::Product(factors) => match self.by_shared(id) {
                Some(factors) => self.product(Q::ONE, &factors),
                None => self.product(Q::ONE, factors),
            },
            Node::Call(f, args) => {
                let a = self.reference(args[0]);
                match f {
                    Fun::Atan2 => {
                        let b = self.reference(args[1]);
                        quote!(#a.atan2(#b))
                    }
                    Fun::Pow1p => {
                        let e = self.reference(args[1]);
                        // 1 to any power is 1, as for `powf`.
                        let one = quote!(#a.ge(R::ZERO).and(#a.le(R::ZERO)));
                        quote!(R::select(#one, R::ONE, (#e * #a.ln_1p()).exp()))
                    }
                    Fun::LnBeta => {
                        let b = self.reference(args[1]);
                        quote!(::aether_core::special::ln_beta(#a, #b))
                    }
                    Fun::BetaInc | Fun::BetaIncInv => {
                        let inverse = *f == Fun::BetaIncInv;
                        let name = if inverse { quote!(beta_quantile) } else { quote!(beta_tail) };
                        let [b, c, rest] = [1, 2, 3].map(|i| self.reference(args[i]));
                        quote!(::aether_core::special::#name(#b, #c, [#a, #rest]))
                    }
                    Fun::Turn => quote!(::aether_core::support::turn(#a)),
                    Fun::TurnTo => {
                        let middle = self.reference(args[1]);
                        quote!(::aether_core::support::turn_to(#a, #middle))
                    }
                    Fun::SinPi => quote!(#a.sin_pi()),
                    Fun::CosPi => quote!(#a.cos_pi()),
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
            Node::If(test, yes, no) => {
                let test = self.reference(*test);
                let (yes, no) = (self.side(*yes), self.side(*no));
                quote!(::aether_core::support::either(#test.gt(R::ZERO), || #yes, || #no))
            }
            Node::Root(r) => super::numeric::root(self, r),
            _ => self.reference(id),
        }
    }

    fn three_halves(&self, power: &ThreeHalves) -> TokenStream {
        let factor = |factor: &Option<Id>| match factor {
            Some(base) => self.reference(*base),
            None => rational(power.number),
        };
        let v = joined(&power.factors.iter().map(factor).collect::<Vec<_>>());
        match power.below {
            false => quote!({ let v = #v; v * v.sqrt() }),
            true => quote!({ let v = #v; R::ONE / (v * v.sqrt()) }),
        }
    }

    /// A writer of a block that knows the names so far.
    pub(super) fn inner(&self) -> Code<'a> {
        let names = self.names.clone();
        let (graph, input, named, lenient) = (self.graph, self.input, self.named, self.lenient);
        let (powers, rescued) = (self.powers.clone(), self.rescued.clone());
        let (lets, partners) = (TokenStream::new(), HashMap::new());
        let shared = self.shared;
        Code { graph, input, lets, names, named, powers, rescued, partners, lenient, shared }
    }

    /// One side of a choice, as a block that knows the names so far.
    fn side(&self, id: Id) -> TokenStream {
        let mut side = self.inner();
        let value = side.value(id);
        let lets = side.lets;
        quote!({ #lets #value })
    }

    fn sum(&self, c: Q, terms: &[(Q, Id)]) -> TokenStream {
        // One factor of many terms is a factor of their sum.
        let size = terms.first().map_or(Q::ONE, |(q, _)| q.abs());
        let alike = c.is_zero() && terms.len() > 1 && terms.iter().all(|(q, _)| q.abs() == size);
        if alike && size != Q::ONE {
            // A sum of negative terms is a negative sum.
            let negative = terms.iter().all(|(q, _)| q.is_negative());
            let sign = |q: Q| if q.is_negative() == negative { Q::ONE } else { Q::int(-1) };
            let signs: Vec<(Q, Id)> = terms.iter().map(|&(q, t)| (sign(q), t)).collect();
            let sum = self.sum(c, &signs);
            let sum = times(size, &quote!((#sum)));
            return if negative { quote!(-(#sum)) } else { sum };
        }
        // In the order in which forms were measured: (1 - u) + u p is not (1 + u p) - u.
        let mut out: Option<TokenStream> = None;
        let mut add = |negative: bool, term: TokenStream| {
            out = Some(match (out.take(), negative) {
                (None, false) => term,
                (None, true) => quote!(-(#term)),
                (Some(o), false) => quote!(#o + #term),
                (Some(o), true) => quote!(#o - #term),
            });
        };
        let written = |(q, t): (Q, Id)| {
            let t = self.reference(t);
            let size = q.abs();
            (q.is_negative(), if size == Q::ONE { t } else { times(size, &t) })
        };
        let first = self.graph.anchored(c, terms);
        let anchored = first.into_iter().flat_map(|(j, k)| [j, k]);
        let anchored: Vec<usize> = anchored.collect();
        for &i in &anchored {
            let (negative, term) = written(terms[i]);
            add(negative, term);
        }
        if !c.is_zero() {
            add(c.is_negative(), rational(c.abs()));
        }
        for (_, term) in terms.iter().enumerate().filter(|(i, _)| !anchored.contains(i)) {
            let (negative, term) = written(*term);
            add(negative, term);
        }
        out.unwrap_or_else(|| quote!(R::ZERO))
    }

    /// A product times `q`, which is one unless a number among the factors has to be rounded.
    fn product(&self, q: Q, all: &[(Id, Id)]) -> TokenStream {
        let mut parts = Parts::default();
        let constant = self.constant(all);
        let together = self.graph.powers_together(all);
        let is_folded = |factor: &&(Id, Id)| {
            let taken = together.as_ref().is_some_and(|t| t.contains(factor));
            taken || constant.is_some() && self.is_number(factor)
        };
        let factors: Vec<(Id, Id)> = all.iter().filter(|f| !is_folded(f)).copied().collect();
        let factors = &factors[..];
        if let Some(constant) = constant {
            let scale = <Dd as Number>::from_ratio(q.num(), q.den());
            parts.top.push(number((constant * scale).to_f64()));
        } else if q != Q::ONE {
            parts.top.push(number(q.to_f64()));
        }
        let half = |e: &Id| self.graph.as_number(*e).is_some_and(|q| q.den() == 2);
        // One that is known need not be taken together with others.
        let is_known = |b: &Id| self.rescued.contains_key(b);
        let roots = factors.iter().filter(|(b, e)| half(e) && !is_known(b)).count();
        let side = self.side_of_roots(factors);
        parts.apart = [false, true].into_iter().any(|below| self.overflows(factors, below));
        let shared = self.graph.shared_powers(factors);
        for &power in &shared {
            let times = |q| divided(q, &shared).filter(|by| by.power == power).map(|by| by.times);
            parts.push_whole(self.power_of_quotient(factors, times, power), power.is_negative());
        }
        let rest = |q: Q| divided(q, &shared).map(|by| by.rest);
        let sum = self.sum_over_sum(factors);
        let length = self.length_below(factors);
        for (b, e) in factors {
            if sum == Some(*b) {
                parts.first = Some(self.reference(*b));
                continue;
            }
            let mut base = self.reference(*b);
            let mut exponent = self.graph.as_number(*e);
            if length == Some(*b) {
                parts.soon = Some(base.clone());
                exponent = exponent.and_then(|e| e.add(Q::HALF));
            }
            if self.lenient && exponent == Some(Q::HALF) && !self.graph.range(*b).nonnegative() {
                let scale = self.scale(*b);
                base = quote!(::aether_core::support::not_negative(#base, || #scale));
            }
            match exponent {
                Some(q) if rest(q).is_some() => rest(q).iter().for_each(|q| parts.push(&base, *q)),
                Some(q) if q.abs() == Q::HALF && (roots == 1 || is_known(b)) => {
                    let root = self.root(*b, &base);
                    parts.push_whole(root, q.is_negative());
                }
                Some(q) => {
                    let is_number = half(e) && self.graph.deps(*b) == 0;
                    let side = side.filter(|_| is_number).unwrap_or(Q::ZERO);
                    match q.add(side.neg()) {
                        Some(rest) => [side, rest].iter().for_each(|q| parts.push(&base, *q)),
                        None => parts.push(&base, q),
                    }
                }
                None => match self.power(*b, *e) {
                    Some(power) => parts.top.push(power),
                    None => {
                        let e = self.reference(*e);
                        parts.top.push(quote!(#base.powf(#e)));
                    }
                },
            }
        }
        if let Some(together) = together {
            let mut inside = Parts::default();
            together.inside.iter().for_each(|&(b, q)| self.push_power(&mut inside, b, q));
            let (inside, e) = (inside.finish(), self.reference(together.exponent));
            parts.top.push(quote!((#inside).powf(#e)));
            together.outside.iter().for_each(|&(b, q)| self.push_power(&mut parts, b, q));
        }
        parts.finish()
    }

    /// How large the terms of a sum are together: what its rounding is relative to; of a product, that of its factors.
    fn scale(&self, id: Id) -> TokenStream {
        match self.graph.node(id) {
            Node::Sum(c, terms) => match terms[..] {
                [(q, term)] if c.is_zero() => multiple_of(q.abs(), self.scale(term)),
                _ => {
                    let constant = (!c.is_zero()).then(|| rational(c.abs()));
                    let written = |&(q, t): &(Q, Id)| {
                        let t = self.reference(t);
                        multiple_of(q.abs(), quote!(#t.abs()))
                    };
                    let sizes = constant.into_iter().chain(terms.iter().map(written));
                    quote!((#(#sizes)+*))
                }
            },
            Node::Product(factors) => {
                let mut parts = Parts::default();
                for &(b, e) in factors {
                    match self.graph.as_number(e) {
                        Some(q) if !q.is_negative() => parts.push(&self.scale(b), q),
                        Some(q) => {
                            let b = self.reference(b);
                            parts.push(&quote!(#b.abs()), q);
                        }
                        None => {
                            let power = self.power(b, e);
                            parts.top.extend(power.map(|power| quote!(#power.abs())));
                        }
                    }
                }
                let product = parts.finish();
                quote!((#product))
            }
            _ => {
                let value = self.reference(id);
                quote!(#value.abs())
            }
        }
    }

    /// Whether the product of the factors on one side that have a root is larger than any number of single precision where the
    /// parameter that all large ones have is as large as it is declared to be.
    fn overflows(&self, factors: &[(Id, Id)], below: bool) -> bool {
        let has_root = |e: Id| {
            self.graph.as_number(e).is_some_and(|q| q.den() == 2 && q.is_negative() == below)
        };
        let under = factors.iter().filter(|(_, e)| has_root(*e)).map(|(b, _)| *b);
        let bounded = under.filter(|b| self.graph.range(*b).hi.is_finite());
        let (largest, shared) = bounded.fold((1.0, Deps::MAX), |(largest, shared), b| {
            let hi = self.graph.range(b).hi;
            (largest * hi, if hi > LARGE { shared & self.graph.deps(b) } else { shared })
        });
        largest > f64::from(f32::MAX) && shared & !(UNKNOWNS | OUTS) != 0
    }

    /// The root, above or below the line, that all factors have which are no numbers and have one: with numbers on the
    /// same side there is one root, and the same where else the product occurs, instead of a quotient of two.
    fn side_of_roots(&self, factors: &[(Id, Id)]) -> Option<Q> {
        let exponents = factors.iter().filter(|(b, _)| self.graph.deps(*b) != 0);
        let mut halves = exponents
            .filter_map(|(_, e)| self.graph.as_number(*e).filter(|q| q.den() == 2))
            .map(|q| q.is_negative());
        let first = halves.next()?;
        let side = if first { Q::HALF.neg() } else { Q::HALF };
        halves.all(|below| below == first).then_some(side)
    }

    /// One more power, a root by itself.
    fn push_power(&self, parts: &mut Parts, b: Id, q: Q) {
        let base = self.reference(b);
        match q.abs() == Q::HALF {
            true => parts.push_whole(self.root(b, &base), q.is_negative()),
            false => parts.push(&base, q),
        }
    }

    /// A sum above the line, if there is another below it, and the uniforms among the factors would make it
    /// underflow: sums are divided first.
    fn sum_over_sum(&self, factors: &[(Id, Id)]) -> Option<Id> {
        let exponent = |e: Id| self.graph.as_number(e);
        let is_sum = |b: Id| matches!(self.graph.node(b), Node::Sum(_, t) if t.len() > 1);
        let uniform = |b: Id| matches!(self.graph.node(b), Node::Leaf(Leaf::Unknown(_)));
        let below = factors.iter().any(|&(b, e)| is_sum(b) && exponent(e) == Some(Q::int(-1)));
        let small = factors.iter().any(|&(b, e)| uniform(b) && exponent(e) == Some(Q::ONE));
        let above = factors.iter().find(|&&(b, e)| is_sum(b) && exponent(e) == Some(Q::ONE));
        above.filter(|_| below && small).map(|(b, _)| *b)
    }

    /// A squared length of which another power than its root stands below the line too, and something above that grows with
    /// it: that is divided by the length first, as the third power may leave the range of numbers where the quotient does not.
    fn length_below(&self, factors: &[(Id, Id)]) -> Option<Id> {
        let exponent = |e: Id| self.graph.as_number(e);
        let is_long = |e: Id| exponent(e).is_some_and(|e| e.den() == 2 && e.num() < -1);
        let mut long =
            factors.iter().filter(|&&(b, e)| is_long(e) && self.scaled_squares(b).is_some());
        let &(length, _) = long.next()?;
        let deps = self.graph.deps(length);
        let grows = |&(b, e): &(Id, Id)| {
            exponent(e) == Some(Q::ONE) && self.graph.deps(b) & deps & OUTS != 0
        };
        (long.next().is_none() && factors.iter().any(grows)).then_some(length)
    }

    /// The factors that have a power so many `times` in them, above and below the line, as that of the quotient: it stays
    /// in range where the powers do not. It is what stands below the line, if the power is negative.
    fn power_of_quotient(
        &self,
        factors: &[(Id, Id)],
        times: impl Fn(Q) -> Option<Q>,
        power: Q,
    ) -> TokenStream {
        let mut quotient = Parts::default();
        for (b, e) in factors {
            if let Some(times) = self.graph.as_number(*e).and_then(&times) {
                let all = integer_power(&self.reference(*b), times.num().abs());
                quotient.push_whole(all, times.is_negative());
            }
        }
        let quotient = quotient.finish();
        let power_of = integer_power(&quote!(q), power.num().abs());
        quote!({ let q = #quotient; #power_of })
    }

    /// √base; a sum of squares small enough to underflow is computed again on another scale.
    fn root(&self, b: Id, base: &TokenStream) -> TokenStream {
        self.rescued.get(&b).cloned().unwrap_or_else(|| quote!(#base.sqrt()))
    }

    /// A number and squares, some of which overflow where exponentials of parameters do not, each square times `up`.
    fn large_squares(&self, b: Id) -> Option<TokenStream> {
        let Node::Sum(c, terms) = self.graph.node(b) else { return None };
        if c.is_zero() || c.is_negative() || !terms.iter().any(|(_, t)| self.may_overflow(*t)) {
            return None;
        }
        let scaled = terms.iter().map(|(q, t)| {
            let Node::Product(factors) = self.graph.node(*t) else { return None };
            let is_square = |(_, e): &(Id, Id)| self.graph.as_number(*e) == Some(Q::int(2));
            if q.is_negative() || !factors.iter().all(is_square) {
                return None;
            }
            let bases: Vec<_> =
                factors.iter().map(|(b, _)| self.known(*b)).collect::<Option<_>>()?;
            let (base, k) = (joined(&bases), rational(*q));
            Some(quote!({ let q = #base * up; q * q * #k }))
        });
        let scaled: Vec<TokenStream> = scaled.collect::<Option<_>>()?;
        let c = rational(*c);
        Some(quote!(up * up * #c + #(#scaled)+*))
    }

    /// Whether the square of an exponential of parameters is a factor that overflows in single precision.
    fn may_overflow(&self, term: Id) -> bool {
        let Node::Product(factors) = self.graph.node(term) else { return false };
        factors.iter().any(|(b, _)| match self.graph.node(*b) {
            Node::Call(Fun::Cosh | Fun::Sinh | Fun::Exp | Fun::ExpM1, args) => {
                let range = self.graph.range(args[0]);
                range.hi.max(-range.lo) > 0.5 * SAFE && self.graph.deps(*b) & (UNKNOWNS | OUTS) == 0
            }
            _ => false,
        })
    }

    /// A sum of squares (with factors that are not negative), each square times `up`.
    fn scaled_squares(&self, b: Id) -> Option<TokenStream> {
        let Node::Sum(c, terms) = self.graph.node(b) else { return None };
        if !c.is_zero() || terms.len() < 2 {
            return None;
        }
        let scaled = terms.iter().map(|(q, t)| {
            let Node::Product(factors) = self.graph.node(*t) else { return None };
            let two = |e: &Id| self.graph.as_number(*e) == Some(Q::int(2));
            let square = factors.iter().position(|(_, e)| two(e))?;
            let others = factors.iter().enumerate().filter(|(i, _)| *i != square);
            let mut product = Parts::default();
            for (_, (b, e)) in others {
                if !self.graph.range(*b).nonnegative() && !two(e) {
                    return None;
                }
                product.push(&self.known(*b)?, self.graph.as_number(*e)?);
            }
            let others = product.finish();
            let base = self.known(factors[square].0)?;
            let k = rational(*q);
            (!q.is_negative()).then(|| quote!((#base * up) * (#base * up) * #others * #k))
        });
        let scaled: Vec<TokenStream> = scaled.collect::<Option<_>>()?;
        Some(quote!(#(#scaled)+*))
    }
}

/// What is larger has its part in a product's being too large.
const LARGE: f64 = 1e6;

/// The inputs among the bases of a sum of products.
fn bases(g: &Graph, id: Id) -> Vec<Id> {
    let Node::Sum(_, terms) = g.node(id) else { return Vec::new() };
    let factors = terms.iter().flat_map(|(_, term)| match g.node(*term) {
        Node::Product(factors) => factors.as_slice(),
        _ => &[],
    });
    let bases = factors.map(|(base, _)| *base);
    bases.filter(|base| matches!(g.node(*base), Node::Leaf(_))).collect()
}

/// Factors above and below the line; square roots are taken together.
#[derive(Default)]
struct Parts {
    /// What is divided before anything is multiplied with it.
    first: Option<TokenStream>,
    /// A root that divides what stands above before anything else does.
    soon: Option<TokenStream>,
    top: Vec<TokenStream>,
    bottom: Vec<TokenStream>,
    root_top: Vec<TokenStream>,
    root_bottom: Vec<TokenStream>,
    /// Whether what has a root is too large in single precision to be multiplied before the root is taken.
    apart: bool,
}

impl Parts {
    fn push_whole(&mut self, factor: TokenStream, below: bool) {
        if below { self.bottom.push(factor) } else { self.top.push(factor) }
    }

    fn push(&mut self, base: &TokenStream, q: Q) {
        let (whole, rest, root) = if q.is_negative() {
            (&mut self.bottom, q.neg(), &mut self.root_bottom)
        } else {
            (&mut self.top, q, &mut self.root_top)
        };
        match (rest.num(), rest.den()) {
            (0, _) => {}
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
                many if self.apart => whole.extend(many.iter().map(|one| quote!(#one.sqrt()))),
                many => {
                    let product = joined(many);
                    whole.push(quote!((#product).sqrt()));
                }
            }
        }
        let (top, bottom) = (self.top, self.bottom);
        let above = joined(&top);
        let below = joined(&bottom);
        let above = match self.soon {
            Some(root) => quote!(#above / #root.sqrt()),
            None => above,
        };
        match (self.first, bottom.len()) {
            (Some(first), 1) => quote!(#above * (#first / #below)),
            (Some(first), _) => quote!(#above * (#first / (#below))),
            (None, 0) => above,
            (None, 1) => quote!(#above / #below),
            (None, _) => quote!(#above / (#below)),
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

/// q · t as a factor or a term: in parentheses, unless it is t.
pub(super) fn multiple_of(q: Q, t: TokenStream) -> TokenStream {
    if q == Q::ONE {
        return t;
    }
    let multiple = times(q, &t);
    quote!((#multiple))
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

pub(super) fn rational(q: Q) -> TokenStream {
    number(<f64 as Number>::from_ratio(q.num(), q.den()))
}

pub(super) fn number(x: f64) -> TokenStream {
    if x == 0.0 {
        return quote!(R::ZERO);
    }
    if x == 1.0 {
        return quote!(R::ONE);
    }
    if x.is_nan() {
        return quote!(R::of(f64::NAN));
    }
    if x.is_infinite() {
        return if x > 0.0 { quote!(R::INFINITY) } else { quote!(-R::INFINITY) };
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
        Fun::LnErfc => "ln_erfc",
        Fun::ErfcInvExp => "erfc_inv_exp",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn higher_powers_are_divided_before_they_are_raised() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let powers = [(a, 2), (b, -2), (c, 6)].map(|(base, e)| g.powi(base, e));
        let product = powers.into_iter().reduce(|product, power| g.mul(product, power)).unwrap();
        let leaf = |leaf: Leaf| format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap();
        let mut code = Code::new(&g, &leaf);
        let value = code.value(product);
        let text = format!("{} {value}", code.statements()).replace(' ', "");
        assert!(
            text.contains("letq=Param_0_*(Param_2_*Param_2_*Param_2_)/Param_1_;(q*q)"),
            "{text}"
        );
    }

    #[test]
    fn exponents_belong_to_one_power() {
        let powers = [2, 4, 3].map(Q::int);
        let by = |exponent| {
            let by = divided(exponent, &powers)?;
            Some((by.power.num(), by.times.num(), by.rest.num()))
        };
        assert_eq!(by(Q::int(7)), Some((2, 3, 1)));
        assert_eq!(by(Q::int(-4)), Some((4, -1, 0)));
        assert_eq!(by(Q::int(6)), Some((2, 3, 0)));
        assert_eq!(by(Q::int(9)), Some((3, 3, 0)));
        assert_eq!(by(Q::int(-1)), None);
        assert_eq!(by(Q::HALF), None);
    }
}
