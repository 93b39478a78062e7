//! Equations that are rational in one unknown or in one root of it.

use std::collections::BTreeMap;

use super::{Condition, Equation, State, scale};
use crate::derivative::derivative;
use crate::display::show;
use crate::expr::{Deps, Fun, Graph, Id, Leaf, Node, UNKNOWNS, children, leaf_bit};
use crate::interval::Interval;
use crate::jacobian::cost;
use crate::overflow::SAFE;
use crate::poly::{Expander, Poly, RatFun, coefficients, within_part_of_budget};
use crate::rational::Q;
use crate::sorted;

/// Solves an equation with a single unknown that occurs several times, if it is rational of degree
/// one or two in some subexpression.
pub(super) fn single_unknown(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    // Of several equations for one unknown, the one whose known side takes the least computing: it
    // has lost the least to rounding.
    let mut order: Vec<usize> = (0..state.equations.len()).collect();
    sorted::sort_by_key(&mut order, |&i| cost(g, state.equations[i].known));
    for i in order {
        let eq = state.equations[i].clone();
        let deps = g.deps(eq.rhs) & UNKNOWNS;
        if deps.count_ones() != 1 || eq.modulo_turn {
            continue;
        }
        let Some(roots) = whole_or_part(g, eq.known, eq.rhs) else { continue };
        let next = roots.into_iter().map(|Root { atom, value, also }| {
            let mut s = state.clone();
            s.equations[i] = Equation { known: value, rhs: atom, modulo_turn: false };
            s.solution.known.entry(atom).or_insert(value);
            if let Some((radical, value)) = also {
                s.solution.known.entry(radical).or_insert(value);
                if !g.range(value).nonnegative() {
                    s.solution.conditions.push(Condition(value));
                }
            }
            s.solution.steps.push(format!(
                "rational equation: {} = {}",
                show(g, atom),
                show(g, value)
            ));
            // The range of a uniform is tested anyhow.
            let uniform = matches!(g.node(atom), Node::Leaf(Leaf::Unknown(i)) if *i < 16);
            if !uniform && g.range(atom).nonnegative() && !g.range(value).nonnegative() {
                s.solution.conditions.push(Condition(value));
            }
            s
        });
        return Some(next.collect());
    }
    None
}

/// One way to satisfy an equation: atom = value, and the radical that was solved for on the way.
struct Root {
    atom: Id,
    value: Id,
    also: Option<(Id, Id)>,
}

/// All ways to satisfy known = rhs. Known sums stay together unless multiplying them out shows a
/// discriminant to be a square.
fn roots(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let together = roots_in(g, known, rhs, UNKNOWNS);
    let has_root = |g: &Graph, r: &Root| {
        matches!(g.node(r.value), Node::Product(_) | Node::Sum(..)) && mentions_root(g, r.value)
    };
    match together {
        Some(r) if !r.iter().any(|r| has_root(g, r)) => Some(r),
        other => match roots_in(g, known, rhs, Deps::MAX) {
            Some(r) if other.as_ref().is_none_or(|o| shorter(g, &r, o)) => Some(r),
            Some(r) if !r.iter().any(|r| has_root(g, r)) => Some(r),
            _ => other,
        },
    }
}

/// All ways to satisfy known = rhs, as it stands or squared.
fn solved(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    roots(g, known, rhs).or_else(|| squared(g, known, rhs))
}

/// The same, or all ways for a part of `rhs` to satisfy it, where those are fewer or shorter: what is in a part that
/// comes out plainly is not squared.
fn whole_or_part(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    if let Some(root) = by_slope(g, known, rhs) {
        return Some(vec![root]);
    }
    // Multiplied out, a long equation could use up what finding a part in it takes.
    let whole = within_part_of_budget(2, || solved(g, known, rhs));
    let plain = |g: &Graph, roots: &[Root]| !roots.iter().any(|r| mentions_root(g, r.value));
    match whole {
        Some(whole) if plain(g, &whole) => Some(whole),
        Some(whole) => match within_part_of_budget(2, || through_a_part(g, known, rhs)) {
            Some(part) if part.len() <= whole.len() && shorter(g, &part, &whole) => Some(part),
            _ => Some(whole),
        },
        None => through_a_part(g, known, rhs),
    }
}

