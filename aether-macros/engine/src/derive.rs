//! From a map's outputs to its inverse, Jacobian and density, each checked while compiling.

use std::collections::HashMap;

use crate::display::show;
use crate::eval::Evaluator;
use crate::expr::{Graph, Id, Leaf, leaf_bit};
use crate::jacobian::{Source, cost, simplify, volume};
use crate::number::{Dd, Number};
use crate::points::{Kind, Point, map_points, sampler_points};
use crate::solve::{Solution, solve};
use crate::stabilise::{Inputs, stabilise, stabilise_point, truths, worst_error};

/// What the type of the result guarantees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The whole of R^n.
    Free,
    /// A unit vector, guaranteed by the type.
    Direction,
    /// A point of a surface that the type identifies.
    Identified,
    /// A manifold that only the map itself knows: membership is tested in every density.
    Embedded,
}

/// An item as parsed: a map from unknowns to outputs.
pub struct Problem {
    /// The expressions.
    pub graph: Graph,
    /// The output coordinates.
    pub outputs: Vec<Id>,
    /// The unknowns: uniforms, or coordinates of a map's argument.
    pub unknowns: Vec<Leaf>,
    /// What the argument of a map is; `None` for a sampler.
    pub argument: Option<Kind>,
    /// The scalar parameters in groups.
    pub kinds: Vec<Kind>,
    /// Parameters that are frames, by columns.
    pub frames: Vec<[[Id; 3]; 3]>,
    /// What the result's type guarantees.
    pub target: Target,
    /// Expressions that must be positive for there to be a result.
    pub requirements: Vec<Id>,
}

/// One preimage, ready to be emitted.
pub struct Preimage {
    /// The unknowns.
    pub unknowns: Vec<Id>,
    /// Must be at least zero.
    pub conditions: Vec<Id>,
    /// Must be greater than zero.
    pub requirements: Vec<Id>,
    /// The density of a sampler's point by way of this preimage.
    pub density: Id,
}

/// Everything that was derived.
pub struct Derived {
    /// The outputs in their most accurate form.
    pub forward: Vec<Id>,
    /// The preimages of a point.
    pub preimages: Vec<Preimage>,
    /// √det(JᵀJ) in terms of the unknowns.
    pub volume: Id,
    /// Whether a preimage must be mapped forward again to see that it is one.
    pub check_forward: bool,
    /// Worst relative error of the density found on the test points, in `f64`.
    pub worst_error: f64,
    /// The derivation, a line a step.
    pub steps: Vec<String>,
}

/// A point with what is known of it.
struct Case {
    point: Point,
    outs: Vec<f64>,
    exact_outs: Vec<Dd>,
    volume: f64,
}

/// Derives and verifies. The error is a text for the user.
pub fn derive(problem: &mut Problem) -> Result<Derived, String> {
    let targets = declare_outputs(problem);
    all_used(problem)?;
    let source = source_of(problem);
    let volumes =
        volume(&mut problem.graph, &problem.outputs, &problem.unknowns, source, &problem.frames)?;
    let cases = cases(problem, volumes[0])?;
    let solutions = find_solutions(problem, &targets)?;
    let (solutions, check_forward) = prune(problem, solutions, &cases)?;
    verify_volume(problem, volumes[0], &cases)?;

    let unknown_points: Vec<Inputs> = cases.iter().map(|c| inputs(problem, c, true)).collect();
    let out_points: Vec<Inputs> = cases.iter().map(|c| inputs(problem, c, false)).collect();
    let outputs = problem.outputs.clone();
    let forward = stabilise_point(&mut problem.graph, &outputs, &unknown_points);
    let own = pick_volume(problem, &volumes, &unknown_points);
    let mut preimages = Vec::new();
    let mut worst = 0.0f64;
    let mut steps = Vec::new();
    for s in &solutions {
        steps.extend(s.steps.iter().cloned());
        let (density, error) =
            density(problem, s, &volumes, &cases, &out_points, solutions.len() == 1);
        worst = worst.max(error);
        preimages.push(finish(problem, s, density, &out_points, check_forward));
    }
    Ok(Derived { forward, preimages, volume: own, check_forward, worst_error: worst, steps })
}

/// Every unknown must matter to the result.
fn all_used(problem: &Problem) -> Result<(), String> {
    let g = &problem.graph;
    for (i, &u) in problem.unknowns.iter().enumerate() {
        if problem.argument.is_none() && problem.outputs.iter().all(|o| !g.has(*o, leaf_bit(u))) {
            return Err(format!(
                "uniform number {i} is not used: the result does not depend on it, so it fills fewer dimensions than its space has. Use it, or take fewer uniforms and return a space of lower dimension"
            ));
        }
    }
    Ok(())
}

