//! Parts of an expression that a solution knows as a whole.

use std::collections::BTreeMap;

use crate::expr::{Graph, Id, Node};
use crate::jacobian::cost;
use crate::sorted;

/// An expression with what a solution knows of more than single unknowns put in, the longest first:
/// it must be done while the unknowns that it is recognised by are there. It may also be recognised by its powers, which
/// is another form if there are any.
pub(super) fn recognised(g: &mut Graph, written: Id, known: &BTreeMap<Id, Id>) -> Vec<Id> {
    let mut composed = known.clone();
    composed.retain(|id, _| !matches!(g.node(*id), Node::Leaf(_)));
    let mut longest: Vec<(Id, Id)> = composed.iter().map(|(part, value)| (*part, *value)).collect();
    sorted::sort_by_key(&mut longest, |(part, _)| std::cmp::Reverse(cost(g, *part)));
    let mut forms = Vec::new();
    for by in [Graph::replace_part, Graph::replace_powers] {
        let mut id = written;
        // What one replacement uncovers another may know.
        for _ in 0..2 {
            for &(part, value) in &longest {
                id = by(g, id, part, value);
            }
            id = g.substitute(id, &composed);
        }
        forms.push(id);
    }
    forms.dedup();
    forms
}
