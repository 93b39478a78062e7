//! Special functions, for samplers and for plain Rust.
//!
//! They are free functions, because `f64` has inherent methods of the same names that are not
//! stable. All of them take `f32`, `f64` and [`Bounded`](crate::bounded::Bounded); a sampler may call
//! them like the methods of a number, and the compiler knows their derivatives and inverses.
//!
//! ```
//! use aether_core::prelude::*;
//!
//! /// The normal distribution with mean m and standard deviation s.
//! #[sampler(s in 1e-3..)]
//! fn normal(u: [Uniform; 1], m: f64, s: f64) -> f64 {
//!     m + s * normal_quantile(u[0])
//! }
//!
//! let normal = normal(1.0, 2.0).expect("2 lies in the declared domain");
//! assert!((normal.pdf(&1.0).value() - 0.5 * (0.5 / PI).sqrt()).abs() < 1e-15);
//! ```
//!
//! Elsewhere in a sampler, numbers have the methods of the standard library: `sqrt cbrt recip exp
//! exp2 exp_m1 ln ln_1p log log2 log10 sin cos sin_cos tan asin acos atan atan2 to_radians to_degrees
//! sinh cosh tanh asinh acosh atanh abs powi powf hypot mul_add`.
//!
//! The kernels are written over [`Real`] without branches, on polynomials fitted for this crate
//! (`coefficients.rs`), so that every kind of number gets the same algorithm. The errors stated are
//! the worst found on the values of `tests/reference/special.txt`, which sweep the domain
//! logarithmically; `tests/special.rs` measures them again. An ulp is the distance between
//! neighbouring numbers at the result.

mod coefficients;
mod error;
mod gamma;
mod lambert;

use crate::real::Real;

/// A function of one argument, with parameters: what [`Real::special`] applies.
#[doc(hidden)]
pub trait Function {
    /// The value at `x`.
    fn value<R: Real>(parameters: &[R], x: R) -> R;
}

macro_rules! function {
    ($(#[$doc:meta])* $name:ident($($parameter:ident),*; $x:ident) $marker:ident = $kernel:path) => {
        $(#[$doc])*
        #[inline]
        pub fn $name<R: Real>($($parameter: R,)* $x: R) -> R {
            struct $marker;
            impl Function for $marker {
                #[inline(always)]
                fn value<R: Real>(parameters: &[R], x: R) -> R {
                    let [$($parameter),*] = *parameters else { return x };
                    $kernel($($parameter,)* x)
                }
            }
            R::special::<$marker>(&[$($parameter),*], $x)
        }
    };
}

function! {
    /// The error function 2/√π ∫₀ˣ exp(-t²) dt.
    ///
    /// Error: at most 1.8 ulp in `f64`, 1.8 in `f32`.
    erf(; x) Erf = error::erf
}
function! {
    /// 1 - erf(x), accurate where it is small.
    ///
    /// Error: at most 4.2 ulp in `f64`, 5.1 in `f32`.
    erfc(; x) Erfc = error::erfc
}
function! {
    /// The inverse of [`erf`]: infinite at ±1, NaN beyond.
    ///
    /// Error: at most 1.4 ulp in `f64`, 1.4 in `f32`.
    erf_inv(; x) ErfInv = error::erf_inv
}
function! {
    /// The inverse of [`erfc`]: infinite at 0 and 2, NaN outside, accurate for the smallest `y`.
    ///
    /// Error: at most 2.6 ulp in `f64`, 2.8 in `f32`.
    erfc_inv(; y) ErfcInv = error::erfc_inv
}
function! {
    /// The probability that a normal variable of mean 0 and variance 1 is at most `x`.
    ///
    /// Error: at most 5.1 ulp in `f64`, 5.0 in `f32`.
    normal_cdf(; x) NormalCdf = error::normal_cdf
}
function! {
    /// The inverse of [`normal_cdf`], -√2 erfc⁻¹(2u): -∞ at 0, ∞ at 1, NaN outside, accurate for
    /// the smallest `u`.
    ///
    /// Error: at most 4.0 ulp in `f64`, 2.5 in `f32`.
    normal_quantile(; u) NormalQuantile = error::normal_quantile
}
function! {
    /// The principal branch of Lambert's W, the solution w >= -1 of w exp(w) = x; NaN below -1/e.
    ///
    /// Error: at most 2.4 ulp in `f64`, 2.3 in `f32`.
    lambert_w(; x) LambertW = lambert::lambert_w
}
function! {
    /// ln Γ(x) for x > 0, of parameters: it has no derivative in the language.
    ///
    /// Error: at most 1.5 ulp in `f64`, 0.6 in `f32`.
    ln_gamma(; x) LnGamma = gamma::ln_gamma
}
