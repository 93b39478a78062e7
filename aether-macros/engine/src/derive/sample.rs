//! A sample together with its density: what both compute is computed once, so that forms that are as accurate are
//! chosen by what they share.

use std::collections::BTreeMap;

use super::Problem;
use super::factored::factored;
use super::opened::opened;
use super::rooted::by_its_roots;
use crate::expr::{Fun, Graph, Id, Leaf, Node, OUTS};
use crate::hash::Map;
use crate::jacobian::cost_together;
use crate::measure::{Loss, Measure, Part};
use crate::sorted;
use crate::stabilise::{GOOD, of_turn, stabilise_knowing};

/// Whether a form is as accurate as another, or more accurate than it is worth to be. Where a density is
/// ill-conditioned each form is far off at some point, in one precision or the other.
fn as_good(new: Loss, old: Loss) -> bool {
    let bits =
        new.parts().into_iter().zip(old.parts()).all(|(new, old)| new.bits <= old.bits + 1.0);
    bits && new.worst() <= (4.0 * old.worst()).max(GOOD)
}

/// The coordinates of a sample in forms that are shorter and as accurate: with what the terms of their sums have in common
/// outside of them, as a vector that is given unit length twice has one divisor then, or as they are `written`, without
/// functions of twice an angle.
pub(super) fn shorter(
    g: &mut Graph,
    forward: Vec<Id>,
    written: &[Id],
    measure: &mut Measure,
) -> Vec<Id> {
    let open = |(&x, &y): (&Id, &Id)| opened(g, x).unwrap_or(y);
    let open: Vec<Id> = written.iter().zip(&forward).map(open).collect();
    let mut all = [factored(g, &forward), open];
    sorted::sort_by_key(&mut all, |forms| cost_together(g, forms));
    let mut loss = |form, of| measure.errors_of(g, form, of).loss();
    let good = |forms: &Vec<Id>| {
        forms.iter().zip(&forward).all(|(&new, &old)| as_good(loss(new, old), loss(old, old)))
    };
    let most = cost_together(g, &forward);
    let better = all.into_iter().filter(|forms| cost_together(g, forms) < most).find(good);
    better.unwrap_or(forward)
}

/// The volume at the uniforms as that of the sample itself, or by the sines and cosines that the sample has, where
/// this is more accurate, or as good and shares more with the sample. `gaps` tell of sums in which the sample loses
/// digits.
pub(super) fn at_the_sample(
    problem: &mut Problem,
    own: Id,
    (forward, density, gaps): (&[Id], Id, &Map<Id, Id>),
    measure: &mut Measure,
) -> Id {
    let g = &mut problem.graph;
    let sample = |written: &[Id], g: &mut Graph| {
        let outs = (0..written.len() as u8).map(Leaf::Out);
        let sample = sorted::map(outs.zip(written).map(|(leaf, &x)| (g.get_leaf(leaf), x)));
        let there = g.substitute(density, &sample);
        g.powi(there, -1)
    };
    let short = factored(g, &[own])[0];
    let rooted = by_its_roots(g, own);
    let mut forms = vec![sample(forward, g), by_its_angles(g, own, forward), short, rooted];
    forms.push(by_its_angles(g, short, forward));
    let old = measure.errors_of(g, own, own).loss();
    if old.worst() > GOOD && !gaps.is_empty() {
        let there = sample(&problem.outputs, g);
        forms.push(stabilise_knowing(g, there, measure, GOOD, gaps));
    }
    let work = |g: &Graph, own| cost_together(g, &[forward, &[own]].concat());
    let mut best = (own, old, work(g, own));
    for there in forms {
        if g.has(there, OUTS) {
            continue;
        }
        let (new, work) = (measure.errors_of(g, there, own).loss(), work(g, there));
        let saves = |new: Part, old: Part| {
            new.bits <= old.bits && new.worst < old.worst / 4.0 && old.worst > GOOD
        };
        let no_worse =
            new.double.bits <= best.1.double.bits && new.double.worst <= best.1.double.worst;
        let better =
            saves(new.double, best.1.double) || no_worse && saves(new.single, best.1.single);
        // What is given up for less work is counted from the form that came first.
        if better || as_good(new, old) && work + 10 < best.2 {
            best = (there, new, work);
        }
    }
    best.0
}

/// The expression with sines and cosines of an angle for those of the same fraction of a turn, or the other way
/// round, where some other expressions have these.
fn by_its_angles(g: &mut Graph, id: Id, others: &[Id]) -> Id {
    let [mine, theirs] = [&[id][..], others].map(|roots| angles(g, roots));
    let mut same = BTreeMap::new();
    for &angle in &mine {
        let turn = of_turn(g, angle).filter(|turn| theirs.contains(turn));
        same.extend(turn.map(|turn| (angle, turn)));
    }
    for &angle in &theirs {
        let turn = of_turn(g, angle).filter(|turn| mine.contains(turn));
        same.extend(turn.map(|turn| (turn, angle)));
    }
    if same.is_empty() { id } else { g.substitute(id, &same) }
}

/// The sines and cosines in expressions.
pub(super) fn angles(g: &Graph, roots: &[Id]) -> Vec<Id> {
    let is_angle = |f: &Fun| matches!(f, Fun::Sin | Fun::Cos | Fun::SinPi | Fun::CosPi);
    let mut found = g.within(roots);
    found.retain(|id| matches!(g.node(*id), Node::Call(f, _) if is_angle(f)));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;
    use crate::rational::Q;

    #[test]
    fn a_density_takes_the_sines_of_its_sample() {
        let mut g = Graph::new();
        let u = g.leaf(Leaf::Unknown(0), "u", Interval::new(0.0, 1.0));
        let twice = g.sum(Q::ZERO, &[(Q::int(2), u)]);
        let pi = g.pi();
        let angle = g.mul(twice, pi);
        let (sine, of_turn) = (g.call(Fun::Sin, &[angle]), g.call(Fun::SinPi, &[twice]));
        let square = |g: &mut Graph, x| {
            let square = g.powi(x, 2);
            g.sum(Q::ONE, &[(Q::int(3), square)])
        };
        let (density, other) = (square(&mut g, of_turn), square(&mut g, sine));
        assert_eq!(by_its_angles(&mut g, density, &[sine]), other);
        assert_eq!(by_its_angles(&mut g, other, &[of_turn]), density);
        let cosine = g.call(Fun::Cos, &[angle]);
        assert_eq!(by_its_angles(&mut g, density, &[cosine]), density);
    }
}
