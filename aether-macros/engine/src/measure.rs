//! How accurate a form of an expression is: its values in double and in single precision against
//! double-double, at many points at once.

use std::cell::OnceCell;
use std::rc::Rc;

use crate::eval::Evaluated;
use crate::expr::{Graph, Id, Leaf};
use crate::hash::Map;
use crate::number::{Dd, Number, Single};

/// An input assignment in double precision.
pub type Inputs = Map<Leaf, f64>;

/// How inaccurate a form is in one precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Mean number of bits that are lost.
    pub bits: f64,
    /// The largest relative error; in single precision as many units of the double.
    pub worst: f64,
}

/// How inaccurate a form is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// In double precision.
    pub double: Part,
    /// In single precision.
    pub single: Part,
}

impl Loss {
    /// The larger of both worst errors.
    pub fn worst(&self) -> f64 {
        self.double.worst.max(self.single.worst)
    }

    /// Both parts.
    pub fn parts(&self) -> [Part; 2] {
        [self.double, self.single]
    }
}

/// A unit in the last place of a single over that of a double.
const UNITS: f64 = f32::EPSILON as f64 / f64::EPSILON;

/// The values of expressions at fixed points. Equal expressions are one node of the graph, so each
/// is evaluated once, in however many forms it occurs.
pub struct Measure {
    points: Vec<Inputs>,
    /// How many of the points, the first ones, are for double precision; the others are for single.
    doubles: usize,
    double: Table<f64>,
    single: Table<Single>,
    exact: Table<Dd>,
    /// The errors of forms by the expression that they are forms of.
    judged: Map<(Id, Id), Rc<Errors>>,
    /// What [`crate::stabilise`] chose among forms, by these and the error that is good enough.
    pub(crate) chosen: Map<(Vec<Id>, u64), Id>,
}

impl Measure {
    /// For these points in double, and these in single precision, whose inputs are rounded to it.
    pub fn new(mut points: Vec<Inputs>, single: Vec<Inputs>) -> Measure {
        let doubles = points.len();
        points.extend(single);
        let (double, single, exact) = (Table::new(), Table::new(), Table::new());
        let (judged, chosen) = (Map::default(), Map::default());
        Measure { points, doubles, double, single, exact, judged, chosen }
    }

    /// The points, of both precisions.
    pub fn points(&self) -> &[Inputs] {
        &self.points
    }

    /// How many of the points, the first ones, are for double precision.
    pub fn doubles(&self) -> usize {
        self.doubles
    }

    /// For those of the points that `keep` says.
    pub fn subset(&self, keep: impl Fn(&Inputs) -> bool) -> Measure {
        let kept = |points: &[Inputs]| points.iter().filter(|p| keep(p)).cloned().collect();
        let (double, single) = self.points.split_at(self.doubles);
        Measure::new(kept(double), kept(single))
    }

    /// The values of an expression, each in the precision of its point.
    pub fn values(&mut self, g: &Graph, id: Id) -> Vec<f64> {
        let (double, single) = self.points.split_at(self.doubles);
        let double = self.double.values(g, id, double);
        let single = self.single.values(g, id, single);
        double.iter().copied().chain(single.iter().map(|x| x.to_f64())).collect()
    }

    /// The values of an expression, through double-double.
    pub fn truths(&mut self, g: &Graph, id: Id) -> Vec<f64> {
        self.precisely(g, id).iter().map(|x| x.to_f64()).collect()
    }

    /// The values of an expression in double-double.
    pub fn precisely(&mut self, g: &Graph, id: Id) -> Rc<[Dd]> {
        self.exact.values(g, id, &self.points)
    }

    /// The true values of the first of equal forms, where a sum loses even the digits of double-double in it: by
    /// a form whose own value agrees with that of double-double. `None` if all are as given.
    pub fn mended(&mut self, g: &Graph, truth: &[f64], forms: &[Id]) -> Option<Vec<f64>> {
        let first = self.values(g, forms[0]);
        let suspect =
            |k: usize| (first[k] - truth[k]).abs() > 1e-3 * truth[k].abs() || truth[k] == 0.0;
        let suspects: Vec<usize> = (0..truth.len()).filter(|&k| suspect(k)).collect();
        let mut mended = None;
        for &form in if suspects.is_empty() { &[] } else { &forms[1..] } {
            let (values, exact) = (self.values(g, form), self.truths(g, form));
            for &k in &suspects {
                let (v, t) = (values[k], exact[k]);
                let agrees = self.scaled(k, (v - t).abs()) <= 1e-12 * t.abs() && t != 0.0;
                if agrees && (t - truth[k]).abs() > 1e-10 * t.abs() {
                    mended.get_or_insert_with(|| truth.to_vec())[k] = t;
                }
            }
        }
        mended
    }

    /// A gap between values at a point, where it is one of single precision as many units of the double.
    pub fn scaled(&self, k: usize, gap: f64) -> f64 {
        if k < self.doubles { gap } else { gap / UNITS }
    }

