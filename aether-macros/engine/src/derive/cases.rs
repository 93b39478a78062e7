//! What a map is at the points that it is tried at while it is compiled, and whether the derivatives are right there.

use super::tried_points::{as_uniforms_make_them, is_guarded, never_taken, on_this_way, points};
use super::{Problem, Target};
use crate::differences::{self, evaluate};
use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf};
use crate::measure::{Inputs, Measure};
use crate::number::{Dd, Number};
use crate::points::{Kind, Point, Rng, with_other_signs};

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

/// An unknown at each point that is tried.
pub(super) fn unknown_of(cases: &[Case], i: usize) -> Vec<f64> {
    cases.iter().map(|c| c.point.unknowns[i].to_f64()).collect()
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
        let mut point = case.point.in_single(&problem.kinds, problem.argument.as_ref())?;
        as_uniforms_make_them(problem, &mut point, true);
        if !on_this_way(problem, &point) {
            return None;
        }
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
