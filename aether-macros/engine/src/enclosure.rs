//! Intervals that certainly contain every value of an expression over a box of inputs: the
//! arithmetic of proofs.

mod outward;
pub mod unbroken;

use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::hash::Map;
use crate::interval::Interval;

use outward::{add, call, mul, power, rational, symbolic_power, widen};

/// Expressions in an order in which every part comes before the whole.
pub struct Enclosure {
    steps: Vec<Step>,
    place: Map<Id, usize>,
}

/// How the interval of an expression follows from those of its parts, which are told by their places.
enum Step {
    Known(Interval),
    /// An input, by its place in the box.
    Input(usize),
    Sum(Interval, Vec<(Interval, usize)>),
    Product(Vec<(usize, Exponent)>),
    Call(Fun, usize),
    If(usize, [usize; 2]),
    /// A root, which lies between two others.
    Between([usize; 2]),
}

enum Exponent {
    Number(f64),
    Part(usize),
}

impl Enclosure {
    /// For these expressions over boxes of these inputs.
    pub fn new(g: &Graph, ids: &[Id], inputs: &[Leaf]) -> Enclosure {
        let mut found = Enclosure { steps: Vec::new(), place: Map::default() };
        let mut open: Vec<(Id, bool)> = ids.iter().rev().map(|i| (*i, false)).collect();
        while let Some((id, ready)) = open.pop() {
            if found.place.contains_key(&id) {
                continue;
            }
            if ready {
                let step = found.step(g, id, inputs);
                found.place.insert(id, found.steps.len());
                found.steps.push(step);
            } else {
                open.push((id, true));
                open.extend(children(g.node(id)).into_iter().map(|c| (c, false)));
            }
        }
        found
    }

    fn step(&self, g: &Graph, id: Id, inputs: &[Leaf]) -> Step {
        let at = |part: &Id| self.place[part];
        match g.node(id) {
            Node::Number(q) => Step::Known(rational(*q)),
            Node::Float(bits) => Step::Known(Interval::point(f64::from_bits(*bits))),
            Node::Pi => Step::Known(widen(Interval::point(std::f64::consts::PI), 1)),
            Node::Leaf(l) => match inputs.iter().position(|input| input == l) {
                Some(k) => Step::Input(k),
                None => Step::Known(Interval::ALL),
            },
            Node::Sum(c, terms) => {
                let terms = terms.iter().map(|(q, t)| (rational(*q), at(t)));
                Step::Sum(rational(*c), terms.collect())
            }
            Node::Product(factors) => {
                let exponent = |e: &Id| match g.as_number(*e) {
                    Some(q) => Exponent::Number(q.to_f64()),
                    None => Exponent::Part(at(e)),
                };
                Step::Product(factors.iter().map(|(b, e)| (at(b), exponent(e))).collect())
            }
            Node::Call(f, args) => match &args[..] {
                [a] => Step::Call(*f, at(a)),
                _ => Step::Known(widen(g.range(id), 8)),
            },
            Node::If(test, yes, no) => Step::If(at(test), [yes, no].map(at)),
            Node::Root(r) if r.inside => Step::Between([&r.lo, &r.hi].map(at)),
            Node::Root(_) => Step::Known(Interval::ALL),
        }
    }

    /// The number of intervals that are computed over a box.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// The intervals over a box.
    pub fn over<'a>(&'a self, region: &'a [Interval]) -> Over<'a> {
        Over { enclosure: self, region, values: Vec::new() }
    }
}

/// The intervals of expressions over a box, computed as far as they are asked for.
pub struct Over<'a> {
    enclosure: &'a Enclosure,
    region: &'a [Interval],
    values: Vec<Interval>,
}

impl Over<'_> {
    /// The interval of one of the expressions.
    pub fn get(&mut self, id: Id) -> Interval {
        let place = self.enclosure.place[&id];
        while self.values.len() <= place {
            let value = self.value(&self.enclosure.steps[self.values.len()]);
            self.values.push(value);
        }
        self.values[place]
    }

    fn value(&self, step: &Step) -> Interval {
        let values = &self.values;
        match step {
            Step::Known(value) => *value,
            Step::Input(k) => self.region[*k],
            Step::Sum(c, terms) => {
                terms.iter().fold(*c, |sum, (k, t)| add(sum, mul(*k, values[*t])))
            }
            Step::Product(factors) => {
                factors.iter().fold(Interval::point(1.0), |product, (base, exponent)| {
                    let base = values[*base];
                    let power = match exponent {
                        Exponent::Number(e) => power(base, *e),
                        Exponent::Part(e) => symbolic_power(base, values[*e]),
                    };
                    mul(product, power)
                })
            }
            Step::Call(f, a) => call(*f, values[*a]),
            Step::If(test, [yes, no]) => match values[*test] {
                test if test.lo > 0.0 => values[*yes],
                test if test.hi <= 0.0 => values[*no],
                _ => values[*yes].hull(values[*no]),
            },
            Step::Between([lo, hi]) => Interval::new(values[*lo].lo, values[*hi].hi),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::number::{Dd, Number};
    use crate::points::Rng;
    use crate::rational::Q;

    /// Every value at points of a box, computed in double-double, lies in the enclosure.
    #[test]
    fn values_lie_inside() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Unknown(0), "x", Interval::ALL);
        let y = g.leaf(Leaf::Unknown(1), "y", Interval::ALL);
        let mut rng = Rng::new(5);
        let functions = [
            Fun::Exp,
            Fun::ExpM1,
            Fun::Sin,
            Fun::Cos,
            Fun::Tanh,
            Fun::Cosh,
            Fun::Sinh,
            Fun::Atan,
            Fun::Asinh,
            Fun::Abs,
        ];
        for round in 0..600 {
            let f = functions[round % functions.len()];
            let powers = [2, 3, 4, 5, -1, -2, -3];
            let (px, py) = (g.powi(x, powers[round % 7]), g.call(f, &[y]));
            let third = Q::new(1, 3).unwrap();
            let inner = g.sum(third, &[(Q::ONE, px), (Q::int(-2), py)]);
            let product = g.mul(inner, py);
            let inputs = [Leaf::Unknown(0), Leaf::Unknown(1)];
            let e = Enclosure::new(&g, &[product], &inputs);
            let mut boxed = || {
                let (lo, width) = (6.0 * rng.uniform() - 3.0, rng.uniform() * rng.uniform());
                Interval::new(lo, lo + width)
            };
            let (bx, by) = (boxed(), boxed());
            let region = |l: Leaf| if l == Leaf::Unknown(0) { bx } else { by };
            let enclosed = e.over(&[bx, by]).get(product);
            for corner in 0..9 {
                let inside = |b: Interval, k: usize| b.lo + b.width() * [0.0, 0.37, 1.0][k];
                let at = |l: Leaf| {
                    let v = if l == Leaf::Unknown(0) {
                        inside(bx, corner % 3)
                    } else {
                        inside(by, corner / 3)
                    };
                    Dd::from_f64(v.clamp(region(l).lo, region(l).hi))
                };
                let v = evaluate::<Dd>(&g, product, &at);
                let (below, above) = (v - Dd::from_f64(enclosed.lo), Dd::from_f64(enclosed.hi) - v);
                assert!(
                    below.to_f64() >= 0.0 && above.to_f64() >= 0.0,
                    "{f:?} {bx:?} {by:?} {v:?} {enclosed:?}"
                );
            }
        }
    }
}
