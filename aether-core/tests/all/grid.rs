//! A world of three sites, small enough to run through everything that can happen in it.
//!
//! Every uniform decides between quarters, so that an experiment is run once for each combination of
//! quarters, with exact probabilities. A pinhole at site 0 looks at the world; site 1 is a mirror
//! under a coat that scatters; every site emits. Strategies tell the density of what they draw, as derived ones do.

#![allow(dead_code)] // Each test uses a part of it.

use std::collections::BTreeMap;

use aether_core::mutation::{Decisions, Draft, Mutation, Mutations, propose};
use aether_core::sequence::{Arena, PathView, RandomSequence, Snapshot};
use aether_core::strategy::{Conditional, Dirac, Drawn, Reads, Strategy, Vertex};
use aether_core::{UniformSource, strategies};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Site(pub usize);

impl Vertex for Site {
    type Real = f64;
    type Point = f64;
    fn point(&self) -> f64 {
        self.0 as f64
    }
}

/// Which of the quarters `u` lies in, given how many of them go to each outcome.
fn pick<const N: usize>(u: f64, quarters: [usize; N]) -> usize {
    let mut below = 0;
    let chosen = quarters.iter().position(|n| {
        below += n;
        4.0 * u < below as f64
    });
    chosen.unwrap_or(N)
}

