//! Sums of the coordinates of two unit vectors, as half vectors have them.
//!
//! Where the vectors are nearly opposite, a sum v + w has the error that rounding made in their lengths. It is
//! perpendicular to v - w, and what it has along that is this error: (v + w) - (v - w) ((v + w) · (v - w)) / 4 is free of
//! it, and exactly the same.

use std::collections::BTreeMap;

use crate::expr::{Graph, Id, Leaf};
use crate::points::{Kind, placed};
use crate::rational::Q;

use super::{Problem, Target};

/// The coordinates of a parameter and of the point, both of which are unit vectors.
pub(super) type Pair = [[Id; 3]; 2];

/// The pairs of unit vectors of which sums may occur: parameters that are directions, each with the point.
pub(super) fn pairs(problem: &mut Problem) -> Vec<Pair> {
    let target = problem.parts.iter().map(|part| part.target).collect::<Vec<_>>();
    if target[..] != [Target::Direction] {
        return vec![];
    }
    let g = &mut problem.graph;
    let point = [0, 1, 2].map(|i| g.get_leaf(Leaf::Out(i)));
    let mut found = vec![];
    for (_, place) in placed(&problem.kinds).filter(|(kind, _)| **kind == Kind::Direction) {
        let first = place.start as u8;
        found.push([[0, 1, 2].map(|i| g.get_leaf(Leaf::Param(first + i))), point]);
    }
    found
}

/// An expression with sums of the coordinates of two unit vectors free of the errors of their lengths; `None` where there
/// is no such sum.
pub(super) fn without_length(g: &mut Graph, written: Id, pairs: &[Pair]) -> Option<Id> {
    let mut id = written;
    for pair in pairs {
        let mut forms = BTreeMap::new();
        for (sum, form) in freed(g, pair) {
            forms.insert(sum, form);
            let (minus, form) = (g.neg(sum), g.neg(form));
            forms.insert(minus, form);
        }
        id = g.substitute(id, &forms);
    }
    (id != written).then_some(id)
}

/// The sums of coordinates of two unit vectors, each with its other form.
fn freed(g: &mut Graph, [v, w]: &Pair) -> [(Id, Id); 3] {
    let along: [[Id; 2]; 3] = std::array::from_fn(|i| [g.add(v[i], w[i]), g.sub(v[i], w[i])]);
    let products = along.map(|[sum, difference]| (Q::ONE, g.mul(sum, difference)));
    let error = g.sum(Q::ZERO, &products);
    along.map(|[sum, difference]| {
        let excess = g.mul(difference, error);
        let half = g.sum(Q::ZERO, &[(Q::HALF, excess)]);
        (sum, g.sum(Q::ZERO, &[(Q::ONE, sum), (Q::HALF.neg(), half)]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::Evaluator;
    use crate::interval::Interval;

    #[test]
    fn nearly_opposite_vectors_add_up_without_the_errors_of_their_lengths() {
        let mut g = Graph::new();
        let signed = Interval::new(-1.0, 1.0);
        let names = ["a", "b", "c", "x", "y", "z"];
        let v = [0, 1, 2].map(|i| g.leaf(Leaf::Param(i), names[i as usize], signed));
        let w = [0, 1, 2].map(|i| g.leaf(Leaf::Out(i), names[3 + i as usize], signed));
        let sum = g.add(v[0], w[0]);
        let other = without_length(&mut g, sum, &[[v, w]]).unwrap();
        // Opposite but for their heights; one is short by some roundings.
        let (c, z) = (1e-4, 3e-4);
        let length = 1.0 - 4.0 * f64::EPSILON;
        let at = |leaf: Leaf| match leaf {
            Leaf::Param(0) => f64::sqrt(1.0 - c * c),
            Leaf::Param(2) => c,
            Leaf::Out(0) => -length * f64::sqrt(1.0 - z * z),
            Leaf::Out(2) => length * z,
            _ => 0.0,
        };
        let mut e = Evaluator::<f64>::new(&g, &at);
        let expected = (z * z - c * c) / 2.0 * (1.0 + (z * z + c * c) / 4.0);
        let [plain, freed] = [sum, other].map(|id| (e.value(id) - expected).abs() / expected);
        assert!(plain > 1e-9 && freed < 1e-14, "{plain:e} {freed:e}");
        // Of one vector alone there is no sum.
        assert_eq!(without_length(&mut g, w[0], &[[v, w]]), None);
    }
}
