//! Cubic equations in closed form.

use super::rational::clear;
use super::{Condition, Equation, State};
use crate::display::show;
use crate::expr::{Deps, Fun, Graph, Id, UNKNOWNS};
use crate::rational::Q;

/// Solves an equation that is a cubic polynomial of some part with the only unknown.
pub(super) fn single_unknown(g: &mut Graph, state: &State) -> Option<Vec<State>> {
    for i in 0..state.equations.len() {
        let e = state.equations[i].clone();
        if e.modulo_turn || (g.deps(e.rhs) & UNKNOWNS).count_ones() != 1 {
            continue;
        }
        let Some((atom, roots)) = cubic(g, &e) else { continue };
        let next = roots.into_iter().map(|(value, condition)| {
            let mut s = state.clone();
            s.equations[i] = Equation { known: value, rhs: atom, modulo_turn: false };
            s.solution.known.entry(atom).or_insert(value);
            s.solution.conditions.extend(condition.map(Condition));
            s.solution.steps.push(format!("cubic: {} = {}", show(g, atom), show(g, value)));
            s
        });
        return Some(next.collect());
    }
    None
}

/// A value, and what must not be negative for it to be a root.
type Root = (Id, Option<Id>);

/// The part that the equation is a cubic polynomial of, and its values.
fn cubic(g: &mut Graph, e: &Equation) -> Option<(Id, Vec<Root>)> {
    let polynomial = clear(g, e.known, e.rhs, Deps::MAX)?;
    let atoms: Vec<Id> = polynomial.atoms().into_iter().filter(|a| g.has(*a, UNKNOWNS)).collect();
    let [atom] = atoms[..] else { return None };
    let c = polynomial.by_powers_of(atom)?;
    let [d, c, b, a] = &c[..] else { return None };
    let [d, c, b, a] = [d, c, b, a].map(|p| p.to_expr(g));
    let monic = Monic::new(g, [a, b, c, d]);
    // With z = t - b / 3 it is t³ + p t + q = 0.
    let [b, c, d] = monic.coefficients;
    let b2 = g.powi(b, 2);
    let p = g.sum(Q::ZERO, &[(Q::ONE, c), (Q::new(-1, 3)?, b2)]);
    let (b3, bc) = (g.powi(b, 3), g.mul(b, c));
    let q = g.sum(Q::ZERO, &[(Q::new(2, 27)?, b3), (Q::new(-1, 3)?, bc), (Q::ONE, d)]);
    let (p3, q2) = (g.powi(p, 3), g.powi(q, 2));
    let discriminant = g.sum(Q::ZERO, &[(Q::new(1, 27)?, p3), (Q::new(1, 4)?, q2)]);
    let mut roots = Vec::new();
    // The one number that tells how many roots there are, so that rounding never finds a root in both ways.
    let cosine = cosine(g, p, q)?;
    let square = g.powi(cosine, 2);
    if !g.range(discriminant).nonnegative() {
        let three = g.sum(Q::ONE, &[(Q::int(-1), square)]);
        roots.extend(three_roots(g, p, cosine)?.map(|t| (t, Some(three))));
    }
    if !g.range(discriminant).nonpositive() {
        // Where it is just a cosine, or none, there are the three roots, and this is the root of something negative.
        let root = one_root(g, p, q, discriminant)?;
        let outside = g.sum(Q::int(-1), &[(Q::ONE, square)]);
        let less = g.sum(Q::int(-2), &[(Q::ONE, square)]);
        let no_root = g.sqrt(less);
        let outer = g.if_positive(outside, root, no_root);
        let opposite = g.neg(p);
        roots.push((g.if_positive(opposite, outer, root), None));
    }
    let shifted = |(t, condition)| {
        let z = g.sum(Q::ZERO, &[(Q::ONE, t), (q_third(), b)]);
        (monic.root(g, z), condition)
    };
    Some((atom, roots.into_iter().map(shifted).collect()))
}

/// A cubic equation with the leading coefficient one.
struct Monic {
    /// The coefficients of z², z and 1.
    coefficients: [Id; 3],
    /// Where the leading coefficient may vanish: whether it is large, if positive, so that z = x, and d of z = d / x otherwise.
    turned: Option<(Id, Id)>,
}

