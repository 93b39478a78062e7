//! Roots, above all of sums whose terms leave the range of numbers where the root does not.

use proc_macro2::TokenStream;
use quote::quote;

use super::Code;
use super::literal::{joined, rational};
use super::parts::Parts;
use crate::expr::{Deps, Fun, Graph, Id, Node, OUTS, UNKNOWNS, children};
use crate::overflow::SAFE;
use crate::rational::Q;

/// What is larger has its part in a product's being too large.
const LARGE: f64 = 1e6;

/// Sums of squares between this and its inverse keep their digits in any precision.
const LEAST: f64 = 1e-30;

impl Code<'_> {
    /// Writes the root of a sum of squares, which has to be looked after, once for all that it divides.
    pub(super) fn write_rescued(&mut self, b: Id) {
        if stays_in_range(self.graph, b) {
            let base = self.reference(b);
            let name = self.named(&quote!(#base.sqrt()));
            self.rescued.insert(b, name);
            return;
        }
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
            let way =
                if self.looked_at.contains(&b) { quote!(root_or_infinite) } else { quote!(root) };
            let again = self.minors_again(b);
            let scaled = if again.is_empty() { scaled } else { quote!({ #again #scaled }) };
            let root = quote!(::aether_core::support::#way(#base, move |up: R| #scaled));
            let name = self.named(&root);
            self.rescued.insert(b, name);
        }
    }

    /// Statements that make the minors among the squares of a sum once more, by the same operations under the same names, if
    /// the edges that they are made of are in use elsewhere. What is seldom asked for is handed the edges then: minors that are
    /// handed on have to be numbers one by one, which keeps the compiler of Rust from having them two at a time.
    fn minors_again(&self, b: Id) -> TokenStream {
        let areas = |minor: Id| match self.graph.node(minor) {
            Node::Sum(_, terms) => terms.iter().map(|(_, area)| *area).collect(),
            _ => Vec::new(),
        };
        let minors = squared(self.graph, b).into_iter().filter(|&id| is_minor(self.graph, id));
        let minors: Vec<(Id, Vec<Id>)> = minors.map(|minor| (minor, areas(minor))).collect();
        let all: Vec<Id> = minors.iter().flat_map(|(_, areas)| areas.clone()).collect();
        let edges: Vec<Id> = all.iter().flat_map(|&area| children(self.graph.node(area))).collect();
        let others = self.names.keys().filter(|id| !all.contains(id));
        let mut used = others.flat_map(|&id| children(self.graph.node(id)));
        let is_edge = |id: &Id| edges.contains(id) && self.graph.deps(*id) != 0;
        if !used.any(|id| is_edge(&id)) {
            return TokenStream::new();
        }
        let again = minors.into_iter().flat_map(|(minor, areas)| areas.into_iter().chain([minor]));
        let named = again.filter_map(|id| Some((self.names.get(&id)?, self.expression(id))));
        named.map(|(name, value)| quote!(let #name = #value;)).collect()
    }

    /// Notes that an expression is looked at: where a root that is a factor of it is infinite, it is infinite or no number.
    pub(crate) fn look_at(&mut self, id: Id) {
        let product = match self.graph.node(id) {
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => terms[0].1,
            _ => id,
        };
        let Node::Product(factors) = self.graph.node(product) else { return };
        let above = factors.iter().filter(|(_, e)| {
            self.graph.as_number(*e).is_some_and(|q| q.den() == 2 && !q.is_negative())
        });
        self.looked_at = above.map(|(b, _)| *b).collect();
    }

    /// √base; a sum of squares small enough to underflow is computed again on another scale.
    pub(super) fn root(&self, b: Id, base: &TokenStream) -> TokenStream {
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
    pub(super) fn scaled_squares(&self, b: Id) -> Option<TokenStream> {
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

    /// Whether the product of the factors on one side that have a root is larger than any number of single precision where the
    /// parameter that all large ones have is as large as it is declared to be.
    pub(super) fn overflows(&self, factors: &[(Id, Id)], below: bool) -> bool {
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
    pub(super) fn side_of_roots(&self, factors: &[(Id, Id)]) -> Option<Q> {
        let exponents = factors.iter().filter(|(b, _)| self.graph.deps(*b) != 0);
        let mut halves = exponents
            .filter_map(|(_, e)| self.graph.as_number(*e).filter(|q| q.den() == 2))
            .map(|q| q.is_negative());
        let first = halves.next()?;
        let side = if first { Q::HALF.neg() } else { Q::HALF };
        halves.all(|below| below == first).then_some(side)
    }
}

/// Whether a sum of squares neither underflows nor overflows, as it has the squares of all coordinates of a unit vector, each
/// times some factor: it is at least the smallest of these.
fn stays_in_range(g: &Graph, b: Id) -> bool {
    let Node::Sum(c, terms) = g.node(b) else { return false };
    let of_coordinate = |x: Id| {
        let least = terms.iter().filter_map(|(q, term)| {
            let Node::Product(factors) = g.node(*term) else { return None };
            let is_square = |(base, e): &(Id, Id)| *base == x && g.as_number(*e) == Some(Q::int(2));
            let square = factors.iter().position(is_square)?;
            let others = factors.iter().enumerate().filter(|(i, _)| *i != square);
            others.map(|(_, f)| f).try_fold(q.to_f64(), |least, &(base, e)| {
                Some(least * g.range(base).pow(g.as_number(e)?.to_f64()).lo)
            })
        });
        least.fold(0.0, f64::max)
    };
    let adds = |(q, term): &(Q, Id)| !q.is_negative() && g.range(*term).nonnegative();
    let unit =
        g.units().iter().map(|unit| unit.iter().map(|x| of_coordinate(*x)).fold(1.0, f64::min));
    !c.is_negative()
        && terms.iter().all(adds)
        && unit.fold(0.0, f64::max) > LEAST
        && g.range(b).hi < 1.0 / LEAST
}

/// The factors of the terms of a sum.
fn factors(g: &Graph, id: Id) -> impl Iterator<Item = &(Id, Id)> {
    let terms = match g.node(id) {
        Node::Sum(_, terms) => terms.as_slice(),
        _ => &[],
    };
    terms.iter().flat_map(|(_, term)| match g.node(*term) {
        Node::Product(factors) => factors.as_slice(),
        _ => &[],
    })
}

/// What is squared in a sum of squares.
fn squared(g: &Graph, id: Id) -> Vec<Id> {
    let is_square = |(_, e): &&(Id, Id)| g.as_number(*e) == Some(Q::int(2));
    factors(g, id).filter(is_square).map(|(base, _)| *base).collect()
}

/// Whether an expression is a difference of two products of two differences of parameters each, as coordinates of a vector
/// product are.
fn is_minor(g: &Graph, id: Id) -> bool {
    let is_edge = |&(base, e): &(Id, Id)| {
        let has_two =
            matches!(g.node(base), Node::Sum(c, terms) if c.is_zero() && terms.len() == 2);
        has_two && g.as_number(e) == Some(Q::ONE) && !g.has(base, UNKNOWNS | OUTS)
    };
    let is_area = |(_, term): &(Q, Id)| match g.node(*term) {
        Node::Product(factors) => factors.len() == 2 && factors.iter().all(is_edge),
        _ => false,
    };
    matches!(g.node(id), Node::Sum(c, terms) if c.is_zero() && terms.len() == 2 && terms.iter().all(is_area))
}

/// The inputs among the bases of a sum of products.
fn bases(g: &Graph, id: Id) -> Vec<Id> {
    let bases = factors(g, id).map(|(base, _)| *base);
    bases.filter(|base| matches!(g.node(*base), Node::Leaf(_))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Leaf;
    use crate::interval::Interval;

    #[test]
    fn stretched_unit_vectors_have_a_length() {
        let mut g = Graph::new();
        let unit =
            [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), &format!("w{i}"), Interval::new(-1.0, 1.0)));
        let [a, tiny] = [(3, 1e-4), (4, 0.0)]
            .map(|(i, lo)| g.leaf(Leaf::Param(i), "a", Interval::new(lo, 1.0)));
        let length = |g: &mut Graph, by: [Option<Id>; 3]| {
            let squares: Vec<(Q, Id)> = unit
                .into_iter()
                .zip(by)
                .map(|(x, by)| {
                    let x = by.map_or(x, |by| g.mul(x, by));
                    (Q::ONE, g.powi(x, 2))
                })
                .collect();
            g.sum(Q::ZERO, &squares)
        };
        let stretched = length(&mut g, [Some(a), Some(a), None]);
        assert!(!stays_in_range(&g, stretched));
        g.declare_unit(unit);
        let [vanishing, part] = [[Some(a), Some(tiny), None], [Some(a), Some(a), Some(tiny)]]
            .map(|by| length(&mut g, by));
        assert!(stays_in_range(&g, stretched));
        assert!(!stays_in_range(&g, vanishing) && !stays_in_range(&g, part));
    }

    #[test]
    fn what_is_seldom_asked_for_makes_minors_of_edges_once_more() {
        let mut g = Graph::new();
        let p: Vec<Id> =
            (0..6).map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL)).collect();
        let edges: Vec<Id> = (1..5).map(|i| g.sub(p[i], p[0])).collect();
        let minor = |g: &mut Graph, [a, b, c, d]: [Id; 4]| {
            let [first, second] = [g.mul(a, b), g.mul(c, d)];
            g.sub(first, second)
        };
        let of_edges = minor(&mut g, [edges[0], edges[1], edges[2], edges[3]]);
        let of_inputs = minor(&mut g, [p[1], p[2], p[3], p[4]]);
        assert!(is_minor(&g, of_edges) && !is_minor(&g, of_inputs) && !is_minor(&g, edges[0]));
        let squares = [of_edges, p[5]].map(|x| (Q::ONE, g.powi(x, 2)));
        let sum = g.sum(Q::ZERO, &squares);
        let root = g.sqrt(sum);
        let inverse = g.powi(root, -1);
        let point = g.mul(p[5], edges[0]);
        let input = |leaf: Leaf| format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap();
        let closure = |ids: &[Id]| {
            let mut code = Code::new(&g, &input);
            code.values(ids);
            let name = code.reference(of_edges).to_string();
            let text = code.statements().to_string();
            let (_, closure) = text.split_once("move | up : R |").unwrap();
            (name, closure.split_once(") ;").unwrap().0.to_string())
        };
        // What is made again is the minor, of its two products.
        let (name, again) = closure(&[point, inverse]);
        assert!(again.contains(&format!("let {name} =")), "{again}");
        assert_eq!(again.matches("let ").count(), 3, "{again}");
        // Where nothing else needs an edge the minor is handed on.
        assert_eq!(closure(&[inverse]).1.matches("let ").count(), 0);
    }

    #[test]
    fn roots_above_the_line_of_what_is_looked_at_may_be_infinite() {
        let mut g = Graph::new();
        let [a, b, c] = [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), &format!("p{i}"), Interval::ALL));
        let squares = |g: &mut Graph, x: Id, y: Id| {
            let squares = [x, y].map(|x| (Q::ONE, g.powi(x, 2)));
            let sum = g.sum(Q::ZERO, &squares);
            g.sqrt(sum)
        };
        let (above, below) = (squares(&mut g, a, b), squares(&mut g, b, c));
        let quotient = g.div(above, below);
        let input = |leaf: Leaf| format!("{leaf:?}").replace(['(', ')'], "_").parse().unwrap();
        let text = |looked_at: bool| {
            let mut code = Code::new(&g, &input);
            if looked_at {
                code.look_at(quotient);
            }
            code.value(quotient);
            let text = code.statements().to_string();
            [":: root_or_infinite", ":: root ("].map(|name| text.matches(name).count())
        };
        assert_eq!((text(false), text(true)), ([0, 2], [1, 1]));
    }
}
