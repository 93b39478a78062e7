//! Cells of functions whose turning points are known.

use super::*;
use crate::expr::Fun;
use crate::rational::Q;

const UNIT: Interval = Interval { lo: 0.0, hi: 1.0 };

fn graph() -> (Graph, Leaf, Id) {
    let mut g = Graph::new();
    let leaf = Leaf::Unknown(0);
    let u = g.leaf(leaf, "u", UNIT);
    (g, leaf, u)
}

fn parameter(g: &mut Graph, lo: f64, hi: f64) -> Id {
    g.leaf(Leaf::Param(0), "k", Interval::new(lo, hi))
}

/// A polynomial by its coefficients, n/d each, the constant first.
fn polynomial(g: &mut Graph, u: Id, coefficients: &[(i128, i128)]) -> Id {
    let terms: Vec<(Q, Id)> =
        (0..).zip(coefficients).map(|(i, &(n, d))| (Q::new(n, d).unwrap(), g.powi(u, i))).collect();
    g.sum(Q::ZERO, &terms)
}

fn shapes(cells: &[Cell]) -> Vec<(usize, i64)> {
    cells.iter().map(|c| (c.order, c.sign)).collect()
}

#[test]
fn a_polynomial_that_turns_twice() {
    let (mut g, leaf, u) = graph();
    // u³ - 3/2 u² + 9/16 u turns at 1/4 and 3/4.
    let f = polynomial(&mut g, u, &[(0, 1), (9, 16), (-3, 2), (1, 1)]);
    let found = cells(&mut g, f, leaf).unwrap();
    assert_eq!(shapes(&found), [(1, -1), (1, 1)]);
    assert!(found[0].range.hi > 0.25 && found[0].range.hi < 0.75, "{found:?}");
    assert_eq!((found[0].range.lo, found[1].range.hi), (0.0, 1.0));
    // Without its turns it is one cell.
    let f = polynomial(&mut g, u, &[(0, 1), (9, 8), (-3, 2), (1, 1)]);
    assert_eq!(shapes(&cells(&mut g, f, leaf).unwrap()), [(0, 1)]);
}

#[test]
fn a_parameter_moves_the_turning_point_all_over_the_range() {
    let (mut g, leaf, u) = graph();
    let k = parameter(&mut g, 0.0, 20.0);
    // u exp(-k u) turns at 1 / k, and for small k not at all.
    let ku = g.mul(k, u);
    let minus = g.neg(ku);
    let decay = g.call(Fun::Exp, &[minus]);
    let f = g.mul(u, decay);
    assert_eq!(shapes(&cells(&mut g, f, leaf).unwrap()), [(1, -1)]);
}

#[test]
fn turning_points_that_appear_with_a_parameter() {
    let (mut g, leaf, u) = graph();
    let k = parameter(&mut g, -0.5, 0.5);
    // (u - 3/10)³ + k u turns on both sides of 3/10, where k is negative.
    let away = g.sum(Q::new(-3, 10).unwrap(), &[(Q::ONE, u)]);
    let (cube, line) = (g.powi(away, 3), g.mul(k, u));
    let f = g.add(cube, line);
    assert_eq!(shapes(&cells(&mut g, f, leaf).unwrap()), [(2, 1)]);
}

#[test]
fn a_sine_of_several_turns() {
    let (mut g, leaf, u) = graph();
    let angle = g.sum(Q::ZERO, &[(Q::int(20), u)]);
    let sine = g.call(Fun::Sin, &[angle]);
    let f = g.add(sine, u);
    // 1 + 20 cos(20 u) has six zeros up to 20.
    let found = cells(&mut g, f, leaf).unwrap();
    let turns = found.iter().filter(|c| c.order == 1).count();
    assert!(turns == 6 && found.iter().all(|c| c.order < 2), "{found:?}");
}

#[test]
fn an_inflection_is_no_turn() {
    let (mut g, leaf, u) = graph();
    // The slope 3 (u - 1/2)² of (u - 1/2)³, written out.
    let f = polynomial(&mut g, u, &[(0, 1), (3, 4), (-3, 2), (1, 1)]);
    assert_eq!(shapes(&cells(&mut g, f, leaf).unwrap()), [(0, 1)]);
    // The slope (exp u - c)², where c and c² are rounded: two turning points next to each other, or none.
    let c = 0.3_f64.exp();
    let exp = g.call(Fun::Exp, &[u]);
    let (square, middle) = (g.powi(exp, 2), g.float(-2.0 * c));
    let (middle, last) = (g.mul(middle, exp), g.float(c * c));
    let last = g.mul(last, u);
    let f = g.sum(Q::ZERO, &[(Q::HALF, square), (Q::ONE, middle), (Q::ONE, last)]);
    let found = cells(&mut g, f, leaf).unwrap();
    assert!(shapes(&found).contains(&(2, 1)), "{found:?}");
}

#[test]
fn an_infinite_range() {
    let mut g = Graph::new();
    let leaf = Leaf::Unknown(0);
    let t = g.leaf(leaf, "t", Interval::ALL);
    // t exp(-t²) turns at ±√½.
    let square = g.powi(t, 2);
    let minus = g.neg(square);
    let decay = g.call(Fun::Exp, &[minus]);
    let f = g.mul(t, decay);
    let found = cells(&mut g, f, leaf).unwrap();
    assert_eq!(shapes(&found), [(0, -1), (1, 1), (1, -1), (0, -1)]);
    assert_eq!((found[1].range.hi, found[3].range.hi), (0.0, f64::INFINITY));
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let (mut g, leaf, u) = graph();
    // sin(k u) turns the more often the larger k is.
    let k = g.leaf(Leaf::Param(0), "k", Interval::ALL);
    let ku = g.mul(k, u);
    let sine = g.call(Fun::Sin, &[ku]);
    let f = g.add(sine, u);
    let reason = cells(&mut g, f, leaf).unwrap_err();
    assert_eq!(reason.unbounded.as_deref(), Some("k"));
    assert!(reason.place.starts_with("u in [0."), "{}", reason.place);
}

#[test]
fn a_function_with_a_pole_or_a_jump_of_its_slope_is_refused() {
    let (mut g, leaf, u) = graph();
    let away = g.sum(Q::new(-3, 10).unwrap(), &[(Q::ONE, u)]);
    let (pole, exp) = (g.powi(away, -1), g.call(Fun::Exp, &[u]));
    // It rises on both sides of its pole.
    let f = g.sub(exp, pole);
    assert!(cells(&mut g, f, leaf).is_err());
    let size = g.call(Fun::Abs, &[away]);
    let f = g.sum(Q::ZERO, &[(Q::int(2), exp), (Q::ONE, size)]);
    assert_eq!(shapes(&cells(&mut g, f, leaf).unwrap()), [(0, 1)]);
    let f = g.sum(Q::ZERO, &[(Q::ONE, exp), (Q::int(-3), size)]);
    assert!(cells(&mut g, f, leaf).is_err());
}