/// What an equation says that is linear in its unknown and has exponentials of parameters: as it is written, since clearing
/// divisors may lead out of the range of numbers, e^-k being one.
fn by_slope(g: &mut Graph, known: Id, rhs: Id) -> Option<Root> {
    let bits = g.deps(rhs) & UNKNOWNS;
    let leaf = Leaf::Unknown(bits.trailing_zeros() as u8);
    let is_large = |g: &Graph, id: Id| match g.node(id) {
        Node::Call(Fun::Exp | Fun::ExpM1, args) => {
            let range = g.range(args[0]);
            !g.has(id, UNKNOWNS) && (range.hi > SAFE || range.lo < -SAFE)
        }
        _ => false,
    };
    if bits.count_ones() != 1 || !g.within(&[rhs]).into_iter().any(|id| is_large(g, id)) {
        return None;
    }
    let slope = derivative(g, rhs, leaf);
    if g.has(slope, UNKNOWNS) {
        return None;
    }
    let (atom, zero) = (g.get_leaf(leaf), g.int(0));
    let start = g.substitute(rhs, &BTreeMap::from([(atom, zero)]));
    let gap = g.sub(known, start);
    Some(Root { atom, value: g.div(gap, slope), also: None })
}

/// The same for the largest part of `rhs` through which alone the unknowns enter: q of q / √(1 - q²),
/// whatever q is.
fn through_a_part(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let mut parts = Vec::new();
    let mut open = children(g.node(rhs));
    while let Some(part) = open.pop() {
        let composed = matches!(g.node(part), Node::Sum(..) | Node::Product(_) | Node::Call(..));
        if composed && g.has(part, UNKNOWNS) && !parts.contains(&part) {
            parts.push(part);
            open.extend(children(g.node(part)));
        }
    }
    sorted::sort_by_key(&mut parts, |&part| std::cmp::Reverse(cost(g, part)));
    parts.into_iter().find_map(|part| {
        let (leaf, range) = match g.range(part).nonnegative() {
            true => (Leaf::Unknown(21), Interval::POSITIVE),
            false => (Leaf::Unknown(22), Interval::ALL),
        };
        let fresh = g.leaf(leaf, "q", range);
        let rest = g.substitute(rhs, &BTreeMap::from([(part, fresh)]));
        if g.deps(rest) & UNKNOWNS != leaf_bit(leaf) {
            return None;
        }
        let roots = solved(g, known, rest)?;
        let found = roots.into_iter().map(|Root { atom, value, .. }| {
            (atom == fresh).then_some(Root { atom: part, value, also: None })
        });
        found.collect()
    })
}

/// Whether the first answers take less computing than the second.
fn shorter(g: &Graph, first: &[Root], second: &[Root]) -> bool {
    let work = |roots: &[Root]| roots.iter().map(|r| cost(g, r.value)).sum::<usize>();
    work(first) < work(second)
}

/// The same for known = √… times something rational: both sides squared. Which of the roots have the
/// sign of the known side shows when they are tried.
fn squared(g: &mut Graph, known: Id, rhs: Id) -> Option<Vec<Root>> {
    let (_, body) = g.split(rhs);
    let root = |e: Id, g: &Graph| g.as_number(e).is_some_and(|q| q.den() == 2);
    if !g.factors(body).into_iter().any(|(_, e)| root(e, g)) {
        return None;
    }
    let (known, rhs) = (g.powi(known, 2), g.powi(rhs, 2));
    roots(g, known, rhs)
}

/// Whether a square root of something open occurs in an expression.
fn mentions_root(g: &Graph, id: Id) -> bool {
    match g.node(id) {
        Node::Product(f) => f
            .iter()
            .any(|(b, e)| g.as_number(*e).is_some_and(|q| q.den() == 2) || mentions_root(g, *b)),
        Node::Sum(_, t) => t.iter().any(|(_, t)| mentions_root(g, *t)),
        _ => false,
    }
}

