//! What has no closed form: the last rules before the search is given up.
//!
//! An equation in one unknown whose side is proven to increase with it has one root, which is found
//! numerically. A system in which a single nonlinear function of a linear combination stands in the way
//! is brought to one such equation first.

use super::peel::unwind_turns;
use super::{Condition, Equation, Numerical, State, linear};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Graph, Id, Leaf, Node, Root, UNKNOWNS, children};
use crate::hash::Set;
use crate::interval::Interval;
use crate::matrix::{dot, solve_matrix};
use crate::monotone::{Unproven, direction};
use crate::rational::Q;
use crate::sorted;

/// Auxiliary unknowns beyond this one have no bit of their own.
const MAX_NAMES: u8 = 24;

/// body(t) = known gives t, for an equation in the single unknown t; the reason if it cannot be shown
/// that there is one root.
pub(super) fn monotone(g: &mut Graph, state: &State) -> Result<Vec<State>, Option<String>> {
    let mut reason = None;
    for (i, unknown) in single_unknowns(g, state) {
        match in_one_variable(g, state, i, unknown) {
            Ok(next) => return Ok(vec![next]),
            Err(unproven) => {
                reason.get_or_insert_with(|| explain(g, &state.equations[i], unknown, &unproven));
            }
        }
    }
    Err(reason)
}

/// The equations in a single unknown, by their numbers, with it.
pub(super) fn single_unknowns(g: &Graph, state: &State) -> Vec<(usize, Leaf)> {
    let unknown = |(i, e): (usize, &Equation)| {
        let open = g.deps(e.rhs) & UNKNOWNS;
        let single = open.count_ones() == 1 && !e.modulo_turn;
        single.then(|| (i, Leaf::Unknown(open.trailing_zeros() as u8)))
    };
    state.equations.iter().enumerate().filter_map(unknown).collect()
}

/// Solves one equation for the innermost expression that its unknown occurs in only once, which is
/// further undone in closed form: z = ln u - ln(1 - u) is known to full precision where u is close to
/// one. For the unknown itself if the equation is not monotone in that expression.
fn in_one_variable(
    g: &mut Graph,
    state: &State,
    i: usize,
    unknown: Leaf,
) -> Result<State, Unproven> {
    let e = state.equations[i].clone();
    let leaf = g.get_leaf(unknown);
    let inner = innermost(g, e.rhs, leaf);
    let attempt = inner.and_then(|inner| {
        let s = solved_for(g, state, i, inner).ok()?;
        Some(s)
    });
    attempt.map_or_else(|| solved_for(g, state, i, leaf), Ok)
}

/// The smallest part, other than the unknown itself and all of `rhs`, without which the unknown would
/// not occur.
pub(super) fn innermost(g: &mut Graph, rhs: Id, leaf: Id) -> Option<Id> {
    let open = g.deps(leaf);
    let mut parts = Vec::new();
    let mut queue = vec![rhs];
    while let Some(id) = queue.pop() {
        if id != leaf && g.has(id, open) && !parts.contains(&id) {
            parts.push(id);
            queue.extend(children(g.node(id)));
        }
    }
    parts.retain(|p| *p != rhs);
    sorted::sort_by_key(&mut parts, |p| crate::jacobian::cost(g, *p));
    // A name, not zero: a product with zero would say that nothing else is left.
    let name = g.leaf(Leaf::Unknown(23), "t", Interval::ALL);
    parts.into_iter().find(|&p| {
        let without = g.substitute(rhs, &[(p, name)].into());
        !g.has(without, open)
    })
}

/// The side of an equation as a function of a bound variable.
pub(super) struct Bound {
    /// The variable.
    pub(super) variable: Leaf,
    /// The function.
    pub(super) body: Id,
    /// The same in which what is known of other unknowns is these again, whose ranges are known.
    pub(super) restored: Id,
}

/// The side of equation `i` as a function of the expression `z`.
pub(super) fn bind(g: &mut Graph, state: &State, i: usize, z: Id) -> Result<Bound, Unproven> {
    let rhs = state.equations[i].rhs;
    let name = if let Node::Leaf(l) = g.node(z) { g.name(*l).to_owned() } else { "t".to_owned() };
    let range = g.range(z);
    let taken = g.bound_bits(rhs);
    let too_many = Unproven { place: "an equation within an equation".into(), unbounded: None };
    let variable = g.bound_variable(taken, &name, range).ok_or(too_many)?;
    let bound = g.get_leaf(variable);
    let body = g.substitute(rhs, &[(z, bound)].into());
    // A solved unknown of the same point lies in its range if the point is one of the map's.
    let solved: Vec<_> = state.solution.unknowns.iter().map(|(l, v)| (*l, *v)).collect();
    let back = sorted::map(solved.into_iter().map(|(l, v)| (v, g.get_leaf(l))));
    let restored = g.substitute(body, &back);
    Ok(Bound { variable, body, restored })
}

