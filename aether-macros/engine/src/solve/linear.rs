//! Linear systems whose unknowns are whole subexpressions (atoms).

use super::{Equation, State};
use crate::display::show;
use crate::expr::{Graph, Id, Node, UNKNOWNS};
use crate::jacobian::cost;
use crate::matrix::{dot, solve_matrix};
use crate::poly::{Expander, RatFun, relation};
use crate::rational::Q;
use crate::sorted;

/// A linear equation: Σ coefficient · atom, coefficients known.
pub(super) type Row = Vec<(Id, Id)>;

/// Finds equations that form a linear system in at most as many atoms, and solves it.
pub(crate) fn linear_system(
    g: &mut Graph,
    state: &State,
    frames: &[[[Id; 3]; 3]],
) -> Option<Vec<State>> {
    let zero = g.int(0);
    for expand in [false, true] {
        let rows: Vec<Option<Row>> = state
            .equations
            .iter()
            .map(|e| if e.modulo_turn { None } else { row(g, e.rhs, expand) })
            .collect();
        for start in 0..rows.len() {
            let Some((members, mut atoms)) = component(&rows, start) else { continue };
            // It has been looked at from its first equation.
            if members[0] != start {
                continue;
            }
            // Weights that add up to one are no independent atoms: of the corners of a triangle they are no three.
            let dependent = dependent(g, &atoms);
            if let Some(dependent) = &dependent {
                atoms.remove(dependent.place);
            }
            if atoms.len() > members.len()
                || members.iter().all(|&i| rows[i].as_ref().is_some_and(|r| r.len() < 2))
            {
                continue;
            }
            let mut matrix: Vec<Vec<Id>> = members
                .iter()
                .map(|&i| {
                    atoms
                        .iter()
                        .map(|a| coefficient(g, rows[i].as_deref().unwrap_or(&[]), *a))
                        .collect()
                })
                .collect();
            let mut known: Vec<Id> = members.iter().map(|&i| state.equations[i].known).collect();
            if let Some(dependent) = &dependent {
                for ((row, known), i) in matrix.iter_mut().zip(&mut known).zip(&members) {
                    let own = coefficient(g, rows[*i].as_deref().unwrap_or(&[]), dependent.atom);
                    dependent.put_into(g, own, (row, known));
                }
            }
            // A homogeneous system says how its atoms are related, not that all of them are zero.
            if known.iter().all(|k| *k == zero) {
                continue;
            }
            let Some((values, unused)) = solve_matrix(g, &matrix, &known, frames) else { continue };
            let mut next = replace(g, state, &members, &atoms, &values, &unused);
            if is_turned(g, &matrix, &known, &values)
                && g.units().iter().any(|u| u[..] == known[..])
            {
                let squares: Vec<(Q, Id)> =
                    atoms.iter().map(|&atom| (Q::ONE, g.powi(atom, 2))).collect();
                let (length, one) = (g.plain_sum(&squares), g.int(1));
                next.equations.retain(|e| e.modulo_turn || (e.rhs, e.known) != (length, one));
            }
            return Some(vec![next]);
        }
    }
    None
}

/// An atom that is a sum of multiples of others and of a number.
struct Dependent {
    /// Its place among the atoms.
    place: usize,
    atom: Id,
    /// The multiples of the others, in their order, and the number.
    multiples: Vec<Q>,
    constant: Q,
}

impl Dependent {
    /// Writes a row of a matrix, of which the atom has this coefficient, and what it gives in terms of the others.
    fn put_into(&self, g: &mut Graph, own: Id, (row, known): (&mut [Id], &mut Id)) {
        let zero = g.int(0);
        if own == zero {
            return;
        }
        for (entry, &q) in row.iter_mut().zip(&self.multiples) {
            *entry = g.sum(Q::ZERO, &[(Q::ONE, *entry), (q, own)]);
        }
        *known = g.sum(Q::ZERO, &[(Q::ONE, *known), (self.constant.neg(), own)]);
    }
}

/// The longest of some atoms that others add up to, if there is a single such relation.
fn dependent(g: &mut Graph, atoms: &[Id]) -> Option<Dependent> {
    let is_sum = |id: &Id| matches!(g.node(*id), Node::Sum(..));
    if atoms.len() < 2 || !atoms.iter().any(is_sum) {
        return None;
    }
    let costs: Vec<usize> = atoms.iter().map(|&atom| cost(g, atom)).collect();
    let mut e = Expander::new(g).only(UNKNOWNS);
    let mut columns = atoms.iter().map(|&a| e.expand(a)).collect::<Option<Vec<RatFun>>>()?;
    columns.push(RatFun::one());
    let k = relation(&mut e, &columns)?;
    let (last, k) = k.split_last()?;
    let open = (0..atoms.len()).filter(|&i| !k[i].is_zero());
    let place = open.max_by_key(|&i| costs[i])?;
    let scale = k[place].recip()?.neg();
    let others = k.iter().enumerate().filter(|(i, _)| *i != place);
    let multiples = others.map(|(_, q)| q.mul(scale)).collect::<Option<Vec<Q>>>()?;
    Some(Dependent { place, atom: atoms[place], multiples, constant: last.mul(scale)? })
}

/// Whether the transpose of a matrix has solved a system: then it is a frame, and what is found is as long as what is known.
fn is_turned(g: &mut Graph, matrix: &[Vec<Id>], known: &[Id], values: &[Id]) -> bool {
    matrix.len() == values.len()
        && values.iter().enumerate().all(|(j, &value)| {
            let column: Vec<Id> = matrix.iter().map(|row| row[j]).collect();
            dot(g, &column, known) == value
        })
}