fn roots_in(g: &mut Graph, known: Id, rhs: Id, open: Deps) -> Option<Vec<Root>> {
    let polynomial = clear(g, known, rhs, open)?;
    let atoms: Vec<Id> = polynomial.atoms().into_iter().filter(|a| g.has(*a, UNKNOWNS)).collect();
    match atoms[..] {
        [atom] => {
            let values = polynomial_roots(g, &polynomial, atom)?;
            Some(values.into_iter().map(|value| Root { atom, value, also: None }).collect())
        }
        [a, b] => radical(g, known, rhs, [a, b], open)
            .or_else(|| radical(g, known, rhs, [b, a], open))
            .or_else(|| isolated(g, &polynomial, &atoms, open)),
        [_, _, _] => isolated(g, &polynomial, &atoms, open),
        _ => None,
    }
}

/// The numerator of rhs - known, as a polynomial.
pub(super) fn clear(g: &mut Graph, known: Id, rhs: Id, open: Deps) -> Option<Poly> {
    let difference = g.sub(rhs, known);
    Some(Expander::new(g).only(open).expand(difference)?.num)
}

/// Atoms u and t = √(α + β u): substitutes u = (t² - α) / β and solves for t.
fn radical(g: &mut Graph, known: Id, rhs: Id, [u, t]: [Id; 2], open: Deps) -> Option<Vec<Root>> {
    let Node::Product(f) = g.node(t).clone() else { return None };
    if f.len() != 1 || g.as_number(f[0].1) != Some(Q::HALF) {
        return None;
    }
    let radicand = Expander::new(g).only(open).expand(f[0].0)?;
    if !radicand.den.is_empty() {
        return None;
    }
    let c = radicand.num.by_powers_of(u)?;
    let [alpha, beta] = &c[..] else { return None };
    let (alpha, beta) = (alpha.to_expr(g), beta.to_expr(g));
    if g.has(alpha, UNKNOWNS) || g.has(beta, UNKNOWNS) {
        return None;
    }
    let fresh = g.leaf(Leaf::Unknown(23), "t", Interval::POSITIVE);
    let t2 = g.powi(fresh, 2);
    let top = g.sub(t2, alpha);
    let inner = g.div(top, beta);
    let substituted = g.substitute(rhs, &BTreeMap::from([(t, fresh), (u, inner)]));
    let polynomial = clear(g, known, substituted, open)?;
    let values = polynomial_roots(g, &polynomial, fresh)?;
    Some(
        values
            .into_iter()
            .map(|v| {
                let exact = g.substitute(inner, &BTreeMap::from([(fresh, v)]));
                let simple = Expander::new(g).only(open).normal_form(exact).unwrap_or(exact);
                Root { atom: u, value: simple, also: Some((t, v)) }
            })
            .collect(),
    )
}

