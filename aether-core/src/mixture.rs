//! Mixtures of samplers: one-sample multiple importance sampling.

mod atoms;

pub use atoms::{ComponentsWithAtoms, Continuous};

use crate::density::Density;
use crate::discrete::{Inversion, WeightError};
use crate::point::Point;
use crate::real::Scalar;
use crate::sampler::{Errors, PdfOf, Sampler, Uniforms};
use crate::support::add_logs;

/// Samplers of one space, numbered from zero: a tuple of different ones, an array or a slice of equal
/// ones. They all take the same number of uniforms.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a family of samplers of one space",
    label = "a mixture needs samplers with the same space, uniforms and precision",
    note = "pass a tuple of two to eight samplers, or an array or a slice of samplers of one type"
)]
pub trait Components<R: Scalar>: Copy {
    /// The uniforms that each of them takes.
    type Uniforms: Uniforms<R>;
    /// The space of their samples.
    type Point: Point<R>;
    /// How many there are.
    fn count(&self) -> usize;
    /// [`Sampler::forward`] of one of them.
    fn forward(&self, index: usize, u: Self::Uniforms) -> (Self::Point, bool);
    /// [`Sampler::pdf`] of one of them.
    fn pdf(&self, index: usize, x: &Self::Point) -> R;
    /// [`Sampler::pdf_as_is`] of one of them.
    fn pdf_as_is(&self, index: usize, x: &Self::Point) -> R;
    /// [`Sampler::pdf_near`] of one of them.
    fn pdf_near(&self, index: usize, x: &Self::Point, errors: Errors<'_, Self::Point, R>) -> R;
    /// [`Sampler::log_pdf`] of one of them.
    fn log_pdf(&self, index: usize, x: &Self::Point) -> R;
    /// [`Sampler::forward_with_pdf`] of one of them.
    fn forward_with_pdf(&self, index: usize, u: Self::Uniforms) -> (Self::Point, bool, R);
    /// [`Sampler::preimages`] of one of them.
    fn preimages(&self, index: usize, x: &Self::Point, visit: impl FnMut(Self::Uniforms, bool));
}

/// A random variable that is one of several, by a discrete choice (the `CompositeRandomVariable` of
/// Aether 2017). Made by [`mixture`].
///
/// Its density is the sum of theirs, weighted with the probabilities, whichever made the sample.
/// Components of probability zero are not evaluated. The choice takes no uniform of its own: what it
/// leaves of the first one goes to the component, so that a sample takes as many uniforms as its space
/// has dimensions, and can be inverted.
#[derive(Clone, Copy, Debug)]
pub struct Mixture<C, D> {
    components: C,
    choice: D,
}

/// The mixture of `components` in which `choice` picks the index of one: a
/// [`coin`](crate::discrete::coin) (false picks the first), [`shares`](crate::discrete::shares), or a
/// reference to a [`Cdf`](crate::discrete::Cdf).
///
/// ```
/// use aether_core::discrete::shares;
/// use aether_core::mixture::mixture;
/// use aether_core::prelude::*;
///
/// /// Uniform on [a, b).
/// #[sampler]
/// fn interval(u: [Uniform; 1], a: f64, b: f64) -> f64 {
///     a + (b - a) * u[0]
/// }
///
/// /// Density 2 x on [0, 1).
/// #[sampler]
/// fn ramp(u: [Uniform; 1]) -> f64 {
///     u[0].sqrt()
/// }
///
/// let both = mixture((interval(0.0, 2.0), ramp()), shares([3.0, 1.0]))?;
/// let x = both.sample([0.9]);
/// assert!((x.value() - 0.6f64.sqrt()).abs() < 1e-15);
/// assert!((both.pdf(&x).value() - (0.75 * 0.5 + 0.25 * 2.0 * x.value())).abs() < 1e-15);
/// # Ok::<(), aether_core::discrete::WeightError>(())
/// ```
///
/// # Errors
/// [`WeightError::Length`] if there are not as many components as outcomes of the choice.
pub fn mixture<R: Scalar, C: Components<R>, D: Inversion<R> + Copy>(
    components: C,
    choice: D,
) -> Result<Mixture<C, D>, WeightError> {
    let (items, weights) = (components.count(), choice.len());
    if items != weights {
        return Err(WeightError::Length { items, weights });
    }
    Ok(Mixture { components, choice })
}

/// `u` with another first uniform.
fn with_first<R: Scalar, U: Uniforms<R>>(u: U, first: R) -> U {
    U::from_fn(|k| if k == 0 { first } else { u.as_ref()[k] })
}

impl<C, D> Mixture<C, D> {
    /// Which component the uniforms `u` pick, its probability, and the uniforms left for it.
    fn pick<R: Scalar>(&self, u: C::Uniforms) -> (usize, R, C::Uniforms)
    where
        C: Components<R>,
        D: Inversion<R>,
    {
        const { assert!(C::Uniforms::COUNT > 0, "a component takes no uniform to be picked by") };
        let (picked, rest) = self.choice.sample_reuse(u.as_ref()[0]);
        (picked.index, picked.probability, with_first(u, rest))
    }

