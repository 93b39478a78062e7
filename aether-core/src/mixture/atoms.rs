//! The parts of a mixture of samplers with atoms.

use super::{Components, Mixture};
use crate::density::Density;
use crate::discrete::Inversion;
use crate::mixed::{Mixed, Parts};
use crate::point::Point;
use crate::real::Scalar;
use crate::sampler::{Errors, PdfOf, Sampler};

/// Samplers with atoms, numbered from zero. What has the same number is the same point in all of them.
pub trait ComponentsWithAtoms<R: Scalar>: Components<R, Point = Mixed<Self::Place>> {
    /// The space without its atoms.
    type Place: Point<R>;
    /// The numbers of the atoms that there may be in any of them, in order.
    const ATOMS: &'static [usize];
    /// Where an atom lies by one of them; `None` if that has none of this number.
    fn place(&self, index: usize, number: usize) -> Option<Self::Place>;
}

/// The continuous part of a mixture of samplers with atoms: their continuous parts, each with the probability of its
/// component.
#[derive(Clone, Copy, Debug)]
pub struct Continuous<C, D>(Mixture<C, D>);

impl<R, C, D> Sampler<R> for Continuous<C, D>
where
    R: Scalar,
    C: ComponentsWithAtoms<R>,
    D: Inversion<R> + Copy,
{
    type Uniforms = C::Uniforms;
    type Point = C::Place;

    fn forward(&self, u: C::Uniforms) -> (C::Place, bool) {
        let (x, valid) = self.0.forward(u);
        (x.point(), valid && x.atom().is_none())
    }

    fn pdf(&self, x: &C::Place) -> PdfOf<Self, R> {
        Density::new(self.0.pdf(&Mixed::Continuous(*x)).value())
    }

    fn pdf_as_is(&self, x: &C::Place) -> PdfOf<Self, R> {
        Density::new(self.0.pdf_as_is(&Mixed::Continuous(*x)).value())
    }

    fn pdf_near(&self, x: &C::Place, errors: Errors<'_, C::Place, R>) -> PdfOf<Self, R> {
        Density::new(self.0.pdf_near(&Mixed::Continuous(*x), errors).value())
    }

    fn log_pdf(&self, x: &C::Place) -> R {
        self.0.log_pdf(&Mixed::Continuous(*x))
    }

    fn pdf_of_uniforms(&self, u: C::Uniforms) -> PdfOf<Self, R> {
        self.forward_with_pdf(u).2
    }

    fn forward_with_pdf(&self, u: C::Uniforms) -> (C::Place, bool, PdfOf<Self, R>) {
        let (x, valid, p) = self.0.forward_with_pdf(u);
        let atom = x.atom().is_some();
        let density = Density::new(if atom { R::ZERO } else { p.value() });
        (x.point(), valid && !atom, density)
    }

    fn preimages(&self, x: &C::Place, visit: impl FnMut(C::Uniforms, bool)) {
        self.0.preimages(&Mixed::Continuous(*x), visit);
    }
}

impl<R, C, D> Parts<R> for Mixture<C, D>
where
    R: Scalar,
    C: ComponentsWithAtoms<R>,
    D: Inversion<R> + Copy,
{
    type Place = C::Place;
    type Continuous = Continuous<C, D>;
    const ATOMS: &'static [usize] = C::ATOMS;

    fn continuous(&self) -> Continuous<C, D> {
        Continuous(*self)
    }

    fn atom(&self, u: C::Uniforms) -> Option<(usize, C::Place)> {
        match self.forward(u) {
            (Mixed::Atom(number, place), true) => Some((number, place)),
            _ => None,
        }
    }

    fn place(&self, number: usize) -> Option<C::Place> {
        self.possible().find_map(|(i, _)| self.components.place(i, number))
    }

    fn probability(&self, number: usize) -> R {
        let at = |place| self.pdf_as_is(&Mixed::Atom(number, place)).value();
        self.place(number).map_or(R::ZERO, at)
    }

    fn log_probability(&self, number: usize) -> R {
        let at = |place| self.log_pdf(&Mixed::Atom(number, place));
        self.place(number).map_or(-R::INFINITY, at)
    }
}

/// Atoms of different numbers that a tuple may have.
const MOST: usize = 64;

/// The numbers in several lists, in order and each once, and how many they are.
const fn merged(lists: &[&[usize]]) -> ([usize; MOST], usize) {
    let (mut all, mut count, mut list) = ([0; MOST], 0, 0);
    while list < lists.len() {
        let mut next = 0;
        while next < lists[list].len() {
            let number = lists[list][next];
            let mut at = 0;
            while at < count && all[at] < number {
                at += 1;
            }
            if at == count || all[at] != number {
                assert!(count < MOST, "a mixture of samplers with more than 64 different atoms");
                let mut moved = count;
                while moved > at {
                    all[moved] = all[moved - 1];
                    moved -= 1;
                }
                all[at] = number;
                count += 1;
            }
            next += 1;
        }
        list += 1;
    }
    (all, count)
}

macro_rules! indexed {
    ($([$($length:tt)*] $components:ty;)*) => {
        $(impl<R: Scalar, S: Parts<R>, $($length)*> ComponentsWithAtoms<R> for $components {
            type Place = S::Place;
            const ATOMS: &'static [usize] = S::ATOMS;
            fn place(&self, index: usize, number: usize) -> Option<S::Place> {
                self[index].place(number)
            }
        })*
    };
}

indexed! {
    [] &[S];
    [const N: usize] [S; N];
}

/// The list of a merged list.
struct List<R, C>(core::marker::PhantomData<(R, C)>);

macro_rules! tuples {
    ($($first:ident $(, $t:ident $i:tt)*;)*) => {
        $(impl<R, $first, $($t),*> List<R, ($first, $($t),*)>
        where
            R: Scalar,
            $first: Parts<R>,
            $($t: Parts<R>,)*
        {
            const MERGED: &'static ([usize; MOST], usize) =
                &merged(&[$first::ATOMS, $($t::ATOMS),*]);
        }

        impl<R, $first, $($t),*> ComponentsWithAtoms<R> for ($first, $($t),*)
        where
            R: Scalar,
            $first: Parts<R>,
            $($t: Parts<R, Uniforms = $first::Uniforms, Place = $first::Place>,)*
        {
            type Place = $first::Place;
            const ATOMS: &'static [usize] =
                List::<R, Self>::MERGED.0.split_at(List::<R, Self>::MERGED.1).0;
            fn place(&self, index: usize, number: usize) -> Option<Self::Place> {
                match index {
                    0 => self.0.place(number),
                    $($i => self.$i.place(number),)*
                    _ => None,
                }
            }
        })*
    };
}
tuples! {
    A, B 1;
    A, B 1, C 2;
    A, B 1, C 2, D 3;
    A, B 1, C 2, D 3, E 4;
    A, B 1, C 2, D 3, E 4, F 5;
    A, B 1, C 2, D 3, E 4, F 5, G 6;
    A, B 1, C 2, D 3, E 4, F 5, G 6, H 7;
}

#[cfg(test)]
mod tests {
    use super::merged;

    #[test]
    fn lists_of_atoms_are_merged_in_order() {
        let (all, count) = merged(&[&[0, 7], &[], &[3, 7, 9], &[0]]);
        assert_eq!(all[..count], [0, 3, 7, 9]);
    }
}
