//! How accurate a form of an expression is: its values in double precision against double-double, at
//! many points at once.

use std::cell::OnceCell;
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
        let mut errors = Vec::with_capacity(truth.len());
        let mut worst = 0.0;
        // This is where most of the compiler's time goes, and it runs unoptimised.
        #[allow(clippy::needless_range_loop)]
        for k in 0..truth.len() {
            let (v, t) = (values[k], truth[k]);
            let error = if !t.is_finite() {
                None
            } else if v == t {
                Some(0.0)
            } else {
                let e = ((v - t) / t).abs();
                Some(if e.is_finite() { e } else { 1e300 })
            };
            if let Some(e) = error
                && e > worst
            {
                worst = e;
            }
            errors.push(error);
        }
        Errors { errors, worst, bits: OnceCell::new() }
    }
}

/// Relative errors of a form, one a point. Points whose truth is not finite are left out, and a value that is
/// no number is infinitely wrong.
pub struct Errors {
    errors: Vec<Option<f64>>,
    worst: f64,
    /// The bits that they lose. Logarithms are expensive, and often nobody asks.
    bits: OnceCell<Vec<f64>>,
}

impl Errors {
    /// The largest.
    pub fn worst(&self) -> f64 {
        self.worst
    }

    /// At a point; zero where there is no truth.
    pub fn at(&self, k: usize) -> f64 {
        self.errors[k].unwrap_or(0.0)
    }

    /// Over all points.
    pub fn loss(&self) -> Loss {
        self.over(|_| true)
    }

    /// Over those of the points for which `kept` is `side`.
    pub fn loss_where(&self, kept: &[bool], side: bool) -> Loss {
        self.over(|k| kept[k] == side)
    }

    fn over(&self, keep: impl Fn(usize) -> bool) -> Loss {
        let lost = |e: f64| if e == 0.0 { 0.0 } else { libm::log2(1.0 + e / f64::EPSILON) };
        let lost = |e: &Option<f64>| e.map_or(0.0, lost);
        let all = self.bits.get_or_init(|| self.errors.iter().map(lost).collect());
        let (mut bits, mut worst, mut count) = (0.0, 0.0f64, 0);
        for (k, error) in self.errors.iter().enumerate() {
            if let (Some(e), true) = (error, keep(k)) {
                bits += all[k];
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
