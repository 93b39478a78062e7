//! What was derived, as the documentation of an item tells it.

use super::Derived;
use crate::display::show;
use crate::expr::{Graph, Id};
use crate::parse::{Piece, Test};

/// The texts of the documentation: (forward, inverse, jacobian, density), a line a piece (and a
/// preimage).
pub fn texts(pieces: &mut [Piece], derived: &[Derived]) -> [String; 4] {
    let mut lines: [Vec<String>; 4] = Default::default();
    for (piece, derived) in pieces.iter_mut().zip(derived) {
        let condition = condition(piece);
        let problem = &mut piece.problem;
        let g = &mut problem.graph;
        let list = |ids: &[Id]| ids.iter().map(|i| show(g, *i)).collect::<Vec<_>>().join(", ");
        let strictly = |&difference: &Id| Test { difference, strict: true };
        let required: Vec<Test> = problem.requirements.iter().map(strictly).collect();
        let required = in_words(g, &required, "if");
        lines[0].push(format!("({}){condition}{required}", list(&problem.outputs)));
        for preimage in &derived.preimages {
            let values = preimage.tested.iter().enumerate().map(|(i, &v)| {
                let whole = match problem.segments.get(i).copied().flatten() {
                    Some(s) => {
                        let inside = g.mul(s.width, v);
                        g.add(s.low, inside)
                    }
                    None => v,
                };
                format!("{} = {}", g.name(problem.unknowns[i]), show(g, whole))
            });
            lines[1].push(values.collect::<Vec<_>>().join(",  "));
        }
        lines[2].push(format!("{}{condition}", show(g, derived.volume)));
        lines[3].extend(derived.preimages.iter().map(|p| show(g, p.density)));
    }
    let [forward, inverse, jacobian, density] = lines;
    [forward.join("\n"), inverse.join("\n"), jacobian.join("\n"), density.join(" + ")]
}

/// The conditions of a piece in words: `  where u < 1/2`.
fn condition(piece: &Piece) -> String {
    in_words(&piece.graph, &piece.tests, "where")
}

/// Tests in words, after a conjunction.
pub fn in_words(g: &Graph, tests: &[Test], conjunction: &str) -> String {
    let tests = tests.iter().map(|t| {
        let sign = if t.strict { ">" } else { "≥" };
        format!("{} {sign} 0", show(g, t.difference))
    });
    let tests: Vec<String> = tests.collect();
    if tests.is_empty() { String::new() } else { format!("  {conjunction} {}", tests.join(", ")) }
}
