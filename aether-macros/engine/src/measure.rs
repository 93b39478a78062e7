//! How accurate a form of an expression is: its values in double precision against double-double, at
//! many points at once.

use std::rc::Rc;

use crate::eval::node_value;
use crate::expr::{Graph, Id, Leaf, children};
use crate::hash::Map;
use crate::number::{Dd, Number};

/// An input assignment in double precision.
pub type Inputs = Map<Leaf, f64>;

/// How inaccurate a form is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// Mean number of bits that are lost.
    pub bits: f64,
    /// The largest relative error.
    pub worst: f64,
}

/// The values of expressions at fixed points. Equal expressions are one node of the graph, so each
/// is evaluated once, in however many forms it occurs.
pub struct Measure {
    points: Vec<Inputs>,
    double: Table<f64>,
    exact: Table<Dd>,
}

impl Measure {
    /// For these points.
    pub fn new(points: Vec<Inputs>) -> Measure {
        Measure { points, double: Table::new(), exact: Table::new() }
    }

    /// The points.
    pub fn points(&self) -> &[Inputs] {
        &self.points
    }

    /// For those of the points that `keep` says.
    pub fn subset(&self, keep: impl Fn(&Inputs) -> bool) -> Measure {
        Measure::new(self.points.iter().filter(|p| keep(p)).cloned().collect())
    }

    /// The values of an expression in double precision.
    pub fn values(&mut self, g: &Graph, id: Id) -> Rc<[f64]> {
        self.double.values(g, id, &self.points)
    }

    /// The values of an expression, through double-double.
    pub fn truths(&mut self, g: &Graph, id: Id) -> Vec<f64> {
        self.exact.values(g, id, &self.points).iter().map(|x| x.to_f64()).collect()
    }

    /// How far a form is from the true values, over all points.
    pub fn loss(&mut self, g: &Graph, form: Id, truth: &[f64]) -> Loss {
        self.errors(g, form, truth).loss()
    }

    /// How far a form is from the true values at each point.
    pub fn errors(&mut self, g: &Graph, form: Id, truth: &[f64]) -> Errors {
        let values = self.double.values(g, form, &self.points);
        let error = |(v, t): (&f64, &f64)| {
            if v == t && t.is_finite() {
                return Some((0.0, 0.0));
            }
            if !t.is_finite() {
                return None;
            }
            let e = ((v - t) / t).abs();
            let e = if e.is_finite() { e } else { 1e300 };
            Some((e, libm::log2(1.0 + e / f64::EPSILON)))
        };
        Errors(values.iter().zip(truth).map(error).collect())
    }
}

/// Relative errors of a form and the bits that they lose, one a point. Points whose truth is not finite
/// are left out, and a value that is no number is infinitely wrong.
pub struct Errors(Vec<Option<(f64, f64)>>);

impl Errors {
    /// Over all points.
    pub fn loss(&self) -> Loss {
        self.over(|_| true)
    }

    /// Over those of the points for which `kept` is `side`.
    pub fn loss_where(&self, kept: &[bool], side: bool) -> Loss {
        self.over(|k| kept[k] == side)
    }

    fn over(&self, keep: impl Fn(usize) -> bool) -> Loss {
        let (mut bits, mut worst, mut count) = (0.0, 0.0f64, 0);
        for (k, error) in self.0.iter().enumerate() {
            if let (Some((e, lost)), true) = (error, keep(k)) {
                bits += lost;
                worst = worst.max(*e);
                count += 1;
            }
        }
        Loss { bits: bits / f64::from(count.max(1)), worst }
    }
}

/// Values by node, one a point.
struct Table<T> {
    known: Map<Id, Rc<[T]>>,
}

impl<T: Number> Table<T> {
    fn new() -> Self {
        Table { known: Map::default() }
    }

    fn values(&mut self, g: &Graph, id: Id, points: &[Inputs]) -> Rc<[T]> {
        if let Some(known) = self.known.get(&id) {
            return known.clone();
        }
        let parts: Vec<(Id, Rc<[T]>)> =
            children(g.node(id)).into_iter().map(|c| (c, self.values(g, c, points))).collect();
        let at = |k: usize| {
            let input = |l: Leaf| T::from_f64(points[k].get(&l).copied().unwrap_or(f64::NAN));
            let part = |id: Id| {
                let found = parts.iter().find(|(c, _)| *c == id);
                found.map_or(T::from_f64(f64::NAN), |(_, v)| v[k])
            };
            node_value(g, id, &input, &mut { part })
        };
        let values: Rc<[T]> = (0..points.len()).map(at).collect();
        self.known.insert(id, values.clone());
        values
    }
}
