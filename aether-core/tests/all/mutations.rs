//! Mutations of paths of real numbers: closed forms, quadrature, mirrors, and what is kept.

use crate::world::{Camera, Light, PINHOLE, SURVIVAL, Seen, Spot, Step, World};
use aether_core::mutation::{Decisions, Draft, Mutations, mutation, propose, shift_jacobian};
use aether_core::sequence::{Arena, PathView, RandomSequence, Snapshot};
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Strategy};
use aether_core::{
    Estimator, MarkovChainState, Mutation, Pcg32, UniformSource, conditional_pdf, strategies,
};

/// Uniform within `RADIUS` of where the vertex has been; none outside [0, 1].
#[derive(Clone, Copy)]
struct Nudge(Spot);
const RADIUS: f64 = 0.2;
impl Strategy<Spot> for Nudge {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let x = self.0.0 + RADIUS * (2.0 * uniforms.next() - 1.0);
        (0.0..=1.0).contains(&x).then(|| Drawn::new(Spot(x)))
    }
    fn pdf(&self, _: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let near = (target.0 - self.0.0).abs() <= RADIUS && (0.0..=1.0).contains(&target.0);
        Conditional::density(if near { 0.5 / RADIUS } else { 0.0 })
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
}

/// A point x = s² with s uniform within `RADIUS` of the root of what it has been.
#[derive(Clone, Copy)]
struct Pixel(Spot);
impl Strategy<Spot> for Pixel {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        uniforms: &mut U,
    ) -> Option<Drawn<Spot>> {
        let s = self.0.0.sqrt() + RADIUS * (2.0 * uniforms.next() - 1.0);
        (s > 0.0).then(|| Drawn::new(Spot(s * s)))
    }
    fn pdf(&self, _: PathView<'_, Spot>, target: &Spot) -> Conditional<f64> {
        let s = target.0.sqrt();
        let near = (s - self.0.0.sqrt()).abs() <= RADIUS;
        Conditional::density(if near { 0.25 / (RADIUS * s) } else { 0.0 })
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
}

/// A vertex where it is wanted.
#[derive(Clone, Copy)]
struct Put(f64, Option<Dirac>);
impl Strategy<Spot> for Put {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Spot>,
        _: &mut U,
    ) -> Option<Drawn<Spot>> {
        Some(Drawn { dirac: self.1, ..Drawn::new(Spot(self.0)) })
    }
    fn pdf(&self, _: PathView<'_, Spot>, _: &Spot) -> Conditional<f64> {
        Conditional::ZERO
    }
}

strategies! {
    #[derive(Clone, Copy)]
    enum Ways<'w> for Spot {
        Camera(Camera), Step(Step<'w>), Light(Light<'w>), Nudge(Nudge), Pixel(Pixel), Put(Put)
    }
}

type Walks<'w> = Arena<Spot, Ways<'w>>;
type Path<'a, 'w> = RandomSequence<'a, Spot, Ways<'w>>;
type Proposal<'a, 'w> = Option<Draft<'a, Spot, Ways<'w>>>;
type Choosing<'d> = Decisions<'d, f64>;

/// The pinhole and further vertices; the last is seen in the mirror if `mirrored`.
fn path<'a, 'w>(arena: &'a Walks<'w>, spots: &[f64], mirrored: bool) -> Path<'a, 'w> {
    let mut path = arena.sequence();
    path.append(Camera);
    for (i, x) in spots.iter().enumerate() {
        let last = i + 1 == spots.len();
        path.append(Put(*x, (mirrored && last).then_some(Dirac::Direction)));
    }
    *path.sample(&mut || 0.5)
}

/// Vertex `i` replaced by one at `x`, the others kept.
fn with<'a, 'w>(path: &Path<'a, 'w>, i: usize, x: f64) -> Path<'a, 'w> {
    let mut front = path.slice(0..i);
    front.append(Put(x, None)).sample(&mut || 0.5);
    front.concat(&path.slice(i + 1..))
}

