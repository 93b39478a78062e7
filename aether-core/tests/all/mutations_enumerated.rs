//! Conditional densities and Markov chains in a world where everything can be enumerated: the oracle
//! is the sampling code alone, run for all values of its uniforms.

use std::collections::{BTreeMap, BTreeSet};

use crate::grid::{
    ALL, AnyMutation, Backward, Bidirectional, Choosing, Lens, Light, Path, Pattern, Proposal,
    Site, Sites, Step, Stored, Ways, for_each_proposal, reachable, seen_from, state, target,
};
use aether_core::mutation::{Mutations, Rated};
use aether_core::{
    Discrete, MarkovChainState, Mutation, PathDensity, Pcg32, Snapshot, UniformSource,
    accept_probability, conditional_pdf, discrete_weighted,
};

type States = BTreeMap<Pattern, Stored>;
/// How likely a mutation is selected at a path.
type Probability<'p> = &'p dyn Fn(&Path<'_>) -> f64;

/// The probabilities of all proposals, by how they look from the path that they were made of.
fn enumerated(mutation: AnyMutation<'_>, from: &Stored) -> BTreeMap<Pattern, f64> {
    let mut sums = BTreeMap::new();
    for_each_proposal(mutation, from, |from, to, p| {
        *sums.entry(seen_from(from, to)).or_default() += p;
    });
    sums
}

/// Calls `visit` with a representative of each proposal that can be told from others, in each way in which it can be made:
/// what drawing it told must not depend on that.
fn for_each_kind(
    mutation: AnyMutation<'_>,
    from: &Stored,
    mut visit: impl FnMut(&Path<'_>, &Path<'_>),
) {
    let mut done = BTreeSet::new();
    for_each_proposal(mutation, from, |from, to, _| {
        let made = Snapshot::of(to).steps().map(|(_, _, code)| code).collect::<Vec<_>>();
        if done.insert((seen_from(from, to), made)) {
            visit(from, to);
        }
    });
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-13 * a.max(b)
}

#[test]
fn conditional_densities_are_the_probabilities_of_the_proposals() {
    let states = reachable(&ALL);
    assert!(states.len() > 40, "{}", states.len());
    let mirrors = states.keys().filter(|state| state.iter().any(|vertex| vertex.3)).count();
    assert!(mirrors > 5, "{mirrors}");
    let mutations: [AnyMutation<'_>; 4] = [&Bidirectional, &Lens { lie: 1.0 }, &Backward, &ALL];
    for (number, mutation) in mutations.into_iter().enumerate() {
        let tables: BTreeMap<&Pattern, BTreeMap<Pattern, f64>> =
            states.iter().map(|(key, from)| (key, enumerated(mutation, from))).collect();
        let mut compared = [0; 2];
        let mut check = |from: &Path<'_>, to: &Path<'_>| {
            let Some(table) = tables.get(&state(from)) else { return };
            let expected = table.get(&seen_from(from, to)).copied().unwrap_or(0.0);
            let p = conditional_pdf(mutation, from, to).value();
            assert!(close(p, expected), "{number}: {from:?} {to:?} {p} {expected}");
            compared[usize::from(expected > 0.0)] += 1;
        };
        let arena = Sites::new();
        for from in states.values() {
            for_each_kind(mutation, from, |from, to| {
                check(from, to);
                check(to, from);
                check(from, from);
            });
            // Paths that have no vertex in common, and some that mutations hardly make.
            for to in states.values() {
                let (from, to) = (arena.restore(from), arena.restore(to));
                check(&from, &to);
                check(&from, &from.slice(0..1).concat(&to.slice(1..)));
                check(&from, &to.slice(0..1).concat(&from.slice(1..)));
                check(&from, &from.slice(0..2).concat(&to.slice(1..)));
            }
        }
        assert!(compared.iter().all(|n| *n > 200), "{number}: {compared:?}");
    }
}

/// The matrix of a chain's transitions to other states, and the target function.
fn transitions(
    states: &States,
    mutations: &[(AnyMutation<'_>, Probability<'_>)],
    accept: impl Fn(usize, &Path<'_>, &Path<'_>) -> f64,
) -> (Vec<Vec<f64>>, Vec<f64>) {
    let number: BTreeMap<&Pattern, usize> = states.keys().zip(0..).collect();
    let mut matrix = vec![vec![0.0; states.len()]; states.len()];
    let mut f = Vec::new();
    for (i, from) in states.values().enumerate() {
        f.push(target(&Sites::new().restore(from)));
        for (which, (mutation, probability)) in mutations.iter().enumerate() {
            let mut accepted = BTreeMap::new();
            for_each_proposal(*mutation, from, |from, to, p| {
                let Some(j) = number.get(&state(to)) else { return };
                let key = seen_from(from, to);
                let a = accepted.entry(key).or_insert_with(|| accept(which, from, to));
                matrix[i][*j] += probability(from) * p * *a;
            });
        }
    }
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] = 0.0;
        row[i] = 1.0 - row.iter().sum::<f64>();
        assert!(row[i] > -1e-12, "more goes on than there is");
    }
    (matrix, f)
}

