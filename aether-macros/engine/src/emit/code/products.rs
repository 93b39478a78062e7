//! Products as text: what is taken together, and in which order it is multiplied and divided.

use proc_macro2::TokenStream;
use quote::quote;

use super::Code;
use super::literal::{integer_power, joined, number, rational};
use super::parts::Parts;
use crate::emit::powers::{Related, ThreeHalves, related};
use crate::eval::evaluate;
use crate::expr::{Id, Leaf, Node, OUTS, divided};
use crate::number::{Dd, Number};
use crate::rational::Q;

/// How the factors of a product are written.
struct Order {
    /// Powers that are taken of a quotient of several factors.
    shared: Vec<Q>,
    /// What is divided first.
    sum: Option<Id>,
    /// A squared length whose root divides what stands above before anything else does.
    length: Option<Id>,
    /// Whether there is but one root.
    has_one_root: bool,
    /// The root that all factors have which are no numbers.
    side: Option<Q>,
    /// A square and what it is multiplied with by way of a product that is there.
    begun: Option<[(Id, Id); 2]>,
}

impl<'a> Code<'a> {
    /// A product times `q`, which is one unless a number among the factors has to be rounded.
    pub(super) fn product(&self, q: Q, all: &[(Id, Id)]) -> TokenStream {
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
        let order = self.order(factors);
        parts.apart = [false, true].into_iter().any(|below| self.overflows(factors, below));
        for &power in &order.shared {
            let times =
                |q| divided(q, &order.shared).filter(|by| by.power == power).map(|by| by.times);
            parts.push_whole(self.power_of_quotient(factors, times, power), power.is_negative());
        }
        for factor in factors {
            match order.begun {
                Some([square, with]) if *factor == square => {
                    let [b, c] = [square, with].map(|(base, _)| self.reference(base));
                    let below = self.graph.as_number(with.1).is_some_and(Q::is_negative);
                    parts.push_whole(quote!((#b * (#b * #c))), below);
                }
                Some([_, with]) if *factor == with => {}
                _ => self.push_factor(&mut parts, factor, &order),
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

    /// What is to be known of all factors of a product to write each of them.
    fn order(&self, factors: &[(Id, Id)]) -> Order {
        // One that is known need not be taken together with others.
        let is_root = |(b, e): &&(Id, Id)| self.is_half(*e) && !self.rescued.contains_key(b);
        let (shared, sum) = (self.graph.shared_powers(factors), self.sum_over_sum(factors));
        Order {
            // What is taken together or first stays so.
            begun: if shared.is_empty() && sum.is_none() {
                self.square_begun(factors)
            } else {
                None
            },
            shared,
            sum,
            length: self.length_below(factors),
            has_one_root: factors.iter().filter(is_root).count() == 1,
            side: self.side_of_roots(factors),
        }
    }

    /// Notes which two factors a product begins with, above the line and below it, whose product the compiler of Rust has for all
    /// that begins alike.
    pub(super) fn note_beginnings(&mut self, id: Id) {
        let Node::Product(factors) = self.graph.node(id) else { return };
        for exponent in [Q::ONE, Q::int(-1)] {
            let is_plain = |(b, e): &&(Id, Id)| {
                self.graph.as_number(*e) == Some(exponent) && self.graph.deps(*b) != 0
            };
            let mut plain = factors.iter().filter(is_plain).map(|(b, _)| *b);
            if let (Some(first), Some(second)) = (plain.next(), plain.next()) {
                self.begun.push([first, second]);
            }
        }
    }

    /// A square b² and a factor c of the same side where a product has begun with b c, so that b (b c) takes one multiplication
    /// less than b² c. As b c lies between c and b² c, it leaves the range of numbers only where one of these does, unlike b².
    fn square_begun(&self, factors: &[(Id, Id)]) -> Option<[(Id, Id); 2]> {
        let exponent = |e: Id| self.graph.as_number(e);
        let squares =
            factors.iter().filter(|(_, e)| exponent(*e).is_some_and(|q| q.abs() == Q::int(2)));
        squares.copied().find_map(|square| {
            let is_other = |(c, e): &&(Id, Id)| {
                let alike = |q: Q| q.abs() == Q::ONE && exponent(square.1) == q.add(q);
                let begins =
                    self.begun.contains(&[square.0, *c]) || self.begun.contains(&[*c, square.0]);
                exponent(*e).is_some_and(alike) && begins
            };
            factors.iter().find(is_other).map(|other| [square, *other])
        })
    }

    /// Whether an exponent is a half, and whole numbers.
    fn is_half(&self, exponent: Id) -> bool {
        self.graph.as_number(exponent).is_some_and(|q| q.den() == 2)
    }

    /// One factor of a product, but for the powers that are shared with others.
    fn push_factor(&self, parts: &mut Parts, &(b, e): &(Id, Id), order: &Order) {
        let mut base = self.reference(b);
        if order.sum == Some(b) {
            parts.first = Some(base);
            return;
        }
        let mut exponent = self.graph.as_number(e);
        if order.length == Some(b) {
            parts.soon = Some(base.clone());
            exponent = exponent.and_then(|e| e.add(Q::HALF));
        }
        if self.lenient && exponent == Some(Q::HALF) && !self.graph.range(b).nonnegative() {
            let scale = self.scale(b);
            base = quote!(::aether_core::support::not_negative(#base, || #scale));
        }
        let Some(q) = exponent else {
            let power = self.power(b, e).unwrap_or_else(|| {
                let e = self.reference(e);
                quote!(#base.powf(#e))
            });
            return parts.top.push(power);
        };
        if let Some(by) = divided(q, &order.shared) {
            return parts.push(&base, by.rest);
        }
        if q.abs() == Q::HALF && (order.has_one_root || self.rescued.contains_key(&b)) {
            return parts.push_whole(self.root(b, &base), q.is_negative());
        }
        let is_number = self.is_half(e) && self.graph.deps(b) == 0;
        let side = order.side.filter(|_| is_number).unwrap_or(Q::ZERO);
        match q.add(side.neg()) {
            Some(rest) => [side, rest].iter().for_each(|q| parts.push(&base, *q)),
            None => parts.push(&base, q),
        }
    }

    /// A multiple of a product with a constant that is rounded anyway, such as 2 π u, one number times the rest; or of one
    /// that is all below the line, the number over the rest.
    pub(super) fn multiple(&self, id: Id) -> Option<(Q, &'a [(Id, Id)])> {
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

    /// A product of integer powers, their signs left away.
    pub(in crate::emit) fn powers(&mut self, powers: &[(Id, Q)]) -> TokenStream {
        let powers: Vec<TokenStream> =
            powers.iter().map(|&(b, q)| integer_power(&self.value(b), q.num().abs())).collect();
        joined(&powers)
    }

    /// The name of a general power that has been written.
    pub(super) fn power(&self, b: Id, e: Id) -> Option<TokenStream> {
        let written = self.powers.iter().find(|(base, exponent, _)| (*base, *exponent) == (b, e));
        written.map(|(.., name)| name.clone())
    }

    /// Writes the general powers among the factors of a product. One that differs from another power of its base by
    /// a factor of that base is that one times or over it, unless it has left the range of numbers.
    pub(super) fn write_powers(&mut self, id: Id) {
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
            self.write_power(b, e);
        }
    }

    /// Writes the general powers among the factors of a product before the others, those of some bases and exponents.
    pub(super) fn write_powers_first(&mut self, id: Id, of: impl Fn(Id) -> bool) {
        let Node::Product(factors) = self.graph.node(id) else { return };
        let together = self.graph.powers_together(factors);
        for &(b, e) in factors {
            let is_written = together.as_ref().is_some_and(|t| t.contains(&(b, e)));
            if !is_written && self.graph.as_number(e).is_none() && of(b) && of(e) {
                self.value(b);
                self.value(e);
                if self.power(b, e).is_none() {
                    self.write_power(b, e);
                }
            }
        }
    }

    /// Writes a general power, whose base and exponent are written.
    fn write_power(&mut self, b: Id, e: Id) {
        let (base, exponent) = (self.reference(b), self.reference(e));
        let power = quote!(#base.powf(#exponent));
        let known = self.powers.iter().find_map(|(base, f, name)| {
            let related = (*base == b).then(|| related(self.graph, e, *f)).flatten()?;
            let range = self.graph.range(b).powers(self.graph.range(*f));
            Some((related, name.clone(), range.at_most_one()))
        });
        let value = known.map(|(Related { times, whole }, name, small)| {
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
            // A power that is at most one has not overflowed.
            match small && times.abs() == 1 {
                true => {
                    quote!(::aether_core::support::by_small_power(#name, #value, #base, #exponent))
                }
                false => quote!(::aether_core::support::by_power(#name, #value, #base, #exponent)),
            }
        });
        let name = self.named(&value.unwrap_or(power));
        self.powers.push((b, e, name));
    }

    pub(super) fn three_halves(&self, power: &ThreeHalves) -> TokenStream {
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
}

#[cfg(test)]
mod tests {
    use super::*;

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