/// Moves vertex 1 a bit, or draws it anew, and goes on where the path was.
struct Reconnect<'w>(&'w World);
impl<'w> Mutation<Spot, Ways<'w>> for Reconnect<'w> {
    fn propose<'a>(&self, path: &Path<'a, 'w>, decide: &mut Choosing<'_>) -> Proposal<'a, 'w> {
        let mut front = path.slice(0..1).keep();
        if decide.weighted(2, |i| [1.0, 3.0][i])? == 0 {
            front.append(Nudge(path.vertex(1)?));
        } else {
            front.append(Step(self.0));
        }
        Some(front.concat(&path.slice(2..).keep()))
    }
}

#[test]
fn a_reconnection_has_its_closed_form() {
    let world = World::default();
    let arena = Walks::new();
    let from = path(&arena, &[0.35, 0.6, 0.9], false);
    let closed = |y: f64| {
        let nudge = if (y - 0.35).abs() < RADIUS { 0.5 / RADIUS } else { 0.0 };
        0.25 * nudge + 0.75 * SURVIVAL * (1.0 - PINHOLE + 2.0 * PINHOLE * y)
    };
    let n = 2000;
    let (mut mass, mut mean) = (0.0, 0.0);
    for k in 0..n {
        let y = (f64::from(k) + 0.5) / f64::from(n);
        let p = conditional_pdf(&Reconnect(&world), &from, &with(&from, 1, y)).value();
        assert!((p / closed(y) - 1.0).abs() < 1e-14, "{y}: {p} {}", closed(y));
        mass += p / f64::from(n);
        mean += p * y / f64::from(n);
    }
    // The same from the sampling code alone, over a grid of its uniforms: which mutation, survival,
    // (which lobe,) where. The midpoint rule is exact to about 1 / n at each jump.
    let (mut sampled_mass, mut sampled_mean) = (0.0, 0.0);
    let grid = |count: u32| (0..count).map(move |k| (f64::from(k) + 0.5) / f64::from(count));
    for which in grid(4) {
        for survival in grid(5) {
            for lobe in grid(100) {
                for u in grid(100) {
                    let mut numbers = [which, survival, 0.5, lobe, u].into_iter();
                    if which < 0.25 {
                        numbers = [which, u, 0.0, 0.0, 0.0].into_iter();
                    }
                    let mut uniforms = || numbers.next().unwrap_or(0.5);
                    if let Some(to) = propose(&Reconnect(&world), &from, &mut uniforms) {
                        let weight = 1.0 / (4.0 * 5.0 * 1e4);
                        sampled_mass += weight;
                        sampled_mean += weight * to.vertex(1).map_or(0.0, |spot| spot.0);
                    }
                }
            }
        }
    }
    assert!((mass - sampled_mass).abs() < 1e-3, "{mass} {sampled_mass}");
    assert!((mean - sampled_mean).abs() < 1e-3, "{mean} {sampled_mean}");
}

#[test]
fn common_vertices_are_known_by_identity_not_by_place() {
    let world = World::default();
    let arena = Walks::new();
    let from = path(&arena, &[0.35, 0.6, 0.9], false);
    let mutation = Reconnect(&world);
    let p = |to| conditional_pdf(&mutation, &from, &to).value();
    // What is kept in place of what was moved: it would have to be hit by chance.
    assert_eq!(p(from), 0.0);
    assert!(p(with(&from, 1, 0.35)) > 0.0);
    // Another vertex at the same place is another vertex.
    assert_eq!(p(with(&with(&from, 1, 0.4), 2, 0.6)), 0.0);
    assert_eq!(p(path(&arena, &[0.4, 0.6, 0.9], false)), 0.0);
    // The right vertices at wrong places.
    let shuffled = with(&from, 1, 0.4);
    let shuffled = shuffled.slice(0..2).concat(&shuffled.slice(2..).reverse());
    assert_eq!(p(shuffled), 0.0);
    assert_eq!(p(with(&from, 1, 0.4).slice(0..3)), 0.0);
}