fn replace(
    g: &mut Graph,
    state: &State,
    members: &[usize],
    atoms: &[Id],
    values: &[Id],
    unused: &[usize],
) -> State {
    let mut s = state.clone();
    for (i, e) in state.equations.iter().enumerate() {
        if members.contains(&i)
            && (unused.is_empty() || unused.contains(&i))
            && members.len() > atoms.len()
        {
            s.solution.unused.push((e.known, e.rhs));
        }
    }
    let mut k = 0;
    s.equations.retain(|_| {
        k += 1;
        !members.contains(&(k - 1))
    });
    for (&atom, &value) in atoms.iter().zip(values) {
        s.solution.steps.push(format!("linear system: {} = {}", show(g, atom), show(g, value)));
        s.solution.known.entry(atom).or_insert(value);
        s.equations.push(Equation { known: value, rhs: atom, modulo_turn: false });
    }
    s
}

/// Writes an expression as a linear combination of atoms, multiplied out if asked.
pub(super) fn row(g: &mut Graph, id: Id, expand: bool) -> Option<Row> {
    let terms: Vec<(Q, Id)> = match g.node(id).clone() {
        Node::Sum(c, terms) if c.is_zero() => terms,
        Node::Sum(..) => return None,
        _ => vec![(Q::ONE, id)],
    };
    let mut out: Row = Vec::new();
    for (q, t) in terms {
        let (known, open): (Vec<_>, Vec<_>) = g
            .factors(t)
            .into_iter()
            .partition(|(b, e)| !g.has(*b, UNKNOWNS) && !g.has(*e, UNKNOWNS));
        let factor = g.product(&known);
        let k = g.number(q);
        let factor = g.mul(k, factor);
        let atom = g.product(&open);
        let multiplied = if expand { multiply_out(g, atom)? } else { vec![(Q::ONE, atom)] };
        for (p, a) in multiplied {
            // Multiplied out, more of a term may be known.
            let (known, open): (Vec<_>, Vec<_>) = g
                .factors(a)
                .into_iter()
                .partition(|(b, e)| !g.has(*b, UNKNOWNS) && !g.has(*e, UNKNOWNS));
            let (known, a) = (g.product(&known), g.product(&open));
            let k = g.number(p);
            let k = g.mul(k, known);
            let c = g.mul(k, factor);
            match out.iter_mut().find(|(_, b)| *b == a) {
                Some((have, _)) => *have = g.add(*have, c),
                None => out.push((c, a)),
            }
        }
    }
    let zero = g.int(0);
    out.retain(|(c, _)| *c != zero);
    Some(out)
}

fn multiply_out(g: &mut Graph, atom: Id) -> Option<Vec<(Q, Id)>> {
    let r = Expander::new(g).expand(atom)?;
    if !r.den.is_empty() {
        return Some(multiply_out_sums(g, atom).unwrap_or_else(|| vec![(Q::ONE, atom)]));
    }
    let terms = r.num.terms(g);
    // A constant among the atoms would have to be known: leave such products alone.
    if terms.iter().any(|(_, t)| !g.has(*t, UNKNOWNS)) {
        Some(vec![(Q::ONE, atom)])
    } else {
        Some(terms)
    }
}

/// The same where only the sums among the factors are multiplied out, and what they are divided by stays.
fn multiply_out_sums(g: &mut Graph, atom: Id) -> Option<Vec<(Q, Id)>> {
    let one = g.int(1);
    let (sums, rest): (Vec<_>, Vec<_>) = g
        .factors(atom)
        .into_iter()
        .partition(|&(b, e)| e == one && matches!(g.node(b), Node::Sum(..)));
    let (sums, rest) = (g.product(&sums), g.product(&rest));
    let r = Expander::new(g).expand(sums).filter(|r| r.den.is_empty())?;
    let terms = r.num.terms(g);
    Some(terms.into_iter().map(|(q, t)| (q, g.mul(t, rest))).collect())
}

pub(super) fn coefficient(g: &mut Graph, row: &[(Id, Id)], atom: Id) -> Id {
    row.iter().find(|(_, a)| *a == atom).map_or_else(|| g.int(0), |(c, _)| *c)
}

/// The equations that share atoms with equation `start`, directly or through others.
pub(super) fn component(rows: &[Option<Row>], start: usize) -> Option<(Vec<usize>, Vec<Id>)> {
    let mut members = vec![start];
    let mut atoms: Vec<Id> = rows[start].as_ref()?.iter().map(|(_, a)| *a).collect();
    loop {
        let before = members.len();
        for (i, r) in rows.iter().enumerate() {
            let Some(r) = r else { continue };
            if !members.contains(&i) && r.iter().any(|(_, a)| atoms.contains(a)) {
                members.push(i);
                for (_, a) in r {
                    if !atoms.contains(a) {
                        atoms.push(*a);
                    }
                }
            }
        }
        if members.len() == before {
            sorted::sort(&mut members);
            return Some((members, atoms));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    #[test]
    fn a_direction_that_a_frame_has_turned_is_not_asked_for_its_length() {
        let derived = |text: &str| {
            Item::new(Default::default(), text.parse().unwrap(), false).unwrap().derived
        };
        for body in ["frame.to_world(w)", "frame.to_local(w)"] {
            let text = format!(
                "fn turned(w: Direction, frame: Frame) -> Direction {{ Direction::from_vec({body}) }}"
            );
            let [turned] = &derived(&text)[..] else { panic!("one piece") };
            assert!(turned.preimages[0].conditions.is_empty(), "{body}");
        }
        // Of any other matrix it has to be found out.
        let text = "fn stretched(w: Direction, s: f64) -> Surface {
            Surface::new(s * w.x, s * w.y, w.z)
        }";
        let [stretched] = &derived(text)[..] else { panic!("one piece") };
        let told = !stretched.preimages[0].conditions.is_empty() || stretched.check_forward;
        assert!(told);
    }
}