/// Atoms u and roots of polynomials of it, of which the equation has one product: A + B √R = 0 as A² - B² R = 0, where that has
/// a low degree.
fn isolated(g: &mut Graph, equation: &Poly, atoms: &[Id], open: Deps) -> Option<Vec<Root>> {
    let radicand = |g: &Graph, atom: Id| match g.node(atom) {
        Node::Product(f) if f.len() == 1 && g.as_number(f[0].1) == Some(Q::HALF) => Some(f[0].0),
        _ => None,
    };
    let (roots, plain): (Vec<Id>, Vec<Id>) =
        atoms.iter().partition(|&&atom| radicand(g, atom).is_some());
    let [u] = plain[..] else { return None };
    let (mut alone, mut times) = (None, equation.clone());
    let (mut above, mut below) = (Poly::constant(Q::ONE), Poly::constant(Q::ONE));
    for &root in &roots {
        let c = times.by_powers_of(root)?;
        let [rest, with] = &c[..] else { return None };
        // Besides the first of them the others stand by themselves nowhere.
        match &alone {
            None => alone = Some(rest.clone()),
            Some(_) if rest.is_zero() => {}
            Some(_) => return None,
        }
        let under = radicand(g, root)?;
        let under = Expander::new(g).only(open).expand(under)?;
        let mut factors = under.den.iter();
        let den = factors
            .try_fold(Poly::constant(Q::ONE), |all, (factor, e)| all.mul(&factor.powi(*e)?))?;
        (above, below, times) = (above.mul(&under.num)?, below.mul(&den)?, with.clone());
    }
    let alone = alone?;
    let is_free =
        |g: &Graph, p: &Poly| p.atoms().into_iter().all(|atom| atom == u || !g.has(atom, UNKNOWNS));
    if ![&alone, &times, &above, &below].into_iter().all(|p| is_free(g, p)) {
        return None;
    }
    let squared = alone.mul(&alone)?.mul(&below)?.sub(&times.mul(&times)?.mul(&above)?)?;
    let values = polynomial_roots(g, &squared, u)?;
    Some(values.into_iter().map(|value| Root { atom: u, value, also: None }).collect())
}

/// The roots of a polynomial of degree one or two in `atom`.
fn polynomial_roots(g: &mut Graph, p: &Poly, atom: Id) -> Option<Vec<Id>> {
    let mut c: Vec<Poly> = p.by_powers_of(atom)?.into_iter().map(|c| modulo_units(g, c)).collect();
    while c.last().is_some_and(Poly::is_zero) {
        c.pop();
    }
    match &c[..] {
        [c0, c1] => Some(vec![quotient(g, &c0.scale(Q::int(-1))?, c1)?]),
        [c0, c1, c2] if c0.is_zero() => {
            let other = quotient(g, &c1.scale(Q::int(-1))?, c2)?;
            Some(vec![g.int(0), other])
        }
        [c0, c1, c2] => {
            let discriminant = c1.mul(c1)?.sub(&c0.mul(c2)?.scale(Q::int(4))?)?;
            let discriminant = modulo_units(g, discriminant);
            let mut quotient = |num: &Poly, den: &Poly| quotient(g, num, den);
            if let Some(root) = discriminant.sqrt() {
                let minus = c1.scale(Q::int(-1))?;
                let twice = c2.scale(Q::int(2))?;
                let a = quotient(&minus.add(&root)?, &twice)?;
                let b = quotient(&minus.sub(&root)?, &twice)?;
                return Some(vec![a, b]);
            }
            Some(quadratic(g, c0, c1, c2, &discriminant))
        }
        _ => None,
    }
}

fn quotient(g: &mut Graph, num: &Poly, den: &Poly) -> Option<Id> {
    let mut e = Expander::new(g);
    let inverse = e.recip(&RatFun { num: den.clone(), den: vec![] })?;
    let r = e.mul(&RatFun { num: num.clone(), den: vec![] }, &inverse)?;
    Some(e.to_expr(&r))
}

/// A polynomial in known quantities, shorter by what the lengths of unit vectors say.
fn modulo_units(g: &mut Graph, p: Poly) -> Poly {
    let units = g.units().to_vec();
    let whole = p.to_expr(g);
    let expander = units.into_iter().fold(Expander::new(g), Expander::unit);
    let reduced = { expander }.expand(whole).filter(|r| r.den.is_empty());
    match reduced {
        Some(r) if r.num.terms(g).len() < p.terms(g).len() => r.num,
        _ => p,
    }
}

