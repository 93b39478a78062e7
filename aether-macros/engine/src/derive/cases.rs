//! Trying an item out while it is compiled: the points, what the map is there, which of the solver's
//! answers occur, and whether the derivatives are right.

use super::nearby;
use super::{Problem, Target};
use crate::differences::{self, evaluate};
use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf};
use crate::measure::{Inputs, Measure};
use crate::number::{Dd, Number};
use crate::points::{Kind, Point, Rng, map_points, placed, sampler_points, with_other_signs};
use crate::solve::Solution;
use crate::sorted;

/// A point with what is known of it.
pub(super) struct Case {
    pub(super) point: Point,
    pub(super) outs: Vec<f64>,
    pub(super) exact_outs: Vec<Dd>,
    pub(super) volume: f64,
    /// Whether its numbers are of single precision.
    pub(super) single: bool,
}

impl Case {
    /// Whether it is of a point in the middle of the domain, with parameters that the map is meant for, in double precision.
    pub(super) fn is_plain(&self) -> bool {
        self.point.interior && !self.point.stress && !self.single
    }

    /// The same parameters with another point of the target space.
    pub(super) fn moved_to(&self, exact_outs: Vec<Dd>) -> Case {
        let outs = exact_outs.iter().map(|x| x.to_f64()).collect();
        Case {
            point: self.point.clone(),
            outs,
            exact_outs,
            volume: self.volume,
            single: self.single,
        }
    }
}

/// Evaluates the map at every test point; points that have no result are left out. Second, whether there were some within
/// what the map is meant for.
pub(super) fn cases(problem: &Problem, volume: Id) -> Result<(Vec<Case>, bool), String> {
    let points = points(problem);
    if points.is_empty() && is_guarded(problem) {
        return Err(never_taken(problem));
    }
    let undefined = points.iter().any(|point| !point.stress && is_undefined(problem, point));
    let out: Vec<Case> =
        points.into_iter().filter_map(|point| case(problem, volume, point)).collect();
    if out.iter().filter(|c| !c.point.corner).count() < 8 {
        return Err(too_few(problem).into());
    }
    if out.iter().filter(|c| c.point.interior).all(|c| c.volume == 0.0) {
        let n = problem.outputs.len();
        return Err(format!(
            "the result does not fill its space: the Jacobian has a rank below the dimension of the returned space. Return a space of lower dimension (a `Surface` or `Curve` instead of a point with {n} free coordinates), or use every uniform in the result. If there are only a few points, they are atoms: let a `#[strategy]` choose among them"
        ));
    }
    for (_, place) in problem.placed().into_iter().filter(|(p, _)| p.target == Target::Direction) {
        for c in out.iter().filter(|c| !c.point.stress) {
            let n: f64 = c.outs[place.clone()].iter().map(|x| x * x).sum();
            if (n - 1.0).abs() > 1e-12 {
                return Err(format!(
                    "the coordinates of this `Direction` have length {:.6} at u = {:?}; normalise them, or return a `Surface` if the points do not lie on the unit sphere",
                    n.sqrt(),
                    c.point.shown()
                ));
            }
        }
    }
    Ok((out, undefined))
}

/// Whether the map has no value at a point, as a root of what is negative has none, nor beside it: at an end alone it may be
/// rounding that has left nothing to take the root of.
fn is_undefined(problem: &Problem, point: &Point) -> bool {
    const STEP: f64 = 1e-4;
    let none = |u: &[Dd]| evaluate(problem, point, u).iter().any(|x| x.to_f64().is_nan());
    let inwards = |u: &Dd| *u + Dd::from_f64(STEP * (0.5 - u.to_f64()));
    none(&point.unknowns) && none(&point.unknowns.iter().map(inwards).collect::<Vec<_>>())
}

/// The points in the middle of the domain with parameters of other signs, where nothing was declared of them: good for finding
/// out which of several preimages occur there, but no test of the map, which may be meant for one sign alone.
pub(super) fn of_other_signs(problem: &Problem, volume: Id, cases: &[Case]) -> Vec<Case> {
    let mut rng = Rng::new(0x516e);
    let plain = cases.iter().filter(|c| c.is_plain());
    let turned = plain.filter_map(|c| with_other_signs(&c.point, &problem.kinds, &mut rng));
    let on_way = turned.filter_map(|mut point| {
        let whole = problem.made.complete(&problem.graph, &mut point);
        (whole && on_this_way(problem, &point)).then_some(point)
    });
    on_way.filter_map(|point| case(problem, volume, point)).collect()
}

