//! Estimates of integrals: the integrand over the density (Aether 2017, section 5.1).

use core::cell::RefCell;
use core::fmt;

use crate::combine::{Combined, Heuristic, WeightedSample};
use crate::path_density::PathDensity;
use crate::point::Point;
use crate::real::{Real, Scalar};
use crate::sampler::{Sample, Sampler};
use crate::sequence::{Arena, KEY, Key, Memo, NONE, PathView, Place, RandomSequence, Unfolded};
use crate::strategy::{Reads, Strategy, Vertex};

mod connections;
mod differences;
mod endings;
mod joints;
mod last;
mod made_pairs;
mod sides;
mod steps;
mod techniques;
mod value;

pub use connections::{Connected, Connections};
pub use differences::Shifts;
pub use endings::{Ending, Endings};
use joints::Carried;
pub(crate) use joints::Joints;
pub use steps::Steps;
pub use techniques::Techniques;
pub use value::Value;

/// The precision of an integrand.
type RealOf<I> = <<I as PathIntegrand>::Vertex as Vertex>::Real;

/// An integrand over paths as a product of factors, one a vertex, so that an estimator can divide
/// factor by factor: the integrand and the density of a long path may each leave the range of a
/// float, their quotients do not.
///
/// All visibility and all scattering is the user's. Where a vertex was found by a ray cast, the view
/// says so ([`PathView::visible`]) and no shadow ray is needed.
pub trait PathIntegrand {
    /// The vertices of the paths.
    type Vertex: Vertex;
    /// What is integrated: a number, a spectrum.
    type Value: Value<<Self::Vertex as Vertex>::Real>;

    /// Everything that the integrand gains when the last vertex of `path` is added to the ones
    /// before: the emission or importance or scattering at the vertex before (towards the new one),
    /// and the geometry term and visibility of the edge between them. At a Dirac factor
    /// ([`PathView::carries`]) its coefficient, stated as the strategies state its probability.
    ///
    /// The path shows the last [`PathIntegrand::reads`] vertices. An integrand is a function of them: it adds
    /// no paths to the arena that they live in.
    fn extend(&self, path: PathView<'_, Self::Vertex>) -> Self::Value;

    /// The factor that closes the path: emission (or importance) of the last vertex towards the one
    /// before. The path shows as many vertices as for [`PathIntegrand::extend`].
    fn end(&self, path: PathView<'_, Self::Vertex>) -> Self::Value;

    /// How many vertices, the new one included, [`PathIntegrand::extend`] depends on; three for
    /// scattering. Factors are remembered by them.
    fn reads(&self) -> usize {
        3
    }
}

/// Something with a point and a density: what a loose estimate is made of.
pub trait Drawing {
    /// The precision.
    type Real: Scalar;
    /// The space.
    type Point: Point<Self::Real>;
    /// The point.
    fn drawn_point(&self) -> Self::Point;
    /// Its density; zero if there is no point.
    fn drawn_density(&self) -> Self::Real;
}

impl<S: Sampler<R>, R: Scalar> Drawing for Sample<S, R> {
    type Real = R;
    type Point = S::Point;
    fn drawn_point(&self) -> S::Point {
        self.value()
    }
    fn drawn_density(&self) -> R {
        self.pdf().value()
    }
}

impl<P: Point<R>, R: Scalar> Drawing for WeightedSample<P, R> {
    type Real = R;
    type Point = P;
    fn drawn_point(&self) -> P {
        self.value
    }
    fn drawn_density(&self) -> R {
        self.pdf
    }
}

/// A Monte Carlo estimator of the integral of an integrand.
///
/// `Estimator::new(|x: &Direction| ...)` estimates from samples, `Estimator::paths(integrand)` from
/// paths. Where the density is zero (no sample) or infinite (a pole, which has no mass), the estimate
/// is zero.
pub struct Estimator<I, F = ()> {
    integrand: I,
    factors: RefCell<F>,
}

impl<I: fmt::Debug, F> fmt::Debug for Estimator<I, F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Estimator").field(&self.integrand).finish()
    }
}

