//! Equations in one unknown whose side turns back: a root on each piece on which it is monotone.
//!
//! [`turns`](crate::turns) says in which parts of the unknown's range the side may turn. Each turning point is a root of
//! its slope, which the parameters may move, and which may reach an end of its part or another one: then a piece has no
//! width, and those on both sides of it are one.

use super::numeric::{self, Bound, bind, end};
use super::{Condition, Equation, State, Within};
use crate::display::show;
use crate::eval::evaluate;
use crate::expr::{Graph, Id, Leaf, Root};
use crate::monotone::Unproven;
use crate::number::{Dd, Number};
use crate::rational::Q;
use crate::turns::{Cell, cells, tower};

/// More pieces than these are not built.
const MOST: usize = 8;

/// Solves one equation in one unknown on each piece of its range; the reason if it cannot be shown where they end.
pub(super) fn by_pieces(g: &mut Graph, state: &State) -> Result<Vec<State>, Option<String>> {
    let mut reason = None;
    for (i, unknown) in numeric::single_unknowns(g, state) {
        let leaf = g.get_leaf(unknown);
        let inner = numeric::innermost(g, state.equations[i].rhs, leaf);
        for z in inner.into_iter().chain([leaf]) {
            match solved_for(g, state, i, z) {
                Ok(next) => return Ok(next),
                Err(why) if z == leaf => {
                    reason.get_or_insert(why);
                }
                Err(_) => {}
            }
        }
    }
    Err(reason)
}

/// The states in which equation `i` is solved for the expression `z`, one for each piece.
fn solved_for(g: &mut Graph, state: &State, i: usize, z: Id) -> Result<Vec<State>, String> {
    let e = state.equations[i].clone();
    let bound = bind(g, state, i, z).map_err(|why| explain(g, &e, z, &why))?;
    let found = cells(g, bound.restored, bound.variable).map_err(|why| explain(g, &e, z, &why))?;
    let pieces = Pieces::new(g, &bound, &found);
    if pieces.signs.len() > MOST {
        return Err(too_many(g, &e, z, pieces.signs.len()));
    }
    let (known, rhs, name) = (show(g, e.known), show(g, e.rhs), show(g, z));
    let step = format!(
        "{known} = {rhs} is monotone on {} pieces of {name}: solved numerically on each",
        pieces.signs.len()
    );
    let states = (0..pieces.signs.len()).map(|k| {
        let (root, within) = pieces.root(g, &bound, e.known, k);
        let mut s = state.clone();
        s.equations[i] = Equation { known: root, rhs: z, modulo_turn: false };
        s.solution.known.entry(e.rhs).or_insert(e.known);
        s.solution.known.entry(z).or_insert(root);
        s.solution.conditions.extend(within.conditions.iter().map(|c| Condition(*c)));
        s.solution.pieces.push(within);
        s.solution.steps.push(step.clone());
        s
    });
    Ok(states.collect())
}

/// The ends of the pieces of a function, one more than there are pieces, and whether it rises in each.
struct Pieces {
    ends: Vec<Id>,
    signs: Vec<i64>,
}

impl Pieces {
    fn new(g: &mut Graph, bound: &Bound, cells: &[Cell]) -> Pieces {
        let tower = tower(g, bound.body, bound.variable);
        let (mut ends, mut signs): (Vec<Id>, Vec<i64>) = (vec![], vec![]);
        for cell in cells {
            let [lo, hi] = [cell.range.lo, cell.range.hi].map(|x| end(g, x));
            let (inner, inner_signs) = turning_points(g, bound.variable, &tower, cell);
            // Across an end of the cell the function goes on as it did, or it turns there.
            if signs.last() == inner_signs.first() {
                ends.pop();
                signs.pop();
            }
            if ends.is_empty() {
                ends.push(lo);
            }
            ends.extend(inner.into_iter().chain([hi]));
            signs.extend(inner_signs);
        }
        let mut pieces = Pieces { ends, signs };
        pieces.drop_empty(g);
        pieces
    }

    /// Leaves out pieces without width, where that is known of them, and takes those on both sides together.
    fn drop_empty(&mut self, g: &Graph) {
        let constant = |id: Id| g.deps(id) == 0;
        let empty = |ends: &[Id]| {
            let values = [ends[0], ends[1]].map(|id| evaluate::<f64>(g, id, &|_| f64::NAN));
            constant(ends[0]) && constant(ends[1]) && values[0] >= values[1]
        };
        while let Some(k) = self.ends.windows(2).position(empty).filter(|_| self.signs.len() > 1) {
            self.signs.remove(k);
            self.ends.remove(if k == 0 { 0 } else { k });
            if k > 0 && k < self.signs.len() {
                self.signs.remove(k);
                self.ends.remove(k);
            }
        }
    }

