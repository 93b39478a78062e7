//! From a map's outputs to its inverse, Jacobian and density, each checked while compiling.

mod cases;
mod density;
mod limits;
mod regimes;

use crate::display::show;
use crate::expr::{Graph, Id, Leaf, leaf_bit};
use crate::jacobian::{Source, simplify, volume};
use crate::measure::{Inputs, Measure};
use crate::overflow::guard;
use crate::points::Kind;
use crate::solve::{Condition, Solution, solve};
use crate::stabilise::stabilise_point;

use cases::{cases, inputs, prune, verify_volume};
use density::{density, finish, pick_volume};
use limits::parameters_with_limits;

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
    /// The unknowns, as accurate as they can be had.
    pub unknowns: Vec<Id>,
    /// The unknowns in a shorter form, good enough to see whether they lie in [0, 1).
    pub tested: Vec<Id>,
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
    /// The scalar parameters that must not be exactly zero, because the formulas have only a limit
    /// there.
    pub limits: Vec<u8>,
    /// Worst relative error of the density found on the test points, in `f64`.
    pub worst_error: f64,
    /// The derivation, a line a step.
    pub steps: Vec<String>,
}

/// Derives and verifies. The error is a text for the user.
pub fn derive(problem: &mut Problem) -> Result<Derived, String> {
    crate::poly::start_budget();
    let targets = declare_outputs(problem);
    all_used(problem)?;
    let source = source_of(problem);
    let volumes =
        volume(&mut problem.graph, &problem.outputs, &problem.unknowns, source, &problem.frames)?;
    let cases = cases(problem, volumes[0])?;
    let solutions = find_solutions(problem, &targets)?;
    let (solutions, check_forward) = prune(problem, solutions, &cases)?;
    verify_volume(problem, volumes[0], &cases)?;

    let measured = |problem: &Problem, unknowns| {
        Measure::new(cases.iter().map(|c| inputs(problem, c, unknowns)).collect::<Vec<Inputs>>())
    };
    let mut unknown_points = measured(problem, true);
    let mut out_points = measured(problem, false);
    let outputs = problem.outputs.clone();
    let forward = stabilise_point(&mut problem.graph, &outputs, &mut unknown_points);
    let forward: Vec<Id> = forward.into_iter().map(|f| guard(&mut problem.graph, f)).collect();
    let own = pick_volume(problem, &volumes, &mut unknown_points);
    let mut preimages = Vec::new();
    let mut worst = 0.0f64;
    let mut steps = Vec::new();
    for s in &solutions {
        steps.extend(s.steps.iter().cloned());
        let injective = solutions.len() == 1;
        let (density, error) = density(problem, s, &volumes, &cases, &mut out_points, injective);
        worst = worst.max(error);
        let flags = (injective, check_forward);
        preimages.push(finish(problem, s, density, &cases, &mut out_points, flags));
    }
    let mut limits = parameters_with_limits(&problem.graph, &[own], &mut unknown_points);
    let at_point = preimages.iter().flat_map(|p| p.tested.iter().copied().chain([p.density]));
    let at_point: Vec<Id> = at_point.collect();
    limits.extend(parameters_with_limits(&problem.graph, &at_point, &mut out_points));
    let at_uniforms: &[Id] = &forward;
    limits.extend(parameters_with_limits(&problem.graph, at_uniforms, &mut unknown_points));
    limits.sort_unstable();
    limits.dedup();
    Ok(Derived {
        forward,
        preimages,
        volume: own,
        check_forward,
        limits,
        worst_error: worst,
        steps,
    })
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
        let way = s.numerical.unwrap_or_else(|| "Write the map with each uniform in one place, or as a composition of samplers and maps that can be inverted one at a time".into());
        format!(
            "cannot invert this map: stuck at `{}`, which should give {}. {way}",
            s.equation,
            s.unknowns.join(" and ")
        )
    })?;
    let g = &mut problem.graph;
    for s in &mut solutions {
        for v in s.unknowns.values_mut() {
            *v = simplify(g, *v, None);
        }
        s.short = s.unknowns.clone();
        let spelled: Vec<_> = s.unknowns.iter().map(|(l, v)| (*l, s.spell_out(g, *v))).collect();
        s.unknowns = spelled.into_iter().collect();
        s.conditions = s.conditions.iter().map(|c| Condition(s.spell_out(g, c.0))).collect();
    }
    Ok(solutions)
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
                .zip(&p.tested)
                .map(|(n, v)| format!("{n} = {}", show(g, *v)))
                .collect::<Vec<_>>()
                .join(",  ")
        })
        .collect();
    let densities: Vec<String> = derived.preimages.iter().map(|p| show(g, p.density)).collect();
    [forward, inverse.join("\n"), show(g, derived.volume), densities.join(" + ")]
}