/// The state in which equation `i` is solved for the expression `z`.
fn solved_for(g: &mut Graph, state: &State, i: usize, z: Id) -> Result<State, Unproven> {
    let e = state.equations[i].clone();
    let range = g.range(z);
    let Bound { variable, body, restored } = bind(g, state, i, z)?;
    let sign = direction(g, restored, variable)?;
    let [body, target] = [body, e.known].map(|id| g.sum(Q::ZERO, &[(Q::int(sign), id)]));
    let slope = derivative(g, body, variable);
    let [lo, hi] = [range.lo, range.hi].map(|x| end(g, x));
    let root = g.root(Root { variable, body, slope, target, lo, hi, inside: false, folds: false });
    let mut s = state.clone();
    s.equations[i] = Equation { known: root, rhs: z, modulo_turn: false };
    s.solution.known.entry(e.rhs).or_insert(e.known);
    s.solution.known.entry(z).or_insert(root);
    let (known, rhs, z) = (show(g, e.known), show(g, e.rhs), show(g, z));
    s.solution.steps.push(format!("{known} = {rhs} is monotone in {z}: solved numerically"));
    Ok(s)
}

pub(super) fn end(g: &mut Graph, x: f64) -> Id {
    if x == 0.0 || x == 1.0 { g.int(x as i64) } else { g.float(x) }
}

fn explain(g: &Graph, e: &Equation, unknown: Leaf, why: &Unproven) -> String {
    let way = match &why.unbounded {
        Some(p) => format!("declare a domain of `{p}` in which it is monotone, as in `#[sampler({p} in 0.0..=10.0)]`"),
        None => "narrow the domains of the parameters, or write one sampler for each piece on which the map is monotone".to_owned(),
    };
    format!(
        "`{}` has no closed inverse, and a numerical one needs a proof that it always increases or always decreases with {}: there is none for {}. If it does, {way}",
        show(g, e.rhs),
        g.name(unknown),
        why.place
    )
}

/// A root that was sampled: known = root(body = target) gives body(known) = target.
pub(super) fn undo_root(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for (i, e) in state.equations.iter().enumerate() {
        let Node::Root(r) = g.node(e.rhs).clone() else { continue };
        // An angle is the root within its range, before its body is more than an angle.
        let found = match e.modulo_turn {
            true => unwind_turns(g, e.known, e.rhs)?.1.into_iter().map(|i| i.known).collect(),
            false => vec![e.known],
        };
        let undone = found.into_iter().map(|known| root_undone(g, state, i, &r, known));
        return Some(undone.collect());
    }
    None
}

/// The state in which equation `i` says of a root that it is known.
fn root_undone(g: &mut Graph, state: &State, i: usize, r: &Root, value: Id) -> State {
    let mut s = state.clone();
    let variable = g.get_leaf(r.variable);
    let body = g.substitute(r.body, &[(variable, value)].into());
    let (known, rhs) = (g.int(0), g.sub(r.target, body));
    let root = std::mem::replace(&mut s.equations[i], Equation { known, rhs, modulo_turn: false });
    let infinite =
        |g: &Graph, id| matches!(g.node(id), Node::Float(x) if f64::from_bits(*x).is_infinite());
    for (a, b) in [(value, r.lo), (r.hi, value)] {
        if !infinite(g, a) && !infinite(g, b) {
            s.solution.conditions.push(Condition(g.sub(a, b)));
        }
    }
    s.solution.known.entry(root.rhs).or_insert(value);
    s.solution.steps.push(format!("{} = {}", show(g, r.target), show(g, body)));
    s
}

