//! Expressions as flat `let` statements with shared subexpressions.

mod calls;
mod literal;
mod parts;
mod products;
mod roots;
mod sums;

use std::collections::HashMap;

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use super::paired::{calls_in_order, has_angle, pairs};
use super::powers::three_halves;
use crate::eval::evaluate;
use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::number::{Dd, Number};
use crate::rational::Q;
pub(super) use literal::{integer_power, multiple_of, number, rational};

/// Writes expressions over the type `R`, with inputs named by `input`.
pub struct Code<'a> {
    graph: &'a Graph,
    input: &'a dyn Fn(Leaf) -> TokenStream,
    lets: TokenStream,
    names: HashMap<Id, Ident>,
    named: usize,
    /// General powers that have been written: base, exponent, name.
    powers: Vec<(Id, Id, TokenStream)>,
    /// Factors that products begin with which have been written.
    begun: Vec<[Id; 2]>,
    /// Names of roots that are computed again where their squares underflow.
    rescued: HashMap<Id, TokenStream>,
    /// Of the sine and of the cosine of an angle, the other one, if that is asked for too.
    partners: HashMap<Id, Id>,
    /// Whether roots are those of a map, which exist but for rounding.
    lenient: bool,
    /// Products that others are written by which have all their factors.
    shared: &'a [Id],
    /// What there are roots of in something that is no number if they are infinite, and looked at.
    looked_at: Vec<Id>,
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
            begun: Vec::new(),
            rescued: HashMap::new(),
            partners: HashMap::new(),
            lenient: false,
            shared: &[],
            looked_at: Vec::new(),
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
    /// functions for both at once are faster, and found where no branch is in between; exponentials first, since others are
    /// told by them. Sines and cosines come after all that is called, for they are computed in place, and of many numbers,
    /// which would have to be kept over calls; and before what would have to be kept meanwhile.
    pub(super) fn values(&mut self, ids: &[Id]) -> Vec<TokenStream> {
        let pairs = pairs(self.graph, ids);
        self.partners.extend(pairs.iter().flat_map(|&[a, b]| [(a, b), (b, a)]));
        let is_angle =
            |[first, _]: &[Id; 2]| !matches!(self.graph.node(*first), Node::Call(Fun::Exp, _));
        let (angles, exponentials): (Vec<_>, Vec<_>) = pairs.into_iter().partition(is_angle);
        for [first, _] in exponentials {
            self.value(first);
        }
        if !angles.is_empty() {
            let graph = self.graph;
            for called in calls_in_order(graph, ids) {
                if has_angle(graph, called) {
                    self.write_powers_first(called, |id| !has_angle(graph, id));
                } else {
                    self.value(called);
                }
            }
        }
        for [first, _] in angles {
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
                Node::If(test, ..) => {
                    open.push((finite_divisor(self.graph, *test).unwrap_or(*test), false));
                }
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
        self.note_beginnings(id);
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
            Node::Call(f, args) => self.call(*f, args),
            Node::If(test, yes, no) => {
                let (yes, no) = (self.side(*yes), self.side(*no));
                let test = match finite_divisor(self.graph, *test).map(|id| self.reference(id)) {
                    Some(divisor) => quote!(#divisor.lt(R::INFINITY)),
                    None => {
                        let test = self.reference(*test);
                        quote!(#test.gt(R::ZERO))
                    }
                };
                quote!(::aether_core::support::either(#test, || #yes, || #no))
            }
            Node::Root(r) => super::numeric::root(self, r),
            _ => self.reference(id),
        }
    }

    /// A writer of a block that knows the names so far.
    pub(super) fn inner(&self) -> Code<'a> {
        let names = self.names.clone();
        let (graph, input, named, lenient) = (self.graph, self.input, self.named, self.lenient);
        let (powers, rescued) = (self.powers.clone(), self.rescued.clone());
        let begun = self.begun.clone();
        let (shared, looked_at) = (self.shared, self.looked_at.clone());
        let texts = Code::new(graph, input);
        Code { names, named, powers, begun, rescued, lenient, shared, looked_at, ..texts }
    }

    /// One side of a choice, as a block that knows the names so far.
    fn side(&self, id: Id) -> TokenStream {
        let mut side = self.inner();
        let value = side.value(id);
        let lets = side.lets;
        quote!({ #lets #value })
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
}

/// What one is divided by in a test whether the quotient is positive, if it is not negative: it has to be finite.
fn finite_divisor(g: &Graph, test: Id) -> Option<Id> {
    let Node::Product(factors) = g.node(test) else { return None };
    let [(base, exponent)] = factors[..] else { return None };
    let divides = g.as_number(exponent) == Some(Q::int(-1));
    (divides && g.range(base).nonnegative()).then_some(base)
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
    fn a_sum_of_negative_terms_turns_its_sign_once() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let both = g.sum(Q::ZERO, &[(Q::int(-1), a), (Q::int(-1), b)]);
        let leaf = |leaf: Leaf| format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap();
        let mut code = Code::new(&g, &leaf);
        let value = code.value(both);
        let text = format!("{} {value}", code.statements()).replace(' ', "");
        assert!(text.contains("-(Param_0_+Param_1_)"), "{text}");
    }

    #[test]
    fn a_square_is_multiplied_by_way_of_a_product_that_has_begun() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let square = g.powi(a, 2);
        let volume = g.mul(square, b);
        let inverse = g.powi(volume, -1);
        let [edge, other] = [b, c].map(|with| g.mul(a, with));
        let leaf = |leaf: Leaf| format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap();
        let text = |ids: &[Id]| {
            let mut code = Code::new(&g, &leaf);
            code.values(ids);
            code.statements().to_string().replace(' ', "")
        };
        let [by_square, by_edge] =
            ["(Param_0_*Param_0_)*Param_1_", "(Param_0_*(Param_0_*Param_1_))"];
        for id in [volume, inverse] {
            let [begun, apart] = [text(&[edge, id]), text(&[other, id])];
            assert!(begun.contains(by_edge) && !begun.contains(by_square), "{begun}");
            assert!(apart.contains(by_square) && !apart.contains(by_edge), "{apart}");
        }
    }

    #[test]
    fn growth_is_told_by_decay_and_finite_numbers_by_themselves() {
        let mut g = Graph::new();
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(0.5, f64::INFINITY));
        let minus = g.neg(k);
        let decay = [Fun::Exp, Fun::ExpM1].map(|f| g.call(f, &[minus]));
        let growth = g.call(Fun::ExpM1, &[k]);
        let inverse = g.powi(growth, -1);
        let choice = g.if_positive(inverse, decay[0], decay[1]);
        let leaf = |_: Leaf| quote!(k);
        let mut code = Code::new(&g, &leaf);
        code.values(&[decay[0], decay[1], growth, choice]);
        let text = code.statements().to_string().replace(' ', "");
        assert!(
            text.contains("exp_and_m1(") && text.contains("either(t3.lt(R::INFINITY)"),
            "{text}"
        );
        assert_eq!(text.matches("exp").count(), 1, "{text}");
    }
}