/// How the map is oriented, if it is oriented alike at all points within the domain.
pub(super) fn orientation(problem: &Problem, cases: &[Case]) -> Option<bool> {
    let points = cases.iter().map(|c| &c.point).filter(|p| p.interior && !p.stress);
    let mut signs = points.map(|p| differences::orientation(problem, p));
    let first = signs.next()??;
    signs.all(|sign| sign == Some(first)).then_some(first)
}

/// What the map is at a point; `None` if it has no result there.
fn case(problem: &Problem, volume: Id, point: Point) -> Option<Case> {
    let at = |l: Leaf| point.input(l, &[]);
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let exact_outs: Vec<Dd> = problem.outputs.iter().map(|f| e.value(*f)).collect();
    let required = problem.requirements.iter().all(|r| e.value(*r).to_f64() > 0.0);
    let volume = e.value(volume).to_f64();
    let outs: Vec<f64> = exact_outs.iter().map(|x| x.to_f64()).collect();
    let finite = outs.iter().all(|x| x.is_finite()) && volume.is_finite();
    (required && finite).then_some(Case { point, outs, exact_outs, volume, single: false })
}

/// The values of an expression of the points themselves, before they are rounded.
pub(super) fn exact_values(g: &Graph, id: Id, cases: &[Case]) -> Vec<f64> {
    let value = |case: &Case| {
        let at = |l: Leaf| case.point.input(l, &case.exact_outs);
        Evaluator::<Dd>::new(g, &at).value(id).to_f64()
    };
    cases.iter().map(value).collect()
}

/// The same points with numbers of single precision, as far as they still are of the domain.
fn in_single(problem: &Problem, volume: Id, cases: &[Case]) -> Vec<Case> {
    let rounded = |case: &Case| {
        let point = case.point.in_single(&problem.kinds, problem.argument.as_ref());
        let point = point.filter(|point| on_this_way(problem, point))?;
        let mut case = self::case(problem, volume, point)?;
        case.single = true;
        let held = |x: &f64| (*x as f32).is_finite();
        (case.outs.iter().all(held) && held(&case.volume)).then_some(case)
    };
    cases.iter().filter_map(rounded).collect()
}

/// The cases, and then what they are in single precision.
pub(super) fn with_single(problem: &Problem, volume: Id, cases: Vec<Case>) -> Vec<Case> {
    let single = in_single(problem, volume, &cases);
    cases.into_iter().chain(single).collect()
}

/// What errors are measured at: by the unknowns, or by the coordinates.
pub(super) fn measured<'c>(
    problem: &Problem,
    cases: impl Iterator<Item = &'c Case> + Clone,
    unknowns: bool,
) -> Measure {
    let points = |single: bool| -> Vec<Inputs> {
        let cases = cases.clone().filter(|c| c.single == single);
        // Grazing directions are for the forms of inverses.
        let cases = cases.filter(|c| !(unknowns && c.point.grazing));
        cases.map(|c| inputs(problem, c, unknowns)).collect()
    };
    Measure::new(points(false), points(true))
}

/// What is wrong with a map that has a value at hardly any point, and what to do.
fn too_few(problem: &Problem) -> &'static str {
    match problem.argument {
        None => {
            "the map has a finite value at too few points of its domain to be checked; declare the domain of its parameters, as in `#[sampler(alpha in 1e-4..=1.0)]`"
        }
        Some(_) => {
            "the map has a finite value at too few points of the space that its argument is of. Say by a branch where it is defined, and return an `Option`: `if p.x > 0.0 && p.x < 1.0 && p.y > 0.0 && p.y < 1.0 { Some(…) } else { None }` for the unit square. If it is so because of the parameters, declare their domain, as in `#[map(alpha in 1e-4..=1.0)]`"
        }
    }
}

fn is_guarded(problem: &Problem) -> bool {
    let confined = !problem.made.is_empty() || problem.segments.iter().any(Option::is_some);
    confined
        || ![&problem.guards, &problem.existence, &problem.relations].iter().all(|t| t.is_empty())
}

