//! Samplers and maps written right by hand.

use core::f64::consts::{PI, TAU};

use crate::density::Density;
use crate::map::Map;
use crate::point::{Direction, Embedded, Point, Surface, SurfaceId, SurfacePoint};
use crate::real::Scalar;
use crate::sampler::{PdfOf, Sampler};
use crate::vec::{Vec2, Vec3};

/// A sampler put together by hand.
#[derive(Clone, Copy)]
pub(super) struct Hand<const N: usize, P> {
    pub(super) forward: fn([f64; N]) -> P,
    /// Where there is a sample at all.
    pub(super) defined: fn([f64; N]) -> bool,
    pub(super) pdf: fn(&P) -> f64,
    /// All candidates; those outside the unit cube are dropped.
    pub(super) invert: fn(&P) -> [[f64; N]; 2],
    /// What `sample.pdf()` is multiplied with.
    pub(super) own_factor: f64,
}

pub(super) const NONE: f64 = -1.0;

impl<const N: usize, P: Point<f64>> Sampler<f64> for Hand<N, P> {
    type Uniforms = [f64; N];
    type Point = P;
    fn forward(&self, u: [f64; N]) -> (P, bool) {
        ((self.forward)(u), (self.defined)(u))
    }
    fn pdf(&self, x: &P) -> PdfOf<Self, f64> {
        Density::new((self.pdf)(x))
    }
    fn pdf_of_uniforms(&self, u: [f64; N]) -> PdfOf<Self, f64> {
        Density::new((self.pdf)(&(self.forward)(u)) * self.own_factor)
    }
    fn preimages(&self, x: &P, mut visit: impl FnMut([f64; N], bool)) {
        for u in (self.invert)(x) {
            let u = u.map(|u| if u < 1.0 + 1e-15 { u.min(1.0_f64.next_down()) } else { u });
            visit(u, finite(x) && u.iter().all(|u| (0.0..1.0).contains(u)));
        }
    }
}

pub(super) const fn hand<const N: usize, P>(
    forward: fn([f64; N]) -> P,
    invert: fn(&P) -> [[f64; N]; 2],
    pdf: fn(&P) -> f64,
) -> Hand<N, P> {
    Hand { forward, defined: |_| true, pdf, invert, own_factor: 1.0 }
}

/// The fraction of a turn that leads to (x, y).
pub(super) fn turn(x: f64, y: f64) -> f64 {
    let t = y.atan2(x) / TAU;
    if t < 0.0 { (t + 1.0).min(1.0_f64.next_down()) } else { t }
}

pub(super) fn finite(x: &impl Point<f64>) -> bool {
    x.coordinates().as_ref().iter().all(|c| c.is_finite())
}

/// The value inside a domain, zero elsewhere and for NaN.
pub(super) fn inside(domain: bool, value: f64) -> f64 {
    if domain { value } else { 0.0 }
}

pub(super) fn affine() -> Hand<1, f64> {
    hand(
        |[u]| 5.0 * u - 2.0,
        |x| [[(x + 2.0) / 5.0], [NONE]],
        |x| inside((-2.0..3.0).contains(x), 0.2),
    )
}

pub(super) fn exponential() -> Hand<1, f64> {
    hand(
        |[u]| -(-u).ln_1p(),
        |x| [[-(-x).exp_m1()], [NONE]],
        |x| inside(*x >= 0.0 && x.is_finite(), (-x).exp()),
    )
}

pub(super) fn cauchy() -> Hand<1, f64> {
    hand(
        |[u]| (PI * (u - 0.5)).tan(),
        |x| [[if x.is_finite() { x.atan() / PI + 0.5 } else { NONE }], [NONE]],
        |x| inside(x.is_finite(), 1.0 / (PI * (1.0 + x * x))),
    )
}

/// A pole of the density at zero.
pub(super) fn square() -> Hand<1, f64> {
    hand(|[u]| u * u, |x| [[x.sqrt()], [NONE]], |x| inside((0.0..1.0).contains(x), 0.5 / x.sqrt()))
}

pub(super) fn fold() -> Hand<1, f64> {
    hand(
        |[u]| (2.0 * u - 1.0) * (2.0 * u - 1.0),
        |x| {
            let (a, b) = (0.5 + 0.5 * x.sqrt(), 0.5 - 0.5 * x.sqrt());
            // At the fold the two are one.
            [[a], [if a == b { NONE } else { b }]]
        },
        |x| inside((0.0..=1.0).contains(x), 0.5 / x.sqrt()),
    )
}

pub(super) fn disk() -> Hand<2, Vec2> {
    hand(
        |[a, b]| Vec2::new(a.sqrt() * (TAU * b).cos(), a.sqrt() * (TAU * b).sin()),
        |p| [[p.length_squared(), turn(p.x, p.y)], [NONE; 2]],
        |p| inside(p.length_squared() <= 1.0, 1.0 / PI),
    )
}

