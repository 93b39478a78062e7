//! Bodies in two steps: from the uniforms to some of the numbers that the body names, and from these to the point.
//!
//! Expressions are kept in a canonical form, in which the names of the body are gone: where `a` is the product r cos φ,
//! `a * a` is r² cos² φ. What a name says is read once more where the inverse is not found without it: a name of the body,
//! or one that it could have (`shared.rs`).

use std::collections::BTreeMap;

use syn::{FnArg, Ident, ItemFn, Stmt};

use super::way::Way;
use super::{Options, Parsed, Reader, Reading, Segment};
use crate::diagnostics::Diagnostics;
use crate::expr::{Graph, Id, Leaf, Node, children, leaf_bit};
use crate::jacobian::{factor_out, simplify};
use crate::matrix::dot;
use crate::rational::Q;
use crate::walk::{self, Look};

/// The first unknown that stands for a named number.
const FIRST: u8 = 10;
/// Steps that are tried, and the most names in one.
const MOST: usize = 3;
const MOST_NAMES: usize = 2;
/// Readings of the body that are tried, and the last names that are taken for them.
const MOST_READ: usize = 8;
const LAST_NAMES: usize = 100;

/// The first parameter that stands for a coordinate of a named vector: beyond those that an item may have.
pub(super) const FIRST_CONSTANT: u8 = 66;

/// What is read as inputs of their own: names of numbers, with the first unknown that stands for one, and of three
/// vectors that are a frame.
#[derive(Clone, Debug, Default)]
pub(super) struct Cut {
    pub(super) numbers: Vec<String>,
    pub(super) first: u8,
    pub(super) frame: Vec<String>,
}

/// A body in two steps.
pub struct Stage {
    /// The output coordinates in terms of the named numbers.
    pub outputs: Vec<Id>,
    /// These, as unknowns, and what they are in terms of the uniforms and of the ones before.
    pub named: Vec<(Leaf, Id)>,
    /// Three vectors of parameters that are a frame, by columns of inputs of their own.
    pub frame: Option<[[Id; 3]; 3]>,
    /// These inputs, and what they are in terms of the parameters and of the ones before.
    pub constants: Vec<(Leaf, Id)>,
}

/// The ways to take apart the body of an item on the way of a piece that ends of uniforms and parameters alone decide about, the
/// last names first.
pub fn stages(item: &ItemFn, parsed: &mut Parsed, number: usize, options: &Options) -> Vec<Stage> {
    let Parsed { signature, pieces, making, .. } = parsed;
    let making = *making;
    let piece = &mut pieces[number];
    let count = piece.problem.unknowns.len();
    if !piece.problem.guards.is_empty() || !(1..=MOST_NAMES).contains(&count) {
        return vec![];
    }
    let way = || piece.way.again(vec![]);
    let ends: Vec<Option<(Segment, &Graph)>> =
        piece.ends.iter().map(|end| end.map(|end| (end, &piece.graph))).collect();
    let mut errors = Diagnostics::new();
    let mut reader = Reader { item, signature, options, making, errors: &mut errors };
    let Some(plain) = reader.read(Graph::new(), (way(), &ends), Cut::default()) else {
        return vec![];
    };
    let frame = frame(&mut reader, &way, &plain.vectors);
    let all: Vec<String> = plain.scalars;
    let unique: Vec<&String> =
        all.iter().filter(|name| all.iter().filter(|n| n == name).count() == 1).collect();
    let uniforms = piece.problem.unknowns.iter().fold(0, |bits, leaf| bits | leaf_bit(*leaf));
    let mut found: Vec<Stage> = Vec::new();
    let Some(uses) = Uses::of(item) else { return vec![] };
    let numbers: Vec<usize> = unique.iter().filter_map(|name| uses.number(name)).collect();
    for cut in uses.whole(choices(&numbers, count)).take(MOST_READ) {
        if found.len() == MOST {
            break;
        }
        let first = FIRST + (found.len() * MOST_NAMES) as u8;
        let graph = std::mem::take(&mut piece.problem.graph);
        let numbers = cut.iter().map(|&name| uses.names[name].clone()).collect();
        let cut = Cut { numbers, first, frame: frame.clone() };
        let Some(reading) = reader.read(graph, (way(), &ends), cut) else { break };
        piece.problem.graph = reading.graph;
        let g = &mut piece.problem.graph;
        let Some((outputs, _)) = reading.point else { break };
        let closed = outputs.iter().all(|o| !g.has(*o, uniforms));
        let is_leaf = |id: Id| piece.problem.unknowns.iter().any(|l| g.is_leaf(id, *l));
        let named = reading.cuts;
        if closed && !named.iter().any(|(_, id)| is_leaf(*id)) {
            let constants = reading.constants_cut;
            let mut values = BTreeMap::new();
            for (leaf, value) in &constants {
                let spelled = g.substitute(*value, &values);
                let value = roots_of_products(g, spelled);
                values.insert(g.get_leaf(*leaf), value);
            }
            let constants: Vec<(Leaf, Id)> =
                constants.into_iter().map(|(leaf, _)| (leaf, values[&g.get_leaf(leaf)])).collect();
            let leaves: Vec<Id> = constants.iter().map(|(leaf, _)| g.get_leaf(*leaf)).collect();
            let frame = <[[Id; 3]; 3]>::try_from(columns(&leaves)).ok();
            found.push(Stage { outputs, named, frame, constants });
        }
    }
    found
}

