//! The volume in the form that is measured to be best. Where forms disagree, the columns of the Jacobian decide.

use super::Problem;
use super::pick::pick;
use crate::derivative::derivative;
use crate::differences::{covered, point_by_point, tangents};
use crate::expr::{Id, Leaf};
use crate::measure::Measure;
use crate::number::{Dd, Number};
use crate::overflow::guard;
use crate::points::Kind;
use crate::stabilise::stabilise;

/// The cheapest of the most accurate of equal volumes.
pub(super) fn pick_volume(problem: &mut Problem, volumes: &[Id], measure: &mut Measure) -> Id {
    let truth = confirmed(problem, volumes, measure);
    let g = &mut problem.graph;
    let stable: Vec<Id> = volumes.iter().map(|&v| stabilise(g, v, measure)).collect();
    let mut all = stable;
    all.extend(volumes);
    let best = pick(g, &all, &truth, measure).0;
    guard(g, best)
}

/// How far a volume may be from the one that the columns of the Jacobian span: these are not simplified, and next to a
/// pole they have a few digits less than a simple form.
const CONFIRMED: f64 = 1e-9;

/// The true volumes at the points: what the forms say in double-double where they agree, and else what the first of
/// them says that agrees with the volume spanned by the columns; the first of all where none does, as at a limit that
/// no column has a value at.
fn confirmed(problem: &mut Problem, volumes: &[Id], measure: &mut Measure) -> Vec<f64> {
    let said: Vec<Vec<f64>> =
        volumes.iter().map(|&form| measure.truths(&problem.graph, form)).collect();
    let near = |a: f64, b: f64| (a - b).abs() <= CONFIRMED * b.abs() || a == b;
    let agreed =
        |k: usize| said.iter().all(|form| near(form[k], said[0][k]) || !form[k].is_finite());
    let mut truth = said[0].clone();
    let open: Vec<usize> = (0..truth.len()).filter(|&k| !agreed(k)).collect();
    if !open.is_empty() {
        let spanned = spanned(problem, measure);
        for k in open {
            let right = said.iter().map(|form| form[k]).find(|&v| near(v, spanned[k]));
            truth[k] = right.unwrap_or(truth[k]);
        }
    }
    truth
}

/// The volume that the columns of the Jacobian span, by orthogonalisation of their values in double-double; not a number
/// where the order of the columns matters, as where they are parallel to more digits than there are.
fn spanned(problem: &mut Problem, measure: &mut Measure) -> Vec<f64> {
    let g = &mut problem.graph;
    let mut columns = Vec::new();
    for &u in &problem.unknowns {
        let slopes: Vec<Id> = problem.outputs.iter().map(|&f| derivative(g, f, u)).collect();
        let values = slopes.iter().map(|&f| measure.precisely(g, f));
        columns.push(values.collect::<Vec<_>>());
    }
    let widths = problem.segments.iter().flatten();
    let widths: Vec<_> = widths.map(|s| measure.precisely(g, s.width)).collect();
    let of_direction = problem.argument == Some(Kind::Direction);
    let at = |k: usize| {
        let mut vectors: Vec<Vec<Dd>> =
            columns.iter().map(|column| column.iter().map(|f| f[k]).collect()).collect();
        if of_direction {
            let point = &measure.points()[k];
            let w = [0, 1, 2].map(|i| Dd::from_f64(point[&Leaf::Unknown(i)]));
            vectors = tangents(w).map(|t| combined(&vectors, t)).to_vec();
        }
        let points = point_by_point(problem, vectors);
        let reversed = points.iter().map(|columns| columns.iter().rev().cloned().collect());
        let other = covered(reversed.collect());
        let v = covered(points);
        let known = (v - other).abs().to_f64() <= CONFIRMED * v.to_f64();
        let v = widths.iter().fold(v, |v, width| v / width[k]);
        if known { v.to_f64() } else { f64::NAN }
    };
    (0..measure.points().len()).map(at).collect()
}

/// The columns times the coordinates of a vector, added up.
fn combined(columns: &[Vec<Dd>], t: [Dd; 3]) -> Vec<Dd> {
    let along = |i: usize| {
        columns.iter().zip(t).fold(Dd::from_f64(0.0), |sum, (column, t)| sum + column[i] * t)
    };
    (0..columns[0].len()).map(along).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpret::Item;

    #[test]
    fn nearly_parallel_columns_keep_their_digits() {
        let text =
            "fn plane(u: [Uniform; 2], a: Vec3, b: Vec3, a3: f64, b3: f64) -> Embedded<2, 4> {
            let p = a * u[0] + b * u[1];
            Embedded([p.x, p.y, p.z, a3 * u[0] + b3 * u[1]])
        }";
        let item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        // Whole numbers, whose minors are exact: b is a up to a part in a million.
        let n = 1e6;
        let (a, b) = ([n, 2.0 * n, 3.0 * n, -n], [n + 1.0, 2.0 * n, 3.0 * n - 1.0, 2.0 - n]);
        let minors = (0..4).flat_map(|i| (0..i).map(move |j| (a[i] * b[j] - a[j] * b[i]).powi(2)));
        let area = minors.sum::<f64>().sqrt();
        let p = [a[0], a[1], a[2], b[0], b[1], b[2], a[3], b[3]];
        let x = item.forward(&p, &[0.25, 0.5]).unwrap();
        let off = item.pdf(&p, &x) * area - 1.0;
        assert!(off.abs() < 1e-14, "{off:e}");
    }

    #[test]
    fn a_false_form_is_no_truth() {
        let text = "fn line(u: [Uniform; 1]) -> f64 { u[0] * u[0] }";
        let mut item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        let problem = &mut item.parsed.pieces[0].problem;
        let g = &mut problem.graph;
        let u = g.get_leaf(problem.unknowns[0]);
        let two = g.int(2);
        let (right, wrong) = (g.mul(two, u), g.powi(u, 2));
        let points = [0.25, 0.5].map(|u| [(problem.unknowns[0], u)].into_iter().collect()).to_vec();
        let mut measure = Measure::new(points, vec![]);
        assert_eq!(confirmed(problem, &[wrong, right], &mut measure), [0.5, 1.0]);
    }

    #[test]
    fn columns_of_a_map_of_directions_lie_in_the_tangent_plane() {
        let text = "fn onto_plane(w: Direction) -> Vec2 { Vec2::new(w.x, w.y) }";
        let item = Item::new(Default::default(), text.parse().unwrap(), false);
        let mut item = item.unwrap();
        let problem = &mut item.parsed.pieces[0].problem;
        let w = [(0, 0.48), (1, 0.6), (2, 0.64)].map(|(i, x)| (Leaf::Unknown(i), x));
        let mut measure = Measure::new(vec![w.into_iter().collect()], vec![]);
        let found = spanned(problem, &mut measure)[0];
        assert!((found - 0.64).abs() < 1e-15, "{found}");
    }
}
