//! Numerical evaluation of expressions at any precision.

use crate::expr::{Fun, Graph, Id, Leaf, Node, Together, power_below};
use crate::hash::Map;
use crate::number::Number;
use crate::rational::Q;

/// Evaluates several expressions that share their subexpressions.
pub struct Evaluator<'a, T> {
    graph: &'a Graph,
    inputs: &'a dyn Fn(Leaf) -> T,
    memo: Map<Id, T>,
}

impl<'a, T: Number> Evaluator<'a, T> {
    /// An evaluator at the point given by `inputs`.
    pub fn new(graph: &'a Graph, inputs: &'a dyn Fn(Leaf) -> T) -> Self {
        Evaluator { graph, inputs, memo: Map::default() }
    }

    /// The value of an expression.
    pub fn value(&mut self, id: Id) -> T {
        if let Some(&v) = self.memo.get(&id) {
            return v;
        }
        let (graph, inputs) = (self.graph, self.inputs);
        let v = Prepared::new(graph, id).value(inputs, &mut |part| self.value(part));
        self.memo.insert(id, v);
        v
    }
}

/// A node, and what is found out once for all points at which it is evaluated.
pub struct Prepared<'g> {
    graph: &'g Graph,
    node: &'g Node,
    /// Of a sum, the coordinates whose difference is taken first.
    anchored: Option<(usize, usize)>,
    /// Of a product, the powers that are taken together, and whether a factor is among them.
    together: Option<(Together, Vec<bool>)>,
    /// Of a product, powers that occur above and below the line.
    shared: Vec<Q>,
}

impl<'g> Prepared<'g> {
    /// A node that is to be evaluated.
    pub fn new(graph: &'g Graph, id: Id) -> Self {
        let node = graph.node(id);
        let (mut anchored, mut together, mut shared) = (None, None, vec![]);
        match node {
            Node::Sum(c, terms) => anchored = graph.anchored(*c, terms),
            Node::Product(factors) => {
                together = graph.powers_together(factors).map(|t| {
                    let among = factors.iter().map(|f| t.contains(f)).collect();
                    (t, among)
                });
                shared = graph.shared_powers(factors);
            }
            _ => {}
        }
        Prepared { graph, node, anchored, together, shared }
    }

    /// The value at a point, from those of the node's parts.
    pub fn value<T: Number>(&self, inputs: &dyn Fn(Leaf) -> T, part: &mut dyn FnMut(Id) -> T) -> T {
        match self.node {
            Node::Number(q) => T::from_ratio(q.num(), q.den()),
            Node::Float(bits) => T::from_f64(f64::from_bits(*bits)),
            Node::Pi => T::pi(),
            Node::Leaf(l) => inputs(*l),
            Node::Sum(c, terms) => self.sum(*c, terms, part),
            Node::Product(factors) => self.product(factors, part),
            Node::Call(f, args) => {
                let a = part(args[0]);
                let mut other = |i: usize| args.get(i).map_or(a, |b| part(*b));
                let others = [1, 2, 3].map(&mut other);
                call(*f, a, others)
            }
            Node::If(test, yes, no) => {
                let positive = part(*test).to_f64() > 0.0;
                part(if positive { *yes } else { *no })
            }
            Node::Root(r) => crate::root::root_value(self.graph, r, inputs, part),
        }
    }

    // In both, loops by index: this is where most of the compiler's time goes, and it runs unoptimised.
    #[allow(clippy::needless_range_loop)]
    fn sum<T: Number>(&self, c: Q, terms: &[(Q, Id)], part: &mut dyn FnMut(Id) -> T) -> T {
        let mut term = |(q, t): (Q, Id)| {
            let v = part(t);
            if q.num() == 1 && q.den() == 1 { v } else { T::from_ratio(q.num(), q.den()) * v }
        };
        let mut sum = T::from_ratio(c.num(), c.den());
        // As in emitted code.
        let (first, second) = self.anchored.unwrap_or((usize::MAX, usize::MAX));
        if self.anchored.is_some() {
            sum = term(terms[first]) + term(terms[second]) + sum;
        }
        for i in 0..terms.len() {
            if i != first && i != second {
                sum = sum + term(terms[i]);
            }
        }
        sum
    }

    #[allow(clippy::needless_range_loop)]
    fn product<T: Number>(&self, factors: &[(Id, Id)], part: &mut dyn FnMut(Id) -> T) -> T {
        // As in emitted code: what is divided by is multiplied first, and may underflow.
        let mut quotient = Quotient::default();
        let mut quotients: Vec<Quotient<T>> =
            self.shared.iter().map(|_| Quotient::default()).collect();
        for i in 0..factors.len() {
            if self.together.as_ref().is_some_and(|(_, among)| among[i]) {
                continue;
            }
            let (b, e) = factors[i];
            let b = part(b);
            match self.graph.as_number(e) {
                Some(q) => match power_below(q, &self.shared) {
                    Some(power) => {
                        let place = self.shared.iter().position(|p| *p == power).unwrap_or(0);
                        let times = Q::new(q.num(), power.num()).unwrap_or(q);
                        quotients[place].push(b, times);
                    }
                    None => quotient.push(b, q),
                },
                None => quotient.top = quotient.top * b.powf(part(e)),
            }
        }
        for (inside, power) in quotients.into_iter().zip(&self.shared) {
            quotient.push(inside.value(), *power);
        }
        if let Some((together, _)) = &self.together {
            let mut inside = Quotient::default();
            together.inside.iter().for_each(|(b, q)| inside.push(part(*b), *q));
            quotient.top = quotient.top * inside.value().powf(part(together.exponent));
            together.outside.iter().for_each(|(b, q)| quotient.push(part(*b), *q));
        }
        quotient.value()
    }
}