/// The names of three vectors of parameters that are perpendicular to each other and have unit length, if there are
/// any: the first known to be so by itself, the others as what they are in terms of the first.
fn frame(
    reader: &mut Reader,
    way: &impl Fn() -> Way,
    vectors: &[(String, [Id; 3])],
) -> Vec<String> {
    for (i, (name, _)) in vectors.iter().enumerate() {
        let cut = Cut { frame: vec![name.clone()], ..Cut::default() };
        let Some(reading) = reader.read(Graph::new(), (way(), &[]), cut) else { break };
        let Reading { mut graph, vectors, constants_cut, .. } = reading;
        let g = &mut graph;
        let leaves: Vec<Id> = constants_cut.iter().map(|(leaf, _)| g.get_leaf(*leaf)).collect();
        let &[x, y, z] = &leaves[..] else { break };
        let mut is = |a: &[Id; 3], b: &[Id; 3], value: i64, unit: Option<[Id; 3]>| {
            let product = dot(g, a, b);
            let product = simplify(g, product, unit);
            g.as_number(product) == Some(Q::int(value))
        };
        let (first, unit) = ([x, y, z], Some([x, y, z]));
        if !is(&vectors[i].1, &vectors[i].1, 1, None) {
            continue;
        }
        let later = &vectors[i + 1..];
        let across: Vec<&(String, [Id; 3])> =
            later.iter().filter(|(_, v)| is(&first, v, 0, unit) && is(v, v, 1, unit)).collect();
        for (j, b) in across.iter().enumerate() {
            if let Some(c) = across[j + 1..].iter().find(|c| is(&b.1, &c.1, 0, unit)) {
                return vec![name.clone(), b.0.clone(), c.0.clone()];
            }
        }
    }
    vec![]
}

/// An expression whose roots are those of products where the terms under them have a common factor.
fn roots_of_products(g: &mut Graph, id: Id) -> Id {
    let mut sums = BTreeMap::new();
    let mut open = vec![id];
    while let Some(id) = open.pop() {
        if let Node::Product(factors) = g.node(id).clone() {
            for (base, exponent) in factors {
                let is_root = g.as_number(exponent).is_some_and(|q| q.den() == 2);
                if is_root && matches!(g.node(base), Node::Sum(..)) {
                    sums.insert(base, factor_out(g, base));
                }
            }
        }
        open.extend(children(g.node(id)));
    }
    g.substitute(id, &sums)
}

/// Which names the statements of a body bind, and which they mention; the last one is the result.
struct Uses {
    statements: Vec<(Vec<usize>, Vec<usize>)>,
    names: Vec<String>,
}