/// Mutations that have to do with the mirror at vertex 1.
#[derive(Clone, Copy)]
enum Mirror<'w> {
    /// Draws the end anew.
    End(&'w World),
    /// Moves the mirror and keeps the end.
    Move,
    /// Moves the mirror and draws the end anew.
    MoveEnd(&'w World),
    /// Draws all but the pinhole anew.
    Anew(&'w World),
    /// Draws the end from the light.
    Light(&'w World),
}
impl<'w> Mutation<Spot, Ways<'w>> for Mirror<'w> {
    fn propose<'a>(&self, path: &Path<'a, 'w>, _: &mut Choosing<'_>) -> Proposal<'a, 'w> {
        let keep = |n: usize| path.slice(0..n).keep();
        let nudge = Nudge(path.vertex(1)?);
        Some(match *self {
            Mirror::End(world) => *keep(2).append(Step(world)),
            Mirror::Move => keep(1).append(nudge).concat(&path.slice(2..).keep()),
            Mirror::MoveEnd(world) => *keep(1).append(nudge).append(Step(world)),
            Mirror::Anew(world) => *keep(1).append(Step(world)).append(Step(world)),
            Mirror::Light(world) => *keep(2).append(Light(world)),
        })
    }
}

#[test]
fn mirrors_are_kept_with_their_neighbours_or_drawn_anew() {
    let world = World::with_mirror(0.4);
    let arena = Walks::new();
    let from = path(&arena, &[0.5, 1.0 - PINHOLE], true);
    assert!(from.view().carries(1, Dirac::Direction));
    fn density<'w>(m: Mirror<'w>, from: &Path<'_, 'w>, to: &Path<'_, 'w>) -> f64 {
        conditional_pdf(&m, from, to).value()
    }
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    let (mirror, coat) = (SURVIVAL * 0.3, SURVIVAL * 0.7);
    let step = |x: f64, y: f64| 1.0 - x + 2.0 * x * y;

    // The end anew: by the mirror it has a probability, by the coat a density.
    let reflected = propose(&Mirror::End(&world), &from, &mut || 0.1).expect("survives");
    assert!(reflected.view().carries(1, Dirac::Direction));
    close(density(Mirror::End(&world), &from, &reflected), mirror);
    close(density(Mirror::End(&world), &reflected, &from), mirror);
    let mut numbers = [0.1, 0.9, 0.1, 0.25].into_iter();
    let scattered = propose(&Mirror::End(&world), &from, &mut || numbers.next().unwrap_or(0.5));
    let scattered = scattered.expect("survives");
    assert!(!scattered.view().carries(1, Dirac::Direction));
    let x = scattered.last().map_or(0.0, |spot| spot.0);
    close(density(Mirror::End(&world), &from, &scattered), coat * step(0.5, x));
    close(density(Mirror::End(&world), &scattered, &from), mirror);

    // Only the mirror moved: its light goes elsewhere, and there is no way back.
    let moved = propose(&Mirror::Move, &from, &mut || 0.75).expect("inside");
    assert!(!moved.view().carries(1, Dirac::Direction));
    close(density(Mirror::Move, &from, &moved), 0.5 / RADIUS);
    close(density(Mirror::Move, &moved, &from), 0.0);
    // A path without the mirror's factor is moved there and back.
    let plain = path(&arena, &[0.5, 1.0 - PINHOLE], false);
    let moved = propose(&Mirror::Move, &plain, &mut || 0.75).expect("inside");
    close(density(Mirror::Move, &moved, &plain), 0.5 / RADIUS);

    // The mirror moved and the end drawn by it.
    let mut numbers = [0.75, 0.1, 0.1].into_iter();
    let followed = propose(&Mirror::MoveEnd(&world), &from, &mut || numbers.next().unwrap_or(0.5));
    let followed = followed.expect("survives");
    assert!(followed.view().carries(1, Dirac::Direction));
    close(density(Mirror::MoveEnd(&world), &from, &followed), 0.5 / RADIUS * mirror);
    close(density(Mirror::MoveEnd(&world), &followed, &from), 0.5 / RADIUS * mirror);
    // The same path by drawing everything anew; a light does not find the end of a mirror.
    let anew = SURVIVAL * step(PINHOLE, 0.6) * mirror;
    close(density(Mirror::Anew(&world), &from, &followed), anew);
    close(density(Mirror::Light(&world), &from, &reflected), 0.0);
    close(density(Mirror::Light(&world), &from, &scattered), 2.0 * x);
}

