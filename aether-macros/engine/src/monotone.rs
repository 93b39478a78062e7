//! Proofs that a function of one variable increases over its whole range, whatever the other inputs
//! in their domains.
//!
//! The box of all inputs is halved until, on every part, interval arithmetic shows that the slope is
//! not negative: directly, or because it is not negative where the variable begins and the slope's own
//! slope is not negative (and so on; or the same from the other end), which settles the neighbourhood of
//! a point where the slope vanishes. That the slope is not zero throughout is seen from its values.

mod leaves;
mod proof;
mod seen;

use crate::derivative::derivative;
use crate::expr::{Graph, Id, Leaf};
use crate::interval::Interval;
use seen::{POINTS, sign_inside};

pub(crate) use leaves::{any_input, centre, inputs_of, inside, leaves_of};
pub(crate) use proof::{Proof, halves};
pub(crate) use seen::{seen_sign, sign_at, values_of};

/// Why monotonicity could not be shown.
#[derive(Clone, Debug)]
pub struct Unproven {
    /// A part of the domain where the sign of the slope is not known, as text.
    pub place: String,
    /// A parameter of unbounded domain that the slope depends on, if there is one.
    pub unbounded: Option<String>,
}

/// Shows that `body` increases (1) or decreases (-1) strictly with `variable`, over the ranges that all
/// inputs are declared with.
pub fn direction(g: &mut Graph, body: Id, variable: Leaf) -> Result<i64, Unproven> {
    let slope = derivative(g, body, variable);
    shown(g, slope, variable, false)
}

/// Shows that an expression is positive (1) or negative (-1) everywhere.
pub fn sign_of(g: &mut Graph, id: Id, variable: Leaf) -> Result<i64, Unproven> {
    shown(g, id, variable, true)
}

/// The sign of a slope that may vanish here and there, or nowhere where `strict`.
fn shown(g: &mut Graph, slope: Id, variable: Leaf, strict: bool) -> Result<i64, Unproven> {
    let leaves = leaves_of(g, slope, variable);
    let sign = match sign_inside(g, slope, &leaves, strict, POINTS) {
        Ok(sign) => sign,
        Err(seen) => {
            let whole: Vec<Interval> = leaves.iter().map(|l| g.leaf_range(*l)).collect();
            let mut why = unproven(g, &leaves, &whole);
            why.place += &seen;
            return Err(why);
        }
    };
    let upward = if sign < 0 { g.neg(slope) } else { slope };
    Proof::new(g, upward, variable, leaves, strict).run(g).map(|()| sign)
}

/// That there is no proof for a part of the box.
pub(crate) fn unproven(g: &Graph, leaves: &[Leaf], part: &[Interval]) -> Unproven {
    let place: Vec<String> = leaves
        .iter()
        .zip(part)
        .map(|(l, i)| {
            let end =
                |x: f64| if x.is_infinite() { "∞".to_owned() } else { format!("{:.6}", x.abs()) };
            let sign = |x: f64| if x < 0.0 { "-" } else { "" };
            format!("{} in [{}{}, {}{}]", g.name(*l), sign(i.lo), end(i.lo), sign(i.hi), end(i.hi))
        })
        .collect();
    let unbounded = leaves
        .iter()
        .find(|l| matches!(l, Leaf::Param(_)) && !g.leaf_range(**l).width().is_finite());
    Unproven { place: place.join(", "), unbounded: unbounded.map(|l| g.name(*l).to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Fun;
    use crate::rational::Q;

    fn unit(g: &mut Graph) -> (Leaf, Id) {
        let leaf = Leaf::Unknown(0);
        (leaf, g.leaf(leaf, "u", Interval::new(0.0, 1.0)))
    }

    #[test]
    fn sums_of_increasing_functions() {
        let mut g = Graph::new();
        let (leaf, u) = unit(&mut g);
        let k = g.leaf(Leaf::Param(0), "k", Interval::new(0.0, 10.0));
        let u5 = g.powi(u, 5);
        let second = g.mul(k, u5);
        let log = g.call(Fun::Ln1p, &[u]);
        let f = g.sum(Q::ZERO, &[(Q::ONE, u), (Q::ONE, second), (Q::ONE, log)]);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
        let down = g.neg(f);
        assert_eq!(direction(&mut g, down, leaf).unwrap(), -1);
    }

    #[test]
    fn a_slope_that_vanishes_at_an_end() {
        let mut g = Graph::new();
        let (leaf, t) = unit(&mut g);
        let (t3, t4) = (g.powi(t, 3), g.powi(t, 4));
        let f = g.sum(Q::ZERO, &[(Q::int(2), t3), (Q::int(-1), t4)]);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
        // Kepler's equation with all eccentricities up to one.
        let e = g.leaf(Leaf::Param(0), "e", Interval::new(0.0, 1.0));
        let leaf = Leaf::Unknown(1);
        let a = g.leaf(leaf, "a", Interval::new(0.0, std::f64::consts::TAU));
        let s = g.call(Fun::Sin, &[a]);
        let es = g.mul(e, s);
        let f = g.sub(a, es);
        assert_eq!(direction(&mut g, f, leaf).unwrap(), 1);
    }

    #[test]
    fn what_does_not_increase_is_refused() {
        let mut g = Graph::new();
        let (leaf, u) = unit(&mut g);
        let (u2, u3) = (g.powi(u, 2), g.powi(u, 3));
        let c = |n, d| Q::new(n, d).unwrap();
        // u³ - 3/2 u² + 9/16 u turns twice inside.
        let f = g.sum(Q::ZERO, &[(Q::ONE, u3), (c(-3, 2), u2), (c(9, 16), u)]);
        let reason = direction(&mut g, f, leaf).unwrap_err();
        assert!(reason.place.starts_with("u in [0."), "{}", reason.place);
        // The parameter may be negative.
        let k = g.leaf(Leaf::Param(0), "k", Interval::ALL);
        let second = g.mul(k, u3);
        let f = g.add(u, second);
        let reason = direction(&mut g, f, leaf).unwrap_err();
        assert_eq!(reason.unbounded.as_deref(), Some("k"));
        // A constant does not increase.
        let f = g.if_positive(u2, u2, u3);
        let flat = g.sub(f, f);
        assert!(direction(&mut g, flat, leaf).is_err());
    }
}
