//! Choosing among equal forms of an expression by measured error.
//!
//! Every sum and logarithm is rewritten in the ways that experts use (expm1, ln_1p, conjugates,
//! multiplying out and factoring, half angles); each form is evaluated in double precision on the
//! test points and compared with double-double; a form is taken if it is clearly more accurate.
//! The graph bounds the number of forms, so the outcome is the same on every machine.

mod conjugates;
mod ends;
mod forms;
mod turned;

pub(crate) use conjugates::over_sum;
pub(crate) use ends::between_ends;
use forms::other_forms;
pub(crate) use turned::of_turn;
use turned::{around_a_pole, by_turns};

mod angles;
mod collect;
mod exponential;
mod hyperbolic;

pub(crate) use exponential::by_size;

use std::rc::Rc;

use crate::expr::{Graph, Id, Leaf, Node};
use crate::hash::Map;
use crate::jacobian::cost;
use crate::measure::{Errors, Loss, Measure};
use crate::rational::Q;
use crate::sorted;

/// Errors up to this many units in the last place are not worth a rewrite.
pub(crate) const GOOD: f64 = 64.0 * f64::EPSILON;

/// How much larger the worst error of a form may be that is as good as another on average.
const FAR: f64 = 256.0;

/// The most forms that are tried for an expression and its parts: what is so long that more would help takes
/// seconds to compile.
const MOST_FORMS: usize = 400;

/// The expression with every part in its most accurate form.
pub fn stabilise(g: &mut Graph, id: Id, measure: &mut Measure) -> Id {
    stabilise_to(g, id, measure, GOOD)
}

/// The same, where only errors up to `good` are not worth a rewrite.
pub fn stabilise_to(g: &mut Graph, id: Id, measure: &mut Measure, good: f64) -> Id {
    // Most expressions are fine as they are: measure once before taking them apart.
    let truth = measure.truths(g, id);
    if measure.errors(g, id, &truth).worst() <= good {
        return id;
    }
    stabilise_knowing(g, id, measure, good, &Map::default())
}

/// The same, where `told` are forms of single parts that no rule finds.
pub fn stabilise_knowing(
    g: &mut Graph,
    id: Id,
    measure: &mut Measure,
    good: f64,
    told: &Map<Id, Id>,
) -> Id {
    Search { measure, good, turns: true, told, left: MOST_FORMS, memo: Map::default() }
        .rebuild(g, id, 3)
}

/// The coordinates of a point, each with every part in its most accurate form, if the point as a
/// whole needs it: an error counts relative to the length of the vector, and where one of a direction has fewer
/// unknowns than the two others, as its height, theirs relative to their own: next to a pole
/// they tell where the point is.
///
/// On a line a coordinate's zeros are the point's, and no point that is tried may be one: sines and
/// cosines of fractions of a turn are taken as such. `told` are forms of single parts that no rule finds.
pub fn stabilise_point(
    g: &mut Graph,
    coordinates: &[Id],
    measure: &mut Measure,
    told: &Map<Id, Id>,
) -> Vec<Id> {
    let by_turns = match *coordinates {
        [single] => vec![by_turns(g, single)],
        _ => coordinates.to_vec(),
    };
    let coordinates = &by_turns[..];
    let truth: Vec<Vec<f64>> = coordinates.iter().map(|&c| measure.truths(g, c)).collect();
    let values: Vec<_> = coordinates.iter().map(|&c| measure.values(g, c)).collect();
    let points = measure.points().len();
    let worst = |members: &[usize]| {
        let error = |k: usize| {
            let norm = members.iter().map(|&i| truth[i][k] * truth[i][k]).sum::<f64>().sqrt();
            let gap = |&i: &usize| (values[i][k] - truth[i][k]).abs();
            let error = measure.scaled(k, members.iter().map(gap).fold(0.0, nan_max));
            if error == 0.0 || !norm.is_finite() { 0.0 } else { error / norm }
        };
        (0..points).map(error).fold(0.0, nan_max)
    };
    let all: Vec<usize> = (0..coordinates.len()).collect();
    let length = |k: usize| truth.iter().map(|t| t[k] * t[k]).sum::<f64>();
    let unit = (0..points).all(|k| !length(k).is_finite() || (length(k) - 1.0).abs() < 1e-9);
    let around = if unit { around_a_pole(g, coordinates) } else { None };
    let at_poles = around.filter(|pair| worst(pair) > GOOD).map_or(vec![], |pair| pair.to_vec());
    let concerned = if worst(&all) <= GOOD { at_poles } else { all };
    let left = MOST_FORMS;
    let mut search = Search { measure, good: GOOD, turns: false, told, left, memo: Map::default() };
    let mut stable = coordinates.to_vec();
    for &k in &concerned {
        stable[k] = search.rebuild(g, stable[k], 3);
    }
    // A height may be what is left of one at a pole.
    let height = (0..3).find(|k| around.is_some_and(|pair| !pair.contains(k)));
    if let Some(k) = height.filter(|k| concerned.contains(k)) {
        let forms = [Q::ONE, Q::int(-1)].map(|side| {
            let gap = g.sum(side, &[(Q::int(-1), coordinates[k])]);
            let gap = search.rebuild(g, gap, 3);
            g.sum(side, &[(Q::int(-1), gap)])
        });
        stable[k] =
            nearest(g, &[stable[k], coordinates[k], forms[0], forms[1]], &truth[k], measure);
    }
    stable
}

