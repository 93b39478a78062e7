//! Equations that are fixed linear combinations of simpler ones.
//!
//! X = 2f + h/2 and Y = 3h - 3f/2 with sums f and h are what a scaled and sheared point (f, h) leads
//! to. Terms of f occur in both equations in one ratio, those of h in another: that is how f and h are
//! found again, however many terms and unknowns they have.

use super::{Equation, State};
use crate::display::show;
use crate::expr::{Graph, Id, Node};
use crate::rational::Q;
use crate::rational::matrix::inverse;
use crate::sorted;

/// Terms that have the same coefficients up to a factor, and these coefficients, an equation each.
struct Group {
    column: Vec<Q>,
    terms: Vec<(Q, Id)>,
}

/// The equations with sets of them taken apart; `None` if there is nothing to take apart.
pub(super) fn decoupled(g: &mut Graph, state: &State) -> Option<State> {
    let rows: Vec<(Q, Vec<(Q, Id)>)> = state.equations.iter().map(|e| terms(g, e.rhs)).collect();
    let groups = groups(&rows)?;
    let mut next = state.clone();
    let mut found = false;
    for first in 0..rows.len() {
        let (members, own) = component(first, &groups);
        if members[0] != first || members.len() < 2 || own.len() != members.len() {
            continue;
        }
        let matrix: Vec<Vec<Q>> =
            members.iter().map(|&m| own.iter().map(|&k| groups[k].column[m]).collect()).collect();
        let Some(inverse) = inverse(&matrix) else { continue };
        for (i, row) in inverse.iter().enumerate() {
            let mut sum = Vec::new();
            for (&m, q) in members.iter().zip(row) {
                let constant = g.number(rows[m].0);
                let known = g.sub(state.equations[m].known, constant);
                sum.push((*q, known));
            }
            let known = g.sum(Q::ZERO, &sum);
            let rhs = g.sum(Q::ZERO, &groups[own[i]].terms);
            let step = format!("decoupled: {} = {}", show(g, rhs), show(g, known));
            next.solution.steps.push(step);
            next.solution.known.entry(rhs).or_insert(known);
            next.equations[members[i]] = Equation { known, rhs, modulo_turn: false };
        }
        found = true;
    }
    found.then_some(next)
}

/// The constant and the terms of a sum; anything else is a sum of one term.
fn terms(g: &mut Graph, id: Id) -> (Q, Vec<(Q, Id)>) {
    match g.node(id).clone() {
        Node::Sum(c, terms) => (c, terms),
        _ => {
            let (q, body) = g.split(id);
            (Q::ZERO, vec![(q, body)])
        }
    }
}

/// All terms by the ratio of their coefficients.
fn groups(rows: &[(Q, Vec<(Q, Id)>)]) -> Option<Vec<Group>> {
    let mut columns: Vec<(Id, Vec<Q>)> = Vec::new();
    for (i, (_, terms)) in rows.iter().enumerate() {
        for (q, t) in terms {
            let place = columns.iter().position(|(u, _)| u == t).unwrap_or_else(|| {
                columns.push((*t, vec![Q::ZERO; rows.len()]));
                columns.len() - 1
            });
            columns[place].1[i] = *q;
        }
    }
    let mut groups: Vec<Group> = Vec::new();
    for (term, column) in columns {
        let pivot = column.iter().position(|q| !q.is_zero())?;
        let scale = column[pivot];
        let column: Option<Vec<Q>> = column.iter().map(|q| q.mul(scale.recip()?)).collect();
        let column = column?;
        match groups.iter_mut().find(|group| group.column == column) {
            Some(group) => group.terms.push((scale, term)),
            None => groups.push(Group { column, terms: vec![(scale, term)] }),
        }
    }
    Some(groups)
}

/// The equations that share groups with equation `first`, directly or through others, and these groups.
fn component(first: usize, groups: &[Group]) -> (Vec<usize>, Vec<usize>) {
    let (mut members, mut own) = (vec![first], Vec::new());
    loop {
        let before = own.len();
        for (k, group) in groups.iter().enumerate() {
            let rows = |i: &usize| !group.column[*i].is_zero();
            if !own.contains(&k) && members.iter().any(rows) {
                own.push(k);
                let all = (0..group.column.len()).filter(rows);
                members.extend(all.filter(|i| !members.contains(i)).collect::<Vec<_>>());
            }
        }
        if own.len() == before {
            sorted::sort(&mut members);
            return (members, own);
        }
    }
}
