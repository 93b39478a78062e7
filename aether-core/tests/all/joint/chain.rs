//! Mutations that draw joint runs, keep them, and keep pieces of them.

use aether_core::mutation::{conditional_pdf, mutation, propose};
use aether_core::{Arena, MarkovChainState, Pcg32, RandomSequence, Strategy};

use super::algebra::{Count, Spot, Walk, Ways, first_pair, pair, start, step};
use crate::world::Mean;

fn spots(path: &Walk<'_, '_>) -> Vec<f64> {
    path.vertices().map(|spot| spot.0).collect()
}

fn seed<'a, 'c>(arena: &'a Arena<Spot, Ways<'c>>, count: &'c Count) -> Walk<'a, 'c> {
    let mut path = arena.sequence();
    path.append(start()).append(pair(count)).append(step()).sample(&mut Pcg32::new(1, 0, 0));
    path
}

fn close(a: f64, b: f64) {
    assert!((a / b - 1.0).abs() < 1e-14, "{a} {b}");
}

#[test]
fn runs_are_drawn_anew_in_both_directions() {
    let (count, arena) = (Count::default(), Arena::new());
    let path = seed(&arena, &count);
    let forwards = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, _| {
        let mut front = path.slice(0..1).keep();
        front.append(pair(&count));
        Some(front.concat(&path.slice(3..).keep()))
    });
    let backwards = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, _| {
        let mut back = path.slice(3..).keep().reverse();
        back.append(pair(&count));
        Some(path.slice(0..1).keep().concat(&back.reverse()))
    });
    for sample in 0..50 {
        let mut uniforms = Pcg32::new(2, 0, sample);
        let x = spots(&path);
        let y = propose(&forwards, &path, &mut uniforms).expect("a proposal");
        let drawn = spots(&y);
        assert!(drawn[0] == x[0] && drawn[3] == x[3] && drawn[1] != x[1] && drawn[2] != x[2]);
        let before = [Spot(x[0])];
        let view = |before| aether_core::PathView::from_slice(before);
        let expected = pair(&count).pdf_joint(view(&before), &[Spot(drawn[1]), Spot(drawn[2])]);
        assert!(expected > 0.0);
        close(conditional_pdf(&forwards, &path, &y).value(), expected);
        let back = pair(&count).pdf_joint(view(&before), &[Spot(x[1]), Spot(x[2])]);
        close(conditional_pdf(&forwards, &y, &path).value(), back);
        // From the other end, in the other order.
        let y = propose(&backwards, &path, &mut uniforms).expect("a proposal");
        let drawn = spots(&y);
        let before = [Spot(x[3])];
        let expected = pair(&count).pdf_joint(view(&before), &[Spot(drawn[2]), Spot(drawn[1])]);
        assert!(expected > 0.0);
        close(conditional_pdf(&backwards, &path, &y).value(), expected);
    }
}

#[test]
fn a_piece_of_a_run_can_be_kept_but_not_drawn() {
    let (count, arena) = (Count::default(), Arena::new());
    let path = seed(&arena, &count);
    let keeps_a_piece = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, _| {
        let mut front = path.slice(0..2).keep();
        front.append(step());
        Some(front.concat(&path.slice(3..).keep()))
    });
    let x = spots(&path);
    let y = propose(&keeps_a_piece, &path, &mut Pcg32::new(2, 0, 0)).expect("a proposal");
    assert_eq!((spots(&y)[1], y.len()), (x[1], 4));
    let expected = 1.0 / (4.0 + x[1].abs());
    assert!((conditional_pdf(&keeps_a_piece, &path, &y).value() / expected - 1.0).abs() < 1e-14);
    let draws_a_piece = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, _| {
        let mut front = path.slice(0..1).keep();
        front.append(pair(&count));
        Some(front.slice(0..2).concat(&path.slice(2..).keep()))
    });
    assert!(propose(&draws_a_piece, &path, &mut Pcg32::new(2, 0, 0)).is_none());
    assert!(conditional_pdf(&draws_a_piece, &path, &y).is_zero());
}

#[test]
fn a_chain_of_pairs_keeps_its_distribution() {
    // Uniform on the triangle 0 < a < b < 2, whose mean a is two thirds.
    let target = |path: &RandomSequence<'_, Spot, Ways<'_>>| {
        let x = spots(path);
        let inside = x.len() == 2 && 0.0 < x[0] && x[0] < x[1] && x[1] < 2.0;
        (f64::from(inside), x.first().copied().unwrap_or(f64::NAN))
    };
    let moved = mutation(|path: &RandomSequence<'_, Spot, Ways<'_>>, _| {
        let mut proposal = path.slice(0..0).keep();
        let middle = (path.vertex(0)?.0 + path.vertex(1)?.0) / 2.0;
        // Not symmetric: the middle moves up more often than down.
        proposal.append(first_pair((middle - 0.5, 1.0 + middle)));
        Some(proposal)
    });
    let mut arena = Arena::new();
    let mut path = arena.sequence();
    path.append(first_pair((0.9, 0.2))).sample(&mut || 0.2);
    let mut chain = MarkovChainState::new(&path, &target);
    let mut mean = Mean::default();
    for _ in 0..200 {
        // Batches that are long compared with the chain's memory.
        let mut batch = 0.0;
        for _ in 0..400 {
            let step = chain.step(&mut arena, &moved, &target, |step| Pcg32::new(6, 0, step));
            batch += step.weighted().map(|(x, weight)| weight * x).sum::<f64>() / 400.0;
        }
        mean.add(batch);
    }
    let z = mean.z(2.0 / 3.0);
    assert!(z.abs() < 5.0, "{z}");
}
