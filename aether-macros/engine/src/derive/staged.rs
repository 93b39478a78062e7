//! The inverse of a body in two steps: first the numbers that the point is made of, then the uniforms that these are
//! made of. The volume is the product of those of both steps.

use super::Problem;
use super::determinant::any_volume;
use super::opened::opened;
use crate::expr::{Fun, Graph, Id, Leaf};
use crate::jacobian::{self, Source, simplify};
use crate::matrix::{cross, dot};
use crate::parse::Stage;
use crate::solve::{Condition, Numerical, Solution, System, solve};
use crate::sorted;

/// The first output that stands for a named number.
const FIRST: u8 = 10;
/// How many equal forms of the volume are kept.
const FORMS: usize = 4;

/// Forms of √det(JᵀJ) in terms of the unknowns and of the named numbers.
fn volumes(problem: &mut Problem, stage: &Stage) -> Option<Vec<Id>> {
    let names: Vec<Leaf> = stage.named.iter().map(|(leaf, _)| *leaf).collect();
    let unknowns = std::mem::replace(&mut problem.unknowns, names);
    let outputs = std::mem::replace(&mut problem.outputs, stage.outputs.clone());
    let frames = problem.frames.clone();
    problem.frames.extend(stage.frame);
    let outer = any_volume(problem);
    problem.frames = frames;
    (problem.unknowns, problem.outputs) = (unknowns, outputs);
    let g = &mut problem.graph;
    let made: Vec<Id> = stage.named.iter().map(|(_, id)| *id).collect();
    // What depends on the numbers before changes nothing: the matrix of slopes is triangular in them.
    let inner = jacobian::volume(g, &made, &problem.unknowns, (Source::Free, false), &[]).ok()?;
    let outer = outer.ok()?;
    let outer = outer.into_iter().map(|v| without_frame(g, v, stage)).collect::<Vec<_>>();
    let pairs = inner.iter().flat_map(|&a| outer.iter().map(move |&b| (a, b)));
    Some(pairs.take(FORMS).map(|(a, b)| g.mul(a, b)).collect())
}

/// A volume in which the determinant of the frame is one.
fn without_frame(g: &mut Graph, volume: Id, stage: &Stage) -> Id {
    let Some([x, y, z]) = stage.frame else { return volume };
    let across = cross(g, &x, &y);
    let determinant = dot(g, &across, &z);
    let (expanded, one) = (simplify(g, determinant, None), g.int(1));
    let sizes = [determinant, expanded].map(|d| (g.call(Fun::Abs, &[d]), one));
    g.substitute(volume, &sizes.into())
}

/// Volumes in terms of the unknowns, and in terms of a stage if there is one that is enough, in all forms that there are.
pub(super) fn in_terms_of(
    problem: &mut Problem,
    stage: Option<&Stage>,
    found: Vec<Id>,
) -> [Vec<Id>; 2] {
    let named = stage.and_then(|stage| volumes(problem, stage));
    let mut forms = match (named, stage) {
        (Some(named), Some(stage)) => {
            [named.iter().map(|&v| spelled_out(problem, stage, v)).collect(), named]
        }
        _ => [found.clone(), found],
    };
    for forms in &mut forms {
        let open: Vec<Id> =
            forms.iter().filter_map(|&form| opened(&mut problem.graph, form)).collect();
        forms.extend(open);
    }
    forms
}

/// An expression in which the named numbers are spelled out.
fn spelled_out(problem: &mut Problem, stage: &Stage, id: Id) -> Id {
    let g = &mut problem.graph;
    let names = stage.named.iter().chain(&stage.constants);
    let values = sorted::map(names.map(|(leaf, value)| (g.get_leaf(*leaf), *value)));
    // Each may be made of those before.
    (0..values.len()).fold(id, |id, _| g.substitute(id, &values))
}

/// Each preimage, by way of each solution of the first step; `None` if one of the steps has no inverse in closed form.
/// `number` says which of the stages it is: names are declared once.
pub(super) fn solutions(
    problem: &mut Problem,
    stage: &Stage,
    (number, targets): (usize, &[Id]),
) -> Option<Vec<Solution>> {
    let (mut frames, unknowns) = (problem.frames.clone(), problem.unknowns.clone());
    frames.extend(stage.frame);
    let positive = problem.requirements.clone();
    let g = &mut problem.graph;
    let names: Vec<Leaf> = stage.named.iter().map(|(leaf, _)| *leaf).collect();
    let outer =
        solve(g, &System::new(targets, &stage.outputs), &names, &frames, &[], Numerical::No)
            .ok()?;
    // To the second step the names are known.
    let first = FIRST + (number * names.len()) as u8;
    let known: Vec<Id> = (first..)
        .zip(&stage.named)
        .map(|(i, (leaf, value))| {
            let (name, range) = (g.name(*leaf).to_owned(), g.range(*value));
            g.leaf(Leaf::Out(i), &name, range)
        })
        .collect();
    let as_known =
        sorted::map(names.iter().map(|leaf| g.get_leaf(*leaf)).zip(known.iter().copied()));
    let made: Vec<Id> = stage.named.iter().map(|(_, id)| g.substitute(*id, &as_known)).collect();
    let inner =
        solve(g, &System::new(&known, &made), &unknowns, &frames, &positive, Numerical::No).ok()?;
    let mut all = Vec::new();
    for outer in &outer {
        let spelled_out =
            |(leaf, known): (&Leaf, &Id)| (*known, outer.spell_out(g, outer.unknowns[leaf]));
        let values = sorted::map(names.iter().zip(&known).map(spelled_out));
        for inner in &inner {
            let mut spelled = |id: Id| {
                let id = inner.spell_out(g, id);
                g.substitute(id, &values)
            };
            let mut unknowns =
                sorted::map(inner.unknowns.iter().map(|(leaf, id)| (*leaf, spelled(*id))));
            let mut conditions: Vec<Condition> =
                inner.conditions.iter().map(|c| Condition(spelled(c.0))).collect();
            conditions.extend(outer.conditions.iter().map(|c| Condition(outer.spell_out(g, c.0))));
            for id in unknowns.values_mut() {
                *id = simplify(g, *id, None);
            }
            let constants = stage.constants.iter();
            let mut found = Solution {
                known: sorted::map(
                    names.iter().map(|l| g.get_leaf(*l)).zip(values.values().copied()),
                ),
                short: unknowns.clone(),
                names: sorted::map(constants.map(|(leaf, value)| (g.get_leaf(*leaf), *value))),
                steps: outer.steps.iter().chain(&inner.steps).cloned().collect(),
                ..Solution::default()
            };
            found.unknowns =
                sorted::map(unknowns.into_iter().map(|(l, id)| (l, found.spell_out(g, id))));
            found.conditions =
                conditions.into_iter().map(|c| Condition(found.spell_out(g, c.0))).collect();
            all.push(found);
        }
    }
    Some(all)
}
