//! The values of roots, at any precision: Newton's method inside a bracket that only shrinks.

use crate::eval::{Evaluated, Evaluator};
use crate::expr::{Graph, Id, Leaf, Root, children, leaf_bit};
use crate::hash::Map;
use crate::monotone::{inputs_of, leaves_of, values_of};
use crate::number::Number;

/// Steps after which a root is as good as it gets; bisection alone needs fewer.
const MAX_STEPS: usize = 160;
/// Stands for infinity as an end.
const HUGE: f64 = 1e300;
/// Stands for zero as an end in a geometric mean.
const TINY: f64 = 1e-300;

/// The value of a root, given the inputs and the values of the root's closed parts.
pub fn root_value<T: Number>(
    graph: &Graph,
    root: &Root,
    inputs: &dyn Fn(Leaf) -> T,
    part: &mut dyn FnMut(Id) -> T,
) -> T {
    let (target, lo, hi) = (part(root.target), part(root.lo), part(root.hi));
    if target.is_nan() || lo.is_nan() || hi.is_nan() {
        return T::from_f64(f64::NAN);
    }
    if !T::from_f64(HUGE).is_finite() {
        let root =
            root_value::<f64>(graph, root, &|l| inputs(l).to_f64(), &mut |id| part(id).to_f64());
        return T::from_f64(root);
    }
    let body = Body::new(graph, root, inputs);
    let body = |t: T| body.at(t);
    if let Some(beyond) = beyond(root, &body, target, lo, hi) {
        return beyond;
    }
    let start = if is_double::<T>() {
        None
    } else {
        // Most steps are as good in double precision.
        let at = |l: Leaf| inputs(l).to_f64();
        let inner = Body::new(graph, root, &at);
        let inner = |t: f64| inner.at(t);
        let t = bracketed(&inner, target.to_f64(), lo.to_f64(), hi.to_f64(), None);
        Some(T::from_f64(t))
    };
    bracketed(&body, target, lo, hi, start)
}

/// The body and the slope of a root as functions of its variable. What does not depend on it is computed once.
struct Body<'a, T> {
    graph: &'a Graph,
    root: &'a Root,
    inputs: &'a dyn Fn(Leaf) -> T,
    /// Every part before the whole.
    steps: Vec<Id>,
    place: Map<Id, usize>,
    closed: Map<Id, T>,
}

impl<'a, T: Number> Body<'a, T> {
    fn new(graph: &'a Graph, root: &'a Root, inputs: &'a dyn Fn(Leaf) -> T) -> Self {
        let mut outside = Evaluator::new(graph, inputs);
        let (steps, place, closed) = (Vec::new(), Map::default(), Map::default());
        let mut found = Body { graph, root, inputs, steps, place, closed };
        let variable = leaf_bit(root.variable);
        let mut open = vec![(root.slope, false), (root.body, false)];
        while let Some((id, ready)) = open.pop() {
            if found.place.contains_key(&id) || found.closed.contains_key(&id) {
                continue;
            }
            if !graph.has(id, variable) {
                found.closed.insert(id, outside.value(id));
            } else if ready {
                found.place.insert(id, found.steps.len());
                found.steps.push(id);
            } else {
                open.push((id, true));
                open.extend(children(graph.node(id)).into_iter().map(|c| (c, false)));
            }
        }
        found
    }

    fn at(&self, t: T) -> (T, T) {
        let inputs = |l: Leaf, _| if l == self.root.variable { t } else { (self.inputs)(l) };
        let node = Evaluated { graph: self.graph, inputs: &inputs, like: &[t] };
        let mut values: Vec<T> = Vec::with_capacity(self.steps.len());
        let known = |values: &[T], id: Id| match self.place.get(&id) {
            Some(place) => values[*place],
            None => self.closed[&id],
        };
        for step in &self.steps {
            let value = node.values(*step, &mut |part| [known(&values, part)]);
            values.extend(value);
        }
        (known(&values, self.root.body), known(&values, self.root.slope))
    }
}

/// Whether `T` has no more digits than a double.
fn is_double<T: Number>() -> bool {
    (T::from_ratio(1, 3) - T::from_f64(1.0 / 3.0)).to_f64() == 0.0
}

/// Points at which the ends of a root are looked at.
const POINTS: u32 = 16;