    /// The components that may be picked, and their probabilities.
    fn possible<R: Scalar>(&self) -> impl Iterator<Item = (usize, R)>
    where
        C: Components<R>,
        D: Inversion<R>,
    {
        let probability = |i: usize| self.choice.get(i).map_or(R::ZERO, |c| c.probability);
        (0..self.components.count()).map(move |i| (i, probability(i))).filter(|(_, p)| *p > R::ZERO)
    }

    /// The largest density by one component. Of a point that has only by its rounding a density, it is not known that
    /// several components have made it.
    fn largest<R: Scalar, M>(&self, density: impl Fn(usize) -> R) -> Density<M, R>
    where
        C: Components<R>,
        D: Inversion<R>,
    {
        Density::new(self.possible().fold(R::ZERO, |most, (i, p)| most.max(p * density(i))))
    }
}

impl<R: Scalar, C: Components<R>, D: Inversion<R> + Copy> Sampler<R> for Mixture<C, D> {
    type Uniforms = C::Uniforms;
    type Point = C::Point;

    fn forward(&self, u: C::Uniforms) -> (C::Point, bool) {
        let (index, _, rest) = self.pick(u);
        self.components.forward(index, rest)
    }

    fn pdf(&self, x: &C::Point) -> PdfOf<Self, R> {
        let p = self.pdf_as_is(x);
        if p.value() > R::ZERO { p } else { self.largest(|i| self.components.pdf(i, x)) }
    }

    fn pdf_as_is(&self, x: &C::Point) -> PdfOf<Self, R> {
        Density::new(self.possible().map(|(i, p)| p * self.components.pdf_as_is(i, x)).sum())
    }

    fn pdf_near(&self, x: &C::Point, errors: Errors<'_, C::Point, R>) -> PdfOf<Self, R> {
        self.largest(|i| self.components.pdf_near(i, x, errors))
    }

    fn log_pdf(&self, x: &C::Point) -> R {
        let logs = self.possible().map(|(i, p)| p.ln() + self.components.log_pdf(i, x));
        logs.fold(-R::INFINITY, add_logs)
    }

    fn pdf_of_uniforms(&self, u: C::Uniforms) -> PdfOf<Self, R> {
        self.forward_with_pdf(u).2
    }

    fn forward_with_pdf(&self, u: C::Uniforms) -> (C::Point, bool, PdfOf<Self, R>) {
        let (picked, p, rest) = self.pick(u);
        let (x, valid, own) = self.components.forward_with_pdf(picked, rest);
        if !valid {
            return (x, false, Density::ZERO);
        }
        let others = self.possible().filter(|(i, _)| *i != picked);
        let others: R = others.map(|(i, p)| p * self.components.pdf_as_is(i, &x)).sum();
        (x, true, Density::new(p * own + others))
    }