/// The largest relative difference of f(x) P(x, y) and f(y) P(y, x).
fn imbalance((matrix, f): &(Vec<Vec<f64>>, Vec<f64>)) -> f64 {
    let mut worst = 0.0_f64;
    for (i, row) in matrix.iter().enumerate() {
        for (j, p) in row.iter().enumerate() {
            let (there, back) = (f[i] * p, f[j] * matrix[j][i]);
            if there.max(back) > 0.0 && i != j {
                worst = worst.max((there - back).abs() / there.max(back));
            }
        }
    }
    worst
}

fn rated<'a>(path: &Path<'a>) -> Rated<'a, Site, Ways> {
    Rated::new(*path, target(path))
}

/// How far the chain of a mutation is from balance.
fn imbalance_of(mutation: AnyMutation<'_>) -> f64 {
    let states = reachable(&ALL);
    let accept = |_, x: &Path<'_>, y: &Path<'_>| accept_probability(mutation, &rated(x), &rated(y));
    imbalance(&transitions(&states, &[(mutation, &|_| 1.0)], accept))
}

const LENS: Lens = Lens { lie: 1.0 };

#[test]
fn chains_are_in_detailed_balance() {
    for mutation in [&Bidirectional as AnyMutation<'_>, &LENS, &Backward, &ALL] {
        let worst = imbalance_of(mutation);
        assert!(worst < 1e-13, "{worst}");
    }
}

/// The probability of each of [`ALL`] at a path.
fn selection(i: usize) -> impl Fn(&Path<'_>) -> f64 {
    move |path| {
        let weights = ALL.0.iter().map(|mutation| mutation.weight(path));
        ALL.0[i].weight(path) / weights.sum::<f64>()
    }
}

/// The chain that accepts with the mutation that has been selected alone.
fn selected(mutations: Mutations<'_, Site, Ways>) -> (Vec<Vec<f64>>, Vec<f64>) {
    let selection = [selection(0), selection(1), selection(2)];
    let list: Vec<(AnyMutation<'_>, Probability<'_>)> =
        ALL.0.iter().zip(&selection).map(|(m, s)| (*m, s as Probability<'_>)).collect();
    transitions(&reachable(&ALL), &list, |i, x, y| {
        accept_probability(&mutations.only(i), &rated(x), &rated(y))
    })
}

#[test]
fn accepting_by_the_mutation_selected_is_balanced_too_and_accepts_less() {
    let alone = selected(ALL);
    assert!(imbalance(&alone) < 1e-13);
    let averaged = transitions(&reachable(&ALL), &[(&ALL, &|_| 1.0)], |_, x, y| {
        accept_probability(&ALL, &rated(x), &rated(y))
    });
    let mut more = 0;
    for (i, (a, b)) in averaged.0.iter().zip(&alone.0).enumerate() {
        for (j, (a, b)) in a.iter().zip(b).enumerate().filter(|(j, _)| *j != i) {
            assert!(*a >= b - 1e-15, "{i} {j}: {a} {b}");
            more += usize::from(*a > b + 1e-6);
        }
    }
    assert!(more > 50, "{more}");
    // Without the selection's probability, which differs there and back, it is not.
    let wrong = Mutations(&[&Even(&Bidirectional), &Even(&LENS), &Even(&Backward)]);
    assert!(imbalance(&selected(wrong)) > 0.1);
}

/// A mutation that is selected as often as any other.
struct Even<'m>(AnyMutation<'m>);
impl Mutation<Site, Ways> for Even<'_> {
    fn propose<'a>(&self, path: &Path<'a>, decide: &mut Choosing<'_>) -> Proposal<'a> {
        self.0.propose(path, decide)
    }
}