impl<I, F> Estimator<I, F> {
    /// The integrand.
    pub fn integrand(&self) -> &I {
        &self.integrand
    }
}

/// Whether a density is neither zero nor infinite.
#[inline(always)]
fn is_regular<R: Scalar>(p: R) -> bool {
    // Infinity times zero is no number. Compared with infinity, this would become a test of bits.
    p > R::ZERO && p * R::ZERO == R::ZERO
}

/// f / p; zero where the density is none that a sample can have.
#[inline(always)]
fn per<R: Scalar, T: Value<R>>(f: T, p: R) -> T {
    if is_regular(p) { f.over(p) } else { T::zero() }
}

/// The same value times the same scale, where neither it nor a product with a factor of ordinary size leaves the range of numbers.
#[inline]
fn moderate<R: Scalar, T: Value<R>>(value: T, scale: PathDensity<R>) -> (T, PathDensity<R>) {
    let step = R::of((1_u64 << 48) as f64);
    if value.times(R::MIN_POSITIVE * step).is_zero() {
        return (value.times(step), scale * step.recip());
    }
    let is_large = !is_usable(value.times((R::MIN_POSITIVE * step).recip()));
    if is_large { (value.over(step), scale * step) } else { (value, scale) }
}

/// Whether a value is in the range of numbers, and not zero.
#[inline(always)]
fn is_usable<R: Scalar, T: Value<R>>(value: T) -> bool {
    value.times(R::ZERO).is_zero() && !value.is_zero()
}

impl<I> Estimator<I> {
    /// An estimator from samples of a function of a point.
    pub fn new(integrand: I) -> Self {
        Estimator { integrand, factors: RefCell::new(()) }
    }

    /// f / p of one sample, not weighted.
    pub fn of<D: Drawing, T: Value<D::Real>>(&self, sample: &D) -> T
    where
        I: Fn(&D::Point) -> T,
    {
        let p = sample.drawn_density();
        if is_regular(p) { (self.integrand)(&sample.drawn_point()).over(p) } else { T::zero() }
    }

    /// The combined estimate of several techniques: the sum of weight × f / p.
    pub fn sum<P: Point<R>, R: Scalar, T: Value<R>>(
        &self,
        samples: impl IntoIterator<Item = WeightedSample<P, R>>,
    ) -> T
    where
        I: Fn(&P) -> T,
    {
        let estimates = samples.into_iter().map(|sample| self.of(&sample).times(sample.weight));
        estimates.fold(T::zero(), |sum, estimate| sum.plus(estimate))
    }
}

/// What a path contributes to the estimate of several techniques.
#[derive(Clone, Copy, Debug)]
pub struct Contribution<'a, V: Vertex, S, T> {
    /// The path.
    pub path: RandomSequence<'a, V, S>,
    /// The number of its technique in the list of techniques.
    pub technique: usize,
    /// Its share of the combined estimate: weight × f / p.
    pub value: T,
    /// f / p over the number of samples that its technique takes: what it would contribute if there were no
    /// other technique.
    pub alone: T,
}

