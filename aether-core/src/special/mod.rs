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
//! ```
//! use aether_core::prelude::*;
//!
//! /// The beta distribution.
//! #[sampler(a in 0.5..=100.0, b in 0.5..=100.0)]
//! fn beta(u: [Uniform; 1], a: f64, b: f64) -> f64 {
//!     beta_inc_inv(a, b, u[0])
//! }
//!
//! let beta = beta(2.0, 1.0).expect("both lie in the declared domain");
//! assert!((beta.sample([0.25]).value() - 0.5).abs() < 1e-15);
//! assert!((beta.pdf(&0.25).value() - 0.5).abs() < 1e-15);
//! ```
//!
//! The kernels are written over [`Real`] without branches, on polynomials fitted for this crate
//! (`coefficients.rs`), so that every kind of number gets the same algorithm; those of the beta functions
//! iterate in double precision. The errors stated are
//! the worst found on the values of `tests/all/reference/special.txt`, which sweep the domain
//! logarithmically; `tests/special.rs` measures them again. An ulp is the distance between
//! neighbouring numbers at the result.

mod beta;
mod coefficients;
mod error;
mod gamma;
mod lambert;

use crate::real::Real;
use crate::support::either;

/// A function of one argument, with parameters: what [`Real::special`] applies.
#[doc(hidden)]
pub trait Function {
    /// Its name, for numbers that have kernels of their own.
    const NAME: &'static str;
    /// A bound for its error and for that of its inverse in `f64`, in units in the last place.
    const ULPS: f64;
    /// The value at `x`.
    fn value<R: Real>(parameters: &[R], x: R) -> R;
}

macro_rules! function {
    ($(#[$doc:meta])* $name:ident($($parameter:ident),*; $x:ident) $marker:ident = $kernel:path) => {
        function! { $(#[$doc])* $name($($parameter),*; $x) $marker = $kernel, 4.0 }
    };
    (
        $(#[$doc:meta])*
        $name:ident($($parameter:ident),*; $x:ident) $marker:ident = $kernel:path, $ulps:expr
    ) => {
        $(#[$doc])*
        #[inline]
        pub fn $name<R: Real>($($parameter: R,)* $x: R) -> R {
            struct $marker;
            impl Function for $marker {
                const NAME: &'static str = stringify!($name);
                const ULPS: f64 = $ulps;
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
    /// ln erfc(x), also where erfc is smaller than any number.
    #[doc(hidden)]
    ln_erfc(; x) LnErfc = error::ln_erfc
}
function! {
    /// The inverse of [`ln_erfc`]: erfc⁻¹ of exp(l), NaN beyond ln 2.
    #[doc(hidden)]
    erfc_inv_exp(; l) ErfcInvExp = error::erfc_inv_exp
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
function! {
    /// ln B(a, b) = ln Γ(a) + ln Γ(b) - ln Γ(a + b) for a, b > 0, of parameters: it has no derivative in the
    /// language. For large parameters it keeps the digits that the difference would lose.
    ///
    /// Error: at most 28 ulp in `f64`, 0.6 in `f32`.
    ln_beta(a; b) LnBeta = beta::ln_beta, 28.0
}
function! {
    /// The regularised incomplete beta function I(x; a, b) = ∫₀ˣ tᵃ⁻¹ (1 - t)ᵇ⁻¹ dt / B(a, b), for parameters
    /// a, b > 0 and x in [0, 1]; NaN outside. Accurate where it is small; where it is close to one,
    /// 1 - I(x; a, b) = I(1 - x; b, a) is.
    ///
    /// Error: mostly below 3 ulp in `f64`; at most 540 (at 1e-196, for parameters of a thousand, where x itself
    /// would have to be known that well), 0.6 in `f32`.
    beta_inc(a, b; x) BetaInc = beta::beta_inc, 540.0
}
function! {
    /// The inverse of [`beta_inc`] in x: NaN for p outside [0, 1], 0 where x is too small for a number.
    ///
    /// Error: mostly below 3 ulp in `f64`; at most 240 (for a p of 1e-30 and small a), 0.6 in `f32`.
    beta_inc_inv(a, b; p) BetaIncInv = beta::beta_inc_inv, 540.0
}
function! {
    /// I(1 - y; a, b), where y tells more than 1 - y does.
    #[doc(hidden)]
    beta_inc_rest(a, b; y) BetaIncRest = beta::beta_inc_rest, 540.0
}
function! {
    /// The x with I(x; a, b) = 1 - q, where q tells more than 1 - q does.
    #[doc(hidden)]
    beta_inc_inv_rest(a, b; q) BetaIncInvRest = beta::beta_inc_inv_rest, 540.0
}

/// [`beta_inc`] of numbers that add up to one, by the smaller of them.
#[doc(hidden)]
#[inline]
pub fn beta_tail<R: Real>(a: R, b: R, [x, y]: [R; 2]) -> R {
    either(x.le(y), || beta_inc(a, b, x), || beta_inc_rest(a, b, y))
}

/// [`beta_inc_inv`] of numbers that add up to one, by the smaller of them.
#[doc(hidden)]
#[inline]
pub fn beta_quantile<R: Real>(a: R, b: R, [p, q]: [R; 2]) -> R {
    either(p.le(q), || beta_inc_inv(a, b, p), || beta_inc_inv_rest(a, b, q))
}
