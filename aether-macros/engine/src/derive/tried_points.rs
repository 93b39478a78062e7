//! The points at which a map is tried while it is compiled: those that take its way through the branches.

use super::Problem;
use super::nearby;
use crate::differences::evaluate;
use crate::eval::Evaluator;
use crate::expr::{Id, Leaf};
use crate::number::{Dd, Number};
use crate::points::{Kind, Point, map_points, placed, sampler_points};

pub(super) fn is_guarded(problem: &Problem) -> bool {
    let confined = !problem.made.is_empty() || problem.segments.iter().any(Option::is_some);
    confined
        || ![&problem.guards, &problem.existence, &problem.relations].iter().all(|t| t.is_empty())
}

/// The points at which the map is tried: those that take this way through the branches.
pub(super) fn points(problem: &Problem) -> Vec<Point> {
    let on_way = |point: &Point| on_this_way(problem, point);
    // With zeros in their place points take the way that others do not.
    let accept = |point: &mut Point| {
        problem.made.complete(&problem.graph, point)
            && (!problem.vanishing.is_empty() || on_way(point))
    };
    let guarded = is_guarded(problem);
    let tried = |accept: &dyn Fn(&mut Point) -> bool| match &problem.argument {
        None => sampler_points(problem.unknowns.len(), &problem.kinds, guarded, accept),
        Some(kind) => map_points(kind, &problem.kinds, guarded, accept),
    };
    let mut points = tried(&accept);
    if points.is_empty() && problem.vanishing.is_empty() {
        let failed = std::cell::Cell::new(0);
        points = tried(&|point| {
            let found =
                failed.get() < MOST_FAILED && nearby::bring(problem, point) && accept(point);
            failed.set(if found { 0 } else { failed.get() + 1 });
            found
        });
    }
    if !problem.vanishing.is_empty() {
        points.iter_mut().for_each(|point| vanish(problem, &mut point.params));
        points.retain(on_way);
    } else if problem.argument.is_none() {
        let beside = beside_limits(problem, &points);
        points.extend(beside.into_iter().filter(on_way));
    }
    points.iter_mut().for_each(|point| as_uniforms_make_them(problem, point, false));
    points
}

/// Rounds the unknowns of segments that begin above zero to what uniforms can make of them, which are no closer to each other
/// there than numbers are: what is left up to the end is not rounded then.
pub(super) fn as_uniforms_make_them(problem: &Problem, point: &mut Point, single: bool) {
    let segments = problem.segments.iter().zip(&mut point.unknowns);
    for (segment, t) in segments.filter_map(|(segment, t)| Some((segment.as_ref()?, t))) {
        let few = |id: Id| problem.graph.as_number(id).filter(|q| q.den().count_ones() == 1);
        let (Some(low), Some(width)) = (few(segment.low), few(segment.width)) else { continue };
        let (low, width) = (low.to_f64(), width.to_f64());
        if low <= 0.0 || t.to_f64() <= 0.0 {
            continue;
        }
        let u = low + width * t.to_f64();
        let (u, least, most) = match single {
            false => (u, low.next_up(), (low + width).next_down()),
            true => {
                let ends = [(low as f32).next_up(), ((low + width) as f32).next_down()];
                let [least, most] = ends.map(f64::from);
                (f64::from(u as f32), least, most)
            }
        };
        *t = Dd::from_f64((u.max(least).min(most) - low) / width);
    }
}

/// Points with a parameter next to an end of zero, where the map has no value for zero itself: a form that has a limit there
/// is better than one that loses its digits on the way.
fn beside_limits(problem: &Problem, points: &[Point]) -> Vec<Point> {
    let ends_at_zero =
        |kind: &Kind| matches!(kind, Kind::Scalar(Some(d)) if d.lo == 0.0 || d.hi == 0.0);
    let places = placed(&problem.kinds).filter(|(kind, _)| ends_at_zero(kind));
    let mut beside = Vec::new();
    for (_, place) in places {
        let with = |point: &Point, scale: f64| {
            let mut point = Point { stress: true, ..point.clone() };
            point.params[place.start] = point.params[place.start] * Dd::from_f64(scale);
            point
        };
        let plain = points.iter().filter(|p| p.interior && !p.stress).step_by(3);
        let none = |point: &&Point| {
            let zero = with(point, 0.0);
            evaluate(problem, &zero, &zero.unknowns).iter().all(|x| x.to_f64().is_nan())
        };
        beside.extend(plain.filter(none).take(MOST_BESIDE).map(|point| with(point, BESIDE)));
    }
    beside
}

/// How many points with a parameter next to zero there are, and how much closer to it than others that is.
const MOST_BESIDE: usize = 8;

const BESIDE: f64 = 1e-9;

/// How many points in a row may be brought to a way in vain.
const MOST_FAILED: usize = 20;

/// Puts zeros in the place of parameters that vanish, and gives unit vectors their length again.
fn vanish(problem: &Problem, params: &mut [Dd]) {
    let zero = Dd::from_f64(0.0);
    for (kind, place) in placed(&problem.kinds) {
        let is_zero = |i: &usize| problem.vanishing.contains(&Leaf::Param(*i as u8));
        let zeros: Vec<usize> = place.clone().filter(is_zero).collect();
        zeros.iter().for_each(|i| params[*i] = zero);
        if !zeros.is_empty() && matches!(kind, Kind::Direction) {
            let square = params[place.clone()].iter().fold(zero, |sum, x| sum + *x * *x);
            let length = square.sqrt();
            params[place].iter_mut().for_each(|x| *x = *x / length);
        }
    }
}

/// What is wrong with a way through the branches that no point takes.
pub(super) fn never_taken(problem: &Problem) -> String {
    let place = way(problem).map_or(String::new(), |way| format!(", where {way},"));
    format!(
        "one of the ways through the branches of this body{place} was not taken by any point that was tried; declare the domain of the parameters that it depends on, as in `#[sampler(alpha in 1e-4..=1.0)]`, or leave the branch out if it is never taken, as a `max(0.0)` that only keeps rounding from a square root"
    )
}

/// The last comparison that leads to this way, as text.
fn way(problem: &Problem) -> Option<String> {
    let test = problem.guards.last().or(problem.existence.last())?;
    let relation = if test.strict { ">" } else { ">=" };
    Some(format!("`{} {relation} 0`", crate::display::show(&problem.graph, test.difference)))
}

/// What is wrong with a piece, with the way through the branches that leads to it; if none does, that.
pub fn on_which_way(problem: &Problem, why: String) -> String {
    let Some(way) = way(problem) else { return why };
    if points(problem).is_empty() {
        return never_taken(problem);
    }
    if why.contains(&way) {
        return why;
    }
    format!(
        "{why}. That is so on the way through the branches where {way}: if no point should take it, declare the domains of the parameters that exclude it, as in `#[sampler(alpha in 1e-4..=1.0)]`"
    )
}

/// Whether a point takes this way through the branches.
pub(super) fn on_this_way(problem: &Problem, point: &Point) -> bool {
    let at = |l: Leaf| point.input(l, &[]);
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let wide = problem.segments.iter().flatten().all(|s| e.value(s.width).to_f64() > 0.0);
    wide && [&problem.relations, &problem.existence, &problem.guards].into_iter().flatten().all(
        |t| {
            let difference = e.value(t.difference).to_f64();
            difference > 0.0 || (!t.strict && difference >= 0.0)
        },
    )
}