/// The points at which the map is tried: those that take this way through the branches.
fn points(problem: &Problem) -> Vec<Point> {
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
    points
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
fn never_taken(problem: &Problem) -> String {
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
fn on_this_way(problem: &Problem, point: &Point) -> bool {
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

pub(super) fn inputs(problem: &Problem, case: &Case, unknowns: bool) -> Inputs {
    let round = |x: f64| if case.single { f64::from(x as f32) } else { x };
    let mut map = Inputs::default();
    if unknowns {
        for (i, v) in case.point.unknowns.iter().enumerate() {
            map.insert(Leaf::Unknown(i as u8), round(v.to_f64()));
        }
    }
    for (i, v) in case.outs.iter().enumerate() {
        map.insert(Leaf::Out(i as u8), round(*v));
    }
    for i in 0..problem.kinds.iter().map(Kind::scalars).sum::<usize>() {
        map.insert(Leaf::Param(i as u8), round(case.point.params[i].to_f64()));
    }
    map
}

/// The values of a solution at a case, if its tests pass.
fn try_solution(problem: &Problem, s: &Solution, case: &Case) -> Option<Vec<f64>> {
    try_exactly(problem, s, case).map(|u| u.iter().map(|u| u.to_f64()).collect())
}

/// Whether a solution is the preimage that a case was made from.
pub(super) fn recovers(problem: &Problem, s: &Solution, case: &Case) -> bool {
    let near = |(a, b): (&f64, &Dd)| (a - b.to_f64()).abs() < 1e-9;
    try_solution(problem, s, case).is_some_and(|u| u.iter().zip(&case.point.unknowns).all(near))
}

/// The same in double-double.
pub(super) fn try_exactly(problem: &Problem, s: &Solution, case: &Case) -> Option<Vec<Dd>> {
    try_all(problem, &[s], case).pop().flatten()
}

/// The same for several solutions, what they have in common computed once.
pub(super) fn try_all(
    problem: &Problem,
    solutions: &[&Solution],
    case: &Case,
) -> Vec<Option<Vec<Dd>>> {
    let at = |l: Leaf| match l {
        Leaf::Out(i) => case.exact_outs[i as usize],
        // An answer in terms of the question is none.
        Leaf::Unknown(_) => Dd::from_f64(f64::NAN),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    solutions.iter().map(|s| tried(problem, s, case, &mut e)).collect()
}

/// The values of a solution, if its tests pass, where `e` evaluates at the point of a case.
fn tried(problem: &Problem, s: &Solution, case: &Case, e: &mut Evaluator<Dd>) -> Option<Vec<Dd>> {
    let u: Vec<Dd> = problem
        .unknowns
        .iter()
        .map(|l| s.unknowns.get(l).map_or(Dd::from_f64(f64::NAN), |v| e.value(*v)))
        .collect();
    let inside = problem.argument.is_some()
        || u.iter().all(|u| u.is_finite() && u.to_f64() > -1e-12 && u.to_f64() < 1.0 + 1e-12);
    let conditions = s.conditions.iter().all(|c| e.value(c.0).to_f64() >= -1e-20)
        && s.pieces.iter().flat_map(|p| &p.widths).all(|w| e.value(*w).to_f64() > 0.0);
    let at = |l: Leaf| match l {
        Leaf::Unknown(i) => u.get(i as usize).copied().unwrap_or(Dd::from_f64(f64::NAN)),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let required = problem.requirements.iter().all(|r| e.value(*r).to_f64() > 0.0)
        && problem.guards.iter().all(|t| e.value(t.difference).to_f64() >= -1e-20);
    (inside && conditions && required).then_some(u)
}

/// Keeps the solutions that occur, in a form without duplicates; every point must be recovered.
pub(super) fn prune(
    problem: &Problem,
    solutions: Vec<Solution>,
    cases: &[Case],
) -> Result<(Vec<Solution>, bool), String> {
    let all: Vec<&Solution> = solutions.iter().collect();
    let mut table: Vec<Vec<Option<Vec<f64>>>> = vec![vec![]; all.len()];
    for case in cases {
        for (row, u) in table.iter_mut().zip(try_all(problem, &all, case)) {
            row.push(u.map(|u| u.iter().map(|u| u.to_f64()).collect()));
        }
    }
    let mut check_forward = problem.parts.iter().any(|p| p.target == Target::Embedded);
    let mut kept = needed(problem, &table, cases);
    with_their_pieces(&solutions, &mut kept);
    for (i, case) in cases.iter().enumerate().filter(|(_, c)| !c.point.stress) {
        let mut found = false;
        for &k in &kept {
            let Some(u) = &table[k][i] else { continue };
            found |= u.iter().zip(&case.point.shown()).all(|(a, b)| (a - b).abs() <= 1e-9);
            check_forward |= !maps_back(problem, u, case);
        }
        if !found && !flat(problem, case) {
            return Err(format!(
                "the derived inverse does not recover its own input: u = {:?} with parameters {:?} maps to {:?}, which maps back to {:?}. If this point lies outside what the map is meant for, declare the domain of the parameters",
                case.point.shown(),
                case.point.params.iter().map(|p| p.to_f64()).collect::<Vec<_>>(),
                case.outs,
                kept.iter().filter_map(|&k| table[k][i].take()).collect::<Vec<_>>()
            ));
        }
    }
    let needed: Vec<&Solution> = kept.iter().map(|&k| &solutions[k]).collect();
    check_forward |= super::strays::accepted(problem, &needed, cases);
    let mut index = 0;
    let mut solutions = solutions;
    solutions.retain(|_| {
        index += 1;
        kept.contains(&(index - 1))
    });
    Ok((solutions, check_forward))
}

/// Whether the map is so flat at an extreme point that its image in `f64` does not determine the
/// unknowns to the accuracy asked for: at the border of a power, or where it folds.
fn flat(problem: &Problem, case: &Case) -> bool {
    const STEP: f64 = 1e-9;
    problem.argument.is_none()
        && (0..case.point.unknowns.len()).any(|i| {
            let mut u = case.point.unknowns.clone();
            let inwards = if u[i].to_f64() < 0.6 { STEP } else { -STEP };
            u[i] = u[i] + Dd::from_f64(inwards);
            let moved = evaluate(problem, &case.point, &u);
            moved
                .iter()
                .zip(&case.outs)
                .all(|(y, x)| (y.to_f64() - x).abs() <= 4.0 * f64::EPSILON * (x.abs().max(STEP)))
        })
}

/// The solutions without which some preimage would be missing. A root of a squared equation may lie
/// in the cube everywhere and lead back nowhere, or only where it meets another.
fn needed(problem: &Problem, table: &[Vec<Option<Vec<f64>>>], cases: &[Case]) -> Vec<usize> {
    let near = |a: &[f64], b: &[f64], tolerance: f64| {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() <= tolerance * (1.0 + x.abs()))
    };
    let leads_back: Vec<Vec<bool>> = table
        .iter()
        .map(|row| {
            let tried = row.iter().zip(cases);
            tried
                .map(|(u, case)| {
                    u.as_ref().is_some_and(|u| {
                        let own = near(u, &case.point.shown(), 1e-9);
                        own || case.point.interior && maps_back(problem, u, case)
                    })
                })
                .collect()
        })
        .collect();
    let mut kept: Vec<usize> =
        (0..table.len()).filter(|&k| leads_back[k].contains(&true)).collect();
    for k in (0..table.len()).rev() {
        let covered = |i: usize| {
            let Some(u) = &table[k][i] else { return true };
            kept.iter().any(|&j| {
                let same = |v: &Vec<f64>| near(v, u, 1e-12);
                j != k && leads_back[j][i] && table[j][i].as_ref().is_some_and(same)
            })
        };
        if kept.contains(&k) && (0..cases.len()).all(|i| !leads_back[k][i] || covered(i)) {
            kept.retain(|j| *j != k);
        }
    }
    kept
}

/// Adds to the solutions that occur those that differ from one of them in the piece of a root alone: none of the points may
/// have hit a narrow piece.
fn with_their_pieces(solutions: &[Solution], kept: &mut Vec<usize>) {
    let alike = |a: &Solution, b: &Solution| !a.pieces.is_empty() && a.answers == b.answers;
    let occurs = |s: &Solution| kept.iter().any(|&k| alike(s, &solutions[k]));
    let more: Vec<usize> =
        (0..solutions.len()).filter(|k| !kept.contains(k) && occurs(&solutions[*k])).collect();
    kept.extend(more);
    sorted::sort(kept);
}

fn maps_back(problem: &Problem, u: &[f64], case: &Case) -> bool {
    if !case.point.interior {
        return true;
    }
    let u: Vec<Dd> = u.iter().map(|u| Dd::from_f64(*u)).collect();
    let image = evaluate(problem, &case.point, &u);
    image.iter().zip(&case.outs).all(|(y, x)| (y.to_f64() - x).abs() <= 1e-6 * (1.0 + x.abs()))
}

/// Checks √det(JᵀJ) against differences of the map itself in double-double.
pub(super) fn verify_volume(problem: &Problem, volume: Id, cases: &[Case]) -> Result<(), String> {
    for case in cases.iter().filter(|c| c.point.interior && !c.point.stress).take(24) {
        let Some(truth) = crate::differences::volume(problem, &case.point) else { continue };
        let at = |l: Leaf| case.point.input(l, &[]);
        let v = Evaluator::<Dd>::new(&problem.graph, &at).value(volume).to_f64();
        let gap = (v - truth).abs() / truth.abs().max(1e-300);
        let off = gap > 1e-7 && (v - truth).abs() > 1e-12;
        if off && crate::differences::tell(problem, &case.point) {
            return Err(format!(
                "internal check failed: the derived Jacobian is {v:e} at {:?}, differences of the map give {truth:e}; please report this map",
                case.point.shown()
            ));
        }
    }
    Ok(())
}
