//! Points that are no images of the map.
//!
//! A step of the solver may lose part of an equation: what was squared has lost its sign, a factor that
//! was given a name its definition. Such an inverse answers for points that the map never reaches, and
//! verification by images alone would not notice.

use super::cases::Case;
use super::occurring::try_all;
use super::{Problem, Target};
use crate::differences::evaluate;
use crate::number::{Dd, Number};
use crate::points::{Rng, unit};
use crate::solve::Solution;

/// How many points that have nothing to do with it are tried for each case.
const TRIES: usize = 4;
/// Of a point, reflections in this many planes of coordinates are tried.
const PLANES: usize = 3;

/// Whether some solution accepts a point of the target space that it does not map back to.
pub(super) fn accepted(problem: &Problem, solutions: &[&Solution], cases: &[Case]) -> bool {
    // On a surface that only its identity tells, other points cannot be made up.
    if problem.parts.iter().any(|p| matches!(p.target, Target::Identified | Target::Embedded)) {
        return false;
    }
    let mut rng = Rng::new(0x57a7);
    let tried = cases.iter().filter(|c| c.point.interior && !c.point.stress);
    tried.flat_map(|case| strays(problem, case, cases, &mut rng)).any(|stray| {
        let found = try_all(problem, solutions, &stray);
        found.into_iter().flatten().any(|u| is_wrong(problem, &stray, &u))
    })
}

/// Points that may be no images, with the parameters of a case: its image with other signs, which are what a
/// square forgets, and points from anywhere.
fn strays(problem: &Problem, case: &Case, cases: &[Case], rng: &mut Rng) -> Vec<Case> {
    let planes = case.outs.len().min(PLANES);
    let reflected = (1..1 << planes).map(|signs: usize| {
        let flip = |(i, x): (usize, &Dd)| if signs >> i & 1 == 1 { -*x } else { *x };
        case.exact_outs.iter().enumerate().map(flip).collect()
    });
    let anywhere = (0..TRIES).map(|_| stray(problem, cases, rng));
    let all: Vec<Vec<Dd>> = reflected.chain(anywhere).collect();
    all.into_iter().map(|outs| case.moved_to(outs)).collect()
}

/// A random direction; other coordinates from images of different points, some with the other sign.
fn stray(problem: &Problem, cases: &[Case], rng: &mut Rng) -> Vec<Dd> {
    let mut outs = Vec::new();
    for (part, place) in problem.placed() {
        if part.target == Target::Direction {
            outs.extend(unit(rng));
            continue;
        }
        for i in place {
            let case = &cases[(rng.uniform() * cases.len() as f64) as usize % cases.len()];
            let x = case.exact_outs[i];
            outs.push(if rng.uniform() < 0.25 { -x } else { x });
        }
    }
    outs
}

fn is_wrong(problem: &Problem, stray: &Case, u: &[Dd]) -> bool {
    // Next to an end of the unit interval even double-double cannot tell.
    let far = |u: &Dd| (1e-9..1.0 - 1e-9).contains(&u.to_f64());
    if problem.argument.is_none() && !u.iter().all(far) {
        return false;
    }
    let image = evaluate(problem, &stray.point, u);
    image.iter().zip(&stray.outs).any(|(y, x)| {
        let y = y.to_f64();
        // Where the map has no value nothing is claimed.
        y.is_finite() && (y - x).abs() > 1e-6 * (1.0 + x.abs())
    })
}