/// Whether rounding to `T`, which has this unit, puts an end of a root beyond a pole of its body, where values have the
/// sign of the other side: what increases is smaller at the upper end than before it, or larger at the lower one.
pub fn passes_pole<T: Number>(g: &Graph, root: &Root, [end, other]: [Id; 2], unit: f64) -> bool {
    let leaves = leaves_of(g, root.body, root.variable);
    let leaves = [end, other].iter().fold(leaves, |mut leaves, id| {
        let more = inputs_of(g, *id).unwrap_or_default();
        leaves.extend(more.into_iter().filter(|l| !leaves.contains(l)).collect::<Vec<_>>());
        leaves
    });
    let points = if leaves.len() > 1 { POINTS } else { 1 };
    (0..points).any(|n| {
        let at = values_of(g, &leaves, n);
        let number =
            |l: Leaf| T::from_f64(leaves.iter().position(|k| *k == l).map_or(f64::NAN, |k| at[k]));
        let [end, other] = [end, other].map(|id| Evaluator::new(g, &number).value(id).to_f64());
        let body = Body::new(g, root, &number);
        lies_beyond_pole(&|t: T| body.at(t).0, [end, other].map(T::from_f64), unit)
    })
}

/// Whether an end of a range in which a function increases lies beyond a pole that the function has there.
fn lies_beyond_pole<T: Number>(body: &dyn Fn(T) -> T, [end, other]: [T; 2], unit: f64) -> bool {
    let towards = (other - end).to_f64();
    let step = 8.0 * unit * end.to_f64().abs().max(towards.abs());
    let at = |steps: f64| body(end + T::from_f64((steps * step).copysign(towards))).to_f64();
    let [at_end, before, far] = [0.0, 1.0, 8.0].map(at);
    let falls = if towards < 0.0 { at_end < before } else { at_end > before };
    // Next to a zero, where rounding has any sign, values grow with the distance.
    let grows = before.abs() > 2.0 * far.abs();
    step.is_finite() && falls && grows && at_end * before < 0.0 && (at_end - before).is_finite()
}

/// The end, or a number beyond it, if the target is no value of the body between the ends.
fn beyond<T: Number>(
    root: &Root,
    body: &dyn Fn(T) -> (T, T),
    target: T,
    lo: T,
    hi: T,
) -> Option<T> {
    let ((below, from), (above, to)) = (body(lo), body(hi));
    let (end, at_end, slope) = if below >= target {
        (lo, below, from)
    } else if above <= target {
        (hi, above, to)
    } else {
        return None;
    };
    let ends = if below >= target { [lo, hi] } else { [hi, lo] };
    if lies_beyond_pole(&|t| body(t).0, ends, f64::EPSILON) {
        return None;
    }
    if root.inside {
        return Some(end);
    }
    let scale = (hi - lo) / (above - below);
    let scale = if scale.is_finite() && scale.to_f64() > 0.0 { scale } else { hi - lo };
    let excess = target - at_end;
    if root.folds && slope.is_finite() {
        // As the runtime does, by a parabola with this slope.
        let (slope, four) = (slope.abs(), T::from_f64(4.0));
        let square = slope * slope + four * excess.abs() / (scale * (hi - lo));
        let distance = excess * T::from_f64(2.0) / (slope + square.sqrt());
        return Some(if excess.to_f64() == 0.0 { end } else { end + distance });
    }
    Some(end + excess * scale)
}

/// The root of an increasing function whose value is below the target at `lo` and above it at `hi`.
fn bracketed<T: Number>(
    body: &dyn Fn(T) -> (T, T),
    target: T,
    lo: T,
    hi: T,
    start: Option<T>,
) -> T {
    let f = T::from_f64;
    let zero = f(0.0);
    let close = f(if is_double::<T>() { 8e-16 } else { 4e-31 });
    let (mut a, mut b) = (lo.max(f(-HUGE)), hi.min(f(HUGE)));
    let mut t = match start {
        Some(t) if t > a && t < b => t,
        _ => first(a, b),
    };
    let mut last = b - a;
    for _ in 0..MAX_STEPS {
        let (y, slope) = body(t);
        let excess = y - target;
        if excess.to_f64() == 0.0 {
            return t;
        }
        let far = excess.is_nan() && b.abs() > a.abs();
        if excess > zero || far {
            b = t;
        } else {
            a = t;
        }
        let newton = step(t, y, target, slope);
        let size = (newton - t).abs();
        let steady = size <= last * f(0.75);
        let within = newton > a && newton < b;
        // Close to the root, steps shrink quadratically until they are rounding: those no longer do.
        if size <= t.abs() * close || !steady && size <= t.abs() * close.sqrt() {
            return if within { newton } else { t };
        }
        let next = if within && steady { newton } else { middle(a, b) };
        last = (next - t).abs();
        t = next;
        if b - a <= a.abs().max(b.abs()) * close * f(0.25) {
            break;
        }
    }
    t
}

