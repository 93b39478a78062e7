//! Unknowns that are one minus the height of a unit vector, which no point makes negative: where the azimuth about the
//! same axis is found as the angle of two numbers a and b, 1 - z² is a² + b².
//!
//! That this is so is an identity, and it is tried in exact arithmetic at points all over the space. The vector is another
//! one than the point, as where a normal is made from a direction that was drawn, and its height is no short expression.

use super::Problem;
use super::cases::Case;
use crate::eval::Evaluator;
use crate::expr::{Fun, Graph, Id, Node, OUTS};
use crate::interval::Interval;
use crate::number::{Dd, Number};
use crate::points::{Rng, unit};

/// How far values may differ that are the same: there are 31 digits, but for what cancels.
const SAME: f64 = 1e-20;
/// At how many points an identity has to have been tried.
const FEWEST: usize = 24;

/// Makes known which unknowns of a sampler of directions are never negative.
pub(super) fn keep_capped(problem: &mut Problem, unknowns: &[Id], cases: &[Case]) {
    if !problem.is_direction() || problem.argument.is_some() {
        return;
    }
    let (g, mut points) = (&mut problem.graph, None);
    let pairs = angles(g, unknowns);
    for &unknown in if pairs.is_empty() { &[] } else { unknowns } {
        let range = g.range(unknown);
        if range.nonnegative() {
            continue;
        }
        let Some(heights) = deciding(g, unknown) else { continue };
        let points = points.get_or_insert_with(|| all_over(cases));
        if pairs.iter().any(|pair| heights.iter().any(|&h| is_cap(g, h, *pair, points))) {
            g.assume(unknown, Interval::new(0.0, range.hi));
        }
    }
}

/// What has the sign of an expression, if a single factor decides that: the factor, and all that depend on the point, as
/// what is over one line has a length below it.
fn deciding(g: &mut Graph, id: Id) -> Option<[Id; 2]> {
    let (q, body) = g.split(id);
    let factors = g.factors(body);
    if !factors.iter().all(|&(_, e)| g.as_number(e).is_some_and(|e| e.is_int())) {
        return None;
    }
    let signed = |g: &Graph, base: Id| g.range(base).nonnegative() || g.range(base).nonpositive();
    let [open, of_point] = [
        factors.iter().copied().filter(|&(base, _)| !signed(g, base)).collect::<Vec<_>>(),
        factors.iter().copied().filter(|&(base, _)| g.has(base, OUTS)).collect::<Vec<_>>(),
    ];
    let &[(base, exponent)] = &open[..] else { return None };
    let is_odd = |g: &Graph, e: Id| g.as_number(e).is_some_and(|e| !e.is_even());
    if !is_odd(g, exponent) || !g.has(base, OUTS) {
        return None;
    }
    let alike = |g: &mut Graph, left: &[(Id, Id)], part: Id| {
        let turns = |&&(b, e): &&(Id, Id)| is_odd(g, e) && g.range(b).nonpositive();
        let turned = factors.iter().filter(|f| !left.contains(f)).filter(turns).count() % 2 == 1;
        if turned == q.is_negative() { part } else { g.neg(part) }
    };
    let product = g.product(&of_point);
    Some([alike(g, &open, base), alike(g, &of_point, product)])
}

/// The two numbers of each angle in some expressions.
fn angles(g: &Graph, ids: &[Id]) -> Vec<[Id; 2]> {
    let numbers = |id: Id| match g.node(id) {
        Node::Call(Fun::Atan2, of) => Some([of[1], of[0]]),
        _ => None,
    };
    g.within(ids).into_iter().filter_map(numbers).collect()
}

/// The points that something is tried at: parameters of cases, each with two directions of all kinds.
fn all_over(cases: &[Case]) -> Vec<[Case; 2]> {
    let mut rng = Rng::new(0xca99ed);
    let plain = cases.iter().filter(|case| case.is_plain());
    plain.map(|case| [(); 2].map(|()| case.moved_to(unit(&mut rng).to_vec()))).collect()
}

