//! Samplers and integrators written by hand, as an expert writes them, to measure what the derived ones cost.
//!
//! This and the tests are the only places where densities are written by hand. A twin keeps the contract of
//! what it is compared with: the same values on the same inputs, zero outside of the support, on the back
//! side, and for coordinates that are no finite numbers. The binary `twins` compares instructions and time.

pub mod accuracy;
pub mod bidirectional;
pub mod direction;
pub mod line;
pub mod measure;
pub mod pairs;
pub mod path;
pub mod plane;
pub mod renderers;
pub mod space;

use aether_core::prelude::{Direction, Vec3};

/// A parameter of what is written by hand.
pub trait Parameter {
    /// The next one of a list of numbers, which has enough of them.
    fn next(numbers: &mut impl Iterator<Item = f64>) -> Self;
}

impl Parameter for f64 {
    fn next(numbers: &mut impl Iterator<Item = f64>) -> Self {
        numbers.next().unwrap_or(f64::NAN)
    }
}

impl Parameter for Vec3 {
    fn next(numbers: &mut impl Iterator<Item = f64>) -> Self {
        let [x, y, z] = core::array::from_fn(|_| f64::next(numbers));
        Vec3::new(x, y, z)
    }
}

impl Parameter for Direction {
    fn next(numbers: &mut impl Iterator<Item = f64>) -> Self {
        let Vec3 { x, y, z } = Vec3::next(numbers);
        Direction::new(x, y, z)
    }
}

/// A random variable written by hand.
pub trait ByHand: Copy {
    /// The uniforms that a sample consumes.
    type Uniforms: Copy;
    /// The space of the samples.
    type Point: Copy;
    /// The one whose parameters are these numbers, those of the derived sampler in their order.
    fn with(numbers: &[f64]) -> Self;
    /// The point of some uniforms.
    fn sample(&self, u: Self::Uniforms) -> Self::Point;
    /// The density at any point, in the measure of the space.
    fn pdf(&self, x: &Self::Point) -> f64;
    /// The point of some uniforms and its density, which share what they can.
    fn draw(&self, u: Self::Uniforms) -> (Self::Point, f64);
}

/// Defines random variables by their three functions; parameters are in scope under their names.
macro_rules! by_hand {
    ($(
        $(#[$doc:meta])*
        $name:ident($($p:ident: $t:ty),*): [$n:literal] => $point:ty;
        sample($u:ident) $sample:block
        pdf($x:ident) $pdf:block
        draw($v:ident) $draw:block
    )*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug)]
            #[allow(missing_docs)]
            pub struct $name { $(pub $p: $t),* }

            impl $crate::twins::ByHand for $name {
                type Uniforms = [f64; $n];
                type Point = $point;
                fn with(numbers: &[f64]) -> Self {
                    #[allow(unused)]
                    let numbers = &mut numbers.iter().copied();
                    $name { $($p: <$t as $crate::twins::Parameter>::next(numbers)),* }
                }
                #[inline(always)]
                fn sample(&self, $u: [f64; $n]) -> $point {
                    #[allow(unused_variables)]
                    let $name { $($p),* } = *self;
                    $sample
                }
                #[inline(always)]
                fn pdf(&self, $x: &$point) -> f64 {
                    #[allow(unused_variables)]
                    let $name { $($p),* } = *self;
                    $pdf
                }
                #[inline(always)]
                fn draw(&self, $v: [f64; $n]) -> ($point, f64) {
                    #[allow(unused_variables)]
                    let $name { $($p),* } = *self;
                    $draw
                }
            }
        )*
    };
}
pub(crate) use by_hand;

/// A quotient of powers of uniforms u / x, which is `at_zero` where both are zero: there it has only a limit.
#[inline(always)]
pub(crate) fn quotient(u: f64, x: f64, at_zero: impl FnOnce() -> f64) -> f64 {
    if x > 0.0 { u / x } else { at_zero() }
}

/// Whether a point has finite coordinates: of any other number, the difference from itself is no zero.
#[inline(always)]
#[allow(clippy::eq_op)]
pub(crate) fn finite<const N: usize>(x: [f64; N]) -> bool {
    x.iter().map(|x| x - x).sum::<f64>() == 0.0
}
