//! Archimedes: the projection of the unit sphere to its cylinder keeps areas.

use super::{distinct, simplify};
use crate::derivative::derivative;
use crate::expr::{Fun, Graph, Id, Leaf, Node};
use crate::poly::Expander;
use crate::rational::Q;

/// The volume of a direction (A cos t, A sin t, z) in any order, with A² + z² = 1 and either sign of
/// each coordinate: |dz ∧ dt|, where sines and cosines have no part.
pub(super) fn volume(g: &mut Graph, outputs: &[Id], unknowns: &[Leaf]) -> Option<Vec<Id>> {
    let ([_, _, _], &[u, v]) = (outputs, unknowns) else { return None };
    let bodies: Vec<(Q, Id)> = outputs.iter().map(|&o| g.split(o)).collect();
    for (i, j, k) in [(0, 1, 2), (1, 0, 2), (1, 2, 0), (2, 1, 0), (2, 0, 1), (0, 2, 1)] {
        let sized = [i, j].iter().all(|&i| bodies[i].0.abs() == Q::ONE);
        let Some(t) = angle(g, bodies[i].1, bodies[j].1).filter(|_| sized) else { continue };
        let z = outputs[k];
        if !on_sphere(g, bodies[i].1, t, z) {
            continue;
        }
        let [zu, zv, tu, tv] =
            [(z, u), (z, v), (t, u), (t, v)].map(|(f, leaf)| derivative(g, f, leaf));
        let (down, up) = (g.mul(zu, tv), g.mul(zv, tu));
        let plain = g.sub(down, up);
        let tidy = simplify(g, plain, None);
        return Some(distinct([tidy, plain].map(|d| g.call(Fun::Abs, &[d])).to_vec()));
    }
    None
}

/// The angle t of A cos t and A sin t.
fn angle(g: &mut Graph, x: Id, y: Id) -> Option<Id> {
    g.factors(x).into_iter().find_map(|(cos, e)| {
        let Node::Call(Fun::Cos, args) = g.node(cos).clone() else { return None };
        let sin = g.call(Fun::Sin, &args);
        let (amplitude, other) = (g.div(x, cos), g.div(y, sin));
        (amplitude == other && g.as_number(e) == Some(Q::ONE)).then_some(args[0])
    })
}

/// Whether (x / cos t)² + z² = 1.
fn on_sphere(g: &mut Graph, x: Id, t: Id, z: Id) -> bool {
    let cos = g.call(Fun::Cos, &[t]);
    let amplitude = g.div(x, cos);
    let (a2, z2) = (g.powi(amplitude, 2), g.powi(z, 2));
    let sum = g.add(a2, z2);
    let sum = Expander::new(g).normal_form(sum);
    sum.and_then(|s| g.as_number(s)) == Some(Q::ONE)
}