/// Whether h (2 - h) is a² + b² at all points, or a positive multiple of it that parameters alone decide, since what both
/// share is no matter to an angle: h = 1 - z then, with z in [-1, 1].
fn is_cap(g: &Graph, h: Id, [a, b]: [Id; 2], points: &[[Case; 2]]) -> bool {
    let mut tried = 0;
    for cases in points {
        let sides = cases.each_ref().map(|case| {
            let at = |leaf| case.point.input(leaf, &case.exact_outs);
            let mut e = Evaluator::<Dd>::new(g, &at);
            let [h, a, b] = [h, a, b].map(|id| e.value(id));
            [h * (Dd::from_f64(2.0) - h), a * a + b * b]
        });
        let [[one, other], [second, beside]] = sides;
        let [left, right] = [one * beside, second * other];
        let off = (left - right).abs().to_f64();
        if off.is_nan() {
            continue;
        }
        let size = (Dd::from_f64(1.0) + other + beside).to_f64();
        if off > SAME * size || (one + second).to_f64() < 0.0 {
            return false;
        }
        tried += 1;
    }
    tried >= FEWEST
}

#[cfg(test)]
mod tests {
    use super::super::cases::cases;
    use super::*;
    use crate::expr::Leaf;
    use crate::interpret::Item;
    use crate::rational::Q;

    /// Of each unknown of a sampler, whether it is known not to be negative.
    fn never_negative(text: &str) -> Vec<bool> {
        let domain = "alpha in 1e-4..=1.0, where w.z > 0.0".parse().unwrap();
        let item = Item::new(domain, text.parse().unwrap(), true).unwrap();
        let g = &item.parsed.pieces[0].problem.graph;
        let tested = &item.derived[0].preimages[0].tested;
        tested.iter().map(|&u| g.range(u).nonnegative()).collect()
    }

    /// Normals that are half way between a direction and one in a cap about an axis.
    fn half_ways(cap: &str) -> String {
        format!(
            "fn normals(u: [Uniform; 2], alpha: f64, w: Direction) -> Direction {{
                let v = Vec3::new(alpha * w.x, alpha * w.y, w.z).normalize();
                let z = {cap};
                let r = (1.0 - z * z).sqrt();
                let phi = TAU * u[0];
                let n = (Vec3::new(r * phi.cos(), r * phi.sin(), z) + v).normalize();
                Direction::from_vec(Vec3::new(alpha * n.x, alpha * n.y, n.z).normalize())
            }}"
        )
    }

    #[test]
    fn no_direction_lies_above_the_pole_of_a_cap() {
        assert!(never_negative(&half_ways("1.0 - u[1] * (1.0 + v.z)"))[1]);
    }

    #[test]
    fn directions_lie_above_the_rim_of_a_zone() {
        // Those nearer to the pole have a negative unknown.
        assert!(!never_negative(&half_ways("0.9 - u[1] * (0.9 + v.z)"))[1]);
    }

    #[test]
    fn what_two_others_lack_to_one_is_a_height() {
        let text = "fn sphere(u: [Uniform; 2]) -> Direction {
            let z = 1.0 - 2.0 * u[0];
            let r = (1.0 - z * z).sqrt();
            let phi = TAU * u[1];
            Direction::new(r * phi.cos(), r * phi.sin(), z)
        }";
        let mut item = Item::new(Default::default(), text.parse().unwrap(), true).unwrap();
        let (problem, volume) = (&mut item.parsed.pieces[0].problem, item.derived[0].volume);
        let points = all_over(&cases(problem, volume).unwrap().0);
        assert!(points.len() >= FEWEST && points.iter().flatten().any(|p| p.outs[2] < 0.0));
        let g = &mut problem.graph;
        let [x, y, z] = [0, 1, 2].map(|i| g.get_leaf(Leaf::Out(i)));
        let below = |g: &mut Graph, of: Id| g.sum(Q::ONE, &[(Q::int(-1), of)]);
        let (from_pole, from_side) = (below(g, z), below(g, x));
        assert!(is_cap(g, from_pole, [x, y], &points) && is_cap(g, from_side, [z, y], &points));
        assert!(!is_cap(g, from_side, [x, y], &points));
        // Alike in the upper half alone.
        let size = g.call(Fun::Abs, &[z]);
        let mirrored = g.add(from_pole, size);
        let either = g.sub(mirrored, z);
        assert!(!is_cap(g, either, [x, y], &points));
    }
}
