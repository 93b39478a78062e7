//! Numerical evaluation of expressions at any precision.

mod column;
mod memo;

use self::column::{Column, Quotient};
use self::memo::Memo;
use crate::expr::{Fun, Graph, Id, Leaf, Node, divided};
use crate::number::Number;
use crate::rational::Q;

/// Evaluates several expressions that share their subexpressions.
pub struct Evaluator<'a, T> {
    graph: &'a Graph,
    inputs: &'a dyn Fn(Leaf) -> T,
    memo: Memo<T>,
}

impl<'a, T: Number> Evaluator<'a, T> {
    /// An evaluator at the point given by `inputs`.
    pub fn new(graph: &'a Graph, inputs: &'a dyn Fn(Leaf) -> T) -> Self {
        Evaluator { graph, inputs, memo: Memo::new() }
    }

    /// The value of an expression.
    pub fn value(&mut self, id: Id) -> T {
        if let Some(v) = self.memo.get(id) {
            return v;
        }
        let inputs = self.inputs;
        let node =
            Evaluated { graph: self.graph, inputs: &|l, _| inputs(l), like: &[T::from_f64(0.0)] };
        let [v] = node.values(id, &mut |part| [self.value(part)]);
        self.memo.insert(id, v);
        v
    }
}

/// Points at which nodes are evaluated.
pub struct Evaluated<'a, T, C> {
    /// Where the nodes are.
    pub graph: &'a Graph,
    /// The inputs of a point, by its number.
    pub inputs: &'a dyn Fn(Leaf, usize) -> T,
    /// A column that is as long as there are points.
    pub like: &'a C,
}

impl<T: Number, C: Column<T>> Evaluated<'_, T, C> {
    /// The values of a node from those of its parts. What is to be found out about the node is found out once for all
    /// points. Parts that are not needed are not asked for.
    pub fn values<P: AsRef<[T]>>(&self, id: Id, part: &mut dyn FnMut(Id) -> P) -> C {
        let Evaluated { graph, inputs, like } = *self;
        let mut values = like.clone();
        let out = values.as_mut();
        match graph.node(id) {
            Node::Number(q) => out.fill(T::from_ratio(q.num(), q.den())),
            Node::Float(bits) => out.fill(T::from_f64(f64::from_bits(*bits))),
            Node::Pi => out.fill(T::pi()),
            Node::Leaf(l) => column::set(out, |k| inputs(*l, k)),
            Node::Sum(c, terms) => self.sum(*c, terms, out, part),
            Node::Product(factors) => return self.product(factors, part),
            Node::Call(f, args) => {
                let columns: Vec<P> = args.iter().map(|a| part(*a)).collect();
                let arguments = |i: usize| columns.get(i).unwrap_or(&columns[0]).as_ref();
                let [a, b, c, d] = [0, 1, 2, 3].map(arguments);
                column::set(out, |k| call(*f, a[k], [b[k], c[k], d[k]]));
            }
            Node::If(test, yes, no) => {
                let test = part(*test);
                let test: Vec<bool> = test.as_ref().iter().map(|t| t.to_f64() > 0.0).collect();
                let sides = [(*yes, true), (*no, false)];
                let [yes, no] =
                    sides.map(|(branch, side)| test.contains(&side).then(|| part(branch)));
                column::set(out, |k| {
                    let chosen = if test[k] { &yes } else { &no };
                    chosen.as_ref().map_or(T::from_f64(f64::NAN), |c| c.as_ref()[k])
                });
            }
            Node::Root(r) => {
                let parts = [r.target, r.lo, r.hi].map(|id| (id, part(id)));
                column::set(out, |k| {
                    let found = |id: Id| parts.iter().find(|p| p.0 == id);
                    let mut part =
                        |id| found(id).map_or(T::from_f64(f64::NAN), |p| p.1.as_ref()[k]);
                    crate::root::root_value(graph, r, &|l| inputs(l, k), &mut part)
                });
            }
        }
        values
    }

    fn sum<P: AsRef<[T]>>(
        &self,
        c: Q,
        terms: &[(Q, Id)],
        out: &mut [T],
        part: &mut dyn FnMut(Id) -> P,
    ) {
        let constant = T::from_ratio(c.num(), c.den());
        // As in emitted code, the difference of two coordinates is taken first.
        let anchored = self.graph.anchored(c, terms);
        let (first, second) = anchored.unwrap_or((usize::MAX, usize::MAX));
        if anchored.is_some() {
            let [(p, a), (q, b)] = [terms[first], terms[second]];
            let (a, b) = (part(a), part(b));
            let (a, b) = (a.as_ref(), b.as_ref());
            let [p, q] = [p, q].map(|q| (q != Q::ONE).then(|| T::from_ratio(q.num(), q.den())));
            let times = |factor: Option<T>, v: T| factor.map_or(v, |factor| factor * v);
            column::set(out, |k| times(p, a[k]) + times(q, b[k]) + constant);
        } else {
            out.fill(constant);
        }
        for (i, (q, t)) in terms.iter().enumerate() {
            if i != first && i != second {
                column::add(out, *q, part(*t).as_ref());
            }
        }
    }

    fn product<P: AsRef<[T]>>(&self, factors: &[(Id, Id)], part: &mut dyn FnMut(Id) -> P) -> C {
        let Evaluated { graph, like, .. } = *self;
        // Powers that are taken together, and those that occur above and below the line.
        let together = graph.powers_together(factors);
        let shared = graph.shared_powers(factors);
        let mut quotient = Quotient::default();
        let mut quotients: Vec<Quotient<C>> = shared.iter().map(|_| Quotient::default()).collect();
        for factor in factors {
            if together.as_ref().is_some_and(|together| together.contains(factor)) {
                continue;
            }
            let (b, e) = *factor;
            let b = part(b);
            let b = b.as_ref();
            match graph.as_number(e) {
                Some(q) => match divided(q, &shared) {
                    Some(by) => {
                        let place = shared.iter().position(|p| *p == by.power).unwrap_or(0);
                        quotients[place].push(b, by.times, like);
                        if !by.rest.is_zero() {
                            quotient.push(b, by.rest, like);
                        }
                    }
                    None => quotient.push(b, q, like),
                },
                None => quotient.push_general(b, part(e).as_ref(), like),
            }
        }
        for (inside, power) in quotients.into_iter().zip(&shared) {
            quotient.push(inside.value(like).as_ref(), *power, like);
        }
        if let Some(together) = &together {
            let mut inside = Quotient::default();
            together.inside.iter().for_each(|(b, q)| inside.push(part(*b).as_ref(), *q, like));
            let exponents = part(together.exponent);
            quotient.push_general(inside.value(like).as_ref(), exponents.as_ref(), like);
            together.outside.iter().for_each(|(b, q)| quotient.push(part(*b).as_ref(), *q, like));
        }
        quotient.value(like)
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
