//! Equal expressions for √det(JᵀJ), by all ways to find one.

use super::line::line;
use super::opened::opened;
use super::{Problem, joint, through};
use crate::expr::{Id, Leaf};
use crate::jacobian::{Source, sphere, volume};
use crate::points::Kind;

/// Equal expressions for √det(JᵀJ), also by what is written without functions of twice an angle.
pub(super) fn any_volumes(problem: &mut Problem) -> Result<Vec<Id>, String> {
    let mut volumes = any_volume(problem)?;
    let written = problem.outputs.clone();
    let g = &mut problem.graph;
    let forms: Vec<Id> = written.iter().map(|&x| opened(g, x).unwrap_or(x)).collect();
    if forms != written {
        crate::poly::start_budget();
        problem.outputs = forms;
        let more = any_volume(problem);
        problem.outputs = written;
        volumes.extend(more?);
    }
    Ok(volumes)
}

/// Equal expressions for √det(JᵀJ).
pub(super) fn any_volume(problem: &mut Problem) -> Result<Vec<Id>, String> {
    if let Some(volume) = joint::volume(problem).or_else(|| spherical(problem)) {
        return volume;
    }
    if let Some(line) = line(problem) {
        return line.volume(&mut problem.graph);
    }
    if let Some(volume) = through::volume(problem) {
        return Ok(volume);
    }
    let source = (source_of(problem), problem.is_direction());
    let g = &mut problem.graph;
    volume(g, &problem.outputs, &problem.unknowns, source, &problem.frames)
}

/// The volume of what is written in spherical coordinates. That a direction has unit length is tried at
/// the points, like everything else.
fn spherical(problem: &mut Problem) -> Option<Result<Vec<Id>, String>> {
    if problem.argument.is_some() {
        return None;
    }
    let covered = if problem.is_direction() { sphere::area } else { sphere::volume };
    covered(&mut problem.graph, &problem.outputs, &problem.unknowns).map(Ok)
}

/// Volumes in terms of the uniforms, where the unknowns run over segments of them.
pub(super) fn per_uniform(problem: &mut Problem, volumes: &[Id]) -> Vec<Id> {
    let g = &mut problem.graph;
    let widths: Vec<Id> = problem.segments.iter().flatten().map(|s| s.width).collect();
    let scale = widths.into_iter().fold(g.int(1), |product, w| g.mul(product, w));
    volumes.iter().map(|&v| g.div(v, scale)).collect()
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
