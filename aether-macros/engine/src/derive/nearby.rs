//! Parameters of a way that few of them take: `if (n + 1.0).abs() < 1e-3 { … }`.

use super::Problem;
use crate::eval::Evaluator;
use crate::expr::Leaf;
use crate::number::{Dd, Number};
use crate::points::{Kind, Point, placed};

/// Values of a parameter that are tried over its domain, and steps in which the best of them is closed in on.
const VALUES: usize = 33;
const STEPS: usize = 60;
/// Where nothing is declared.
const UNDECLARED: [f64; 2] = [-8.0, 8.0];

/// Changes one number among the parameters of a point so that the comparisons of parameters come out as they do on the way;
/// whether that is so.
pub(super) fn bring(problem: &Problem, point: &mut Point) -> bool {
    for (kind, place) in placed(&problem.kinds) {
        if let Kind::Scalar(domain) = kind {
            let [low, high] = domain.map_or(UNDECLARED, |d| [d.lo, d.hi]);
            let ends = [low.max(-1e3), high.min(1e3)];
            if let Some(value) = value_for(problem, point, place.start, ends) {
                point.params[place.start] = Dd::from_f64(value);
                return true;
            }
        }
    }
    false
}

/// A value of a parameter between two ends with which the comparisons come out so.
fn value_for(problem: &Problem, point: &Point, place: usize, [low, high]: [f64; 2]) -> Option<f64> {
    let mut tried = point.clone();
    let mut margin = |value: f64| {
        tried.params[place] = Dd::from_f64(value);
        margin(problem, &tried)
    };
    let step = (high - low) / (VALUES - 1) as f64;
    let values = (0..VALUES).map(|i| low + step * i as f64);
    let best = values.max_by(|a, b| margin(*a).total_cmp(&margin(*b)))?;
    let (mut a, mut b) = ((best - step).max(low), (best + step).min(high));
    for _ in 0..STEPS {
        let (left, right) = (a + (b - a) / 3.0, b - (b - a) / 3.0);
        if margin(left) < margin(right) {
            a = left;
        } else {
            b = right;
        }
    }
    let middle = 0.5 * (a + b);
    // Not always the same: next to an end of those that there are, on either side.
    let side = if point.unknowns.first().is_some_and(|u| u.to_f64() < 0.5) { -step } else { step };
    let beside = (0..STEPS as i32).map(|k| middle + side * libm::exp2(-f64::from(k)));
    let mut all = beside.chain([middle]).filter(|v| (low..=high).contains(v));
    all.find(|value| margin(*value) > 0.0)
}

/// By how much the comparisons of parameters come out as they do on the way, at least.
fn margin(problem: &Problem, point: &Point) -> f64 {
    let at = |leaf: Leaf| point.input(leaf, &[]);
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let tests = problem.existence.iter().chain(&problem.relations);
    let margins = tests.map(|test| e.value(test.difference).to_f64());
    margins
        .fold(f64::INFINITY, |least, m| if m.is_nan() { f64::NEG_INFINITY } else { least.min(m) })
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    #[test]
    fn a_way_for_few_parameters_has_points() {
        let text = "fn power(u: [Uniform; 1], n: f64) -> f64 {
            if (n + 1.0).abs() < 1e-3 { 2.0f64.powf(u[0]) } else {
                let b = 2.0f64.powf(n + 1.0);
                (1.0 + u[0] * (b - 1.0)).powf(1.0 / (n + 1.0))
            }
        }";
        for domain in ["n in -3.0..=3.0", ""] {
            let item = Item::new(domain.parse().unwrap(), text.parse().unwrap(), true);
            let item = item.unwrap_or_else(|e| panic!("{domain}: {e}"));
            for (n, x, expected) in [(-1.0, 1.25, 0.8), (-1.0005, 1.25, 0.8), (0.0, 1.5, 1.0)] {
                let found =
                    item.pdf(&[n], &[x]) * if n < -0.5 { std::f64::consts::LN_2 } else { 1.0 };
                assert!((found - expected).abs() < 1e-12, "{n}: {found}");
            }
            assert!((item.pdf(&[1.0], &[1.5]) - 1.0).abs() < 1e-12);
        }
    }
}