/// What an [`Estimator`] of paths remembers about the contents of one arena.
#[derive(Clone, Debug)]
pub struct Factors<T> {
    contents: Option<(u64, u64)>,
    /// f / p of the steps up to the end of a run, by its name.
    runs: Vec<Option<T>>,
    /// The same of runs that are the last part of a path, with the factors of the integrand that depend on
    /// nothing before them.
    endings: Vec<Option<T>>,
    /// Factors of the integrand, by the vertices that they depend on.
    memo: Memo<T>,
    /// What pieces of two walks carry.
    carried: [Carried<T>; 2],
}

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
    /// An estimator from paths. It remembers factors of the integrand until the arena is cleared.
    pub fn paths(integrand: I) -> Self {
        let factors = Factors {
            contents: None,
            runs: Vec::new(),
            endings: Vec::new(),
            memo: Memo::new(),
            carried: Default::default(),
        };
        Estimator { integrand, factors: RefCell::new(factors) }
    }

    /// The integrand, to be changed: what is remembered of it is forgotten.
    pub fn integrand_mut(&mut self) -> &mut I {
        self.factors.get_mut().contents = None;
        &mut self.integrand
    }

    /// f / p of one path, not weighted; zero if the path is not complete. Costs one factor if the
    /// path extends one that has been estimated.
    pub fn of<S: Strategy<I::Vertex>>(&self, path: &RandomSequence<'_, I::Vertex, S>) -> I::Value {
        if !path.is_complete() || path.is_empty() {
            return I::Value::zero();
        }
        self.remember(path.arena.contents());
        let tape = &path.arena.tape.unfolded();
        let (place, n) = (path.handle.place, path.len());
        // Mostly a path extends by one vertex a run that has been estimated.
        if let Some((before, name, p)) = tape.last_of_run(place)
            && let Some(value) = self.run(before)
        {
            let value = value.multiply(self.new_factor(tape, place, n - 1));
            let value = per(value, p);
            self.set_run(name, value);
            return if value.is_zero() { value } else { self.ended(tape, place, value) };
        }
        self.joined(path, tape)
    }

    /// The same of a path that is not known to be one run.
    fn joined<S: Strategy<I::Vertex>>(
        &self,
        path: &RandomSequence<'_, I::Vertex, S>,
        tape: &Unfolded<'_, I::Vertex>,
    ) -> I::Value {
        let (arena, place, n) = (path.arena, path.handle.place, path.len());
        let ahead = tape.steps_ahead(place);
        // Where two pieces are joined, what goes on behind the edge may vanish without a shadow ray.
        let behind = (ahead + 1 < n).then(|| self.factor(tape, place, ahead + 1));
        if behind.is_some_and(|factor| factor.is_zero()) {
            return I::Value::zero();
        }
        let mut value = self.ahead(arena, tape, place, ahead);
        if value.is_zero() {
            return value;
        }
        let (mut extended, mut start) = (ahead, ahead);
        if let Some(ending) = self.ending(arena, tape, place, ahead) {
            let own = (n - ahead).min(self.reads() - 1);
            for k in ahead..ahead + own {
                let known = behind.filter(|_| k == ahead + 1);
                value = value.multiply(known.unwrap_or_else(|| self.factor(tape, place, k)));
            }
            value = value.multiply(ending);
            if value.is_zero() {
                return value;
            }
            (extended, start) = (n, n);
        }
        // Step k divides by the density of vertex k, and multiplies with the factor of the edge that
        // it was sampled along: to vertex k + 1 if it came from there.
        for k in start..n {
            let backward = tape.way(place, k).is_backward();
            let edges = if backward { (k + 2).min(n) } else { k + 1 };
            while extended < edges {
                value = value.multiply(self.factor(tape, place, extended));
                extended += 1;
            }
            let p = arena.factor(place, k, place);
            value = per(value, p);
            if value.is_zero() {
                return value;
            }
        }
        self.ended(tape, place, value)
    }

    /// f / p of the first `ahead` steps of a path, which are taken forwards.
    fn ahead<S: Strategy<I::Vertex>>(
        &self,
        arena: &Arena<I::Vertex, S>,
        tape: &Unfolded<'_, I::Vertex>,
        place: Place,
        ahead: usize,
    ) -> I::Value {
        let run = |k: usize| tape.run_name(place, k);
        let known = |k: usize| Some((k + 1, self.run(run(k)?)?));
        let (start, mut value) = (0..ahead).rev().find_map(known).unwrap_or((0, I::Value::one()));
        for k in start..ahead {
            let name = run(k);
            // Of a run that has a name the product is remembered, not its factors.
            let factor = match name {
                Some(_) => self.new_factor(tape, place, k),
                None => self.factor(tape, place, k),
            };
            value = value.multiply(factor);
            let p = arena.factor(place, k, place);
            value = per(value, p);
            if let Some(name) = name {
                self.set_run(name, value);
            }
            if value.is_zero() {
                break;
            }
        }
        value
    }

    /// What all steps from `ahead` on share with other paths that end alike, if they are one run that came from
    /// the other end: one over their densities, and the factors of the edges that see nothing before them. `None`
    /// where that leaves the range of numbers.
    fn ending<S: Strategy<I::Vertex>>(
        &self,
        arena: &Arena<I::Vertex, S>,
        tape: &Unfolded<'_, I::Vertex>,
        place: Place,
        ahead: usize,
    ) -> Option<I::Value> {
        let n = place.len as usize;
        let back = place.range(ahead, n).reverse();
        let len = n - ahead;
        let name = |len: usize| tape.run_name(back, len - 1);
        let usable = |value: I::Value| is_usable(value).then_some(value);
        let whole = if len > 0 { name(len)? } else { return None };
        if let Some(known) = known_at(&self.factors.borrow().endings, whole) {
            return usable(known);
        }
        let known = |len: usize| Some((len, known_at(&self.factors.borrow().endings, name(len)?)?));
        let found = (1..len).rev().find_map(known);
        let (start, mut value) = found.unwrap_or((0, I::Value::one()));
        for len in start + 1..=len {
            // The edge that the new vertex completes: all that its factor reads is there.
            if len >= self.reads() {
                value = value.multiply(self.new_factor(tape, place, n - len + self.reads() - 1));
            }
            let p = arena.factor(place, n - len, place);
            value = per(value, p);
            remember_at(&mut self.factors.borrow_mut().endings, name(len)?, value);
        }
        usable(value)
    }

    /// How many vertices a factor depends on.
    #[inline(always)]
    fn reads(&self) -> usize {
        self.integrand.reads().max(1)
    }

    /// What the integrand is shown of a path.
    #[inline(always)]
    fn shown(&self) -> Reads {
        Reads { vertices: self.reads(), length: false }
    }

    /// What comes along a path, times the factor that closes it.
    #[inline]
    fn ended(&self, tape: &Unfolded<'_, I::Vertex>, place: Place, value: I::Value) -> I::Value {
        value.multiply(self.closing(PathView::of_unfolded(tape, place, self.shown())))
    }

    /// The integrand itself, f, not divided by a density. Zero if the path is not complete. Unlike f / p it leaves the range of
    /// numbers where paths are long, or lengths far from one: see [`Estimator::scaled_integrand_at`].
    pub fn integrand_at<S: Strategy<I::Vertex>>(
        &self,
        path: &RandomSequence<'_, I::Vertex, S>,
    ) -> I::Value {
        let (value, scale) = self.scaled_integrand_at(path);
        if scale == PathDensity::ONE { value } else { value.times(scale.value()) }
    }

    /// The integrand itself as a value of ordinary range and a number that it is to be multiplied by: what a Markov chain is to
    /// be distributed as. Zero if the path is not complete.
    pub fn scaled_integrand_at<S: Strategy<I::Vertex>>(
        &self,
        path: &RandomSequence<'_, I::Vertex, S>,
    ) -> (I::Value, PathDensity<RealOf<I>>) {
        let (mut value, mut scale) = (I::Value::one(), PathDensity::ONE);
        if !path.is_complete() || path.is_empty() {
            return (I::Value::zero(), scale);
        }
        self.remember(path.arena.contents());
        let tape = path.arena.tape.unfolded();
        for k in 0..path.len() {
            value = value.multiply(self.factor(&tape, path.handle.place, k));
            if value.is_zero() {
                return (value, scale);
            }
            (value, scale) = moderate(value, scale);
        }
        let end = PathView::of_unfolded(&tape, path.handle.place, self.shown());
        (value.multiply(self.closing(end)), scale)
    }

    /// The paths with their weighted contributions, weight × f / p. Paths that contribute nothing, those of
    /// techniques that take no samples among them, are left out, and their weights are not computed.
    pub fn each<'a, S, H>(
        &self,
        mut combined: Combined<'a, I::Vertex, S, H>,
    ) -> impl Iterator<Item = Contribution<'a, I::Vertex, S, I::Value>>
    where
        I::Vertex: 'a,
        S: Strategy<I::Vertex> + 'a,
        H: Heuristic<<I::Vertex as Vertex>::Real>,
    {
        core::iter::from_fn(move || {
            while let Some((technique, path)) = combined.next_sample() {
                let estimate = self.of(&path);
                if estimate.is_zero() {
                    continue;
                }
                let samples = combined.samples_of(technique);
                if samples > RealOf::<I>::ZERO {
                    let value = estimate.times(combined.weight_of(technique));
                    let alone = estimate.over(samples);
                    return Some(Contribution { path, technique, value, alone });
                }
            }
            None
        })
    }

    /// The combined estimate of several techniques: the sum of weight × f / p.
    pub fn sum<'a, S, H>(&self, combined: Combined<'a, I::Vertex, S, H>) -> I::Value
    where
        I::Vertex: 'a,
        S: Strategy<I::Vertex> + 'a,
        H: Heuristic<<I::Vertex as Vertex>::Real>,
    {
        self.each(combined).fold(I::Value::zero(), |sum, path| sum.plus(path.value))
    }

    /// Forgets everything if it is about other contents.
    fn remember(&self, contents: (u64, u64)) {
        let mut factors = self.factors.borrow_mut();
        if factors.contents != Some(contents) {
            factors.contents = Some(contents);
            factors.runs.clear();
            factors.endings.clear();
            factors.memo.clear();
            factors.carried.iter_mut().for_each(Carried::clear);
        }
    }

    fn run(&self, name: u32) -> Option<I::Value> {
        known_at(&self.factors.borrow().runs, name)
    }

    fn set_run(&self, name: u32, value: I::Value) {
        remember_at(&mut self.factors.borrow_mut().runs, name, value);
    }

    /// The factor that vertex `k` of a path brings.
    fn factor(&self, tape: &Unfolded<'_, I::Vertex>, path: Place, k: usize) -> I::Value {
        let reads = self.reads();
        if reads > KEY {
            return self.new_factor(tape, path, k);
        }
        let mut key: Key = [NONE; KEY];
        for (back, part) in key.iter_mut().enumerate().take(reads.min(k + 1)) {
            *part = tape.id(path, k - back);
        }
        let known = self.factors.borrow().memo.get(&key);
        known.unwrap_or_else(|| {
            let value = self.new_factor(tape, path, k);
            self.factors.borrow_mut().memo.insert(key, value);
            value
        })
    }

    /// The same, not remembered.
    #[inline]
    fn new_factor(&self, tape: &Unfolded<'_, I::Vertex>, path: Place, k: usize) -> I::Value {
        self.extended(PathView::of_unfolded(tape, path.range(0, k + 1), self.shown()))
    }

    /// The factor that closes a path.
    #[inline(always)]
    fn closing(&self, path: PathView<'_, I::Vertex>) -> I::Value {
        self.integrand.end(path.limited(self.shown()))
    }

    /// The factor that the last vertex of a path brings.
    #[inline(always)]
    fn extended(&self, path: PathView<'_, I::Vertex>) -> I::Value {
        self.integrand.extend(path.limited(self.shown()))
    }
}

#[inline(always)]
fn known_at<T: Copy>(values: &[Option<T>], name: u32) -> Option<T> {
    values.get(name as usize).copied().flatten()
}

#[inline(always)]
fn remember_at<T: Copy>(values: &mut Vec<Option<T>>, name: u32, value: T) {
    let i = name as usize;
    if i >= values.len() {
        values.resize(i + 1, None);
    }
    values[i] = Some(value);
}