/// X_i = Σ_k M_ik z_k + β_i f(Σ w_k z_k), linear in the atoms z but for one function f of a linear
/// combination of them.
///
/// Solving for z as if f were known gives z = p + q f, and with s = Σ w_k z_k one equation in one unknown:
/// s - (w · q) f(s) = w · p.
pub(super) fn coupled(g: &mut Graph, state: &State, frames: &[[[Id; 3]; 3]]) -> Option<Vec<State>> {
    if state.next_unknown >= MAX_NAMES {
        return None;
    }
    let rows: Vec<Option<linear::Row>> = state
        .equations
        .iter()
        .map(|e| if e.modulo_turn { None } else { linear::row(g, e.rhs, false) })
        .collect();
    for start in 0..rows.len() {
        let Some((members, atoms)) = linear::component(&rows, start) else { continue };
        if members.len() < 2 || atoms.len() != members.len() + 1 {
            continue;
        }
        for &f in &atoms {
            let z: Vec<Id> = atoms.iter().copied().filter(|a| *a != f).collect();
            let Some((l, weights)) = argument(g, f, &z) else { continue };
            let matrix: Vec<Vec<Id>> = members
                .iter()
                .map(|&i| {
                    let row = rows[i].as_deref().unwrap_or(&[]);
                    z.iter().map(|a| linear::coefficient(g, row, *a)).collect()
                })
                .collect();
            let known: Vec<Id> = members.iter().map(|&i| state.equations[i].known).collect();
            let minus: Vec<Id> = members
                .iter()
                .map(|&i| {
                    let c = linear::coefficient(g, rows[i].as_deref().unwrap_or(&[]), f);
                    g.neg(c)
                })
                .collect();
            let Some((p, _)) = solve_matrix(g, &matrix, &known, frames) else { continue };
            let Some((q, _)) = solve_matrix(g, &matrix, &minus, frames) else { continue };
            let along = Separated { f, l, weights, z, p, q };
            return Some(vec![along.name(g, state, &members)]);
        }
    }
    None
}

/// The linear combination of `z` that a nonlinear atom is a function of, with the weights of the `z`.
fn argument(g: &mut Graph, atom: Id, z: &[Id]) -> Option<(Id, Vec<Id>)> {
    let (mut open, mut seen) = (vec![atom], Set::default());
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        if let Node::Sum(_, terms) = g.node(id).clone() {
            let linear = g.sum(Q::ZERO, &terms);
            let row = linear::row(g, linear, false)?;
            let own: Vec<Id> =
                row.iter().map(|(_, a)| *a).filter(|a| g.has(*a, UNKNOWNS)).collect();
            if own.len() >= 2 && own.iter().all(|a| z.contains(a)) {
                let weights = z.iter().map(|a| linear::coefficient(g, &row, *a)).collect();
                return Some((id, weights));
            }
        }
        open.extend(children(g.node(id)).into_iter().filter(|c| g.has(*c, UNKNOWNS)));
    }
    None
}

/// z = p + q f(l), where l is a combination of the z with these weights, and something known.
struct Separated {
    f: Id,
    l: Id,
    weights: Vec<Id>,
    z: Vec<Id>,
    p: Vec<Id>,
    q: Vec<Id>,
}

impl Separated {
    /// The state with l as an unknown of its own.
    fn name(&self, g: &mut Graph, state: &State, members: &[usize]) -> State {
        let mut s = state.clone();
        let leaf = Leaf::Unknown(s.next_unknown);
        s.next_unknown += 1;
        let unknown = g.leaf(leaf, "s", Interval::ALL);
        if s.numerical == Numerical::Pieces {
            // A wave turns back for ever, but not where it is needed.
            let range = g.range(self.l);
            g.assume(unknown, range);
        }
        let of_s = g.substitute(self.f, &[(self.l, unknown)].into());
        let mut k = 0;
        s.equations.retain(|_| {
            k += 1;
            !members.contains(&(k - 1))
        });
        let [of_z, of_p, of_q] = [&self.z, &self.p, &self.q].map(|v| dot(g, &self.weights, v));
        let constant = g.sub(self.l, of_z);
        let known = g.add(of_p, constant);
        let along = crate::jacobian::simplify(g, of_q, None);
        let part = g.mul(along, of_s);
        let rhs = g.sub(unknown, part);
        let step = format!("with s = {}: {} = {}", show(g, self.l), show(g, known), show(g, rhs));
        s.equations.push(Equation { known, rhs, modulo_turn: false });
        for ((&atom, &p), &q) in self.z.iter().zip(&self.p).zip(&self.q) {
            let part = g.mul(q, of_s);
            let rhs = g.sub(atom, part);
            s.equations.push(Equation { known: p, rhs, modulo_turn: false });
        }
        s.solution.known.insert(self.l, unknown);
        s.solution.known.insert(self.f, of_s);
        s.solution.steps.push(step);
        s
    }
}
