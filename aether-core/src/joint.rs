//! Several points sampled together: tuples of points, with the product of their measures.

use crate::density::Product;
use crate::point::Point;
use crate::real::Real;

/// The most coordinates that the points of a joint sample have together.
const CAPACITY: usize = 24;

/// Coordinates of several points, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct JointCoordinates<R> {
    values: [R; CAPACITY],
    count: usize,
}

impl<R: Real> JointCoordinates<R> {
    fn new() -> Self {
        JointCoordinates { values: [R::ZERO; CAPACITY], count: 0 }
    }

    fn with(mut self, more: &[R]) -> Self {
        for &x in more {
            self.values[self.count] = x;
            self.count += 1;
        }
        self
    }
}

impl<R> AsRef<[R]> for JointCoordinates<R> {
    fn as_ref(&self) -> &[R] {
        &self.values[..self.count]
    }
}

impl<R> AsMut<[R]> for JointCoordinates<R> {
    fn as_mut(&mut self) -> &mut [R] {
        &mut self.values[..self.count]
    }
}

/// Two points; densities are per product of their measures.
impl<R: Real, A: Point<R>, B: Point<R>> Point<R> for (A, B) {
    type Measure = Product<A::Measure, B::Measure>;
    type Coordinates = JointCoordinates<R>;
    const DIMENSION: usize = A::DIMENSION + B::DIMENSION;
    #[inline(always)]
    fn coordinates(&self) -> JointCoordinates<R> {
        JointCoordinates::new()
            .with(self.0.coordinates().as_ref())
            .with(self.1.coordinates().as_ref())
    }
}

macro_rules! more_points {
    ($($($part:ident $i:tt),+; $last:ident $k:tt;)*) => {
        $(/// Several points; densities are per product of their measures.
        impl<R: Real, $($part: Point<R>,)+ $last: Point<R>> Point<R> for ($($part,)+ $last) {
            type Measure = Product<<($($part,)+) as Point<R>>::Measure, $last::Measure>;
            type Coordinates = JointCoordinates<R>;
            const DIMENSION: usize = $($part::DIMENSION +)+ $last::DIMENSION;
            #[inline(always)]
            fn coordinates(&self) -> JointCoordinates<R> {
                JointCoordinates::new()
                    $(.with(self.$i.coordinates().as_ref()))+
                    .with(self.$k.coordinates().as_ref())
            }
        })*
    };
}
more_points! {
    A 0, B 1; C 2;
    A 0, B 1, C 2; D 3;
    A 0, B 1, C 2, D 3; E 4;
    A 0, B 1, C 2, D 3, E 4; F 5;
    A 0, B 1, C 2, D 3, E 4, F 5; G 6;
    A 0, B 1, C 2, D 3, E 4, F 5, G 6; H 7;
}