#[test]
fn what_was_seen_stays_seen_where_both_ends_are_kept() {
    let world = World::default();
    let arena = Walks::new();
    let mut from = arena.sequence();
    from.append(Camera);
    (0..4).for_each(|_| _ = from.append(Step(&world)));
    from.sample(&mut || 0.3);
    let reversed = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| {
        let mut back = path.slice(3..).keep().reverse();
        Some(
            path.slice(0..1)
                .keep()
                .append(Nudge(path.vertex(1)?))
                .concat(&back.append(Nudge(path.vertex(2)?)).reverse()),
        )
    });
    let to = propose(&reversed, &from, &mut || 0.3).expect("inside");
    let seen: Vec<_> = (1..5).map(|i| to.view().visible(i)).collect();
    assert_eq!(seen, [false, false, false, true]);
    assert_eq!(
        (0..5).map(|i| from.position_of(&to, i)).collect::<Vec<_>>(),
        [Some(0), None, None, Some(3), Some(4)]
    );
    // Cut and joined again where it was cut, nothing is lost.
    let same = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| {
        Some(path.slice(0..2).keep().concat(&path.slice(2..).keep()))
    });
    let to = propose(&same, &from, &mut || 0.3).expect("nothing is drawn");
    assert!((1..5).all(|i| to.view().visible(i)));
    assert_eq!(conditional_pdf(&same, &from, &to).value(), 1.0);
    assert!((to.pdf().ratio(from.pdf()) - 1.0).abs() < 1e-14);
}

#[test]
fn drafts_that_cannot_be_drawn_make_no_proposal() {
    let world = World::default();
    let arena = Walks::new();
    let from = path(&arena, &[0.35, 0.6, 0.9], false);
    let other = path(&arena, &[0.1, 0.2], false);
    let step = Step(&world);
    for case in 0..5 {
        let mutation = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| match case {
            0 => Some(path.slice(0..9).keep()),
            1 => Some(path.keep().slice(3..7)),
            2 => Some(*path.slice(0..9).keep().append(step)),
            // A step forwards from a vertex that is found on the way back.
            3 => {
                let found = path.slice(2..3).keep().reverse().append(step).reverse();
                Some(*found.slice(0..1).append(step))
            }
            _ => None,
        });
        assert!(propose(&mutation, &from, &mut || 0.5).is_none(), "{case}");
        for to in [other, other.slice(1..3)] {
            assert!(conditional_pdf(&mutation, &from, &to).is_zero(), "{case}");
        }
    }
    // Vertices that the current path does not have.
    let snapshot = Snapshot::of(&other);
    let foreign = Walks::new();
    let elsewhere = foreign.restore(&snapshot);
    let everything = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| Some(path.keep()));
    assert!(conditional_pdf(&everything, &from, &elsewhere).is_zero());
    assert_eq!(conditional_pdf(&everything, &from, &from).value(), 1.0);
}