/// The cheapest of the forms with the least error at any point, in double and then in single precision.
fn nearest(g: &Graph, forms: &[Id], truth: &[f64], measure: &mut Measure) -> Id {
    let doubles = measure.doubles();
    let mut scored: Vec<(Id, [f64; 2])> = Vec::new();
    for &form in forms {
        let values = measure.values(g, form);
        let mut worst = [f64::EPSILON; 2];
        for (k, (v, t)) in values.iter().zip(truth).enumerate().filter(|(_, (_, t))| t.is_finite())
        {
            let part = &mut worst[usize::from(k >= doubles)];
            *part = nan_max(*part, measure.scaled(k, (v - t).abs()));
        }
        scored.push((form, worst));
    }
    for part in 0..2 {
        let least = scored.iter().map(|s| s.1[part]).fold(f64::INFINITY, f64::min);
        scored.retain(|s| s.1[part] <= 4.0 * least);
    }
    scored.iter().min_by_key(|s| cost(g, s.0)).map_or(forms[0], |s| s.0)
}

/// The larger of two errors; not a number is the largest of all.
fn nan_max(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}

/// A search for better forms.
struct Search<'a> {
    measure: &'a mut Measure,
    good: f64,
    /// Whether sines and cosines of fractions of a turn may be taken as such.
    turns: bool,
    /// Forms of single parts that no rule finds.
    told: &'a Map<Id, Id>,
    /// How many forms may still be tried.
    left: usize,
    /// What was found already, by expression and depth: forms share most of their parts.
    memo: Map<(Id, u8), Id>,
}

