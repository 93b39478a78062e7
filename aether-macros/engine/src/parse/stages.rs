//! Bodies in two steps: from the uniforms to some of the numbers that the body names, and from these to the point.
//!
//! Expressions are kept in a canonical form, in which the names of the body are gone: where `a` is the product r cos φ,
//! `a * a` is r² cos² φ. What a name says is read once more where the inverse is not found without it.

use syn::ItemFn;

use super::branch::Way;
use super::{Options, Parsed, Reader};
use crate::diagnostics::Diagnostics;
use crate::expr::{Graph, Id, Leaf, leaf_bit};

/// The first unknown that stands for a named number.
const FIRST: u8 = 10;
/// Steps that are tried, and the most names in one.
const MOST: usize = 3;
const MOST_NAMES: usize = 2;

/// A body in two steps.
pub struct Stage {
    /// The output coordinates in terms of the named numbers.
    pub outputs: Vec<Id>,
    /// These, as unknowns, and what they are in terms of the uniforms and of the ones before.
    pub named: Vec<(Leaf, Id)>,
}

/// The ways to take apart the body of an item without branches, the last names first.
pub fn stages(item: &ItemFn, parsed: &mut Parsed, options: &Options) -> Vec<Stage> {
    let Parsed { signature, pieces, .. } = parsed;
    let [piece] = &mut pieces[..] else { return vec![] };
    let count = piece.problem.unknowns.len();
    if !piece.tests.is_empty() || !(1..=MOST_NAMES).contains(&count) {
        return vec![];
    }
    let mut errors = Diagnostics::new();
    let mut reader = Reader { item, signature, options, errors: &mut errors };
    let Some(plain) = reader.read(Graph::new(), (Way::default(), &[]), (vec![], 0)) else {
        return vec![];
    };
    let all: Vec<String> = plain.scalars;
    let unique: Vec<&String> =
        all.iter().filter(|name| all.iter().filter(|n| n == name).count() == 1).collect();
    let uniforms = piece.problem.unknowns.iter().fold(0, |bits, leaf| bits | leaf_bit(*leaf));
    let mut found: Vec<Stage> = Vec::new();
    for names in choices(&unique, count) {
        if found.len() == MOST {
            break;
        }
        let first = FIRST + (found.len() * MOST_NAMES) as u8;
        let graph = std::mem::take(&mut piece.problem.graph);
        let Some(reading) = reader.read(graph, (Way::default(), &[]), (names, first)) else { break };
        piece.problem.graph = reading.graph;
        let g = &piece.problem.graph;
        let Some((outputs, _)) = reading.point else { break };
        let closed = outputs.iter().all(|o| !g.has(*o, uniforms));
        let is_leaf = |id: Id| piece.problem.unknowns.iter().any(|l| g.is_leaf(id, *l));
        let named = reading.cuts;
        if closed && !named.iter().any(|(_, id)| is_leaf(*id)) {
            found.push(Stage { outputs, named });
        }
    }
    found
}

/// Sets of so many names, the last first.
fn choices(names: &[&String], count: usize) -> Vec<Vec<String>> {
    let last = (0..names.len()).rev();
    if count == 1 {
        return last.map(|i| vec![names[i].clone()]).collect();
    }
    let pairs = last.flat_map(|i| (0..i).rev().map(move |j| (j, i)));
    pairs.map(|(j, i)| vec![names[j].clone(), names[i].clone()]).collect()
}
