//! Densities that are not positive at any point with a coordinate that is no finite number, so that nobody need ask whether all
//! coordinates are: the formula is followed with every number replaced by what kinds of number it may be.

use super::pieces::Place;
use super::plainly::{Condition, conditions};
use crate::expr::{Fun, Graph, Id, Leaf, Node, children};
use crate::hash::Map;

/// A set of kinds of numbers.
type Kinds = u8;

const NEGATIVE: Kinds = 1;
const ZERO: Kinds = 2;
const POSITIVE: Kinds = 4;
const BELOW: Kinds = 8;
const ABOVE: Kinds = 16;
const NONE: Kinds = 32;
const FINITE: Kinds = NEGATIVE | ZERO | POSITIVE;
const ALL: Kinds = FINITE | BELOW | ABOVE | NONE;

/// Of more coordinates there are too many combinations.
const MOST: usize = 3;

/// What becomes of points with coordinates that are not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fading {
    /// They do not pass the tests of the preimage.
    Excluded,
    /// The formula of the density gives zero or no number.
    Fades,
    /// The formula may tell a density.
    Stays,
}

/// What becomes of them at a preimage of points with `m` coordinates.
pub(super) fn fading(place: Place, m: usize) -> Fading {
    if m > MOST {
        return Fading::Stays;
    }
    let (g, density) = (&place.problem.graph, place.preimage.density);
    let tests: Vec<(Id, Kinds)> =
        conditions(place).into_iter().map(|(id, condition)| (id, passing(condition))).collect();
    let finite = |i: usize| {
        let own = tests.iter().filter(|(id, _)| g.is_leaf(*id, Leaf::Out(i as u8)));
        own.fold(FINITE, |kinds, (_, passing)| kinds & passing)
    };
    let mut fading = Fading::Excluded;
    for combination in 1..4usize.pow(m as u32) {
        let kinds = (0..m).map(|i| match combination >> (2 * i) & 3 {
            0 => finite(i),
            1 => BELOW,
            2 => ABOVE,
            _ => NONE,
        });
        let mut point = Point { g, kinds: kinds.collect(), known: Map::default() };
        if tests.iter().any(|&(id, passing)| point.kinds(id) & passing == 0) {
            continue;
        }
        if point.kinds(density) & (POSITIVE | ABOVE) != 0 {
            return Fading::Stays;
        }
        fading = Fading::Fades;
    }
    fading
}

/// The kinds of numbers that pass a test.
fn passing(condition: Condition) -> Kinds {
    match condition {
        Condition::Positive => POSITIVE | ABOVE,
        Condition::NotNegative => ZERO | POSITIVE | ABOVE,
        Condition::HardlyNegative => FINITE | ABOVE,
        Condition::Finite => FINITE,
    }
}

/// A point by the kinds of its coordinates; parameters are finite.
struct Point<'a> {
    g: &'a Graph,
    kinds: Vec<Kinds>,
    known: Map<Id, Kinds>,
}

impl Point<'_> {
    fn kinds(&mut self, id: Id) -> Kinds {
        if let Some(known) = self.known.get(&id) {
            return *known;
        }
        let kinds = self.of_node(id);
        self.known.insert(id, kinds);
        kinds
    }

    fn of_node(&mut self, id: Id) -> Kinds {
        let g = self.g;
        match g.node(id) {
            Node::Leaf(Leaf::Out(i)) => self.kinds[usize::from(*i)],
            Node::Leaf(Leaf::Param(_)) | Node::Number(_) | Node::Float(_) | Node::Pi => {
                let range = g.range(id);
                let one = |is: bool, kind| if is { kind } else { 0 };
                one(range.lo < 0.0, NEGATIVE)
                    | one(range.hi > 0.0, POSITIVE)
                    | one(range.lo <= 0.0 && range.hi >= 0.0, ZERO)
            }
            Node::Leaf(_) | Node::Root(_) => ALL,
            Node::Sum(c, terms) => {
                let start = if c.is_zero() { ZERO } else { sign(c.is_negative()) };
                terms.iter().fold(start, |sum, (q, term)| {
                    let term = self.kinds(*term);
                    pairs(sum, pairs(sign(q.is_negative()), term, product), total)
                })
            }
            Node::Product(factors) => factors.iter().fold(POSITIVE, |all, &(base, exponent)| {
                let base = self.kinds(base);
                pairs(all, self.power(base, exponent), product)
            }),
            Node::Call(Fun::Abs, args) => {
                let kinds = self.kinds(args[0]);
                each(kinds, |kind| match kind {
                    NEGATIVE => POSITIVE,
                    BELOW => ABOVE,
                    kind => kind,
                })
            }
            Node::Call(Fun::Exp, args) => {
                let kinds = self.kinds(args[0]);
                each(kinds, |kind| match kind {
                    NEGATIVE => ZERO | POSITIVE,
                    POSITIVE => POSITIVE | ABOVE,
                    ZERO => POSITIVE,
                    BELOW => ZERO,
                    kind => kind,
                })
            }
            Node::If(test, yes, no) => {
                let test = self.kinds(*test);
                let taken = |is: bool, kinds: Kinds| if is { kinds } else { 0 };
                let yes = taken(test & (POSITIVE | ABOVE) != 0, self.kinds(*yes));
                yes | taken(test & !(POSITIVE | ABOVE) != 0, self.kinds(*no))
            }
            // These have values where what they are of, or one of it, is no number.
            Node::Call(Fun::Sign | Fun::Pow1p | Fun::TurnTo, _) => ALL,
            node => {
                let undefined = children(node).iter().any(|&arg| self.kinds(arg) == NONE);
                if undefined { NONE } else { ALL }
            }
        }
    }

    /// A power of a number of some kinds.
    fn power(&self, base: Kinds, exponent: Id) -> Kinds {
        let Some(q) = self.g.as_number(exponent) else { return ALL };
        let (even, whole) = (q.is_even(), q.is_int());
        let raised = each(base, |kind| match kind {
            NEGATIVE | BELOW if q.den() == 2 => NONE,
            NEGATIVE | BELOW if !whole => ALL,
            NEGATIVE if even => POSITIVE | ZERO | ABOVE,
            NEGATIVE => NEGATIVE | ZERO | BELOW,
            BELOW if even => ABOVE,
            POSITIVE => POSITIVE | ZERO | ABOVE,
            kind => kind,
        });
        if !q.is_negative() {
            return raised;
        }
        each(raised, |kind| match kind {
            ZERO => BELOW | ABOVE,
            BELOW | ABOVE => ZERO,
            POSITIVE => POSITIVE | ZERO | ABOVE,
            NEGATIVE => NEGATIVE | ZERO | BELOW,
            kind => kind,
        })
    }
}