/// Breaks the rule that a mutation must do the same whatever it is run for.
struct Impure;
impl Mutation<Site, Ways> for Impure {
    fn propose<'a>(&self, path: &Path<'a>, decide: &mut Choosing<'_>) -> Proposal<'a> {
        let drawing = decide.wants(usize::MAX);
        let odds = if drawing { [1.0, 3.0] } else { [3.0, 1.0] };
        if decide.weighted(2, |i| odds[i])? == 0 {
            Bidirectional.propose(path, decide)
        } else {
            LENS.propose(path, decide)
        }
    }
}

/// Draws the end anew, by one of two strategies; the reverse move is as likely only if the path does
/// not change its length.
struct Tail {
    /// Whether the odds depend on the length of the path.
    skewed: bool,
}
impl Mutation<Site, Ways> for Tail {
    fn propose<'a>(&self, path: &Path<'a>, decide: &mut Choosing<'_>) -> Proposal<'a> {
        let odds = if self.skewed && path.len() > 2 { [3.0, 1.0] } else { [2.0, 2.0] };
        let mut front = path.slice(0..1).keep();
        if decide.weighted(2, |i| odds[i])? == 0 {
            front.append(Light);
        } else {
            front.append(Step).append(Step);
        }
        Some(front)
    }
}

#[test]
fn what_is_wrong_is_out_of_balance() {
    assert!(imbalance_of(&Lens { lie: 1.05 }) > 0.01);
    assert!(imbalance_of(&Impure) > 0.1);
    assert!(imbalance_of(&Tail { skewed: true }) < 1e-13);
    // Acceptance with the probabilities of choices at the wrong path, and without any densities.
    let states = reachable(&ALL);
    let skewed = Tail { skewed: true };
    let even = Tail { skewed: false };
    let wrong = |_, x: &Path<'_>, y: &Path<'_>| accept_probability(&even, &rated(x), &rated(y));
    assert!(imbalance(&transitions(&states, &[(&skewed, &|_| 1.0)], wrong)) > 0.1);
    let metropolis = |_, x: &Path<'_>, y: &Path<'_>| (target(y) / target(x)).min(1.0);
    assert!(imbalance(&transitions(&states, &[(&ALL, &|_| 1.0)], metropolis)) > 0.1);
}

#[test]
fn the_target_is_stationary_and_the_chain_converges_to_it() {
    let (matrix, f) = transitions(&reachable(&ALL), &[(&ALL, &|_| 1.0)], |_, x, y| {
        accept_probability(&ALL, &rated(x), &rated(y))
    });
    let total: f64 = f.iter().sum();
    let step = |p: &[f64]| -> Vec<f64> {
        (0..p.len()).map(|j| p.iter().zip(&matrix).map(|(p, row)| p * row[j]).sum()).collect()
    };
    let distance =
        |p: &[f64]| -> f64 { p.iter().zip(&f).map(|(p, f)| (p - f / total).abs()).sum() };
    let stationary: Vec<f64> = f.iter().map(|f| f / total).collect();
    assert!(distance(&step(&stationary)) < 1e-14);
    let mut p = vec![0.0; f.len()];
    p[0] = 1.0;
    for _ in 0..800 {
        p = step(&p);
    }
    assert!(distance(&p) < 1e-4, "{}", distance(&p));
}

type Chain = MarkovChainState<Site, Ways, Pattern>;

fn rate(path: &Path<'_>) -> (f64, Pattern) {
    (target(path), state(path))
}

/// The numbers of each step of a chain.
fn uniforms(chain: u64) -> impl Fn(u64) -> Pcg32 {
    move |step| Pcg32::new(5, chain, step)
}