    /// Whether a piece may be without width for some parameters.
    fn may_vanish(&self, g: &Graph, k: usize) -> bool {
        g.range(self.ends[k]).hi >= g.range(self.ends[k + 1]).lo
    }

    fn width(&self, g: &mut Graph, k: usize) -> Id {
        g.sub(self.ends[k + 1], self.ends[k])
    }

    /// Where a piece ends: if the one after it is without width, where the one after that ends.
    fn last(&self, g: &mut Graph, k: usize) -> Id {
        if k + 2 >= self.signs.len() || !self.may_vanish(g, k + 1) {
            return self.ends[k + 1];
        }
        let (width, beyond) = (self.width(g, k + 1), self.last(g, k + 2));
        g.if_positive(width, self.ends[k + 1], beyond)
    }

    /// The root on a piece, and what tells that it is one.
    fn root(&self, g: &mut Graph, bound: &Bound, known: Id, k: usize) -> (Id, Within) {
        let sign = Q::int(self.signs[k]);
        let [body, target] = [bound.body, known].map(|id| g.sum(Q::ZERO, &[(sign, id)]));
        let slope = crate::derivative::derivative(g, body, bound.variable);
        let (lo, hi) = (self.ends[k], self.last(g, k));
        let folds = self.signs.len() > 1;
        let root = g.root(Root {
            variable: bound.variable,
            body,
            slope,
            target,
            lo,
            hi,
            inside: false,
            folds,
        });
        let mut within = Within { of: self.signs.len(), ..Within::default() };
        if k > 0 {
            within.conditions.push(g.sub(root, lo));
        }
        if k + 1 < self.signs.len() {
            within.conditions.push(g.sub(hi, root));
        }
        if self.may_vanish(g, k) {
            within.widths.push(g.sub(hi, lo));
        }
        // Behind a piece without width the function goes on as before it.
        if k > 1 && self.may_vanish(g, k - 1) {
            within.widths.push(self.width(g, k - 1));
        }
        (root, within)
    }
}

/// The turning points in a cell, and in which direction the function goes before, between and after them.
///
/// From the highest derivative that is known down to the slope: on each piece on which one is monotone, the one before it
/// has at most one zero.
fn turning_points(g: &mut Graph, variable: Leaf, tower: &[Id], cell: &Cell) -> (Vec<Id>, Vec<i64>) {
    let [first, last] = [cell.range.lo, cell.range.hi].map(|x| end(g, x));
    let (mut points, mut signs) = (vec![], vec![cell.sign]);
    for pair in tower[..=cell.order].windows(2).rev() {
        let ends: Vec<Id> =
            std::iter::once(first).chain(points.iter().copied()).chain([last]).collect();
        points = ends
            .windows(2)
            .zip(&signs)
            .map(|(ends, sign)| {
                let [body, slope] =
                    [pair[0], pair[1]].map(|id| g.sum(Q::ZERO, &[(Q::int(*sign), id)]));
                let (target, lo, hi) = (g.int(0), ends[0], ends[1]);
                let root =
                    Root { variable, body, slope, target, lo, hi, inside: true, folds: false };
                fixed(g, root)
            })
            .collect();
        signs.insert(0, -signs[0]);
    }
    (points, signs)
}

/// A root, as a number if it depends on nothing.
fn fixed(g: &mut Graph, root: Root) -> Id {
    let id = g.root(root);
    if g.deps(id) != 0 {
        return id;
    }
    let value = evaluate::<Dd>(g, id, &|_| Dd::from_f64(f64::NAN)).to_f64();
    end(g, value)
}

fn explain(g: &Graph, e: &Equation, z: Id, why: &Unproven) -> String {
    let way = match &why.unbounded {
        Some(p) => format!("Declare a domain of `{p}`, as in `#[sampler({p} in 0.0..=10.0)]`"),
        None => "Narrow the domains of the parameters, or write one sampler for each piece on which the map is monotone".to_owned(),
    };
    format!(
        "`{}` has no closed inverse, and a numerical one needs a proof of where it increases and where it decreases with {}: there is none for {}. {way}",
        show(g, e.rhs),
        show(g, z),
        why.place,
    )
}

