//! Sines and cosines of fractions of a turn.
//!
//! The runtime has its own for sin(π x) and cos(π x): the angle is reduced without rounding, and it is known to be a
//! fraction of a turn, so that they are faster and closer than those of an angle to which π was multiplied. The solver and the
//! texts for the user know angles; what is emitted does not need them.

use super::sample::angles;
use super::{Derived, Image};
use crate::expr::{Graph, Id, children};
use crate::hash::Set;
use crate::sorted;
use crate::stabilise::of_turn;

/// What was derived with all sines and cosines of multiples of π by the functions that are made for these.
pub(crate) fn by_fractions(g: &mut Graph, derived: &mut Derived) {
    let Derived { forward, preimages, volume, own_density, .. } = derived;
    for id in forward.iter_mut().chain([volume, own_density]) {
        *id = rewritten(g, *id);
    }
    for preimage in preimages {
        for id in preimage.back.iter_mut().flat_map(Image::expressions) {
            *id = rewritten(g, *id);
        }
        for id in preimage.expressions() {
            *id = rewritten(g, *id);
        }
    }
}

fn rewritten(g: &mut Graph, id: Id) -> Id {
    let of_angles = angles(g, &[id]).into_iter();
    let turns = sorted::map(of_angles.filter_map(|angle| Some((angle, plainly(g, angle)?))));
    g.substitute(id, &turns)
}

/// A sine or cosine by a fraction that π has left for good. Of an angle such as acos(x) + 2 π / 3 it has not: what is divided by π
/// is rounded once more than the angle.
fn plainly(g: &mut Graph, angle: Id) -> Option<Id> {
    let turn = of_turn(g, angle)?;
    let pi = g.pi();
    let (mut open, mut seen) = (children(g.node(turn)), Set::default());
    while let Some(id) = open.pop() {
        if id == pi {
            return None;
        }
        if seen.insert(id) {
            open.extend(children(g.node(id)));
        }
    }
    Some(turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Fun, Leaf};
    use crate::interval::Interval;

    #[test]
    fn angles_that_are_multiples_of_pi_are_fractions_of_a_turn() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let k = g.leaf(Leaf::Param(0), "k", Interval::ALL);
        let (one, two, pi) = (g.int(1), g.int(2), g.pi());
        let turns = g.mul(two, u);
        let angle = g.mul(pi, turns);
        let other = g.mul(k, u);
        let [sine, cosine] = [Fun::Sin, Fun::Cos].map(|f| g.call(f, &[angle]));
        let unknown = g.call(Fun::Sin, &[other]);
        let product = g.product(&[sine, cosine, unknown].map(|f| (f, one)));
        let [sine, cosine] = [Fun::SinPi, Fun::CosPi].map(|f| g.call(f, &[turns]));
        let expected = g.product(&[sine, cosine, unknown].map(|f| (f, one)));
        assert_eq!(rewritten(&mut g, product), expected);
        assert_eq!(rewritten(&mut g, unknown), unknown);
        // An angle of which π is a part stays one.
        let beside = g.add(other, angle);
        let sine = g.call(Fun::Sin, &[beside]);
        assert_eq!(rewritten(&mut g, sine), sine);
    }
}
