//! The preimages of a point: which of the ways to solve for them succeeds.

use std::collections::BTreeMap;

use super::cases::{Case, of_other_signs};
use super::line::line;
use super::occurring::prune;
use super::{Problem, staged};
use crate::expr::{Graph, Id, Leaf};
use crate::jacobian::{cost_together, simplify};
use crate::parse::Stage;
use crate::points::{Kind, placed};
use crate::solve::{Condition, Numerical, Solution, System, solve};

/// How points lead back to unknowns.
pub(super) struct Inverse {
    pub(super) solutions: Vec<Solution>,
    /// Whether a preimage must be mapped forward again to see that it is one.
    pub(super) check_forward: bool,
    /// The two-step form that was solved, if it was not solved as written.
    pub(super) stage: Option<Stage>,
}

impl Inverse {
    fn as_written((solutions, check_forward): (Vec<Solution>, bool)) -> Self {
        Inverse { solutions, check_forward, stage: None }
    }
}

/// The inverse in closed form, if there is one and roots on several pieces are not asked for; and the cases that it was tried
/// at. (Those of other signs are for this alone.)
pub(super) fn find(
    problem: &mut Problem,
    targets: &[Id],
    (volume, cases): (Id, Vec<Case>),
    most: Numerical,
) -> Result<(Inverse, Vec<Case>), String> {
    let others = of_other_signs(problem, volume, &cases);
    let plain = cases.len();
    let mut selecting: Vec<Case> = cases.into_iter().chain(others).collect();
    let inverse = find_by(problem, targets, &selecting, most)?;
    selecting.truncate(plain);
    Ok((inverse, selecting))
}

fn find_by(
    problem: &mut Problem,
    targets: &[Id],
    cases: &[Case],
    most: Numerical,
) -> Result<Inverse, String> {
    let inverse = |problem: &mut Problem, numerical| {
        // The search must not fail because the Jacobian is long.
        crate::poly::start_budget();
        let solutions = find_solutions(problem, targets, numerical)?;
        prune(problem, solutions, cases).map(Inverse::as_written).map_err(NoInverse::Wrong)
    };
    if most == Numerical::Pieces {
        return inverse(problem, Numerical::Pieces).map_err(NoInverse::text);
    }
    // A closed form may be missing, or fail where its parts overflow.
    match inverse(problem, Numerical::No) {
        Ok(found) => Ok(found),
        Err(NoInverse::Wrong(why)) => inverse(problem, Numerical::Monotone).map_err(|_| why),
        Err(NoInverse::Stuck(_)) => {
            if let Some(found) = in_stages(problem, targets, cases) {
                return Ok(found);
            }
            let found = inverse(problem, Numerical::Monotone);
            problem.stuck = matches!(found, Err(NoInverse::Stuck(_)));
            found.map_err(NoInverse::text)
        }
    }
}

/// Why there is no inverse.
enum NoInverse {
    /// The solver found none.
    Stuck(String),
    /// It found one that is wrong at some point.
    Wrong(String),
}

impl NoInverse {
    fn text(self) -> String {
        match self {
            NoInverse::Stuck(text) | NoInverse::Wrong(text) => text,
        }
    }
}

/// The inverse of the first of the two-step forms that has one.
fn in_stages(problem: &mut Problem, targets: &[Id], cases: &[Case]) -> Option<Inverse> {
    let stages = std::mem::take(&mut problem.stages);
    stages.into_iter().enumerate().find_map(|(k, stage)| {
        crate::poly::start_budget();
        let solutions = staged::solutions(problem, &stage, (k, targets))?;
        let (solutions, check_forward) = prune(problem, solutions, cases).ok()?;
        Some(Inverse { solutions, check_forward, stage: Some(stage) })
    })
}

/// The preimages by the solver, not yet tried.
fn find_solutions(
    problem: &mut Problem,
    targets: &[Id],
    numerical: Numerical,
) -> Result<Vec<Solution>, NoInverse> {
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
    let line = line(problem);
    let (unknowns, frames) = (problem.unknowns.clone(), problem.frames.clone());
    let (undeclared, positive) = (undeclared(problem), problem.requirements.clone());
    let g = &mut problem.graph;
    let solved =
        |g: &mut Graph, system: &System| solve(g, system, &unknowns, &frames, &positive, numerical);
    // What the surfaces tell of two points of a line is used where that is enough.
    let written = System::new(&known, &outputs);
    let mut solutions = solved(g, &written)
        .or_else(|stuck| {
            let line = line.ok_or_else(|| stuck.clone())?;
            crate::poly::start_budget();
            let system = line.system(g, &known, &positive);
            solved(g, &system).map_err(|_| stuck)
        })
        .map_err(|s| {
        let words: Vec<&str> = s.equation.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
        let concerned = undeclared.iter().find(|name| words.contains(&name.as_str()));
        let declare = concerned.map_or(String::new(), |name| format!("If that depends on the values of `{name}`, declare its domain, as in `#[sampler({name} in 0.1..=10.0)]`. Else write"));
        let write = if declare.is_empty() { "Write".to_owned() } else { declare };
        let way = s.numerical.unwrap_or_else(|| format!("{write} the map with each uniform in one place, or as a composition of samplers and maps that can be inverted one at a time"));
        NoInverse::Stuck(format!(
            "cannot invert this map: stuck at `{}`, which should give {}. {way}",
            s.equation,
            s.unknowns.join(" and ")
        ))
    })?;
    let g = &mut problem.graph;
    for s in &mut solutions {
        tidy(g, &mut s.unknowns);
        s.short = s.unknowns.clone();
        let spelled: Vec<_> = s.unknowns.iter().map(|(l, v)| (*l, s.spell_out(g, *v))).collect();
        s.unknowns = spelled.into_iter().collect();
        s.conditions = s.conditions.iter().map(|c| Condition(s.spell_out(g, c.0))).collect();
        let mut pieces = std::mem::take(&mut s.pieces);
        for id in pieces.iter_mut().flat_map(|p| p.conditions.iter_mut().chain(&mut p.widths)) {
            *id = s.spell_out(g, *id);
        }
        s.pieces = pieces;
    }
    Ok(solutions)
}

/// Simplifies expressions, but for those that cost less as they are, next to the others.
fn tidy(g: &mut Graph, values: &mut BTreeMap<Leaf, Id>) {
    let written: Vec<(Leaf, Id)> = values.iter().map(|(leaf, v)| (*leaf, *v)).collect();
    for v in values.values_mut() {
        *v = simplify(g, *v, None);
    }
    let together = |g: &Graph, values: &BTreeMap<Leaf, Id>| {
        cost_together(g, &values.values().copied().collect::<Vec<_>>())
    };
    for (leaf, as_written) in written {
        let before = together(g, values);
        let tidied = values.insert(leaf, as_written);
        if let Some(tidied) = tidied.filter(|_| together(g, values) >= before) {
            values.insert(leaf, tidied);
        }
    }
}

/// The numbers among the parameters that no domain is declared of.
fn undeclared(problem: &Problem) -> Vec<String> {
    let open = placed(&problem.kinds).filter(|(kind, _)| **kind == Kind::Scalar(None));
    open.map(|(_, place)| problem.graph.name(Leaf::Param(place.start as u8)).to_owned()).collect()
}