/// Both roots in the form 2c₀ / (-c₁ ∓ √D): the sum below does not cancel for one of the signs.
///
/// The discriminant is multiplied out only where that makes it shorter.
fn quadratic(g: &mut Graph, c0: &Poly, c1: &Poly, c2: &Poly, discriminant: &Poly) -> Vec<Id> {
    // √D = s √r, of which both signs are taken.
    let composed = composed(g, c0, c1, c2);
    let whole = || (Poly::constant(Q::ONE), discriminant.clone());
    // Of a product each factor may show what the whole of it does not.
    let parts = if c1.is_zero() { square_parts(c0, c2) } else { None };
    let (s, r) = parts.or_else(|| discriminant.square_part()).unwrap_or_else(whole);
    let (c0, c1, s) = without_common(c0, c1, &s);
    let halved = c1.exact_div(&r).filter(|_| r.as_constant().is_none());
    let (scale, r) = r.integral().unwrap_or((Q::ONE, r));
    let (c0, s, mut under) = (c0.to_expr(g), s.to_expr(g), r.to_expr(g));
    let plain = r == *discriminant && scale == Q::ONE;
    if plain && cost(g, composed) < cost(g, under) {
        under = composed;
    }
    let scale = g.number(scale);
    let scale = g.sqrt(scale);
    let root = g.sqrt(under);
    let root = g.mul(scale, root);
    let root = without_signs(g, root);
    let top = g.sum(Q::ZERO, &[(Q::int(2), c0)]);
    // -c₁ ∓ s √r, or √r times a sum where c₁ is a multiple of r.
    let (outside, c1, s) = match halved {
        Some(c) => {
            let c = c.to_expr(g);
            (root, g.mul(c, root), s)
        }
        None => (g.int(1), c1.to_expr(g), g.mul(s, root)),
    };
    [Q::ONE, Q::int(-1)]
        .into_iter()
        .map(|sign| {
            let bottom = g.sum(Q::ZERO, &[(Q::int(-1), c1), (sign, s)]);
            let bottom = g.mul(outside, bottom);
            g.div(top, bottom)
        })
        .collect()
}

/// -4 c₀ c₂ as s² r, with as much in s as each of the factors shows.
fn square_parts(c0: &Poly, c2: &Poly) -> Option<(Poly, Poly)> {
    let [(s0, r0), (s2, r2)] = [c0.square_part()?, c2.square_part()?];
    Some((s0.mul(&s2)?.scale(Q::int(2))?, r0.mul(&r2)?.scale(Q::int(-1))?))
}

/// c₁² - 4 c₀ c₂, not multiplied out.
fn composed(g: &mut Graph, c0: &Poly, c1: &Poly, c2: &Poly) -> Id {
    let (c0, c1, c2) = (c0.to_expr(g), c1.to_expr(g), c2.to_expr(g));
    let (square, other) = (g.powi(c1, 2), g.mul(c0, c2));
    g.sum(Q::ZERO, &[(Q::ONE, square), (Q::int(-4), other)])
}

/// Three polynomials without the factors of the third that divide them all.
fn without_common(c0: &Poly, c1: &Poly, s: &Poly) -> (Poly, Poly, Poly) {
    let mut all = (c0.clone(), c1.clone(), s.clone());
    for (factor, e) in s.split() {
        for _ in 0..e {
            let divided =
                (all.0.exact_div(&factor), all.1.exact_div(&factor), all.2.exact_div(&factor));
            let (Some(a), Some(b), Some(c)) = divided else { break };
            all = (a, b, c);
        }
    }
    all
}

/// √(x² d) as x √d: where both signs of a root are taken, neither needs the size of x, and each of
/// the answers stays with one branch of the map.
fn without_signs(g: &mut Graph, root: Id) -> Id {
    let (q, body) = g.split(root);
    let factors: Vec<(Id, Id)> = g
        .factors(body)
        .into_iter()
        .map(|(b, e)| match g.node(b) {
            Node::Call(Fun::Abs, args) => (args[0], e),
            _ => (b, e),
        })
        .collect();
    let body = g.product(&factors);
    g.sum(Q::ZERO, &[(q, body)])
}

