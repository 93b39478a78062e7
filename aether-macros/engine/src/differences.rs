//! The oracle of verification: derivatives of the forward map by differences in double-double.

use crate::derive::{Block, Problem, blocks};
use crate::eval::Evaluator;
use crate::expr::Leaf;
use crate::number::{Dd, Number};
use crate::points::{Kind, Point};

/// √det(JᵀJ) at a point, by central differences and orthogonalisation; `None` if not finite. Of several points that are had
/// one after another, the product of those of each.
pub fn volume(problem: &Problem, point: &Point) -> Option<f64> {
    volume_by(problem, point, STEP)
}

/// Whether differences tell the volume at a point: next to a vertical tangent, as that of a cube root at its zero, each
/// step gives another one.
pub fn tell(problem: &Problem, point: &Point) -> bool {
    let [Some(fine), Some(coarse)] = [STEP, 8.0 * STEP].map(|h| volume_by(problem, point, h))
    else {
        return false;
    };
    (fine - coarse).abs() <= 1e-3 * fine.abs()
}

fn volume_by(problem: &Problem, point: &Point, step: f64) -> Option<f64> {
    let columns: Vec<Option<Vec<Dd>>> = match problem.argument {
        Some(Kind::Direction) => {
            let w: [Dd; 3] = [0, 1, 2].map(|i| point.unknowns[i]);
            tangents(w).into_iter().map(|t| along_circle(problem, point, (w, t), step)).collect()
        }
        _ => (0..problem.unknowns.len()).map(|j| along_axis(problem, point, j, step)).collect(),
    };
    let columns: Vec<Vec<Dd>> = columns.into_iter().collect::<Option<_>>()?;
    let v = covered(point_by_point(problem, columns));
    let v = v.to_f64();
    v.is_finite().then_some(v)
}

/// The columns of the Jacobian for each point of the result, where these can be had one after another: those of its own
/// unknowns, in its own coordinates. A curve that an earlier number moves is no longer for that.
pub fn point_by_point(problem: &Problem, columns: Vec<Vec<Dd>>) -> Vec<Vec<Vec<Dd>>> {
    let Some(blocks) = blocks(problem) else { return vec![columns] };
    let of_block = |block: &Block| {
        let own = problem.unknowns.iter().zip(&columns).filter(|(u, _)| block.own.contains(u));
        own.map(|(_, column)| column[block.place.clone()].to_vec()).collect()
    };
    blocks.iter().map(of_block).collect()
}

/// The product of the volumes that the columns of each point span.
pub fn covered(points: Vec<Vec<Vec<Dd>>>) -> Dd {
    points.into_iter().fold(Dd::from_f64(1.0), |product, columns| product * span(columns))
}

/// Whether the map keeps the orientation of its unknowns at a point, or turns it round; for a direction as it is seen from
/// outside of the sphere. `None` where dimensions differ, and where differences do not tell.
pub fn orientation(problem: &Problem, point: &Point) -> Option<bool> {
    let axes = 0..problem.unknowns.len();
    let mut columns: Vec<Vec<Dd>> =
        axes.map(|j| along_axis(problem, point, j, STEP)).collect::<Option<_>>()?;
    if problem.is_direction() {
        columns.push(evaluate(problem, point, &point.unknowns));
    }
    let square = columns.iter().all(|column| column.len() == columns.len());
    let d = square.then(|| determinant(columns).to_f64())?;
    (d.abs() > 0.0).then_some(d > 0.0)
}

/// The determinant, by elimination with the largest pivots.
fn determinant(mut rows: Vec<Vec<Dd>>) -> Dd {
    let mut product = Dd::from_f64(1.0);
    for k in 0..rows.len() {
        let size = |row: &Vec<Dd>| row[k].abs().to_f64();
        let largest = (k..rows.len()).max_by(|&i, &j| size(&rows[i]).total_cmp(&size(&rows[j])));
        if let Some(i) = largest.filter(|&i| i != k) {
            rows.swap(i, k);
            product = Dd::from_f64(0.0) - product;
        }
        let (done, rest) = rows.split_at_mut(k + 1);
        let pivot = &done[k];
        product = product * pivot[k];
        for row in rest {
            let factor = row[k] / pivot[k];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x = *x - factor * *p);
        }
    }
    product
}

