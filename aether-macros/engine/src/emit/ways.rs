//! Which piece uniforms take, told by no more tests than a way through the branches of the body has.

use std::ops::Range;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::code::Code;
use super::item::Emitter;
use super::passed::passed;
use super::pieces::input;
use crate::expr::{Graph, Id, Leaf};
use crate::parse::{Parsed, Piece};

/// The branches that lead to pieces.
#[derive(Debug, PartialEq, Eq)]
pub enum Ways {
    /// The piece with this number.
    Piece(usize),
    /// Those that pass a test of a piece (numbers of both) go on otherwise than those that do not.
    Fork(usize, usize, Box<[Ways; 2]>),
}

/// The differences of a piece's tests, in a graph that all share, and whether they are strict.
type Tests = Vec<(Id, bool)>;

impl Ways {
    /// The branches that lead to the pieces of an item, if there are more than two and every way leads to one of them.
    pub fn of(parsed: &Parsed) -> Option<Ways> {
        if parsed.total && parsed.pieces.len() > 2 { Ways::to(&parsed.pieces) } else { None }
    }

    /// The branches of pieces in the order in which they were followed, where each way leads to a piece; `None` where it is not
    /// seen that one test is what another is not.
    fn to(pieces: &[Piece]) -> Option<Ways> {
        let mut g = pieces.first()?.graph.clone();
        let tests = pieces.iter().map(|piece| {
            let tests = piece.tests.iter().map(|test| {
                // Roots are no expressions of another graph.
                let is_plain = !piece.graph.is_numerical(test.difference);
                is_plain.then(|| (g.import(&piece.graph, test.difference), test.strict))
            });
            tests.collect()
        });
        let all: Vec<Tests> = tests.collect::<Option<_>>()?;
        Ways::among(&mut g, &all, 0..all.len(), 0)
    }

    /// Those of some pieces whose first tests, so many, are known to be passed.
    fn among(g: &mut Graph, all: &[Tests], pieces: Range<usize>, known: usize) -> Option<Ways> {
        let first = pieces.start;
        let Some(&(difference, strict)) = all[first].get(known) else {
            return (pieces.len() == 1).then_some(Ways::Piece(first));
        };
        let opposite = Some((g.neg(difference), !strict));
        let next = |i: usize| all[i].get(known).copied();
        let alike = pieces.clone().take_while(|&i| next(i) == Some((difference, strict))).count();
        let (yes, no) = (first..first + alike, first + alike..pieces.end);
        if no.is_empty() || !no.clone().all(|i| next(i) == opposite) {
            return None;
        }
        let [yes, no] = [yes, no].map(|range| Ways::among(g, all, range, known + 1));
        Some(Ways::Fork(first, known, Box::new([yes?, no?])))
    }

    /// What is done in each piece that those of `left` take, where `taken` says which do.
    pub(super) fn code(&self, then: &impl Fn(usize) -> TokenStream) -> TokenStream {
        match self {
            Ways::Piece(j) => {
                let then = then(*j);
                quote!(let taken = left; #then)
            }
            Ways::Fork(j, k, ways) => {
                let (test, [yes, no]) = (name(*j, *k), ways.each_ref().map(|way| way.code(then)));
                quote! {
                    let (left, others) = {
                        let passed = #test::<R>(&p, &u);
                        (left.and(passed), left.and(passed.not()))
                    };
                    if left.any() { #yes }
                    let left = others;
                    if left.any() { #no }
                }
            }
        }
    }

    /// The functions of the tests.
    pub(super) fn functions(&self, e: &Emitter) -> TokenStream {
        let Ways::Fork(j, k, ways) = self else { return TokenStream::new() };
        let (n, _, p) = e.sizes();
        let (piece, name) = (&e.parsed.pieces[*j], name(*j, *k));
        let at = |l: Leaf| input(l, "u");
        let mut code = Code::new(&piece.graph, &at);
        let passed = passed(&mut code, &piece.tests[*k..=*k]);
        let lets = code.statements();
        let further = ways.iter().map(|way| way.functions(e));
        quote! {
            /// Whether uniforms go on this way at a branch.
            #[inline(always)]
            fn #name<R: Real>(p: &[R; #p], u: &[R; #n]) -> R::Mask { #lets #passed }
            #(#further)*
        }
    }
}

fn name(piece: usize, test: usize) -> Ident {
    format_ident!("way_{piece}_{test}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Item;

    fn pieces(body: &str) -> Vec<Piece> {
        let text = format!("fn s(u: [Uniform; 2]) -> Vec2 {{ {body} }}");
        let item = Item::new(TokenStream::new(), text.parse().unwrap(), true).unwrap();
        item.parsed.pieces
    }

    fn fork(piece: usize, test: usize, yes: Ways, no: Ways) -> Ways {
        Ways::Fork(piece, test, Box::new([yes, no]))
    }

    #[test]
    fn branches_within_branches_are_told_by_a_test_each() {
        use Ways::Piece;

        let four = pieces(
            "let (a, b) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
            let x = if a >= 0.0 { a } else { 2.0 * a };
            Vec2::new(x, if b < 0.5 * a { b } else { 3.0 * b - a })",
        );
        let expected = fork(0, 0, fork(0, 1, Piece(0), Piece(1)), fork(2, 1, Piece(2), Piece(3)));
        assert_eq!(Ways::to(&four), Some(expected));
        let three = pieces(
            "Vec2::new(u[0], if u[0] < 0.2 { u[1] } else if u[0] < 0.7 { 2.0 * u[1] } else { 5.0 * u[1] })",
        );
        assert_eq!(Ways::to(&three), Some(fork(0, 0, Piece(0), fork(1, 1, Piece(1), Piece(2)))));
        // Nothing tells that those which take no other way take the last one that is left.
        assert_eq!(Ways::to(&four[..3]), None);
    }
}