impl Monic {
    /// Of a x³ + b x² + c x + d = 0. Divided by a it is one of x; divided by x³ and multiplied by d² it is
    /// z³ + c z² + b d z + a d² = 0 with z = d / x, which knows the roots that there are without a: one of the three goes away to
    /// infinity. A root that is told by its distance from b / (3 a), which is eight times as large, has lost a digit.
    fn new(g: &mut Graph, [a, b, c, d]: [Id; 4]) -> Monic {
        let range = g.range(a);
        let divided = [b, c, d].map(|v| g.div(v, a));
        if range.lo > 0.0 || range.hi < 0.0 {
            return Monic { coefficients: divided, turned: None };
        }
        let [a2, b2] = [a, b].map(|v| g.powi(v, 2));
        let is_large = g.sum(Q::ZERO, &[(Q::int(64), a2), (Q::int(-1), b2)]);
        let (bd, d2) = (g.mul(b, d), g.powi(d, 2));
        let turned = [c, bd, g.mul(a, d2)];
        let coefficients = [0, 1, 2].map(|i| g.if_positive(is_large, divided[i], turned[i]));
        Monic { coefficients, turned: Some((is_large, d)) }
    }

    /// x of z.
    fn root(&self, g: &mut Graph, z: Id) -> Id {
        match self.turned {
            None => z,
            Some((is_large, d)) => {
                let other = g.div(d, z);
                g.if_positive(is_large, z, other)
            }
        }
    }
}

fn q_third() -> Q {
    Q::new(-1, 3).unwrap_or(Q::ZERO)
}

/// c = -q / 2 (-3 / p)^(3/2): there are three roots where it is a cosine.
fn cosine(g: &mut Graph, p: Id, q: Id) -> Option<Id> {
    let third = g.sum(Q::ZERO, &[(Q::new(-1, 3)?, p)]);
    let root = g.sqrt(third);
    let cube = g.powi(root, -3);
    let cosine = g.mul(q, cube);
    Some(g.sum(Q::ZERO, &[(Q::HALF.neg(), cosine)]))
}

/// Viète's roots 2 √(-p/3) cos((acos(c) - 2 π k) / 3); the middle one is -2 √(-p/3) sin(asin(c) / 3),
/// which keeps its digits where it is much smaller than the others, as of a cubic that is nearly linear.
fn three_roots(g: &mut Graph, p: Id, cosine: Id) -> Option<[Id; 3]> {
    let third = g.sum(Q::ZERO, &[(Q::new(-1, 3)?, p)]);
    let root = g.sqrt(third);
    let angle = g.call(Fun::Acos, &[cosine]);
    let beside = g.call(Fun::Asin, &[cosine]);
    let beside = g.sum(Q::ZERO, &[(q_third().neg(), beside)]);
    let middle = g.call(Fun::Sin, &[beside]);
    let middle = g.mul(root, middle);
    let middle = g.sum(Q::ZERO, &[(Q::int(-2), middle)]);
    let pi = g.pi();
    let [first, last] = [0, 2].map(|k| {
        let turned =
            [(q_third().neg(), angle), (q_third().mul(Q::int(2 * k)).unwrap_or(Q::ZERO), pi)];
        let turned = g.sum(Q::ZERO, &turned);
        let cosine = g.call(Fun::Cos, &[turned]);
        let t = g.mul(root, cosine);
        g.sum(Q::ZERO, &[(Q::int(2), t)])
    });
    Some([first, middle, last])
}

/// Cardano's root, with the sum that does not cancel: C - p / (3 C), C³ = -(q/2 ± √D). Where p outweighs q the difference does,
/// and -2 √(p/3) sinh(asinh(q / 2 (3 / p)^(3/2)) / 3) does not.
fn one_root(g: &mut Graph, p: Id, q: Id, discriminant: Id) -> Option<Id> {
    let root = g.sqrt(discriminant);
    let sign = g.call(Fun::Sign, &[q]);
    let away = g.mul(sign, root);
    let cube = g.sum(Q::ZERO, &[(Q::HALF.neg(), q), (Q::int(-1), away)]);
    let c = g.call(Fun::Cbrt, &[cube]);
    let rest = g.div(p, c);
    let cardano = g.sum(Q::ZERO, &[(Q::ONE, c), (Q::new(-1, 3)?, rest)]);

    let third = g.sum(Q::ZERO, &[(Q::new(1, 3)?, p)]);
    let root = g.sqrt(third);
    let cube = g.powi(root, -3);
    let sine = g.mul(q, cube);
    let sine = g.sum(Q::ZERO, &[(Q::HALF, sine)]);
    let angle = g.call(Fun::Asinh, &[sine]);
    let angle = g.sum(Q::ZERO, &[(q_third().neg(), angle)]);
    let sine = g.call(Fun::Sinh, &[angle]);
    let product = g.mul(root, sine);
    let by_angle = g.sum(Q::ZERO, &[(Q::int(-2), product)]);
    let (p3, q2) = (g.powi(p, 3), g.powi(q, 2));
    let outweighs = g.sum(Q::ZERO, &[(Q::int(4), p3), (Q::int(-27), q2)]);
    Some(g.if_positive(outweighs, by_angle, cardano))
}
