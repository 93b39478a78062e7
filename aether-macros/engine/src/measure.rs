//! How accurate a form of an expression is: its values in double precision against double-double, at
//! many points at once.

use std::collections::HashMap;
use std::rc::Rc;

use crate::eval::node_value;
use crate::expr::{Graph, Id, Leaf, children};
use crate::number::{Dd, Number};

/// An input assignment in double precision.
pub type Inputs = HashMap<Leaf, f64>;

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

    /// How far a form is from the true values. Points whose truth is not finite are left out, and a
    /// value that is no number is infinitely wrong.
    pub fn loss(&mut self, g: &Graph, form: Id, truth: &[f64]) -> Loss {
        self.loss_where(g, form, truth, |_| true)
    }

    /// The same over those of the points that `keep` says.
    pub fn loss_where(
        &mut self,
        g: &Graph,
        form: Id,
        truth: &[f64],
        keep: impl Fn(&Inputs) -> bool,
    ) -> Loss {
        let values = self.double.values(g, form, &self.points);
        let (mut bits, mut worst, mut count) = (0.0, 0.0f64, 0);
        for ((v, t), point) in values.iter().zip(truth).zip(&self.points) {
            if !t.is_finite() || !keep(point) {
                continue;
            }
            let e = if v == t { 0.0 } else { ((v - t) / t).abs() };
            let e = if e.is_finite() { e } else { 1e300 };
            bits += libm::log2(1.0 + e / f64::EPSILON);
            worst = worst.max(e);
            count += 1;
        }
        Loss { bits: bits / f64::from(count.max(1)), worst }
    }
}

/// Values by node, one a point.
struct Table<T> {
    known: HashMap<Id, Rc<[T]>>,
}

impl<T: Number> Table<T> {
    fn new() -> Self {
        Table { known: HashMap::new() }
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