#[test]
fn a_draft_that_keeps_a_vertex_twice_makes_no_proposal() {
    let arena = Walks::new();
    let from = path(&arena, &[0.35, 0.6], false);
    // With two vertices that are one, the path would have a density per measure of one place less than all others have.
    let twice = mutation(|path: &Path<'_, '_>, decide: &mut Choosing<'_>| {
        let kept = |i: usize| path.slice(i..i + 1).keep();
        let order = [[0, 1, 1], [0, 2, 0], [2, 1, 0]][decide.index(3)?];
        Some(kept(order[0]).concat(&kept(order[1])).concat(&kept(order[2])))
    });
    for (u, exists) in [(0.1, false), (0.5, false), (0.9, true)] {
        assert_eq!(propose(&twice, &from, &mut || u).is_some(), exists, "{u}");
    }
    let piece = |i: usize| from.slice(i..i + 1);
    let join = |[a, b, c]: [usize; 3]| piece(a).concat(&piece(b)).concat(&piece(c));
    for order in [[0, 1, 1], [0, 2, 0]] {
        assert!(conditional_pdf(&twice, &from, &join(order)).is_zero(), "{order:?}");
    }
    assert!((conditional_pdf(&twice, &from, &join([2, 1, 0])).value() - 1.0 / 3.0).abs() < 1e-15);
    // The same at the ends of a path, where most vertices are looked for.
    let (longer, ends) = (from.concat(&piece(2)), piece(0).concat(&from));
    let whole = |first: bool| {
        mutation(move |path: &Path<'_, '_>, _: &mut Choosing<'_>| {
            let (all, end) = (path.keep(), if first { path.slice(0..1) } else { path.slice(2..3) });
            Some(if first { end.keep().concat(&all) } else { all.concat(&end.keep()) })
        })
    };
    for (first, to) in [(false, longer), (true, ends)] {
        assert!(propose(&whole(first), &from, &mut || 0.5).is_none());
        assert!(conditional_pdf(&whole(first), &from, &to).is_zero());
    }
}

#[test]
fn a_chain_moves_on_from_a_path_that_it_cannot_begin_with() {
    let world = World::default();
    let arena = Walks::new();
    let anew = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| {
        let mut draft = path.slice(0..0).keep();
        draft.append(Light(&world)).append(Light(&world));
        Some(draft)
    });
    // Of a path that has not found all of its vertices the last one found may look bright; so may two that have met.
    let bright = |path: &Path<'_, '_>| (path.last().map_or(0.0, |spot| spot.0), ());
    let mut pending = arena.sequence();
    pending.append(Light(&world)).sample(&mut || 0.5).append(Light(&world));
    let mut back = arena.sequence();
    back.append(Light(&world)).append(Step(&world)).sample(&mut || 0.5);
    let merged = path(&arena, &[0.35], false).merge(&back.reverse(), 0.1);
    assert!(!pending.is_complete() && merged.is_complete() && bright(&merged).0 > 0.0);
    // No way leads back to the empty path, nor has one to.
    for start in [pending, merged] {
        let mut chain = MarkovChainState::new(&start, &bright);
        assert!(chain.target().is_zero());
        let mut among = chain.clone();
        let uniforms = |step| Pcg32::new(1, 0, step);
        let step = chain.step(&mut Walks::new(), &anew, &bright, uniforms);
        assert!(step.accepted && chain.path().len() == 2);
        let all = Mutations(&[&anew]);
        for k in 0..2 {
            let step = among.step_among(&mut Walks::new(), &all, &bright, uniforms);
            assert!(step.selected == Some(0) && (step.accepted || k > 0));
        }
        assert_eq!(among.path().len(), 2);
    }
}