/// Gives the coefficients of polynomial equations in several unknowns names, where they are sums. Multiplied
/// out in all that follows, these would become long, and cancel: b - a and c - d of the corners a, b, c
/// and d are small where the corners are not.
pub(super) fn name_coefficients(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    let mut next = state.clone();
    let mut sums = 0;
    for e in next.equations.iter_mut().filter(|e| !e.modulo_turn) {
        if (g.deps(e.rhs) & UNKNOWNS).count_ones() < 2 {
            continue;
        }
        let difference = g.sub(e.rhs, e.known);
        let mut terms = Vec::new();
        for (open, known) in coefficients(g, difference)? {
            let long =
                matches!(g.node(known), Node::Sum(c, t) if t.len() + usize::from(!c.is_zero()) > 1);
            let value = match (long, next.solution.names.iter().find(|(_, v)| **v == known)) {
                (true, Some((name, _))) => *name,
                (true, None) => {
                    sums += 1;
                    scale::next_name(g, &mut next.solution, known)?
                }
                (false, _) => known,
            };
            terms.push((Q::ONE, g.mul(value, open)));
        }
        *e = Equation { known: g.int(0), rhs: g.sum(Q::ZERO, &terms), modulo_turn: false };
    }
    (sums > 0).then(|| vec![next])
}

/// Isolates one unknown of an equation with several and substitutes it into the others: if there is one that is divided by a
/// number alone, that one, since anything else may be zero somewhere.
pub(super) fn eliminate(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    eliminate_by(g, state, true).or_else(|| eliminate_by(g, state, false))
}

fn eliminate_by(g: &mut Graph, state: &State, by_number: bool) -> Option<Vec<State>> {
    for i in 0..state.equations.len() {
        let eq = state.equations[i].clone();
        // What an equation gave another one holds already: doing it again leads round in circles.
        if eq.modulo_turn || state.eliminated.contains(&eq.rhs) {
            continue;
        }
        for (leaf, atom) in isolatable(g, eq.known, eq.rhs) {
            let used = state
                .equations
                .iter()
                .enumerate()
                .any(|(j, e)| j != i && !e.modulo_turn && g.has(e.rhs, leaf_bit(leaf)));
            if !used {
                continue;
            }
            let Some(polynomial) = clear(g, eq.known, eq.rhs, UNKNOWNS) else { continue };
            let Some(c) = polynomial.by_powers_of(atom) else { continue };
            let [c0, c1] = &c[..] else { continue };
            let (c0, c1) = (c0.to_expr(g), c1.to_expr(g));
            if g.has(c1, leaf_bit(leaf)) || g.has(c0, leaf_bit(leaf)) {
                continue;
            }
            if by_number && g.as_number(c1).is_none() {
                continue;
            }
            let value = g.div(c0, c1);
            let value = g.neg(value);
            let mut s = state.clone();
            let map = BTreeMap::from([(atom, value)]);
            let mut gone = true;
            for (j, e) in s.equations.iter_mut().enumerate() {
                if j != i {
                    e.rhs = g.substitute(e.rhs, &map);
                    gone &= !g.has(e.rhs, leaf_bit(leaf));
                    // Unknowns may have moved to both sides of nothing: bring the equation up to date.
                    if let Some(n) = Expander::new(g).only(UNKNOWNS).normal_form(e.rhs) {
                        e.rhs = n;
                    }
                }
            }
            if !gone {
                continue;
            }
            s.solution.steps.push(format!("elimination: {} = {}", show(g, atom), show(g, value)));
            // The eliminated equation comes last: it is solved once the others are.
            let last = s.equations.remove(i);
            s.eliminated.push(last.rhs);
            s.equations.push(last);
            return Some(vec![s]);
        }
    }
    None
}

/// (unknown, atom) pairs such that the equation is linear in the atom and the atom holds only that unknown.
fn isolatable(g: &mut Graph, known: Id, rhs: Id) -> Vec<(Leaf, Id)> {
    let Some(p) = clear(g, known, rhs, UNKNOWNS) else { return vec![] };
    let mut found = Vec::new();
    for atom in p.atoms() {
        for i in 0..24 {
            if g.deps(atom) & UNKNOWNS == leaf_bit(Leaf::Unknown(i)) {
                found.push((Leaf::Unknown(i), atom));
            }
        }
    }
    found
}