impl Search<'_> {
    fn rebuild(&mut self, g: &mut Graph, id: Id, depth: u8) -> Id {
        if let Some(&r) = self.memo.get(&(id, depth)) {
            return r;
        }
        let rebuilt = match g.node(id).clone() {
            Node::Sum(c, terms) => {
                let t: Vec<_> =
                    terms.iter().map(|&(q, t)| (q, self.rebuild(g, t, depth))).collect();
                g.sum(c, &t)
            }
            Node::Product(f) => {
                let f: Vec<_> = f.iter().map(|&(b, e)| (self.rebuild(g, b, depth), e)).collect();
                g.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.rebuild(g, a, depth)).collect();
                g.call(f, &a)
            }
            _ => id,
        };
        let best = self.best_form(g, id, rebuilt, depth);
        self.memo.insert((id, depth), best);
        best
    }

    /// The cheapest among the most accurate forms; a form must be clearly better to be taken.
    fn best_form(&mut self, g: &mut Graph, original: Id, rebuilt: Id, depth: u8) -> Id {
        let mut forms = vec![(original, self.measure.errors_of(g, original, original))];
        if rebuilt != original {
            forms.push((rebuilt, self.measure.errors_of(g, rebuilt, original)));
        }
        let worst = |forms: &[(Id, Rc<Errors>)]| {
            forms.iter().map(|f| f.1.worst()).fold(f64::INFINITY, f64::min)
        };
        if worst(&forms) > self.good && depth > 0 {
            let mut others = other_forms(g, original, self.turns);
            others.extend(self.told.get(&original));
            for form in others {
                let Some(left) = self.left.checked_sub(1) else { break };
                self.left = left;
                // The parts of a new form deserve a look of their own.
                let form = self.children_of(g, form, depth - 1);
                forms.push((form, self.measure.errors_of(g, form, original)));
            }
            if worst(&forms) > self.good
                && let Some(form) = self.by_sign(g, &forms)
            {
                forms.push((form, self.measure.errors_of(g, form, original)));
            }
        }
        if let [(only, _)] = forms[..] {
            return only;
        }
        let ids: Vec<Id> = forms.iter().map(|f| f.0).collect();
        let choice = (ids, self.good.to_bits());
        if let Some(&best) = self.measure.chosen.get(&choice) {
            return best;
        }
        let best = self.cheapest_of_the_best(g, forms);
        self.measure.chosen.insert(choice, best);
        best
    }

    /// The cheapest among the most accurate of equal forms, of which the first is the original.
    fn cheapest_of_the_best(&mut self, g: &Graph, forms: Vec<(Id, Rc<Errors>)>) -> Id {
        let truth = self.measure.truths(g, forms[0].0);
        let ids: Vec<Id> = forms.iter().map(|f| f.0).collect();
        let mut scored: Vec<(Id, Loss)> = match self.measure.mended(g, &truth, &ids) {
            Some(truth) => ids.iter().map(|&f| (f, self.measure.loss(g, f, &truth))).collect(),
            None => forms.iter().map(|f| (f.0, f.1.loss())).collect(),
        };
        // What counts first is double precision; single tells those apart that are as good in it.
        for part in 0..2 {
            let least = scored.iter().map(|s| s.1.parts()[part].bits).fold(f64::INFINITY, f64::min);
            scored.retain(|s| s.1.parts()[part].bits <= least + 0.4);
            let worst =
                scored.iter().map(|s| s.1.parts()[part].worst).fold(f64::INFINITY, f64::min);
            // What is good at every point goes before what is only good on average.
            let limit = if worst <= self.good { self.good } else { FAR * worst };
            scored.retain(|s| s.1.parts()[part].worst <= limit);
        }
        scored.iter().min_by_key(|s| cost(g, s.0)).map_or(ids[0], |s| s.0)
    }

    /// If no form is good everywhere: the one that is best for positive, and the one that is best for
    /// other values of an input, chosen by its sign.
    fn by_sign(&mut self, g: &mut Graph, forms: &[(Id, Rc<Errors>)]) -> Option<Id> {
        // At every point one of them has to be good (where single precision does what it can).
        let hopeless = |k: usize| forms.iter().all(|f| f.1.at(k) > self.good);
        if (0..self.measure.doubles()).any(hopeless) {
            return None;
        }
        let mut inputs: Vec<Leaf> = self.measure.points().first()?.keys().copied().collect();
        sorted::sort(&mut inputs);
        for leaf in inputs {
            let range = g.leaf_range(leaf);
            let varies = g.has(forms[0].0, crate::expr::leaf_bit(leaf));
            if !varies || range.lo >= 0.0 || range.hi <= 0.0 {
                continue;
            }
            let points = self.measure.points().iter();
            let above: Vec<bool> = points.map(|p| p.get(&leaf).is_some_and(|x| *x > 0.0)).collect();
            let yes = best_where(forms, &above, true)?;
            let no = best_where(forms, &above, false)?;
            if yes.0 != no.0 && yes.1.double.worst.max(no.1.double.worst) <= self.good {
                let test = g.get_leaf(leaf);
                return Some(g.if_positive(test, yes.0, no.0));
            }
        }
        None
    }

    fn children_of(&mut self, g: &mut Graph, form: Id, depth: u8) -> Id {
        match g.node(form).clone() {
            Node::Product(f) => {
                let f: Vec<_> = f.iter().map(|&(b, e)| (self.rebuild(g, b, depth), e)).collect();
                g.product(&f)
            }
            Node::Call(f, args) => {
                let a: Vec<_> = args.iter().map(|&a| self.rebuild(g, a, depth)).collect();
                g.call(f, &a)
            }
            Node::Sum(c, terms) if c.is_zero() && terms.len() == 1 => {
                let t = self.children_of(g, terms[0].1, depth);
                g.sum(c, &[(terms[0].0, t)])
            }
            _ => form,
        }
    }
}

/// The form that is most accurate over those of the points for which `kept` is `side`.
fn best_where(forms: &[(Id, Rc<Errors>)], kept: &[bool], side: bool) -> Option<(Id, Loss)> {
    let scored = forms.iter().map(|(f, errors)| (*f, errors.loss_where(kept, side)));
    scored.min_by(|a, b| a.1.double.bits.total_cmp(&b.1.double.bits))
}