pub(super) fn ball() -> Hand<3, Vec3> {
    hand(
        |[a, b, c]| {
            let (r, z) = (a.cbrt(), 1.0 - 2.0 * b);
            let s = 2.0 * (b * (1.0 - b)).sqrt();
            Vec3::new(s * (TAU * c).cos(), s * (TAU * c).sin(), z) * r
        },
        |p| {
            let r = p.length();
            let z = if r > 0.0 { p.z / r } else { 1.0 };
            [[r * r * r, 0.5 - 0.5 * z, turn(p.x, p.y)], [NONE; 3]]
        },
        |p| inside(p.length_squared() <= 1.0, 0.75 / PI),
    )
}

pub(super) fn cosine_hemisphere() -> Hand<2, Direction> {
    hand(
        |[a, b]| {
            let r = a.sqrt();
            let v = Vec3::new(r * (TAU * b).cos(), r * (TAU * b).sin(), (1.0 - a).sqrt());
            Direction::from_unit(v)
        },
        |w| {
            let a = if w.z >= 0.0 { w.x * w.x + w.y * w.y } else { NONE };
            [[a, turn(w.x, w.y)], [NONE; 2]]
        },
        |w| inside(w.z >= 0.0 && finite(w), w.z / PI),
    )
}

pub(super) const CENTRE: [f64; 3] = [100.0, -7.0, 2.0];

/// The surface of the sphere of radius 3 about CENTRE.
pub(super) fn sphere() -> Hand<2, Surface> {
    hand(
        |[a, b]| {
            let (z, s) = (1.0 - 2.0 * a, 2.0 * (a * (1.0 - a)).sqrt());
            let w = [s * (TAU * b).cos(), s * (TAU * b).sin(), z];
            Embedded(core::array::from_fn(|i| CENTRE[i] + 3.0 * w[i]))
        },
        |p| {
            let [x, y, z]: [f64; 3] = core::array::from_fn(|i| (p.0[i] - CENTRE[i]) / 3.0);
            let on = (x * x + y * y + z * z - 1.0).abs() < 1e-13;
            [[if on { (0.5 - 0.5 * z).max(0.0) } else { NONE }, turn(x, y)], [NONE; 2]]
        },
        |p| {
            let d: [f64; 3] = core::array::from_fn(|i| (p.0[i] - CENTRE[i]) / 3.0);
            let on = (d.iter().map(|d| d * d).sum::<f64>() - 1.0).abs() < 1e-13;
            inside(on, 1.0 / (36.0 * PI))
        },
    )
}

/// A rectangle of 2 by 3 at z = 5.
pub(super) fn rectangle() -> Hand<2, SurfacePoint> {
    hand(
        |[a, b]| SurfacePoint::new(Vec3::new(2.0 * a, 3.0 * b, 5.0), SurfaceId(4)),
        |p| [[if p.surface == SurfaceId(4) { p.x / 2.0 } else { NONE }, p.y / 3.0], [NONE; 2]],
        |p| {
            let hit = (0.0..2.0).contains(&p.x) && (0.0..3.0).contains(&p.y);
            inside(hit && finite(p) && p.surface == SurfaceId(4), 1.0 / 6.0)
        },
    )
}

/// Exponential in any precision.
#[derive(Clone, Copy)]
pub(super) struct Exponential {
    pub(super) rate: f32,
}
impl<R: Scalar> Sampler<R> for Exponential {
    type Uniforms = [R; 1];
    type Point = R;
    fn forward(&self, [u]: [R; 1]) -> (R, bool) {
        (-(-u).ln_1p(), true)
    }
    fn pdf(&self, x: &R) -> PdfOf<Self, R> {
        let p = R::of(f64::from(self.rate)) * (-*x).exp();
        Density::new(if *x >= R::ZERO && *x < R::INFINITY { p } else { R::ZERO })
    }
    fn pdf_of_uniforms(&self, u: [R; 1]) -> PdfOf<Self, R> {
        self.pdf(&Sampler::<R>::forward(self, u).0)
    }
    fn preimages(&self, x: &R, mut visit: impl FnMut([R; 1], bool)) {
        let u = -(-*x).exp_m1();
        visit([u.min(R::ONE - R::EPSILON * R::of(0.5))], u >= R::ZERO && *x < R::INFINITY);
    }
}

/// x -> slope x.
#[derive(Clone, Copy)]
pub(super) struct Stretch {
    pub(super) slope: f64,
    pub(super) claimed: f64,
}
impl Map<f64> for Stretch {
    type Source = f64;
    type Target = f64;
    fn forward(&self, x: &f64) -> (f64, bool) {
        (self.slope * x, true)
    }
    fn preimages(&self, y: &f64, mut visit: impl FnMut(f64, bool)) {
        visit(y / self.slope, y.is_finite());
    }
    fn jacobian(&self, _: &f64) -> f64 {
        self.claimed
    }
}
