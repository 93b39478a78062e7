//! Atoms in the body of a sampler: ways that lead to one point, with a probability in place of a density.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{Block, Expr, ExprCall, Lit};

use super::body::Body;
use super::{Made, Reading, Signature, Test, Value};
use crate::derive::Part;
use crate::expr::{Deps, Graph, Id, Leaf, UNKNOWNS};
use crate::points::Kind;

/// What the author says of a point of a distribution with atoms.
#[derive(Clone, Debug)]
pub struct Mark {
    /// The number of the atom; `None` for a point of the continuous part.
    pub number: Option<usize>,
    /// `Mixed::Atom(…)` as written.
    pub tokens: TokenStream,
}

/// A way through the branches of a body that ends in an atom.
pub struct AtomWay {
    /// The number of the atom.
    pub number: usize,
    /// Where it lies, by expressions of the parameters.
    pub place: Vec<Id>,
    /// The points that it consists of; mostly a single one.
    pub parts: Vec<Part>,
    /// The identity expressions, if it lies on surfaces.
    pub identities: Vec<TokenStream>,
    /// The expressions of the place and of the tests.
    pub graph: Graph,
    /// Which uniforms take this way.
    pub tests: Vec<Test>,
    /// The uniforms.
    pub unknowns: Vec<Leaf>,
    /// The scalar parameters in groups.
    pub kinds: Vec<Kind>,
    /// Those that are made of others.
    pub made: Made,
    /// What is declared of the parameters together.
    pub relations: Vec<Test>,
    /// The atom as written.
    pub tokens: TokenStream,
}

impl Reading {
    /// The way that was read as one that ends in this atom.
    pub(super) fn into_atom(self, number: usize, tokens: TokenStream, parts: Vec<Part>) -> AtomWay {
        let (place, identities) = self.point.unwrap_or_default();
        let mut tests: Vec<Test> = self.way.tests.into_iter().map(|(_, test)| test).collect();
        let required = self.requirements.into_iter();
        tests.extend(required.map(|difference| Test { difference, strict: true }));
        AtomWay {
            number,
            place,
            parts,
            identities,
            graph: self.graph,
            tests,
            unknowns: self.unknowns,
            kinds: self.kinds,
            made: self.constants.made(),
            relations: self.relations,
            tokens,
        }
    }
}

impl AtomWay {
    /// All that it is made of.
    pub(super) fn used(&self) -> Deps {
        let tests = self.tests.iter().map(|test| test.difference);
        let all = self.place.iter().copied().chain(tests);
        all.fold(0, |all, id| all | self.graph.deps(id))
    }
}

/// `Mixed::Continuous(x)`, or `Mixed::Atom(number, x)`.
pub(super) fn marked(body: &mut Body, call: &ExprCall, arguments: &[&Expr]) -> Option<Value> {
    let (number, point) = match *arguments {
        [point] => (None, point),
        [number, point] => match number {
            Expr::Lit(syn::ExprLit { lit: Lit::Int(n), .. }) => {
                (Some(n.base10_parse::<usize>().ok()?), point)
            }
            _ => return body.error(number, "the number of an atom is its name, which has to be known here: write a literal, as in `Mixed::Atom(0, wall)`"),
        },
        _ => return None,
    };
    let point = body.expr(point)?;
    Some(Value::Mixed(Mark { number, tokens: call.to_token_stream() }, Box::new(point)))
}

impl Body<'_> {
    /// Coordinates and identities of what a way through the body ends in, and the mark of an atom.
    #[allow(clippy::type_complexity)]
    pub(super) fn ending(
        &mut self,
        value: Value,
        signature: &Signature,
        block: &Block,
    ) -> Option<(Option<(Vec<Id>, Vec<TokenStream>)>, Option<(usize, TokenStream)>)> {
        let space = &signature.space;
        match value {
            Value::Nothing => Some((None, None)),
            Value::Mixed(Mark { number: Some(number), tokens }, place) if signature.mixed => {
                let point = self.coordinates(&place, space, block)?;
                if point.0.iter().any(|c| self.graph.has(*c, UNKNOWNS)) {
                    return self.error(tokens, "an atom is a single point, so where it lies depends on parameters alone, and this depends on what is sampled: write `Mixed::Continuous(…)` for a point that has a density");
                }
                Some((Some(point), Some((number, tokens))))
            }
            Value::Mixed(_, point) if signature.mixed => {
                Some((Some(self.outputs(&point, space, block)?), None))
            }
            _ if signature.mixed => {
                let at = block.stmts.last().map(ToTokens::to_token_stream).unwrap_or_default();
                self.error(at, "the signature promises a `Mixed` point, so every way through the body says whether it ends in an atom: write `Mixed::Continuous(x)` for a point that has a density, and `Mixed::Atom(0, x)` for one that is reached with a probability")
            }
            value => Some((Some(self.outputs(&value, space, block)?), None)),
        }
    }
}