#[test]
fn what_cannot_come_next_does_not_count() {
    let arena = Walks::new();
    let world = World::default();
    let anew = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| {
        Some(*path.slice(0..0).keep().append(Light(&world)))
    });
    // A colour over its brightness, which is no number where there is none: half of all proposals, 1 - u < 1/4, and the start.
    let seen = |path: &Path<'_, '_>| {
        let f = path.last().map_or(0.0, |spot| (spot.0 - 0.5).max(0.0));
        (f, f / f)
    };
    let mut start = arena.sequence();
    start.append(Light(&world)).sample(&mut || 0.9);
    assert_eq!(seen(&start).0, 0.0);
    let mut chain = MarkovChainState::new(&start, &seen);
    let (mut sum, mut dark) = (0.0, 0);
    for _ in 0..200 {
        let step = chain.step(&mut Walks::new(), &anew, &seen, |step| Pcg32::new(1, 0, step));
        let is_dark = chain.target().is_zero();
        dark += usize::from(is_dark);
        if !is_dark {
            sum += step.weighted().map(|(colour, weight)| weight * colour).sum::<f64>();
            let total: f64 = step.weighted().map(|(_, weight)| weight).sum();
            assert!((total - 1.0).abs() < 1e-15);
        }
    }
    assert!((sum + dark as f64 - 200.0).abs() < 1e-12, "{sum} {dark}");
}

#[test]
fn a_shift_stretches_by_the_ratio_of_its_densities() {
    let arena = Walks::new();
    let shift = mutation(|path: &Path<'_, '_>, _: &mut Choosing<'_>| {
        let mut front = path.slice(0..1).keep();
        front.append(Pixel(path.vertex(1)?));
        Some(front.concat(&path.slice(2..).keep()))
    });
    let from = path(&arena, &[0.25, 0.6], false);
    for s in [0.31, 0.45, 0.5, 0.69] {
        // x = s², shifted by as much for all s: dx'/dx = s'/s.
        let jacobian = shift_jacobian(&shift, &from, &with(&from, 1, s * s));
        assert!((jacobian - s / 0.5).abs() < 1e-14, "{s}: {jacobian}");
    }
    assert_eq!(shift_jacobian(&shift, &from, &with(&from, 1, 0.9)), 0.0);
}

#[test]
fn a_snapshot_is_the_path() {
    let world = World::with_mirror(0.4);
    let arena = Walks::new();
    let mut from = arena.sequence();
    from.append(Camera).append(Step(&world)).append(Step(&world)).append(Step(&world));
    let mut numbers = [0.1, 0.9, 0.9, 0.2, 0.1, 0.1, 0.1, 0.9, 0.4, 0.7].into_iter();
    from.sample(&mut || numbers.next().unwrap_or(0.5));
    let mut emt = arena.sequence();
    emt.append(Light(&world)).append(Step(&world)).sample(&mut || 0.75);
    let from = from.concat(&emt.reverse());
    let snapshot = Snapshot::of(&from);
    assert_eq!(snapshot.len(), 6);
    let estimator = Estimator::paths(Seen(&world));
    let (f, p, estimate) = (estimator.integrand_at(&from), from.pdf(), estimator.of(&from));
    assert!((f / p.value() - estimate).abs() < 1e-14 * estimate && estimate > 0.0);
    let other = Walks::new();
    let to = other.restore(&snapshot);
    assert_eq!(to.vertices().collect::<Vec<_>>(), from.vertices().collect::<Vec<_>>());
    assert!((to.pdf().ratio(p) - 1.0).abs() < 1e-14);
    assert_eq!(estimator.integrand_at(&to), f);
    // The same from the numbers that a file may keep.
    let steps: Vec<_> = snapshot.steps().map(|(v, s, code)| (*v, *s, code)).collect();
    let kept = Snapshot::from_steps(steps.clone());
    let again = other.restore(&kept);
    assert!((again.pdf().ratio(p) - 1.0).abs() < 1e-14);
    assert_eq!(estimator.integrand_at(&again), f);
    assert!(kept.steps().map(|(_, _, code)| code).eq(steps.iter().map(|step| step.2)));
    assert!(Snapshot::of(&from.slice(0..9)).is_empty());
    assert!((0..6).all(|i| arena.restore(&snapshot).position_of(&from, i).is_none()));
}

const BINS: usize = 6;