/// The image of some unknowns, with the parameters of a point.
pub fn evaluate(problem: &Problem, point: &Point, unknowns: &[Dd]) -> Vec<Dd> {
    let at = |l: Leaf| match l {
        Leaf::Unknown(i) => unknowns[i as usize],
        _ => point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    problem.outputs.iter().map(|f| e.value(*f)).collect()
}

const STEP: f64 = 1.0 / (1u64 << 32) as f64;

fn along_axis(problem: &Problem, point: &Point, j: usize, step: f64) -> Option<Vec<Dd>> {
    let h = Dd::from_f64(step);
    let at = |sign: f64| {
        let mut u: Vec<Dd> = point.unknowns.clone();
        u[j] = u[j] + h * Dd::from_f64(sign);
        evaluate(problem, point, &u)
    };
    quotient(at(1.0), at(0.0), at(-1.0), h)
}

/// The derivative along the great circle through w with unit tangent t.
fn along_circle(
    problem: &Problem,
    point: &Point,
    (w, t): ([Dd; 3], [Dd; 3]),
    step: f64,
) -> Option<Vec<Dd>> {
    let h = Dd::from_f64(step);
    let at = |sign: f64| {
        let a = h * Dd::from_f64(sign);
        let moved: Vec<Dd> = (0..3).map(|i| w[i] * a.cos() + t[i] * a.sin()).collect();
        evaluate(problem, point, &moved)
    };
    quotient(at(1.0), at(0.0), at(-1.0), h)
}

/// The central quotient; `None` where the quotients from both sides disagree: at a kink.
fn quotient(up: Vec<Dd>, middle: Vec<Dd>, down: Vec<Dd>, h: Dd) -> Option<Vec<Dd>> {
    let mut out = Vec::new();
    for ((a, m), b) in up.into_iter().zip(middle).zip(down) {
        let (right, left) = ((a - m) / h, (m - b) / h);
        let size = right.abs().to_f64() + left.abs().to_f64();
        if (right - left).abs().to_f64() > 1e-3 * size + 1e-6 {
            return None;
        }
        out.push((a - b) / (h + h));
    }
    Some(out)
}

fn dot(a: &[Dd], b: &[Dd]) -> Dd {
    a.iter().zip(b).fold(Dd::from_f64(0.0), |s, (x, y)| s + *x * *y)
}

/// The volume that the columns span, by Gram–Schmidt: never through the normal equations.
fn span(columns: Vec<Vec<Dd>>) -> Dd {
    let mut volume = Dd::from_f64(1.0);
    let mut basis: Vec<Vec<Dd>> = Vec::new();
    for mut c in columns {
        for q in &basis {
            let k = dot(&c, q);
            c = c.iter().zip(q).map(|(x, y)| *x - k * *y).collect();
        }
        let n = dot(&c, &c).sqrt();
        volume = volume * n;
        if n.to_f64() == 0.0 {
            return n;
        }
        basis.push(c.iter().map(|x| *x / n).collect());
    }
    volume
}

/// Two unit vectors that span the plane with this unit normal.
pub fn tangents(w: [Dd; 3]) -> [[Dd; 3]; 2] {
    let axis =
        if w[0].to_f64().abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }.map(Dd::from_f64);
    let k = dot(&axis, &w);
    let t: [Dd; 3] = std::array::from_fn(|i| axis[i] - k * w[i]);
    let n = dot(&t, &t).sqrt();
    let t = t.map(|x| x / n);
    let s = std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        w[j] * t[k] - w[k] * t[j]
    });
    [t, s]
}

#[cfg(test)]
mod tests {
    use crate::interpret::Item;

    /// How the pieces of a sampler are oriented.
    fn orientations(space: &str, body: &str) -> Vec<Option<bool>> {
        let text = format!(
            "fn s(u: [Uniform; {}]) -> {space} {{ {body} }}",
            1 + body.matches("u[1]").count().min(1)
        );
        let item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        item.derived.iter().map(|d| d.orientation).collect()
    }

    #[test]
    fn a_fold_turns_the_orientation_round_and_a_border_does_not() {
        let line = |body: &str| orientations("f64", body);
        let mut fold = line("(2.0 * u[0] - 1.0).abs()");
        fold.sort_unstable();
        assert_eq!(fold, [Some(false), Some(true)]);
        assert_eq!(line("if u[0] < 0.5 { u[0] } else { u[0] * u[0] + 0.25 }"), [Some(true); 2]);
        // A preimage on either side of zero, in one piece of the domain.
        assert_eq!(line("u[0] * (1.0 - u[0])"), [None]);
        assert_eq!(orientations("Vec2", "Vec2::new(u[1], u[0])"), [Some(false)]);
        assert_eq!(orientations("Vec2", "Vec2::new(u[0], u[1])"), [Some(true)]);
        let cap = |z: &str| {
            let body = format!(
                "let z = {z}; let r = (1.0 - z * z).sqrt(); let p = TAU * u[1];
                 Direction::new(r * p.cos(), r * p.sin(), z)"
            );
            orientations("Direction", &body)
        };
        assert!(
            matches!([&cap("u[0]")[..], &cap("1.0 - u[0]")[..]], [[Some(a)], [Some(b)]] if a != b)
        );
    }
}