fn too_many(g: &Graph, e: &Equation, z: Id, pieces: usize) -> String {
    format!(
        "`{}` has no closed inverse, and a numerical one has a root for each piece of {} on which it is monotone: there may be {pieces}, and {MOST} are allowed. Narrow the domains of the parameters, or write one sampler for some of the pieces each",
        show(g, e.rhs),
        show(g, z),
    )
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    fn item(domain: &str, body: &str) -> Result<Item, String> {
        let text = format!("fn turning(u: [Uniform; 1], k: f64) -> f64 {{ {body} }}");
        Item::new(domain.parse().unwrap(), text.parse().unwrap(), true)
    }

    /// Compares the preimages of points with those that a scan of the forward map finds; says how many there were at most.
    fn scanned(item: &Item, k: f64) -> usize {
        let forward = |u: f64| item.forward(&[k], &[u]).unwrap()[0];
        let mut most = 0;
        const STEPS: usize = 4000;
        for i in 0..60 {
            let x = forward((f64::from(i) + 0.37) / 60.0);
            let place = |n: usize| n as f64 / STEPS as f64;
            let across = |n: &usize| (forward(place(*n)) > x) != (forward(place(n + 1)) > x);
            let expected: Vec<usize> = (0..STEPS).filter(across).collect();
            let mut found: Vec<f64> = item.preimages(&[k], &[x]).iter().map(|u| u[0]).collect();
            found.sort_by(f64::total_cmp);
            assert_eq!(found.len(), expected.len(), "{k}: {x} has {found:?}, not {expected:?}");
            for (u, n) in found.iter().zip(&expected) {
                let near = place(*n) - 1e-12..=place(n + 1) + 1e-12;
                assert!(near.contains(u), "{k}: {x} has {u}");
                assert!((forward(*u) - x).abs() < 1e-14, "{k}: {u} leads to {}", forward(*u));
            }
            most = most.max(found.len());
        }
        most
    }

    #[test]
    fn a_parameter_moves_the_turning_points() {
        let item = item("k in 0.0..=8.0", "u[0].powi(5) - k * u[0].powi(2) + u[0].exp()").unwrap();
        assert_eq!([0.0, 1.0, 2.0, 8.0].map(|k| scanned(&item, k)), [1, 1, 3, 2]);
    }

    #[test]
    fn turning_points_that_appear_and_vanish() {
        let body = "(u[0] - 0.3).powi(3) + 0.1 * k * (u[0].powi(2).sin() + u[0])";
        let item = item("k in -0.5..=0.5", body).unwrap();
        let most = [-0.5, -0.1, -1e-3, 0.0, 1e-3, 0.1, 0.5].map(|k| scanned(&item, k));
        assert!(most[1] > 1 && most[3..].iter().all(|n| *n == 1), "{most:?}");
    }

    #[test]
    fn a_sine_of_many_turns() {
        let item = item("k in 0.9..=1.1", "(16.0 * u[0]).sin() * k + u[0]").unwrap();
        assert_eq!(item.derived[0].preimages.len(), 6);
        assert!([0.9, 1.0, 1.1].iter().all(|k| scanned(&item, *k) >= 5));
        let steps = &item.derived[0].steps;
        assert!(steps[0].ends_with("on 6 pieces of u: solved numerically on each"), "{steps:?}");
    }

    #[test]
    fn the_density_is_one_over_the_slopes() {
        let item = item("k in 0.0..=1.0", "u[0].powi(5) - u[0] + k * 0.1 * u[0].sin()").unwrap();
        let (k, x) = (0.4, -0.3);
        let us = item.preimages(&[k], &[x]);
        let slope = |u: f64| 5.0 * u.powi(4) - 1.0 + k * 0.1 * u.cos();
        let expected: f64 = us.iter().map(|u| 1.0 / slope(u[0]).abs()).sum();
        assert_eq!(us.len(), 2);
        assert!((item.pdf(&[k], &[x]) / expected - 1.0).abs() < 1e-13);
        // Beyond the turning point there is nothing.
        assert_eq!(item.pdf(&[k], &[-0.6]), 0.0);
    }

    #[test]
    fn a_map_of_all_numbers() {
        let text = "fn bent(x: f64, k: f64) -> f64 { x.powi(5) - k * x }";
        let map =
            Item::new("k in 0.0..=2.0".parse().unwrap(), text.parse().unwrap(), false).unwrap();
        for (k, x, count) in [(0.0, 0.3, 1), (0.5, 0.01, 3), (2.0, -0.5, 3), (2.0, 1e60, 1)] {
            let found = map.preimages(&[k], &[x]);
            assert_eq!(found.len(), count, "{k} {x}: {found:?}");
            for t in found {
                let back = map.forward(&[k], &t).unwrap()[0];
                assert!((back - x).abs() <= 1e-14 * x.abs(), "{k}: {t:?} leads to {back}, not {x}");
            }
        }
    }

    #[test]
    fn what_turns_too_often_or_nobody_knows_where_is_refused() {
        let refused = |domain: &str, body: &str| item(domain, body).err().unwrap();
        let often = refused("k in 0.9..=1.1", "(30.0 * u[0]).sin() * k + u[0]");
        assert!(often.contains("there may be 11, and 8 are allowed"), "{often}");
        let unknown = refused("", "(k * u[0]).sin() + u[0]");
        assert!(unknown.contains("where it decreases with u"), "{unknown}");
        assert!(unknown.contains("Declare a domain of `k`"), "{unknown}");
    }
}