    /// How far a form is from the true values, over all points.
    pub fn loss(&mut self, g: &Graph, form: Id, truth: &[f64]) -> Loss {
        self.errors(g, form, truth).loss()
    }

    /// How far a form of an expression is from the true values of that at each point.
    pub fn errors_of(&mut self, g: &Graph, form: Id, of: Id) -> Rc<Errors> {
        if let Some(known) = self.judged.get(&(form, of)) {
            return known.clone();
        }
        let truth = self.truths(g, of);
        let errors = Rc::new(self.errors(g, form, &truth));
        self.judged.insert((form, of), errors.clone());
        errors
    }

    /// How far a form is from the true values at each point.
    pub fn errors(&mut self, g: &Graph, form: Id, truth: &[f64]) -> Errors {
        let values = self.values(g, form);
        let mut errors = Vec::with_capacity(truth.len());
        let mut worst = 0.0;
        // This is where most of the compiler's time goes, and it runs unoptimised.
        #[allow(clippy::needless_range_loop)]
        for k in 0..truth.len() {
            let (v, t) = (values[k], truth[k]);
            let single = k >= self.doubles;
            let error = if !t.is_finite() || single && !held(t) {
                None
            } else if v == t {
                Some(0.0)
            } else {
                let e = self.scaled(k, ((v - t) / t).abs());
                Some(if e.is_finite() { e } else { NO_VALUE })
            };
            if let Some(e) = error
                && e > worst
            {
                worst = e;
            }
            errors.push(error);
        }
        let (bits, whole) = (OnceCell::new(), OnceCell::new());
        Errors { errors, doubles: self.doubles, worst, bits, whole }
    }
}

/// Whether a value is one that normal numbers of single precision have.
fn held(t: f64) -> bool {
    t == 0.0 || (f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&t.abs())
}

/// The relative error of what is no number.
const NO_VALUE: f64 = 1e300;

/// Relative errors of a form, one a point. Points whose truth is not finite are left out, and a value that is
/// no number is infinitely wrong.
pub struct Errors {
    errors: Vec<Option<f64>>,
    doubles: usize,
    worst: f64,
    /// The bits that they lose. Logarithms are expensive, and often nobody asks.
    bits: OnceCell<Vec<f64>>,
    whole: OnceCell<Loss>,
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

    /// Whether the form has no value at a point.
    pub fn is_unknown(&self, k: usize) -> bool {
        self.errors[k] == Some(NO_VALUE)
    }

    /// Over all points.
    pub fn loss(&self) -> Loss {
        *self.whole.get_or_init(|| self.over(|_| true))
    }

    /// Over those of the points for which `kept` is `side`.
    pub fn loss_where(&self, kept: &[bool], side: bool) -> Loss {
        self.over(|k| kept[k] == side)
    }

    fn over(&self, keep: impl Fn(usize) -> bool) -> Loss {
        // What has no value is a finite loss, too: a form with fewer such points is better.
        let lost = |e: f64| match e {
            0.0 => 0.0,
            _ => libm::log2(1.0 + e.min(f64::EPSILON * NO_VALUE) / f64::EPSILON),
        };
        let lost = |e: &Option<f64>| e.map_or(0.0, lost);
        let all = self.bits.get_or_init(|| self.errors.iter().map(lost).collect());
        let part = |points: std::ops::Range<usize>| {
            let (mut bits, mut worst, mut count) = (0.0, 0.0f64, 0);
            for k in points {
                if let (Some(e), true) = (self.errors[k], keep(k)) {
                    bits += all[k];
                    worst = worst.max(e);
                    count += 1;
                }
            }
            Part { bits: bits / f64::from(count.max(1)), worst }
        };
        Loss { double: part(0..self.doubles), single: part(self.doubles..self.errors.len()) }
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
        let inputs =
            |l: Leaf, k: usize| T::from_f64(points[k].get(&l).copied().unwrap_or(f64::NAN));
        let like = vec![T::from_f64(0.0); points.len()];
        let node = Evaluated { graph: g, inputs: &inputs, like: &like };
        let values = node.values(id, &mut |part| self.values(g, part, points));
        let values: Rc<[T]> = values.into();
        self.known.insert(id, values.clone());
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    #[test]
    fn of_two_forms_the_one_with_fewer_points_without_a_value_is_better() {
        let mut g = Graph::new();
        let x = g.leaf(Leaf::Param(0), "x", Interval::new(0.0, 1e300));
        let points = [1.0, 1e15, 1e30].map(|x| [(Leaf::Param(0), x)].into_iter().collect());
        let mut measure = Measure::new(vec![], points.to_vec());
        // In single precision the square is out of range at the last point, and the cube at the last two.
        let [square, cube] = [2, 3].map(|n| {
            let power = g.powi(x, n);
            measure.loss(&g, power, &[1.0, 1e30, 1e30]).single
        });
        assert!(square.worst == NO_VALUE && cube.worst == NO_VALUE);
        assert!(square.bits.is_finite() && square.bits + 100.0 < cube.bits, "{square:?} {cube:?}");
    }
}