impl Uses {
    /// Of a body that is a list of bindings and an expression. The first name is that of the uniforms.
    fn of(item: &ItemFn) -> Option<Uses> {
        let Some(FnArg::Typed(uniforms)) = item.sig.inputs.first() else { return None };
        let mut mentioned = Mentioned::default();
        walk::pat(&mut mentioned, &uniforms.pat);
        let mut statements = Vec::new();
        for statement in &item.block.stmts {
            // What items say does not depend on names of the body.
            if let Stmt::Item(_) = statement {
                continue;
            }
            let bound = match statement {
                Stmt::Local(local) => mentioned.in_part(|m| walk::pat(m, &local.pat)),
                _ => vec![],
            };
            let used = match statement {
                Stmt::Local(local) => {
                    let init = local.init.as_ref()?;
                    mentioned.in_part(|m| walk::expr(m, &init.expr))
                }
                Stmt::Expr(result, _) => mentioned.in_part(|m| walk::expr(m, result)),
                _ => return None,
            };
            statements.push((bound, used));
        }
        Some(Uses { statements, names: mentioned.names })
    }

    /// The number of a name.
    fn number(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// Those cuts through which the result has all that it has of the uniforms.
    fn whole(&self, cuts: Vec<Vec<usize>>) -> impl Iterator<Item = Vec<usize>> {
        // A way past one cut leads past all that have none of its names: few ways rule out most cuts.
        let mut known: Vec<Vec<usize>> = Vec::new();
        cuts.into_iter().filter(move |cut| {
            let passes = |way: &Vec<usize>| !way.iter().any(|name| cut.contains(name));
            if known.iter().any(passes) {
                return false;
            }
            let past = self.way_past(cut);
            known.extend(past.clone());
            past.is_none()
        })
    }

    /// Names by which the result has something of the uniforms, none of them of the cut.
    fn way_past(&self, cut: &[usize]) -> Option<Vec<usize>> {
        /// Whom a name is needed for.
        #[derive(Clone, Copy)]
        enum Needed {
            Not,
            ByResult,
            By(usize),
        }
        let mut needed = vec![Needed::Not; self.names.len()];
        let last = self.statements.len().saturating_sub(1);
        for (i, (bound, used)) in self.statements.iter().enumerate().rev() {
            let is_needed = |name: &&usize| !matches!(needed[**name], Needed::Not);
            let by = match bound.iter().filter(|name| !cut.contains(name)).find(is_needed) {
                Some(name) => Needed::By(*name),
                None if i == last => Needed::ByResult,
                None => continue,
            };
            for &name in used {
                if let Needed::Not = needed[name] {
                    needed[name] = by;
                }
            }
        }
        let (mut way, mut at) = (Vec::new(), *needed.get(UNIFORMS)?);
        while let Needed::By(name) = at {
            way.push(name);
            at = needed[name];
        }
        matches!(at, Needed::ByResult).then_some(way)
    }
}

/// The number of the name of the uniforms.
const UNIFORMS: usize = 0;

/// Names that occur, each once, and the places of those in the part that is looked at.
#[derive(Default)]
struct Mentioned {
    names: Vec<String>,
    part: Vec<usize>,
}

impl Mentioned {
    fn in_part(&mut self, visit: impl FnOnce(&mut Self)) -> Vec<usize> {
        self.part.clear();
        visit(self);
        std::mem::take(&mut self.part)
    }
}

impl Look for Mentioned {
    fn name(&mut self, name: &Ident) {
        let known = self.names.iter().position(|n| name == n);
        self.part.push(known.unwrap_or(self.names.len()));
        if known.is_none() {
            self.names.push(name.to_string());
        }
    }
}

/// Vectors of which these are the coordinates.
fn columns(coordinates: &[Id]) -> Vec<[Id; 3]> {
    coordinates.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
}

/// Sets of so many names, the last first.
fn choices(names: &[usize], count: usize) -> Vec<Vec<usize>> {
    let last = (names.len().saturating_sub(LAST_NAMES)..names.len()).rev();
    if count == 1 {
        return last.map(|i| vec![names[i]]).collect();
    }
    let pairs = last.flat_map(|i| (0..i).rev().map(move |j| vec![names[j], names[i]]));
    pairs.collect()
}