/// Paths of two edges, of which the second is a mirror's or not, that are begun distributed as the
/// light they carry, after 20 steps of a chain: chi-square against the exact integrals over bins, as
/// a z-score (Wilson and Hilferty 1931). Chains are independent, so counts are multinomial.
fn chi_square(coefficient: f64) -> f64 {
    let world = World::with_mirror(0.4);
    let estimator = Estimator::paths(Seen(&world));
    let wrong = World::with_mirror(coefficient);
    let wrong = Estimator::paths(Seen(&wrong));
    let bin = |x: f64| ((x * BINS as f64) as usize).min(BINS - 1);
    let place = |path: &Path<'_, '_>| {
        let [x, y] = [1, 2].map(|i| path.vertex(i).map_or(0.0, |spot| spot.0));
        let mirrored = path.view().carries(1, Dirac::Direction);
        if mirrored { BINS * BINS + bin(x) } else { bin(x) * BINS + bin(y) }
    };
    // The light of a path; Gauss's rule with two points is exact for cubics.
    let nodes = |i: usize| [-1.0, 1.0].map(|s| (i as f64 + 0.5 + s / 12_f64.sqrt()) / BINS as f64);
    let light = |x: f64, y: f64| (1.0 + PINHOLE * x) / 2.0 * (1.0 + x * y) / 2.0 * 2.0 * y;
    let mirror = |x: f64| (1.0 + PINHOLE * x) / 2.0 * 0.4 * 2.0 * (1.0 - PINHOLE);
    let cell = (0.5 / BINS as f64).powi(2);
    let mut expected: Vec<f64> = (0..BINS * BINS)
        .map(|k| {
            let points = nodes(k / BINS).map(|x| nodes(k % BINS).map(|y| light(x, y)));
            points.as_flattened().iter().sum::<f64>() * cell
        })
        .collect();
    expected
        .extend((0..BINS).map(|i| nodes(i).map(mirror).iter().sum::<f64>() * 0.5 / BINS as f64));
    let total: f64 = expected.iter().sum();
    let mirrored = expected[BINS * BINS..].iter().sum::<f64>() / total;

    let moves: [&dyn Mutation<Spot, Ways<'_>>; 6] = [
        &Reconnect(&world),
        &Mirror::End(&world),
        &Mirror::Move,
        &Mirror::MoveEnd(&world),
        &Mirror::Anew(&world),
        &Mirror::Light(&world),
    ];
    let target = |path: &Path<'_, '_>| (wrong.integrand_at(path), place(path));
    let (chains, mut counts, mut arena) = (40_000, [0.0; BINS * BINS + BINS], Walks::new());
    for chain in 0..chains {
        let mut uniforms = Pcg32::new(8, chain, 0);
        let mut next = || UniformSource::<f64>::next(&mut uniforms);
        let by_mirror = next() < mirrored;
        let start = loop {
            let (x, y, u) = (next(), next(), next());
            let start = path(&arena, &[x, if by_mirror { 1.0 - PINHOLE } else { y }], by_mirror);
            if 1.4 * u < estimator.integrand_at(&start) {
                break start;
            }
        };
        let mut state = MarkovChainState::new(&start, &target);
        for _ in 0..20 {
            state.step(&mut arena, &Mutations(&moves), &target, |step| Pcg32::new(9, chain, step));
        }
        counts[*state.contribution()] += 1.0;
    }
    let expected = expected.iter().map(|e| e / total * chains as f64);
    let chi: f64 = counts.iter().zip(expected).map(|(n, e)| (n - e) * (n - e) / e).sum();
    let k = (counts.len() - 1) as f64;
    ((chi / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

/// False alarm with probability 3e-7 (z > 5).
#[test]
fn chains_stay_distributed_as_the_light() {
    let z = chi_square(0.4);
    assert!(z < 5.0, "{z}");
}

#[test]
fn an_error_of_ten_percent_in_a_coefficient_would_be_found() {
    let z = chi_square(0.44);
    assert!(z > 5.0, "an error of ten percent in the mirror's coefficient is not found: {z}");
}