/// Chi-square of where many chains are after 30 steps that were begun with states distributed as the
/// target function, against it, as a z-score (Wilson and Hilferty 1931). Chains are independent, so
/// counts are multinomial. States of which fewer than ten are expected count as one.
fn chi_square(step: impl Fn(&mut Chain, &mut Sites, u64)) -> f64 {
    const CHAINS: u64 = 20_000;
    let states = reachable(&ALL);
    let f: Vec<f64> = states.values().map(|state| target(&Sites::new().restore(state))).collect();
    let total: f64 = f.iter().sum();
    let distributed = discrete_weighted(states.values().collect::<Vec<_>>(), &f).expect("weights");
    let mut arena = Sites::new();
    let mut counts: BTreeMap<Pattern, u64> = BTreeMap::new();
    for chain in 0..CHAINS {
        let first = distributed.sample(Pcg32::new(6, chain, 0).next()).item;
        let mut at = MarkovChainState::new(&arena.restore(first), &rate);
        for _ in 0..30 {
            step(&mut at, &mut arena, chain);
        }
        *counts.entry(at.contribution().clone()).or_default() += 1;
    }
    let (mut bins, mut rest) = (Vec::new(), (0.0, 0.0));
    for (key, f) in states.keys().zip(&f) {
        let expected = f / total * CHAINS as f64;
        let count = counts.get(key).copied().unwrap_or(0) as f64;
        if expected >= 10.0 {
            bins.push((count, expected));
        } else {
            rest = (rest.0 + count, rest.1 + expected);
        }
    }
    bins.extend((rest.1 > 0.0).then_some(rest));
    let chi: f64 = bins.iter().map(|(n, e)| (n - e) * (n - e) / e).sum();
    let k = (bins.len() - 1) as f64;
    ((chi / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

/// False alarm with probability 3e-7 (z > 5).
#[test]
fn chains_stay_distributed_as_the_target() {
    let z = chi_square(|at, arena, chain| _ = at.step(arena, &ALL, &rate, uniforms(chain)));
    assert!(z < 5.0, "{z}");
    let among = |at: &mut Chain, arena: &mut Sites, chain| {
        let step = at.step_among(arena, &ALL, &rate, uniforms(chain));
        assert!(step.selected.is_some());
    };
    let z = chi_square(among);
    assert!(z < 5.0, "{z}");
}

#[test]
fn chains_with_a_wrong_density_would_be_found() {
    let z = chi_square(|at, arena, chain| _ = at.step(arena, &Impure, &rate, uniforms(chain)));
    assert!(z > 5.0, "a wrong density is not found: {z}");
}

#[test]
fn zeros_poles_and_nan_are_safe() {
    let arena = Sites::new();
    let states = reachable(&ALL);
    let from = arena.restore(states.values().last().expect("there are states"));
    let to = (0..)
        .filter_map(|i| aether_core::mutation::propose(&ALL, &from, &mut Pcg32::new(1, 0, i)))
        .find(|to| conditional_pdf(&ALL, to, &from).is_regular())
        .expect("there are proposals");
    let accept =
        |f: f64, g: f64| accept_probability(&ALL, &Rated::new(from, f), &Rated::new(to, g));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(accept(1.0, bad), 0.0);
        assert_eq!(accept(bad, bad), 0.0);
        assert_eq!(accept(bad, 1.0), 1.0);
    }
    assert_eq!(accept(1e-300, 1e300), 1.0);
    assert!(accept(1e300, 1e-5) > 0.0);
    let tiny = PathDensity::new(1e-300) * 1e-300;
    let there = accept_probability(&ALL, &Rated::new(from, tiny), &Rated::new(to, tiny));
    assert!((there - accept(1.0, 1.0)).abs() < 1e-13);
    // A path that is not complete, one of another arena, and nothing to select from.
    let other = Sites::new();
    let foreign = other.restore(states.values().last().expect("there are states"));
    assert!(conditional_pdf(&ALL, &from, &foreign).is_zero());
    assert!(conditional_pdf(&ALL, &from.slice(0..9), &from).is_zero());
    assert!(conditional_pdf(&Mutations(&[]), &from, &to).is_zero());
    assert!(aether_core::mutation::propose(&Mutations(&[]), &from, &mut || 0.5).is_none());
    assert!(conditional_pdf(&ALL.only(7), &from, &to).is_zero());
}