/// A step of Newton's method; where the value is far off and has the sign of the target, one on
/// logarithmic scales, which is exact for powers.
fn step<T: Number>(t: T, y: T, target: T, slope: T) -> T {
    let (ratio, exponent) = (target / y, y / (slope * t));
    let r = ratio.to_f64();
    // At zero itself the exponent is infinite.
    let power = exponent.to_f64() > 0.0 && exponent.is_finite();
    if power && r > 0.0 && !(0.5..=2.0).contains(&r) && r.is_finite() {
        return t * ratio.powf(exponent);
    }
    t - (y - target) / slope
}

fn first<T: Number>(a: T, b: T) -> T {
    let one = T::from_f64(1.0);
    match (a.to_f64() <= -HUGE, b.to_f64() >= HUGE) {
        (false, false) => (a + b) * T::from_f64(0.5),
        (false, true) => a + a.abs().max(one),
        (true, false) => b - b.abs().max(one),
        (true, true) => T::from_f64(0.0),
    }
}

/// Between a and b: zero if they have different signs, and on a logarithmic scale if they differ
/// much.
fn middle<T: Number>(a: T, b: T) -> T {
    let (zero, tiny) = (T::from_f64(0.0), T::from_f64(TINY));
    if a < zero && b > zero {
        return zero;
    }
    let (small, large) = (a.abs().min(b.abs()).max(tiny), a.abs().max(b.abs()));
    if large > small * T::from_f64(4.0) {
        let size = small.sqrt() * large.sqrt();
        return if b > zero { size } else { -size };
    }
    a + (b - a) * T::from_f64(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::evaluate;
    use crate::interval::Interval;
    use crate::number::Dd;
    use crate::rational::Q;

    /// Where 2t³ - t⁴ = u.
    fn smoothstep() -> (Graph, Root) {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let variable = g.bound_variable(0, "t", Interval::new(0.0, 1.0)).unwrap();
        let t = g.get_leaf(variable);
        let (t3, t4) = (g.powi(t, 3), g.powi(t, 4));
        let body = g.sum(Q::ZERO, &[(Q::int(2), t3), (Q::int(-1), t4)]);
        let slope = crate::derivative::derivative(&mut g, body, variable);
        let (lo, hi) = (g.int(0), g.int(1));
        (g, Root { variable, body, slope, target: u, lo, hi, inside: false, folds: false })
    }

    #[test]
    fn full_precision_where_the_slope_vanishes() {
        let (mut g, root) = smoothstep();
        let id = g.root(root);
        for u in [1e-300, 1e-18, 1e-9, 0.1, 0.5, 0.9, 1.0 - 1e-15] {
            let exact = evaluate::<Dd>(&g, id, &|_| Dd::from_f64(u));
            let back = Dd::from_f64(2.0) * exact.powi(3) - exact.powi(4);
            assert!(((back.to_f64() - u) / u).abs() < 1e-28f64.max(1e-16), "{u}");
            let double = evaluate::<f64>(&g, id, &|_| u);
            assert!((double / exact.to_f64() - 1.0).abs() < 1e-15, "{u}: {double}");
        }
        assert!(
            (evaluate::<f64>(&g, id, &|_| 1e-18) / 7.937_006_309_775_623e-7 - 1.0).abs() < 1e-15
        );
    }

    #[test]
    fn targets_beyond_the_ends_have_roots_beyond_them() {
        let (mut g, root) = smoothstep();
        let inside = g.root(Root { inside: true, ..root.clone() });
        let id = g.root(root);
        assert_eq!(evaluate::<f64>(&g, id, &|_| -0.5), -0.5);
        assert_eq!(evaluate::<f64>(&g, id, &|_| 1.25), 1.25);
        assert_eq!(evaluate::<f64>(&g, inside, &|_| 1.25), 1.0);
        assert!(evaluate::<f64>(&g, id, &|_| f64::NAN).is_nan());
    }

    #[test]
    fn the_derivative_is_the_implicit_one() {
        let (mut g, root) = smoothstep();
        let id = g.root(root);
        let d = crate::derivative::derivative(&mut g, id, Leaf::Unknown(0));
        let at = |id: Id, u: f64| evaluate::<Dd>(&g, id, &|_| Dd::from_f64(u)).to_f64();
        let h = 1e-6;
        let quotient = (at(id, 0.3 + h) - at(id, 0.3 - h)) / (2.0 * h);
        assert!((at(d, 0.3) / quotient - 1.0).abs() < 1e-9);
    }
}