fn declare_outputs(problem: &mut Problem) -> Vec<Id> {
    let unit = problem.target == Target::Direction;
    let range = if unit {
        crate::interval::Interval::new(-1.0, 1.0)
    } else {
        crate::interval::Interval::ALL
    };
    // The outputs are called x, y, z unless a parameter is.
    let taken = |name: &str| (0..64).any(|i| problem.graph.name(Leaf::Param(i)) == name);
    let names = if ["x", "y", "z"].iter().any(|n| taken(n)) {
        ["X", "Y", "Z", "W", "V"]
    } else {
        ["x", "y", "z", "w", "v"]
    };
    let n = problem.outputs.len();
    let outs: Vec<Id> = (0..n)
        .map(|i| {
            let name = names.get(i).copied().unwrap_or("x");
            problem.graph.leaf(Leaf::Out(i as u8), name, range)
        })
        .collect();
    if unit && n == 3 {
        problem.graph.declare_unit([outs[0], outs[1], outs[2]]);
    }
    outs
}

fn source_of(problem: &mut Problem) -> Source {
    match problem.argument {
        Some(Kind::Direction) => {
            let w = [0, 1, 2].map(|i| problem.graph.get_leaf(Leaf::Unknown(i)));
            Source::Direction(w)
        }
        _ => Source::Free,
    }
}

fn find_solutions(problem: &mut Problem, targets: &[Id]) -> Result<Vec<Solution>, String> {
    let mut outputs = problem.outputs.clone();
    let mut known = targets.to_vec();
    if problem.argument == Some(Kind::Direction) {
        // The argument has unit length: one more equation.
        let g = &mut problem.graph;
        let w = [0, 1, 2].map(|i| g.get_leaf(Leaf::Unknown(i)));
        let length = w.map(|c| (crate::rational::Q::ONE, g.powi(c, 2)));
        outputs.push(g.plain_sum(&length));
        known.push(g.int(1));
    }
    let frames = problem.frames.clone();
    let mut solutions = solve(&mut problem.graph, &outputs, &known, &problem.unknowns, &frames, &problem.requirements).map_err(|s| {
        format!(
            "cannot invert this map: stuck at `{}`, which should give {}. Write the map with each uniform in one place, or as a composition of samplers and maps that can be inverted one at a time",
            s.equation,
            s.unknowns.join(" and ")
        )
    })?;
    let g = &mut problem.graph;
    for s in &mut solutions {
        for v in s.unknowns.values_mut() {
            *v = simplify(g, *v, None);
        }
    }
    Ok(solutions)
}

/// Evaluates the map at every test point; points that have no result are left out.
fn cases(problem: &Problem, volume: Id) -> Result<Vec<Case>, String> {
    let points = match &problem.argument {
        None => sampler_points(problem.unknowns.len(), &problem.kinds),
        Some(kind) => map_points(kind, &problem.kinds),
    };
    let mut out = Vec::new();
    for point in points {
        let at = |l: Leaf| point.input(l, &[]);
        let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
        let exact_outs: Vec<Dd> = problem.outputs.iter().map(|f| e.value(*f)).collect();
        let required = problem.requirements.iter().all(|r| e.value(*r).to_f64() > 0.0);
        let volume = e.value(volume).to_f64();
        let outs: Vec<f64> = exact_outs.iter().map(|x| x.to_f64()).collect();
        if required && outs.iter().all(|x| x.is_finite()) && volume.is_finite() {
            out.push(Case { point, outs, exact_outs, volume });
        }
    }
    if out.len() < 8 {
        return Err("the map has a finite value at too few points of its domain to be checked; declare the domain of its parameters, as in `#[sampler(alpha in 1e-4..=1.0)]`".into());
    }
    if out.iter().filter(|c| c.point.interior).all(|c| c.volume == 0.0) {
        let n = problem.outputs.len();
        return Err(format!(
            "the result does not fill its space: the Jacobian has a rank below the dimension of the returned space. Return a space of lower dimension (a `Surface` or `Curve` instead of a point with {n} free coordinates), or use every uniform in the result"
        ));
    }
    if problem.target == Target::Direction {
        for c in &out {
            let n: f64 = c.outs.iter().map(|x| x * x).sum();
            if (n - 1.0).abs() > 1e-12 {
                return Err(format!(
                    "the coordinates of this `Direction` have length {:.6} at u = {:?}; normalise them, or return a `Surface` if the points do not lie on the unit sphere",
                    n.sqrt(),
                    c.point.shown()
                ));
            }
        }
    }
    Ok(out)
}