#[derive(Clone, Copy)]
pub struct Camera;
impl Strategy<Site> for Camera {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Site>,
        _: &mut U,
    ) -> Option<Drawn<Site>> {
        Some(Drawn::atom(Site(0), Dirac::Position).with_value(1.0))
    }
    fn pdf(&self, _: PathView<'_, Site>, _: &Site) -> Conditional<f64> {
        Conditional::atom(Dirac::Position, 1.0)
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// Scatters by a table that depends on the vertex before too, or takes the mirror.
#[derive(Clone, Copy)]
pub struct Step;
impl Step {
    fn table(path: PathView<'_, Site>) -> Option<[usize; 3]> {
        let (x, w) = (path.last()?.0, path.back(1).map_or(0, |w| w.0));
        Some([[1, 1, 2], [2, 1, 1], [0, 3, 1]][(x + w) % 3])
    }
    fn has_mirror(path: PathView<'_, Site>) -> bool {
        path.last() == Some(Site(1)) && path.back(1).is_some()
    }
    fn probability(path: PathView<'_, Site>, target: Site, dirac: Option<Dirac>) -> f64 {
        let mirror = if Step::has_mirror(path) { 0.5 } else { 0.0 };
        match (Step::table(path), dirac) {
            (Some(_), Some(Dirac::Direction)) => 0.75 * mirror,
            (Some(table), _) => 0.75 * (1.0 - mirror) * table[target.0] as f64 / 4.0,
            (None, _) => 0.0,
        }
    }
}
impl Strategy<Site> for Step {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        path: PathView<'_, Site>,
        uniforms: &mut U,
    ) -> Option<Drawn<Site>> {
        if pick(uniforms.next(), [3, 1]) == 1 {
            return None;
        }
        if Step::has_mirror(path) && pick(uniforms.next(), [2, 2]) == 0 {
            let (site, dirac) = (Site(2 - path.back(1)?.0), Dirac::Direction);
            let value = Step::probability(path, site, Some(dirac));
            return Some(Drawn::atom(site, dirac).visible().with_value(value));
        }
        let site = Site(pick(uniforms.next(), Step::table(path)?));
        Some(Drawn::new(site).visible().with_value(Step::probability(path, site, None)))
    }
    fn pdf(&self, path: PathView<'_, Site>, target: &Site) -> Conditional<f64> {
        let dirac = path.dirac().filter(|dirac| *dirac == Dirac::Direction);
        Conditional { value: Step::probability(path, *target, dirac), dirac }
    }
    fn reads(&self) -> Reads {
        Reads::TWO
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

#[derive(Clone, Copy)]
pub struct Light;
impl Strategy<Site> for Light {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Site>,
        uniforms: &mut U,
    ) -> Option<Drawn<Site>> {
        let site = pick(uniforms.next(), [1, 2, 1]);
        Some(Drawn::new(Site(site)).with_value([0.25, 0.5, 0.25][site]))
    }
    fn pdf(&self, _: PathView<'_, Site>, target: &Site) -> Conditional<f64> {
        Conditional::density([0.25, 0.5, 0.25][target.0])
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
    fn same(&self, _: &Self) -> bool {
        true
    }
}

/// Moves to the next site, rarely to the one after, sometimes nowhere.
#[derive(Clone, Copy)]
pub struct Near {
    pub old: Site,
    /// By what the density is wrong.
    pub lie: f64,
}
impl Near {
    fn density(&self, by: usize) -> f64 {
        [0.0, 0.5 * self.lie, 0.25][by]
    }
}
impl Strategy<Site> for Near {
    fn sample<U: UniformSource<f64> + ?Sized>(
        &self,
        _: PathView<'_, Site>,
        uniforms: &mut U,
    ) -> Option<Drawn<Site>> {
        let by = pick(uniforms.next(), [0, 2, 1]);
        (by < 3).then(|| Drawn::new(Site((self.old.0 + by) % 3)).with_value(self.density(by)))
    }
    fn pdf(&self, _: PathView<'_, Site>, target: &Site) -> Conditional<f64> {
        Conditional::density(self.density((target.0 + 3 - self.old.0) % 3))
    }
    fn reads(&self) -> Reads {
        Reads::NOTHING
    }
}

strategies! {
    #[derive(Clone, Copy)]
    pub enum Ways for Site { Camera(Camera), Step(Step), Light(Light), Near(Near) }
}

pub type Path<'a> = RandomSequence<'a, Site, Ways>;
pub type Sites = Arena<Site, Ways>;
pub type Choosing<'d> = Decisions<'d, f64>;
pub type Proposal<'a> = Option<Draft<'a, Site, Ways>>;
pub type AnyMutation<'m> = &'m dyn Mutation<Site, Ways>;
pub type Stored = Snapshot<Site, Ways>;

/// The target function: zero unless the path begins at the pinhole; mirrors have a coefficient.
pub fn target(path: &Path<'_>) -> f64 {
    let (view, n) = (path.view(), path.len());
    let site = |i: usize| view.vertex(i).map_or(0, |site| site.0);
    if !(2..=4).contains(&n) || !view.carries(0, Dirac::Position) {
        return 0.0;
    }
    let scattering = |m: usize| {
        let (q, x, y) = (site(m - 1), site(m), site(m + 1));
        match view.carries(m, Dirac::Direction) {
            true if x == 1 && y == 2 - q => 2.5,
            true => panic!("a mirror's factor where there is none: {path:?}"),
            false => 1.0 + ((q + 2 * x + 3 * y) % 4) as f64,
        }
    };
    let emission = [1.0, 3.0, 2.0][site(n - 1)];
    (1..n - 1).map(scattering).product::<f64>() * emission * 0.25_f64.powi(n as i32)
}

/// Deletes vertices and grows what is left from both ends, as Veach and Guibas (1997) do.
pub struct Bidirectional;
impl Mutation<Site, Ways> for Bidirectional {
    fn propose<'a>(&self, path: &Path<'a>, decide: &mut Choosing<'_>) -> Proposal<'a> {
        let n = path.len();
        let deleted = [(1, n), (n - 1, n), (1, n - 1), (0, n)];
        let odds = if n > 2 { [1.0; 4] } else { [1.0, 0.0, 2.0, 1.0] };
        let purpose = decide.purpose();
        let is_useful = |i: usize| {
            let (begin, end) = deleted[i];
            purpose.replaces_so_many(end - begin) && purpose.replaces(begin..end)
        };
        let (begin, end) = deleted[decide.weighted_among(4, |i| odds[i], is_useful)?];
        let added = [(1, 0), (0, 1), (1, 1), (0, 2)];
        let odds = if n < 4 { [1.0; 4] } else { [2.0, 1.0, 1.0, 0.0] };
        let (camera, light) = added[decide.weighted(4, |i| odds[i])?];
        let size = begin + camera + light + n - end;
        ((2..=4).contains(&size) && decide.wants(size)).then_some(())?;
        let mut front = path.slice(0..begin).keep();
        let mut back = path.slice(end..).keep().reverse();
        for _ in 0..camera {
            if front.size() == 0 {
                front.append(Camera)
            } else {
                front.append(Step)
            };
        }
        for _ in 0..light {
            if back.size() == 0 {
                back.append(Light)
            } else {
                back.append(Step)
            };
        }
        Some(front.concat(&back.reverse()))
    }
    fn weight(&self, path: &Path<'_>) -> f64 {
        if path.len() > 2 { 1.0 } else { 2.0 }
    }
}

/// Moves the vertex after the pinhole and goes on, at once or after one more step, where the path
/// was.
pub struct Lens {
    pub lie: f64,
}
impl Mutation<Site, Ways> for Lens {
    fn propose<'a>(&self, path: &Path<'a>, decide: &mut Choosing<'_>) -> Proposal<'a> {
        let steps = if path.len() > 2 { decide.weighted(2, |i| [3.0, 1.0][i])? } else { 0 };
        let mut front = path.slice(0..1).keep();
        front.append(Near { old: path.vertex(1)?, lie: self.lie });
        (0..steps).for_each(|_| _ = front.append(Step));
        Some(front.concat(&path.slice(2 + steps..).keep()))
    }
    fn weight(&self, path: &Path<'_>) -> f64 {
        if path.len() > 2 { 1.0 } else { 2.0 }
    }
}

/// Draws the vertex after the pinhole anew, coming back from those after it.
pub struct Backward;
impl Mutation<Site, Ways> for Backward {
    fn propose<'a>(&self, path: &Path<'a>, _: &mut Choosing<'_>) -> Proposal<'a> {
        let mut back = path.slice(2..).keep().reverse();
        Some(path.slice(0..1).keep().concat(&back.append(Step).reverse()))
    }
    fn weight(&self, path: &Path<'_>) -> f64 {
        if path.len() > 2 { 2.0 } else { 0.0 }
    }
}

/// All of them.
pub const ALL: Mutations<'static, Site, Ways> =
    Mutations(&[&Bidirectional, &Lens { lie: 1.0 }, &Backward]);

/// Uniforms in the middle of prescribed quarters, the first quarter where nothing is prescribed.
#[derive(Clone, Default)]
pub struct Script {
    pub quarters: Vec<u8>,
    used: usize,
}
impl UniformSource<f64> for Script {
    fn next(&mut self) -> f64 {
        if self.used == self.quarters.len() {
            self.quarters.push(0);
        }
        self.used += 1;
        (f64::from(self.quarters[self.used - 1]) + 0.5) / 4.0
    }
    fn start(&mut self, _: u32) {}
}

/// Runs an experiment for all combinations of quarters, with their probability.
pub fn for_each_script(mut experiment: impl FnMut(&mut Script, &dyn Fn(&Script) -> f64)) {
    let mut script = Script::default();
    loop {
        script.used = 0;
        experiment(&mut script, &|script| 0.25_f64.powi(script.used as i32));
        script.quarters.truncate(script.used);
        while script.quarters.last() == Some(&3) {
            script.quarters.pop();
        }
        match script.quarters.last_mut() {
            Some(last) => *last += 1,
            None => return,
        }
    }
}

/// A vertex of a path: which one of another path it is, its site, its Dirac factors.
type Trait = (Option<usize>, usize, bool, bool);
/// A path as seen from another.
pub type Pattern = Vec<Trait>;

pub fn seen_from(from: &Path<'_>, to: &Path<'_>) -> Pattern {
    let view = to.view();
    (0..to.len())
        .map(|i| {
            let site = to.vertex(i).map_or(9, |site| site.0);
            let carries = [Dirac::Position, Dirac::Direction].map(|dirac| view.carries(i, dirac));
            (from.position_of(to, i), site, carries[0], carries[1])
        })
        .collect()
}

/// A path as a point of the state space: without regard to which vertices it shares with what.
pub fn state(path: &Path<'_>) -> Pattern {
    let mut pattern = seen_from(path, path);
    pattern.iter_mut().for_each(|vertex| vertex.0 = None);
    pattern
}

/// All states that a mutation leads to from the shortest path, if the target is not zero there.
pub fn reachable(mutation: AnyMutation<'_>) -> BTreeMap<Pattern, Stored> {
    let arena = Sites::new();
    let mut first = arena.sequence();
    first.append(Camera).append(Light).sample(&mut || 0.5);
    let mut known = BTreeMap::from([(state(&first), Snapshot::of(&first))]);
    let mut pending = vec![Snapshot::of(&first)];
    while let Some(snapshot) = pending.pop() {
        for_each_proposal(mutation, &snapshot, |_, to, _| {
            if target(to) > 0.0 && !known.contains_key(&state(to)) {
                known.insert(state(to), Snapshot::of(to));
                pending.push(Snapshot::of(to));
            }
        });
    }
    known
}

/// Calls `visit` with a path, each proposal that can be made of it, and its probability; a proposal
/// can turn up several times.
pub fn for_each_proposal(
    mutation: AnyMutation<'_>,
    from: &Stored,
    mut visit: impl FnMut(&Path<'_>, &Path<'_>, f64),
) {
    let mut arena = Sites::new();
    for_each_script(|script, probability| {
        arena.clear();
        let from = arena.restore(from);
        if let Some(to) = propose(mutation, &from, script) {
            visit(&from, &to, probability(script));
        }
    });
}