    fn preimages(&self, x: &C::Point, mut visit: impl FnMut(C::Uniforms, bool)) {
        for (i, _) in self.possible() {
            self.components.preimages(i, x, |u, valid| {
                if let Some(first) = self.choice.uniform(i, u.as_ref()[0]) {
                    visit(with_first(u, first), valid);
                }
            });
        }
    }
}

/// A point with its density as a number.
#[inline(always)]
fn with_value<P, M, R: Scalar>((x, valid, p): (P, bool, Density<M, R>)) -> (P, bool, R) {
    (x, valid, p.value())
}

macro_rules! indexed {
    ($([$($length:tt)*] $components:ty;)*) => {
        $(impl<R: Scalar, S: Sampler<R>, $($length)*> Components<R> for $components {
            type Uniforms = S::Uniforms;
            type Point = S::Point;
            fn count(&self) -> usize {
                self.len()
            }
            fn forward(&self, index: usize, u: S::Uniforms) -> (S::Point, bool) {
                self[index].forward(u)
            }
            fn pdf(&self, index: usize, x: &S::Point) -> R {
                self[index].pdf(x).value()
            }
            fn pdf_as_is(&self, index: usize, x: &S::Point) -> R {
                self[index].pdf_as_is(x).value()
            }
            fn pdf_near(&self, index: usize, x: &S::Point, errors: Errors<'_, S::Point, R>) -> R {
                self[index].pdf_near(x, errors).value()
            }
            fn log_pdf(&self, index: usize, x: &S::Point) -> R {
                self[index].log_pdf(x)
            }
            fn forward_with_pdf(&self, index: usize, u: S::Uniforms) -> (S::Point, bool, R) {
                with_value(self[index].forward_with_pdf(u))
            }
            fn preimages(&self, index: usize, x: &S::Point, visit: impl FnMut(S::Uniforms, bool)) {
                self[index].preimages(x, visit);
            }
        })*
    };
}

indexed! {
    [] &[S];
    [const N: usize] [S; N];
}

macro_rules! tuples {
    ($($n:literal: $first:ident $last:ident $l:tt $(, $t:ident $i:tt)*;)*) => {
        $(impl<R, $first, $($t,)* $last> Components<R> for ($first, $($t,)* $last)
        where
            R: Scalar,
            $first: Sampler<R>,
            $($t: Sampler<R, Uniforms = $first::Uniforms, Point = $first::Point>,)*
            $last: Sampler<R, Uniforms = $first::Uniforms, Point = $first::Point>,
        {
            type Uniforms = $first::Uniforms;
            type Point = $first::Point;
            fn count(&self) -> usize {
                $n
            }
            fn forward(&self, index: usize, u: Self::Uniforms) -> (Self::Point, bool) {
                match index {
                    0 => self.0.forward(u),
                    $($i => self.$i.forward(u),)*
                    _ => self.$l.forward(u),
                }
            }
            fn pdf(&self, index: usize, x: &Self::Point) -> R {
                match index {
                    0 => self.0.pdf(x).value(),
                    $($i => self.$i.pdf(x).value(),)*
                    _ => self.$l.pdf(x).value(),
                }
            }
            fn pdf_as_is(&self, index: usize, x: &Self::Point) -> R {
                match index {
                    0 => self.0.pdf_as_is(x).value(),
                    $($i => self.$i.pdf_as_is(x).value(),)*
                    _ => self.$l.pdf_as_is(x).value(),
                }
            }
            fn pdf_near(
                &self,
                index: usize,
                x: &Self::Point,
                errors: Errors<'_, Self::Point, R>,
            ) -> R {
                match index {
                    0 => self.0.pdf_near(x, errors).value(),
                    $($i => self.$i.pdf_near(x, errors).value(),)*
                    _ => self.$l.pdf_near(x, errors).value(),
                }
            }
            fn log_pdf(&self, index: usize, x: &Self::Point) -> R {
                match index {
                    0 => self.0.log_pdf(x),
                    $($i => self.$i.log_pdf(x),)*
                    _ => self.$l.log_pdf(x),
                }
            }
            fn forward_with_pdf(
                &self,
                index: usize,
                u: Self::Uniforms,
            ) -> (Self::Point, bool, R) {
                match index {
                    0 => with_value(self.0.forward_with_pdf(u)),
                    $($i => with_value(self.$i.forward_with_pdf(u)),)*
                    _ => with_value(self.$l.forward_with_pdf(u)),
                }
            }
            fn preimages(
                &self,
                index: usize,
                x: &Self::Point,
                visit: impl FnMut(Self::Uniforms, bool),
            ) {
                match index {
                    0 => self.0.preimages(x, visit),
                    $($i => self.$i.preimages(x, visit),)*
                    _ => self.$l.preimages(x, visit),
                }
            }
        })*
    };
}
tuples! {
    2: A B 1;
    3: A C 2, B 1;
    4: A D 3, B 1, C 2;
    5: A E 4, B 1, C 2, D 3;
    6: A F 5, B 1, C 2, D 3, E 4;
    7: A G 6, B 1, C 2, D 3, E 4, F 5;
    8: A H 7, B 1, C 2, D 3, E 4, F 5, G 6;
}