/// What is multiplied, and what that is divided by.
struct Quotient<T> {
    top: T,
    bottom: Option<T>,
}

impl<T: Number> Default for Quotient<T> {
    fn default() -> Self {
        Quotient { top: T::from_f64(1.0), bottom: None }
    }
}

impl<T: Number> Quotient<T> {
    fn push(&mut self, b: T, q: Q) {
        let power = match q.den() {
            1 => b.powi(q.to_i32().map_or(i32::MAX, i32::abs)),
            2 if q.num().abs() < 64 => b.sqrt().powi(q.num().abs() as i32),
            3 if q.num().abs() < 64 => b.cbrt().powi(q.num().abs() as i32),
            _ => {
                self.top = self.top * b.powf(T::from_ratio(q.num(), q.den()));
                return;
            }
        };
        if q.is_negative() {
            self.bottom = Some(self.bottom.map_or(power, |bottom: T| bottom * power));
        } else {
            self.top = self.top * power;
        }
    }

    fn value(self) -> T {
        self.bottom.map_or(self.top, |bottom| self.top / bottom)
    }
}

/// One expression at one point.
pub fn evaluate<T: Number>(graph: &Graph, id: Id, inputs: &dyn Fn(Leaf) -> T) -> T {
    Evaluator::new(graph, inputs).value(id)
}

/// A function of one to four arguments; the others are not looked at.
fn call<T: Number>(f: Fun, a: T, [b, c, d]: [T; 3]) -> T {
    match f {
        Fun::Exp => a.exp(),
        Fun::ExpM1 => a.exp_m1(),
        Fun::Ln => a.ln(),
        Fun::Ln1p => a.ln_1p(),
        Fun::Sin => a.sin(),
        Fun::Cos => a.cos(),
        Fun::Tan => a.tan(),
        Fun::Asin => a.asin(),
        Fun::Acos => a.acos(),
        Fun::Atan => a.atan(),
        Fun::Sinh => a.sinh(),
        Fun::Cosh => a.cosh(),
        Fun::Tanh => a.tanh(),
        Fun::Asinh => a.asinh(),
        Fun::Acosh => a.acosh(),
        Fun::Atanh => a.atanh(),
        Fun::Cbrt => a.cbrt(),
        Fun::Erf => a.erf(),
        Fun::Erfc => a.erfc(),
        Fun::ErfInv => a.erf_inv(),
        Fun::ErfcInv => a.erfc_inv(),
        Fun::LnErfc => a.ln_erfc(),
        Fun::ErfcInvExp => a.erfc_inv_exp(),
        Fun::LambertW => a.lambert_w(),
        Fun::LnGamma => a.ln_gamma(),
        Fun::LnBeta => a.ln_beta(b),
        Fun::BetaInc => a.beta_inc(d, b, c),
        Fun::BetaIncInv => a.beta_inc_inv(d, b, c),
        Fun::SinPi => half_turns(a, 0),
        Fun::CosPi => half_turns(a, 1),
        Fun::Abs => a.abs(),
        Fun::Sign => T::from_f64(if a.to_f64() < 0.0 { -1.0 } else { 1.0 }),
        Fun::Atan2 => a.atan2(b),
        Fun::TurnTo => {
            let turn = T::pi() + T::pi();
            let turns = ((a - b) / turn + T::from_f64(0.5)).floor();
            if turns.to_f64() == 0.0 { a } else { a - turn * turns }
        }
        Fun::Pow1p => (b * a.ln_1p()).exp(),
        Fun::Turn => {
            let turn = T::pi() + T::pi();
            if a.to_f64() < 0.0 || a.to_f64() >= turn.to_f64() {
                a - turn * (a / turn).floor()
            } else {
                a
            }
        }
    }
}

/// sin(π x + quarter · π / 2), with x reduced exactly first.
fn half_turns<T: Number>(x: T, quarter: i64) -> T {
    let two = T::from_f64(2.0);
    let half = T::from_f64(0.5);
    let n = (x * two + half).floor();
    let r = T::pi() * (x - n * half);
    // A number of quarters beyond all integers is a multiple of four.
    let k = (n.to_f64() as i64).rem_euclid(4) + quarter;
    match k % 4 {
        0 => r.sin(),
        1 => r.cos(),
        2 => -r.sin(),
        _ => -r.cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::number::Single;

    #[test]
    fn powers_above_and_below_the_line_are_those_of_a_quotient() {
        let mut g = Graph::new();
        let [a, b] = [0, 1].map(|i| g.leaf(Leaf::Param(i), ["a", "b"][i as usize], Interval::ALL));
        let (top, bottom) = (g.powi(a, 2), g.powi(b, -2));
        let product = g.mul(top, bottom);
        let input = |leaf: Leaf| Single::from_f64(if leaf == Leaf::Param(0) { 1e25 } else { 1e30 });
        let value = evaluate(&g, product, &input).to_f64();
        assert!((value - 1e-10).abs() < 1e-16, "{value:e}");
    }
}
