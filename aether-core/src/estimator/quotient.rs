//! f / p of one path, factor by factor, and f by itself.

use crate::estimator::factors::{known_at, remember_at};
use crate::estimator::range::{is_usable, moderate, per};
use crate::estimator::{Estimator, Factors, PathIntegrand, RealOf, Value};
use crate::path_density::PathDensity;
use crate::sequence::{Arena, PathView, Place, RandomSequence, Unfolded};
use crate::strategy::Strategy;

impl<I: PathIntegrand> Estimator<I, Factors<I::Value>> {
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

    /// What comes along a path, times the factor that closes it.
    #[inline]
    pub(super) fn ended(
        &self,
        tape: &Unfolded<'_, I::Vertex>,
        place: Place,
        value: I::Value,
    ) -> I::Value {
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
        let tape = path.arena.tape.unfolded();
        for k in 0..path.len() {
            // Chains ask once about a path: to remember factors would cost more than it saves.
            value = value.multiply(self.new_factor(&tape, path.handle.place, k));
            if value.is_zero() {
                return (value, scale);
            }
            (value, scale) = moderate(value, scale);
        }
        let end = PathView::of_unfolded(&tape, path.handle.place, self.shown());
        (value.multiply(self.closing(end)), scale)
    }
}