/// The kind of a number of this sign.
fn sign(negative: bool) -> Kinds {
    if negative { NEGATIVE } else { POSITIVE }
}

/// What a function makes of each of some kinds.
fn each(kinds: Kinds, function: impl Fn(Kinds) -> Kinds) -> Kinds {
    let kinds = (0..6).map(|i| kinds & 1 << i).filter(|kind| *kind != 0);
    kinds.fold(0, |all, kind| all | function(kind))
}

/// What an operation makes of pairs of some kinds.
fn pairs(a: Kinds, b: Kinds, operation: impl Fn(Kinds, Kinds) -> Kinds) -> Kinds {
    each(a, |a| each(b, |b| operation(a, b)))
}

fn total(a: Kinds, b: Kinds) -> Kinds {
    match (a, b) {
        (NONE, _) | (_, NONE) | (ABOVE, BELOW) | (BELOW, ABOVE) => NONE,
        (ABOVE | BELOW, _) => a,
        (_, ABOVE | BELOW) => b,
        (ZERO, kind) | (kind, ZERO) => kind,
        (POSITIVE, POSITIVE) => POSITIVE | ABOVE,
        (NEGATIVE, NEGATIVE) => NEGATIVE | BELOW,
        _ => FINITE,
    }
}

fn product(a: Kinds, b: Kinds) -> Kinds {
    let infinite = |kind| kind & (ABOVE | BELOW) != 0;
    let negative = (a & (NEGATIVE | BELOW) != 0) != (b & (NEGATIVE | BELOW) != 0);
    let unbounded = if negative { BELOW } else { ABOVE };
    match (a, b) {
        (NONE, _) | (_, NONE) => NONE,
        (ZERO, other) | (other, ZERO) => {
            if infinite(other) {
                NONE
            } else {
                ZERO
            }
        }
        _ if infinite(a) || infinite(b) => unbounded,
        _ => sign(negative) | ZERO | unbounded,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proc_macro2::TokenStream;

    fn asks(parameters: &str, space: &str, body: &str) -> bool {
        let function = format!(
            "fn f(u: [Uniform; 2], {parameters}) -> {space} {{ let phi = TAU * u[1]; {body} }}"
        );
        let code = crate::sampler(TokenStream::new(), function.parse().unwrap()).to_string();
        let (_, density) = code.split_once("'quick").unwrap();
        density.split_once("fn ").unwrap().0.contains("if ! belongs () . all ()")
    }

    #[test]
    fn what_divides_by_all_coordinates_fades() {
        let slopes =
            "let r = a * (u[0] / (1.0 - u[0])).sqrt(); Vec2::new(r * phi.cos(), r * phi.sin())";
        assert!(!asks("a: f64", "Vec2", slopes));
        let lobe = "let z = u[0].sqrt(); let r = (1.0 - z * z).sqrt(); Direction::new(r * phi.cos(), r * phi.sin(), z)";
        assert!(asks("a: f64", "Direction", lobe));
    }

    #[test]
    fn a_sign_is_a_number_whatever_it_is_of() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Out(0), "x", crate::interval::Interval::new(-9.0, 9.0));
        let calls = [Fun::Sin, Fun::Sign].map(|f| g.call(f, &[x]));
        let mut point = Point { g: &g, kinds: vec![NONE], known: Map::default() };
        assert_eq!(calls.map(|id| point.kinds(id)), [NONE, ALL]);
    }

    #[test]
    fn kinds_of_sums_products_and_powers() {
        assert_eq!(pairs(ABOVE, BELOW | POSITIVE, total), NONE | ABOVE);
        assert_eq!(pairs(ZERO, ABOVE | NEGATIVE, product), NONE | ZERO);
        assert_eq!(pairs(NEGATIVE, BELOW, product), ABOVE);
        assert_eq!(pairs(POSITIVE, NEGATIVE, product), NEGATIVE | ZERO | BELOW);
    }
}