fn inputs(problem: &Problem, case: &Case, unknowns: bool) -> Inputs {
    let mut map = HashMap::new();
    if unknowns {
        for (i, v) in case.point.unknowns.iter().enumerate() {
            map.insert(Leaf::Unknown(i as u8), v.to_f64());
        }
    }
    for (i, v) in case.outs.iter().enumerate() {
        map.insert(Leaf::Out(i as u8), *v);
    }
    for i in 0..problem.kinds.iter().map(Kind::scalars).sum::<usize>() {
        map.insert(Leaf::Param(i as u8), case.point.params[i].to_f64());
    }
    map
}

/// The values of a solution at a case: unknowns, and whether its tests pass.
fn try_solution(problem: &Problem, s: &Solution, case: &Case) -> Option<Vec<f64>> {
    let at = |l: Leaf| match l {
        Leaf::Out(i) => case.exact_outs[i as usize],
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let u: Vec<Dd> = problem
        .unknowns
        .iter()
        .map(|l| s.unknowns.get(l).map_or(Dd::from_f64(f64::NAN), |v| e.value(*v)))
        .collect();
    let inside = problem.argument.is_some()
        || u.iter().all(|u| u.is_finite() && u.to_f64() > -1e-12 && u.to_f64() < 1.0 + 1e-12);
    let conditions = s.conditions.iter().all(|c| e.value(c.0).to_f64() >= -1e-20);
    let at = |l: Leaf| match l {
        Leaf::Unknown(i) => u.get(i as usize).copied().unwrap_or(Dd::from_f64(f64::NAN)),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    let required = problem.requirements.iter().all(|r| e.value(*r).to_f64() > 0.0);
    (inside && conditions && required).then(|| u.iter().map(|u| u.to_f64()).collect())
}

/// Keeps the solutions that occur, in a form without duplicates; every point must be recovered.
fn prune(
    problem: &Problem,
    solutions: Vec<Solution>,
    cases: &[Case],
) -> Result<(Vec<Solution>, bool), String> {
    let mut table: Vec<Vec<Option<Vec<f64>>>> = solutions
        .iter()
        .map(|s| cases.iter().map(|c| try_solution(problem, s, c)).collect())
        .collect();
    let mut check_forward = problem.target == Target::Embedded;
    let mut kept: Vec<usize> = Vec::new();
    for k in 0..solutions.len() {
        let occurs = table[k].iter().any(Option::is_some);
        let duplicate = kept.iter().any(|&j| {
            table[j].iter().zip(&table[k]).all(|(a, b)| match (a, b) {
                (Some(a), Some(b)) => {
                    a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-12 * (1.0 + x.abs()))
                }
                (None, None) => true,
                _ => false,
            })
        });
        if occurs && !duplicate {
            kept.push(k);
        }
    }
    for (i, case) in cases.iter().enumerate() {
        let mut found = false;
        for &k in &kept {
            let Some(u) = &table[k][i] else { continue };
            found |= u.iter().zip(&case.point.shown()).all(|(a, b)| (a - b).abs() <= 1e-9);
            check_forward |= !maps_back(problem, u, case);
        }
        if !found {
            return Err(format!(
                "the derived inverse does not recover its own input: u = {:?} with parameters {:?} maps to {:?}, which maps back to {:?}. If this point lies outside what the map is meant for, declare the domain of the parameters",
                case.point.shown(),
                case.point.params.iter().map(|p| p.to_f64()).collect::<Vec<_>>(),
                case.outs,
                kept.iter().filter_map(|&k| table[k][i].take()).collect::<Vec<_>>()
            ));
        }
    }
    let mut index = 0;
    let mut solutions = solutions;
    solutions.retain(|_| {
        index += 1;
        kept.contains(&(index - 1))
    });
    Ok((solutions, check_forward))
}

fn maps_back(problem: &Problem, u: &[f64], case: &Case) -> bool {
    let at = |l: Leaf| match l {
        Leaf::Unknown(i) => Dd::from_f64(u[i as usize]),
        _ => case.point.input(l, &[]),
    };
    let mut e = Evaluator::<Dd>::new(&problem.graph, &at);
    problem.outputs.iter().zip(&case.outs).all(|(f, x)| {
        let y = e.value(*f).to_f64();
        let near_edge = !case.point.interior;
        near_edge || (y - x).abs() <= 1e-6 * (1.0 + x.abs())
    })
}

/// Checks √det(JᵀJ) against differences of the map itself in double-double.
fn verify_volume(problem: &Problem, volume: Id, cases: &[Case]) -> Result<(), String> {
    for case in cases.iter().filter(|c| c.point.interior).take(24) {
        let Some(truth) = crate::differences::volume(problem, &case.point) else { continue };
        let at = |l: Leaf| case.point.input(l, &[]);
        let v = Evaluator::<Dd>::new(&problem.graph, &at).value(volume).to_f64();
        let gap = (v - truth).abs() / truth.abs().max(1e-300);
        if gap > 1e-7 && (v - truth).abs() > 1e-12 {
            return Err(format!(
                "internal check failed: the derived Jacobian is {v:e} at {:?}, differences of the map give {truth:e}; please report this map",
                case.point.shown()
            ));
        }
    }
    Ok(())
}

/// The cheapest among the most accurate expressions.
fn pick(g: &mut Graph, candidates: &[Id], truth: &[f64], points: &[Inputs]) -> (Id, f64) {
    let scored: Vec<(Id, f64, usize)> =
        candidates.iter().map(|&c| (c, worst_error(g, c, truth, points), cost(g, c))).collect();
    let least = scored.iter().map(|s| s.1).fold(f64::INFINITY, f64::min).max(16.0 * f64::EPSILON);
    scored
        .iter()
        .filter(|s| s.1 <= 4.0 * least)
        .min_by_key(|s| s.2)
        .or(scored.first())
        .map_or((candidates[0], f64::INFINITY), |s| (s.0, s.1))
}

fn pick_volume(problem: &mut Problem, volumes: &[Id], points: &[Inputs]) -> Id {
    let g = &mut problem.graph;
    let truth = truths(g, volumes[0], points);
    let stable: Vec<Id> = volumes.iter().map(|&v| stabilise(g, v, points)).collect();
    let mut all = stable;
    all.extend(volumes);
    pick(g, &all, &truth, points).0
}

/// The density in terms of the outputs, in its most accurate form, and its worst error.
fn density(
    problem: &mut Problem,
    s: &Solution,
    volumes: &[Id],
    cases: &[Case],
    points: &[Inputs],
    injective: bool,
) -> (Id, f64) {
    let g = &mut problem.graph;
    let only: HashMap<Id, Id> = s.unknowns.iter().map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let mut candidates = Vec::new();
    for &v in volumes {
        let p = g.powi(v, -1);
        for map in [&s.known, &only] {
            let mut direct = g.substitute(p, map);
            // What one substitution uncovers another may know.
            direct = g.substitute(direct, &only);
            candidates.push(direct);
            candidates.push(simplify(g, direct, None));
        }
    }
    candidates.sort_by_key(|c| cost(g, *c));
    candidates.dedup();
    // Among several preimages this one's share is known only where it is the one that was sampled.
    let truth: Vec<f64> = if injective {
        cases.iter().map(|c| if c.volume > 0.0 { 1.0 / c.volume } else { f64::NAN }).collect()
    } else {
        truths(g, candidates[0], points)
    };
    let mut all = candidates.clone();
    if pick(g, &candidates, &truth, points).1 > 64.0 * f64::EPSILON {
        for &c in candidates.iter().take(3) {
            all.push(stabilise(g, c, points));
        }
    }
    pick(g, &all, &truth, points)
}

fn finish(
    problem: &mut Problem,
    s: &Solution,
    density: Id,
    points: &[Inputs],
    check_forward: bool,
) -> Preimage {
    let g = &mut problem.graph;
    let values: Vec<Id> =
        problem.unknowns.iter().map(|l| stabilise(g, s.unknowns[l], points)).collect();
    let map: HashMap<Id, Id> =
        problem.unknowns.iter().zip(&values).map(|(l, v)| (g.get_leaf(*l), *v)).collect();
    let requirements = problem
        .requirements
        .iter()
        .map(|&r| {
            let known = g.substitute(r, &s.known);
            g.substitute(known, &map)
        })
        .collect();
    Preimage {
        unknowns: values,
        // Mapping forward again is a test that contains all others.
        conditions: if check_forward { vec![] } else { s.conditions.iter().map(|c| c.0).collect() },
        requirements,
        density,
    }
}

/// The texts of the documentation: (forward, inverse, jacobian, density).
pub fn texts(problem: &Problem, derived: &Derived) -> [String; 4] {
    let g = &problem.graph;
    let list = |ids: &[Id]| ids.iter().map(|i| show(g, *i)).collect::<Vec<_>>().join(", ");
    let forward = list(&problem.outputs);
    let inverse: Vec<String> = derived
        .preimages
        .iter()
        .map(|p| {
            let names: Vec<&str> = problem.unknowns.iter().map(|l| g.name(*l)).collect();
            names
                .iter()
                .zip(&p.unknowns)
                .map(|(n, v)| format!("{n} = {}", show(g, *v)))
                .collect::<Vec<_>>()
                .join(",  ")
        })
        .collect();
    let densities: Vec<String> = derived.preimages.iter().map(|p| show(g, p.density)).collect();
    [forward, inverse.join("\n"), show(g, derived.volume), densities.join(" + ")]
}
